"""The bias with its uncertainty budget."""

from gyrotest.analysis.noise import NoiseModel
from gyrotest.procedures.earth import earth_share, earth_words
from gyrotest.procedures.rest.budget import bias_budget, missing_contributions
from gyrotest.procedures.rest.record import RestRecord
from gyrotest.procedures.uncertainty import budgeted_result
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.result import Result


def bias_result(record: RestRecord, model: NoiseModel, context: Context) -> Result:
    """Return the mean rate less the Earth's share, with its budget (GUM, JCGM 100)."""
    mean_dps = float(record.rate_dps.mean())
    share_dps = earth_share(context)
    budget = bias_budget(record, model, mean_dps, share_dps, context)
    return budgeted_result(
        budget,
        name="bias",
        label="Bias",
        value=mean_dps - (share_dps or 0.0),
        unit="deg/s",
        condition=_condition(record, share_dps),
        not_included=tuple(missing_contributions(record, context)),
    )


def _condition(record: RestRecord, share_dps: float | None) -> str:
    parts = (f"mean over {plain(record.duration_s, 6)} s", record.condition, earth_words(share_dps))
    return "; ".join(part for part in parts if part)
