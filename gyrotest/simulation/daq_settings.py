"""A simulated acquisition system's figures, from `simulation.instruments` and what the station states of it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gyrotest.errors import Fault, StationError, UnitError
from gyrotest.records.station import Instrument, Slot, Station
from gyrotest.simulation.figures import Figure, fault, figures_of, given_figures
from gyrotest.simulation.grating import GratingFigures
from gyrotest.units import Dimension, parse_quantity

_FIGURES = {
    "noise": Figure(Dimension.VOLTAGE, "30 uV"),
    "gain_error": Figure(Dimension.NUMBER, "100 ppm"),
    "offset_error": Figure(Dimension.NUMBER, "0 ppm"),
    "range": Figure(Dimension.VOLTAGE, "10 V", positive=True),
    "skew": Figure(Dimension.TIME, "0 s"),
    "filter": Figure(Dimension.FREQUENCY, "0 Hz"),
    "clock_error": Figure(Dimension.NUMBER, "0 ppm", signed=True),
    "grating_amplitude": Figure(Dimension.VOLTAGE, "1 V", positive=True),
    "grating_offset": Figure(Dimension.NUMBER, "2 %"),
    "grating_mismatch": Figure(Dimension.NUMBER, "2 %"),
    "grating_quadrature": Figure(Dimension.ANGLE, "1 deg"),
    "grating_harmonic": Figure(Dimension.NUMBER, "0.1 %"),
    "grating_ripple": Figure(Dimension.NUMBER, "0.5 %"),
    "grating_noise": Figure(Dimension.VOLTAGE, "0.2 mV"),
    "encoder_noise": Figure(Dimension.ANGLE, "0.0002 deg"),
}
ONLY_CHANNEL = "output"
"""The channel of a slot that names none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DaqParameters:
    """A simulated acquisition system: half-widths of its errors, noise, range, how its channels are sampled.

    A channel is sampled `skew_s` later than the one before it, or `stated_skew_s` later than the first, and
    that to within `skew_uncertainty_s`. `filter_hz` is None where there is no low-pass.
    """

    channels: tuple[str, ...]
    angles: frozenset[str]
    gain_error: float
    offset_error_of_range: float
    noise_v: float
    range_v: float
    skew_s: float
    stated_skew_s: Mapping[str, float]
    skew_uncertainty_s: float
    filter_hz: float | None
    clock_error: float
    grating: GratingFigures
    encoder_noise_deg: float

    def skew_of(self, channel: str) -> float:
        """How much later a channel is sampled, as it says itself."""
        return self.skew_s * self.channels.index(channel)

    def nominal_skew_of(self, channel: str) -> float:
        """How much later it is sampled, but for its error."""
        return self.stated_skew_s.get(channel, self.skew_of(channel))


def daq_parameters(station: Station, name: str) -> DaqParameters:
    """An acquisition system's figures; raises `StationError` with all complaints at once."""
    instrument = station.instruments[name]
    settings = instrument.settings
    given = _stated(instrument) | given_figures(station, name)
    found = figures_of(given, _FIGURES, f"simulation.instruments.{name}")
    faults, key = [*found.faults], f"instruments.{name}.settings"
    stated = settings.get("skew", {})
    skews = {
        str(channel): _time_s(value, f"{key}.skew.{channel}", faults)
        for channel, value in (stated.items() if isinstance(stated, Mapping) else ())
    }
    uncertainty = _time_s(settings.get("skew_uncertainty", "0 s"), f"{key}.skew_uncertainty", faults)
    if faults:
        raise StationError(faults)
    values, slots = found.values, [slot for slot in station.slots.values() if slot.source == name]
    return DaqParameters(
        channels=tuple(dict.fromkeys(one for slot in slots for one in _channels(slot))),
        angles=frozenset(_angle(slot) for slot in slots) - {""},
        gain_error=values["gain_error"],
        offset_error_of_range=values["offset_error"],
        noise_v=values["noise"],
        range_v=values["range"],
        skew_s=values["skew"],
        stated_skew_s=skews,
        skew_uncertainty_s=uncertainty,
        filter_hz=values["filter"] or None,
        clock_error=values["clock_error"],
        grating=GratingFigures(
            amplitude_v=values["grating_amplitude"],
            offset=values["grating_offset"],
            mismatch=values["grating_mismatch"],
            quadrature_deg=values["grating_quadrature"],
            harmonic=values["grating_harmonic"],
            ripple=values["grating_ripple"],
            noise_v=values["grating_noise"],
        ),
        encoder_noise_deg=values["encoder_noise"],
    )


def output_channels(slot: Slot, axes: tuple[str, ...]) -> tuple[str, ...]:
    """The channel of each axis of the unit in a slot."""
    return tuple(slot.channels.get(axis, slot.channel or ONLY_CHANNEL) for axis in axes)


def _channels(slot: Slot) -> tuple[str, ...]:
    """All channels that a slot uses: of its unit, of its encoder, of what is beside."""
    outputs = tuple(slot.channels.values()) or (slot.channel or ONLY_CHANNEL,)
    encoder = slot.encoder
    read = (encoder.sine, encoder.cosine, encoder.angle) if encoder is not None else ()
    return (*outputs, *(one for one in read if one is not None), *slot.auxiliary.values())


def _angle(slot: Slot) -> str:
    return (slot.encoder.angle or "") if slot.encoder is not None else ""


def _stated(instrument: Instrument) -> dict[str, Any]:
    """What the station states of it: its accuracy, and the low-pass that its driver's settings name."""
    stated: dict[str, Any] = {}
    if "filter" in instrument.settings:
        stated["filter"] = instrument.settings["filter"]
    accuracy = instrument.accuracy
    if accuracy is not None:
        stated |= {"gain_error": str(accuracy.of_reading), "offset_error": str(accuracy.of_range)}
        if accuracy.noise is not None:
            stated["noise"] = str(accuracy.noise)
    return stated


def _time_s(given: object, key: str, faults: list[Fault]) -> float:
    try:
        return parse_quantity(given, Dimension.TIME).to(Dimension.TIME)
    except UnitError as error:
        faults.append(fault(key, str(error)))
        return 0.0
