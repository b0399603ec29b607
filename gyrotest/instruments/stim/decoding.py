"""Frames of a serial gyro to numbers, many at once."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.instruments.stim.crc import ColumnCheck
from gyrotest.instruments.stim.models import (
    LINE_END,
    TEMPERATURE_PER_COUNT_K,
    Frame,
    Model,
    rate_per_count_dps,
)
from gyrotest.records.recording import SampleFlag
from gyrotest.records.spec import OutputMode

# Frames that are worked on at once: their columns stay in the processor's cache.
_CHUNK = 8192

# TS1524 table 5-23; the three low bits name the axes. To be outside the operating conditions is no
# fault of the sample: a test may well take a unit there.
OUTSIDE_CONDITIONS = 0x20
_MEANINGS = {
    0x80: SampleFlag.FAULT,  # system integrity
    0x40: SampleFlag.START_UP,
    0x10: SampleFlag.OVERLOAD,
    0x08: SampleFlag.FAULT,  # error in a channel
}


def _flags_by_status() -> NDArray[np.uint8]:
    """What each status byte means."""
    status = np.arange(256)
    flags = np.zeros(256, dtype=np.uint8)
    for bit, flag in _MEANINGS.items():
        flags[(status & bit) > 0] |= np.uint8(flag)
    flags.setflags(write=False)
    return flags


_FLAGS = _flags_by_status()


@dataclass(frozen=True, slots=True, kw_only=True)
class Decoded:
    """Frames in numbers.

    `values` (n, 3) rates in deg/s, or (n, 6) with the three temperatures in °C behind them; `flags` (n,)
    `SampleFlag` as uint8; `counter` (n,) 0 … 255 and `latency_us` (n,), None where the kind has none;
    `whole` (n,) whether identifier, checksum and line end are right: the numbers of the others mean nothing.
    """

    values: NDArray[np.float64]
    flags: NDArray[np.uint8]
    counter: NDArray[np.uint8] | None
    latency_us: NDArray[np.uint16] | None
    whole: NDArray[np.bool_]


class FrameDecoder:
    """Decodes one kind of frame of one model, set to one output mode and sample rate."""

    def __init__(
        self,
        model: Model,
        frame: Frame,
        *,
        mode: OutputMode = OutputMode.RATE,
        period_s: float = 1.0,
        crlf: bool = False,
    ) -> None:
        self.frame = frame
        self.size = model.wire_size(frame, crlf=crlf)
        self.columns = 3 if frame.temperatures is None else 6
        self._scale_dps = rate_per_count_dps(mode, period_s)
        self._check = ColumnCheck(model.crc, frame.size)
        self._end = LINE_END if crlf else b""

    def decode(self, frames: NDArray[np.uint8] | bytes, *, known_whole: bool = False) -> Decoded:
        """Decode consecutive frames; raises `ValueError` where they are not whole frames.

        Frames that were checked already, `known_whole`, are not checked again.
        """
        rows = np.frombuffer(frames, dtype=np.uint8) if isinstance(frames, bytes) else frames
        rows = rows.reshape(-1, self.size)
        n, frame = len(rows), self.frame
        found = Decoded(
            values=np.empty((n, self.columns)),
            flags=np.empty(n, dtype=np.uint8),
            counter=None if frame.counter is None else rows[:, frame.counter].copy(),
            latency_us=None if frame.latency is None else np.empty(n, dtype=np.uint16),
            whole=np.ones(n, dtype=np.bool_),
        )
        for begin in range(0, n, _CHUNK):
            part = slice(begin, begin + _CHUNK)
            columns = np.ascontiguousarray(rows[part].T)
            self._decode_part(columns, found, part)
            if not known_whole:
                found.whole[part] = self._whole(columns)
        return found

    def whole(self, rows: NDArray[np.uint8]) -> NDArray[np.bool_]:
        """Which of the frames, (n, size), have the right identifier, checksum and line end."""
        return self._whole(np.ascontiguousarray(rows.T))

    def _decode_part(self, columns: NDArray[np.uint8], found: Decoded, part: slice) -> None:
        frame = self.frame
        for axis in range(3):
            found.values[part, axis] = _int24(columns, frame.rates + 3 * axis) * self._scale_dps
        if frame.temperatures is not None:
            for axis in range(3):
                degrees = _int16(columns, frame.temperatures + 2 * axis) * TEMPERATURE_PER_COUNT_K
                found.values[part, 3 + axis] = degrees
        if found.latency_us is not None and frame.latency is not None:
            found.latency_us[part] = _int16(columns, frame.latency).astype(np.uint16)
        found.flags[part] = _FLAGS[columns[frame.statuses[0]]]
        for status in frame.statuses[1:]:
            found.flags[part] |= _FLAGS[columns[status]]

    def _whole(self, columns: NDArray[np.uint8]) -> NDArray[np.bool_]:
        whole = (columns[0] == self.frame.identifier) & self._check.passes(columns)
        for place, byte in enumerate(self._end, start=self.size - len(self._end)):
            whole &= columns[place] == byte
        return np.asarray(whole)


def _int24(columns: NDArray[np.uint8], begin: int) -> NDArray[np.int32]:
    """Three bytes as a signed number: put on top of 32 bits, then shifted down with their sign."""
    high, middle, low = (columns[begin + k].astype(np.int32) for k in range(3))
    return np.asarray((high << 24 | middle << 16 | low << 8) >> 8)


def _int16(columns: NDArray[np.uint8], begin: int) -> NDArray[np.int16]:
    high, low = columns[begin].astype(np.int16), columns[begin + 1]
    return np.asarray(high << 8 | low)
