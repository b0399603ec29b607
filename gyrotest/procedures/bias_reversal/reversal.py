"""The bias from two opposite turns, and its budget: a reversal is not free of error."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gyrotest.analysis.scale_factor import Linear
from gyrotest.analysis.step_noise import Variance, mean_covariances
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.bias_reversal.known_slope import KnownSlope, known_slope
from gyrotest.procedures.bias_reversal.parameters import BiasReversalParameters
from gyrotest.procedures.dwells import DwellRecord, dwell_records, noise_of
from gyrotest.procedures.earth import earth_share, earth_words, of_earth
from gyrotest.procedures.meter import meter_contributions, missing_of_meter
from gyrotest.procedures.table_steps import rounding_covariance
from gyrotest.procedures.uncertainty import budgeted_result, by_statistics, rectangular
from gyrotest.procedures.wording import plain, rate_text
from gyrotest.records.plan import Context
from gyrotest.records.recording import Samples
from gyrotest.records.result import Contribution, Result

_ROOT_2, _ROOT_3 = math.sqrt(2.0), math.sqrt(3.0)
_MATTERS = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Reversal:
    """The two turns, the scale factor, and half the sum of their outputs with its variances."""

    forward: DwellRecord
    backward: DwellRecord
    slope: KnownSlope
    sum_by_noise: Variance
    sum_by_rounding: float

    @property
    def rate_dps(self) -> float:
        """The rate that was turned both ways."""
        return self.forward.rate_dps

    @property
    def rate_at_rest_dps(self) -> float:
        """Bias and Earth's share together: B = (F₊ + F₋)/(2·SF), S3.5."""
        return (self.forward.mean + self.backward.mean) / (2.0 * self.slope.value)


def measured_reversal(samples: Samples, context: Context) -> Reversal:
    """Check the two dwells; raises `InsufficientDataError`."""
    parameters: BiasReversalParameters = context.parameters
    records = dwell_records(samples, context, rule=parameters.rule)
    if len(records) != 2 or records[0].rate_dps != -records[1].rate_dps:
        raise InsufficientDataError(
            f"{context.case_name}: a reversal needs one turn forward and one backward"
        )
    half = Linear(value=0.5 * (records[0].mean + records[1].mean), weights=np.array([0.5, 0.5]))
    # Two turns are too short to tell how far the bias has walked since power-on; for as long as they
    # last themselves they can.
    covariances = mean_covariances(
        np.array([one.begin_s for one in records]),
        np.array([one.duration_s for one in records]),
        since_s=records[1].begin_s + records[1].duration_s - records[0].begin_s,
    )
    return Reversal(
        forward=records[0],
        backward=records[1],
        slope=known_slope(records[0].scaling, parameters, context),
        sum_by_noise=noise_of(records).variance(half.per_square(covariances)),
        sum_by_rounding=half.variance(rounding_covariance(records)),
    )


def reversal_result(reversal: Reversal, context: Context) -> Result:
    """Return the bias, less the Earth's share, with its budget."""
    share_dps = earth_share(context)
    budget = (*_contributions(reversal, context), of_earth(share_dps))
    return budgeted_result(
        budget,
        name="bias",
        label="Bias, by reversal",
        value=reversal.rate_at_rest_dps - (share_dps or 0.0),
        unit="deg/s",
        condition=f"±{plain(abs(reversal.rate_dps), 6)} °/s; {reversal.slope.source};"
        f" {earth_words(share_dps)}",
        not_included=tuple(_missing(reversal, context)),
    )


def _contributions(reversal: Reversal, context: Context) -> Iterator[Contribution]:
    slope, at_rest = abs(reversal.slope.value), abs(reversal.rate_at_rest_dps)
    noise = reversal.sum_by_noise
    standard = math.sqrt(noise.value) / slope
    yield by_statistics("noise and drift of the two means", standard, noise.degrees_of_freedom)
    rounding = math.sqrt(reversal.sum_by_rounding) / slope
    if rounding > _MATTERS * standard:
        yield rectangular("resolution of the output", "", "1", _ROOT_3 * rounding)
    yield from _of_asymmetry(reversal)
    yield from _of_table(context)
    if reversal.slope.relative is not None:
        half = _ROOT_3 * reversal.slope.relative
        share = f"{plain(half * 100.0, 3)} %"
        yield rectangular(reversal.slope.source, share, rate_text(at_rest, 3), half * at_rest)
    scaling = reversal.forward.scaling
    yield from meter_contributions(
        context, reversal.forward.sampling, scaling, slope=slope, indication=_indication(reversal)
    )


def _indication(reversal: Reversal) -> float:
    """Return the mean indication; where the scale factor is measured, its share in the gain cancels."""
    zero = reversal.forward.scaling.zero
    if reversal.slope.source.startswith("nominal"):
        return zero + reversal.slope.value * reversal.rate_at_rest_dps
    return zero


def _of_asymmetry(reversal: Reversal) -> Iterator[Contribution]:
    """Give α·ω/2, which a reversal does not tell from a bias (S3.5)."""
    asymmetry = reversal.slope.asymmetry
    if asymmetry is not None:
        half_rate = abs(reversal.rate_dps) / 2.0
        yield Contribution(
            source="scale-factor asymmetry",
            kind="B",
            distribution=asymmetry.distribution,
            half_width=asymmetry.stated,
            sensitivity=rate_text(half_rate, 3),
            standard_uncertainty=asymmetry.standard * half_rate,
        )


def _of_table(context: Context) -> Iterator[Contribution]:
    """Give what unequal rates leave: half the difference of two settings' own errors."""
    if context.table is not None and context.table.of_setting is not None:
        half_dps = context.table.of_setting.to("deg/s")
        yield rectangular(
            "table, own errors of the two settings", rate_text(half_dps), "0.71", half_dps / _ROOT_2
        )


def _missing(reversal: Reversal, context: Context) -> Iterator[str]:
    if context.table is None or context.table.of_setting is None:
        yield "own error of each setting of the rate table"
    if reversal.slope.asymmetry is None:
        yield "scale-factor asymmetry"
    if reversal.slope.relative is None:
        yield "uncertainty of the scale factor"
    yield from missing_of_meter(context, reversal.forward.sampling)
