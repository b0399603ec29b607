"""STIM210 and STIM300 on the simulated bench: the unit under test itself, on a serial line."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import Fault, StationError
from gyrotest.records.spec import OutputKind, OutputMode
from gyrotest.records.station import Station
from gyrotest.simulation.emitter import Emitter
from gyrotest.simulation.figures import Figure, fault, figures_of, given_figures, nearest
from gyrotest.simulation.housed import Housed
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.outlet import Outlet
from gyrotest.simulation.peer import Making
from gyrotest.simulation.sampled import Sampled
from gyrotest.simulation.scenarios import Misbehaviour
from gyrotest.simulation.stim_datagrams import (
    FILTERS_HZ,
    RATES_HZ,
    Setup,
    Subject,
    datagram,
    digits,
)
from gyrotest.simulation.stim_frames import STIM210, STIM300, Content, FramePacker, StimModel
from gyrotest.units import Dimension

_TICKS_HZ = 2000.0
_COUNTER = 256
_RATE_COUNTS = 2.0**14
_ANGLE_COUNTS = 2.0**21
_AXES = ("x", "y", "z")
_START_UP, _OVERLOAD = 0x40, 0x10
_FIGURES = {
    "sample_rate": Figure(Dimension.FREQUENCY, "125 Hz", positive=True),
    "latency": Figure(Dimension.TIME, "0.506 ms"),
}
_OTHERS = ("frame", "mode", "crlf", "baud_rate")
# What a driver's settings say that is not how the unit is set.
_OF_DRIVER = ("range", "ask")
_WIRE_S = 65_535e-6


class StimPeer:
    """A unit set as the station's driver expects it, unless `simulation.instruments` says otherwise."""

    kinds = frozenset({OutputKind.RATE})

    def __init__(self, making: Making) -> None:
        model, setup, latency_us = _described(making.station, making.name)
        if making.scenario.has(Misbehaviour.OTHER_CONFIGURATION):
            setup = replace(setup, mode=_other(setup.mode))
        other = making.scenario.has(Misbehaviour.OTHER_DEVICE)
        self._emitter = Emitter(making, _StimVoice(model, setup, latency_us, other_device=other))

    @staticmethod
    def check(station: Station, name: str) -> None:
        """Raise `StationError` with all complaints about this unit's figures."""
        _described(station, name)

    def begin(self, occasion: Occasion) -> None:
        """Nothing: what a unit is, its slot tells."""

    def truth(self) -> Mapping[str, float]:
        """Nothing beside the unit's own figures."""
        return {}

    def house(self, housed: Housed) -> None:
        """Be this unit from now on, for its next record."""
        self._emitter.house(housed)

    def transmit(self, now_s: float, outlet: Outlet) -> None:
        """Answer what was asked, and send all that is due by now."""
        self._emitter.transmit(now_s, outlet)


