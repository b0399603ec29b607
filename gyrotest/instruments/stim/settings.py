"""What a station says of a serial gyro."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from gyrotest.instruments.stim.models import STIM210, STIM300, Model
from gyrotest.records.described import Described
from gyrotest.records.spec import OutputMode
from gyrotest.units import Dimension, OfDimension, Quantity

_BITS_PER_BYTE = 10
_RANGE = Quantity(400.0, "deg/s")


@dataclass(frozen=True, slots=True, kw_only=True)
class StimSettings:
    """The station's settings of a serial gyro, which each model words and checks."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    frame: str | int
    sample_rate: Annotated[
        Quantity, OfDimension(Dimension.FREQUENCY), Described("Frames per second.", "125 Hz")
    ]
    baud_rate: Annotated[int, Described("Bits per second of the line.", "460800")] = 460800
    mode: Annotated[OutputMode, Described("What the unit gives out.", "average_rate")] = OutputMode.RATE
    range: Annotated[
        Quantity, OfDimension(Dimension.RATE), Described("The unit's range.", "400 deg/s")
    ] = _RANGE
    crlf: Annotated[bool, Described("Whether each frame ends with CR and LF.", "true")] = False
    ask: Annotated[bool, Described("Ask the unit for its serial number and how it is set.", "false")] = (
        True
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Stim210Settings(StimSettings):
    """The station's settings of a STIM210: what the unit is set to."""

    frame: Annotated[
        str | int,
        Described(
            "The kind of frame that the unit sends, by its contents or its identifier: rate, rate_extended, "
            "rate_temperature, rate_counter, rate_latency, rate_counter_latency, rate_temperature_counter, "
            "rate_temperature_latency, rate_temperature_counter_latency. Without the counter, losses shorter "
            "than 0.1 s are not found.",
            "rate_temperature_counter",
        ),
    ]

    def __post_init__(self) -> None:
        check(self, STIM210)


@dataclass(frozen=True, slots=True, kw_only=True)
class Stim300Settings(StimSettings):
    """The station's settings of a STIM300: what the unit is set to."""

    frame: Annotated[
        str | int,
        Described(
            "The kind of frame that the unit sends, by its identifier or its contents: rate, and of "
            "acceleration, inclination, temperature and auxiliary (or pps) what it has, in this order.",
            "rate_temperature",
        ),
    ]
    baud_rate: Annotated[int, Described("Bits per second of the line.", "921600")] = 460800

    def __post_init__(self) -> None:
        check(self, STIM300)


def check(settings: StimSettings, model: Model) -> None:
    """Refuse what the model does not have, or the line cannot carry; raises `ValueError`."""
    frame, rate_hz = model.frame(settings.frame), settings.sample_rate.to("Hz")
    if rate_hz not in model.sample_rates_hz:
        known = ", ".join(f"{one} Hz" for one in model.sample_rates_hz)
        raise ValueError(
            f"sample_rate {settings.sample_rate} is none of the {model.name}'s: write one of {known}"
        )
    needed = model.wire_size(frame, crlf=settings.crlf) * _BITS_PER_BYTE * rate_hz
    if settings.baud_rate < needed:
        raise ValueError(
            f"baud_rate {settings.baud_rate} is too slow for {frame.name} frames at {rate_hz:g} Hz,"
            f" which need {needed:.0f} bit/s"
        )
    if settings.range.to("deg/s") <= 0.0:
        raise ValueError(f"range {settings.range} is not more than zero; write e.g. '400 deg/s'")
