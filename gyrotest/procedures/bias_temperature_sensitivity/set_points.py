"""The set points of a recording: bias and temperature of each, and how well they are known."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.step_noise import StepNoise, mean_covariances
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.bias_temperature_sensitivity.parameters import (
    TemperatureParameters,
    same_set_point,
)
from gyrotest.procedures.dwells import DwellRecord, dwell_records, noise_of, sample_places
from gyrotest.procedures.earth import earth_share
from gyrotest.procedures.recorded_temperature import sensor_column
from gyrotest.procedures.table_steps import rounding_covariance
from gyrotest.records.plan import Context
from gyrotest.records.recording import Samples


@dataclass(frozen=True, slots=True, kw_only=True)
class SetPoints:
    """Set points (n,) with their mean temperatures, biases in °/s and the biases' covariance by noise.

    Records at the same set point are taken together. `room` is the place of the room temperature;
    `reader` says what measured the temperatures. `records` and `record_degc` are the single records and
    their temperatures, biases and these' covariance, in the order in which they were taken, and
    `record_u_dps` each one's standard uncertainty by what happens within it. `freedom` are the degrees of
    freedom of the noise, `share_dps` the Earth's rate that was subtracted (None: not).
    """

    set_degc: NDArray[np.float64]
    temperature_degc: NDArray[np.float64]
    bias_dps: NDArray[np.float64]
    covariance: NDArray[np.float64]
    freedom: float
    room: int
    reader: "Reader"
    records: tuple[DwellRecord, ...]
    record_degc: NDArray[np.float64]
    record_bias_dps: NDArray[np.float64]
    record_covariance: NDArray[np.float64]
    record_u_dps: NDArray[np.float64]
    share_dps: float | None

    def visits(self, place: int) -> int:
        """Return how many records were taken at a set point."""
        here = float(self.set_degc[place])
        return sum(same_set_point(_demanded(one), here) for one in self.records)

    def change_uncertainty_dps(self, place: int) -> float:
        """Return the standard uncertainty, by noise, of a set point's bias less that of the room."""
        return difference_uncertainty(self.covariance, place, self.room)


def difference_uncertainty(covariance: NDArray[np.float64], one: int, other: int) -> float:
    """Return the standard uncertainty of the difference of two quantities."""
    variance = covariance[one, one] + covariance[other, other] - 2.0 * covariance[one, other]
    return math.sqrt(max(float(variance), 0.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class Reader:
    """What measured the temperatures, in words, and whether that is the chamber."""

    name: str
    chamber: bool


def set_points(samples: Samples, context: Context, parameters: TemperatureParameters) -> SetPoints:
    """Reduce a recording to its set points; raises `InsufficientDataError`."""
    records = dwell_records(samples, context)
    reader, record_degc = _temperatures(samples, context, records)
    set_degc = np.array([_demanded(one) for one in records])
    noise = noise_of(records, alike=_longest_alike(records, set_degc))
    share_dps = earth_share(context)
    record_bias = np.array([one.mean_rate_dps for one in records]) - (share_dps or 0.0)
    covariance, freedom = _covariance(records, noise)
    distinct, merged = _merged(set_degc)
    room = parameters.room.to("degC")
    places = [place for place, one in enumerate(distinct) if same_set_point(float(one), room)]
    if not places:
        raise InsufficientDataError(
            f"{context.case_name}: no record at the room temperature of {room:g} °C; found"
            f" {', '.join(f'{one:g}' for one in distinct)} °C"
        )
    return SetPoints(
        set_degc=distinct,
        temperature_degc=merged @ record_degc,
        bias_dps=merged @ record_bias,
        covariance=merged @ covariance @ merged.T,
        freedom=freedom,
        room=places[0],
        reader=reader,
        records=records,
        record_degc=record_degc,
        record_bias_dps=record_bias,
        record_covariance=covariance,
        record_u_dps=np.array([_own_uncertainty(one, noise) for one in records]),
        share_dps=share_dps,
    )


def _own_uncertainty(record: DwellRecord, noise: StepNoise) -> float:
    variance = noise.of_mean(record.duration_s).value
    return math.sqrt(variance) / abs(record.scaling.scale_factor)


def _demanded(record: DwellRecord) -> float:
    if record.dwell.temperature_degc is None:
        raise InsufficientDataError(f"{record.name}: no temperature was asked for; is there a chamber?")
    return record.dwell.temperature_degc


def _merged(set_degc: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the distinct set points in their order, and the means (n, m) that take alike ones together."""
    first = [
        place
        for place, one in enumerate(set_degc)
        if not any(same_set_point(one, before) for before in set_degc[:place])
    ]
    distinct = set_degc[first]
    alike = np.array([[float(same_set_point(one, other)) for other in set_degc] for one in distinct])
    return distinct, alike / alike.sum(axis=1, keepdims=True)


def _longest_alike(
    records: tuple[DwellRecord, ...], set_degc: NDArray[np.float64]
) -> tuple[DwellRecord, ...]:
    """Return the records of the set point that was visited most often; no temperature moves them apart."""
    groups = [
        tuple(one for one, at in zip(records, set_degc, strict=True) if same_set_point(at, here))
        for here in set_degc
    ]
    return max(groups, key=len)


def _covariance(records: tuple[DwellRecord, ...], noise: StepNoise) -> tuple[NDArray[np.float64], float]:
    """Return the covariance of the records' mean rates, (°/s)², and its degrees of freedom."""
    begins = np.array([one.begin_s for one in records])
    durations = np.array([one.duration_s for one in records])
    per_square = mean_covariances(begins, durations)
    covariance = np.tensordot(noise.prudent_squares, per_square, axes=1) + rounding_covariance(records)
    first_to_last = (
        per_square[:, 0, 0] + per_square[:, -1, -1] - per_square[:, 0, -1] - per_square[:, -1, 0]
    )
    freedom = noise.variance(first_to_last).degrees_of_freedom
    return covariance / records[0].scaling.scale_factor ** 2, freedom


def _temperatures(
    samples: Samples, context: Context, records: tuple[DwellRecord, ...]
) -> tuple[Reader, NDArray[np.float64]]:
    """Return what measured the temperatures, and their means: a sensor that was recorded, or the chamber."""
    column = sensor_column(samples.sampling, context.axis)
    if column is not None:
        means = [float(one.mean()) for one in _parts(samples, context, column)]
        return Reader(name="recorded sensor", chamber=False), np.array(means)
    read = [one.dwell.measured_temperature_degc for one in records]
    if any(one is None for one in read):
        demanded = np.array([_demanded(one) for one in records])
        return Reader(name="set points, not read back", chamber=True), demanded
    return Reader(name="chamber's reading", chamber=True), np.array(read, dtype=np.float64)


def _parts(samples: Samples, context: Context, column: int) -> Iterator[NDArray[np.float64]]:
    """Give a column's samples of each dwell that are numbers."""
    values = samples.values[:, column]
    places = sample_places(samples, context)
    for dwell in context.dwells:
        start, stop = np.searchsorted(places, (dwell.first, dwell.first + dwell.samples))
        part = values[start:stop]
        found = part[np.isfinite(part)]
        if not found.size:
            raise InsufficientDataError(
                f"{context.case_name}: no reading of the temperature sensor at '{dwell.name}'"
            )
        yield found
