"""How far the output stays on the line, each way: step by step, and how certainly."""

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np

from gyrotest.analysis.interval import coverage_factor
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.dwells import DwellRecord, dwell_records
from gyrotest.procedures.full_scale.parameters import FullScaleParameters
from gyrotest.procedures.turns import Turns, turns_of
from gyrotest.records.plan import Context
from gyrotest.records.recording import Samples

_WHOLE = 1e-9
_GROWS = 0.1


class Held(Enum):
    """Whether the output of a step is on the line: it is, it is by its value, it is not by it, it is not."""

    CERTAINLY = 3
    RATHER = 2
    RATHER_NOT = 1
    NOT = 0

    @property
    def on_line(self) -> bool:
        """Whether it is by its value."""
        return self.value >= Held.RATHER.value


@dataclass(frozen=True, slots=True, kw_only=True)
class Reached:
    """A step: its record, how far it is from the line in proportion to full scale, and its expanded uncertainty.

    Both are None of a saturated step; `flat` says that the output did not grow with the rate any more.
    """

    record: DwellRecord
    deviation: float | None
    uncertainty: float | None
    held: Held
    flat: bool

    @property
    def saturated(self) -> bool:
        """Whether the output stands at its limit."""
        return self.deviation is None or self.flat


@dataclass(frozen=True, slots=True, kw_only=True)
class Reach:
    """One way: rates in °/s, positive; 0 where not even the first step is on the line.

    The true end of the range lies between `lower_dps` and `upper_dps`, which is None where the output never
    certainly left the line. `left_at` is the first step beyond.
    """

    steps: tuple[Reached, ...]
    value_dps: float
    lower_dps: float
    upper_dps: float | None
    left_at: Reached | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Reaches:
    """Both ways, the line that they were held against, and the records of all steps."""

    forward: Reach
    backward: Reach
    turns: Turns
    records: tuple[DwellRecord, ...]


def measured_reaches(samples: Samples, context: Context) -> Reaches:
    """Check the dwells, fit the line to the slow ones and follow it; raises `InsufficientDataError`."""
    parameters: FullScaleParameters = context.parameters
    full_scale = context.output.full_scale
    if full_scale is None:
        raise InsufficientDataError(f"{context.case_name}: 'output.full_scale' is not given")
    records = dwell_records(samples, context, rule=parameters.rule, may_saturate=True)
    line_to_dps = parameters.line_to_dps(context.output) * (1.0 + _WHOLE)
    _refuse_saturated_line(records, line_to_dps, context)
    turns = turns_of(
        tuple(one for one in records if not one.saturated), context, line_to_dps=line_to_dps
    )
    limit, scale_dps = parameters.linearity.to(""), full_scale.to("deg/s")
    return Reaches(
        forward=_reach(records, turns, 1.0, limit, scale_dps),
        backward=_reach(records, turns, -1.0, limit, scale_dps),
        turns=turns,
        records=records,
    )


def _refuse_saturated_line(
    records: tuple[DwellRecord, ...], line_to_dps: float, context: Context
) -> None:
    bad = [one for one in records if one.saturated and abs(one.rate_dps) <= line_to_dps]
    if bad:
        raise InsufficientDataError(
            f"{context.case_name}: {bad[0].name}: {bad[0].overloaded + bad[0].railed} of"
            f" {bad[0].dwell.samples} samples are saturated or stuck, and the line is fitted to this step"
        )


def _reach(
    records: tuple[DwellRecord, ...], turns: Turns, sign: float, limit: float, scale_dps: float
) -> Reach:
    own = sorted(
        (one for one in records if one.rate_dps * sign > 0.0), key=lambda one: abs(one.rate_dps)
    )
    steps = tuple(
        _reached(one, before, turns, limit, scale_dps)
        for before, one in zip((None, *own), own, strict=False)
    )
    left_at = next((one for one in steps if not one.held.on_line), None)
    left = next((one for one in steps if one.held is Held.NOT), None)
    return Reach(
        steps=steps,
        value_dps=_last_before(steps, {Held.CERTAINLY, Held.RATHER}),
        lower_dps=_last_before(steps, {Held.CERTAINLY}),
        upper_dps=None if left is None else abs(left.record.rate_dps),
        left_at=left_at,
    )


def _last_before(steps: tuple[Reached, ...], held: set[Held]) -> float:
    """Return the largest rate up to which every step is so held; 0 where the first is not."""
    reached = 0.0
    for one in steps:
        if one.held not in held:
            break
        reached = abs(one.record.rate_dps)
    return reached


def _reached(
    record: DwellRecord,
    before: DwellRecord | None,
    turns: Turns,
    limit: float,
    scale_dps: float,
) -> Reached:
    if record.saturated:
        return Reached(record=record, deviation=None, uncertainty=None, held=Held.NOT, flat=False)
    residual = turns.fit.residuals[_place(record, turns)]
    per = 1.0 / (abs(turns.fit.scale_factor.value) * scale_dps)
    variance = turns.total(residual)
    factor = coverage_factor(variance.degrees_of_freedom, coverage=0.95)
    deviation, uncertainty = residual.value * per, factor * math.sqrt(variance.value) * per
    return Reached(
        record=record,
        deviation=deviation,
        uncertainty=uncertainty,
        held=_held(abs(deviation), uncertainty, limit),
        flat=before is not None and _is_flat(before, record, turns),
    )


def _place(record: DwellRecord, turns: Turns) -> int:
    return next(
        place for place, one in enumerate(turns.turning) if one.dwell.first == record.dwell.first
    )


def _held(size: float, uncertainty: float, limit: float) -> Held:
    if size + uncertainty <= limit:
        return Held.CERTAINLY
    if size - uncertainty > limit:
        return Held.NOT
    return Held.RATHER if size <= limit else Held.RATHER_NOT


def _is_flat(before: DwellRecord, record: DwellRecord, turns: Turns) -> bool:
    """Whether the output grew by less than a tenth of what the line promises."""
    if before.saturated:
        return True
    promised = turns.fit.scale_factor.value * (record.rate_dps - before.rate_dps)
    return bool(np.abs(record.mean - before.mean) < _GROWS * abs(promised))
