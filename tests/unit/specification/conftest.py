"""Documents to read, and a procedure and a driver that stand in for the installed ones."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import pytest

from gyrotest.errors import GyrotestError, SpecError, StationError
from gyrotest.records.result import Measurand
from gyrotest.records.spec import Case, Output, Over, SpecDocument
from gyrotest.records.station import StationDocument
from gyrotest.specification.spec import load_spec
from gyrotest.specification.station import load_station
from gyrotest.units import Dimension, OfDimension, Quantity

TEN_VOLTS = Quantity(10.0, "V")
ONE_SECOND = Quantity(1.0, "s")
Time = Annotated[Quantity, OfDimension(Dimension.TIME)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters:
    """What the stand-in procedure is told."""

    smoothing: tuple[Time, ...] = (ONE_SECOND,)


class Stand:
    """A procedure that measures a bias, and its spread over repeats."""

    parameters = Parameters

    def measurands(self, case: Case, parameters: Parameters, output: Output) -> tuple[Measurand, ...]:
        names = ["bias", "allan_minimum", "bias_instability_coefficient"]
        names += [f"bias_stability_{one.to('s'):g}s" for one in parameters.smoothing]
        rate, unit = Dimension.RATE, "deg/h"
        found = [Measurand(name=name, label=name, dimension=rate, unit=unit) for name in names]
        if case.repeats > 1:
            name = f"bias_{'run_to_run' if case.between_repeats == 'nothing' else 'repeatability'}"
            found.append(Measurand(name=name, label=name, dimension=rate, unit=unit, over=Over.REPEATS))
        return tuple(found)

    def complaints(
        self, case: Case, parameters: Parameters, output: Output
    ) -> Iterable[tuple[str, str]]:
        for place, one in enumerate(parameters.smoothing):
            if one.to("s") % case.interval.to("s"):
                yield f"parameters.smoothing[{place}]", f"'{one}' is no whole number of intervals"


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """What the stand-in driver is told."""

    range: Annotated[Quantity, OfDimension(Dimension.VOLTAGE)] = TEN_VOLTS
    nplc: float = 10.0

    def __post_init__(self) -> None:
        if self.nplc > 100:
            raise ValueError("nplc is at most 100")


class Meter:
    """A driver that is never opened."""

    settings = Settings


class Player:
    """A driver whose resource is a file."""

    settings = Settings
    resource_is_path = True


def catalogue(**known: Any) -> Callable[[str], Any]:
    def find(name: str) -> Any:
        if name not in known:
            raise GyrotestError(f"'{name}' is not installed ({', '.join(known)})")
        return known[name]

    return find


@pytest.fixture
def spec(tmp_path: Path) -> Callable[[str], SpecDocument]:
    """Load a spec from its text."""

    def read(text: str) -> SpecDocument:
        path = tmp_path / "spec.yaml"
        path.write_text(text, encoding="utf-8")
        return load_spec(path, catalogue(static=Stand()))

    return read


@pytest.fixture
def station(tmp_path: Path) -> Callable[[str], StationDocument]:
    """Load a station from its text."""

    def read(text: str) -> StationDocument:
        path = tmp_path / "station.yaml"
        path.write_text(text, encoding="utf-8")
        return load_station(path, catalogue(meter=Meter, player=Player))

    return read


def _faults_of(read: Callable[[str], Any], error: type[Any], text: str) -> list[str]:
    with pytest.raises(error) as refused:
        read(text)
    return [f"{fault.line}: {fault.key}: {fault.message}" for fault in refused.value.faults]


@pytest.fixture
def spec_faults(spec: Callable[[str], Any]) -> Callable[[str], list[str]]:
    """Return the faults of a spec's text as `line: key: message`."""
    return lambda text: _faults_of(spec, SpecError, text)


@pytest.fixture
def station_faults(station: Callable[[str], Any]) -> Callable[[str], list[str]]:
    """Return the faults of a station's text as `line: key: message`."""
    return lambda text: _faults_of(station, StationError, text)
