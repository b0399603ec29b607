"""Straight lines of the Allan plot: limits, datasheet figures, and the meter's own noise."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from gyrotest.procedures.static.noise_results import NoiseAnalysis
from gyrotest.procedures.static.record import StaticRecord
from gyrotest.procedures.static.terms import ANGLE_WALK, TERMS, Term
from gyrotest.procedures.static.time_figures import Unit
from gyrotest.procedures.static.wording import plain
from gyrotest.records.figure import Curve, Role
from gyrotest.records.spec import Limit
from gyrotest.units import Quantity, printed_unit

_REACH = 3.0  # how far beyond the averaging times that carry a term its lines go, a factor
_ABOVE, _BELOW = 2.0, 0.5  # of the curve's highest and lowest point: beyond, nothing is drawn
_NEAR = 0.35  # of the curve's lowest point: a floor that stays below it would only stretch the axis
_LETTERS = {ANGLE_WALK: "ARW"}
_MINIMUM = "allan_minimum"
_AS_READ = "angle_random_walk_apparent"


@dataclass(frozen=True, slots=True, kw_only=True)
class Lines:
    """What lines are drawn against: the analysis, the unit of the deviations, and the folding.

    `folding` is the factor by which dead time makes white noise read too large.
    """

    noise: NoiseAnalysis
    rate: Unit
    folding: float

    def limits(self, limits: Mapping[str, Limit]) -> Iterator[Curve]:
        """Give the greatest values that the case allows."""
        highest = {name: one.max for name, one in limits.items() if one.max is not None}
        yield from self._lines(highest, Role.LIMIT, "limit")
        if _AS_READ in highest and ANGLE_WALK.name not in highest:
            yield from self._sloped(ANGLE_WALK, highest[_AS_READ], 1.0, Role.LIMIT, "limit")

    def datasheet(self, datasheet: Mapping[str, Quantity]) -> Iterator[Curve]:
        """Give the datasheet's figures."""
        yield from self._lines(datasheet, Role.DATASHEET, "datasheet")

    def floor(self, record: StaticRecord) -> Iterator[Curve]:
        """Give the meter's own white noise, where it is known and not far below the curve."""
        walk = floor_walk(record)
        if walk is not None and not self.floor_is_far_below(record):
            tau = self.noise.overlapping.tau_s[[0, -1]]
            y = tuple((walk / np.sqrt(tau) * self.rate.factor).tolist())
            yield Curve(x=tuple(tau.tolist()), y=y, role=Role.FLOOR, label="meter's own noise")

    def floor_is_far_below(self, record: StaticRecord) -> bool:
        """Whether the meter's own noise would only stretch the axis."""
        walk, curve = floor_walk(record), self.noise.overlapping
        highest = 0.0 if walk is None else walk / float(np.sqrt(curve.tau_s[0]))
        return highest < _NEAR * float(curve.deviation_dps.min())

    def _lines(self, given: Mapping[str, Quantity], role: Role, kind: str) -> Iterator[Curve]:
        if _MINIMUM in given:
            yield self._level(given[_MINIMUM], role, f"{kind} minimum")
        for term in TERMS:
            if term.name in given:
                folding = self.folding if term is ANGLE_WALK else 1.0
                yield from self._sloped(term, given[term.name], folding, role, kind)

    def _level(self, value: Quantity, role: Role, label: str) -> Curve:
        tau = self.noise.overlapping.tau_s
        y = value.to("deg/s") * self.rate.factor
        return Curve(
            x=(float(tau[0]), float(tau[-1])), y=(y, y), role=role, label=f"{label} {written(value)}"
        )

    def _sloped(
        self, term: Term, value: Quantity, folding: float, role: Role, kind: str
    ) -> Iterator[Curve]:
        """Draw a term's line where the term carries the curve, or would if it were so large."""
        curve, carries = self.noise.overlapping, term.of(self.noise.model).carries
        tau = curve.tau_s
        line = folding * value.to(term.dimension.value) * term.at_1_s * tau**term.slope
        counts = line >= curve.deviation_dps
        if carries is not None:
            counts |= (tau >= carries.first_s / _REACH) & (tau <= carries.last_s * _REACH)
        counts &= line <= _ABOVE * curve.deviation_dps.max()
        counts &= line >= _BELOW * curve.deviation_dps.min()
        if np.count_nonzero(counts) > 1:
            ends = np.flatnonzero(counts)[[0, -1]]
            label = f"{kind} {_LETTERS.get(term, term.letter)} {written(value)}"
            y = tuple((line[ends] * self.rate.factor).tolist())
            yield Curve(x=tuple(tau[ends].tolist()), y=y, role=role, label=label)


def floor_walk(record: StaticRecord) -> float | None:
    """Return the meter's own white noise as an angle random walk, °/√s; None where it is not known."""
    return record.floor_dps * float(np.sqrt(record.interval_s)) if record.floor_dps else None


def written(quantity: Quantity) -> str:
    """Return a quantity as it is printed for people."""
    return f"{plain(quantity.value, 6)} {printed_unit(quantity.unit)}"
