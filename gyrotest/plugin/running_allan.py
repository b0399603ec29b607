"""The Allan deviation of an acquisition that is still running: an indication, never a result."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.accumulator import AllanAccumulator
from gyrotest.analysis.curve import AllanDeviation
from gyrotest.analysis.minimum import FEWEST_FREEDOM, AllanMinimum, allan_minimum
from gyrotest.errors import InsufficientDataError
from gyrotest.records.recording import Block, Sampling

_WARM_UP = 40
_CERTAIN_FREEDOM = 30.0
_NEXT_TO = 1.2  # the curve's averaging times are at most a factor of 1.33 apart
_GAP = "a gap"
_BAD_SAMPLE = "a bad sample"


@dataclass(frozen=True, slots=True, kw_only=True)
class WalkReading:
    """Angle random walk as it is read off the curve: the deviation times the root of the time."""

    tau_s: float
    value_dps_rts: float


@dataclass(frozen=True, slots=True, kw_only=True)
class RunningCurve:
    """A channel's curve so far; `certain` is where it is known to ± 13 % (30 degrees of freedom).

    `lowest` and `walk` are None until enough samples came; `falling` where the lowest point is at the
    longest averaging time that is known well enough to look for it.
    """

    channel: str
    tau_s: NDArray[np.float64]  # (k,)
    deviation_dps: NDArray[np.float64]  # (k,)
    certain: NDArray[np.bool_]  # (k,)
    lowest: AllanMinimum | None
    falling: bool
    walk: WalkReading | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Anew:
    """The curve began anew at a sample, because of what came before it."""

    first: int
    reason: str


class RunningAllan:
    """Curves of all channels, block by block; a gap or a bad sample begins them anew.

    `dps_per_unit` makes a rate of the source's unit; a zero does not matter to a deviation.
    All that is computed is compiled and loaded in the constructor: no block has to wait for it.
    """

    def __init__(self, sampling: Sampling, *, dps_per_unit: float) -> None:
        self._sampling = sampling
        self._factor = abs(dps_per_unit)
        self._anew: Anew | None = None
        self._next = 0
        self._curves: tuple[RunningCurve, ...] | None = None
        self._accumulator = self._empty()
        self._warm_up()

    @property
    def anew(self) -> Anew | None:
        """Where the curves begin, if not with the record."""
        return self._anew

    def push(self, block: Block) -> None:
        """Take in the samples that follow one another without a gap or a bad one."""
        if block.first != self._next:
            self._begin_anew(block.first, _GAP)
        self._next = block.first + len(block.flags)
        values = block.values[:, : len(self._sampling.channels)]
        if block.flags.any() or not np.isfinite(values).all():
            bad = (block.flags != 0) | ~np.isfinite(values).all(axis=1)
            good_from = int(np.flatnonzero(bad)[-1]) + 1
            self._begin_anew(block.first + good_from, _BAD_SAMPLE)
            values = values[good_from:]
        self._take(values)

    def curves(self) -> tuple[RunningCurve, ...]:
        """Compute a curve for each channel; none while there are too few samples, or all the same."""
        if self._curves is None:
            self._curves = self._computed()
        return self._curves

    def _take(self, values: NDArray[np.float64]) -> None:
        self._accumulator.push(values.T * self._factor)
        self._curves = None

    def _begin_anew(self, first: int, reason: str) -> None:
        self._anew = Anew(first=first, reason=reason)
        self._accumulator = self._empty()
        self._curves = None

    def _computed(self) -> tuple[RunningCurve, ...]:
        try:
            found = self._accumulator.result()
        except InsufficientDataError:
            return ()
        if not np.all(found.deviation_dps > 0.0):
            return ()  # steps of a coarse output; they have no place on a logarithmic axis
        return tuple(
            _running(_of_channel(found, place), name)
            for place, name in enumerate(self._sampling.channels)
        )

    def _empty(self) -> AllanAccumulator:
        return AllanAccumulator(1.0 / self._sampling.interval_s)

    def _warm_up(self) -> None:
        noise = np.random.default_rng(0).normal(size=(_WARM_UP, len(self._sampling.channels)))
        self._take(noise)
        self.curves()
        self._accumulator, self._curves = self._empty(), None


def _of_channel(curves: AllanDeviation, place: int) -> AllanDeviation:
    return replace(
        curves,
        deviation_dps=curves.deviation_dps[place],
        edf=curves.edf[place],
        lower_dps=curves.lower_dps[place],
        upper_dps=curves.upper_dps[place],
        noise_type=curves.noise_type[place],
    )


def _running(curve: AllanDeviation, channel: str) -> RunningCurve:
    lowest = allan_minimum(curve, first_tau_s=0.0)
    known_s = curve.tau_s[curve.edf >= FEWEST_FREEDOM]
    return RunningCurve(
        channel=channel,
        tau_s=curve.tau_s,
        deviation_dps=curve.deviation_dps,
        certain=curve.edf >= _CERTAIN_FREEDOM,
        lowest=lowest,
        falling=lowest is not None and lowest.tau_s == known_s[-1],
        walk=_walk(curve),
    )


def _walk(curve: AllanDeviation) -> WalkReading | None:
    """Read it at 1 s, or at the shortest time where that is longer."""
    wanted_s = max(1.0, float(curve.tau_s[0]))
    place = int(np.argmin(np.abs(np.log(curve.tau_s / wanted_s))))
    tau_s = float(curve.tau_s[place])
    if tau_s * _NEXT_TO < wanted_s or curve.edf[place] < FEWEST_FREEDOM:
        return None
    value = float(curve.deviation_dps[place]) * tau_s**0.5  # methods.md: N = σ(τ)·√τ
    return WalkReading(tau_s=tau_s, value_dps_rts=value)
