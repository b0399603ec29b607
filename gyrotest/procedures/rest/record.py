"""The record at rest that a test reduces: checked, gap-free, in °/s."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.continuity import Stretch, stretches_by_index, stretches_by_time
from gyrotest.analysis.noise import SHORTEST_RECORD
from gyrotest.analysis.resolution import digital_step
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.recorded_temperature import sensor_column
from gyrotest.procedures.rest.soundness import refuse_bad, refuse_lifeless, rounding_complaint
from gyrotest.procedures.scaling import Scaling, output_scaling
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.recording import Samples, Sampling
from gyrotest.records.spec import Gaps
from gyrotest.units import Quantity

Window = tuple[Quantity, Quantity]
"""A part of a record, [begin, end), from its first sample on."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RestRecord:
    """A stretch of evenly spaced rates that begins `begin_s` after the recording's first sample.

    `floor_dps` is the meter's own noise of a sample and `step_dps` what it is digitised in, where known;
    `rounding` says why the steps hide the gyro's noise, where they do. `temperature_degc` was recorded
    beside (None: was not; single readings may be missing).
    """

    rate_dps: NDArray[np.float64]
    begin_s: float
    sampling: Sampling
    scaling: Scaling
    floor_dps: float | None
    step_dps: float | None
    rounding: str
    temperature_degc: NDArray[np.float64] | None
    missing: int
    condition: str
    remarks: tuple[str, ...]

    @property
    def interval_s(self) -> float:
        """Time between two samples."""
        return self.sampling.interval_s

    @property
    def duration_s(self) -> float:
        """Time that the record covers."""
        return self.rate_dps.size * self.interval_s

    def since(self, start_s: float) -> NDArray[np.float64]:
        """Return the rates from a time after the recording's first sample on."""
        first = max(round((start_s - self.begin_s) / self.interval_s), 0)
        return self.rate_dps[first:]


def rest_record(samples: Samples, context: Context, *, window: Window | None = None) -> RestRecord:
    """Check the samples and turn them into rates; raises `InsufficientDataError`.

    `window` is the part of the record that is used, begin and end; None: all of it.
    """
    sampling = samples.sampling
    part = _part(samples, window)
    stretches = tuple(_clipped(_stretches(samples, context), part))
    used = _used(stretches, samples, context)
    values = samples.values[used.start : used.stop, 0]
    refuse_bad(values, samples.flags[used.start : used.stop], used.start)
    if used.size < SHORTEST_RECORD:
        raise InsufficientDataError(
            f"{context.case_name}: {used.size} samples are left; an Allan deviation needs {SHORTEST_RECORD}"
        )
    step = digital_step(values)
    refuse_lifeless(values, sampling, used.start)
    scaling = output_scaling(context.output, sampling.unit)
    sensor = sensor_column(sampling, context.axis)
    whole = len(stretches) == 1
    note = "" if whole else f"longest gap-free stretch, {used.size} of {part.size} samples"
    return RestRecord(
        rate_dps=scaling.rates_dps(values),
        begin_s=_begin_s(samples, used.start),
        sampling=sampling,
        scaling=scaling,
        floor_dps=None if sampling.noise is None else scaling.spread_dps(sampling.noise),
        step_dps=None if step is None else scaling.spread_dps(step),
        rounding=rounding_complaint(values, step, sampling.unit),
        temperature_degc=None if sensor is None else samples.values[used.start : used.stop, sensor],
        missing=_missing(samples, context),
        condition=note,
        remarks=()
        if whole
        else (
            f"The record has gaps; used: samples {_position(samples, context, used.start)} …"
            f" {_position(samples, context, used.stop - 1)}.",
        ),
    )


