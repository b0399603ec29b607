"""The procedures: small up-and-down steps from rest, and around a rate (S3.9)."""

from collections.abc import Iterable
from typing import Any, ClassVar

from gyrotest.procedures.step_table import dropped_samples
from gyrotest.procedures.threshold.figure import small_step_figure
from gyrotest.procedures.threshold.levels import measured_levels
from gyrotest.procedures.threshold.parameters import (
    ResolutionParameters,
    ThresholdParameters,
    small_step_complaints,
    small_step_plan,
)
from gyrotest.procedures.threshold.results import Kind, small_step_measurands, small_step_results
from gyrotest.records.plan import Context, Plan, Reduction
from gyrotest.records.recording import Samples
from gyrotest.records.result import Measurand, Result
from gyrotest.records.spec import Case, Output

THRESHOLD = Kind(name="threshold", label="Threshold")
RESOLUTION = Kind(name="resolution", label="Resolution")


class Threshold:
    """The smallest input from rest that gives at least half of the output that is promised."""

    parameters: type[Any] = ThresholdParameters
    kind: ClassVar[Kind] = THRESHOLD

    def measurands(
        self, case: Case, parameters: ThresholdParameters, output: Output
    ) -> tuple[Measurand, ...]:
        """Return the smallest change that is followed, and the response at the stated value."""
        del case, parameters, output
        return small_step_measurands(self.kind)

    def complaints(
        self, case: Case, parameters: ThresholdParameters, output: Output
    ) -> Iterable[tuple[str, str]]:
        """Give what is wrong with a case beyond its types."""
        return small_step_complaints(case, parameters, output, self.kind.name)

    def plan(self, case: Case, parameters: ThresholdParameters) -> Plan:
        """Return the acquisition of one repeat."""
        return small_step_plan(case, parameters)

    def reduce(self, samples: Samples, context: Context) -> Reduction:
        """Return results and figure of one acquisition; raises `InsufficientDataError`."""
        parameters: ThresholdParameters = context.parameters
        found = measured_levels(samples, context, parameters)
        return Reduction(
            results=small_step_results(found, self.kind, parameters, context),
            figures=(small_step_figure(found, self.kind),),
            remarks=tuple(dropped_samples(found.records)),
        )

    def reduce_repeats(self, repeats: tuple[tuple[Result, ...], ...], context: Context) -> Reduction:
        """Return nothing: each repeat stands for itself."""
        del repeats, context
        return Reduction(results=())


class Resolution(Threshold):
    """The smallest change of an input, not 0, that gives at least half of the change that is promised."""

    parameters: type[Any] = ResolutionParameters
    kind: ClassVar[Kind] = RESOLUTION
