"""The dwells of a recording: the samples of each, checked, outliers counted, and their mean."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.noise_terms import Grid
from gyrotest.analysis.outliers import median_deviation
from gyrotest.analysis.step_noise import LikeSteps, StepNoise, step_noise
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.dwell_checks import Cut, refuse_unfit, step_words
from gyrotest.procedures.outlier_rule import OutlierRule
from gyrotest.procedures.rails import rail_of
from gyrotest.procedures.scaling import Scaling, output_scaling
from gyrotest.records.plan import Context
from gyrotest.records.recording import Dwell, Samples, Sampling

MOST_DROPPED = 0.01
"""Share of a dwell's samples beyond which outliers are no outliers any more; a single one always is."""

_MAD_OF_NORMAL = 0.6745
_BLUR_SIGMAS, _LEAST_BLUR, _MOST_BLUR = 6.0, 0.1, 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class DwellRecord:
    """A dwell's kept samples (n,), as the output less the nominal one at rest, in `scaling.unit`.

    `dropped` are outliers, `missing` samples that were lost on the way. Only where the dwell may saturate
    there are `overloaded` ones, which do not count, and `railed` ones at a limit of the output, which do;
    then nothing is dropped. `middle_s` is the mean time of the kept samples
    since the recording's begin.
    """

    dwell: Dwell
    output: NDArray[np.float64]
    scaling: Scaling
    sampling: Sampling
    middle_s: float
    dropped: int = 0
    missing: int = 0
    overloaded: int = 0
    railed: int = 0

    @property
    def name(self) -> str:
        """The step's name, and the rate that was asked for."""
        return step_words(self.dwell)

    @property
    def rate_dps(self) -> float:
        """The rate that was asked for, °/s; 0 where none was."""
        return self.dwell.rate_dps or 0.0

    @property
    def kept(self) -> int:
        """Number of samples that count."""
        return int(self.output.size)

    @property
    def duration_s(self) -> float:
        """Time for which samples that count stand."""
        return self.kept * self.sampling.interval_s

    @property
    def begin_s(self) -> float:
        """When such a time would begin, its middle where it is, since the recording's begin."""
        return self.middle_s - self.duration_s / 2.0

    @property
    def mean(self) -> float:
        """Mean of the kept samples, in `scaling.unit`."""
        return float(self.output.mean())

    @property
    def mean_rate_dps(self) -> float:
        """The mean as a rate by the nominal scale factor, the bias in it."""
        return self.mean / self.scaling.scale_factor

    @property
    def saturated(self) -> bool:
        """Whether some samples are no measure of the rate."""
        return self.overloaded + self.railed > 0


def dwell_records(
    samples: Samples, context: Context, *, rule: OutlierRule | None = None, may_saturate: bool = False
) -> tuple[DwellRecord, ...]:
    """Return every dwell of a recording in the order of the plan; `rule` None: median ± 7.5 MAD.

    Raises `InsufficientDataError` naming the dwell: samples flagged bad, more than 1 % of them outliers,
    fewer than half of them there; overloaded or at a limit of the output, unless it may saturate.
    """
    if not context.dwells:
        raise InsufficientDataError(f"{context.case_name}: the recording has no dwells")
    places = sample_places(samples, context)
    scaling = output_scaling(context.output, samples.sampling.unit)
    cuts = [_cut(samples, places, dwell) for dwell in context.dwells]
    blur = _blur(cuts)
    for cut in cuts:
        refuse_unfit(cut, context, blur, may_saturate=may_saturate)
    readings = [cut.only(~cut.overloaded) for cut in cuts]
    deviations = [median_deviation(one.values) for one in readings if one.values.size]
    usual_dps = scaling.spread_dps(float(np.median(deviations))) if deviations else 0.0
    return tuple(
        _record(cut, one, scaling, _Choice(rule=rule or OutlierRule(), usual_dps=usual_dps, blur=blur))
        for cut, one in zip(cuts, readings, strict=True)
    )


