"""Samples on a shaft: which were taken while it turned evenly, how they are averaged, what of a turn is there."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.g_sensitivity import Arcs
from gyrotest.analysis.level_shaft import Circle
from gyrotest.analysis.outliers import near_median
from gyrotest.analysis.wandering_fit import Spans

SECTOR_DEG = 30.0
"""The sectors of a turn in each of which there must be samples, both ways."""

_Array = NDArray[np.float64]
_LEAST_OF_SECTOR = 0.3
_EVEN = 0.1
_PIECES = 64
_LEAST_PIECE = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class ShaftSamples:
    """The samples (n,) of one step: output as a rate, angle of the shaft without a jump, and time.

    `time_s` is the middle of each sample. `forward` tells the direction of turning, None: the shaft stands.
    """

    name: str
    output: _Array
    angle_deg: _Array
    time_s: _Array
    interval_s: float
    forward: bool | None = None

    @property
    def rate_dps(self) -> float:
        """The mean rate of turning by the angle, °/s."""
        return _slope(self.time_s, self.angle_deg)

    def only(self, chosen: NDArray[np.bool_]) -> "ShaftSamples":
        """Leave out all others."""
        if chosen.all():
            return self
        return replace(
            self,
            output=self.output[chosen],
            angle_deg=self.angle_deg[chosen],
            time_s=self.time_s[chosen],
        )


def while_even(samples: ShaftSamples) -> ShaftSamples:
    """Leave out run-up and reversal: what lies before and after the rate is within 10 % of its median.

    The rate is that over a 64th of the step, by the measured angle.
    """
    pieces = min(_PIECES, samples.time_s.size // _LEAST_PIECE)
    if samples.forward is None or pieces < _LEAST_PIECE:
        return samples
    ends = np.linspace(0, samples.time_s.size - 1, pieces + 1).astype(np.intp)
    rates = np.diff(samples.angle_deg[ends]) / np.diff(samples.time_s[ends])
    median = float(np.median(rates))
    even = np.flatnonzero(np.abs(rates - median) <= _EVEN * abs(median))
    if not even.size:
        return samples
    chosen = np.zeros(samples.time_s.size, dtype=np.bool_)
    chosen[ends[even[0]] : ends[even[-1] + 1] + 1] = True
    return samples.only(chosen)


def near_the_model(steps: Sequence[ShaftSamples], *, mads: float) -> tuple[NDArray[np.bool_], ...]:
    """Return which samples of each step lie near a first fit, all samples alike: the others are outliers."""
    circles = [Circle.of(one.angle_deg) for one in steps]
    design = np.concatenate(
        [
            np.column_stack(
                (
                    np.ones(one.output.size),
                    circle.cosine,
                    circle.sine,
                    np.full(one.output.size, one.rate_dps),
                )
            )
            for one, circle in zip(steps, circles, strict=True)
        ]
    )
    output = np.concatenate([one.output for one in steps])
    left = output - design @ np.linalg.lstsq(design, output, rcond=None)[0]
    kept = near_median(left, mads=mads)
    return tuple(np.split(kept, np.cumsum([one.output.size for one in steps])[:-1]))


@dataclass(frozen=True, slots=True, kw_only=True)
class ShaftRecord:
    """Averages over arcs of one duration: `values` (m,), where the shaft was, and of which step each one is."""

    values: _Array
    arcs: Arcs
    step: NDArray[np.intp]

    @property
    def angle_deg(self) -> _Array:
        """The middle angle (m,) of each arc, 0 … 360."""
        middle: _Array = np.degrees(np.arctan2(self.arcs.circle.sine, self.arcs.circle.cosine)) % 360.0
        return middle


def averaged(steps: Sequence[ShaftSamples], *, span_s: float) -> ShaftRecord:
    """Average samples over spans as close to a duration as each step allows; gaps shorten a span."""
    parts = [_spans(one, span_s) for one in steps]
    whole = [np.concatenate(columns) for columns in zip(*parts, strict=True)]
    return ShaftRecord(
        values=whole[0],
        arcs=Arcs(
            spans=Spans(begins_s=whole[4] - whole[5] / 2.0, durations_s=whole[5]),
            circle=Circle(cosine=whole[1], sine=whole[2]),
            rate_dps=whole[3],
        ),
        step=np.repeat(np.arange(len(parts)), [one[0].size for one in parts]),
    )


def _spans(samples: ShaftSamples, span_s: float) -> tuple[_Array, ...]:
    """Return mean output, cosine, sine, rate, middle time and duration of each span of a step."""
    begin, end = samples.time_s[0], samples.time_s[-1] + samples.interval_s
    count = max(round(float(end - begin) / span_s), 1)
    place = np.minimum(((samples.time_s - begin) / (end - begin) * count).astype(np.intp), count - 1)
    cuts = np.flatnonzero(np.diff(place, prepend=-1))
    sizes = np.diff(np.append(cuts, place.size))
    circle = Circle.of(samples.angle_deg)

    def mean(values: _Array) -> _Array:
        found: _Array = np.add.reduceat(values, cuts) / sizes
        return found

    middle = mean(samples.time_s)
    away = samples.time_s - np.repeat(middle, sizes)
    square = np.add.reduceat(away**2, cuts)
    slope = np.add.reduceat(away * samples.angle_deg, cuts) / np.where(square > 0.0, square, np.inf)
    if samples.forward is None:
        slope = np.zeros(slope.size)
    return (
        mean(samples.output),
        mean(circle.cosine),
        mean(circle.sine),
        slope,
        middle,
        sizes * samples.interval_s,
    )


def missing_sectors(steps: Sequence[ShaftSamples], *, forward: bool) -> Iterator[tuple[float, float]]:
    """Give the sectors of a turn, from and to in °, in which a direction has too few samples or none."""
    turning = [one.angle_deg for one in steps if one.forward is forward]
    angles = np.concatenate(turning) % 360.0 if turning else np.zeros(0)
    count = round(360.0 / SECTOR_DEG)
    found = np.histogram(angles, bins=count, range=(0.0, 360.0))[0]
    least = _LEAST_OF_SECTOR * float(np.median(found[found > 0])) if angles.size else 1.0
    for place in np.flatnonzero(found < least):
        yield SECTOR_DEG * float(place), SECTOR_DEG * float(place + 1)


def _slope(x: _Array, y: _Array) -> float:
    away = x - x.mean()
    square = float(away @ away)
    return float(away @ y) / square if square > 0.0 else 0.0
