"""A vibration recording looked through once: what makes it unfit, and the encoder's ellipse."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.continuity import stretches_by_index
from gyrotest.analysis.ellipse import Ellipse, EllipseFit
from gyrotest.analysis.skew import Aligner
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.scaling import Scaling
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.recording import Dwell, SampleFlag, Samples, SampleStream
from gyrotest.records.spec import Gaps
from gyrotest.units import printed_unit

FEWEST_PRESENT = 0.5
"""Share of a dwell's samples that are needed, where some may be missing."""

_CLIPPED_LEAST, _CLIPPED_MORE, _CLIPPED_RUN = 5, 6, 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Stretch:
    """Consecutive samples of a dwell, the `number`th of the recording: values (n, columns) and flags (n,).

    `first` is the position of the first one; `begins` says that it does not go on from the stretch before.
    """

    number: int
    first: int
    begins: bool
    values: NDArray[np.float64]
    flags: NDArray[np.uint8]


def stretches(stream: SampleStream, dwells: tuple[Dwell, ...]) -> Iterator[Stretch]:
    """Give the dwells' samples in their order, block by block, cut where samples are missing."""
    expected, last = -1, -1
    for samples in stream.blocks():
        places = _places(samples)
        for number, dwell in enumerate(dwells):
            start, stop = np.searchsorted(places, (dwell.first, dwell.first + dwell.samples))
            if start == stop:
                continue
            for one in stretches_by_index(places[start:stop]):
                cut = slice(start + one.start, start + one.stop)
                first = int(places[cut.start])
                yield Stretch(
                    number=number,
                    first=first,
                    begins=first != expected or number != last,
                    values=samples.values[cut],
                    flags=samples.flags[cut],
                )
                expected, last = first + one.size, number


def _places(samples: Samples) -> NDArray[np.int64]:
    if samples.index is None:
        raise InsufficientDataError("a block of samples has no positions; read it as a stream")
    return samples.index


@dataclass
class _Extreme:
    """The greatest level so far, how often it was there and in how many runs, and how often the next one was."""

    level: float = -np.inf
    count: int = 0
    runs: int = 0
    next_level: float = -np.inf
    next_count: int = 0

    def push(self, values: NDArray[np.float64]) -> None:
        """Look at further values."""
        level = float(values.max())
        if level < self.next_level:
            return
        there = values == level
        runs = int(there[0]) + int(np.count_nonzero(there[1:] & ~there[:-1]))
        self._put(level, int(np.count_nonzero(there)), runs)
        below = values[~there]
        if below.size:
            beside = float(below.max())
            self._put(beside, int(np.count_nonzero(below == beside)), 0)

    def _put(self, level: float, count: int, runs: int) -> None:
        if level > self.level:
            self.next_level, self.next_count = self.level, self.count
            self.level, self.count, self.runs = level, count, runs
        elif level == self.level:
            self.count += count
            self.runs += runs
        elif level > self.next_level:
            self.next_level, self.next_count = level, count
        elif level == self.next_level:
            self.next_count += count

    @property
    def clipped(self) -> bool:
        """Whether the signal rests here, far more often than next to it: no sine and no noise does that."""
        rests = self.count >= _CLIPPED_LEAST and self.count >= _CLIPPED_RUN * self.runs
        return rests and self.count > _CLIPPED_MORE * self.next_count


@dataclass
class DwellTally:
    """What was found in a dwell; extremes are those of the output as it is indicated."""

    dwell: Dwell
    present: int = 0
    stretches: int = 0
    flagged: dict[SampleFlag, int] = field(default_factory=dict)
    first_flagged: int | None = None
    unreadable: int = 0
    greatest: _Extreme = field(default_factory=_Extreme)
    least: _Extreme = field(default_factory=_Extreme)

    @property
    def missing(self) -> int:
        """How many of its samples are not there."""
        return self.dwell.samples - self.present

    @property
    def moves(self) -> bool:
        """Whether the table was driven."""
        return bool(self.dwell.vibration_dps)

    def push(self, stretch: Stretch) -> None:
        """Count further samples."""
        self.present += stretch.flags.size
        self.stretches += stretch.begins
        if stretch.flags.any():
            self._count_flags(stretch)
        output = stretch.values[:, 0]
        self.unreadable += int(np.count_nonzero(~np.isfinite(stretch.values)))
        self.greatest.push(output)
        self.least.push(-output)

    def _count_flags(self, stretch: Stretch) -> None:
        if self.first_flagged is None:
            self.first_flagged = stretch.first + int(np.flatnonzero(stretch.flags)[0])
        for flag in SampleFlag:
            count = int(np.count_nonzero(stretch.flags & np.uint8(flag))) if flag else 0
            if count:
                self.flagged[flag] = self.flagged.get(flag, 0) + count


@dataclass(frozen=True, slots=True, kw_only=True)
class Inspection:
    """Every dwell's tally, and the encoder's ellipse (None where it gives the angle itself)."""

    tallies: tuple[DwellTally, ...]
    ellipse: Ellipse | None


