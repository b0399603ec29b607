"""A vibration recording looked through once: what makes it unfit, and the encoder's ellipse."""

from dataclasses import dataclass

import numpy as np

from gyrotest.analysis.ellipse import Ellipse, EllipseFit
from gyrotest.analysis.skew import Aligner
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.dwell_checks import FEWEST_PRESENT, full_scale_words
from gyrotest.procedures.scaling import Scaling
from gyrotest.procedures.vibration_tally import DwellTally, Stretch, stretches
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.recording import ENCODER_COSINE, ENCODER_SINE, Dwell, SampleFlag, SampleStream
from gyrotest.records.spec import Gaps
from gyrotest.units import printed_unit


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
    signals = _Signals(stream) if ENCODER_SINE in stream.sampling.columns else None
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
        self._columns = [columns.index(ENCODER_SINE), columns.index(ENCODER_COSINE)]
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
            f" {full_scale_words(context)}; lower the level, or widen the channel's range"
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
                f" ({full_scale_words(context)}); lower the level, or widen the range"
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
