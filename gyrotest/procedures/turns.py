"""The steps of a test on the table as they were measured: the line through them, and its covariance."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.scale_factor import Linear, StepFit, fit_steps
from gyrotest.analysis.step_noise import StepNoise, Variance, mean_covariances
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.case_plan import since_power_on_s
from gyrotest.procedures.dwells import DwellRecord, dwell_records, noise_of
from gyrotest.procedures.outlier_rule import OutlierRule
from gyrotest.procedures.scaling import Scaling
from gyrotest.procedures.table_steps import rounding_covariance
from gyrotest.records.plan import Context
from gyrotest.records.recording import Samples

_Array = NDArray[np.float64]
_DEAF = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class Turns:
    """Steps that turn (m), those at rest (r), the line, and what makes the means (m + r) uncertain.

    `noise_covariances` (4, m + r, m + r) are per unit of each squared noise coefficient, `setting` and
    `rounding` (m + r, m + r) the covariances that each setting's own error of the table and the steps of
    a digitised output give the means, in the square of the output's unit; None where not known.
    """

    turning: tuple[DwellRecord, ...]
    rest: tuple[DwellRecord, ...]
    fit: StepFit
    noise: StepNoise
    noise_covariances: _Array
    setting: _Array | None
    rounding: _Array

    @property
    def scaling(self) -> Scaling:
        """How the output is scaled by the spec."""
        return self.turning[0].scaling

    @property
    def rates_dps(self) -> _Array:
        """The rates (m,) that were asked for."""
        return np.array([one.rate_dps for one in self.turning])

    @property
    def largest_dps(self) -> float:
        """The largest rate of either sign."""
        return float(np.abs(self.rates_dps).max())

    def by_noise(self, one: Linear) -> Variance:
        """Return the variance that noise gives something linear in the means."""
        return self.noise.variance(one.per_square(self.noise_covariances))

    def by_setting(self, one: Linear) -> float:
        """Return the variance that the table's own errors at its settings give it; 0 where not known."""
        return 0.0 if self.setting is None else one.variance(self.setting)

    def total(self, one: Linear) -> Variance:
        """Return its variance by all that differs from step to step, and the degrees of freedom."""
        noise = self.by_noise(one)
        value = noise.value + self.by_setting(one) + one.variance(self.rounding)
        freedom = noise.degrees_of_freedom * (value / noise.value) ** 2 if noise.value > 0.0 else np.inf
        return Variance(value=value, degrees_of_freedom=float(freedom))


def measured_turns(samples: Samples, context: Context, rule: OutlierRule) -> Turns:
    """Check the dwells and fit the line; raises `InsufficientDataError`."""
    return turns_of(dwell_records(samples, context, rule=rule), context)


def turns_of(
    records: tuple[DwellRecord, ...], context: Context, *, line_to_dps: float = math.inf
) -> Turns:
    """Fit the line through dwells, none of them saturated, up to a rate of either sign."""
    turning = tuple(one for one in records if one.rate_dps != 0.0)
    rest = tuple(one for one in records if one.rate_dps == 0.0)
    means = (*turning, *rest)
    fit = fit_steps(
        rates_dps=_numbers(one.rate_dps for one in turning),
        outputs=_numbers(one.mean for one in turning),
        times_s=_numbers(one.middle_s for one in turning),
        rest_outputs=_numbers(one.mean for one in rest),
        rest_times_s=_numbers(one.middle_s for one in rest),
        line_to_dps=line_to_dps,
    )
    _refuse_deaf(fit, records)
    return Turns(
        turning=turning,
        rest=rest,
        fit=fit,
        noise=noise_of(records),
        noise_covariances=mean_covariances(
            _numbers(one.begin_s for one in means),
            _numbers(one.duration_s for one in means),
            since_s=since_power_on_s(context) + min(one.begin_s for one in means),
        ),
        setting=setting_covariance(means, fit.scale_factor.value, context),
        rounding=rounding_covariance(means),
    )


def setting_covariance(
    means: tuple[DwellRecord, ...], scale_factor: float, context: Context
) -> _Array | None:
    """Return what each setting's own error adds to the covariance of the means; one rate has one error.

    A table at rest is held there, and has none.
    """
    if context.table is None or context.table.of_setting is None:
        return None
    half = abs(scale_factor) * context.table.of_setting.to("deg/s")
    rates = _numbers(one.rate_dps for one in means)
    same = (rates[:, np.newaxis] == rates) & (rates != 0.0)
    return np.asarray(same * (half**2 / 3.0), dtype=np.float64)


def _refuse_deaf(fit: StepFit, records: tuple[DwellRecord, ...]) -> None:
    """Refuse an output that hardly follows the rate: no gyro on this axis, or none on this channel."""
    scaling = records[0].scaling
    ratio = fit.scale_factor.value / scaling.scale_factor
    if abs(ratio) < _DEAF:
        raise InsufficientDataError(
            f"the output follows the table with {ratio:.2%} of the nominal scale factor: is this the axis that"
            " the table turns, and the slot's channel?"
        )


def _numbers(values: Iterable[float]) -> _Array:
    return np.fromiter(values, dtype=np.float64)
