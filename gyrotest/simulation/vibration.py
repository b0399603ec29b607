"""A simulated angular vibration table: what a drive voltage makes of it, by its own transfer function."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import StationError, UnitError
from gyrotest.records.station import Station
from gyrotest.simulation.figures import Figure, fault, figures_of, given_figures
from gyrotest.simulation.motion import Knots
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.peer import Exciting
from gyrotest.units import Dimension, parse_quantity

TABLE_FIGURES: Mapping[str, Figure] = {
    "low_edge": Figure(Dimension.FREQUENCY, "2 Hz", positive=True),
    "resonance": Figure(Dimension.FREQUENCY, "250 Hz", positive=True),
    "resonance_damping": Figure(Dimension.NUMBER, "20 %", positive=True, pure=True),
}
"""What `simulation.instruments` may say of the table behind a drive, beside the drive's own figures."""
_SENSITIVITY = "20 deg/s/V"
# What was before so many e-foldings of the slowest part is no longer seen.
_FORGOTTEN = 22.0
_KNOTS_HZ, _UNDAMPED_KNOTS_HZ = 8e3, 20e3
_BUTTERWORTH = math.sqrt(0.5)


@dataclass(frozen=True, slots=True, kw_only=True)
class VibrationTable:
    """A table: its rate by the drive voltage where it is flat, and what bounds that range.

    Below the low edge it falls by 40 dB a decade, above its resonance too.
    """

    sensitivity_dps_per_v: float
    low_edge_hz: float = 2.0
    resonance_hz: float = 250.0
    resonance_damping: float = 0.2

    def sections(self, rate_hz: float) -> NDArray[np.float64]:
        """The transfer function from voltage to rate at a sampling rate, as second-order sections, (2, 6)."""
        from scipy.signal import bilinear, butter

        low = butter(2, self.low_edge_hz, btype="highpass", fs=rate_hz, output="sos")
        natural = 2.0 * math.pi * self.resonance_hz
        above, below = bilinear(
            [self.sensitivity_dps_per_v * natural**2],
            [1.0, 2.0 * self.resonance_damping * natural, natural**2],
            fs=rate_hz,
        )
        return np.vstack([low, np.concatenate([above, below])])

    def response(self, frequency_hz: NDArray[np.float64], *, rate_hz: float) -> NDArray[np.complex128]:
        """The table's rate by the drive voltage at frequencies, (n,), deg/s per V."""
        from scipy.signal import freqz_sos

        return np.asarray(freqz_sos(self.sections(rate_hz), frequency_hz, fs=rate_hz)[1])

    @property
    def settling_s(self) -> float:
        """When what was before is no longer seen."""
        return _FORGOTTEN / (2.0 * math.pi * _BUTTERWORTH * self.low_edge_hz)


@dataclass(frozen=True, slots=True, kw_only=True)
class SteadyDrive:
    """A drive that always gives the same sine, of this peak; it has nothing to be drawn."""

    peak_v: float
    frequency_hz: float

    def begin(self, occasion: Occasion) -> None:
        """Nothing to restart."""

    def truth(self) -> Mapping[str, float]:
        """Nothing that could be held against it."""
        return {}

    def drive_v(
        self, first: int, count: int, *, origin_s: float, interval_s: float
    ) -> NDArray[np.float64]:
        """The voltage at `origin_s + (first … first + count - 1) · interval_s`, (count,), V."""
        times_s = origin_s + interval_s * np.arange(first, first + count, dtype=np.float64)
        return np.asarray(self.peak_v * np.sin(2.0 * math.pi * self.frequency_hz * times_s))


class Shaken:
    """The motion of a table that is driven; its angle swings about 0."""

    late_s = 0.0

    def __init__(self, drive: Exciting, table: VibrationTable) -> None:
        self._drive = drive
        self._table = table
        self._origin_s, self._interval_s, self._next = 0.0, 1.0, 0
        self._sections: NDArray[np.float64] = np.empty((0, 6))
        self._state: NDArray[np.float64] = np.empty((0, 2))
        self._angle_deg, self._rate_dps = 0.0, 0.0

    @property
    def settling_s(self) -> float:
        """So long the table swings on."""
        return self._table.settling_s

    def knots_hz(self, *, damped: bool) -> float:
        """So many that the images of 100 Hz at them are below 0.01 %; what is damped does not see them."""
        return _KNOTS_HZ if damped else _UNDAMPED_KNOTS_HZ

    def begin(self, first: int, *, origin_s: float, interval_s: float) -> None:
        """Knots from the time `origin_s + first · interval_s` on come next; the table rests before."""
        self._origin_s, self._interval_s, self._next = origin_s, interval_s, first
        self._sections = self._table.sections(1.0 / interval_s)
        self._state = np.zeros((len(self._sections), 2))
        self._angle_deg, self._rate_dps = 0.0, 0.0

    def take(self, count: int) -> Knots:
        """The next knots."""
        from scipy.signal import sosfilt

        driven_v = self._drive.drive_v(
            self._next, count, origin_s=self._origin_s, interval_s=self._interval_s
        )
        rates_dps, self._state = sosfilt(self._sections, driven_v, zi=self._state)
        # The rate goes straight from knot to knot: its integral is exactly the trapezoids'.
        before_dps = np.concatenate([[self._rate_dps], rates_dps[:-1]])
        steps_deg = 0.5 * self._interval_s * (before_dps + rates_dps)
        steps_deg[0] += self._angle_deg
        angles_deg = np.cumsum(steps_deg)
        self._next += count
        self._angle_deg, self._rate_dps = float(angles_deg[-1]), float(rates_dps[-1])
        return Knots(angle_deg=angles_deg, rate_dps=rates_dps)


def vibration_table(station: Station, drive: str) -> VibrationTable:
    """The table behind a drive, by the driver's settings and `simulation.instruments`.

    Keys that are the drive's own are left to it. Raises `StationError` with all complaints at once.
    """
    settings: Mapping[str, Any] = station.instruments[drive].settings
    given = given_figures(station, drive)
    stated = {name: given[name] for name in TABLE_FIGURES if name in given}
    found = figures_of(stated, TABLE_FIGURES, f"simulation.instruments.{drive}")
    faults = [*found.faults]
    key = f"instruments.{drive}.settings.sensitivity"
    try:
        sensitivity = parse_quantity(
            settings.get("sensitivity", _SENSITIVITY), Dimension.RATE_PER_VOLTAGE
        ).to(Dimension.RATE_PER_VOLTAGE)
    except UnitError as error:
        sensitivity = 0.0
        faults.append(fault(key, str(error)))
    if faults:
        raise StationError(faults)
    return VibrationTable(
        sensitivity_dps_per_v=sensitivity,
        low_edge_hz=found.values["low_edge"],
        resonance_hz=found.values["resonance"],
        resonance_damping=found.values["resonance_damping"],
    )
