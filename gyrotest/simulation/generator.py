"""A simulated waveform generator: what each output has given since when, as voltages at any times."""

import math
import threading
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gyrotest.simulation.generator_noise import BandNoise
from gyrotest.simulation.scpi import ErrorQueue, ScpiError

SINE, NOISE = "SIN", "NOIS"
MOST_HZ = 20e6
LEAST_HZ = 1e-6
LEAST_NOISE_HZ = 1e-3
# Peak to peak of an open circuit, V.
_MOST_VPP, _LEAST_VPP = 20.0, 2e-3
_SOURCE_OHM = 50.0
_LONGEST_LOG_SWEEP_S = 500.0
# Peak to peak by root mean square.
_PP_OF_RMS = {SINE: 2.0 * math.sqrt(2.0), NOISE: 9.2}
_SETTINGS_CONFLICT, _OUT_OF_RANGE = -221, -222
# Grids whose phase differs by a whole number of intervals, but for rounding, count as one.
_ON_GRID = 0.37


@dataclass(frozen=True, slots=True, kw_only=True)
class Wave:
    """The settings of one output; levels in `unit` across a load of `load_ohm`."""

    on: bool = False
    function: str = SINE
    level: float = 0.1
    unit: str = "VPP"
    offset_v: float = 0.0
    load_ohm: float = _SOURCE_OHM
    frequency_hz: float = 1e3
    bandwidth_hz: float = 1e5
    start_hz: float = 100.0
    stop_hz: float = 1e3
    spacing: str = "LIN"
    sweep_s: float = 1.0
    swept: bool = False
    trigger: str = "IMM"

    @property
    def vpp(self) -> float:
        """Peak to peak, V."""
        return self.level * (_PP_OF_RMS[self.function] if self.unit == "VRMS" else 1.0)

    @property
    def rms_v(self) -> float:
        """Root mean square, V."""
        return self.vpp / _PP_OF_RMS[self.function]

    def in_unit(self, unit: str) -> "Wave":
        """The same with its level in another unit."""
        return replace(self, unit=unit, level=self.rms_v if unit == "VRMS" else self.vpp)

    def check(self) -> None:
        """Refuse what cannot be given; raises `ScpiError`."""
        share = load_share(self.load_ohm)
        peak_v = 0.5 * self.vpp + abs(self.offset_v)
        if not _LEAST_VPP * share <= self.vpp or peak_v > 0.5 * _MOST_VPP * share * (1 + 1e-9):
            raise ScpiError(_OUT_OF_RANGE)
        if self.swept and self.function != SINE:
            raise ScpiError(_SETTINGS_CONFLICT)
        if self.spacing == "LOG" and self.sweep_s > _LONGEST_LOG_SWEEP_S:
            raise ScpiError(_SETTINGS_CONFLICT)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Phase:
    """A wave from a moment on. `since_s` is when its sine had the phase 0, `triggered_s` when it was swept."""

    from_s: float
    wave: Wave
    since_s: float
    triggered_s: float = math.inf

    def sine_cycles(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """The sine's phase, cycles, of which a sweep is a part."""
        wave = self.wave
        if not wave.swept:
            return (times_s - self.since_s) * wave.frequency_hz
        if wave.trigger == "IMM":
            whole, part_s = np.divmod(times_s - self.from_s, wave.sweep_s)
            each = _swept_cycles(np.array([wave.sweep_s]), wave)
            before = (self.from_s - self.since_s) * wave.start_hz
            return np.asarray(before + whole * each + _swept_cycles(part_s, wave))
        swept_s = np.clip(times_s - self.triggered_s, 0.0, wave.sweep_s)
        # Before its trigger and after its end it has its first frequency.
        rest_s = times_s - self.since_s - swept_s
        return np.asarray(rest_s * wave.start_hz + _swept_cycles(swept_s, wave))


def _swept_cycles(swept_s: NDArray[np.float64], wave: Wave) -> NDArray[np.float64]:
    span_s, ratio = wave.sweep_s, wave.stop_hz / wave.start_hz
    if wave.spacing == "LOG" and ratio != 1.0:
        growth = math.log(ratio) / span_s
        return np.asarray(wave.start_hz * np.expm1(growth * swept_s) / growth)
    slope = (wave.stop_hz - wave.start_hz) / span_s
    return wave.start_hz * swept_s + 0.5 * slope * swept_s**2


@dataclass(frozen=True, slots=True, kw_only=True)
class _Grid:
    """Samples at `origin_s + (first … first + count - 1) · interval_s`."""

    first: int
    count: int
    origin_s: float
    interval_s: float

    @property
    def times_s(self) -> NDArray[np.float64]:
        """When they are taken, (count,)."""
        steps = np.arange(self.first, self.first + self.count, dtype=np.float64)
        return self.origin_s + self.interval_s * steps

    def between(self, from_s: float, to_s: float) -> "_Grid":
        """Those of them from a time on and before another."""
        start, end = self._not_before(from_s), self._not_before(to_s)
        return replace(self, first=start, count=max(0, end - start))

    def _not_before(self, time_s: float) -> int:
        """The first of them that is not before a time; the one after the last where there is none."""
        last = self.first + self.count
        steps = (time_s - self.origin_s) / self.interval_s
        return last if steps >= last else max(self.first, math.ceil(steps))


@dataclass
class _Record:
    """What the noise depends on: the record's name, and where its first grid of samples begins."""

    seed: int
    names: tuple[str | int, ...]
    origin_s: float | None = None
    noises: dict[tuple[float, float], BandNoise] = field(default_factory=dict)

    def noise(self, bandwidth_hz: float, interval_s: float) -> BandNoise:
        key = (bandwidth_hz, interval_s)
        if key not in self.noises:
            self.noises[key] = BandNoise(
                self.seed, self.names, bandwidth_hz=bandwidth_hz, interval_s=interval_s
            )
        return self.noises[key]

    def position(self, origin_s: float, interval_s: float) -> int:
        """Where a grid begins on that of the record's first samples."""
        if self.origin_s is None:
            self.origin_s = origin_s
        return math.floor((origin_s - self.origin_s) / interval_s + _ON_GRID)


class SimulatedWaveform:
    """One output of the generator, in front of a load; any thread may look at what it has given.

    `gain` is its error, a ratio; from `off_from_s` on it is off, whatever it is told.
    """

    def __init__(self, *, load_ohm: float = math.inf, gain: float = 0.0) -> None:
        self._load_ohm = load_ohm
        self._gain = gain
        self.off_from_s = math.inf
        self._lock = threading.Lock()
        self.wave = Wave()
        self._history: list[_Phase] = []
        self._record = _Record(0, ())

    def begin(self, seed: int, names: tuple[str | int, ...]) -> None:
        """Another record: forget what was given before the present wave, restart the noise."""
        with self._lock:
            self._history = self._history[-1:]
            self._record = _Record(seed, names)

    def set(self, now_s: float, wave: Wave) -> None:
        """Give another wave from now on; raises `ScpiError`, leaving all as it is."""
        wave.check()
        with self._lock:
            before = self.wave
            self.wave = wave
            since_s = now_s
            if self._history and before.on and _same_sine(before, wave):
                since_s = self._history[-1].since_s
            self._history.append(_Phase(from_s=now_s, wave=wave, since_s=since_s))

    def trigger(self, now_s: float) -> bool:
        """Begin a sweep that waits for it; False where none does."""
        with self._lock:
            if not self.wave.swept or self.wave.trigger != "BUS":
                return False
            phase = self._history[-1]
            self._history.append(replace(phase, from_s=now_s, triggered_s=now_s))
            return True

    def is_on(self, now_s: float) -> bool:
        """Whether it gives anything: it may have gone off by itself."""
        return self.wave.on and now_s < self.off_from_s

    def drive_v(
        self, first: int, count: int, *, origin_s: float, interval_s: float
    ) -> NDArray[np.float64]:
        """The voltage across the load at `origin_s + (first … first + count - 1) · interval_s`, (count,), V."""
        grid = _Grid(first=first, count=count, origin_s=origin_s, interval_s=interval_s)
        with self._lock:
            history, record = tuple(self._history), self._record
            position = record.position(origin_s, interval_s)
        volts = np.zeros(count)
        # Before it is told anything there is nothing to begin with.
        ends_s = (*(one.from_s for one in history[1:]), math.inf)[: len(history)]
        for phase, end_s in zip(history, ends_s, strict=True):
            part = grid.between(phase.from_s, min(end_s, self.off_from_s))
            if part.count and phase.wave.on:
                start = part.first - first
                volts[start : start + part.count] = self._volts(phase, part, record, position)
        return volts

    def _volts(self, phase: _Phase, part: _Grid, record: _Record, position: int) -> NDArray[np.float64]:
        wave = phase.wave
        if wave.function == NOISE:
            noise = record.noise(wave.bandwidth_hz, part.interval_s)
            given = noise.take(position + part.first, part.count)
        else:
            given = math.sqrt(2.0) * np.sin(2.0 * math.pi * phase.sine_cycles(part.times_s))
        volts = wave.rms_v * (1.0 + self._gain) * given + wave.offset_v
        return np.asarray(volts * self._loaded(wave), dtype=np.float64)

    def _loaded(self, wave: Wave) -> float:
        """What is there by what was set: the generator takes another load for granted."""
        return load_share(self._load_ohm) / load_share(wave.load_ohm)


class SimulatedGenerator:
    """A generator with one or two outputs; what it is told comes through the commands."""

    def __init__(
        self,
        outputs: Mapping[int, SimulatedWaveform],
        *,
        identity: str = "Agilent Technologies,33522B,SIM00005,4.00-1.19-2.00-58-00",
    ) -> None:
        self.identity = identity
        self.errors = ErrorQueue()
        self.now_s = 0.0
        self.outputs = outputs

    def reset(self) -> None:
        """`*RST`: everything off and at its defaults."""
        for output in self.outputs.values():
            output.set(self.now_s, Wave())


def load_share(load_ohm: float) -> float:
    """The share of the open-circuit voltage across a load."""
    return 1.0 if math.isinf(load_ohm) else load_ohm / (load_ohm + _SOURCE_OHM)


def _same_sine(before: Wave, after: Wave) -> bool:
    """Whether a sine goes on without a jump of its phase."""
    now_hz = after.start_hz if after.swept else after.frequency_hz
    was_hz = before.start_hz if before.swept else before.frequency_hz
    return after.on and before.function == after.function == SINE and was_hz == now_hz
