"""The station's `simulation` mappings, checked into records; every complaint names its key."""

import difflib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gyrotest.errors import Fault, StationError, UnitError
from gyrotest.records.spec import Output, OutputKind
from gyrotest.records.station import Instrument, Station
from gyrotest.simulation.gyro import GyroParameters
from gyrotest.simulation.noise import NoiseDensities
from gyrotest.simulation.personalities import MODELS
from gyrotest.units import Dimension, parse_quantity


@dataclass(frozen=True, slots=True)
class _Key:
    """A quantity that may be given: its dimension (canonical unit), default and sign."""

    dimension: Dimension
    default: str
    positive: bool = False
    signed: bool = False


_GYRO = {
    "angle_random_walk": _Key(Dimension.ANGLE_RANDOM_WALK, "0.5 deg/sqrt(h)"),
    "bias_instability_coefficient": _Key(Dimension.RATE, "8 deg/h"),
    "rate_random_walk": _Key(Dimension.RATE_RANDOM_WALK, "3 deg/h/sqrt(h)"),
    "turn_on_bias": _Key(Dimension.RATE, "0.15 deg/s"),
    "scale_factor_error": _Key(Dimension.NUMBER, "0.5 %"),
    "warm_up_drift": _Key(Dimension.RATE, "0.05 deg/s", signed=True),
    "warm_up_time_constant": _Key(Dimension.TIME, "4 min", positive=True),
    "bandwidth": _Key(Dimension.FREQUENCY, "50 Hz", positive=True),
    "input_rate": _Key(Dimension.RATE, "0 deg/s", signed=True),
}
_METER = {
    "noise": _Key(Dimension.VOLTAGE, "3e-6 V"),
    "gain_error": _Key(Dimension.NUMBER, "0.0035 %"),
    "offset_error": _Key(Dimension.NUMBER, "0.0005 %"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class MeterParameters:
    """A simulated meter: model, half-widths of its errors, rms noise of a reading at 10 PLC."""

    model: str
    gain_error: float
    offset_error_of_range: float
    noise_v: float


def gyro_parameters(
    given: Mapping[str, Any], output: Output, factors: Mapping[str, float] | None = None
) -> GyroParameters:
    """The gyro's true figures from `simulation.gyro`, the spec's output and a scenario's factors.

    Raises `StationError` with all complaints at once.
    """
    if output.bandwidth is not None:
        given = {"bandwidth": str(output.bandwidth), **given}
    values, faults = _quantities(given, _GYRO, "simulation.gyro")
    scale_factor = output.scale_factor
    if output.kind is not OutputKind.VOLTAGE or scale_factor is None:
        faults.append(_fault("simulation", _unfit(output)))
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
    values, faults = _quantities(given, _GYRO, "simulation.gyro")
    if faults:
        raise StationError(faults)
    return values


def meter_parameters(station: Station, name: str) -> MeterParameters:
    """A meter's figures from `simulation.instruments` and the station's accuracy.

    Raises `StationError` with all complaints at once.
    """
    instrument = station.instruments[name]
    given = dict(station.simulation.instruments.get(name, {})) if station.simulation else {}
    key = f"simulation.instruments.{name}"
    model = given.pop("model", None) or _model_of(instrument.driver)
    values, faults = _quantities(_stated_accuracy(instrument) | given, _METER, key, also=("model",))
    if model not in MODELS:
        known = " or ".join(MODELS)
        faults.append(
            _fault(f"{key}.model", f"{model or instrument.driver!r} cannot be simulated; write {known}")
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
        _fault(
            f"simulation.instruments.{name}",
            f"the station has no such instrument{_nearest(name, station.instruments)}",
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


def _quantities(
    given: Mapping[str, Any], keys: Mapping[str, _Key], prefix: str, also: tuple[str, ...] = ()
) -> tuple[dict[str, float], list[Fault]]:
    faults = [
        _fault(f"{prefix}.{name}", f"unknown key{_nearest(str(name), (*keys, *also))}")
        for name in given
        if name not in keys
    ]
    values: dict[str, float] = {}
    for name, key in keys.items():
        try:
            value = parse_quantity(given.get(name, key.default), key.dimension).to(key.dimension)
        except UnitError as error:
            faults.append(_fault(f"{prefix}.{name}", str(error)))
            continue
        if (value < 0.0 and not key.signed) or (value == 0.0 and key.positive):
            least = "more than zero" if key.positive else "zero or more"
            faults.append(_fault(f"{prefix}.{name}", f"'{given.get(name)}' must be {least}"))
        values[name] = value
    return values, faults


def _nearest(name: str, known: Any) -> str:
    close = difflib.get_close_matches(name, list(known), n=1)
    return f"; did you mean '{close[0]}'?" if close else f" (known: {', '.join(known)})"


def _fault(key: str, message: str) -> Fault:
    return Fault("", None, key, message)