def _part(samples: Samples, window: Window | None) -> Stretch:
    count, interval_s = samples.values.shape[0], samples.sampling.interval_s
    if window is None:
        return Stretch(start=0, stop=count)
    begin, end = (round(one.to("s") / interval_s) for one in window)
    place = _places(samples)
    length = count if place is None else int(place[-1]) + 1
    if end > length:
        raise InsufficientDataError(
            f"the window [{window[0]}, {window[1]}) ends beyond the record of"
            f" {plain(length * interval_s, 6)} s"
        )
    if place is None:
        return Stretch(start=begin, stop=end)
    start, stop = (int(one) for one in np.searchsorted(place, (begin, end)))
    return Stretch(start=start, stop=stop)


def _places(samples: Samples) -> NDArray[np.int64] | None:
    """Return the samples' places on the grid of intervals, the first one's 0; None where none is missing."""
    if samples.time_s is not None:
        steps = (samples.time_s - samples.time_s[0]) / samples.sampling.interval_s
        rounded: NDArray[np.int64] = np.rint(steps).astype(np.int64)
        return rounded
    if samples.index is None:
        return None
    places: NDArray[np.int64] = samples.index - samples.index[0]
    return places


def _stretches(samples: Samples, context: Context) -> tuple[Stretch, ...]:
    if samples.time_s is not None:
        return stretches_by_time(samples.time_s, interval_s=samples.sampling.interval_s)
    if samples.index is not None:
        return stretches_by_index(samples.index)
    if context.gaps:
        return stretches_by_index(_index_from_gaps(samples.values.shape[0], context))
    return (Stretch(start=0, stop=samples.values.shape[0]),)


def _index_from_gaps(count: int, context: Context) -> NDArray[np.int64]:
    index = np.arange(count, dtype=np.int64)
    for gap in sorted(context.gaps, key=lambda one: one.after):
        index[index > gap.after] += gap.missing
    return index


def _clipped(stretches: tuple[Stretch, ...], window: Stretch) -> Iterator[Stretch]:
    for one in stretches:
        start, stop = max(one.start, window.start), min(one.stop, window.stop)
        if start < stop:
            yield Stretch(start=start, stop=stop)


def _position(samples: Samples, context: Context, row: int) -> int:
    """Return a row's position on the acquisition's grid, by which gaps are told everywhere."""
    places = _places(samples)
    if places is None:
        return int(_index_from_gaps(samples.values.shape[0], context)[row])
    first = 0 if samples.index is None else int(samples.index[0])
    return first + int(places[row])


def _used(stretches: tuple[Stretch, ...], samples: Samples, context: Context) -> Stretch:
    if not stretches:
        raise InsufficientDataError(f"{context.case_name}: the record has no samples")
    if len(stretches) > 1 and context.case.gaps is Gaps.REFUSE:
        gaps = len(stretches) - 1
        places = ", ".join(str(_position(samples, context, one.stop - 1)) for one in stretches[:-1][:3])
        more = f" and {gaps - 3} more" if gaps > 3 else ""
        found = (
            "1 gap in the record, after sample"
            if gaps == 1
            else f"{gaps} gaps in the record, after samples"
        )
        raise InsufficientDataError(
            f"{context.case_name}: {found} {places}{more}"
            f"{_reasons(context)}; with 'gaps: longest_stretch' the longest part is used"
        )
    return max(stretches, key=lambda one: one.size)


def _reasons(context: Context) -> str:
    reasons = sorted({gap.reason for gap in context.gaps if gap.reason})
    return f" ({'; '.join(reasons[:3])})" if reasons else ""


def _missing(samples: Samples, context: Context) -> int:
    if samples.index is not None:
        return int(samples.index[-1]) - int(samples.index[0]) + 1 - samples.index.size
    return sum(gap.missing for gap in context.gaps)


def _begin_s(samples: Samples, start: int) -> float:
    if samples.time_s is not None:
        return float(samples.time_s[start] - samples.time_s[0])
    if samples.index is not None:
        return int(samples.index[start] - samples.index[0]) * samples.sampling.interval_s
    return start * samples.sampling.interval_s
