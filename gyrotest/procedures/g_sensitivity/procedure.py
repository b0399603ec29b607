"""The g-sensitivity procedure: turns of a level shaft, once as mounted and once turned by a quarter (S5)."""

from collections.abc import Iterable
from typing import Any

from gyrotest.procedures.case_plan import warm_up_s
from gyrotest.procedures.g_sensitivity.combined import combined_results
from gyrotest.procedures.g_sensitivity.combined_table import combined_figures
from gyrotest.procedures.g_sensitivity.comparison import comparison_results, other_coefficients
from gyrotest.procedures.g_sensitivity.complaints import g_sensitivity_complaints
from gyrotest.procedures.g_sensitivity.figures import mounting_figures
from gyrotest.procedures.g_sensitivity.measurands import g_sensitivity_measurands
from gyrotest.procedures.g_sensitivity.mounting_record import mounting_record
from gyrotest.procedures.g_sensitivity.mounting_results import mounting_results
from gyrotest.procedures.g_sensitivity.parameters import GSensitivityParameters, steps_of
from gyrotest.procedures.g_sensitivity.remarks import mounting_remarks
from gyrotest.procedures.g_sensitivity.repeats import mountings_of
from gyrotest.records.plan import Context, Plan, Reduction
from gyrotest.records.recording import ENCODER, Samples
from gyrotest.records.result import Measurand, Result
from gyrotest.records.spec import Case, Output


class GSensitivity:
    """Drift that follows gravity, its coefficient along each of the unit's own axes."""

    parameters: type[Any] = GSensitivityParameters

    def measurands(
        self, case: Case, parameters: GSensitivityParameters, output: Output
    ) -> tuple[Measurand, ...]:
        """Return everything that a case with these parameters measures."""
        del output
        return g_sensitivity_measurands(case, parameters)

    def complaints(
        self, case: Case, parameters: GSensitivityParameters, output: Output
    ) -> Iterable[tuple[str, str]]:
        """Give what is wrong with a case beyond its types."""
        return g_sensitivity_complaints(case, parameters, output)

    def plan(self, case: Case, parameters: GSensitivityParameters) -> Plan:
        """Return the acquisition of one mounting."""
        return Plan(
            warm_up_s=warm_up_s(case),
            interval_s=case.interval.to("s"),
            steps=steps_of(case, parameters),
            auxiliary=(ENCODER,),
            placements=parameters.mounted,
        )

    def reduce(self, samples: Samples, context: Context) -> Reduction:
        """Return results and figures of one mounting; raises `InsufficientDataError`."""
        found = mounting_record(samples, context)
        results = mounting_results(found, context)
        return Reduction(
            results=results.results,
            figures=mounting_figures(found, results),
            remarks=tuple(mounting_remarks(found)),
        )

    def reduce_repeats(self, repeats: tuple[tuple[Result, ...], ...], context: Context) -> Reduction:
        """Return the coefficients from all mountings; raises `InsufficientDataError`."""
        other_name = context.parameters.compare_with
        found = mountings_of(repeats, context)
        results = tuple(combined_results(found))
        others = {} if other_name is None else other_coefficients(other_name, context)
        if other_name is not None:
            results = (*results, *comparison_results(results, other_name, context))
        return Reduction(
            results=results,
            figures=combined_figures(found, results, others, other_name or ""),
        )
