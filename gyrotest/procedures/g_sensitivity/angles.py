"""The angle of the shaft at each sample of a step, from the encoder's channels."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.ellipse import Ellipse, EllipseFit
from gyrotest.analysis.encoder import Decoder
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.encoder_unit import encoder_unit_deg
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context, Pointing, Rotating, Step
from gyrotest.records.recording import ENCODER_ANGLE, ENCODER_COSINE, ENCODER_SINE, Dwell, Samples
from gyrotest.records.station import Encoder

_Array = NDArray[np.float64]
_TURN_DEG = 360.0
_MOST_JUMP_DEG = 1.0
_MOST_OFF_DEG = 1.0
_MOST_OFF_RATE = 0.002


@dataclass(frozen=True, slots=True, kw_only=True)
class StepColumns:
    """A step of the plan, how it was carried out, and the rows of it that are good.

    `places` (n,) are their positions on the grid, `rows` (n, columns) what was sampled.
    """

    step: Step
    dwell: Dwell
    places: NDArray[np.int64]
    rows: _Array


class Angles:
    """Reads the angle of each step: absolute of an encoder that gives it, else counted from where it began."""

    def __init__(self, samples: Samples, context: Context, steps: Sequence[StepColumns]) -> None:
        self._context = context
        self._sampling = samples.sampling
        self._columns = {name: place for place, name in enumerate(samples.sampling.columns)}
        self._encoder = context.encoder or Encoder()
        self._lines = self._encoder.lines or 0
        self._ellipse = self._fitted(steps) if self.counted else None

    @property
    def counted(self) -> bool:
        """Whether the angle is counted from the begin of each turn: a grating has no zero."""
        return ENCODER_ANGLE not in self._columns and {ENCODER_SINE, ENCODER_COSINE} <= set(
            self._columns
        )

    @property
    def known(self) -> bool:
        """Whether there is an encoder at all."""
        return self.counted or ENCODER_ANGLE in self._columns

    def of(self, one: StepColumns) -> _Array:
        """Return the angle (n,) of a step, ° and without jumps; raises `InsufficientDataError`."""
        stimulus = one.step.stimulus
        if isinstance(stimulus, Rotating):
            return self._turning(one, stimulus)
        return self._standing(one, stimulus.position_deg if isinstance(stimulus, Pointing) else 0.0)

    def skew_s(self) -> float:
        """Return how much later than the output the angle is sampled."""
        name = ENCODER_SINE if self.counted else ENCODER_ANGLE
        offsets = self._sampling.offsets_s
        return offsets[self._columns[name]] - offsets[0] if offsets and name in self._columns else 0.0

    # A turn

    def _turning(self, one: StepColumns, rotating: Rotating) -> _Array:
        if not self.known:
            raise InsufficientDataError(
                f"{self._context.case_name}: no encoder is recorded beside the output; give the slot an 'encoder'"
                " with the channel of its angle, or stand at 'positions' instead of turning"
            )
        angle = (
            self._absolute(one) if self._ellipse is None else self._counted(one, rotating, self._ellipse)
        )
        _refuse_wrong_rate(one, rotating, _rate_dps(one, angle, self._sampling.interval_s))
        return angle - self.skew_s() * rotating.rate_dps

    def _absolute(self, one: StepColumns) -> _Array:
        angle = np.unwrap(self._read(one), period=_TURN_DEG)
        jumps = np.abs(np.diff(angle))
        steps = np.diff(one.places)
        rotating = one.step.stimulus
        rate_dps = abs(rotating.rate_dps) if isinstance(rotating, Rotating) else 0.0
        even_deg = 1.5 * rate_dps * self._sampling.interval_s * steps
        worst = float((jumps - even_deg).max(initial=0.0))
        if worst > _MOST_JUMP_DEG:
            raise InsufficientDataError(
                f"step '{one.step.name}': the encoder's angle jumps by up to {plain(float(jumps.max()), 3)}° from"
                f" sample to sample, where {plain(rate_dps * self._sampling.interval_s, 3)}° are turned: it is"
                " starved of samples, loses counts, or has no signal; look at its cables, let it update faster, or"
                " turn slower"
            )
        whole: _Array = angle - _TURN_DEG * np.floor(np.median(angle) / _TURN_DEG)
        return whole

    def _counted(self, one: StepColumns, rotating: Rotating, ellipse: Ellipse) -> _Array:
        """Count the lines from where the run-up ends, which is not known better than when it did."""
        decoder = Decoder(
            ellipse,
            lines=self._lines,
            rate_hz=1.0 / self._sampling.interval_s,
            reversed_=self._encoder.reversed,
        )
        if np.any(np.diff(one.places) > 1):
            raise InsufficientDataError(
                f"step '{one.step.name}': samples are missing, and the lines of a grating cannot be counted over a"
                " gap"
            )
        try:
            angle = decoder.push(*self._signals(one))
            decoder.check()
        except InsufficientDataError as error:
            raise InsufficientDataError(f"step '{one.step.name}': {error}") from None
        begin = rotating.run_up_deg if rotating.rate_dps > 0.0 else _TURN_DEG - rotating.run_up_deg
        counted: _Array = angle - angle[0] + begin
        return counted

    def _fitted(self, steps: Sequence[StepColumns]) -> Ellipse:
        if not self._lines:
            raise InsufficientDataError(
                f"{self._context.case_name}: the slot's encoder does not say how many 'lines' a turn has"
            )
        fit = EllipseFit()
        for one in steps:
            if isinstance(one.step.stimulus, Rotating):
                fit.push(*self._signals(one))
        return fit.fit()

    def _signals(self, one: StepColumns) -> _Array:
        """Return the sine and the cosine signal (2, n)."""
        return one.rows[:, [self._columns[ENCODER_SINE], self._columns[ENCODER_COSINE]]].T

    # At rest

    def _standing(self, one: StepColumns, position_deg: float) -> _Array:
        """Return the mean angle: of the encoder, else as the stage reads it back, else as it was asked for."""
        count = one.rows.shape[0]
        if ENCODER_ANGLE not in self._columns:
            read_back = one.dwell.measured_position_deg
            return np.full(count, position_deg if read_back is None else read_back)
        read = self._read(one)
        away = (read - position_deg + _TURN_DEG / 2.0) % _TURN_DEG - _TURN_DEG / 2.0
        off = float(np.median(away))
        if abs(off) > _MOST_OFF_DEG:
            raise InsufficientDataError(
                f"step '{one.step.name}': the encoder reads {plain(position_deg + off, 6)}° where the stage stands"
                f" at {plain(position_deg, 6)}°: their zeros, or their directions, are not the same; correct the"
                " encoder's zero, or 'encoder.reversed' in the station"
            )
        return np.full(count, position_deg + float(away.mean()))

    def _read(self, one: StepColumns) -> _Array:
        sign = -1.0 if self._encoder.reversed else 1.0
        factor = sign * encoder_unit_deg(self._sampling, self._context)
        return factor * one.rows[:, self._columns[ENCODER_ANGLE]]


def _rate_dps(one: StepColumns, angle: _Array, interval_s: float) -> float:
    lasts_s = float(one.places[-1] - one.places[0]) * interval_s
    return float(angle[-1] - angle[0]) / lasts_s if lasts_s > 0.0 else 0.0


def _refuse_wrong_rate(one: StepColumns, rotating: Rotating, rate_dps: float) -> None:
    allowed_dps = rotating.tolerance_dps + _MOST_OFF_RATE * abs(rotating.rate_dps)
    if abs(rate_dps - rotating.rate_dps) <= allowed_dps:
        return
    raise InsufficientDataError(
        f"step '{one.step.name}': the encoder turned at {plain(rate_dps, 4)} °/s, the stage was asked for"
        f" {plain(rotating.rate_dps, 4)} °/s (to within {plain(allowed_dps, 2)} °/s): look at the encoder's"
        " channel, 'encoder.lines' and 'encoder.reversed'".replace("-", "\N{MINUS SIGN}")
    )
