"""The spec: what is tested of a gyro model, how long, how often, and the limits."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Annotated, Any, ClassVar

from gyrotest.records.described import Described
from gyrotest.units import Dimension, OfDimension, Quantity

_OFF_TIME = Quantity(10.0, "s")


class OutputKind(StrEnum):
    """What the gyro gives out."""

    VOLTAGE = "voltage"
    RATE = "rate"
    COUNT = "count"


class OutputMode(StrEnum):
    """What a digital gyro's samples are; all of them are turned into rates."""

    RATE = "rate"
    INCREMENTAL_ANGLE = "incremental_angle"
    AVERAGE_RATE = "average_rate"


class DecisionRule(StrEnum):
    """How a value with its uncertainty is held against a limit (ILAC-G8:09/2019 4.2)."""

    SIMPLE = "simple"
    GUARDED = "guarded"
    GUARDED_NONBINARY = "guarded_nonbinary"


class Over(StrEnum):
    """What a limit's measurement is computed over, where that is more than one acquisition."""

    REPEATS = "repeats"


class Between(StrEnum):
    """What happens between two repeats."""

    NOTHING = "nothing"
    POWER_CYCLE = "power_cycle"


class Gaps(StrEnum):
    """What an analysis that needs uniform samples does with a record that has gaps."""

    REFUSE = "refuse"
    LONGEST_STRETCH = "longest_stretch"


@dataclass(frozen=True, slots=True, kw_only=True)
class Output:
    """The gyro's output: `U = scale_factor · (rate + bias) + zero_rate`."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    kind: Annotated[
        OutputKind,
        Described("What the gyro gives out: a voltage, a rate as numbers, or bare counts.", "voltage"),
    ]
    axes: Annotated[
        tuple[str, ...],
        Described(
            "Names of the sensitive axes, where there are several, as the source names them; each is analysed, "
            "judged and printed.",
            "[x, y, z]",
        ),
    ] = ()
    mode: Annotated[
        OutputMode,
        Described("What a digital gyro's samples are; a unit that is set otherwise is refused."),
    ] = OutputMode.RATE
    scale_factor: Annotated[
        Quantity | None,
        OfDimension(Dimension.SCALE_FACTOR_VOLTAGE, Dimension.NUMBER, Dimension.SCALE_FACTOR_COUNT),
        Described(
            "Nominal output per input rate, signed. Voltages and counts need it; for a rate it is a ratio."
        ),
    ] = None
    scale_factor_uncertainty: Annotated[
        Quantity | None,
        OfDimension(Dimension.NUMBER),
        Described(
            "How far a unit's scale factor may be from the nominal one: the half-width of a rectangular "
            "distribution. Without it nothing derived from the scale factor can be judged with a guard band."
        ),
    ] = None
    zero_rate: Annotated[
        Quantity | None,
        OfDimension(Dimension.VOLTAGE, Dimension.RATE, Dimension.COUNT),
        Described("Nominal output at rest, subtracted from every sample."),
    ] = None
    full_scale: Annotated[
        Quantity | None,
        OfDimension(Dimension.RATE),
        Described("Greatest rate that the model is specified for, of either sign.", "100 deg/s"),
    ] = None
    bandwidth: Annotated[
        Quantity | None,
        OfDimension(Dimension.FREQUENCY),
        Described(
            "The gyro's −3 dB bandwidth; decides whether noise may be corrected for the meter's dead time."
        ),
    ] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Supply:
    """How the model is powered, where the station has a power supply for its slot."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    voltage: Annotated[Quantity, OfDimension(Dimension.VOLTAGE), Described("Supply voltage.", "5 V")]
    current_limit: Annotated[
        Quantity,
        OfDimension(Dimension.CURRENT),
        Described("Current limit; a unit that reaches it is an error.", "200 mA"),
    ]
    over_voltage: Annotated[
        Quantity,
        OfDimension(Dimension.VOLTAGE),
        Described("Over-voltage protection, set before anything else.", "5.5 V"),
    ]
    off_time: Annotated[
        Quantity,
        OfDimension(Dimension.TIME),
        Described(
            "How long the unit stays off in a power cycle, once its voltage has fallen below a tenth of a volt.",
            "10 s",
        ),
    ] = _OFF_TIME