def inspected(stream: SampleStream, context: Context, scaling: Scaling) -> Inspection:
    """Look through a recording; raises `InsufficientDataError` naming the dwell and what is wrong with it.

    The ellipse is that of all dwells in which the table moves: one at rest, or that moves by less than a
    line, is decoded by what the others show.
    """
    tallies = tuple(DwellTally(dwell=one) for one in context.dwells)
    signals = _Signals(stream) if "encoder_sine" in stream.sampling.columns else None
    for stretch in stretches(stream, context.dwells):
        tally = tallies[stretch.number]
        tally.push(stretch)
        if signals is not None and tally.moves:
            signals.push(stretch)
    for tally in tallies:
        _refuse_unfit(tally, context, scaling)
    return Inspection(tallies=tallies, ellipse=None if signals is None else signals.ellipse())


class _Signals:
    """The encoder's two signals at one instant each, and their ellipse."""

    def __init__(self, stream: SampleStream) -> None:
        columns, offsets = stream.sampling.columns, stream.sampling.offsets_s
        self._columns = [columns.index("encoder_sine"), columns.index("encoder_cosine")]
        skews = [offsets[one] for one in self._columns] if offsets else [0.0, 0.0]
        self._aligner = Aligner(skews, stream.sampling.interval_s)
        self._fit = EllipseFit()

    def push(self, stretch: Stretch) -> None:
        """Take further samples."""
        if stretch.begins:
            self._aligner.reset()
            self._fit.begin_stretch()
        both = self._aligner.push(stretch.values[:, self._columns])
        self._fit.push(both[:, 0], both[:, 1])

    def ellipse(self) -> Ellipse:
        """Return the ellipse of all."""
        return self._fit.fit()


def step_words(dwell: Dwell) -> str:
    """Name a dwell and how it moves, for messages."""
    name = f"step '{dwell.name}'" if dwell.name else "step"
    if not dwell.vibration_dps:
        return name
    at = f" and {plain(dwell.frequency_hz, 6)} Hz" if dwell.frequency_hz else ""
    return f"{name} at {plain(dwell.vibration_dps, 4)} °/s rms{at}"


def _refuse_unfit(tally: DwellTally, context: Context, scaling: Scaling) -> None:
    name = step_words(tally.dwell)
    if tally.missing and context.case.gaps is Gaps.REFUSE:
        raise InsufficientDataError(
            f"{name}: {tally.missing} of {tally.dwell.samples} samples are missing; find out where they"
            " are lost, or let the case use what is without gaps: 'gaps: longest_stretch'"
        )
    if tally.present < max(FEWEST_PRESENT * tally.dwell.samples, 2):
        raise InsufficientDataError(
            f"{name}: {tally.present} of {tally.dwell.samples} samples are there; at least half of them are needed"
        )
    if tally.flagged:
        found = ", ".join(
            f"{count} {_FLAG_WORDS.get(flag, str(flag.name).lower())}"
            for flag, count in tally.flagged.items()
        )
        raise InsufficientDataError(
            f"{name}: of {tally.present} samples {found}, the first of them sample {tally.first_flagged};"
            f" {_full_scale(context)}; lower the level, or widen the channel's range"
        )
    if tally.unreadable:
        raise InsufficientDataError(
            f"{name}: {tally.unreadable} values of output or encoder, in {tally.present} samples, are no"
            " numbers; look at the channels, or at the columns of the file"
        )
    _refuse_saturated(tally, context, scaling, name)


_FLAG_WORDS = {
    SampleFlag.OVERLOAD: "are overloads (a channel is clipped)",
    SampleFlag.NOT_A_NUMBER: "are no numbers",
    SampleFlag.START_UP: "are of the start-up",
    SampleFlag.FAULT: "are flagged as faults",
}


def _refuse_saturated(tally: DwellTally, context: Context, scaling: Scaling, name: str) -> None:
    ends = {1.0: tally.greatest, -1.0: tally.least}
    unit = printed_unit(scaling.unit)
    if tally.greatest.level == -tally.least.level:
        raise InsufficientDataError(
            f"{name}: the output is {plain(tally.greatest.level, 5)} in every sample: the unit is stuck, or not"
            " connected"
        )
    for sign, one in ends.items():
        if tally.moves and one.clipped:
            raise InsufficientDataError(
                f"{name}: {one.count} of {tally.present} samples of the output read"
                f" {plain(sign * one.level, 5)} {unit}, its {'greatest' if sign > 0.0 else 'least'}: it is clipped"
                f" ({_full_scale(context)}); lower the level, or widen the range"
            )
    _refuse_beyond(tally, context, scaling, name)


def _refuse_beyond(tally: DwellTally, context: Context, scaling: Scaling, name: str) -> None:
    full_scale = context.output.full_scale
    if full_scale is None:
        return
    ends = scaling.rates_dps(np.array([tally.greatest.level, -tally.least.level]))
    reached_dps = float(np.abs(ends).max())
    if reached_dps > full_scale.to("deg/s"):
        raise InsufficientDataError(
            f"{name}: the output reaches {plain(reached_dps, 4)} °/s, beyond the full scale of {full_scale}, where"
            " it need not follow; lower the level"
        )


def _full_scale(context: Context) -> str:
    full_scale = context.output.full_scale
    return (
        "full scale is not stated in the spec" if full_scale is None else f"full scale is {full_scale}"
    )
