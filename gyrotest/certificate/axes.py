"""Axes: the range that a figure shows, where its ticks stand, and where a value lies on the paper."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrotest.certificate.numbers import plain
from gyrotest.records.figure import Scale

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
_MARGIN = 0.05
_NEARLY = 0.015
_DECADES = 15  # as far down as a logarithmic axis is drawn


@dataclass(frozen=True, slots=True, kw_only=True)
class Tick:
    """A place on an axis; a minor one has no label."""

    value: float
    label: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """A range of values drawn from `begin` to `end`, in points of the paper."""

    scale: Scale
    low: float
    high: float
    begin: float
    end: float
    ticks: tuple[Tick, ...]
    minor: tuple[float, ...] = ()
    exponent: int = 0

    def place(self, values: ArrayLike) -> NDArray[np.float64]:
        """Return where values lie; what a logarithmic axis cannot show lies at its low end."""
        given = np.asarray(values, dtype=np.float64)
        return self.run(given if self.scale is Scale.LINEAR else np.maximum(given, self.low))

    def run(self, values: ArrayLike) -> NDArray[np.float64]:
        """Return where values lie, also beyond the axis's ends."""
        given = np.asarray(values, dtype=np.float64)
        if self.scale is Scale.LINEAR:
            fraction = (given - self.low) / (self.high - self.low)
        else:
            fraction = np.log(given / self.low) / math.log(self.high / self.low)
        return np.asarray(self.begin + fraction * (self.end - self.begin))


def axis(values: Iterable[float], scale: Scale, *, begin: float, end: float, tight: bool) -> Axis:
    """Lay an axis over values; a tight one ends with them, another leaves a margin."""
    numbers = [value for value in values if scale is Scale.LINEAR or value > 0]
    length = abs(end - begin)
    if scale is Scale.LOG:
        low, high = _log_range(numbers)
        ticks, minor = _log_ticks(low, high)
        return Axis(scale=scale, low=low, high=high, begin=begin, end=end, ticks=ticks, minor=minor)
    low, high = _linear_range(numbers, tight=tight)
    step = _step(high - low, length / (42 if begin < end else 15))
    if tight:
        low, high = _to_ticks(low, high, step)
    exponent = _common_exponent(low, high)
    ticks = _linear_ticks(low, high, step, exponent)
    return Axis(scale=scale, low=low, high=high, begin=begin, end=end, ticks=ticks, exponent=exponent)


def times_ten(exponent: int) -> str:
    """The factor that an axis's label is to be read with."""
    return f"10{str(exponent).translate(_SUPERSCRIPTS)}"


def _linear_range(numbers: list[float], *, tight: bool) -> tuple[float, float]:
    low, high = min(numbers, default=0.0), max(numbers, default=1.0)
    if high - low <= 1e-12 * max(abs(low), abs(high)):
        half = abs(low) * 0.1 or 1.0
        return low - half, high + half
    margin = 0.0 if tight else (high - low) * _MARGIN
    # Bars and densities stand on the axis.
    return (0.0 if low == 0 else low - margin), high + margin


def _to_ticks(low: float, high: float, step: float) -> tuple[float, float]:
    """Let an axis that nearly reaches a tick end with it."""
    first, last = math.floor(low / step) * step, math.ceil(high / step) * step
    near = _NEARLY * (high - low)
    return (first if low - first < near else low), (last if last - high < near else high)


def _log_range(numbers: list[float]) -> tuple[float, float]:
    low, high = min(numbers, default=0.1), max(numbers, default=10.0)
    low = max(low, high / 10**_DECADES)
    span = max(math.log10(high / low), 0.3)
    return low / 10 ** (0.03 * span), high * 10 ** (0.03 * span)


def _step(span: float, wanted: float) -> float:
    rough = span / max(wanted, 2.0)
    power = 10.0 ** math.floor(math.log10(rough))
    return next(step * power for step in _STEPS if step * power >= rough * (1 - 1e-9))


def _common_exponent(low: float, high: float) -> int:
    largest = max(abs(low), abs(high))
    power = math.floor(math.log10(largest)) if largest else 0
    return power if power >= 5 or power <= -3 else 0


def _linear_ticks(low: float, high: float, step: float, exponent: int) -> tuple[Tick, ...]:
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    values = [round(index * step, 12 - math.floor(math.log10(step))) for index in range(first, last + 1)]
    shown = [value / 10.0**exponent for value in values]
    decimals = max((len(f"{value:.9g}".partition(".")[2]) for value in shown if value), default=0)
    if any("e" in f"{value:.9g}" for value in shown):
        labels = [plain(one, digits=6) for one in shown]
    else:
        labels = [f"{one:.{decimals}f}".replace("-", "\N{MINUS SIGN}") for one in shown]
    return tuple(Tick(value=value, label=label) for value, label in zip(values, labels, strict=True))


def _log_ticks(low: float, high: float) -> tuple[tuple[Tick, ...], tuple[float, ...]]:
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    decades = math.log10(high / low)
    every = max(1, math.ceil(decades / 9))
    labelled = (1, 2, 5) if decades <= 2.2 else (1,)
    ticks, minor = [], []
    for power in range(first, last + 1):
        for digit in range(1, 10):
            value = digit * 10.0**power
            if not low <= value <= high:
                continue
            if digit in labelled and power % every == 0:
                ticks.append(Tick(value=value, label=_log_label(digit, power)))
            elif every == 1:
                minor.append(value)
    return tuple(ticks), tuple(minor)


def _log_label(digit: int, power: int) -> str:
    if -3 <= power <= 5:
        return plain(digit * 10.0**power)
    return times_ten(power) if digit == 1 else f"{digit}·{times_ten(power)}"
