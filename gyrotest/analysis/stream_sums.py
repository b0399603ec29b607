"""What an Allan accumulator keeps of several streams: all that is exact, or all that stays small."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.curve import default_factors
from gyrotest.analysis.kernels import lag, pyramid, stream
from gyrotest.analysis.kernels.chains import add_squares, octave_chains
from gyrotest.analysis.noise_type import identifiable, types_at
from gyrotest.errors import InsufficientDataError

_Array = NDArray[np.float64]
_LEAST_ROOM = 16384
_FIRST_LEVEL = 128


@dataclass(frozen=True, slots=True, kw_only=True)
class Variances:
    """Overlapping Allan variances of c streams at k averaging factors."""

    factors: NDArray[np.int64]  # (k,)
    variances: _Array  # (c, k)
    differences: NDArray[np.int64]  # (k,)
    strides: NDArray[np.int64]  # (k,): differences taken an averaging time
    types: NDArray[np.int8]  # (c, k)


class StreamSums(Protocol):
    """What is kept of c streams of equally many samples."""

    samples: int
    streams: int

    def prepare(self) -> None:
        """Compile what it needs."""

    def push(self, rows: _Array) -> int:
        """Take in samples of shape (c, b); returns the place of one that is not finite, or −1."""

    def variances(self) -> Variances:
        """Compute what can be said now; raises `InsufficientDataError`."""


class ExactSums:
    """The angle back to twice the longest factor; work is done when its room is full."""

    def __init__(self, streams: int, factors: NDArray[np.int64]) -> None:
        longest = int(factors[-1])
        self.samples, self.streams = 0, streams
        self._factors, self._chains = factors, octave_chains(factors)
        self._kept = 2 * longest
        self._points = np.zeros((streams, self._kept + max(longest, _LEAST_ROOM)))
        self._ends = np.zeros((streams, stream.COLUMNS))
        self._sums = np.zeros((streams, factors.size))
        self._lags = np.zeros((streams, factors.size, lag.COLUMNS))
        self._origin, self._worked, self._fill = 0, 1, 1
        self._level_at = _FIRST_LEVEL

    def prepare(self) -> None:
        """Compile what it needs."""
        for kernel in (
            stream.first_not_finite,
            stream.append,
            add_squares,
            lag.add_averages,
            lag.identify,
        ):
            kernel.prepare()

    def push(self, rows: _Array) -> int:
        """Take in samples; the work is cut where the room is full, not where a push ends."""
        bad = stream.first_not_finite(rows)
        if bad >= 0 or not rows.shape[1]:
            return bad
        if not self.samples:
            self._ends[:, stream.OFFSET] = self._ends[:, stream.FIRST] = rows[:, 0]
        place, end = 0, int(rows.shape[1])
        while place < end:
            place += self._take(rows, place)
        return bad

    def variances(self) -> Variances:
        """Compute the variances at all factors that fit twice into the samples."""
        possible = 2 * self._factors <= self.samples
        factors = self._factors[possible]
        if not factors.size:
            raise InsufficientDataError(
                f"averaging {self._factors[0]} samples needs at least {2 * self._factors[0]};"
                f" there are {self.samples} so far"
            )
        if np.any(self._ends[:, stream.UNLIKE] == 0.0):
            raise _no_noise(self.samples)
        sums, lags = self._sums.copy(), self._lags.copy()
        self._work(sums, lags)
        differences = self.samples + 1 - 2 * factors
        known = identifiable(factors, self.samples)
        return Variances(
            factors=factors,
            variances=sums[:, self._chains.place[possible]] / (2.0 * factors**2.0 * differences),
            differences=differences,
            strides=factors,
            types=np.stack([types_at(factors, known, rows[: known.size]) for rows in lags]),
        )

    def _take(self, rows: _Array, begin: int) -> int:
        """Take in what goes on to the next piece of work; returns how much."""
        room = int(self._points.shape[1]) - self._fill
        taken = min(int(rows.shape[1]) - begin, room, self._level_at - self.samples)
        end = begin + taken
        stream.append(rows, begin, end, self.samples, self._points, self._fill, self._ends)
        self._fill += taken
        self.samples += taken
        if self.samples == self._level_at:
            self._level()
        if self._fill == self._points.shape[1]:
            self._work(self._sums, self._lags)
            self._make_room()
        return taken

    def _level(self) -> None:
        slopes = np.zeros((self.streams, 1))
        stream.level(self._points, self._fill, self._origin, slopes, self._ends)
        self._lags[:, :, lag.FIRST] -= slopes * self._factors
        self._level_at *= 2

    def _work(self, sums: _Array, lags: _Array) -> None:
        first, octaves = self._chains.first, self._chains.octaves
        begin, end = self._origin + self._worked - 1, self._origin + self._fill - 1
        for row, points in enumerate(self._points[:, : self._fill]):
            add_squares(points, self._worked, self._fill, first, octaves, sums[row])
            lag.add_averages(points, self._origin, begin, end, self._factors, lags[row])

    def _make_room(self) -> None:
        self._origin += self._fill - self._kept
        self._points[:, : self._kept] = self._points[:, self._fill - self._kept : self._fill].copy()
        self._worked = self._fill = self._kept


class BoundedSums:
    """A state of 16 kB a stream, whatever its length; see `gyrotest.analysis.kernels.pyramid`."""

    def __init__(self, streams: int) -> None:
        self.samples, self.streams = 0, streams
        self._states = np.zeros((streams, pyramid.SIZE))

    def prepare(self) -> None:
        """Compile what it needs."""
        for kernel in (pyramid.push, pyramid.work, lag.identify):
            kernel.prepare()

    def push(self, rows: _Array) -> int:
        """Take in samples."""
        bad = pyramid.push(rows, self._states)
        if bad < 0:
            self.samples += rows.shape[1]
        return bad

    def variances(self) -> Variances:
        """Compute the variances three an octave up to a ninth of the samples."""
        longest = default_factors(self.samples)[-1]
        states = self._states.copy()
        for state in states:
            pyramid.work(state, int(state[pyramid.BEGUN]))
        if np.any(states[:, pyramid.SUMS] == 0.0):
            raise _no_noise(self.samples)
        factors, interval = _pyramid_factors()
        count = np.searchsorted(factors, longest, side="right")
        factors, interval = factors[:count], interval[:count]
        sums = states[:, pyramid.SUMS : pyramid.SUMS + count]
        differences = self.samples // interval - 2 * (factors // interval) + 1
        return Variances(
            factors=factors,
            variances=sums / (2.0 * factors**2.0 * differences),
            differences=differences,
            strides=factors // interval,
            types=np.stack([self._types(factors, state) for state in states]),
        )

    def _types(self, factors: NDArray[np.int64], state: _Array) -> NDArray[np.int8]:
        known = identifiable(2 ** np.arange(pyramid.OCTAVES, dtype=np.int64), self.samples)
        rows = state[pyramid.AVERAGES :].reshape(pyramid.OCTAVES, lag.COLUMNS)
        return types_at(factors, known, rows[: known.size])


def _pyramid_factors() -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return all factors of the pyramid and, for each, how many samples apart its differences are."""
    wider = 2 ** np.arange(1, pyramid.STAGES + 1, dtype=np.int64)
    factors = np.concatenate((pyramid.SHORT, np.multiply.outer(wider, pyramid.LONG).ravel()))
    return factors, np.concatenate((np.ones(len(pyramid.SHORT), dtype=np.int64), np.repeat(wider, 3)))


def _no_noise(samples: int) -> InsufficientDataError:
    return InsufficientDataError(
        f"all {samples} samples of a stream are the same: a constant carries no noise; is the output alive?"
    )
