"""What is found in a record: its curve, its noise model, its Allan minimum, and what to know of them."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from gyrotest.analysis.allan import AllanDeviation, overlapping_allan_deviation
from gyrotest.analysis.dead_time import DeadTime, dead_time_correction
from gyrotest.analysis.interval import NORMAL_95
from gyrotest.analysis.mean import mean_uncertainty
from gyrotest.analysis.minimum import AllanMinimum, allan_minimum
from gyrotest.analysis.noise import identify_noise
from gyrotest.analysis.noise_model import DriftKind, NoiseModel
from gyrotest.certificate.numbers import printed
from gyrotest.offline.record import RateRecord
from gyrotest.offline.sources import Source
from gyrotest.procedures.rest.soundness import regularity_complaint
from gyrotest.procedures.wording import engineering, plain
from gyrotest.units import Quantity

_IMPROBABLE = 0.001
_SAME_TIME = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Analysis:
    """A record's noise, without its samples.

    `dead_time` is the factor from the apparent to the true angle random walk; None where there is
    dead time and it cannot be corrected.
    """

    source: Source
    samples: int
    interval_s: float
    begin_s: float
    duty: float
    mean_dps: float
    mean_standard_uncertainty_dps: float
    curve: AllanDeviation
    model: NoiseModel
    minimum: AllanMinimum | None
    dead_time: DeadTime | None
    datasheet: Mapping[str, Quantity]
    remarks: tuple[str, ...]

    @property
    def duration_s(self) -> float:
        """Time that the record covers."""
        return self.samples * self.interval_s


def analysed(
    record: RateRecord, *, bandwidth_hz: float | None, datasheet: Mapping[str, Quantity]
) -> Analysis:
    """Analyse a record; raises `InsufficientDataError`."""
    rate, rate_hz = record.rate_dps, 1.0 / record.interval_s
    curve = overlapping_allan_deviation(rate, sample_rate_hz=rate_hz)
    model = identify_noise(rate, sample_rate_hz=rate_hz, duty=record.duty, deviation=curve)
    minimum = allan_minimum(curve, first_tau_s=model.first_tau_s)
    dead_time = dead_time_correction(
        reading_s=min(record.reading_s, record.interval_s / record.readings),
        spacing_s=record.interval_s / record.readings,
        bandwidth_hz=bandwidth_hz,
    )
    found = mean_uncertainty(model, duration_s=rate.size * record.interval_s)
    return Analysis(
        source=record.source,
        samples=rate.size,
        interval_s=record.interval_s,
        begin_s=record.begin_s,
        duty=record.duty,
        mean_dps=float(rate.mean()),
        mean_standard_uncertainty_dps=found.standard_uncertainty_dps,
        curve=curve,
        model=model,
        minimum=minimum,
        dead_time=dead_time,
        datasheet=datasheet,
        remarks=(
            *record.remarks,
            *_fit_remarks(curve, model),
            *_minimum_remarks(minimum),
            *_dead_time_remarks(record, dead_time, bandwidth_hz),
        ),
    )


def _fit_remarks(curve: AllanDeviation, model: NoiseModel) -> Iterator[str]:
    if model.first_tau_s > float(curve.tau_s[0]) * (1.0 + _SAME_TIME):
        yield (
            f"Averaging times below {plain(model.first_tau_s, 3)} s contradict the longer ones (a low-pass"
            " filter, or a spectral line): they are left out of the fit and of the minimum."
        )
    if model.fit_probability < _IMPROBABLE:
        yield (
            f"The five noise terms do not describe the record (χ²/ν = {plain(model.misfit, 3)}): the"
            " intervals are widened by its root."
        )
    too_regular = regularity_complaint(model)
    if too_regular:
        yield too_regular
    for line in model.lines:
        yield (
            f"Spectral line at {plain(line.frequency_hz, 4)} Hz, amplitude"
            f" {_with_interval(line.amplitude_dps, line.standard_uncertainty_dps)} °/s: kept out of the fit."
        )
    yield from _drift_remarks(model)


def _drift_remarks(model: NoiseModel) -> Iterator[str]:
    drift = model.drift
    if drift is not None:
        course = (
            "a straight line"
            if drift.kind is DriftKind.LINEAR or drift.time_constant_s is None
            else f"an exponential of {plain(drift.time_constant_s, 3)} s"
        )
        yield (
            f"The rate drifts by {_with_interval(drift.change_dps, drift.standard_uncertainty_dps)} °/s"
            f" along {course}: kept out of the fit."
        )


def _with_interval(value: float, standard_uncertainty: float) -> str:
    shown = printed(value, uncertainty=NORMAL_95 * standard_uncertainty)
    return f"{shown.value} ± {shown.uncertainty}"


def _minimum_remarks(minimum: AllanMinimum | None) -> Iterator[str]:
    if minimum is None:
        yield "The record is too short for an Allan minimum: nowhere 10 degrees of freedom."
    elif not minimum.reached:
        yield (
            "The Allan minimum's floor was not reached: the curve is lowest at an end of the admissible"
            " averaging times, so that the value is an upper limit."
        )


def _dead_time_remarks(
    record: RateRecord, dead_time: DeadTime | None, bandwidth_hz: float | None
) -> Iterator[str]:
    if record.duty >= 1.0 - 1e-9:
        return
    begin = f"Dead time: a sample covers {plain(100.0 * record.duty, 3)} % of its interval;"
    if dead_time is not None:
        yield (
            f"{begin} the angle random walk is corrected for the white noise that folds back, the curve"
            " and all other values are as read."
        )
        return
    needed = engineering(1.0 / (2.0 * record.reading_s), "Hz", 3)
    known = "not known (--bandwidth)" if bandwidth_hz is None else engineering(bandwidth_hz, "Hz", 3)
    yield (
        f"{begin} the angle random walk cannot be corrected for it, the gyro's bandwidth must exceed"
        f" {needed} and is {known}."
    )
