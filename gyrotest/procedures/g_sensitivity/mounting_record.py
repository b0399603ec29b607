"""One mounting: its samples checked and averaged over arcs, and the model that is fitted to them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from gyrotest.analysis.g_sensitivity import ShaftFit, fit_shaft
from gyrotest.analysis.shaft_samples import (
    SECTOR_DEG,
    ShaftRecord,
    ShaftSamples,
    averaged,
    missing_sectors,
    near_the_model,
    while_even,
)
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.case_plan import since_power_on_s
from gyrotest.procedures.dwell_checks import Cut, refuse_unfit
from gyrotest.procedures.dwells import MOST_DROPPED, sample_places
from gyrotest.procedures.g_sensitivity.angles import Angles, StepColumns
from gyrotest.procedures.g_sensitivity.bench import Mounted, mounted
from gyrotest.procedures.g_sensitivity.known_scale import KnownScale, known_scale
from gyrotest.procedures.g_sensitivity.lifeless import refuse_lifeless, refuse_without_earth
from gyrotest.procedures.g_sensitivity.parameters import GSensitivityParameters, steps_of
from gyrotest.procedures.scaling import Scaling, output_scaling
from gyrotest.records.plan import Context, Rotating
from gyrotest.records.recording import Samples, Sampling

_SPANS = 180
_BLUR_SIGMAS = 6.0


@dataclass(frozen=True, slots=True, kw_only=True)
class MountingRecord:
    """What one mounting gave: the averages over arcs, and the fit, in °/s by the scale factor that is known.

    `dropped` are outliers, `left_out` samples of run-up and reversal, `missing` those lost on the way, of
    `planned`. `counted` tells that the angle is counted from the begin of each turn.
    """

    mounted: Mounted
    scaling: Scaling
    scale: KnownScale
    sampling: Sampling
    record: ShaftRecord
    found: ShaftFit
    steps: tuple[ShaftSamples, ...]
    span_s: float
    counted: bool
    dropped: int
    left_out: int
    missing: int
    planned: int


def mounting_record(samples: Samples, context: Context) -> MountingRecord:
    """Check an acquisition and fit the model to it; raises `InsufficientDataError`."""
    parameters: GSensitivityParameters = context.parameters
    unit = mounted(context, context.placement or parameters.placement(context.repeat))
    _refuse_unsynchronous(samples.sampling, parameters, context)
    scaling = output_scaling(context.output, samples.sampling.unit)
    scale = known_scale(scaling, parameters.scale_factor_from, context)
    refuse_lifeless(samples, context)
    columns = tuple(_columns(samples, context))
    angles = Angles(samples, context, columns)
    steps = tuple(_step(one, angles, scaling, scale, samples.sampling.interval_s) for one in columns)
    even = tuple(while_even(one) for one in steps)
    if parameters.turning:
        _refuse_short_of_a_turn(even, context)
    kept = _without_outliers(even, parameters, context)
    span_s = _span_s(kept, parameters)
    record = averaged(kept, span_s=span_s)
    found = fit_shaft(
        record.values,
        record.arcs,
        unit.model,
        since_s=since_power_on_s(context) + float(record.arcs.spans.begins_s[0]),
    )
    refuse_without_earth(found, samples, context)
    return MountingRecord(
        mounted=unit,
        scaling=scaling,
        scale=scale,
        sampling=samples.sampling,
        record=record,
        found=found,
        steps=kept,
        span_s=span_s,
        counted=angles.counted and parameters.turning,
        dropped=_size(even) - _size(kept),
        left_out=_size(steps) - _size(even),
        missing=sum(one.dwell.samples for one in columns) - _size(steps),
        planned=sum(one.dwell.samples for one in columns),
    )


def _size(steps: Sequence[ShaftSamples]) -> int:
    return sum(one.output.size for one in steps)


def _refuse_unsynchronous(
    sampling: Sampling, parameters: GSensitivityParameters, context: Context
) -> None:
    if parameters.turning and not sampling.synchronous:
        raise InsufficientDataError(
            f"{context.case_name}: the source does not take output and angle by one clock; what turns needs a"
            " synchronous source: read the unit by one, or stand at 'positions'"
        )


def _columns(samples: Samples, context: Context) -> Iterator[StepColumns]:
    """Give each step's samples; raises `InsufficientDataError` where some of them are bad or clipped."""
    steps = steps_of(context.case, context.parameters)
    if len(context.dwells) != len(steps):
        raise InsufficientDataError(
            f"{context.case_name}: {len(context.dwells)} of {len(steps)} steps were carried out; all of them are"
            " needed"
        )
    places = sample_places(samples, context)
    blur = _BLUR_SIGMAS * (samples.sampling.noise or 0.0)
    for step, dwell in zip(steps, context.dwells, strict=True):
        start, stop = np.searchsorted(places, (dwell.first, dwell.first + dwell.samples))
        cut = Cut(
            dwell=dwell,
            sampling=samples.sampling,
            values=samples.values[start:stop, 0],
            flags=samples.flags[start:stop],
            places=places[start:stop],
        )
        refuse_unfit(cut, context, blur, may_saturate=False)
        rows = samples.values[start:stop]
        if not np.isfinite(rows).all():
            raise InsufficientDataError(
                f"step '{step.name}': the encoder's angle is no number in"
                f" {int((~np.isfinite(rows)).any(axis=1).sum())} of {rows.shape[0]} samples"
            )
        yield StepColumns(step=step, dwell=dwell, places=places[start:stop], rows=rows)


