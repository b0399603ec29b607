"""An encoder's signals in quadrature as an angle."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.ellipse import Ellipse, EllipseFit, Vector
from gyrotest.errors import InsufficientDataError

__all__ = ["AngleTrack", "Decoder", "Ellipse", "EllipseFit", "required_rate_hz"]

SAMPLES_A_LINE = 6.0
"""Samples that a line takes at least: a step of phase is a sixth of a turn at most."""

_LARGEST_STEP = 2.0 * math.pi / SAMPLES_A_LINE
_SUSTAINED = 0.75 * _LARGEST_STEP
_WEAKEST, _STRONGEST = 0.5, 1.5
_CARRIED = 3
_TURN_DEG = 360.0
_MOST_ANGLE_STEP_DEG = 90.0
_LEAP_SIGMAS = 30.0
_LEAP_STEPS = 4.0


def required_rate_hz(fastest_dps: float, lines: int) -> float:
    """Return the least sampling rate for a rate of turn, Hz: six samples a line (S4.1)."""
    return SAMPLES_A_LINE * abs(fastest_dps) * lines / _TURN_DEG


@dataclass(slots=True)
class _Faults:
    """What was wrong with the signals: how often, and where it began, counted in samples of the stretch."""

    weak: int = 0
    leaps: int = 0
    first: int | None = None

    def note(self, place: int) -> None:
        """Keep the place of the first one."""
        self.first = place if self.first is None else min(self.first, place)

    def complaint(self) -> str:
        """Say what was found; empty where nothing was."""
        found = []
        if self.weak:
            found.append(f"the encoder's signal is lost in {self.weak} samples")
        if self.leaps:
            found.append(f"its angle leaps {self.leaps} times from one sample to the next")
        if not found:
            return ""
        return (
            f"{', and '.join(found)}, first at sample {self.first} of the stretch: lines may be lost or counted"
            " twice; clean the grating, look at the cables and whether samples are missing"
        )


class Decoder:
    """Two signals in quadrature as an unwrapped angle, block by block.

    Parameters
    ----------
    ellipse
        How the signals depart from a sine and a cosine.
    lines
        Lines of the grating in a turn.
    rate_hz
        Sampling rate.
    reversed_
        Whether the angle grows while the phase falls.

    Notes
    -----
    S4.1: φ = atan2(sine, cosine) of the corrected signals, less the error within a line where that is known,
    unwrapped; θ = φ/M. A step of more than a sixth
    of a turn of phase from sample to sample breaks the rule f_s ≥ 6·ω_max·M/360°. Where the corrected
    vector's length is not within ½ … 1½ the signal is lost. A single step that differs from both its
    neighbours by more than a sixth of a turn is a leap.
    """

    def __init__(self, ellipse: Ellipse, *, lines: int, rate_hz: float, reversed_: bool = False) -> None:
        self._ellipse = ellipse
        self._lines, self._rate_hz = lines, rate_hz
        self._deg_per_radian = (-1.0 if reversed_ else 1.0) * _TURN_DEG / (2.0 * math.pi * lines)
        self._fastest = 0.0
        self.reset()

    @property
    def fastest_dps(self) -> float:
        """The greatest rate met so far, °/s, from sample to sample: the signals' noise is in it."""
        return self._fastest * abs(self._deg_per_radian) * self._rate_hz

    def reset(self) -> None:
        """Begin a new stretch: the angle begins anew, between −180° and 180° of phase."""
        self._carried = np.empty((2, 0))
        self._turns = 0.0
        self._seen = 0
        self._faults = _Faults()

    def push(self, sine: NDArray[np.float64], cosine: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the angle (n,), °, which goes on from push to push.

        Raises
        ------
        InsufficientDataError
            The table turned faster than the sampling follows; the message has both rates.
        """
        carried = self._carried.shape[1]
        sine, cosine = (
            np.concatenate((kept, new)) for kept, new in zip(self._carried, (sine, cosine), strict=True)
        )
        if sine.size == carried:
            return np.empty(0)
        vector = self._ellipse.corrected(sine, cosine)
        phase = np.arctan2(vector.sine, vector.cosine)
        if self._ellipse.line_error is not None:
            phase -= self._ellipse.line_error.at(vector.sine, vector.cosine)
        steps = np.diff(phase)
        turns = np.rint(steps / (2.0 * math.pi))
        steps -= 2.0 * math.pi * turns
        self._look(vector, steps, carried)
        turns[: max(carried - 1, 0)] = 0.0
        counted = self._turns + np.concatenate(([0.0], np.cumsum(turns)))
        self._turns = float(counted[-1])
        self._carried = np.stack((sine[-_CARRIED:], cosine[-_CARRIED:]))
        self._seen += phase.size - carried
        unwrapped: NDArray[np.float64] = phase - 2.0 * math.pi * counted
        return unwrapped[carried:] * self._deg_per_radian

    def check(self) -> None:
        """Raise `InsufficientDataError` where this stretch lost the signal or leapt, saying how often."""
        complaint = self._faults.complaint()
        if complaint:
            raise InsufficientDataError(complaint)

    def _look(self, vector: Vector, steps: NDArray[np.float64], carried: int) -> None:
        """Count what is wrong: of the samples the new ones, of the steps those with two neighbours."""
        weak, first = _weak(vector), self._seen - carried
        new = weak[weak >= carried]
        if new.size:
            self._faults.weak += int(new.size)
            self._faults.note(first + int(new[0]))
        sizes = np.abs(steps)
        if weak.size:
            at = np.concatenate((weak - 1, weak))  # the steps to and from a lost sample say nothing
            sizes[at[(at >= 0) & (at < sizes.size)]] = 0.0
        if sizes.size > 2 and float(sizes[1:-1].max()) > _SUSTAINED:
            leaps = _leaps(steps, sizes)
            sizes[leaps] = 0.0
            if leaps.size:
                self._faults.leaps += int(leaps.size)
                self._faults.note(first + int(leaps[0]) + 1)
        self._fastest = max(self._fastest, float(sizes[1:-1].max(initial=0.0)))
        if self._fastest > _LARGEST_STEP:
            self._refuse_starved()

    def _refuse_starved(self) -> None:
        fastest_dps = self.fastest_dps
        raise InsufficientDataError(
            f"the encoder is starved of samples: at {fastest_dps:.6g} °/s (ω_max) its {self._lines} lines (M) need"
            f" {required_rate_hz(fastest_dps, self._lines):.6g} Hz (6·ω_max·M/360°), and it is sampled at"
            f" {self._rate_hz:.6g} Hz; sample faster, or move the table more slowly"
        )


def _weak(vector: Vector) -> NDArray[np.intp]:
    """Return where the vector's length is that of no signal."""
    squares = vector.sine * vector.sine + vector.cosine * vector.cosine
    if squares.min() >= _WEAKEST**2 and squares.max() <= _STRONGEST**2:
        return np.empty(0, dtype=np.intp)
    return np.flatnonzero(~((squares >= _WEAKEST**2) & (squares <= _STRONGEST**2)))


def _leaps(steps: NDArray[np.float64], sizes: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return which steps stand alone: both neighbours agree with each other and not with it."""
    before, step, after = steps[:-2], steps[1:-1], steps[2:]
    alone = (
        (np.abs(step - (before + after) / 2.0) > _LARGEST_STEP)
        & (np.abs(after - before) < _LARGEST_STEP)
        & (sizes[1:-1] > 0.0)
        & (np.maximum(np.abs(before), np.abs(after)) < _SUSTAINED)
    )
    return np.flatnonzero(alone) + 1


class AngleTrack:
    """The angle of an encoder that gives it, unwrapped, block by block."""

    def __init__(self, *, rate_hz: float, reversed_: bool = False) -> None:
        self._rate_hz, self._sign = rate_hz, -1.0 if reversed_ else 1.0
        self._fastest_dps = 0.0
        self.reset()

    @property
    def fastest_dps(self) -> float:
        """The greatest rate met so far, °/s, from sample to sample: the last digit's steps are in it."""
        return self._fastest_dps

    def reset(self) -> None:
        """Begin a new stretch."""
        self._carried = np.empty(0)
        self._turns = 0.0
        self._seen = 0
        self._faults = _Faults()

    def push(self, angle_deg: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the angle (n,), °, without its leaps by a whole turn; raises `InsufficientDataError`."""
        carried = self._carried.size
        angle = np.concatenate((self._carried, angle_deg))
        if angle.size == carried:
            return np.empty(0)
        steps = np.diff(angle)
        turns = np.rint(steps / _TURN_DEG)
        steps -= _TURN_DEG * turns
        self._look(steps, carried)
        turns[: max(carried - 1, 0)] = 0.0
        counted = self._turns + np.concatenate(([0.0], np.cumsum(turns)))
        self._turns = float(counted[-1])
        self._carried = angle[-_CARRIED:]
        self._seen += angle.size - carried
        unwrapped: NDArray[np.float64] = self._sign * (angle - _TURN_DEG * counted)
        return unwrapped[carried:]

    def check(self) -> None:
        """Raise `InsufficientDataError` where this stretch leapt, saying how often."""
        complaint = self._faults.complaint()
        if complaint:
            raise InsufficientDataError(complaint)

    def _look(self, steps: NDArray[np.float64], carried: int) -> None:
        largest = float(np.abs(steps).max(initial=0.0))
        self._fastest_dps = max(self._fastest_dps, largest * self._rate_hz)
        if largest > _MOST_ANGLE_STEP_DEG:
            raise InsufficientDataError(
                f"the encoder's angle changes by {largest:.4g}° from one sample to the next: it is lost, or"
                f" sampled too slowly at {self._rate_hz:.6g} Hz; sample faster, or look at its cables"
            )
        leaps = _angle_leaps(steps)
        if leaps.size:
            self._faults.leaps += int(leaps.size)
            self._faults.note(self._seen - carried + int(leaps[0]) + 1)


def _angle_leaps(steps: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return which steps stand alone, far beyond how much steps differ from their neighbours."""
    before, step, after = steps[:-2], steps[1:-1], steps[2:]
    departure = np.abs(step - (before + after) / 2.0)
    moving = np.abs(steps[steps != 0.0])
    if not departure.size or not moving.size:
        return np.empty(0, dtype=np.intp)
    rms = float(np.sqrt(np.mean(departure**2)))
    least = max(_LEAP_SIGMAS * rms, _LEAP_STEPS * float(np.median(moving)))
    return np.flatnonzero((departure > least) & (np.abs(after - before) < departure)) + 1
