"""Rate noise of a gyro, drawn exactly for any sequence of averaging intervals.

Every kind of noise is a Markov process (Ornstein–Uhlenbeck or Wiener), for which the end state and
the mean over an aperture are jointly Gaussian in closed form. So nothing is stepped finer than the
readings themselves, however far apart or irregular they are.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.simulation.streams import Normals

# Corners of the flicker noise: two a decade keep the ripple of the spectrum below 0.1 %.
_FLICKER_RATIO = math.sqrt(10.0)
_FLICKER_LOWEST_HZ = 3e-7
_CHUNK = 1024
_LOOP = 8
_CACHED = 1024


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseDensities:
    """Noise coefficients as in IEEE 952 Annex C, and the bandwidth of the output.

    One-sided rate densities: `2N²` (angle random walk), `B²/(πf)` (bias instability), `K²/(2π²f²)`
    (rate random walk).
    """

    angle_random_walk_dps_sqrt_s: float
    bias_instability_dps: float
    rate_random_walk_dps_per_sqrt_s: float
    bandwidth_hz: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """Coefficients of one gap followed by one aperture.

    With the state `x` before the gap and normals `z` (one a process, and one more):
    mean = `from_state · x + from_drive · z[:n] + rest · z[n]`, then `x ← decay x + drive z[:n]`.
    `rests` are the variances that make up `rest²`, one a process.
    """

    decay: NDArray[np.float64]
    drive: NDArray[np.float64]
    from_state: NDArray[np.float64]
    from_drive: NDArray[np.float64]
    rest: float
    rests: NDArray[np.float64]

    def of(self, places: NDArray[np.intp]) -> "Step":
        """The same for some of the processes alone."""
        return Step(
            decay=self.decay[places],
            drive=self.drive[places],
            from_state=self.from_state[places],
            from_drive=self.from_drive[places],
            rest=math.sqrt(max(0.0, float(np.sum(self.rests[places])))),
            rests=self.rests[places],
        )


class RateNoise:
    """The random part of a gyro's rate. All of it is zero at power-on."""

    def __init__(
        self, densities: NoiseDensities, normals: Normals, *, since_power_on_s: float, start_s: float
    ) -> None:
        self._tau_s, self._variance = processes(densities)
        self._rate_random_walk = densities.rate_random_walk_dps_per_sqrt_s
        self._normals = normals
        self._width = self._tau_s.size + 1
        self._steps: dict[tuple[float, float], Step] = {}
        self._at_s = start_s
        self._state = np.zeros(self._width)
        self._state = self._gap_spread(since_power_on_s) * normals.take(self._width)

    def mean(self, start_s: float, aperture_s: float) -> float:
        """The mean over one aperture, deg/s; raises `ValueError` if it overlaps the last one."""
        step = self._step(start_s - self._at_s, aperture_s)
        normals = self._normals.take(self._width + 1)
        drive = normals[:-1]
        mean = step.from_state @ self._state + step.from_drive @ drive + step.rest * normals[-1]
        self._state = step.decay * self._state + step.drive * drive
        self._at_s = start_s + aperture_s
        return float(mean)

    def means(
        self, start_s: float, aperture_s: float, spacing_s: float, count: int
    ) -> NDArray[np.float64]:
        """Means over `count` apertures that begin every `spacing_s`, (count,), deg/s."""
        if count <= _LOOP:
            return np.array([self.mean(start_s + k * spacing_s, aperture_s) for k in range(count)])
        means = np.empty(count)
        means[0] = self.mean(start_s, aperture_s)
        step = self._step(spacing_s - aperture_s, aperture_s)
        for first in range(1, count, _CHUNK):
            last = min(first + _CHUNK, count)
            means[first:last] = self._chunk(step, last - first)
        self._at_s = start_s + (count - 1) * spacing_s + aperture_s
        return means

    def _chunk(self, step: Step, count: int) -> NDArray[np.float64]:
        """Means over equal steps: the recursion of the state as a scan in log₂(count) passes."""
        normals = self._normals.take(count * (self._width + 1)).reshape(count, -1)
        drive = normals[:, :-1]
        after = step.drive * drive
        after[0] += step.decay * self._state
        reach, decay = 1, step.decay
        while reach < count:
            after[reach:] += decay * after[:-reach]
            reach, decay = 2 * reach, decay * decay
        before = np.vstack([self._state, after[:-1]])
        self._state = after[-1].copy()
        return np.asarray(
            before @ step.from_state + drive @ step.from_drive + step.rest * normals[:, -1]
        )

    @classmethod
    def step(cls, densities: NoiseDensities, gap_s: float, aperture_s: float) -> Step:
        """The coefficients of one gap followed by one aperture, of all processes in their order."""
        nothing = Normals(np.random.default_rng(0))
        return cls(densities, nothing, since_power_on_s=0.0, start_s=0.0)._new_step(gap_s, aperture_s)

    def _step(self, gap_s: float, aperture_s: float) -> Step:
        key = (round(gap_s, 9), round(aperture_s, 9))
        step = self._steps.get(key)
        if step is None:
            if len(self._steps) >= _CACHED:
                self._steps.clear()
            step = self._steps[key] = self._new_step(*key)
        return step

    def _gap_spread(self, gap_s: float) -> NDArray[np.float64]:
        """Standard deviations of the states after a gap that they enter as known, (n,)."""
        fast = self._variance * -np.expm1(-2.0 * gap_s / self._tau_s)
        return np.asarray(np.sqrt(np.append(fast, self._rate_random_walk**2 * gap_s)), dtype=np.float64)

    def _new_step(self, gap_s: float, aperture_s: float) -> Step:
        if gap_s < 0.0 or aperture_s <= 0.0:
            raise ValueError(f"aperture of {aperture_s} s, {gap_s} s after the last one ended")
        gap_decay = np.append(np.exp(-gap_s / self._tau_s), 1.0)
        gap_variance = self._gap_spread(gap_s) ** 2
        u = aperture_s / self._tau_s
        lost = -np.expm1(-u)
        walk = self._rate_random_walk**2
        decay = np.append(1.0 - lost, 1.0)
        # The mean over the aperture: what it takes over from the state at the aperture's start.
        share = np.append(lost / u, 1.0)
        end_variance = np.append(self._variance * lost * (2.0 - lost), walk * aperture_s)
        covariance = np.append(self._variance * lost**2 / u, walk * aperture_s / 2.0)
        mean_variance = np.append(self._variance * _integral_variance(u) / u**2, walk * aperture_s / 3.0)
        # Both intervals together: the gap's innovation passes into the end and into the mean.
        total_end = decay**2 * gap_variance + end_variance
        total_covariance = decay * share * gap_variance + covariance
        total_mean = share**2 * gap_variance + mean_variance
        drive = np.sqrt(total_end)
        from_drive = np.divide(total_covariance, drive, out=np.zeros_like(drive), where=drive > 0.0)
        return Step(
            decay=gap_decay * decay,
            drive=drive,
            from_state=gap_decay * share,
            from_drive=from_drive,
            rest=math.sqrt(max(0.0, float(np.sum(total_mean - from_drive**2)))),
            rests=total_mean - from_drive**2,
        )


