"""The bias with its uncertainty budget."""

from gyrotest.analysis.earth import earth_share_dps
from gyrotest.analysis.noise import NoiseModel
from gyrotest.procedures.static.budget import bias_budget, missing_contributions
from gyrotest.procedures.static.record import StaticRecord
from gyrotest.procedures.uncertainty import expanded
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.result import Result

_MINUS = "\N{MINUS SIGN}"


def bias_result(record: StaticRecord, model: NoiseModel, context: Context) -> Result:
    """Return the mean rate less the Earth's share, with its budget (GUM, JCGM 100)."""
    mean_dps = float(record.rate_dps.mean())
    share_dps = _earth_share_dps(context)
    budget = bias_budget(record, model, mean_dps, share_dps, context)
    found = expanded(budget)
    return Result(
        name="bias",
        label="Bias",
        value=mean_dps - (share_dps or 0.0),
        unit="deg/s",
        expanded_uncertainty=found.uncertainty,
        coverage_factor=found.factor,
        condition=_condition(record, share_dps),
        budget=budget,
        not_included=tuple(missing_contributions(record, context)),
    )


def _earth_share_dps(context: Context) -> float | None:
    site = context.site
    return earth_share_dps(
        context.case.mounting,
        latitude_deg=None if site is None else site.latitude.to("deg"),
        heading_deg=None if site is None or site.heading is None else site.heading.to("deg"),
    )


def _condition(record: StaticRecord, share_dps: float | None) -> str:
    parts = [f"mean over {plain(record.duration_s, 6)} s", record.condition]
    if share_dps is None:
        parts.append("Earth's rate not subtracted")
    else:
        parts.append(f"Earth's share {plain(share_dps * 3600.0, 3)} °/h subtracted".replace("-", _MINUS))
    return "; ".join(part for part in parts if part)
