"""A level shaft in memory: what a gyro on it gives out, by the equations alone, and how it lies truly."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrotest.procedures.g_sensitivity import GSensitivity, GSensitivityParameters
from gyrotest.records.plan import Context, Pointing, Reduction, Rotating, Step
from gyrotest.records.recording import Auxiliary, Dwell, Samples, Sampling
from gyrotest.records.result import Result
from gyrotest.records.spec import Case, Output, OutputKind
from gyrotest.records.station import Accuracy, Encoder, Shaft, Site
from gyrotest.simulation.noise import NoiseDensities, RateNoise
from gyrotest.simulation.streams import Normals
from gyrotest.units import Quantity

EARTH_DPS = 15.041 / 3600.0
LATITUDE_DEG, AZIMUTH_DEG = 48.0, 30.0
GRAVITY_G = 9.80894 / 9.80665
SCALE, ZERO_V = 0.05, 2.5
OUTPUT = Output(
    kind=OutputKind.VOLTAGE,
    scale_factor=Quantity(50.0, "mV/(deg/s)"),
    scale_factor_uncertainty=Quantity(0.5, "%"),
    zero_rate=Quantity(ZERO_V, "V"),
    full_scale=Quantity(100.0, "deg/s"),
)
SHAFT = Shaft(
    azimuth=Quantity(AZIMUTH_DEG, "deg"),
    azimuth_uncertainty=Quantity(0.5, "deg"),
    tilt_uncertainty=Quantity(0.05, "deg"),
    index_uncertainty=Quantity(0.1, "deg"),
)
FRAME_X = {"x": "x", "y": "y", "z": "z"}
FRAME_Z = {"x": "z", "y": "x", "z": "y"}
QUIET = NoiseDensities(
    angle_random_walk_dps_sqrt_s=1e-5,
    bias_instability_dps=1e-9,
    rate_random_walk_dps_per_sqrt_s=1e-12,
    bandwidth_hz=50.0,
)
MEMS = NoiseDensities(
    angle_random_walk_dps_sqrt_s=0.5 / 60.0,
    bias_instability_dps=8.0 / 3600.0,
    rate_random_walk_dps_per_sqrt_s=3.0 / 3600.0 / 60.0,
    bandwidth_hz=50.0,
)


@dataclass(frozen=True)
class Unit:
    """A gyro that senses own x, and how its shaft truly lies."""

    zeta: tuple[float, float, float] = (0.03, -0.05, 0.08)
    bias_dps: float = 0.2
    cross_axis: tuple[float, float] = (0.004, -0.007)
    """Of own y and z."""
    scale_error: float = 0.0
    azimuth_error_deg: float = 0.0
    index_error_deg: float = 0.0
    square: float = 0.0
    """Drift by the square of gravity along own x, °/s/g²."""
    noise: NoiseDensities = QUIET
    seed: int = 1


@dataclass(frozen=True)
class Bench:
    """A case on a station, and what becomes of the recording before it is reduced."""

    unit: Unit = field(default_factory=Unit)
    frame: Mapping[str, str] = field(default_factory=lambda: FRAME_X)
    parameters: GSensitivityParameters = field(default_factory=GSensitivityParameters)
    interval_s: float = 0.05
    rest_s: float = 30.0
    repeats: int = 2
    encoder: Encoder = field(
        default_factory=lambda: Encoder(angle="angle", accuracy=Quantity(5, "arcsec"))
    )
    shaft: Shaft | None = SHAFT
    site: Site | None = field(default_factory=lambda: Site(latitude=Quantity(LATITUDE_DEG, "deg")))
    output: Output = OUTPUT
    synchronous: bool = True
    earlier: Mapping[str, tuple[Result, ...]] = field(default_factory=dict)

    @property
    def case(self) -> Case:
        """The case."""
        return Case(
            procedure="g_sensitivity",
            duration=Quantity(self.rest_s, "s"),
            interval=Quantity(self.interval_s, "s"),
            repeats=self.repeats,
        )

    @property
    def steps(self) -> tuple[Step, ...]:
        """The plan's steps."""
        return GSensitivity().plan(self.case, self.parameters).steps

    def context(self, repeat: int | None, dwells: tuple[Dwell, ...] = ()) -> Context:
        """What the reduction is given."""
        return Context(
            case_name="turning",
            case=self.case,
            parameters=self.parameters,
            output=self.output,
            datasheet={},
            accuracy=Accuracy(of_reading=Quantity(50.0, "ppm")),
            site=self.site,
            since_power_on_s=600.0,
            dwells=dwells,
            earlier=self.earlier,
            repeat=repeat,
            encoder=self.encoder,
            frame=self.frame,
            placement=None if repeat is None else self.parameters.placement(repeat),
            shaft=self.shaft,
        )

    def recorded(self, repeat: int) -> "Recorded":
        """Turn the shaft once for a repeat."""
        return _recorded(self, repeat)

    def mounting(self, repeat: int) -> Reduction:
        """Turn it and reduce."""
        return self.recorded(repeat).reduced()

    def both(self) -> tuple[Result, ...]:
        """Everything over the repeats."""
        return self.together().results

    def together(self) -> Reduction:
        """The reduction over the repeats."""
        repeats = tuple(self.mounting(one).results for one in range(1, self.repeats + 1))
        return GSensitivity().reduce_repeats(repeats, self.context(None))


