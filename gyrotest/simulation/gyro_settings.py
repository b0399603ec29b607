"""The simulated gyro's true figures, from the station's `simulation` and from the spec."""

import math
from collections.abc import Mapping
from typing import Any

from gyrotest.errors import Fault, StationError
from gyrotest.records.spec import Output, OutputKind, Spec
from gyrotest.records.station import Simulation
from gyrotest.simulation.figures import Figure, fault, figures_of
from gyrotest.simulation.noise import NoiseDensities
from gyrotest.simulation.unit import GyroParameters
from gyrotest.units import Dimension

# Where the spec states no full scale: the output never saturates, and no rate is a large one.
_NO_SATURATION = "1e12 deg/s"
_UNLIMITED_DPS = 1e12
# Of the full scale: what an output still shows.
_HEADROOM = 1.25
_FIGURES = {
    "angle_random_walk": Figure(Dimension.ANGLE_RANDOM_WALK, "0.5 deg/sqrt(h)"),
    "bias_instability_coefficient": Figure(Dimension.RATE, "8 deg/h"),
    "rate_random_walk": Figure(Dimension.RATE_RANDOM_WALK, "3 deg/h/sqrt(h)"),
    "turn_on_bias": Figure(Dimension.RATE, "0.15 deg/s"),
    "scale_factor_error": Figure(Dimension.NUMBER, "0.5 %"),
    "warm_up_drift": Figure(Dimension.RATE, "0.05 deg/s", signed=True),
    "warm_up_time_constant": Figure(Dimension.TIME, "4 min", positive=True),
    "bandwidth": Figure(Dimension.FREQUENCY, "50 Hz", positive=True),
    "input_rate": Figure(Dimension.RATE, "0 deg/s", signed=True),
    "nonlinearity": Figure(Dimension.NUMBER, "0 ppm"),
    "asymmetry": Figure(Dimension.NUMBER, "0 ppm"),
    "saturation": Figure(Dimension.RATE, _NO_SATURATION, positive=True),
    "dead_zone": Figure(Dimension.RATE, "0 deg/s"),
    "temperature_sensitivity": Figure(Dimension.RATE_PER_TEMPERATURE, "0 deg/s/degC"),
    "scale_factor_temperature_sensitivity": Figure(Dimension.RATIO_PER_TEMPERATURE, "0 ppm/degC"),
    "clock_error": Figure(Dimension.NUMBER, "0 ppm", signed=True),
    "damping": Figure(Dimension.NUMBER, "0 %", pure=True),
    "bandwidth_error": Figure(Dimension.NUMBER, "0 %"),
    "delay": Figure(Dimension.TIME, "0 s"),
    "g_sensitivity": Figure(Dimension.RATE_PER_ACCELERATION, "0 deg/s/g"),
    "misalignment": Figure(Dimension.ANGLE, "0 deg"),
}
_SCALE_FACTORS = {
    OutputKind.VOLTAGE: Dimension.SCALE_FACTOR_VOLTAGE,
    OutputKind.RATE: Dimension.NUMBER,
    OutputKind.COUNT: Dimension.SCALE_FACTOR_COUNT,
}
_OFFSETS = {
    OutputKind.VOLTAGE: Dimension.VOLTAGE,
    OutputKind.RATE: Dimension.RATE,
    OutputKind.COUNT: Dimension.COUNT,
}


def gyro_parameters(
    simulation: Simulation, spec: Spec, factors: Mapping[str, float] | None = None
) -> GyroParameters:
    """The gyro's true figures: the model's before those of any gyro, and a scenario's factors on them.

    Raises `StationError` with all complaints at once.
    """
    output = spec.output
    values = _values(simulation, spec)
    if output.scale_factor is None and output.kind is not OutputKind.RATE:
        raise StationError([fault("simulation", unfit(output))])
    for name, factor in (factors or {}).items():
        values[name] *= factor
    full_scale_dps = output.full_scale.to(Dimension.RATE) if output.full_scale else math.inf
    return GyroParameters(
        axes=output.axes or ("",),
        voltage=output.kind is OutputKind.VOLTAGE,
        scale_factor=(
            output.scale_factor.to(_SCALE_FACTORS[output.kind]) if output.scale_factor else 1.0
        ),
        zero_rate=output.zero_rate.to(_OFFSETS[output.kind]) if output.zero_rate else 0.0,
        noise=NoiseDensities(
            angle_random_walk_dps_sqrt_s=values["angle_random_walk"],
            bias_instability_dps=values["bias_instability_coefficient"],
            rate_random_walk_dps_per_sqrt_s=values["rate_random_walk"],
            bandwidth_hz=values["bandwidth"],
        ),
        turn_on_bias_dps=values["turn_on_bias"],
        scale_factor_error=values["scale_factor_error"],
        warm_up_drift_dps=values["warm_up_drift"],
        warm_up_time_constant_s=values["warm_up_time_constant"],
        input_rate_dps=values["input_rate"],
        full_scale_dps=full_scale_dps,
        nonlinearity=values["nonlinearity"],
        asymmetry=values["asymmetry"],
        saturation_dps=(values["saturation"] if values["saturation"] < _UNLIMITED_DPS else math.inf),
        dead_zone_dps=values["dead_zone"],
        temperature_sensitivity_dps_per_c=values["temperature_sensitivity"],
        scale_factor_sensitivity_per_c=values["scale_factor_temperature_sensitivity"] * 1e-6,
        clock_error=values["clock_error"],
        damping=values["damping"],
        bandwidth_error=values["bandwidth_error"],
        delay_s=values["delay"],
        g_sensitivity_dps_per_g=values["g_sensitivity"],
        misalignment_deg=values["misalignment"],
    )


def _values(simulation: Simulation, spec: Spec) -> dict[str, float]:
    """The figures in canonical units; raises `StationError`."""
    output, of_model = spec.output, simulation.models.get(spec.model, {})
    given = {**simulation.gyro, **of_model}
    if output.bandwidth is not None:
        given = {"bandwidth": str(output.bandwidth), **given}
    if output.full_scale is not None:
        given = {"saturation": f"{_HEADROOM * output.full_scale.to('deg/s')} deg/s", **given}
    if faults := figure_faults(simulation):
        raise StationError(faults)
    return figures_of(given, _FIGURES, "simulation.gyro").values


def figure_faults(simulation: Simulation) -> list[Fault]:
    """The complaints about a station's true figures, of any gyro and of each model."""
    given: dict[str, Mapping[str, Any]] = {"simulation.gyro": simulation.gyro}
    given |= {f"simulation.models.{model}": figures for model, figures in simulation.models.items()}
    return [
        one for prefix, figures in given.items() for one in figures_of(figures, _FIGURES, prefix).faults
    ]


def unfit(output: Output) -> str:
    """Why a gyro with this output cannot be read by a simulated meter."""
    needs = "the simulated bench has a gyro with a voltage output and a scale factor"
    if output.kind is not OutputKind.RATE and output.scale_factor is None:
        return f"{needs}; the spec has no 'output.scale_factor'"
    return (
        f"{needs}, the spec's output.kind is '{output.kind.value}'; name another station by --gyro-station:"
        " one with this gyro's driver, or one that replays a recorded file (specs/stations/replay.yaml shows how)"
    )
