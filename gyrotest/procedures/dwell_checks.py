"""What makes a dwell unfit for a mean: too few samples, bad ones, an output at its limit."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.rails import rail_of
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.recording import Dwell, SampleFlag, Sampling
from gyrotest.units import printed_unit

FEWEST_PRESENT = 0.5
"""Share of a dwell's samples that are needed: what was lost on the way does not bias a mean."""

_MINUS = "\N{MINUS SIGN}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Cut:
    """A dwell's samples as they were recorded, and their positions on the grid."""

    dwell: Dwell
    sampling: Sampling
    values: NDArray[np.float64]
    flags: NDArray[np.uint8]
    places: NDArray[np.int64]

    @property
    def overloaded(self) -> NDArray[np.bool_]:
        """Which samples are flagged as overloads: their values are no readings."""
        overloaded: NDArray[np.bool_] = (self.flags & np.uint8(SampleFlag.OVERLOAD)) != 0
        return overloaded

    def only(self, chosen: NDArray[np.bool_]) -> "Cut":
        """Leave out all others."""
        if chosen.all():
            return self
        return replace(
            self, values=self.values[chosen], flags=self.flags[chosen], places=self.places[chosen]
        )


def refuse_unfit(cut: Cut, context: Context, blur: float, *, may_saturate: bool) -> None:
    """Refuse too few samples, bad ones, and, unless they may, saturated ones."""
    _refuse_few(cut)
    readings = cut.only(~cut.overloaded)
    _refuse_bad(readings)
    if not may_saturate:
        railed = readings.values[rail_of(readings.values, blur=blur)]
        _refuse_saturated(cut, railed, context)


def step_words(dwell: Dwell) -> str:
    """Name a step and its rate, for messages."""
    name = f"step '{dwell.name}'" if dwell.name else "step"
    if dwell.rate_dps is None:
        return name
    return f"{name} at {plain(dwell.rate_dps, 6)} °/s".replace("-", _MINUS)


def full_scale_words(context: Context) -> str:
    """Say what full scale is, as far as the spec says it."""
    full_scale = context.output.full_scale
    return (
        "full scale is not stated in the spec" if full_scale is None else f"full scale is {full_scale}"
    )


def _refuse_few(cut: Cut) -> None:
    count, planned = cut.values.size, cut.dwell.samples
    if count < max(FEWEST_PRESENT * planned, 2):
        raise InsufficientDataError(
            f"{step_words(cut.dwell)}: {count} of {planned} samples are there, the others are missing;"
            " its mean needs at least half of them"
        )


def _refuse_bad(readings: Cut) -> None:
    """Refuse what is flagged otherwise than as an overload, or is no number."""
    bad = (readings.flags != 0) | ~np.isfinite(readings.values)
    if bad.any():
        first = int(np.flatnonzero(bad)[0])
        kinds = ", ".join(_kinds(int(readings.flags[first]))) or "no number"
        raise InsufficientDataError(
            f"{step_words(readings.dwell)}: {int(bad.sum())} of {bad.size} samples are bad, the first of them"
            f" sample {int(readings.places[first])} ({kinds}); a mean needs every sample"
        )


def _kinds(flags: int) -> Iterator[str]:
    for flag in SampleFlag:
        if flags & flag:
            yield str(flag.name).lower().replace("_", " ")


def _refuse_saturated(cut: Cut, railed: NDArray[np.float64], context: Context) -> None:
    overloaded = int(cut.overloaded.sum())
    if overloaded:
        found = f"{overloaded} of {cut.values.size} samples are overloads"
    elif railed.size:
        found = (
            f"{railed.size} of {cut.values.size} samples read"
            f" {_spoken(railed, cut.sampling)}: the output stands at its limit, or is stuck"
        )
    else:
        return
    raise InsufficientDataError(
        f"{step_words(cut.dwell)}: {found} ({full_scale_words(context)}); leave such a rate out, or correct the"
        " range"
    )


def _spoken(railed: NDArray[np.float64], sampling: Sampling) -> str:
    ends = [plain(float(one), 5) for one in (railed.min(), railed.max())]
    return f"{' or '.join(dict.fromkeys(ends))} {printed_unit(sampling.unit)}".replace("-", _MINUS)
