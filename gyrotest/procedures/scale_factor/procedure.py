"""The scale-factor procedure: steps on a rate table, and the line through them."""

from collections.abc import Iterable, Iterator
from typing import Any

from gyrotest.procedures.case_plan import plan_of_steps, step_samples
from gyrotest.procedures.scale_factor.figures import turn_figures
from gyrotest.procedures.scale_factor.over_repeats import scale_factor_repeatability
from gyrotest.procedures.scale_factor.parameters import (
    ScaleFactorParameters,
    scale_factor_complaints,
    scale_factor_measurands,
)
from gyrotest.procedures.scale_factor.remarks import turn_remarks
from gyrotest.procedures.scale_factor.results import turn_results
from gyrotest.procedures.turns import measured_turns
from gyrotest.records.plan import Context, Plan, Reduction, Step
from gyrotest.records.recording import Samples
from gyrotest.records.result import Measurand, Result
from gyrotest.records.spec import Case, Output


class ScaleFactor:
    """Scale factor, bias, nonlinearity and asymmetry by steps on a rate table."""

    parameters: type[Any] = ScaleFactorParameters

    def measurands(
        self, case: Case, parameters: ScaleFactorParameters, output: Output
    ) -> tuple[Measurand, ...]:
        """Return everything that a case with these parameters measures."""
        del parameters
        return scale_factor_measurands(case, output)

    def complaints(
        self, case: Case, parameters: ScaleFactorParameters, output: Output
    ) -> Iterable[tuple[str, str]]:
        """Give what is wrong with a case beyond its types."""
        return scale_factor_complaints(case, parameters, output)

    def plan(self, case: Case, parameters: ScaleFactorParameters) -> Plan:
        """Return the acquisition of one repeat: at rest, every rate, at rest."""
        return plan_of_steps(case, tuple(_steps(case, parameters)))

    def reduce(self, samples: Samples, context: Context) -> Reduction:
        """Return results and figures of one acquisition; raises `InsufficientDataError`."""
        parameters: ScaleFactorParameters = context.parameters
        turns = measured_turns(samples, context, parameters.rule)
        results = tuple(turn_results(turns, context))
        return Reduction(
            results=results,
            figures=turn_figures(turns, context),
            remarks=tuple(turn_remarks(turns, context)),
        )

    def reduce_repeats(self, repeats: tuple[tuple[Result, ...], ...], context: Context) -> Reduction:
        """Return the repeatability over the repeats; raises `InsufficientDataError`."""
        return Reduction(results=(scale_factor_repeatability(repeats, context),))


def _steps(case: Case, parameters: ScaleFactorParameters) -> Iterator[Step]:
    rest = case.duration if parameters.rest is None else parameters.rest
    at_rest = round(rest.to("s") / case.interval.to("s"))
    yield parameters.step("rest before", 0.0, at_rest)
    for number, rate_dps in enumerate(parameters.signed_rates_dps, start=1):
        yield parameters.step(f"turn {number}", rate_dps, step_samples(case))
    yield parameters.step("rest after", 0.0, at_rest)
