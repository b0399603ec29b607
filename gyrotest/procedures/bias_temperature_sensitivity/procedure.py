"""The procedure: soak, record at rest, next temperature; the bias against the temperature (S3.9)."""

from collections.abc import Iterable, Iterator
from typing import Any

from gyrotest.analysis.interval import NORMAL_95
from gyrotest.procedures.bias_temperature_sensitivity.figure import temperature_figure
from gyrotest.procedures.bias_temperature_sensitivity.parameters import (
    TemperatureParameters,
    same_set_point,
    temperature_complaints,
    temperature_plan,
)
from gyrotest.procedures.bias_temperature_sensitivity.results import (
    DPH,
    UNIT,
    line_of,
    sensitivity_of,
    sensitivity_result,
    slope_result,
)
from gyrotest.procedures.bias_temperature_sensitivity.set_points import (
    SetPoints,
    difference_uncertainty,
    set_points,
)
from gyrotest.procedures.scaling import nominal_complaints
from gyrotest.procedures.step_table import dropped_samples
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context, Plan, Reduction
from gyrotest.records.recording import Samples
from gyrotest.records.result import Measurand, Result
from gyrotest.records.spec import Case, Output
from gyrotest.units import Dimension

_MINUS = "\N{MINUS SIGN}"


class BiasTemperatureSensitivity:
    """How the bias follows the temperature, over soaked set points of a chamber."""

    parameters: type[Any] = TemperatureParameters

    def measurands(
        self, case: Case, parameters: TemperatureParameters, output: Output
    ) -> tuple[Measurand, ...]:
        """Return the sensitivity and the slope."""
        del case, parameters, output
        return tuple(
            Measurand(name=name, label=label, dimension=Dimension.RATE_PER_TEMPERATURE, unit=UNIT)
            for name, label in (
                ("bias_temperature_sensitivity", "Bias, temperature sensitivity"),
                ("bias_temperature_slope", "Bias, slope over temperature"),
            )
        )

    def complaints(
        self, case: Case, parameters: TemperatureParameters, output: Output
    ) -> Iterable[tuple[str, str]]:
        """Give what is wrong with a case beyond its types."""
        yield from nominal_complaints(output)
        yield from temperature_complaints(case, parameters)

    def plan(self, case: Case, parameters: TemperatureParameters) -> Plan:
        """Return the acquisition of one repeat: a record at rest at each set point."""
        return temperature_plan(case, parameters)

    def reduce(self, samples: Samples, context: Context) -> Reduction:
        """Return sensitivity and slope; raises `InsufficientDataError`."""
        points = set_points(samples, context, context.parameters)
        worst, line = sensitivity_of(points, context), line_of(points, context)
        results = (
            sensitivity_result(worst, points, context),
            slope_result(line, points, context),
        )
        return Reduction(
            results=results,
            figures=(temperature_figure(points, worst, line, context),),
            remarks=(*dropped_samples(points.records), *_returns(points)),
        )

    def reduce_repeats(self, repeats: tuple[tuple[Result, ...], ...], context: Context) -> Reduction:
        """Return nothing: each repeat stands for itself."""
        del repeats, context
        return Reduction(results=())


def _returns(points: SetPoints) -> Iterator[str]:
    """Say by how much the bias has changed where a set point was reached again, or that the room never was."""
    if points.visits(points.room) == 1:
        yield (
            "No return to the room temperature: how far the bias wandered by itself meanwhile is known from the"
            " records' own noise only."
        )
    demanded = [one.dwell.temperature_degc or 0.0 for one in points.records]
    for set_point in points.set_degc:
        visits = [place for place, one in enumerate(demanded) if same_set_point(one, float(set_point))]
        if len(visits) > 1:
            first, last = visits[0], visits[-1]
            change = float(points.record_bias_dps[last] - points.record_bias_dps[first]) * DPH
            standard_dps = difference_uncertainty(points.record_covariance, first, last)
            uncertainty = NORMAL_95 * standard_dps * DPH
            yield (
                f"{plain(float(set_point), 4)} °C again: the bias differs by {plain(change, 3)} °/h from that"
                f" of the first time (95 % by noise alone: ± {plain(uncertainty, 2)} °/h)."
            ).replace("-", _MINUS)