class _StimVoice:
    """Samples as frames."""

    def __init__(self, model: StimModel, setup: Setup, latency_us: int, *, other_device: bool) -> None:
        self._model = model
        self._setup = setup
        self._other_device = other_device
        self._packer = FramePacker(model, setup.identifier, crlf=setup.crlf, latency_us=latency_us)
        self._step = round(_TICKS_HZ / setup.rate_hz)
        self._serial_number = ""
        self._rows: list[int] = []
        self.rate_hz = setup.rate_hz
        self.period = _COUNTER // self._step
        self.largest = self._packer.size
        self.sending = True

    def house(self, housed: Housed) -> None:
        """Be this unit from now on."""
        number = int(digits(housed.occasion.serial_number)) + self._other_device
        self._serial_number = str(number)
        self._setup = replace(self._setup, bandwidth_hz=housed.gyro.noise.bandwidth_hz)
        names = [element.axis.name for element in housed.elements]
        self._rows = [
            _AXES.index(name) if name in _AXES else place for place, name in enumerate(names[:3])
        ]

    def frames(self, sampled: Sampled, status: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """The samples as rows of bytes."""
        scale = _RATE_COUNTS
        if self._setup.mode is OutputMode.INCREMENTAL_ANGLE:
            scale = _ANGLE_COUNTS / self._setup.rate_hz
        counts = np.zeros((len(_AXES), sampled.number.size))
        counts[self._rows] = sampled.outputs[: len(self._rows)] * scale
        return self._packer.pack(
            Content(
                counts=counts,
                status=self._status(sampled, status),
                temperature_degc=sampled.temperature_degc,
                counter=(sampled.number + 1) * self._step,
            )
        )

    def _status(self, sampled: Sampled, status: NDArray[np.uint8]) -> NDArray[np.uint8]:
        if sampled.starting[0]:
            status[sampled.starting] |= np.uint8(_START_UP)
        if sampled.over.any():
            for row, over in zip(self._rows, sampled.over, strict=False):
                status[over] |= np.uint8(_OVERLOAD | 1 << row)
        return status

    def hello(self) -> bytes:
        """All datagrams, once after power-on."""
        return b"".join(self._datagram(subject) for subject in Subject)

    def answer(self, asked: bytes) -> bytes:
        """The datagrams for letters, each followed by a carriage return."""
        said = b""
        for word in asked.split(b"\r")[:-1]:
            said += b"".join(
                self._datagram(subject) for subject in Subject if subject.value[2] == word.strip()
            )
        return said

    def _datagram(self, subject: Subject) -> bytes:
        return datagram(subject, self._model, self._setup, self._serial_number)


def _other(mode: OutputMode) -> OutputMode:
    angle = OutputMode.INCREMENTAL_ANGLE
    return OutputMode.RATE if mode is angle else angle


def _described(station: Station, name: str) -> tuple[StimModel, Setup, int]:
    """Model, set-up and latency of a unit; raises `StationError` with all complaints at once."""
    instrument = station.instruments[name]
    simulated = given_figures(station, name)
    key = f"simulation.instruments.{name}"
    given: dict[str, Any] = {**instrument.settings, **simulated}
    model = STIM300 if "300" in f"{given.pop('model', instrument.driver)}" else STIM210
    figures = figures_of(given, _FIGURES, key, also=(*_OTHERS, *_OF_DRIVER))
    faults = figures.faults
    identifier = _identifier(model, given.get("frame", 0x90), f"{key}.frame", faults)
    mode = _mode(given.get("mode", "rate"), f"{key}.mode", faults)
    rate_hz = figures.values.get("sample_rate", 0.0)
    if rate_hz not in RATES_HZ and "sample_rate" in figures.values:
        known = ", ".join(f"{one:g} Hz" for one in RATES_HZ)
        faults.append(fault(f"{key}.sample_rate", f"'{rate_hz:g} Hz' is none of {known}"))
    latency_s = figures.values.get("latency", 0.0)
    if latency_s > _WIRE_S:
        faults.append(fault(f"{key}.latency", "must be at most 65 ms"))
    if faults:
        raise StationError(faults)
    setup = Setup(
        identifier=identifier,
        rate_hz=rate_hz,
        mode=mode,
        crlf=given.get("crlf") is True,
        bandwidth_hz=FILTERS_HZ[-1],
        baud_rate=int(given.get("baud_rate", 460_800)),
    )
    return model, setup, round(latency_s * 1e6)


def _identifier(model: StimModel, given: object, key: str, faults: list[Fault]) -> int:
    names = model.names()
    text = str(given).strip().lower()
    numbers = {f"0x{one:02x}": one for one in model.kinds} | {str(one): one for one in model.kinds}
    found = names.get(text, numbers.get(text))
    if found is None:
        faults.append(
            fault(key, f"'{given}' is no frame of a {model.name}{nearest(text, tuple(names))}")
        )
        return 0x90
    return found


def _mode(given: object, key: str, faults: list[Fault]) -> OutputMode:
    try:
        return OutputMode(str(given))
    except ValueError:
        faults.append(fault(key, f"'{given}' is none of {', '.join(one.value for one in OutputMode)}"))
        return OutputMode.RATE
