"""Results of one mounting: bias, the coefficients that it shows, the drift before and after compensation."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.drift_spread import Spread, spread
from gyrotest.analysis.g_sensitivity import Term
from gyrotest.analysis.mounting import AXES
from gyrotest.analysis.shaft_errors import FittedShaft
from gyrotest.analysis.shaft_samples import SECTOR_DEG
from gyrotest.procedures.g_sensitivity.influences import (
    Bench,
    Influence,
    combined_lines,
    influences,
    missing_influences,
)
from gyrotest.procedures.g_sensitivity.measurands import (
    MOUNTED_AFTER,
    MOUNTED_BEFORE,
    MOUNTED_CROSS_AXIS,
    PER_G,
    mounted_name,
)
from gyrotest.procedures.g_sensitivity.mounting_record import MountingRecord
from gyrotest.procedures.uncertainty import budgeted_result, by_statistics
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.result import Contribution, Result

NOISE = "noise and drift"

_Array = NDArray[np.float64]
_DPH = 3600.0
_MATTERS = 5e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class MountingResults:
    """What one mounting is told to have, and the drift's spread before and after compensation, °/s."""

    results: tuple[Result, ...]
    before: Spread
    after: Spread
    groups: NDArray[np.intp]


def own_coefficients(found: MountingRecord) -> _Array:
    """Return the coefficients along the own axes (3,), 0 along the shaft, °/s per g."""
    own = np.zeros(len(AXES))
    for place in found.mounted.across:
        own[place] = found.found.along(found.mounted.axes[place]) @ found.found.coefficients
    return own


def mounting_results(found: MountingRecord, context: Context) -> MountingResults:
    """Return the results of one mounting."""
    bench = Bench(
        context=context,
        scale=found.scale,
        scaling=found.scaling,
        sampling=found.sampling,
        counted=found.counted,
        placement_deg=context.parameters.placement_uncertainty.to("deg"),
    )
    own = own_coefficients(found)
    known = influences(FittedShaft.of(found.found), found.mounted, own, bench)
    missing = tuple(missing_influences(bench, turning=context.parameters.turning))
    groups = drift_groups(found)
    noise = found.found.fit.noise_covariance
    before = spread(found.found.drift, groups, noise)
    after = spread(found.found.fit.residuals, groups, noise)
    return MountingResults(
        results=(
            _bias(found, known, missing, context),
            *_coefficients(found, own, known, missing),
            *_cross_axis(found, known, missing),
            _drift(before, MOUNTED_BEFORE, "Drift before compensation, this mounting", found),
            _drift(after, MOUNTED_AFTER, "Drift after compensation, this mounting", found),
        ),
        before=before,
        after=after,
        groups=groups,
    )


def drift_groups(found: MountingRecord) -> NDArray[np.intp]:
    """Return which average each span belongs to: long ones, so that white noise does not hide the drift."""
    step, spans = found.record.step, found.record.arcs.spans
    starts = np.flatnonzero(np.diff(step, prepend=-1))
    first = spans.begins_s[np.repeat(starts, np.diff(np.append(starts, step.size)))]
    within = np.floor((spans.begins_s - first + spans.durations_s / 2.0) / averaged_s(found))
    changes = (np.diff(step, prepend=-1) != 0) | (np.diff(within, prepend=-1.0) != 0)
    groups: NDArray[np.intp] = np.cumsum(changes) - 1
    return groups


def averaged_s(found: MountingRecord) -> float:
    """Return the averaging time of drifts: that of a sector, at rest a twelfth of the whole."""
    rates = np.abs(found.record.arcs.rate_dps)
    if found.found.arcs.turns:
        return SECTOR_DEG / float(np.median(rates[rates > 0.5 * rates.max()]))
    return max(found.span_s, 5.0)


def _bias(
    found: MountingRecord, known: tuple[Influence, ...], missing: tuple[str, ...], context: Context
) -> Result:
    factors = np.zeros(found.found.coefficients.size)
    factors[Term.BIAS] = 1.0
    unknown = (
        []
        if context.since_power_on_s is not None
        else ["drift before the record (time of power-on not known)"]
    )
    return budgeted_result(
        _budget(found, known, factors, "°/s"),
        name="bias",
        label="Bias",
        value=float(found.found.coefficients[Term.BIAS]),
        unit="deg/s",
        condition=f"{found.mounted.words}; Earth's rate and drift by gravity taken off",
        not_included=(*missing, *unknown),
    )


def _coefficients(
    found: MountingRecord, own: _Array, known: tuple[Influence, ...], missing: tuple[str, ...]
) -> Iterator[Result]:
    for place in found.mounted.across:
        axis = AXES[place]
        yield budgeted_result(
            _budget(found, known, found.found.along(found.mounted.axes[place]), "°/s/g"),
            name=mounted_name(axis),
            label=f"g-sensitivity {axis}, this mounting",
            value=float(own[place]),
            unit=PER_G,
            condition=found.mounted.words,
            not_included=missing,
        )


def _cross_axis(
    found: MountingRecord, known: tuple[Influence, ...], missing: tuple[str, ...]
) -> Iterator[Result]:
    """Give how the output follows the turning about the own axis that lies along the shaft."""
    if not found.found.arcs.turns:
        return
    factors = np.zeros(found.found.coefficients.size)
    factors[Term.TURNING] = 100.0 * found.mounted.shaft_sign
    yield budgeted_result(
        _budget(found, known, factors, "%"),
        name=MOUNTED_CROSS_AXIS,
        label="Cross-axis sensitivity to the shaft's rate",
        value=float(factors @ found.found.coefficients),
        unit="%",
        condition=f"{found.mounted.words}; output over the rate about own {AXES[found.mounted.along]}",
        not_included=missing,
    )


def _budget(
    found: MountingRecord, known: tuple[Influence, ...], factors: _Array, unit: str
) -> tuple[Contribution, ...]:
    noise = found.found.fit.variance(factors)
    lines = [
        by_statistics(NOISE, noise.value**0.5, noise.degrees_of_freedom),
        *combined_lines([(known, factors)], unit),
    ]
    return mattering(lines)


def mattering(lines: list[Contribution]) -> tuple[Contribution, ...]:
    """Leave out what is less than 0.5 % of the largest line, but never the noise."""
    least = _MATTERS * max(one.standard_uncertainty for one in lines)
    return tuple(one for one in lines if one.kind == "A" or one.standard_uncertainty >= least)


def _drift(found: Spread, name: str, label: str, record: MountingRecord) -> Result:
    lasts = f"{plain(averaged_s(record), 3)} s"
    averaged = f"{SECTOR_DEG:g}° ({lasts})" if record.found.arcs.turns else lasts
    return Result(
        name=name,
        label=label,
        value=found.deviation * _DPH,
        unit="deg/h",
        lower_95=found.lower_95 * _DPH,
        upper_95=found.upper_95 * _DPH,
        condition=f"standard deviation of {found.count} averages over {averaged}; {record.mounted.words}",
    )
