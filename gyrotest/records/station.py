"""The station: with what is tested: instruments, addresses, accuracy, calibration dates."""

import datetime
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar

from gyrotest.records.described import Described
from gyrotest.units import Dimension, OfDimension, Quantity

_NOTHING = Quantity(0.0, "%")
_AZIMUTH_HALF_WIDTH = Quantity(1.0, "deg")
_LEVEL = Quantity(0.0, "deg")
_TILT_HALF_WIDTH = Quantity(0.05, "deg")
_INDEX_HALF_WIDTH = Quantity(0.1, "deg")


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """An instrument's calibration certificate."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    certificate: Annotated[str, Described("Number of the calibration certificate.", "DKD-12345")]
    date: Annotated[datetime.date, Described("Day of the calibration.", "2026-01-15")]
    due: Annotated[
        datetime.date,
        Described("Day on which the calibration ends; later the station stops a run.", "2027-01-15"),
    ]
    traceable_to: Annotated[str, Described("What the calibration is traceable to.", "PTB")] = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Accuracy:
    """Datasheet accuracy: half-widths, of the reading and of the range; and rms noise of one reading."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    of_reading: Annotated[
        Quantity,
        OfDimension(Dimension.NUMBER),
        Described("Half-width in proportion to the reading, for the calibration interval.", "35 ppm"),
    ]
    of_range: Annotated[
        Quantity,
        OfDimension(Dimension.NUMBER),
        Described("Half-width in proportion to the range; of a meter.", "5 ppm"),
    ] = _NOTHING
    of_setting: Annotated[
        Quantity | None,
        OfDimension(Dimension.RATE, Dimension.TEMPERATURE),
        Described(
            "Half-width of each setting's own error, not in proportion to it; of a rate table or a chamber.",
            "0.0005 deg/s",
        ),
    ] = None
    noise: Annotated[
        Quantity | None,
        OfDimension(Dimension.VOLTAGE, Dimension.RATE),
        Described("Standard deviation of one reading with the settings below, input shorted.", "3 uV"),
    ] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """What a rate table, its cables and what is mounted on it may do; nothing beyond is ever sent."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    max_rate: Annotated[
        Quantity, OfDimension(Dimension.RATE), Described("Greatest rate of either sign.", "200 deg/s")
    ]
    max_acceleration: Annotated[
        Quantity,
        OfDimension(Dimension.RATE_RAMP),
        Described("Acceleration of run-up and run-down.", "100 deg/s/s"),
    ]
    slip_ring: Annotated[
        bool, Described("Whether the cables pass a slip ring, so that the table may turn for ever.")
    ] = False
    max_turns: Annotated[
        float | None,
        Described("Without a slip ring: how far it may turn from where it starts, either way.", "3"),
    ] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Shaft:
    """How the level shaft of a rotation stage lies; angles are counted right-handed about it.

    At the angle 0 the stage's z axis points up and its x axis horizontally to `azimuth`; y is the shaft.
    """

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    azimuth: Annotated[
        Quantity | None,
        OfDimension(Dimension.ANGLE),
        Described("Where the stage's x axis points at angle 0, clockwise from true north.", "37 deg"),
    ] = None
    azimuth_uncertainty: Annotated[
        Quantity,
        OfDimension(Dimension.ANGLE),
        Described("Half-width of the azimuth's error.", "1 deg"),
    ] = _AZIMUTH_HALF_WIDTH
    tilt: Annotated[
        Quantity,
        OfDimension(Dimension.ANGLE),
        Described("How far the shaft's y end lies above the horizontal, as measured.", "0.02 deg"),
    ] = _LEVEL
    tilt_uncertainty: Annotated[
        Quantity,
        OfDimension(Dimension.ANGLE),
        Described("Half-width of the tilt's error.", "0.05 deg"),
    ] = _TILT_HALF_WIDTH
    index_uncertainty: Annotated[
        Quantity,
        OfDimension(Dimension.ANGLE),
        Described("How far z may be from pointing up at angle 0: a half-width.", "0.1 deg"),
    ] = _INDEX_HALF_WIDTH


@dataclass(frozen=True, slots=True, kw_only=True)
class Encoder:
    """What measures the angle of the table that carries the unit, by channels of the slot's source.

    Either two sinusoids in quadrature of a grating with `lines` a turn, or the angle itself.
    """

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    sine: Annotated[
        str | None,
        Described("Channel of the grating's sine signal, which leads when the angle grows.", "ua"),
    ] = None
    cosine: Annotated[str | None, Described("Channel of the grating's cosine signal.", "ub")] = None
    lines: Annotated[int | None, Described("Lines of the grating in a turn.", "9000")] = None
    angle: Annotated[
        str | None, Described("Channel of the angle itself, where the encoder gives that.", "angle")
    ] = None
    reversed: Annotated[
        bool, Described("Whether it counts against the direction that is positive for the unit.")
    ] = False
    accuracy: Annotated[
        Quantity | None,
        OfDimension(Dimension.ANGLE),
        Described("Half-width of the angle's error within a turn.", "5 arcsec"),
    ] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Instrument:
    """One instrument of the bench. `settings` are the driver's own and checked by it."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    driver: Annotated[
        str, Described("The driver, by the name under which it is installed.", "agilent34401a")
    ]
    resource: Annotated[
        str,
        Described("VISA resource, a file for the driver `replay`, or `simulated`.", "GPIB0::22::INSTR"),
    ]
    settings: Annotated[Mapping[str, Any], Described("The driver's own settings.", "{nplc: 10}")] = (
        field(default_factory=dict)
    )
    accuracy: Annotated[
        Accuracy | None,
        Described("Accuracy by the datasheet; without it the uncertainty names it as not included."),
    ] = None
    motion: Annotated[
        Motion | None,
        Described(
            "Of a rate table: how far and how fast it may turn.",
            "{max_rate: 200 deg/s, max_acceleration: 100 deg/s/s, slip_ring: true}",
        ),
    ] = None
    shaft: Annotated[
        Shaft | None,
        Described(
            "Of a rotation stage with a level shaft: how that lies.",
            "{azimuth: 37 deg, azimuth_uncertainty: 1 deg}",
        ),
    ] = None
    io_timeout: Annotated[
        Quantity | None,
        OfDimension(Dimension.TIME),
        Described("How long a reply may take beyond the measurement itself, in real seconds.", "5 s"),
    ] = None
    asset: Annotated[str, Described("The laboratory's own number of the instrument.", "DMM-07")] = ""
    serial_number: Annotated[
        str | None,
        Described(
            "Serial number; where it is given, another instrument at the address is refused.",
            "'MY41012345'",
        ),
    ] = None
    calibration: Annotated[Calibration | None, Described("The valid calibration.")] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Slot:
    """A place for one unit under test: the source that reads it and the channel there."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    source: Annotated[
        str, Described("The instrument that reads the unit, by its name in this file.", "meter")
    ]
    channel: Annotated[
        str | None, Described("The instrument's channel, where it has several.", "'101'")
    ] = None
    channels: Annotated[
        Mapping[str, str],
        Described(
            "Of a unit with several axes: the instrument's channel of each.",
            "{x: '101', y: '102', z: '103'}",
        ),
    ] = field(default_factory=dict)
    auxiliary: Annotated[
        Mapping[str, str],
        Described(
            "Other channels of the instrument that are recorded beside: a name for each, and the channel.",
            "{temperature: '102'}",
        ),
    ] = field(default_factory=dict)
    table: Annotated[
        str | None, Described("The rate table that carries the unit, by its name in this file.")
    ] = None
    supply: Annotated[
        str | None, Described("The power supply that feeds the unit, by its name in this file.")
    ] = None
    supply_output: Annotated[int, Described("The supply's output, where it has several.", "1")] = 1
    chamber: Annotated[
        str | None, Described("The temperature chamber around the unit, by its name in this file.")
    ] = None
    vibration: Annotated[
        str | None,
        Described("What drives the vibration table that carries the unit, by its name in this file."),
    ] = None
    encoder: Annotated[
        Encoder | None,
        Described(
            "What measures the angle of the table that carries the unit.",
            "{sine: ua, cosine: ub, lines: 9000}",
        ),
    ] = None
    frame: Annotated[
        Mapping[str, str],
        Described(
            "How the unit's own axes lie in the stage's: x horizontal and z up at angle 0, y along the shaft.",
            "{x: z, y: x, z: y}",
        ),
    ] = field(default_factory=lambda: {"x": "x", "y": "y", "z": "z"})
    models: Annotated[
        tuple[str, ...],
        Described(
            "Models that fit here. A model that some slot names goes there, any other where none are named.",
            "[STIM210]",
        ),
    ] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Site:
    """Where the bench stands: for the Earth's rate."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    latitude: Annotated[
        Quantity,
        OfDimension(Dimension.ANGLE),
        Described("Geographic latitude, north positive.", "48.1 deg"),
    ]
    heading: Annotated[
        Quantity | None,
        OfDimension(Dimension.ANGLE),
        Described("Direction of the bench's own north, clockwise from true north.", "0 deg"),
    ] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Simulation:
    """The simulated bench's physics; its presence makes the bench a simulated one.

    `gyro` and the entries of `instruments` (by instrument name) are checked by the simulation.
    """

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    scenario: Annotated[
        str, Described("The scenario, where the command line names none.", "nominal")
    ] = "nominal"
    seed: Annotated[int, Described("Seed of all randomness, together with the serial number.", "1")] = 1
    gyro: Annotated[Mapping[str, Any], Described("The simulated gyro's true figures.")] = field(
        default_factory=dict
    )
    models: Annotated[
        Mapping[str, Mapping[str, Any]],
        Described("True figures of a model, in place of those of `gyro`, by the model's name."),
    ] = field(default_factory=dict)
    instruments: Annotated[
        Mapping[str, Mapping[str, Any]],
        Described("The simulated instruments' true figures, by the instrument's name in this file."),
    ] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Station:
    """A bench. A resource `simulated[:tcp|:pty|:prologix]` is served by the simulated bench."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    name: Annotated[str, Described("The bench's name, as it is printed.", "Bench 3")]
    instruments: Annotated[
        Mapping[str, Instrument], Described("The instruments, each under a name of its own.")
    ]
    slots: Annotated[
        Mapping[str, Slot],
        Described(
            "The places for units under test; serial numbers take them in this order.",
            "{a: {source: meter}}",
        ),
    ]
    description: Annotated[str, Described("What the bench is, in a line.")] = ""
    laboratory: Annotated[
        str, Described("Who tests, as it is printed.", "Example Gyros Ltd, test laboratory")
    ] = ""
    address: Annotated[str, Described("Where, as it is printed.", "1 Example Street, Exampleton")] = ""
    line_frequency: Annotated[
        Quantity | None,
        OfDimension(Dimension.FREQUENCY),
        Described(
            "Mains frequency: `50 Hz` or `60 Hz`. A meter that integrates over power-line cycles needs it."
        ),
    ] = None
    site: Annotated[Site | None, Described("Where the bench stands, for the Earth's rate.")] = None
    ambient: Annotated[
        Mapping[str, str],
        Described(
            "Ambient conditions as they are printed, in your own words.", "{temperature: '(23 ± 2) °C'}"
        ),
    ] = field(default_factory=dict)
    allow_expired_calibration: Annotated[
        bool,
        Described(
            "Run all the same when a calibration has ended; the certificate prints the deviation."
        ),
    ] = False
    simulation: Annotated[
        Simulation | None,
        Described(
            "The simulated bench; with it every instrument is simulated, and the certificate says so."
        ),
    ] = None

    def slots_for(self, model: str, *, vibrates: bool = False, rotates: bool = False) -> tuple[str, ...]:
        """The slots where a model goes: those that name it; where none does, those that name no model.

        Of these the ones on a vibration table or on a level shaft, where that is needed, and the others
        where it is not; where there are none of the kind, all of them.
        """
        naming = [name for name, slot in self.slots.items() if model in slot.models]
        open_to = naming or [name for name, slot in self.slots.items() if not slot.models]
        of_kind = [
            name
            for name in open_to
            if (self.slots[name].vibration is not None) == vibrates
            and (self.shaft(name) is not None) == rotates
        ]
        return tuple(of_kind or open_to)

    def shaft(self, slot: str) -> Shaft | None:
        """How the level shaft lies that carries a slot; None where it is on no such stage."""
        table = self.slots[slot].table
        instrument = self.instruments.get(table) if table is not None else None
        return instrument.shaft if instrument is not None else None


@dataclass(frozen=True, slots=True, kw_only=True)
class StationDocument:
    """A station, the file that it came from and that file's SHA-256 (hex)."""

    path: str
    sha256: str
    station: Station
