"""Slow lines: a sine in the slow part of a record, as an air conditioner's cycle leaves it.

They lie below what Welch's method resolves. Left in, one of them makes the slow modes contradict the
short averaging times, and the record seems to have hardly any noise that a model describes.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.slow_modes import SlowModes
from gyrotest.analysis.spectral_lines import Excess

_MOST = 8
_FIRST_MODE = 6
"""Three periods: what has fewer is a drift."""

_FEWEST_MODES = 40
_NEIGHBOURS = 16
_STANDS_OUT = 60.0
_WORTH_A_LOOK = 25.0
_MEDIAN = 0.4549364231195724
"""Median of chi-square of one degree of freedom."""

_AGAIN = 2
_AROUND = np.arange(-4.0, 5.0)
_CLOSER = (0.25, 0.1, 0.04, 0.016, 0.006, 0.0024, 0.001)


def take_slow_lines(
    modes: SlowModes, course_dps: NDArray[np.float64]
) -> tuple[SlowModes, tuple[Excess, ...]]:
    """Take the slow lines out of a record's modes, and return them too.

    Parameters
    ----------
    modes
        Of the record.
    course_dps
        The modes (m,) of its drift, where one was recognised; else zeros.
    """
    lines: list[Excess] = []
    left = modes.mode_dps - course_dps
    while left.size >= _FEWEST_MODES and len(lines) < _MOST:
        sine = _strongest(modes, left)
        if sine is None:
            break
        left = left - sine.modes_dps
        lines.append(sine.line(modes.duration_s))
    return replace(modes, mode_dps=left + course_dps), tuple(lines)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Sine:
    """A sine of `order` half periods over the record: its amplitudes (2,) and their covariance (2, 2)."""

    order: float
    waves: NDArray[np.float64]
    amplitudes: NDArray[np.float64]
    covariance: NDArray[np.float64]
    explained: float

    @property
    def modes_dps(self) -> NDArray[np.float64]:
        """Its modes (m,)."""
        modes: NDArray[np.float64] = self.amplitudes @ self.waves
        return modes

    def line(self, duration_s: float) -> Excess:
        """Return it as a spectral line."""
        power = float(self.amplitudes @ self.amplitudes) / 2.0
        by_chance = float(np.sqrt(self.amplitudes @ self.covariance @ self.amplitudes))
        # A mean square over no whole number of periods depends on the phase.
        by_phase = power / (2.0 * np.pi * self.order)
        return Excess(
            frequency_hz=np.array([self.order / (2.0 * duration_s)]),
            power=np.array([power]),
            standard_uncertainty=float(np.hypot(by_chance, by_phase)),
        )


def _strongest(modes: SlowModes, left: NDArray[np.float64]) -> _Sine | None:
    """Find the sine that explains most of chi-square; None if that is not enough.

    Its leakage raises the floor about it: so it is fitted again over the floor that it leaves.
    """
    floor = _floor(left)
    above = left**2 / floor
    above[: _FIRST_MODE - 1] = 0.0
    if float(above.max()) < _WORTH_A_LOOK:
        return None
    sine = _fitted(modes, left, floor, float(np.argmax(above) + 1))
    for _ in range(_AGAIN):
        sine = _fitted(modes, left, _floor(left - sine.modes_dps), sine.order)
    return sine if sine.explained >= _STANDS_OUT else None


def _fitted(
    modes: SlowModes, left: NDArray[np.float64], floor: NDArray[np.float64], order: float
) -> _Sine:
    """Fit a sine of an order near that which is given, by ever closer ones."""
    sine = _at(modes, left, floor, order)
    for reach in _CLOSER:
        around = sine.order + reach * _AROUND
        sine = max(
            (_at(modes, left, floor, float(one)) for one in around), key=lambda one: one.explained
        )
    return sine


def _at(modes: SlowModes, left: NDArray[np.float64], floor: NDArray[np.float64], order: float) -> _Sine:
    waves = _waves(modes, order)
    weighted = waves / floor
    covariance: NDArray[np.float64] = np.asarray(np.linalg.inv(weighted @ waves.T), dtype=np.float64)
    amplitudes = covariance @ (weighted @ left)
    return _Sine(
        order=order,
        waves=waves,
        amplitudes=amplitudes,
        covariance=covariance,
        explained=float(amplitudes @ weighted @ left),
    )


def _waves(modes: SlowModes, order: float) -> NDArray[np.float64]:
    """Return the modes (2, m) of a cosine and a sine of `order` half periods over the record, as block means."""
    middles = np.pi * order * (np.arange(modes.blocks) + 0.5) / modes.blocks
    mean = float(np.sinc(order / (2.0 * modes.blocks)))
    return modes.of_course(np.asarray(mean * np.vstack((np.cos(middles), np.sin(middles)))))


def _floor(left: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return each mode's variance by its neighbours' median, on the high side where it falls steeply."""
    order = np.arange(1.0, left.size + 1.0)
    return (
        np.maximum(_running_median(left**2), _running_median((left * order) ** 2) / order**2) / _MEDIAN
    )


def _running_median(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the median of each value's neighbours, as many on either side as there are before it."""
    padded = np.pad(values, _NEIGHBOURS, mode="reflect")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * _NEIGHBOURS + 1)
    medians: NDArray[np.float64] = np.median(windows, axis=1)
    for place in range(_NEIGHBOURS):
        reach = max(place, 2)
        medians[place] = np.median(values[max(place - reach, 0) : place + reach + 1])
    return medians
