"""The frames of simulated STIM210 and STIM300 gyros: every documented kind, put together many at once."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from gyrotest.simulation.checksum import STIM210_CHECKSUM, STIM300_CHECKSUM, Checksum, FrameChecksum

_AXES = 3
# One count of an acceleration, g; of an inclination, g.
_ACCELERATION_G = 2.0**-19
_INCLINATION_G = 2.0**-22
_TEMPERATURE_C = 2.0**-8
_LARGEST_24 = 2**23 - 1
# Specific force of a unit that stands upright, g, by axis.
_UPRIGHT_G = (0.0, 0.0, 1.0)
LINE_END = b"\r\n"


class Part(StrEnum):
    """What stands in a frame behind the rates and their status."""

    RESERVE = "reserve"
    ACCELERATION = "acceleration"
    INCLINATION = "inclination"
    TEMPERATURE = "temperature"
    TEMPERATURE_STATUS = "temperature with status"
    AUXILIARY = "auxiliary"
    PPS = "pps"
    COUNTER = "counter"
    LATENCY = "latency"


_NAMES = {Part.TEMPERATURE_STATUS: "temperature"}


@dataclass(frozen=True, slots=True, kw_only=True)
class StimModel:
    """A model: its checksum and its kinds of frames, by identifier, in the order on the wire."""

    name: str
    checksum: Checksum
    kinds: Mapping[int, tuple[Part, ...]]
    named_trailer: bool

    def names(self) -> dict[str, int]:
        """The identifiers by what the frames hold: `rate_temperature`."""
        trailer = () if self.named_trailer else (Part.COUNTER, Part.LATENCY)
        names = {Part.RESERVE: "extended", Part.TEMPERATURE_STATUS: "temperature"}
        return {
            "_".join(
                ["rate", *(names.get(one, one.value) for one in parts if one not in trailer)]
            ): number
            for number, parts in self.kinds.items()
        }


def _stim210() -> dict[int, tuple[Part, ...]]:
    temperature, counter, latency = Part.TEMPERATURE, Part.COUNTER, Part.LATENCY
    return {
        0x90: (),
        0x92: (Part.RESERVE,),
        0xA0: (temperature,),
        0xA2: (counter,),
        0xA4: (latency,),
        0xA5: (counter, latency),
        0x99: (temperature, counter),
        0xA6: (temperature, latency),
        0xA8: (temperature, counter, latency),
    }


def _stim300() -> dict[int, tuple[Part, ...]]:
    """By the bits of the option: 1 acceleration, 2 inclination, 4 temperature, 8 auxiliary, 16 PPS."""
    identifiers = {
        0: 0x90, 1: 0x91, 2: 0x92, 3: 0x93, 4: 0x94, 5: 0xA5, 6: 0xA6, 7: 0xA7,
        8: 0x98, 9: 0x99, 10: 0x9A, 11: 0x9B, 12: 0x9C, 13: 0xAD, 14: 0xAE, 15: 0xAF,
    }  # fmt: skip
    identifiers |= {16 + option: 0xF0 + option for option in range(8)}
    parts = (
        Part.ACCELERATION,
        Part.INCLINATION,
        Part.TEMPERATURE_STATUS,
        Part.AUXILIARY,
        Part.PPS,
    )
    return {
        identifier: (
            *(part for bit, part in enumerate(parts) if option >> bit & 1),
            Part.COUNTER,
            Part.LATENCY,
        )
        for option, identifier in identifiers.items()
    }


STIM210 = StimModel(name="STIM210", checksum=STIM210_CHECKSUM, kinds=_stim210(), named_trailer=True)
STIM300 = StimModel(name="STIM300", checksum=STIM300_CHECKSUM, kinds=_stim300(), named_trailer=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Content:
    """What frames say: counts of the rates, (axes, n), and for each frame status, temperature, counter."""

    counts: NDArray[np.float64]
    status: NDArray[np.uint8]
    temperature_degc: NDArray[np.float64]
    counter: NDArray[np.int64]


class FramePacker:
    """Packs one kind of frame of a model."""

    def __init__(self, model: StimModel, identifier: int, *, crlf: bool, latency_us: int) -> None:
        self._identifier = identifier
        self._parts = model.kinds[identifier]
        self._crlf = crlf
        self._latency_us = latency_us
        clusters = 1 + sum(one in {Part.ACCELERATION, Part.INCLINATION} for one in self._parts)
        self._clusters = clusters
        sizes = {
            Part.RESERVE: 3, Part.ACCELERATION: 10, Part.INCLINATION: 10, Part.TEMPERATURE: 6,
            Part.TEMPERATURE_STATUS: 7 * clusters, Part.AUXILIARY: 4, Part.PPS: 4, Part.COUNTER: 1,
            Part.LATENCY: 2,
        }  # fmt: skip
        self._places: dict[Part, int] = {}
        end = 1 + 3 * _AXES + 1
        for part in self._parts:
            self._places[part] = end
            end += sizes[part]
        self._length = end
        self._checksum = FrameChecksum(model.checksum, end)
        self.size = end + model.checksum.size + (len(LINE_END) if crlf else 0)

    def pack(self, content: Content) -> NDArray[np.uint8]:
        """The frames, (n, size)."""
        n = content.status.size
        columns = np.zeros((self.size, n), dtype=np.uint8)
        columns[0] = self._identifier
        columns[1 : 1 + 3 * _AXES] = _int24(content.counts)
        columns[3 * _AXES + 1] = content.status
        for part, place in self._places.items():
            self._fill(columns[place:], part, content)
        length = self._length
        columns[length : length + self._checksum.size] = self._checksum.of(columns[:length])
        if self._crlf:
            columns[-2:] = np.frombuffer(LINE_END, dtype=np.uint8)[:, None]
        return np.ascontiguousarray(columns.T)

    def _fill(self, columns: NDArray[np.uint8], part: Part, content: Content) -> None:
        if part is Part.COUNTER:
            columns[0] = content.counter & 0xFF
        elif part is Part.LATENCY:
            columns[0], columns[1] = divmod(self._latency_us, 256)
        elif part in {Part.ACCELERATION, Part.INCLINATION}:
            scale = _ACCELERATION_G if part is Part.ACCELERATION else _INCLINATION_G
            columns[:9] = _int24(np.array(_UPRIGHT_G)[:, None] / scale)
            columns[9] = content.status & 0xE0
        elif part in {Part.TEMPERATURE, Part.TEMPERATURE_STATUS}:
            self._fill_temperatures(columns, part, content)

    def _fill_temperatures(self, columns: NDArray[np.uint8], part: Part, content: Content) -> None:
        high, low = np.divmod(np.round(content.temperature_degc / _TEMPERATURE_C), 256)
        size = 7 if part is Part.TEMPERATURE_STATUS else 6
        for cluster in range(self._clusters):
            for axis in range(_AXES):
                place = cluster * size + 2 * axis
                columns[place], columns[place + 1] = high.astype(np.int8).view(np.uint8), low
            if part is Part.TEMPERATURE_STATUS:
                columns[cluster * size + 6] = content.status & 0xE0


def _int24(values: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Numbers, (rows, n), as three bytes each, most significant first; (3·rows, n)."""
    whole = np.clip(np.round(values), -_LARGEST_24 - 1, _LARGEST_24).astype(">i4")
    rows, n = whole.shape
    return whole.view(np.uint8).reshape(rows, n, 4)[:, :, 1:].transpose(0, 2, 1).reshape(3 * rows, n)
