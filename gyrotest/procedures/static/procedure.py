"""The static procedure: a gyro at rest, its bias and its noise."""

from collections.abc import Iterable
from typing import Any

from gyrotest.procedures.case_plan import single_step_plan
from gyrotest.procedures.recorded_temperature import SENSOR
from gyrotest.procedures.rest.bias import bias_result
from gyrotest.procedures.rest.bias_over_repeats import bias_over_repeats
from gyrotest.procedures.rest.record import rest_record
from gyrotest.procedures.scaling import nominal_complaints
from gyrotest.procedures.static.figures import static_figures
from gyrotest.procedures.static.noise_results import (
    analyse_noise,
    coefficient_results,
    minimum_result,
    not_evaluated,
    stability_result,
)
from gyrotest.procedures.static.parameters import (
    StaticParameters,
    static_complaints,
    static_measurands,
)
from gyrotest.records.plan import Context, Plan, Reduction
from gyrotest.records.recording import Samples
from gyrotest.records.result import Measurand, Result
from gyrotest.records.spec import Case, Output


class Static:
    """Bias, bias stability, Allan deviation and noise coefficients of a gyro at rest."""

    parameters: type[Any] = StaticParameters

    def measurands(
        self, case: Case, parameters: StaticParameters, output: Output
    ) -> tuple[Measurand, ...]:
        """Return everything that a case with these parameters measures."""
        del output  # rates, whatever it is
        return static_measurands(case, parameters)

    def complaints(
        self, case: Case, parameters: StaticParameters, output: Output
    ) -> Iterable[tuple[str, str]]:
        """Give what is wrong with a case beyond its types."""
        yield from nominal_complaints(output)
        yield from static_complaints(case, parameters)

    def plan(self, case: Case, parameters: StaticParameters) -> Plan:
        """Return the acquisition of one repeat."""
        del parameters
        return single_step_plan(case, auxiliary=(SENSOR,))

    def reduce(self, samples: Samples, context: Context) -> Reduction:
        """Return results and figures of one acquisition; raises `InsufficientDataError`."""
        parameters: StaticParameters = context.parameters
        record = rest_record(samples, context, window=parameters.window)
        noise = analyse_noise(record)
        spreads = (
            *(
                stability_result(record, noise.model, smoothing, parameters, context)
                for smoothing in parameters.smoothing
            ),
            minimum_result(record, noise, context),
            *coefficient_results(record, noise.model, context),
        )
        if record.rounding:
            spreads = tuple(
                not_evaluated(one.name, one.label, one.unit, record.rounding) for one in spreads
            )
        results = (bias_result(record, noise.model, context), *spreads)
        figures = static_figures(record, noise, results, context)
        return Reduction(results=results, figures=figures, remarks=record.remarks)

    def reduce_repeats(self, repeats: tuple[tuple[Result, ...], ...], context: Context) -> Reduction:
        """Return the spread of the bias over the repeats; raises `InsufficientDataError`."""
        return Reduction(results=(bias_over_repeats(repeats, context),))