def processes(densities: NoiseDensities) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Time constants, s, and variances, (deg/s)², of the Ornstein–Uhlenbeck processes."""
    bandwidth = densities.bandwidth_hz
    corners = bandwidth / _FLICKER_RATIO ** np.arange(
        math.ceil(math.log(bandwidth / _FLICKER_LOWEST_HZ, _FLICKER_RATIO)) + 1
    )
    # Sum of 4 s² τ/(1 + (2πfτ)²) over corners a factor r apart is s²/(f ln r) = B²/(πf).
    flicker = densities.bias_instability_dps**2 * math.log(_FLICKER_RATIO) / math.pi
    # White noise 2N² through one pole at f_b has the variance 2N²·(π/2)·f_b.
    white = math.pi * bandwidth * densities.angle_random_walk_dps_sqrt_s**2
    tau = 1.0 / (2.0 * math.pi * np.append(bandwidth, corners))
    return tau, np.append(white, np.full(corners.size, flicker))


def _integral_variance(u: NDArray[np.float64]) -> NDArray[np.float64]:
    """`2u − 3 + 4e^(−u) − e^(−2u)`, by its series where the terms would cancel."""
    series = u**3 * (2 / 3 - u * (1 / 2 - u * (7 / 30 - u * (1 / 12 - u * (31 / 1260)))))
    direct = 2.0 * u - 3.0 + 4.0 * np.exp(-u) - np.exp(-2.0 * u)
    return np.where(u < 0.02, series, direct)
