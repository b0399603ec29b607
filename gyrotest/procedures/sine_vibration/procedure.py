"""The sine-vibration procedure: sines of the table one after another, or a sweep, and what they tell."""

from collections.abc import Iterable, Iterator
from typing import Any

from gyrotest.procedures.case_plan import plan_of_steps, step_samples
from gyrotest.procedures.sine_vibration.complaints import sine_complaints
from gyrotest.procedures.sine_vibration.figure import bode_figure
from gyrotest.procedures.sine_vibration.measured import measured_sines
from gyrotest.procedures.sine_vibration.parameters import SineVibrationParameters, step_name
from gyrotest.procedures.sine_vibration.remarks import sine_remarks
from gyrotest.procedures.sine_vibration.results import sine_results
from gyrotest.procedures.vibration_names import response_measurands
from gyrotest.records.plan import Context, Plan, Reduction, Step
from gyrotest.records.recording import ENCODER, SampleStream
from gyrotest.records.result import Measurand, Result
from gyrotest.records.spec import Case, Output


class SineVibration:
    """Sensitivity and phase at single frequencies, by sines against the table's encoder."""

    parameters: type[Any] = SineVibrationParameters

    def measurands(
        self, case: Case, parameters: SineVibrationParameters, output: Output
    ) -> tuple[Measurand, ...]:
        """Return everything that a case with these parameters measures."""
        del case
        return tuple(response_measurands(parameters.frequencies_hz, output))

    def complaints(
        self, case: Case, parameters: SineVibrationParameters, output: Output
    ) -> Iterable[tuple[str, str]]:
        """Give what is wrong with a case beyond its types."""
        return sine_complaints(case, parameters, output)

    def plan(self, case: Case, parameters: SineVibrationParameters) -> Plan:
        """Return one acquisition: a step a frequency, or the sweep."""
        return plan_of_steps(case, tuple(_steps(case, parameters)), auxiliary=(ENCODER,))

    def reduce_stream(self, stream: SampleStream, context: Context) -> Reduction:
        """Return results and figures of one acquisition; raises `InsufficientDataError`."""
        measured = measured_sines(stream, context)
        results = tuple(sine_results(measured, context))
        return Reduction(
            results=results,
            figures=(bode_figure(measured, results, context),),
            remarks=tuple(sine_remarks(measured, context)),
        )

    def reduce_repeats(self, repeats: tuple[tuple[Result, ...], ...], context: Context) -> Reduction:
        """Return nothing: each repeat stands for itself."""
        del repeats, context
        return Reduction(results=())


def _steps(case: Case, parameters: SineVibrationParameters) -> Iterator[Step]:
    samples, sweep = step_samples(case), parameters.sweep
    if sweep is not None:
        yield Step(samples=samples, name="sweep", stimulus=parameters.swept(sweep))
        return
    for frequency_hz in parameters.frequencies_hz:
        yield Step(
            samples=samples, name=step_name(frequency_hz), stimulus=parameters.steady(frequency_hz)
        )
