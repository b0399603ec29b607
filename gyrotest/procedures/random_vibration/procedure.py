"""The random-vibration procedure: a record at rest, then runs of random motion, and what they tell."""

from collections.abc import Iterable, Iterator
from typing import Any

from gyrotest.procedures.case_plan import plan_of_steps, step_samples
from gyrotest.procedures.random_vibration.agreement import agreement_with
from gyrotest.procedures.random_vibration.complaints import random_complaints
from gyrotest.procedures.random_vibration.exports import response_export
from gyrotest.procedures.random_vibration.figures import response_figures
from gyrotest.procedures.random_vibration.measurands import random_measurands
from gyrotest.procedures.random_vibration.measured import measured_response
from gyrotest.procedures.random_vibration.parameters import RandomVibrationParameters
from gyrotest.procedures.random_vibration.remarks import response_remarks
from gyrotest.procedures.random_vibration.results import response_results
from gyrotest.records.plan import Context, Excitation, Plan, Reduction, Step
from gyrotest.records.recording import ENCODER, SampleStream
from gyrotest.records.result import Measurand, Result
from gyrotest.records.spec import Case, Output


class RandomVibration:
    """Sensitivity and phase over a band, by random vibration against the table's encoder."""

    parameters: type[Any] = RandomVibrationParameters

    def measurands(
        self, case: Case, parameters: RandomVibrationParameters, output: Output
    ) -> tuple[Measurand, ...]:
        """Return everything that a case with these parameters measures."""
        del case
        return random_measurands(parameters, output)

    def complaints(
        self, case: Case, parameters: RandomVibrationParameters, output: Output
    ) -> Iterable[tuple[str, str]]:
        """Give what is wrong with a case beyond its types."""
        return random_complaints(case, parameters, output)

    def plan(self, case: Case, parameters: RandomVibrationParameters) -> Plan:
        """Return one acquisition: a record at rest, then the runs."""
        return plan_of_steps(case, tuple(_steps(case, parameters)), auxiliary=(ENCODER,))

    def reduce_stream(self, stream: SampleStream, context: Context) -> Reduction:
        """Return results and figures of one acquisition; raises `InsufficientDataError`."""
        measured = measured_response(stream, context)
        agreement = agreement_with(measured, context)
        return Reduction(
            results=tuple(response_results(measured, agreement, context)),
            figures=response_figures(measured, agreement, context),
            remarks=tuple(response_remarks(measured, context)),
            exports=(response_export(measured, context),),
        )

    def reduce_repeats(self, repeats: tuple[tuple[Result, ...], ...], context: Context) -> Reduction:
        """Return nothing: the runs of an acquisition show what repeats."""
        del repeats, context
        return Reduction(results=())


def _steps(case: Case, parameters: RandomVibrationParameters) -> Iterator[Step]:
    at_rest = round(parameters.rest.to("s") / case.interval.to("s"))
    yield Step(samples=at_rest, name="rest", stimulus=parameters.vibrating(Excitation.NONE))
    for number in range(1, parameters.runs + 1):
        moving = parameters.vibrating(Excitation.RANDOM)
        yield Step(samples=step_samples(case), name=f"run {number}", stimulus=moving)
