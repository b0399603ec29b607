"""A vibration table in random motion, and the recordings of a random-vibration case on it."""

import dataclasses
import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrotest.procedures.random_vibration import RandomVibration, RandomVibrationParameters
from gyrotest.records.plan import Context, Reduction
from gyrotest.records.recording import SampleStream
from gyrotest.records.spec import Case
from gyrotest.units import Quantity
from tests.unit.procedures.vibration_bench import (
    RATE_HZ,
    Gyro,
    recorded,
    streamed,
    vibration_context,
)

QUIET = Gyro(scale=0.05, natural_hz=90.0, damping=0.6, delay_s=0.4e-3, noise_v=2e-3)
LEVEL_DPS = 8.0
LOW_HZ, RUN_S = 20.0, 10.0
FREQUENCIES_HZ = (22.5, 40.0, 80.0)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Random:
    """A rate that is random between two frequencies: its lines are as far apart as the record is long."""

    rms_dps: float = LEVEL_DPS
    low_hz: float = LOW_HZ
    high_hz: float = 100.0
    seed: int = 1
    silent_hz: tuple[float, float] | None = None

    def angle_deg(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the table's angle at times."""
        frequency_hz, lines = self._lines(time_s)
        return self._at(time_s, lines / (2j * np.pi * np.where(frequency_hz > 0.0, frequency_hz, 1.0)))

    def output_v(self, gyro: Gyro, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the gyro's output without noise."""
        frequency_hz, lines = self._lines(time_s)
        moved = np.flatnonzero(lines)
        lines[moved] *= [gyro.response(float(one)) for one in frequency_hz[moved]]
        return gyro.zero + self._at(time_s, lines)

    def _lines(self, time_s: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
        frequency_hz = np.fft.rfftfreq(time_s.size, 1.0 / RATE_HZ)
        moves = (frequency_hz >= 0.8 * self.low_hz) & (frequency_hz <= 1.2 * self.high_hz)
        if self.silent_hz is not None:
            moves &= (frequency_hz < self.silent_hz[0]) | (frequency_hz > self.silent_hz[1])
        lines = np.random.default_rng(self.seed).normal(size=(frequency_hz.size, 2)) @ [1.0, 1j]
        lines *= moves
        power = 2.0 * np.sum(np.abs(lines) ** 2) / time_s.size**2
        return frequency_hz, lines * (self.rms_dps / np.sqrt(power))

    def _at(self, time_s: NDArray[np.float64], lines: NDArray[np.complex128]) -> NDArray[np.float64]:
        """Return the sum of the lines, which are those of times that begin at 0."""
        frequency_hz = np.fft.rfftfreq(time_s.size, 1.0 / RATE_HZ)
        return np.fft.irfft(lines * np.exp(2j * np.pi * frequency_hz * time_s[0]), time_s.size)


def case(**changes: Any) -> Case:
    plain = Case(
        procedure="random_vibration", duration=Quantity(RUN_S, "s"), interval=Quantity(0.1, "ms")
    )
    return dataclasses.replace(plain, **changes)


def parameters(**changes: Any) -> RandomVibrationParameters:
    plain = RandomVibrationParameters(
        level=Quantity(LEVEL_DPS, "deg/s"),
        low=Quantity(LOW_HZ, "Hz"),
        rest=Quantity(RUN_S, "s"),
        degree=5,
        flat_to=Quantity(50.0, "Hz"),
        frequencies=tuple(Quantity(one, "Hz") for one in FREQUENCIES_HZ),
    )
    return dataclasses.replace(plain, **changes)


def context(given: RandomVibrationParameters | None = None, **changes: Any) -> Context:
    wanted = given or parameters()
    judged = changes.pop("case", case())
    return vibration_context(judged, wanted, RandomVibration().plan(judged, wanted), **changes)


@functools.lru_cache(maxsize=4)
def runs(gyro: Gyro = QUIET, *, seed: int = 1, count: int = 3, **motion: Any) -> NDArray[np.float64]:
    """Return the columns of a record at rest and of runs."""
    moved = [Random(seed=1000 * seed + number, **motion) for number in range(count)]
    values = recorded([None, *moved], samples=round(RUN_S * RATE_HZ), gyro=gyro, seed=seed)
    values.setflags(write=False)
    return values


def reduced(values: NDArray[np.float64] | SampleStream, given: Context | None = None) -> Reduction:
    stream = values if isinstance(values, SampleStream) else streamed(values)
    return RandomVibration().reduce_stream(stream, given or context())