def _step(
    one: StepColumns, angles: Angles, scaling: Scaling, scale: KnownScale, interval_s: float
) -> ShaftSamples:
    stimulus = one.step.stimulus
    return ShaftSamples(
        name=one.step.name,
        output=scaling.rates_dps(one.rows[:, 0]) / scale.of_nominal,
        angle_deg=angles.of(one),
        time_s=np.asarray(
            one.dwell.began_s + (one.places - one.dwell.first + 0.5) * interval_s, dtype=np.float64
        ),
        interval_s=interval_s,
        forward=stimulus.rate_dps > 0.0 if isinstance(stimulus, Rotating) else None,
    )


def _refuse_short_of_a_turn(steps: Sequence[ShaftSamples], context: Context) -> None:
    for forward, way in ((True, "forward"), (False, "back")):
        lacking = list(missing_sectors(steps, forward=forward))
        if lacking:
            angles = ", ".join(f"{begin:g}° … {end:g}°" for begin, end in lacking)
            raise InsufficientDataError(
                f"{context.case_name}: turning {way}, there are too few samples at {angles}: the range of angles"
                f" is short of a turn; each {SECTOR_DEG:g}° of it must be there, both ways"
            )


def _without_outliers(
    steps: Sequence[ShaftSamples], parameters: GSensitivityParameters, context: Context
) -> tuple[ShaftSamples, ...]:
    chosen = near_the_model(steps, mads=parameters.outlier_mads)
    total = _size(steps)
    dropped = total - sum(int(one.sum()) for one in chosen)
    if dropped > max(MOST_DROPPED * total, 1.0):
        raise InsufficientDataError(
            f"{context.case_name}: {dropped} of {total} samples are not within {parameters.outlier_mads:g} median"
            f" absolute deviations of the model (at most {MOST_DROPPED:.0%} may be dropped); look for what"
            " disturbs the bench, or correct 'parameters.outlier_mads'"
        )
    return tuple(one.only(kept) for one, kept in zip(steps, chosen, strict=True))


def _span_s(steps: Sequence[ShaftSamples], parameters: GSensitivityParameters) -> float:
    """Return over how long samples are averaged: some hundred spans, in none of which much of a turn passes."""
    whole_s = sum(one.output.size * one.interval_s for one in steps)
    span_s = max(whole_s / _SPANS, 2.0 * steps[0].interval_s)
    return min(span_s, SECTOR_DEG / parameters.rate_dps) if parameters.turning else span_s
