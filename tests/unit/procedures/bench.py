"""A static case on a 50 mV/(°/s) gyro, its samples, and the context to reduce them in."""

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrotest.procedures.static import StaticParameters
from gyrotest.records.plan import Context
from gyrotest.records.recording import Samples, Sampling
from gyrotest.records.result import Result
from gyrotest.records.spec import Case, Output, OutputKind
from gyrotest.records.station import Accuracy, Site
from gyrotest.units import Quantity
from tests.unit.analysis.generator import DPH, gyro_noise

NOISE = {"angle_random_walk": 30 * DPH, "bias_instability": 8 * DPH, "rate_random_walk": 0.05 * DPH}
SITE = Site(latitude=Quantity(48.0, "deg"))


def quantity(value: float, unit: str) -> Quantity:
    return Quantity(value, unit)


def static_case(**changes: Any) -> Case:
    plain = Case(
        procedure="static",
        duration=quantity(1.0, "h"),
        interval=quantity(1.0, "s"),
        warm_up=quantity(10.0, "min"),
        repeats=3,
        mounting=(1.0, 0.0, 0.0),
    )
    return dataclasses.replace(plain, **changes)


def voltage_output(**changes: Any) -> Output:
    plain = Output(
        kind=OutputKind.VOLTAGE,
        scale_factor=quantity(50.0, "mV/(deg/s)"),
        scale_factor_uncertainty=quantity(0.5, "%"),
        zero_rate=quantity(2.5, "V"),
        bandwidth=quantity(50.0, "Hz"),
    )
    return dataclasses.replace(plain, **changes)


def static_context(**changes: Any) -> Context:
    plain = Context(
        case_name="bias_stability",
        case=static_case(),
        parameters=StaticParameters(),
        output=voltage_output(),
        datasheet={},
        accuracy=Accuracy(of_reading=quantity(35.0, "ppm"), of_range=quantity(5.0, "ppm")),
        site=SITE,
        since_power_on_s=600.0,
    )
    return dataclasses.replace(plain, **changes)


def meter_sampling(**changes: Any) -> Sampling:
    plain = Sampling(interval_s=1.0, aperture_s=1.0, noise=3e-6, range=10.0)
    return dataclasses.replace(plain, **changes)


def rates(seed: int = 1, samples: int = 3600) -> NDArray[np.float64]:
    return gyro_noise(samples, since_power_on_s=600.0, seed=seed, **NOISE) + 0.2


def voltages(rate_dps: NDArray[np.float64], scale_factor: float = 0.05) -> Samples:
    return samples_of(2.5 + scale_factor * rate_dps)


def samples_of(values: NDArray[np.float64], **changes: Any) -> Samples:
    plain = Samples(
        sampling=meter_sampling(),
        values=values[:, None],
        flags=np.zeros(values.size, dtype=np.uint8),
    )
    return dataclasses.replace(plain, **changes)


def by_name(results: tuple[Result, ...]) -> dict[str, Result]:
    return {one.name: one for one in results}
