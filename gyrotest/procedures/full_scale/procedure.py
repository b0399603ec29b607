"""The measurement-range procedure: steps up to full scale and beyond, until the output leaves the line."""

from collections.abc import Iterable, Iterator
from typing import Any

from gyrotest.procedures.case_plan import plan_of_steps, step_samples
from gyrotest.procedures.full_scale.parameters import (
    FullScaleParameters,
    range_complaints,
    range_measurands,
)
from gyrotest.procedures.full_scale.reach import measured_reaches
from gyrotest.procedures.full_scale.results import range_figure, range_results, saturation_remarks
from gyrotest.procedures.step_table import dropped_samples, steps_figure
from gyrotest.records.plan import Context, Plan, Reduction, Step
from gyrotest.records.recording import Samples
from gyrotest.records.result import Measurand, Result
from gyrotest.records.spec import Case, Output


class FullScale:
    """The highest rates, each way, at which the output stays on the line; where it saturates."""

    parameters: type[Any] = FullScaleParameters

    def measurands(
        self, case: Case, parameters: FullScaleParameters, output: Output
    ) -> tuple[Measurand, ...]:
        """Return everything that a case with these parameters measures."""
        del case, parameters, output
        return range_measurands()

    def complaints(
        self, case: Case, parameters: FullScaleParameters, output: Output
    ) -> Iterable[tuple[str, str]]:
        """Give what is wrong with a case beyond its types."""
        return range_complaints(case, parameters, output)

    def plan(self, case: Case, parameters: FullScaleParameters) -> Plan:
        """Return the acquisition of one repeat: at rest, every rate both ways, at rest."""
        return plan_of_steps(case, tuple(_steps(case, parameters)))

    def reduce(self, samples: Samples, context: Context) -> Reduction:
        """Return the ranges of one acquisition; raises `InsufficientDataError`."""
        reaches = measured_reaches(samples, context)
        return Reduction(
            results=tuple(range_results(reaches, context)),
            figures=(range_figure(reaches, context), steps_figure(reaches.records)),
            remarks=(*saturation_remarks(reaches), *dropped_samples(reaches.records)),
        )

    def reduce_repeats(self, repeats: tuple[tuple[Result, ...], ...], context: Context) -> Reduction:
        """Return nothing: a range has no spread that anyone asks for."""
        del repeats, context
        return Reduction(results=())


def _steps(case: Case, parameters: FullScaleParameters) -> Iterator[Step]:
    samples = step_samples(case)
    yield parameters.step("rest before", 0.0, samples)
    for number, rate_dps in enumerate(parameters.magnitudes_dps, start=1):
        yield parameters.step(f"forward {number}", rate_dps, samples, may_saturate=True)
        yield parameters.step(f"backward {number}", -rate_dps, samples, may_saturate=True)
    yield parameters.step("rest after", 0.0, samples)
