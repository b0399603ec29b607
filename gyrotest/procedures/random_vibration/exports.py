"""The response as a file for other programs: one line a frequency."""

import csv
import io

import numpy as np
from numpy.typing import NDArray

from gyrotest.procedures.random_vibration.measured import MeasuredResponse
from gyrotest.procedures.random_vibration.pointwise import scale_in
from gyrotest.procedures.vibration_names import SENSITIVITY_UNITS
from gyrotest.records.plan import Context, Export

_DIGITS = 9


def response_export(measured: MeasuredResponse, context: Context) -> Export:
    """Return estimates with their errors, the fitted curve, and each run's estimates."""
    unit = SENSITIVITY_UNITS[context.output.kind]
    columns = _columns(measured, scale_in(measured, unit))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\r\n")
    writer.writerow(_headings(measured, unit or "ratio"))
    for row in zip(*columns, strict=True):
        writer.writerow([_number(float(one)) for one in row])
    return Export(name="response.csv", text=text.getvalue())


def _headings(measured: MeasuredResponse, unit: str) -> list[str]:
    runs = range(1, len(measured.runs) + 1)
    return [
        "frequency_hz",
        f"sensitivity [{unit}]",
        "phase_deg",
        "coherence",
        "sensitivity_error_percent",
        "phase_error_deg",
        "left_out",
        f"fitted_sensitivity [{unit}]",
        "fitted_phase_deg",
        "h1_over_hv",
        "h2_over_hv",
        *(f"run_{number}_sensitivity [{unit}]" for number in runs),
        *(f"run_{number}_phase_deg" for number in runs),
    ]


def _columns(measured: MeasuredResponse, scale: float) -> list[NDArray[np.float64]]:
    one, curve = measured.response, measured.curve
    frequency_hz = one.frequency_hz
    within = (frequency_hz >= curve.low_hz) & (frequency_hz <= curve.high_hz)
    fitted_gain, fitted_phase = np.full((2, frequency_hz.size), np.nan)
    fitted = curve.at(frequency_hz[within])
    fitted_gain[within], fitted_phase[within] = fitted.gain * scale, fitted.phase_deg
    return [
        frequency_hz,
        one.gain * scale,
        one.phase_deg,
        one.coherence,
        100.0 * one.error,
        one.phase_error_deg,
        np.isin(frequency_hz, curve.excluded_hz).astype(np.float64),
        fitted_gain,
        fitted_phase,
        measured.output_noise.gain / one.gain,
        measured.reference_noise.gain / one.gain,
        *(run.gain * scale for run in measured.runs),
        *(run.phase_deg for run in measured.runs),
    ]


def _number(value: float) -> str:
    """Return a number; what there is none for is empty."""
    return f"{value:.{_DIGITS}g}" if np.isfinite(value) else ""
