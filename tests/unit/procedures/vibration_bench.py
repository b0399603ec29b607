"""A vibration table with a grating, a gyro on it, and the recording that a synchronous source makes of them."""

import dataclasses
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrotest.records.plan import Context, Plan, Vibrating
from gyrotest.records.recording import (
    Auxiliary,
    Dwell,
    SampleFlag,
    Samples,
    SampleStream,
    Sampling,
)
from gyrotest.records.spec import Case, Output, OutputKind
from gyrotest.records.station import Accuracy, Encoder
from gyrotest.units import Quantity

Motion = Callable[[NDArray[np.float64]], NDArray[np.float64]]
RATE_HZ = 10_000.0
LINES = 9000
ENCODER = Encoder(sine="ua", cosine="ub", lines=LINES, accuracy=Quantity(5.0, "arcsec"))
SKEWS_S = (0.0, 2.5e-5, 5e-5)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Gyro:
    """A second-order gyro with a delay: output `zero + scale·rate`, V."""

    scale: float = 0.05
    natural_hz: float = 130.0
    damping: float = 0.7
    delay_s: float = 0.4e-3
    zero: float = 2.5
    noise_v: float = 0.0

    def response(self, frequency_hz: float) -> complex:
        """Return output over rate, V/(°/s)."""
        s = 1j * frequency_hz / self.natural_hz
        lag = np.exp(-2j * np.pi * frequency_hz * self.delay_s)
        return complex(self.scale * lag / (1.0 + 2.0 * self.damping * s + s * s))


@dataclasses.dataclass(frozen=True, kw_only=True)
class Sine:
    """A steady sine of the table's rate."""

    frequency_hz: float
    rms_dps: float
    phase: float = 0.3
    at_deg: float = 0.0

    @property
    def _peak_deg(self) -> float:
        return self.rms_dps * math.sqrt(2.0) / (2.0 * math.pi * self.frequency_hz)

    def _wave(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.phase + 2.0 * np.pi * self.frequency_hz * time_s

    def angle_deg(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the table's angle at times."""
        angle: NDArray[np.float64] = self.at_deg + self._peak_deg * np.sin(self._wave(time_s))
        return angle

    def output_v(self, gyro: Gyro, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the gyro's output without noise."""
        ratio = gyro.response(self.frequency_hz)
        rate = self._peak_deg * 2.0 * np.pi * self.frequency_hz
        wave = rate * np.abs(ratio) * np.cos(self._wave(time_s) + np.angle(ratio))
        output: NDArray[np.float64] = gyro.zero + wave
        return output


@dataclasses.dataclass(frozen=True, kw_only=True)
class Signals:
    """What is wrong with the grating's signals, V."""

    offset: tuple[float, float] = (0.03, -0.05)
    amplitude: tuple[float, float] = (1.02, 0.95)
    quadrature_error: float = 0.06
    noise_v: float = 1e-3


def recorded(
    motions: list[Any],
    *,
    samples: int,
    gyro: Gyro | None = None,
    signals: Signals | None = None,
    skews_s: tuple[float, ...] = SKEWS_S,
    seed: int = 1,
) -> NDArray[np.float64]:
    """Return the columns output, sine and cosine (n, 3) of one motion after the other; None is rest."""
    rng = np.random.default_rng(seed)
    unit, grating = gyro or Gyro(), signals or Signals()
    parts = [_dwell(one, samples, unit, grating, skews_s, rng) for one in motions]
    return np.concatenate(parts)


def _dwell(
    motion: Any,
    samples: int,
    gyro: Gyro,
    signals: Signals,
    skews_s: tuple[float, ...],
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    moves = motion if motion is not None else Sine(frequency_hz=1.0, rms_dps=0.0)
    output_s, sine_s, cosine_s = (np.arange(samples) / RATE_HZ + one for one in skews_s)
    sine = np.sin(np.deg2rad(moves.angle_deg(sine_s)) * LINES)
    cosine = np.cos(np.deg2rad(moves.angle_deg(cosine_s)) * LINES + signals.quadrature_error)
    noise = rng.normal(size=(samples, 3)) * [gyro.noise_v, signals.noise_v, signals.noise_v]
    columns = (
        moves.output_v(gyro, output_s),
        signals.offset[0] + signals.amplitude[0] * sine,
        signals.offset[1] + signals.amplitude[1] * cosine,
    )
    values: NDArray[np.float64] = np.stack(columns, axis=1) + noise
    return values


def daq_sampling(**changes: Any) -> Sampling:
    plain = Sampling(
        interval_s=1.0 / RATE_HZ,
        aperture_s=1.0 / RATE_HZ,
        auxiliary=(
            Auxiliary(name="encoder_sine", unit="V"),
            Auxiliary(name="encoder_cosine", unit="V"),
        ),
        offsets_s=SKEWS_S,
        range=10.0,
        synchronous=True,
        skew_uncertainty_s=1e-6,
    )
    return dataclasses.replace(plain, **changes)


def streamed(
    values: NDArray[np.float64],
    *,
    sampling: Sampling | None = None,
    lost: tuple[int, ...] = (),
    overloaded: tuple[int, ...] = (),
    block: int = 65_536,
) -> SampleStream:
    """Return a recording of rows, without those that were lost."""
    described = sampling or daq_sampling()
    index = np.setdiff1d(np.arange(values.shape[0], dtype=np.int64), np.array(lost, dtype=np.int64))
    flags = np.zeros(values.shape[0], dtype=np.uint8)
    flags[list(overloaded)] = SampleFlag.OVERLOAD

    def blocks() -> Iterator[Samples]:
        for begin in range(0, index.size, block):
            chosen = index[begin : begin + block]
            yield Samples(sampling=described, values=values[chosen], flags=flags[chosen], index=chosen)

    return SampleStream(sampling=described, samples=int(index.size), blocks=blocks)


def dwells_of(plan: Plan) -> tuple[Dwell, ...]:
    """Return a plan's steps as they are carried out."""
    found, first = [], 0
    for step in plan.steps:
        stimulus = step.stimulus
        assert isinstance(stimulus, Vibrating)
        same = stimulus.low_hz == stimulus.high_hz and stimulus.low_hz > 0.0
        found.append(
            Dwell(
                name=step.name,
                first=first,
                samples=step.samples,
                began_s=first / RATE_HZ,
                vibration_dps=stimulus.rms_dps,
                frequency_hz=stimulus.low_hz if same else None,
            )
        )
        first += step.samples
    return tuple(found)


def vibration_output(**changes: Any) -> Output:
    plain = Output(
        kind=OutputKind.VOLTAGE,
        scale_factor=Quantity(50.0, "mV/(deg/s)"),
        zero_rate=Quantity(2.5, "V"),
    )
    return dataclasses.replace(plain, **changes)


def vibration_context(case: Case, parameters: Any, plan: Plan, **changes: Any) -> Context:
    plain = Context(
        case_name="response",
        case=case,
        parameters=parameters,
        output=vibration_output(),
        datasheet={},
        accuracy=Accuracy(of_reading=Quantity(0.01, "%")),
        site=None,
        encoder=ENCODER,
        dwells=dwells_of(plan),
    )
    return dataclasses.replace(plain, **changes)
