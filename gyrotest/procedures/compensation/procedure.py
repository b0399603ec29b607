"""The procedure: a verification run, the fitted coefficients applied, what is left before and after (S3.7)."""

from collections.abc import Iterable
from typing import Any

from gyrotest.procedures.compensation.coefficients import fitted_coefficients
from gyrotest.procedures.compensation.exports import coefficient_exports
from gyrotest.procedures.compensation.figure import residuals_figure
from gyrotest.procedures.compensation.parameters import (
    CompensationParameters,
    compensation_complaints,
    compensation_plan,
)
from gyrotest.procedures.compensation.results import compensation_measurands, compensation_results
from gyrotest.procedures.compensation.verification import verification
from gyrotest.procedures.step_table import dropped_samples
from gyrotest.records.plan import Context, Plan, Reduction
from gyrotest.records.recording import Samples
from gyrotest.records.result import Measurand, Result
from gyrotest.records.spec import Case, Output


class Compensation:
    """Residual of a verification run before and after compensation, and the coefficients as files."""

    parameters: type[Any] = CompensationParameters

    def measurands(
        self, case: Case, parameters: CompensationParameters, output: Output
    ) -> tuple[Measurand, ...]:
        """Return the residuals, rms and largest, before and after."""
        del case, parameters, output
        return compensation_measurands()

    def complaints(
        self, case: Case, parameters: CompensationParameters, output: Output
    ) -> Iterable[tuple[str, str]]:
        """Give what is wrong with a case beyond its types."""
        return compensation_complaints(case, parameters, output)

    def plan(self, case: Case, parameters: CompensationParameters) -> Plan:
        """Return the acquisition of one repeat: rest, a step at each rate, rest."""
        return compensation_plan(case, parameters)

    def reduce(self, samples: Samples, context: Context) -> Reduction:
        """Return the residuals and the coefficients; raises `InsufficientDataError`."""
        parameters: CompensationParameters = context.parameters
        coefficients = fitted_coefficients(context, parameters.scale_factor_from)
        found = verification(samples, context, coefficients, parameters.rule)
        results = compensation_results(found, coefficients, context)
        return Reduction(
            results=results,
            figures=(residuals_figure(found, context),),
            remarks=tuple(dropped_samples(found.records)),
            exports=coefficient_exports(coefficients, results, context),
        )

    def reduce_repeats(self, repeats: tuple[tuple[Result, ...], ...], context: Context) -> Reduction:
        """Return nothing: each repeat stands for itself."""
        del repeats, context
        return Reduction(results=())
