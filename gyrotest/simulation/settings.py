"""The station's `simulation` mappings, checked into records; every complaint names its key."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gyrotest.errors import Fault, StationError
from gyrotest.records.spec import Output, OutputKind, Spec
from gyrotest.records.station import Instrument, Simulation, Station
from gyrotest.simulation.figures import Figure, fault, figures_of, nearest
from gyrotest.simulation.gyro import GyroParameters
from gyrotest.simulation.noise import NoiseDensities
from gyrotest.simulation.personalities import MODELS
from gyrotest.units import Dimension

_GYRO = {
    "angle_random_walk": Figure(Dimension.ANGLE_RANDOM_WALK, "0.5 deg/sqrt(h)"),
    "bias_instability_coefficient": Figure(Dimension.RATE, "8 deg/h"),
    "rate_random_walk": Figure(Dimension.RATE_RANDOM_WALK, "3 deg/h/sqrt(h)"),
    "turn_on_bias": Figure(Dimension.RATE, "0.15 deg/s"),
    "scale_factor_error": Figure(Dimension.NUMBER, "0.5 %"),
    "warm_up_drift": Figure(Dimension.RATE, "0.05 deg/s", signed=True),
    "warm_up_time_constant": Figure(Dimension.TIME, "4 min", positive=True),
    "bandwidth": Figure(Dimension.FREQUENCY, "50 Hz", positive=True),
    "input_rate": Figure(Dimension.RATE, "0 deg/s", signed=True),
}
_LINE_FREQUENCY_HZ = 50.0
_METER = {
    "noise": Figure(Dimension.VOLTAGE, "3e-6 V"),
    "gain_error": Figure(Dimension.NUMBER, "0.0035 %"),
    "offset_error": Figure(Dimension.NUMBER, "0.0005 %"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class MeterParameters:
    """A simulated meter: model, half-widths of its errors, rms noise of a reading at 10 PLC."""

    model: str
    gain_error: float
    offset_error_of_range: float
    noise_v: float


def gyro_parameters(
    simulation: Simulation, spec: Spec, factors: Mapping[str, float] | None = None
) -> GyroParameters:
    """The gyro's true figures from the station's `simulation`, the spec and a scenario's factors.

    Raises `StationError` with all complaints at once.
    """
    given, output = simulation.gyro, spec.output
    if output.bandwidth is not None:
        given = {"bandwidth": str(output.bandwidth), **given}
    figures = figures_of(given, _GYRO, "simulation.gyro")
    values, faults = figures.values, figures.faults
    scale_factor = output.scale_factor
    if output.kind is not OutputKind.VOLTAGE or scale_factor is None:
        faults.append(fault("simulation", _unfit(output)))
    if faults or scale_factor is None:
        raise StationError(faults)
    for name, factor in (factors or {}).items():
        values[name] *= factor
    return GyroParameters(
        scale_factor_v_per_dps=scale_factor.to(Dimension.SCALE_FACTOR_VOLTAGE),
        zero_rate_v=output.zero_rate.to(Dimension.VOLTAGE) if output.zero_rate else 0.0,
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
    )


def _unfit(output: Output) -> str:
    needs = "the simulated bench has a gyro with a voltage output and a scale factor"
    if output.kind is OutputKind.VOLTAGE:
        return f"{needs}; the spec has no 'output.scale_factor'"
    return (
        f"{needs}, the spec's output.kind is '{output.kind.value}'; name another station by --gyro-station:"
        " one with this gyro's driver, or one that replays a recorded file (specs/stations/replay.yaml shows how)"
    )


def gyro_figures(given: Mapping[str, Any]) -> dict[str, float]:
    """The gyro's true figures in canonical units; raises `StationError` with all complaints at once."""
    figures = figures_of(given, _GYRO, "simulation.gyro")
    if figures.faults:
        raise StationError(figures.faults)
    return figures.values


def meter_parameters(station: Station, name: str) -> MeterParameters:
    """A meter's figures from `simulation.instruments` and the station's accuracy.

    Raises `StationError` with all complaints at once.
    """
    instrument = station.instruments[name]
    given = dict(station.simulation.instruments.get(name, {})) if station.simulation else {}
    key = f"simulation.instruments.{name}"
    model = given.pop("model", None) or _model_of(instrument.driver)
    figures = figures_of(_stated_accuracy(instrument) | given, _METER, key)
    values, faults = figures.values, figures.faults
    if model not in MODELS:
        known = " or ".join(MODELS)
        faults.append(
            fault(f"{key}.model", f"{model or instrument.driver!r} cannot be simulated; write {known}")
        )
    if faults:
        raise StationError(faults)
    return MeterParameters(
        model=str(model),
        gain_error=values["gain_error"],
        offset_error_of_range=values["offset_error"],
        noise_v=values["noise"],
    )


def unknown_instruments(station: Station) -> list[Fault]:
    """Complaints about entries of `simulation.instruments` for which the station has no instrument."""
    given = station.simulation.instruments if station.simulation else {}
    return [
        fault(
            f"simulation.instruments.{name}",
            f"the station has no such instrument{nearest(name, station.instruments)}",
        )
        for name in given
        if name not in station.instruments
    ]


def _stated_accuracy(instrument: Instrument) -> dict[str, str]:
    accuracy = instrument.accuracy
    if accuracy is None:
        return {}
    stated = {"gain_error": str(accuracy.of_reading), "offset_error": str(accuracy.of_range)}
    return stated if accuracy.noise is None else {**stated, "noise": str(accuracy.noise)}


def _model_of(driver: str) -> str | None:
    """The model in a driver's name: `agilent34401a` drives a 34401A."""
    return next((model for model in MODELS if model.lower() in driver.lower()), None)


def line_frequency_hz(station: Station) -> float:
    """The station's line frequency, Hz; 50 where it states none."""
    return station.line_frequency.to("Hz") if station.line_frequency else _LINE_FREQUENCY_HZ
