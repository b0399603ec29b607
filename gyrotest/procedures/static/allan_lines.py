"""Straight lines of the Allan plot: limits, datasheet figures, and the meter's own noise."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from gyrotest.analysis.allan import FLAT
from gyrotest.procedures.drawn_units import Unit
from gyrotest.procedures.rest.record import RestRecord
from gyrotest.procedures.static.noise_results import NoiseAnalysis
from gyrotest.procedures.static.terms import ANGLE_WALK, BIAS_INSTABILITY, TERMS, Term
from gyrotest.procedures.wording import plain
from gyrotest.records.figure import Curve, Role
from gyrotest.units import Quantity, printed_unit

_REACH = 3.0  # how far beyond the averaging times that carry a term its lines go, a factor
_ABOVE, _BELOW = 2.0, 0.5  # of the curve's highest and lowest point: beyond, nothing is drawn
_NEAR = 0.35  # of the curve's lowest point: a floor that stays below it would only stretch the axis
_LETTERS = {ANGLE_WALK: "ARW"}
_LEVELS = {"allan_minimum": (1.0, "minimum"), BIAS_INSTABILITY.name: (FLAT, BIAS_INSTABILITY.letter)}
_AS_READ = "angle_random_walk_apparent"


@dataclass(frozen=True, slots=True, kw_only=True)
class Lines:
    """What lines are drawn, and against what: the analysis, and the unit of the deviations.

    `limits` are the greatest values allowed; `folding` is the factor by which dead time makes white
    noise read too large.
    """

    noise: NoiseAnalysis
    rate: Unit
    folding: float
    limits: Mapping[str, Quantity]
    datasheet: Mapping[str, Quantity]

    def drawn(self) -> Iterator[Curve]:
        """Give the greatest values that the case allows, and the datasheet's figures."""
        yield from self._lines(self.limits, Role.LIMIT, "limit")
        if _AS_READ in self.limits and ANGLE_WALK.name not in self.limits:
            yield from self._sloped(ANGLE_WALK, self.limits[_AS_READ], 1.0, Role.LIMIT, "limit")
        yield from self._lines(self.datasheet, Role.DATASHEET, "datasheet")

    def floor(self, record: RestRecord) -> Iterator[Curve]:
        """Give the meter's own white noise, where it is known and not far below the curve."""
        walk = floor_walk(record)
        if walk is not None and not self.floor_is_far_below(record):
            tau = self.noise.overlapping.tau_s[[0, -1]]
            y = tuple((walk / np.sqrt(tau) * self.rate.factor).tolist())
            yield Curve(x=tuple(tau.tolist()), y=y, role=Role.FLOOR, label="meter's own noise")

    def floor_is_far_below(self, record: RestRecord) -> bool:
        """Whether the meter's own noise would only stretch the axis."""
        walk, curve = floor_walk(record), self.noise.overlapping
        highest = 0.0 if walk is None else walk / float(np.sqrt(curve.tau_s[0]))
        return highest < _NEAR * float(curve.deviation_dps.min())

    def _lines(self, given: Mapping[str, Quantity], role: Role, kind: str) -> Iterator[Curve]:
        for name, (share, word) in _LEVELS.items():
            if name in given:
                y = given[name].to("deg/s") * share * self.rate.factor
                yield self._level(y, role, f"{kind} {word} {written(given[name])}")
        for term in TERMS:
            if term.name in given and term.name not in _LEVELS:
                folding = self.folding if term is ANGLE_WALK else 1.0
                yield from self._sloped(term, given[term.name], folding, role, kind)

    def _level(self, y: float, role: Role, label: str) -> Curve:
        tau = self.noise.overlapping.tau_s
        return Curve(x=(float(tau[0]), float(tau[-1])), y=(y, y), role=role, label=label)

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
        counts &= line >= _BELOW * self._lowest_dps()
        if np.count_nonzero(counts) > 1:
            ends = np.flatnonzero(counts)[[0, -1]]
            label = f"{kind} {_LETTERS.get(term, term.letter)} {written(value)}"
            y = tuple((line[ends] * self.rate.factor).tolist())
            yield Curve(x=tuple(tau[ends].tolist()), y=y, role=role, label=label)

    def _lowest_dps(self) -> float:
        """Return the lowest point of the curve and of the level lines."""
        levels = [
            given[name].to("deg/s") * share
            for given in (self.limits, self.datasheet)
            for name, (share, _) in _LEVELS.items()
            if name in given
        ]
        return min([float(self.noise.overlapping.deviation_dps.min()), *levels])


def floor_walk(record: RestRecord) -> float | None:
    """Return the meter's own white noise as an angle random walk, °/√s; None where it is not known."""
    return record.floor_dps * float(np.sqrt(record.interval_s)) if record.floor_dps else None


def written(quantity: Quantity) -> str:
    """Return a quantity as it is printed for people."""
    return f"{plain(quantity.value, 6)} {printed_unit(quantity.unit)}"