def noise_of(
    records: tuple[DwellRecord, ...], *, alike: tuple[DwellRecord, ...] | None = None
) -> StepNoise:
    """Return the noise that dwells have in common, in `scaling.unit`; raises `InsufficientDataError`.

    How far dwells that are `alike` (None: those at rest) lie apart tells of the slow noise.
    """
    sampling = records[0].sampling
    grid = Grid(interval_s=sampling.interval_s, aperture_s=sampling.effective_aperture_s)
    rest = tuple(one for one in records if one.rate_dps == 0.0) if alike is None else alike
    like = LikeSteps(
        means=np.array([one.mean for one in rest]),
        begins_s=np.array([one.begin_s for one in rest]),
        durations_s=np.array([one.duration_s for one in rest]),
    )
    return step_noise([one.output for one in records], grid, like=like)


def sample_places(samples: Samples, context: Context) -> NDArray[np.int64]:
    """Return each sample's position on the acquisition's grid."""
    if samples.index is not None:
        return samples.index
    places = np.arange(samples.values.shape[0], dtype=np.int64)
    for gap in sorted(context.gaps, key=lambda one: one.after):
        places[places > gap.after] += gap.missing
    return places


def _cut(samples: Samples, places: NDArray[np.int64], dwell: Dwell) -> Cut:
    start, stop = np.searchsorted(places, (dwell.first, dwell.first + dwell.samples))
    return Cut(
        dwell=dwell,
        sampling=samples.sampling,
        values=samples.values[start:stop, 0],
        flags=samples.flags[start:stop],
        places=places[start:stop],
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Choice:
    """What decides which samples count: the rule, the dwells' usual deviation, how wide a limit looks."""

    rule: OutlierRule
    usual_dps: float
    blur: float


def _blur(cuts: list[Cut]) -> float:
    """Return how wide the noise of what reads the output makes a limit of it, in the indication's unit.

    No more than half the noise at rest, where the output is certainly none; at least a tenth of it.
    """
    rest = [one.only(~one.overloaded).values for one in cuts if one.dwell.rate_dps == 0.0]
    deviations = [median_deviation(one) for one in rest if one.size]
    if not deviations:
        return 0.0
    usual = min(deviations) / _MAD_OF_NORMAL
    own = _BLUR_SIGMAS * (cuts[0].sampling.noise or 0.0)
    return min(max(own, _LEAST_BLUR * usual), _MOST_BLUR * usual)


def _record(cut: Cut, readings: Cut, scaling: Scaling, choice: _Choice) -> DwellRecord:
    """Take the outliers out; an overload's value is no reading and does not count."""
    railed = rail_of(readings.values, blur=choice.blur)
    chosen = readings
    if not railed.any() and readings.values.size:
        chosen = readings.only(_kept(readings, scaling, choice))
    return DwellRecord(
        dwell=cut.dwell,
        output=scaling.outputs(chosen.values),
        scaling=scaling,
        sampling=cut.sampling,
        middle_s=_middle_s(chosen),
        dropped=int(readings.values.size - chosen.values.size),
        missing=cut.dwell.samples - int(cut.values.size),
        overloaded=int(cut.values.size - readings.values.size),
        railed=int(railed.sum()),
    )


def _kept(readings: Cut, scaling: Scaling, choice: _Choice) -> NDArray[np.bool_]:
    rate_dps, demanded_dps = scaling.rates_dps(readings.values), readings.dwell.rate_dps
    kept = choice.rule.kept(rate_dps, demanded_dps, usual_dps=choice.usual_dps)
    dropped = int(rate_dps.size - kept.sum())
    if dropped > max(MOST_DROPPED * rate_dps.size, 1.0):
        raise InsufficientDataError(
            f"{step_words(readings.dwell)}: {dropped} of {rate_dps.size} samples are not"
            f" {choice.rule.spoken(demanded_dps)} (at most {MOST_DROPPED:.0%} may be dropped after settling):"
            " settle longer, or correct the rule"
        )
    return kept


def _middle_s(cut: Cut) -> float:
    interval_s = cut.sampling.interval_s
    places = cut.places if cut.places.size else np.array([cut.dwell.first + cut.dwell.samples // 2])
    return cut.dwell.began_s + (float((places - cut.dwell.first).mean()) + 0.5) * interval_s
