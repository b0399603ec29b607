"""One acquisition of a simulated synchronous system, from its START to its last block."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.simulation.blocks import BlockFlag, BlockWriter
from gyrotest.simulation.daq_axis import Grid
from gyrotest.simulation.daq_converter import ChannelConverter
from gyrotest.simulation.daq_faults import DaqFaults
from gyrotest.simulation.daq_seat import Seat
from gyrotest.simulation.scenarios import Misbehaviour

# Computed at once: so little that no thread of the program is held up.
_CHUNK_S = 0.25
_MOST_SAMPLES = 65_536
_HASTE = 1e-6
# So many samples before the first one let a low-pass settle; nearer to half the rate it does nothing.
_RUN_IN = 64
_FILTERED_BELOW = 0.45


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """A channel that is transferred: the seat that gives it something (None: nothing is connected)."""

    channel: str
    seat: Seat | None
    converter: ChannelConverter


class _LowPass:
    """The low-pass in front of one channel: a Butterworth filter of second order."""

    def __init__(self, cut_off_hz: float, rate_hz: float) -> None:
        from scipy.signal import butter

        self._sections = butter(2, cut_off_hz, fs=rate_hz, output="sos")
        self._state: NDArray[np.float64] | None = None

    def passed(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """What is left of the next values, (n,)."""
        from scipy.signal import sosfilt, sosfilt_zi

        if self._state is None:
            self._state = sosfilt_zi(self._sections) * values[0]
        passed, self._state = sosfilt(self._sections, values, zi=self._state)
        return np.asarray(passed)


class Acquisition:
    """Samples from `origin_s` on, `samples` of them (0: until it is stopped), as blocks."""

    def __init__(
        self,
        columns: Sequence[Column],
        *,
        origin_s: float,
        interval_s: float,
        samples: int,
        filter_hz: float | None,
        faults: DaqFaults | None,
    ) -> None:
        self._columns = columns
        self._seats = tuple(dict.fromkeys(one.seat for one in columns if one.seat is not None))
        for seat in self._seats:
            seat.prepare()
        step = max((math.ceil(seat.knots_hz * interval_s - _HASTE) for seat in self._seats), default=1)
        self._grid = Grid(origin_s=origin_s, step=max(1, step), knot_s=interval_s / max(1, step))
        self._samples = samples
        self._faults = faults
        self._blocks = BlockWriter(len(columns))
        self._chunk = max(1, min(_MOST_SAMPLES, round(_CHUNK_S / interval_s)))
        self._filters = self._low_passes(filter_hz)
        self._next = 0
        self._lost = False
        before = _RUN_IN if self._filters else 0
        for seat in self._seats:
            seat.begin(self._grid, before=before)
        self._ahead = max((seat.knots_ahead(self._grid) for seat in self._seats), default=1)
        if before:
            self._numbers(-before, before)

    def _low_passes(self, filter_hz: float | None) -> Mapping[str, _LowPass]:
        rate_hz = 1.0 / self._grid.interval_s
        if filter_hz is None or filter_hz >= _FILTERED_BELOW * rate_hz:
            return {}
        return {
            one.channel: _LowPass(filter_hz, rate_hz) for one in self._columns if one.converter.analogue
        }

    @property
    def ended(self) -> bool:
        """Whether the last block has been made."""
        return self._samples > 0 and self._next >= self._samples

    def blocks(self, now_s: float, *, full: bool) -> list[bytes] | None:
        """The blocks of the next samples that are due, lost where the memory is full; None where none are due."""
        count = min(self._chunk, self._due(now_s) - self._next)
        return self._made(count, now_s, full=full) if count > 0 else None

    def last_block(self) -> bytes:
        """An empty one, for an acquisition that is stopped."""
        return self._block(self._next, np.empty((0, len(self._columns)), dtype=np.int32), last=True)

    def _due(self, now_s: float) -> int:
        """How many samples of all have been taken by now."""
        grid = self._grid
        passed_s = now_s - grid.origin_s - self._ahead * grid.knot_s
        due = max(0, math.floor(passed_s / grid.interval_s + _HASTE) + 1)
        return min(due, self._samples) if self._samples else due

    def _made(self, count: int, now_s: float, *, full: bool) -> list[bytes]:
        first = self._next
        numbers = self._numbers(first, count)
        self._next += count
        lost = self._struck(first, count, full=full)
        kept = np.flatnonzero(~lost)
        made = []
        for run in np.split(kept, np.flatnonzero(np.diff(kept) > 1) + 1):
            # What was lost before it shows in its index; its flag says that it is known.
            if run.size:
                self._lost |= bool(run[0] > 0 and lost[run[0] - 1])
                rows = numbers[run[0] : run[-1] + 1]
                last = self.ended and run[-1] == count - 1
                made.append(self._block(first + int(run[0]), rows, last=last, now_s=now_s))
        self._lost |= bool(lost[-1])
        if self.ended and lost[-1]:
            made.append(self._block(self._next, numbers[:0], last=True))
        return made

    def _block(
        self, index: int, rows: NDArray[np.int32], *, last: bool, now_s: float = -math.inf
    ) -> bytes:
        flags = BlockFlag.OVERRUN if self._lost else BlockFlag.NONE
        self._lost = False
        damaged = self._faults is not None and self._faults.due(Misbehaviour.BAD_BLOCK, now_s)
        return self._blocks.write(
            index, rows, flags | BlockFlag.LAST if last else flags, damaged=damaged
        )

    def _struck(self, first: int, count: int, *, full: bool) -> NDArray[np.bool_]:
        """Which samples there is no room for, (n,)."""
        if full:
            return np.ones(count, dtype=np.bool_)
        lost = None if self._faults is None else self._faults.lost(self._grid.samples_s(first, count))
        return np.zeros(count, dtype=np.bool_) if lost is None else lost

    def _numbers(self, first: int, count: int) -> NDArray[np.int32]:
        """What is transferred of the next samples, (n, columns)."""
        last = (first + count - 1) * self._grid.step + self._ahead
        for seat in self._seats:
            seat.extend(last)
        numbers = np.empty((count, len(self._columns)), dtype=np.int32)
        for place, column in enumerate(self._columns):
            source, channel = column.seat, column.channel
            values = np.zeros(count) if source is None else source.take(channel, first, count)
            if column.channel in self._filters:
                values = self._filters[column.channel].passed(values)
            numbers[:, place] = column.converter.numbers(values)
        return numbers
