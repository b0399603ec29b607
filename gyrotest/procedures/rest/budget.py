"""The uncertainty budget of the bias (GUM, JCGM 100): what contributes, and what could not be had."""

from collections.abc import Iterator

from gyrotest.analysis.mean import mean_uncertainty
from gyrotest.analysis.noise import NoiseModel
from gyrotest.analysis.resolution import mean_half_width
from gyrotest.procedures.case_plan import since_power_on_s
from gyrotest.procedures.earth import of_earth
from gyrotest.procedures.meter import meter_contributions, missing_of_meter
from gyrotest.procedures.rest.record import RestRecord
from gyrotest.procedures.uncertainty import by_statistics, rectangular
from gyrotest.procedures.wording import plain, rate_text
from gyrotest.records.plan import Context
from gyrotest.records.result import Contribution

_MATTERS = 1.7e-3
"""Half a step over the noise, below which it adds nothing to it."""


def bias_budget(
    record: RestRecord, model: NoiseModel, mean_dps: float, share_dps: float | None, context: Context
) -> tuple[Contribution, ...]:
    """Return every contribution to the uncertainty of a bias, in °/s."""
    first = _statistical(record, model, context)
    return (
        first,
        *meter_contributions(
            context,
            record.sampling,
            record.scaling,
            slope=record.scaling.scale_factor,
            indication=mean_dps * record.scaling.scale_factor + record.scaling.zero,
        ),
        *_of_steps(record, first.standard_uncertainty),
        *_of_scale_factor(mean_dps, context),
        of_earth(share_dps),
    )


def missing_contributions(record: RestRecord, context: Context) -> Iterator[str]:
    """Give what could not be had of the budget of a bias."""
    yield from missing_of_meter(context, record.sampling)
    if context.output.scale_factor_uncertainty is None:
        yield "uncertainty of the scale factor"
    if context.since_power_on_s is None:
        yield "drift before the record (time of power-on not known)"


def _statistical(record: RestRecord, model: NoiseModel, context: Context) -> Contribution:
    since_s = since_power_on_s(context) + record.begin_s
    found = mean_uncertainty(model, duration_s=record.duration_s, since_power_on_s=since_s)
    return by_statistics(
        f"noise and drift over {plain(record.duration_s, 6)} s",
        found.standard_uncertainty_dps,
        found.degrees_of_freedom,
    )


def _of_steps(record: RestRecord, noise_dps: float) -> Iterator[Contribution]:
    """Give the steps in which the samples are digitised, where they matter beside the noise."""
    if record.step_dps is None:
        return
    half_dps = mean_half_width(record.step_dps, float(record.rate_dps.std(ddof=1)))
    if half_dps >= _MATTERS * noise_dps:
        source = f"resolution, steps of {rate_text(record.step_dps)}"
        yield rectangular(source, rate_text(half_dps), "1", half_dps)


def _of_scale_factor(mean_dps: float, context: Context) -> Iterator[Contribution]:
    if context.output.scale_factor_uncertainty is not None:
        relative = context.output.scale_factor_uncertainty.to("")
        yield rectangular(
            "scale factor",
            f"{plain(relative * 100.0, 3)} %",
            rate_text(abs(mean_dps), 3),
            abs(mean_dps) * relative,
        )
