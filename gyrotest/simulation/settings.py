"""The station's `simulation.instruments`, checked into records; every complaint names its key."""

from dataclasses import dataclass

from gyrotest.errors import Fault, StationError
from gyrotest.records.station import Instrument, Station
from gyrotest.simulation.figures import Figure, fault, figures_of, given_figures, nearest
from gyrotest.simulation.personalities import MODELS
from gyrotest.units import Dimension

_LINE_FREQUENCY_HZ = 50.0
_UP = (1.0, 0.0, 0.0)
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


def meter_parameters(station: Station, name: str) -> MeterParameters:
    """A meter's figures from `simulation.instruments` and the station's accuracy.

    Raises `StationError` with all complaints at once.
    """
    instrument = station.instruments[name]
    given = given_figures(station, name)
    key = f"simulation.instruments.{name}"
    model = given.pop("model", None) or _model_of(instrument.driver)
    figures = figures_of(stated_meter_accuracy(instrument) | given, _METER, key)
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


def stated_meter_accuracy(instrument: Instrument) -> dict[str, str]:
    """A meter's figures by the accuracy that the station states of it."""
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


def table_axis(station: Station, table: str | None) -> tuple[float, float, float]:
    """The direction (up, north, east) of a table's axis: up where nothing else is said."""
    given = given_figures(station, table) if table else {}
    if "axis" not in given:
        return _UP
    axis = given["axis"]
    try:
        up, north, east = (float(one) for one in axis)
    except (TypeError, ValueError):
        up = north = east = 0.0
    if up == north == east == 0.0:
        message = f"'{axis}' is no direction; write [up, north, east], e.g. [0, 1, 0]"
        raise StationError([fault(f"simulation.instruments.{table}.axis", message)])
    return up, north, east
