"""The bias-reversal procedure: one rate, turned forward and backward."""

from collections.abc import Iterable
from typing import Any

from gyrotest.procedures.bias_reversal.parameters import (
    BiasReversalParameters,
    reversal_complaints,
    reversal_measurands,
)
from gyrotest.procedures.bias_reversal.reversal import measured_reversal, reversal_result
from gyrotest.procedures.case_plan import plan_of_steps, step_samples
from gyrotest.procedures.step_table import dropped_samples, steps_figure
from gyrotest.records.plan import Context, Plan, Reduction
from gyrotest.records.recording import Samples
from gyrotest.records.result import Measurand, Result
from gyrotest.records.spec import Case, Output


class BiasReversal:
    """Bias by turning at a rate and at the opposite one."""

    parameters: type[Any] = BiasReversalParameters

    def measurands(
        self, case: Case, parameters: BiasReversalParameters, output: Output
    ) -> tuple[Measurand, ...]:
        """Return everything that a case with these parameters measures."""
        del case, parameters, output
        return reversal_measurands()

    def complaints(
        self, case: Case, parameters: BiasReversalParameters, output: Output
    ) -> Iterable[tuple[str, str]]:
        """Give what is wrong with a case beyond its types."""
        return reversal_complaints(case, parameters, output)

    def plan(self, case: Case, parameters: BiasReversalParameters) -> Plan:
        """Return the acquisition of one repeat: forward, backward."""
        rate_dps, samples = parameters.rate.to("deg/s"), step_samples(case)
        steps = (
            parameters.step("forward", rate_dps, samples),
            parameters.step("backward", -rate_dps, samples),
        )
        return plan_of_steps(case, steps)

    def reduce(self, samples: Samples, context: Context) -> Reduction:
        """Return the bias of one acquisition; raises `InsufficientDataError`."""
        reversal = measured_reversal(samples, context)
        records = (reversal.forward, reversal.backward)
        return Reduction(
            results=(reversal_result(reversal, context),),
            figures=(steps_figure(records),),
            remarks=tuple(dropped_samples(records)),
        )

    def reduce_repeats(self, repeats: tuple[tuple[Result, ...], ...], context: Context) -> Reduction:
        """Return nothing: the spread over repeats is `bias_repeatability`'s."""
        del repeats, context
        return Reduction(results=())
