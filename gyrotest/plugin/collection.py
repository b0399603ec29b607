"""The spec as a test module: one item for each acquisition, one for what is over the repeats."""

import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from gyrotest.plugin.session import GYRO, PLANNED, GyroSession
from gyrotest.runner.flow import Acquired
from gyrotest.runner.items import planned_items


class LimitsNotMet(Exception):  # noqa: N818 — it is a verdict on the gyro, no error of the bench
    """A gyro is out of its limits; one line for each."""


def judge_acquisition(gyro_acquired: Acquired, gyro_judgement: Any) -> None:
    """Judge what the fixture has acquired."""
    gyro_judgement(gyro_acquired)


def judge_repeats(gyro_judgement: Any) -> None:
    """Judge what is computed over the repeats."""
    gyro_judgement(None)


class GyroItem(pytest.Function):
    """An item of the spec: its acquisition in setup, its judgement in the call."""

    def reportinfo(self) -> tuple[Path, int, str]:
        """Say where the item comes from: the spec; pytest wants a line of whatever is skipped."""
        return self.path, 0, self.name


class SpecModule(pytest.Module):
    """The spec file in pytest's tree; a Module, since plugins ask items for `request.module`."""

    def _getobj(self) -> types.ModuleType:
        module = types.ModuleType(self.path.stem, "A gyro spec.")
        module.__file__ = str(self.path)
        return module

    def collect(self) -> Iterator[GyroItem]:
        """Yield the plan's items, unit by unit."""
        session = self.config.stash[GYRO]
        for serial_number in session.order.serial_numbers:
            for planned in planned_items(session.order.spec.spec, serial_number):
                judgement = judge_repeats if planned.repeat is None else judge_acquisition
                item = GyroItem.from_parent(self, name=planned.name, callobj=judgement)
                item.stash[PLANNED] = planned
                item.stash[SERIAL_NUMBER] = serial_number
                yield item


SERIAL_NUMBER = pytest.StashKey[str]()


class Collection:
    """Makes pytest collect the spec, in the plan's order."""

    def __init__(self, session: GyroSession) -> None:
        self._path = Path(session.order.spec.path)
        config = session.config
        if config.args_source is not pytest.Config.ArgsSource.ARGS:
            config.args[:] = [str(self._path)]
            return
        given = [self._resolved(config, one) for one in config.args]
        pointed = any(one.partition("::")[0] == str(self._path) for one in given)
        config.args[:] = given if pointed else [*given, str(self._path)]

    def _resolved(self, config: pytest.Config, argument: str) -> str:
        """Write the spec's path in one way, so that it is collected once.

        An argument may name it through a link, or, outside the root directory, by its bare node id.
        """
        name, colons, item = argument.partition("::")
        path = config.invocation_params.dir / name
        is_node_id = name == self._path.name and not path.exists()
        return f"{self._path}{colons}{item}" if is_node_id or path.resolve() == self._path else argument

    @pytest.hookimpl
    def pytest_collect_file(self, file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
        """Collect the spec that was asked for, and no other YAML file."""
        if file_path != self._path:
            return None
        if file_path.is_relative_to(parent.config.rootpath):
            return SpecModule.from_parent(parent, path=file_path)
        return SpecModule.from_parent(parent, path=file_path, nodeid=file_path.name)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> Iterator[None]:
        """Restore the plan's order among the spec's items after whatever shuffled them."""
        order = {item.nodeid: place for place, item in enumerate(items) if PLANNED in item.stash}
        yield
        places = [place for place, item in enumerate(items) if item.nodeid in order]
        ours = sorted((items[place] for place in places), key=lambda item: order[item.nodeid])
        for place, item in zip(places, ours, strict=True):
            items[place] = item
