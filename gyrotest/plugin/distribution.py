"""pytest-xdist: the controller owns the runs, the workers do their items, a real bench has one worker."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import pytest

from gyrotest.plugin.session import GyroSession

if TYPE_CHECKING:
    from xdist.workermanage import WorkerController

_KEY = "gyro_runs"


def runs_of_worker(config: pytest.Config) -> tuple[Path, ...] | None:
    """The folders that the controller made, in a worker; None elsewhere."""
    handed: dict[str, Any] | None = getattr(config, "workerinput", None)
    if handed is None or _KEY not in handed:
        return None
    return tuple(Path(one) for one in json.loads(handed[_KEY]))


def install_distribution(config: pytest.Config, session: GyroSession) -> None:
    """Take part in xdist where it is installed and active."""
    if session.is_worker or not config.pluginmanager.hasplugin("xdist"):
        return
    if not getattr(config.option, "tx", None) and not getattr(config.option, "numprocesses", None):
        return
    session.close_bench()  # the worker that opens it owns it
    config.pluginmanager.register(Distribution(session))


class Distribution:
    """The controller's part."""

    def __init__(self, session: GyroSession) -> None:
        self._session = session

    @pytest.hookimpl(optionalhook=True)
    def pytest_configure_node(self, node: "WorkerController") -> None:
        """Hand the runs' folders to a worker."""
        folders = [str(run.folder.path) for run in self._session.runs.values()]
        node.workerinput[_KEY] = json.dumps(folders)

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_make_scheduler(self, config: pytest.Config, log: Any) -> Any:
        """Keep a unit's items together; on a real bench, all items in one worker."""
        from xdist.scheduler import LoadScopeScheduling

        simulated = self._session.order.station.station.simulation is not None
        serial_numbers = self._session.order.serial_numbers

        class ByUnit(LoadScopeScheduling):  # type: ignore[misc]
            """Scopes by unit on a simulated bench, by the bench on a real one."""

            def remove_node(self, node: "WorkerController") -> str | None:
                """Give what a lost worker has not begun to others; not again what it was lost at."""
                for unit in self.assigned_work[node].values():
                    lost: str | None = next((one for one, done in unit.items() if not done), None)
                    if lost is not None:
                        unit[lost] = True
                        super().remove_node(node)
                        return lost
                return cast("str | None", super().remove_node(node))

            def _split_scope(self, nodeid: str) -> str:
                if not simulated:
                    return "bench"
                name = nodeid.rpartition("::")[2]
                return next((one for one in serial_numbers if f"-{one}-" in name), nodeid)

        return ByUnit(config, log)
