"""The procedure: one record at rest a power cycle, its mean the bias of that cycle (S3.6)."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

from gyrotest.analysis.noise import SHORTEST_RECORD, identify_noise
from gyrotest.procedures.bias_repeatability.cycles_figure import cycles_figure
from gyrotest.procedures.bias_repeatability.over_cycles import mean_result
from gyrotest.procedures.case_plan import single_step_plan, step_samples
from gyrotest.procedures.rest.bias import bias_result
from gyrotest.procedures.rest.bias_over_repeats import bias_over_repeats, bias_spread, biases
from gyrotest.procedures.rest.record import rest_record
from gyrotest.procedures.scaling import nominal_complaints
from gyrotest.records.plan import Context, Plan, Reduction
from gyrotest.records.recording import Samples
from gyrotest.records.result import Measurand, Result
from gyrotest.records.spec import Between, Case, Output, Over
from gyrotest.units import Dimension

_FEWEST = 2
ADVISED = 5
"""Power cycles below which the certificate prints a deviation."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BiasRepeatabilityParameters:
    """There are none: what is measured, `duration`, `repeats` and `between_repeats` say."""

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}


class BiasRepeatability:
    """The bias after each of several power cycles, and the spread over them."""

    parameters: type[Any] = BiasRepeatabilityParameters

    def measurands(
        self, case: Case, parameters: BiasRepeatabilityParameters, output: Output
    ) -> tuple[Measurand, ...]:
        """Return the bias of each cycle, and mean and spread over them."""
        del parameters, output
        if case.between_repeats is not Between.POWER_CYCLE or case.repeats < _FEWEST:
            return (_rate("bias", "Bias", "deg/s"),)
        return (
            _rate("bias", "Bias", "deg/s"),
            _rate("bias_repeatability", "Bias repeatability", "deg/h", Over.REPEATS),
            _rate("bias_mean", "Bias, mean over power cycles", "deg/s", Over.REPEATS),
        )

    def complaints(
        self, case: Case, parameters: BiasRepeatabilityParameters, output: Output
    ) -> Iterable[tuple[str, str]]:
        """Give what is wrong with a case beyond its types."""
        del parameters
        yield from nominal_complaints(output)
        if case.between_repeats is not Between.POWER_CYCLE:
            message = (
                "is 'nothing', and bias repeatability is measured over power cycles;"
                " write 'between_repeats: power_cycle'"
            )
            yield "between_repeats", message
        if case.repeats < _FEWEST:
            message = f"{case.repeats} has no spread; write e.g. 'repeats: {ADVISED}', {ADVISED} to 7 are usual"
            yield "repeats", message
        samples = step_samples(case)
        if samples < SHORTEST_RECORD:
            shortest = SHORTEST_RECORD * case.interval.to("s")
            yield (
                "duration",
                f"{samples} samples are too few to tell how well their mean is known;"
                f" {SHORTEST_RECORD} are needed, {shortest:g} s of record",
            )

    def plan(self, case: Case, parameters: BiasRepeatabilityParameters) -> Plan:
        """Return the acquisition of one cycle: after the warm-up, one record at rest."""
        del parameters
        return single_step_plan(case)

    def reduce(self, samples: Samples, context: Context) -> Reduction:
        """Return the bias of one cycle; raises `InsufficientDataError`."""
        record = rest_record(samples, context)
        model = identify_noise(
            record.rate_dps, sample_rate_hz=1.0 / record.interval_s, duty=record.sampling.duty
        )
        return Reduction(results=(bias_result(record, model, context),), remarks=record.remarks)

    def reduce_repeats(self, repeats: tuple[tuple[Result, ...], ...], context: Context) -> Reduction:
        """Return spread and mean over the cycles; raises `InsufficientDataError`."""
        found = biases(repeats, context)
        spread = bias_spread(found, context, unit="deg/s")
        results = (bias_over_repeats(repeats, context), mean_result(found, spread))
        remarks = (
            (f"{spread.count} power cycles: fewer than the {ADVISED} to 7 of the method.",)
            if spread.count < ADVISED
            else ()
        )
        return Reduction(
            results=results, figures=(cycles_figure(found, spread, context),), remarks=remarks
        )


def _rate(name: str, label: str, unit: str, over: Over | None = None) -> Measurand:
    return Measurand(name=name, label=label, dimension=Dimension.RATE, unit=unit, over=over)
