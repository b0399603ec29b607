"""The analogue side of a simulated meter: its own errors, its noise, its resolution."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.simulation.faults import Faults
from gyrotest.simulation.signal import Signal
from gyrotest.simulation.streams import Normals

OVERLOAD_V = 9.9e37
RANGES_V = (0.1, 1.0, 10.0, 100.0, 1000.0)
_OVERRANGE = 1.2
_NOISE_NPLC = 10.0
# Share of the range that one digit of the display is, by integration time; a reading that goes
# over the bus carries one digit more.
_RESOLUTION = ((100.0, 3e-7), (10.0, 1e-6), (1.0, 3e-6), (0.2, 1e-5), (0.0, 1e-4))


def resolution(nplc: float) -> float:
    """The display's resolution at an integration time, as a share of the range."""
    return next(share for least, share in _RESOLUTION if nplc >= least)


def fitting_range(voltage_v: float) -> float:
    """The smallest range that holds a voltage, V."""
    return next((one for one in RANGES_V if abs(voltage_v) <= _OVERRANGE * one), RANGES_V[-1])


@dataclass(frozen=True, slots=True, kw_only=True)
class MeterErrors:
    """One meter's own errors: gain (a ratio), offset (a share of the range), rms noise at 10 PLC, V."""

    gain: float
    offset_of_range: float
    noise_v: float


class Converter:
    """Turns a signal's means into readings."""

    def __init__(self, signal: Signal, errors: MeterErrors, normals: Normals, faults: Faults) -> None:
        self._signal = signal
        self._errors = errors
        self._normals = normals
        self._stuck_from_s = faults.stuck_from_s
        self._last_v: float | None = None
        self.faults = faults

    def reading(self, start_s: float, aperture_s: float, *, range_v: float | None, nplc: float) -> float:
        """One reading, V; ±9.9E37 beyond 120 % of the range. Without a range the meter finds one."""
        if start_s >= self._stuck_from_s and self._last_v is not None:
            return self._last_v
        errors = self._errors
        noise_v = errors.noise_v * math.sqrt(_NOISE_NPLC / nplc)
        value = self._signal.mean_voltage(start_s, aperture_s) * (1.0 + errors.gain)
        range_v = fitting_range(value) if range_v is None else range_v
        value += errors.offset_of_range * range_v + noise_v * float(self._normals.take(1)[0])
        if abs(value) > _OVERRANGE * range_v:
            value = math.copysign(OVERLOAD_V, value)
        else:
            digit = 0.1 * resolution(nplc) * range_v
            value = round(value / digit) * digit
        self._last_v = value
        return value

    def readings(
        self,
        start_s: float,
        aperture_s: float,
        spacing_s: float,
        count: int,
        *,
        range_v: float | None,
        nplc: float,
    ) -> NDArray[np.float64]:
        """`count` readings that begin every `spacing_s`, (count,), V."""
        errors = self._errors
        noise_v = errors.noise_v * math.sqrt(_NOISE_NPLC / nplc)
        values = self._signal.mean_voltages(start_s, aperture_s, spacing_s, count) * (1.0 + errors.gain)
        range_v = fitting_range(float(np.abs(values).max())) if range_v is None else range_v
        values += errors.offset_of_range * range_v + noise_v * self._normals.take(count)
        over = np.abs(values) > _OVERRANGE * range_v
        digit = 0.1 * resolution(nplc) * range_v
        values = np.where(over, np.copysign(OVERLOAD_V, values), np.round(values / digit) * digit)
        stuck = start_s + spacing_s * np.arange(count) >= self._stuck_from_s
        if stuck.any():
            first = int(np.argmax(stuck))
            previous = values[first - 1] if first else self._last_v
            values[stuck] = values[first] if previous is None else previous
        self._last_v = float(values[-1])
        return values
