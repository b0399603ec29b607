"""Why items of the plan did not run, and what makes the whole of a run incomplete."""

from collections.abc import Iterator

import pytest

from gyrotest.plugin.session import GyroSession
from gyrotest.plugin.signals import hold_for_good
from gyrotest.runner.flow import UnitRun

_SELECTING = (
    ("keyword", "-k"),
    ("markexpr", "-m"),
    ("deselect", "--deselect"),
    ("lf", "--lf"),
    ("stepwise", "--sw"),
)


class Omissions:
    """Listens for whatever is left out, interrupted or broken."""

    def __init__(self, session: GyroSession) -> None:
        self._session = session
        self._whole: list[str] = []

    @property
    def whole(self) -> str:
        """What makes all of the run incomplete; empty where nothing does."""
        return "; ".join(dict.fromkeys(self._whole))

    def add(self, reason: str) -> None:
        """Note something else that makes all of the run incomplete."""
        self._whole.append(reason)

    @pytest.hookimpl
    def pytest_deselected(self, items: list[pytest.Item]) -> None:
        """Remember what was left out, and why."""
        selection = self._selection()
        reason = f"deselected ({selection})" if selection else "deselected"
        for item in items:
            self._missing(item.name, reason)

    @pytest.hookimpl
    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Remember why an item was skipped."""
        if report.when == "setup" and report.skipped and isinstance(report.longrepr, tuple):
            reason = str(report.longrepr[2]).removeprefix("Skipped: ")
            self._missing(report.nodeid.rpartition("::")[2], f"skipped ({reason})")

    @pytest.hookimpl
    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """A file that cannot be collected may have held tests that judge values."""
        if report.failed:
            self.add(f"{report.nodeid or 'pytest'} could not be collected")

    @pytest.hookimpl(tryfirst=True)
    def pytest_keyboard_interrupt(self, excinfo: pytest.ExceptionInfo[BaseException]) -> None:
        """The run ends early; let nothing stop what is still to be written."""
        if not self._session.observes_only:
            hold_for_good()
        detail = f" ({excinfo.value})" if str(excinfo.value) else ""
        self.add(f"the run was interrupted{detail}")

    @pytest.hookimpl
    def pytest_internalerror(self, excinfo: pytest.ExceptionInfo[BaseException]) -> None:
        """Pytest itself, or a plugin, broke."""
        self.add(f"pytest ended with an internal error ({excinfo.typename})")

    def explain(self, run: UnitRun, session: pytest.Session | None) -> None:
        """Give a reason for all items of the plan that have none yet."""
        reason = ", ".join(self._stopped(session))
        for planned in run.header.plan:
            if reason:
                run.missing.setdefault(planned.name, f"not run ({reason})")

    def _stopped(self, session: pytest.Session | None) -> Iterator[str]:
        stopped = session is not None and (session.shouldfail or session.shouldstop)
        if stopped:
            yield str(stopped)
        elif self._selection():
            yield f"selected were {self._selection()}"

    def _missing(self, item: str, reason: str) -> None:
        for run in self._session.runs.values():
            run.missing.setdefault(item, reason)

    def _selection(self) -> str:
        option = self._session.config.option
        chosen = ((flag, getattr(option, name, None)) for name, flag in _SELECTING)
        return ", ".join(_shown(flag, value) for flag, value in chosen if value)


def _shown(flag: str, value: object) -> str:
    if value is True:
        return flag
    values = value if isinstance(value, list) else [value]
    return " ".join(f"{flag} {one}" for one in values)