@dataclass(frozen=True)
class Recorded:
    """A recording that can be spoiled before it is reduced."""

    bench: Bench
    repeat: int
    samples: Samples
    dwells: tuple[Dwell, ...]

    def reduced(self) -> Reduction:
        """What the procedure makes of it."""
        return GSensitivity().reduce(self.samples, self.bench.context(self.repeat, self.dwells))

    def of(self, **changes: Any) -> "Recorded":
        """The same with other samples."""
        return replace(self, samples=replace(self.samples, **changes))

    def column(self, place: int, values: NDArray[np.float64]) -> "Recorded":
        """The same with another column."""
        spoiled = self.samples.values.copy()
        spoiled[:, place] = values
        return self.of(values=spoiled)


def _recorded(bench: Bench, repeat: int) -> Recorded:
    dwells: list[Dwell] = []
    angles: list[NDArray[np.float64]] = []
    rates: list[NDArray[np.float64]] = []
    outputs: list[NDArray[np.float64]] = []
    unit, first, begin_s = bench.unit, 0, 0.0
    seed = np.random.default_rng([unit.seed, repeat])
    noise = RateNoise(unit.noise, Normals(seed), since_power_on_s=600.0, start_s=0.0)
    for step in bench.steps:
        along = (np.arange(step.samples) + 0.5) * bench.interval_s
        angle, rate = _motion(step, along)
        dwells.append(Dwell(name=step.name, first=first, samples=step.samples, began_s=begin_s))
        random = noise.means(begin_s, bench.interval_s, bench.interval_s, step.samples)
        outputs.append(_output(bench, repeat, angle, rate) + random)
        angles.append(angle)
        rates.append(rate)
        first += step.samples
        begin_s += step.samples * bench.interval_s + 3.0
    rate_dps = np.concatenate(outputs)
    volts = SCALE * (1.0 + unit.scale_error) * rate_dps + ZERO_V
    values = np.asfortranarray(np.column_stack((volts, np.concatenate(angles) % 360.0)))
    sampling = Sampling(
        interval_s=bench.interval_s,
        aperture_s=bench.interval_s,
        auxiliary=(Auxiliary(name="encoder_angle", unit="deg"),),
        offsets_s=(0.0, 0.0),
        synchronous=bench.synchronous,
        skew_uncertainty_s=1e-6,
    )
    samples = Samples(
        sampling=sampling,
        values=values,
        flags=np.zeros(values.shape[0], dtype=np.uint8),
        index=np.arange(values.shape[0]),
    )
    return Recorded(bench=bench, repeat=repeat, samples=samples, dwells=tuple(dwells))


def _motion(step: Step, along_s: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
    stimulus = step.stimulus
    if isinstance(stimulus, Pointing):
        return np.full(along_s.size, stimulus.position_deg), np.zeros(along_s.size)
    assert isinstance(stimulus, Rotating)
    begin = stimulus.run_up_deg if stimulus.rate_dps > 0.0 else 360.0 - stimulus.run_up_deg
    return begin + stimulus.rate_dps * along_s, np.full(along_s.size, stimulus.rate_dps)


def _output(
    bench: Bench, repeat: int, angle_deg: NDArray[np.float64], rate_dps: NDArray[np.float64]
) -> NDArray[np.float64]:
    """S5.1 to S5.4, and the own axes turned by hand: by 90°, own y lies where own z lay."""
    unit = bench.unit
    latitude = math.radians(LATITUDE_DEG)
    azimuth = math.radians(AZIMUTH_DEG + unit.azimuth_error_deg)
    angle = np.radians(angle_deg + unit.index_error_deg)
    sine, cosine = np.sin(angle), np.cos(angle)
    level = math.cos(latitude) * math.cos(azimuth)
    stage = {
        "x": (-GRAVITY_G * sine, EARTH_DPS * (level * cosine - math.sin(latitude) * sine)),
        "z": (GRAVITY_G * cosine, EARTH_DPS * (level * sine + math.sin(latitude) * cosine)),
        "y": (
            np.zeros(angle.size),
            np.full(angle.size, EARTH_DPS * math.cos(latitude) * math.sin(azimuth)),
        ),
    }
    quarter = round(bench.parameters.placement(repeat).turned_deg / 90.0) % 4
    own = {name: _signed(stage, bench.frame[name]) for name in "xyz"}
    mounted = dict(own)
    for _ in range(quarter):
        mounted["y"], mounted["z"] = mounted["z"], (-mounted["y"][0], -mounted["y"][1])
    along_shaft = {name: _share(bench.frame[name], "y") for name in "xyz"}
    for _ in range(quarter):
        along_shaft["y"], along_shaft["z"] = along_shaft["z"], -along_shaft["y"]
    drift = sum(zeta * mounted[name][0] for zeta, name in zip(unit.zeta, "xyz", strict=True))
    drift = drift + unit.square * mounted["x"][0] ** 2
    turning = unit.cross_axis[0] * along_shaft["y"] + unit.cross_axis[1] * along_shaft["z"]
    return np.asarray(unit.bias_dps + drift + mounted["x"][1] + turning * rate_dps)


def _signed(
    stage: Mapping[str, tuple[NDArray[np.float64], NDArray[np.float64]]], axis: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    sign = -1.0 if axis.startswith("-") else 1.0
    force, earth = stage[axis.removeprefix("-")]
    return sign * force, sign * earth


def _share(axis: str, of: str) -> float:
    return (axis.removeprefix("-") == of) * (-1.0 if axis.startswith("-") else 1.0)
