"""Rate noise of a gyro that averages without gaps: the same processes as in `noise`, many at once.

Fast processes are drawn exactly from sample to sample. A process whose time constant is many samples long
is drawn exactly at points that lie at least sixteen to a time constant, and goes straight between them: what it
does in between is less than a hundredth of what the faster processes do there.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.simulation.noise import NoiseDensities, RateNoise, processes

_CHUNK = 4096
# So many samples lie between two points of a process, at most.
_SPANS = (4096, 512, 64, 8)
_POINTS_A_TIME_CONSTANT = 16.0
_WALK_SPAN = 8
# What is left of a state is no longer seen.
_FORGOTTEN = 1e-18


@dataclass(frozen=True, slots=True, kw_only=True)
class _Group:
    """Processes whose points lie `span` samples apart: their places among all, decay and drive a span."""

    span: int
    places: NDArray[np.intp]
    decay: NDArray[np.float64]
    drive: NDArray[np.float64]


class StreamNoise:
    """Means over successive intervals, in the same order however many are taken at a time."""

    def __init__(
        self,
        densities: NoiseDensities,
        source: np.random.Generator,
        *,
        interval_s: float,
        since_power_on_s: float,
    ) -> None:
        tau_s, self._variance = processes(densities)
        self._tau_s = np.append(tau_s, np.inf)
        self._walk = densities.rate_random_walk_dps_per_sqrt_s
        self._source = source
        self._interval_s = interval_s
        spans = np.array([_span(one, interval_s) for one in tau_s] + [_WALK_SPAN])
        self._fast = np.flatnonzero(spans == 1)
        self._step = RateNoise.step(densities, 0.0, interval_s).of(self._fast)
        self._groups = tuple(
            _Group(
                span=span,
                places=np.flatnonzero(spans == span),
                decay=np.exp(-span * interval_s / self._tau_s[spans == span]),
                drive=self._spread(span * interval_s)[spans == span],
            )
            for span in _SPANS
            if (spans == span).any()
        )
        self._buffer: NDArray[np.float64] = np.empty(0)
        self._used = 0
        self._state = self._spread(since_power_on_s) * source.standard_normal(self._tau_s.size)

    def take(self, count: int) -> NDArray[np.float64]:
        """The next means, (count,), deg/s; a view that the caller does not change."""
        left = self._buffer.size - self._used
        if count > left:
            parts = [self._buffer[self._used :]]
            parts += [self._chunk() for _ in range(-(-(count - left) // _CHUNK))]
            self._buffer, self._used = np.concatenate(parts), 0
        taken = self._buffer[self._used : self._used + count]
        self._used += count
        return taken

    def skip(self, count: int) -> None:
        """Leave out so many means."""
        left = self._buffer.size - self._used
        if count <= left:
            self._used += count
            return
        self._buffer, self._used = np.empty(0), 0
        gap_s = (count - left) * self._interval_s
        drawn = self._source.standard_normal(self._tau_s.size)
        self._state = np.exp(-gap_s / self._tau_s) * self._state + self._spread(gap_s) * drawn

    def _spread(self, gap_s: float) -> NDArray[np.float64]:
        """Standard deviations of the states after a gap that they enter as known, (processes,)."""
        settled = self._variance * -np.expm1(-2.0 * gap_s / self._tau_s[:-1])
        return np.asarray(np.sqrt(np.append(settled, self._walk**2 * gap_s)))

    def _chunk(self) -> NDArray[np.float64]:
        means = self._fast_means()
        for group in self._groups:
            means += self._straight(group).ravel()
        return means

    def _fast_means(self) -> NDArray[np.float64]:
        """The fast processes' means, exactly: `noise` has the equations."""
        step, fast = self._step, self._fast
        normals = self._source.standard_normal((fast.size + 1, _CHUNK))
        drive = normals[:-1]
        after = step.drive[:, None] * drive
        _accumulate(after, step.decay, self._state[fast])
        before = np.empty_like(after)
        before[:, 0], before[:, 1:] = self._state[fast], after[:, :-1]
        self._state[fast] = after[:, -1]
        return np.asarray(step.from_state @ before + step.from_drive @ drive + step.rest * normals[-1])

    def _straight(self, group: _Group) -> NDArray[np.float64]:
        """The sum of a group's processes, straight from point to point, (spans, samples of a span)."""
        spans = _CHUNK // group.span
        after = group.drive[:, None] * self._source.standard_normal((group.places.size, spans))
        _accumulate(after, group.decay, self._state[group.places])
        points = np.append(self._state[group.places].sum(), after.sum(axis=0))
        self._state[group.places] = after[:, -1]
        share = (np.arange(group.span) + 0.5) / group.span
        rise = points[1:] - points[:-1]
        return np.asarray(points[:-1, None] + rise[:, None] * share)


def _accumulate(
    after: NDArray[np.float64], decay: NDArray[np.float64], state: NDArray[np.float64]
) -> None:
    """Turn innovations, (processes, n), into states in place: `x ← decay·x + innovation` by doubling."""
    after[:, 0] += decay * state
    reach, factor = 1, decay.copy()
    while reach < after.shape[1]:
        alive = np.flatnonzero(np.abs(factor) > _FORGOTTEN)
        if alive.size == 0:
            return
        # Time constants rise, so that those still alive are the last ones.
        rest = slice(int(alive[0]), None)
        after[rest, reach:] += factor[rest, None] * after[rest, :-reach]
        reach, factor = 2 * reach, factor * factor


def _span(tau_s: float, interval_s: float) -> int:
    """How many samples the points of a process lie apart."""
    longest = tau_s / (_POINTS_A_TIME_CONSTANT * interval_s)
    return next((span for span in _SPANS if span <= longest), 1)
