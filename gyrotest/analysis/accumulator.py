"""The Allan deviation of a stream of rate samples, at any time while it runs."""

import threading
from collections.abc import Sequence
from enum import StrEnum
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrotest.analysis.angle import real_samples
from gyrotest.analysis.curve import AllanDeviation, bounded_curve, checked_factors, checked_sample_rate
from gyrotest.analysis.edf import allan_edf
from gyrotest.analysis.stream_sums import BoundedSums, ExactSums, StreamSums
from gyrotest.errors import InsufficientDataError


class Mode(StrEnum):
    """What an accumulator keeps."""

    EXACT = "exact"
    """Twice the longest factor's samples: the result is that of the whole record."""

    BOUNDED = "bounded"
    """16 kB a stream, whatever its length: at long times not every difference is taken."""


class AllanAccumulator:
    """Overlapping Allan deviations of one or more streams, block by block.

    The same samples give the same bits however they are cut into blocks, and results in between change
    nothing. Blocks may be pushed in one thread and results taken in another.

    Parameters
    ----------
    sample_rate_hz
        Samples a second.
    mode
        `"exact"`: for all averaging factors that are given, what `overlapping_allan_deviation` gives of
        the whole record. `"bounded"`: three averaging factors an octave up to a ninth of the samples
        so far. Above 50 samples the differences do not end at every sample, but at 32 to 50
        an averaging time; `edf` allows for it. Its noise types are identified once an octave.
    averaging_factors
        For the exact mode only, and needed there: samples in a group, positive whole numbers.

    Raises
    ------
    ValueError
        A sample rate that is not positive and finite, an unknown mode, or averaging factors that are
        missing, not wanted or no positive whole numbers.

    Notes
    -----
    What it needs is compiled here, on the first use on a machine: a few seconds that no push has to wait.
    """

    def __init__(
        self,
        sample_rate_hz: float,
        *,
        mode: Mode | str = Mode.BOUNDED,
        averaging_factors: Sequence[int] | NDArray[np.int64] | None = None,
    ) -> None:
        checked_sample_rate(sample_rate_hz)
        self._sample_rate_hz = sample_rate_hz
        self._mode = Mode(mode)
        self._factors = self._checked(averaging_factors)
        self._shape: tuple[int, ...] | None = None
        self._sums = self._new(1)
        self._lock = threading.Lock()
        self._sums.prepare()

    @property
    def n_samples(self) -> int:
        """Samples so far, of each stream."""
        return self._sums.samples

    def push(self, block: ArrayLike) -> None:
        """Take in rate samples.

        Parameters
        ----------
        block
            Shape (..., b), °/s: the next b samples of each stream. The leading axes are those of the
            first block.

        Raises
        ------
        InsufficientDataError
            A sample is masked, or not finite; then its place in the stream is named. Nothing was taken in.
        ValueError
            The leading axes differ from the first block's, or the samples are no real numbers.
        """
        samples = np.asarray(real_samples(block), dtype=np.float64)
        with self._lock:
            if samples.shape[:-1] != self._shape or not samples.ndim:
                self._begin(samples)
            rows = samples.reshape(self._sums.streams, -1)
            bad = self._sums.push(np.ascontiguousarray(rows))
            if bad >= 0:
                raise self._refusal(rows, bad)

    def result(self) -> AllanDeviation:
        """Compute the curve of the samples so far.

        Raises
        ------
        InsufficientDataError
            Too few samples: bounded 9, exact twice the shortest factor; or they are all the same, or so
            large that their squares are no numbers.
        """
        with self._lock:
            found = self._sums.variances()
            samples, lead = self._sums.samples, self._shape or ()
        if not np.all(np.isfinite(found.variances)):
            raise InsufficientDataError(
                "the samples are so large that their squares are no numbers any more; is their unit right?"
            )
        types = found.types.reshape(*lead, -1)
        return bounded_curve(
            averaging_factor=found.factors,
            sample_rate_hz=self._sample_rate_hz,
            deviation_dps=np.sqrt(found.variances).reshape(*lead, -1),
            n_differences=found.differences,
            edf=allan_edf(samples + 1, found.factors, types, strides=found.strides),
            noise_type=types,
        )

    def __reduce__(self) -> NoReturn:
        """Refuse: two that share one state would both be wrong."""
        raise TypeError("an accumulator is neither copied nor pickled; take its result, or push to two")

    def _checked(self, factors: Sequence[int] | NDArray[np.int64] | None) -> NDArray[np.int64] | None:
        if self._mode is Mode.EXACT:
            if factors is None:
                raise ValueError("an exact accumulator needs its averaging factors beforehand")
            return checked_factors(factors)
        if factors is not None:
            raise ValueError(
                "a bounded accumulator has its own averaging factors; mode='exact' takes any"
            )
        return None

    def _new(self, streams: int) -> StreamSums:
        return BoundedSums(streams) if self._factors is None else ExactSums(streams, self._factors)

    def _begin(self, block: NDArray[np.float64]) -> None:
        """Take the leading axes of the first block."""
        if self._shape is not None:
            raise ValueError(
                f"the stream began with leading axes {self._shape}; found a block of shape {block.shape}"
            )
        streams = int(np.prod(block.shape[:-1], dtype=int))
        if not block.ndim or not streams:
            raise ValueError(f"a block has shape (..., b) and at least one stream, found {block.shape}")
        self._shape = block.shape[:-1]
        self._sums = self._new(streams)

    def _refusal(self, rows: NDArray[np.float64], bad: int) -> InsufficientDataError:
        row, place = divmod(bad, rows.shape[1])
        axis = f"axis {', '.join(map(str, np.unravel_index(row, self._shape)))}: " if self._shape else ""
        return InsufficientDataError(
            f"{axis}sample {self._sums.samples + place} of the stream is {rows[row, place]};"
            " a number is needed; nothing of this block was taken in"
        )
