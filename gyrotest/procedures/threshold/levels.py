"""The levels of a recording: how much of each change the output followed, with its uncertainty."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.small_steps import Level, Response, contrast
from gyrotest.analysis.step_noise import StepNoise, mean_covariances
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.dwells import DwellRecord, dwell_records, noise_of
from gyrotest.procedures.threshold.parameters import ThresholdParameters, largest_error_dps
from gyrotest.procedures.wording import rate_text
from gyrotest.records.plan import Context
from gyrotest.records.recording import Samples
from gyrotest.records.station import Accuracy

_OF_VALUE = 1.0 / 3.0
_K = 2.0
_BASES = 2  # settings that a change goes between


@dataclass(frozen=True, slots=True, kw_only=True)
class Levels:
    """Levels in rising order, and the records that they come from."""

    levels: tuple[Level, ...]
    records: tuple[DwellRecord, ...]


def measured_levels(samples: Samples, context: Context, parameters: ThresholdParameters) -> Levels:
    """Reduce a recording to its levels; raises `InsufficientDataError`."""
    table = _known_table(context, parameters)
    records = dwell_records(samples, context, rule=parameters.rule)
    expected = 1 + 4 * parameters.steps * len(parameters.levels)  # up, base, down, base
    if len(records) != expected:
        raise InsufficientDataError(
            f"{context.case_name}: {len(records)} of {expected} steps are there; every change needs the steps"
            " beside it"
        )
    means, each = _means(records), 4 * parameters.steps
    levels = []
    for number, size_dps in enumerate(parameters.sizes_dps):
        first = 1 + each * number
        _refuse_off(records[first - 1 : first + each], size_dps)
        ups = first + 4 * np.arange(parameters.steps)
        table_dps = table_uncertainty_dps(table, size_dps, parameters)
        up = means.response(ups, size_dps, table_dps)
        down = means.response(ups + 2, -size_dps, table_dps)
        levels.append(Level(size_dps=size_dps, up=up, down=down))
    return Levels(levels=tuple(levels), records=records)


def table_uncertainty_dps(table: Accuracy, size_dps: float, parameters: ThresholdParameters) -> float:
    """Return the standard uncertainty of a change of a size.

    A table at rest is held there and has no error of its own; between two rates each setting has one.
    """
    setting = 0.0 if table.of_setting is None else table.of_setting.to("deg/s")
    settings = 1 if parameters.around_dps == 0.0 else _BASES
    gain = table.of_reading.to("") * size_dps
    return math.sqrt((settings * setting**2 + gain**2) / 3.0)


def _known_table(context: Context, parameters: ThresholdParameters) -> Accuracy:
    """Refuse a table that is not known to be good enough: the uncertainty of its rate, a third of the value."""
    table, value_dps = context.table, parameters.value.to("deg/s")
    if table is None or table.of_setting is None:
        raise InsufficientDataError(
            f"{context.case_name}: how exactly the table sets a rate is not known; state 'accuracy.of_setting' of"
            f" the table in the station: its uncertainty may be a third of {parameters.value} at most"
        )
    expanded_dps = _K * table_uncertainty_dps(table, value_dps, parameters)
    if expanded_dps > _OF_VALUE * value_dps:
        raise InsufficientDataError(
            f"{context.case_name}: the table's rate is uncertain by {rate_text(expanded_dps)} (k = 2), more than a"
            f" third of the value {parameters.value}; a better table is needed"
        )
    return table


def _refuse_off(records: tuple[DwellRecord, ...], size_dps: float) -> None:
    for one in records:
        read = one.dwell.measured_rate_dps
        if read is not None and abs(read - one.rate_dps) > largest_error_dps(size_dps):
            raise InsufficientDataError(
                f"{one.name}: the table reads back {rate_text(read, 4)}, too far off for a change of"
                f" {rate_text(size_dps, 3)}; does it turn so slowly?"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Means:
    """The steps' means, and what makes them uncertain: (4, n, n) per unit of each squared coefficient."""

    records: tuple[DwellRecord, ...]
    noise: StepNoise
    covariances: NDArray[np.float64]

    def response(self, places: NDArray[np.int64], change_dps: float, table_dps: float) -> Response:
        """Return what a change gives over what the nominal scale factor promises of it."""
        weights = contrast(places, len(self.records))
        promised = self.records[0].scaling.scale_factor * change_dps
        share = float(weights @ np.array([one.mean for one in self.records])) / promised
        per_square = np.einsum("i,kij,j->k", weights, self.covariances, weights)
        by_noise = self.noise.variance(per_square)
        variance = by_noise.value / promised**2
        total = variance + (share * table_dps / change_dps) ** 2
        freedom = by_noise.degrees_of_freedom * (total / variance) ** 2 if variance > 0.0 else math.inf
        return Response(share=share, standard_uncertainty=math.sqrt(total), degrees_of_freedom=freedom)


def _means(records: tuple[DwellRecord, ...]) -> _Means:
    """Fit the noise; the steps between the changes all have the same input."""
    begins = np.array([one.begin_s for one in records])
    durations = np.array([one.duration_s for one in records])
    return _Means(
        records=records,
        noise=noise_of(records, alike=records[::2]),
        covariances=mean_covariances(begins, durations),
    )
