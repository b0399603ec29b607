"""A gyro of known truth on a rate table of known errors: the samples that a plan's steps would give."""

import dataclasses
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.earth import EARTH_RATE_DPS
from gyrotest.procedures.scale_factor import ScaleFactor, ScaleFactorParameters
from gyrotest.records.plan import Context, Plan, Turning
from gyrotest.records.recording import Dwell, SampleFlag, Samples, Sampling
from gyrotest.records.spec import Case, Output, OutputKind
from gyrotest.records.station import Accuracy
from gyrotest.units import Quantity
from tests.unit.analysis.generator import DPH, gyro_noise
from tests.unit.procedures.bench import SITE, static_case, static_context, voltage_output

EARTH_DPS = EARTH_RATE_DPS * float(np.sin(np.radians(48.0)))
RUN_UP_S = 3.0
SINCE_S = 60.0
TABLE = Accuracy(of_reading=Quantity(20.0, "ppm"), of_setting=Quantity(0.0005, "deg/s"))
METER = Accuracy(of_reading=Quantity(35.0, "ppm"), of_range=Quantity(5.0, "ppm"))
QUIET = {"angle_random_walk": 0.002, "bias_instability": 10 * DPH}


@dataclass(frozen=True, kw_only=True)
class Unit:
    """A gyro, the table that turns it and the meter that reads it, all as they truly are."""

    scale_factor: float = 0.05
    bias_dps: float = 0.3
    cubic_ppm: float = 0.0  # of full scale, at full scale
    asymmetry_ppm: float = 0.0
    full_scale_dps: float = 100.0
    zero: float = 2.5
    table_gain: float = 0.0
    setting_dps: dict[float, float] = field(default_factory=dict)
    meter_gain: float = 0.0
    meter_offset: float = 0.0
    noise: dict[str, float] = field(default_factory=lambda: dict(QUIET))
    saturation: float | None = None
    earth_dps: float = EARTH_DPS

    def response(self, rate_dps: NDArray[np.float64]) -> NDArray[np.float64]:
        """Output less the one at rest and without bias, no noise, at true rates."""
        bent = 1e-6 * self.cubic_ppm * self.full_scale_dps * (rate_dps / self.full_scale_dps) ** 3
        uneven = 0.5e-6 * self.asymmetry_ppm * np.abs(rate_dps)
        return self.scale_factor * (rate_dps + bent + uneven)

    def true_rate(self, rate_dps: float) -> float:
        if rate_dps == 0.0:
            return 0.0
        return rate_dps * (1.0 + self.table_gain) + self.setting_dps.get(rate_dps, 0.0)


def table_case(**changes: Any) -> Case:
    plain = static_case(
        procedure="scale_factor",
        duration=Quantity(10.0, "s"),
        interval=Quantity(0.1, "s"),
        repeats=1,
    )
    return dataclasses.replace(plain, **changes)


def table_output(**changes: Any) -> Output:
    return voltage_output(**{"full_scale": Quantity(100.0, "deg/s"), **changes})


def table_context(plan: Plan, **changes: Any) -> Context:
    plain = static_context(
        case_name="scale_factor",
        since_power_on_s=SINCE_S,
        case=table_case(),
        parameters=ScaleFactorParameters(),
        output=table_output(),
        accuracy=METER,
        table=TABLE,
        site=SITE,
        dwells=dwells_of(plan),
    )
    return dataclasses.replace(plain, **changes)


def plan_of(case: Case, parameters: Any = None, procedure: Any = None) -> Plan:
    return (procedure or ScaleFactor()).plan(case, parameters or ScaleFactorParameters())


def dwells_of(plan: Plan) -> tuple[Dwell, ...]:
    """Every step after a run-up and its settling."""
    dwells, first, began_s = [], 0, 0.0
    for step in plan.steps:
        rate = step.stimulus.rate_dps if isinstance(step.stimulus, Turning) else None
        settling_s = RUN_UP_S if first else 0.0
        began_s += settling_s
        dwells.append(
            Dwell(
                name=step.name,
                first=first,
                samples=step.samples,
                began_s=began_s,
                settling_s=settling_s,
                rate_dps=rate,
                measured_rate_dps=rate,
            )
        )
        first += step.samples
        began_s += step.samples * plan.interval_s
    return tuple(dwells)


def samples_of_turns(
    unit: Unit, plan: Plan, *, seed: int = 1, sampling: Sampling | None = None
) -> Samples:
    """What the meter reads of the unit: noise goes on between the steps."""
    dwells = dwells_of(plan)
    interval_s = plan.interval_s
    length = round((dwells[-1].began_s + dwells[-1].samples * interval_s) / interval_s) + 1
    noise = gyro_noise(length, interval_s=interval_s, seed=seed, since_power_on_s=SINCE_S, **unit.noise)
    values = np.concatenate([_dwell(unit, one, noise, interval_s) for one in dwells])
    flags = np.zeros(values.size, dtype=np.uint8)
    if unit.saturation is not None:
        flags[np.abs(values - unit.zero) > unit.saturation] = SampleFlag.OVERLOAD
    return Samples(
        sampling=sampling
        or Sampling(interval_s=interval_s, aperture_s=interval_s, noise=3e-6, range=10.0),
        values=values[:, None],
        flags=flags,
    )


def _dwell(
    unit: Unit, dwell: Dwell, noise: NDArray[np.float64], interval_s: float
) -> NDArray[np.float64]:
    begin = round(dwell.began_s / interval_s)
    rate = np.full(dwell.samples, unit.true_rate(dwell.rate_dps or 0.0))
    rest = unit.bias_dps + unit.earth_dps + noise[begin : begin + dwell.samples]
    output = unit.zero + unit.response(rate) + unit.scale_factor * rest
    return output * (1.0 + unit.meter_gain) + unit.meter_offset


def counts_output() -> Output:
    return Output(
        kind=OutputKind.COUNT,
        scale_factor=Quantity(131.0, "count/(deg/s)"),
        full_scale=Quantity(250.0, "deg/s"),
    )
