"""Any board that prints lines, on the simulated bench: the unit under test itself, on a serial line."""

import string
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import StationError
from gyrotest.records.station import Station
from gyrotest.simulation.emitter import Emitter
from gyrotest.simulation.figures import Figure, fault, figures_of
from gyrotest.simulation.housed import Housed
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.outlet import Outlet
from gyrotest.simulation.peer import Making
from gyrotest.simulation.sampled import Sampled
from gyrotest.units import Dimension

_FIGURES = {"sample_rate": Figure(Dimension.FREQUENCY, "100 Hz", positive=True)}
_MODULUS = 65_536
_LONGEST = 1000
_NUMBER = 123_456.789
# What a line may hold beside the axes, by their names (`output` for a gyro of one axis).
_BESIDE = ("counter", "time_s", "temperature", "status")
_END = "\r\n"
# Bits of the status, which is a number.
START_UP, OVERLOAD = 0x40, 0x10


class LinePeer:
    """A board that prints a line for each sample, by `format`: `{counter},{x:.5f},{temperature:.2f}`."""

    def __init__(self, making: Making) -> None:
        given = _given(making.station, making.name)
        figures = figures_of(given, _FIGURES, _key(making.name), also=("format",))
        if figures.faults:
            raise StationError(figures.faults)
        voice = _LineVoice(_key(making.name), given.get("format"), figures.values["sample_rate"])
        self._emitter = Emitter(making, voice)

    @staticmethod
    def check(station: Station, name: str) -> None:
        """Raise `StationError` with all complaints about this board's figures."""
        given = _given(station, name)
        faults = figures_of(given, _FIGURES, _key(name), also=("format",)).faults
        if "format" in given:
            try:
                list(string.Formatter().parse(str(given["format"])))
            except ValueError as error:
                faults.append(fault(f"{_key(name)}.format", f"'{given['format']}': {error}"))
        if faults:
            raise StationError(faults)

    def begin(self, occasion: Occasion) -> None:
        """Nothing: what a unit is, its slot tells."""

    def truth(self) -> Mapping[str, float]:
        """Nothing beside the unit's own figures."""
        return {}

    def house(self, housed: Housed) -> None:
        """Be this unit from now on, for its next record."""
        self._emitter.house(housed)

    def transmit(self, now_s: float, outlet: Outlet) -> None:
        """Send all that is due by now."""
        self._emitter.transmit(now_s, outlet)


class _LineVoice:
    """Samples as lines of text."""

    def __init__(self, key: str, form: object, rate_hz: float) -> None:
        self._key = key
        self._asked_form = form
        self._form = ""
        self._names: list[str] = []
        self.rate_hz = rate_hz
        self.period = _MODULUS
        self.largest = _LONGEST

    def house(self, housed: Housed) -> None:
        """Be this unit from now on; raises `StationError` for a format that does not fit."""
        self._names = [element.axis.name or "output" for element in housed.elements]
        columns = (f"{{{name}:.5f}}" for name in self._names)
        default = ",".join(["{counter}", *columns, "{temperature:.2f}"])
        self._form = f"{self._asked_form or default}{_END}"
        sample = dict.fromkeys((*self._names, *_BESIDE), _NUMBER) | {"counter": _MODULUS, "status": 255}
        try:
            self.largest = len(self._form.format(**sample)) + len(sample)
        except (KeyError, ValueError, IndexError) as error:
            known = ", ".join((*self._names, *_BESIDE))
            message = f"'{self._asked_form}' cannot be filled in ({error}); it may hold {known}"
            raise StationError([fault(f"{self._key}.format", message)]) from error

    def frames(self, sampled: Sampled, status: NDArray[np.uint8]) -> list[bytes]:
        """The samples, a line each."""
        columns = {name: row.tolist() for name, row in zip(self._names, sampled.outputs, strict=True)}
        columns |= {
            "counter": (sampled.number % _MODULUS).tolist(),
            "time_s": sampled.time_s.tolist(),
            "temperature": sampled.temperature_degc.tolist(),
            "status": _status(sampled, status).tolist(),
        }
        form = self._form.format
        lines = zip(*columns.values(), strict=True)
        return [form(**dict(zip(columns, line, strict=True))).encode("latin-1") for line in lines]

    def hello(self) -> bytes:
        """Nothing."""
        return b""

    def answer(self, asked: bytes) -> bytes:  # noqa: ARG002 - it does not listen
        """Nothing."""
        return b""


def _status(sampled: Sampled, status: NDArray[np.uint8]) -> NDArray[np.uint8]:
    status[sampled.starting] |= np.uint8(START_UP)
    status[sampled.over.any(axis=0)] |= np.uint8(OVERLOAD)
    return status


def _given(station: Station, name: str) -> dict[str, Any]:
    """What the station says of the board; how often it sends, its driver knows too."""
    simulated = station.simulation.instruments.get(name, {}) if station.simulation else {}
    settings = station.instruments[name].settings
    known = {key: settings[key] for key in _FIGURES if key in settings}
    return {**known, **simulated}


def _key(name: str) -> str:
    return f"simulation.instruments.{name}"
