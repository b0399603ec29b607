"""Results of a random-vibration case: sensitivity, phase, what the whole band gives, and how it repeats."""

from collections.abc import Iterator

import numpy as np

from gyrotest.analysis.response_repeatability import Largest
from gyrotest.procedures.random_vibration.agreement import Agreement, agreement_results
from gyrotest.procedures.random_vibration.band import band_results
from gyrotest.procedures.random_vibration.least_coherence import least_coherence
from gyrotest.procedures.random_vibration.measurands import (
    AMPLITUDE_REPEATABILITY,
    LABELS,
    LEAST_COHERENCE,
    PHASE_REPEATABILITY,
)
from gyrotest.procedures.random_vibration.measured import MeasuredResponse
from gyrotest.procedures.random_vibration.parameters import RandomVibrationParameters
from gyrotest.procedures.random_vibration.pointwise import phase_result, sensitivity_result
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.result import Result


def response_results(
    measured: MeasuredResponse, agreement: Agreement, context: Context
) -> Iterator[Result]:
    """Give the results of one acquisition."""
    parameters: RandomVibrationParameters = context.parameters
    for frequency_hz in parameters.reported_hz:
        yield sensitivity_result(measured, frequency_hz, context)
    for frequency_hz in parameters.reported_hz:
        yield phase_result(measured, frequency_hz)
    yield from band_results(measured, parameters)
    yield from _repeatability_results(measured)
    yield _coherence_result(measured)
    yield from agreement_results(agreement)


def _repeatability_results(measured: MeasuredResponse) -> Iterator[Result]:
    found = measured.repeatability
    for name, unit in ((AMPLITUDE_REPEATABILITY, "%"), (PHASE_REPEATABILITY, "deg")):
        if found is None:
            reason = "a single run has no spread; see 'parameters.runs'"
            yield Result(name=name, label=LABELS[name], value=None, unit=unit, condition=reason)
        else:
            largest = found.amplitude if name == AMPLITUDE_REPEATABILITY else found.phase
            yield _repeatability_result(largest, found.runs, name, unit)


def _repeatability_result(largest: Largest, runs: int, name: str, unit: str) -> Result:
    noise = f"{plain(largest.noise, 2)} {'%' if unit == '%' else '°'}"
    return Result(
        name=name,
        label=LABELS[name],
        value=largest.value,
        unit=unit,
        lower_95=largest.lower_95,
        upper_95=largest.upper_95,
        condition=f"3σ of {runs} runs, largest at {plain(largest.at_hz, 3)} Hz; random error of the runs"
        f" alone {noise}",
    )


def _coherence_result(measured: MeasuredResponse) -> Result:
    response = measured.response
    found = least_coherence(response.coherence, averages=response.averages)
    lowest = int(np.argmin(response.coherence))
    return Result(
        name=LEAST_COHERENCE,
        label=LABELS[LEAST_COHERENCE],
        value=100.0 * found.value,
        unit="%",
        lower_95=100.0 * found.lower_95,
        upper_95=100.0 * found.upper_95,
        condition=f"at {plain(float(response.frequency_hz[lowest]), 5)} Hz, all runs together",
    )