@dataclass(frozen=True, slots=True, kw_only=True)
class Limit:
    """A minimum, a maximum or both, and the rule by which a value is held against them."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    min: Annotated[
        Quantity | None,
        OfDimension(),
        Described("Least value that passes, in any unit of its kind.", "-2 deg/s"),
    ] = None
    max: Annotated[
        Quantity | None,
        OfDimension(),
        Described("Greatest value that passes, in any unit of its kind.", "12 deg/h"),
    ] = None
    decision: Annotated[
        DecisionRule,
        Described(
            "The rule: `simple` holds the value against the limit, `guarded` passes only if the whole uncertainty "
            "interval lies inside, `guarded_nonbinary` has conditional verdicts between."
        ),
    ] = DecisionRule.SIMPLE
    over: Annotated[
        Over | None,
        Described("What the value is computed over, if not over one acquisition.", "repeats"),
    ] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One entry of a spec: a procedure with its times, repeats, parameters and limits."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    procedure: Annotated[
        str, Described("The test kind, by the name under which it is installed.", "static")
    ]
    duration: Annotated[
        Quantity,
        OfDimension(Dimension.TIME),
        Described("Length of each record; a whole number of intervals.", "1 h"),
    ]
    interval: Annotated[
        Quantity,
        OfDimension(Dimension.TIME),
        Described("Time from sample to sample; as many readings as fit are averaged in each.", "1 s"),
    ]
    warm_up: Annotated[
        Quantity | None,
        OfDimension(Dimension.TIME),
        Described(
            "Time from power-on to the first sample; waited for once after each power-on.", "10 min"
        ),
    ] = None
    repeats: Annotated[int, Described("How often the record is taken.", "3")] = 1
    between_repeats: Annotated[
        Between,
        Described(
            "What happens between two repeats; `power_cycle` switches the unit off and warms up again."
        ),
    ] = Between.NOTHING
    retests: Annotated[
        int,
        Described(
            "How many completed acquisitions that failed may be taken again; the certificate says so.",
            "0",
        ),
    ] = 0
    mounting: Annotated[
        tuple[float, float, float] | None,
        Described(
            "Direction of the sensitive axis as [up, north, east], of any length. With the station's site it "
            "gives the Earth's rate, which is subtracted; without it a bias is uncertain by the whole of it.",
            "[1, 0, 0]",
        ),
    ] = None
    mountings: Annotated[
        Mapping[str, tuple[float, float, float]],
        Described(
            "Of a gyro with several axes: the direction of each, as `mounting` gives it for one.",
            "{x: [0, 1, 0], y: [0, 0, 1], z: [1, 0, 0]}",
        ),
    ] = field(default_factory=dict)
    axes: Annotated[
        tuple[str, ...],
        Described(
            "Which of the output's axes this case judges; all by default. On a rate table the one along its axis.",
            "[z]",
        ),
    ] = ()
    allowed_loss: Annotated[
        Quantity | None,
        OfDimension(Dimension.NUMBER),
        Described(
            "Share of the samples that may be lost on the way; more ends the acquisition. Without it any number "
            "may, and `gaps` says what becomes of them.",
            "10 ppm",
        ),
    ] = None
    gaps: Annotated[
        Gaps,
        Described("What an analysis that needs uniform samples does where some are missing."),
    ] = Gaps.REFUSE
    parameters: Annotated[
        Mapping[str, Any],
        Described("The procedure's own parameters.", "{smoothing: [1 s, 10 s, 100 s]}"),
    ] = field(default_factory=dict)
    limits: Annotated[
        Mapping[str, Limit],
        Described(
            "Limits, by the name of what the procedure measures.", "{allan_minimum: {max: 12 deg/h}}"
        ),
    ] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Spec:
    """A gyro model's spec."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    model: Annotated[str, Described("The model's name, as it is printed.", "MEMS50")]
    output: Annotated[
        Output, Described("What the gyro gives out.", "{kind: voltage, scale_factor: 50 mV/(deg/s)}")
    ]
    cases: Annotated[
        Mapping[str, Case], Described("What is tested: a name for each case, and the case.")
    ]
    supply: Annotated[
        Supply | None,
        Described(
            "How the model is powered. Without it a station's power supply is left alone.",
            "{voltage: 5 V, current_limit: 200 mA, over_voltage: 5.5 V}",
        ),
    ] = None
    description: Annotated[
        str, Described("What the model is, in a line.", "Single-axis analogue MEMS gyro")
    ] = ""
    title: Annotated[str, Described("Title of the certificate.", "Test certificate")] = (
        "Test certificate"
    )
    document: Annotated[
        str,
        Described(
            "Number and revision of the test specification that this file carries out.", "TS-1042 rev. C"
        ),
    ] = ""
    manufacturer: Annotated[str, Described("Who makes the model.", "Example Gyros Ltd")] = ""
    serial_pattern: Annotated[
        str | None,
        Described("Regular expression that a serial number matches as a whole.", "'[0-9]{4,8}'"),
    ] = None
    datasheet: Annotated[
        Mapping[str, Annotated[Quantity, OfDimension()]],
        Described(
            "The datasheet's figures, printed beside the measured ones and not judged.",
            "{angle_random_walk: 0.5 deg/sqrt(h)}",
        ),
    ] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class SpecDocument:
    """A spec, the file that it came from and that file's SHA-256 (hex)."""

    path: str
    sha256: str
    spec: Spec
