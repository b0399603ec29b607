"""The verification run: what is left of each step's rate before and after compensation."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.earth import EARTH_RATE_DPS
from gyrotest.procedures.compensation.coefficients import Coefficients
from gyrotest.procedures.dwells import DwellRecord, dwell_records, noise_of
from gyrotest.procedures.earth import earth_share
from gyrotest.procedures.outlier_rule import OutlierRule
from gyrotest.procedures.table_steps import rounding_covariance
from gyrotest.records.plan import Context
from gyrotest.records.recording import Samples

_Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Residuals:
    """Compensated rate less the table's (n,), °/s, with the covariance (n, n) of its errors."""

    values_dps: _Array
    covariance: _Array
    freedom: _Array

    @property
    def standard_dps(self) -> _Array:
        """The standard uncertainty of each."""
        return np.sqrt(np.diag(self.covariance))


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """Steps (n,) in their order, the residuals by the nominal values and by the fitted ones.

    `share_dps` is the Earth's rate that was subtracted; None: it is in the rates.
    """

    records: tuple[DwellRecord, ...]
    rates_dps: _Array
    before: Residuals
    after: Residuals
    share_dps: float | None


def verification(
    samples: Samples, context: Context, coefficients: Coefficients, rule: OutlierRule
) -> Verification:
    """Apply S3.7, ω = U/SF − B, to each step's mean; raises `InsufficientDataError`."""
    records = dwell_records(samples, context, rule=rule)
    rates_dps = np.array([one.rate_dps for one in records])
    outputs = np.array([one.mean for one in records])
    share_dps = earth_share(context)
    common = noise_of(records)
    noise = [common.of_mean(one.duration_s) for one in records]
    errors = _Errors(
        records=records,
        rates_dps=rates_dps,
        outputs=outputs,
        noise=np.array([one.value for one in noise]) + np.diag(rounding_covariance(records)),
        freedom=np.array([one.degrees_of_freedom for one in noise]),
        context=context,
    )
    nominal = records[0].scaling.scale_factor
    fitted, bias_dps = coefficients.scale_factor.value, coefficients.bias.value
    earth_dps = share_dps or 0.0
    in_bias = coefficients.holds_earth
    return Verification(
        records=records,
        rates_dps=rates_dps,
        before=errors.residuals(
            outputs / nominal - earth_dps - rates_dps, nominal, earth_unknown=share_dps is None
        ),
        after=errors.residuals(
            outputs / fitted - bias_dps - (0.0 if in_bias else earth_dps) - rates_dps,
            fitted,
            earth_unknown=share_dps is None and not in_bias,
        ),
        share_dps=share_dps,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Errors:
    """What makes the residuals uncertain: the noise of the means, the table, the meter, the Earth."""

    records: tuple[DwellRecord, ...]
    rates_dps: _Array
    outputs: _Array
    noise: _Array
    freedom: _Array
    context: Context

    def residuals(self, values_dps: _Array, scale_factor: float, *, earth_unknown: bool) -> Residuals:
        noise = np.diag(self.noise / scale_factor**2)
        others = self._table() + self._meter(scale_factor)
        if earth_unknown:
            others = others + EARTH_RATE_DPS**2 / 3.0
        total = np.diag(noise + others)
        own = np.diag(noise)
        freedom = np.where(
            own > 0.0, self.freedom * (total / np.where(own > 0.0, own, 1.0)) ** 2, np.inf
        )
        return Residuals(values_dps=values_dps, covariance=noise + others, freedom=freedom)

    def _table(self) -> _Array:
        """Return the table's common gain error, and each setting's own, of which a table at rest has none."""
        table = self.context.table
        if table is None:
            return np.zeros((self.rates_dps.size, self.rates_dps.size))
        gain = np.outer(self.rates_dps, self.rates_dps) * table.of_reading.to("") ** 2
        half_dps = 0.0 if table.of_setting is None else table.of_setting.to("deg/s")
        same = (self.rates_dps[:, np.newaxis] == self.rates_dps) & (self.rates_dps != 0.0)
        return np.asarray((gain + same * half_dps**2) / 3.0, dtype=np.float64)

    def _meter(self, scale_factor: float) -> _Array:
        accuracy, first = self.context.accuracy, self.records[0]
        if accuracy is None:
            return np.zeros((self.outputs.size, self.outputs.size))
        indicated = self.outputs + first.scaling.zero
        square = np.outer(indicated, indicated) * accuracy.of_reading.to("") ** 2
        if first.sampling.range is not None:
            full = first.sampling.range * first.scaling.to_canonical
            square = square + (accuracy.of_range.to("") * full) ** 2
        return np.asarray(square / (3.0 * scale_factor**2), dtype=np.float64)
