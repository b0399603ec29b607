"""The station: with what is tested: instruments, addresses, accuracy, calibration dates."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import date
from typing import Annotated, Any

from gyrotest.units import Dimension, OfDimension, Quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """An instrument's calibration certificate."""

    __pydantic_config__ = {"extra": "forbid", "strict": True}

    certificate: str
    date: date
    due: date
    traceable_to: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Accuracy:
    """Datasheet accuracy: half-widths, of the reading and of the range; and rms noise of one reading."""

    __pydantic_config__ = {"extra": "forbid", "strict": True}

    of_reading: Annotated[Quantity, OfDimension(Dimension.NUMBER)]
    of_range: Annotated[Quantity, OfDimension(Dimension.NUMBER)]
    noise: Annotated[Quantity | None, OfDimension(Dimension.VOLTAGE, Dimension.RATE)] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Instrument:
    """One instrument of the bench. `settings` are the driver's own and checked by it."""

    __pydantic_config__ = {"extra": "forbid", "strict": True}

    driver: str
    resource: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    accuracy: Accuracy | None = None
    io_timeout: Annotated[Quantity | None, OfDimension(Dimension.TIME)] = None
    asset: str = ""
    serial_number: str | None = None
    calibration: Calibration | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Slot:
    """A place for one unit under test: the source that reads it and the channel there."""

    __pydantic_config__ = {"extra": "forbid", "strict": True}

    source: str
    channel: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Site:
    """Where the bench stands: for the Earth's rate."""

    __pydantic_config__ = {"extra": "forbid", "strict": True}

    latitude: Annotated[Quantity, OfDimension(Dimension.ANGLE)]
    heading: Annotated[Quantity | None, OfDimension(Dimension.ANGLE)] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Simulation:
    """The simulated bench's physics; its presence makes the bench a simulated one.

    `gyro` and the entries of `instruments` (by instrument name) are checked by the simulation.
    """

    __pydantic_config__ = {"extra": "forbid", "strict": True}

    scenario: str = "nominal"
    seed: int = 1
    gyro: Mapping[str, Any] = field(default_factory=dict)
    instruments: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Station:
    """A bench. A resource `simulated[:tcp|:pty|:prologix]` is served by the simulated bench."""

    __pydantic_config__ = {"extra": "forbid", "strict": True}

    name: str
    instruments: Mapping[str, Instrument]
    slots: Mapping[str, Slot]
    description: str = ""
    laboratory: str = ""
    address: str = ""
    line_frequency: Annotated[Quantity | None, OfDimension(Dimension.FREQUENCY)] = None
    site: Site | None = None
    ambient: Mapping[str, str] = field(default_factory=dict)
    allow_expired_calibration: bool = False
    simulation: Simulation | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class StationDocument:
    """A station, the file that it came from and that file's SHA-256 (hex)."""

    path: str
    sha256: str
    station: Station
