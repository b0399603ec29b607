"""The scenarios: a closed table of units that fail and instruments that misbehave."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum, auto


class Misbehaviour(Enum):
    """What can go wrong on the simulated bench in the middle of a record."""

    NO_REPLY = auto()
    HANG_UP = auto()
    DEAD = auto()
    GARBLE = auto()
    STUCK = auto()
    RAIL = auto()
    TABLE_SLOW = auto()
    TABLE_INTERLOCK = auto()
    TABLE_REFUSES = auto()
    SUPPLY_NO_VOLTAGE = auto()
    SUPPLY_CURRENT_LIMIT = auto()
    CHAMBER_STUCK = auto()
    EXCITER_SILENT = auto()
    EXCITER_LOST = auto()
    LOST_FRAMES = auto()
    LOST_COUNTER_PERIOD = auto()
    BAD_CRC = auto()
    LINE_NOISE = auto()
    UNPLUGGED = auto()
    WRONG_BAUD_RATE = auto()
    OVERLOAD_STATUS = auto()
    CHANNEL_ERROR = auto()
    OTHER_DEVICE = auto()
    OTHER_CONFIGURATION = auto()
    LOST_SAMPLES = auto()
    BAD_BLOCK = auto()
    LOST_CONNECTION = auto()
    ENCODER_DARK = auto()


@dataclass(frozen=True, slots=True, kw_only=True)
class Strike:
    """A misbehaviour and when it strikes, as a fraction of the record's duration."""

    misbehaviour: Misbehaviour
    at: float
    until: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """A named state of the bench: factors on the unit's figures, and what strikes when."""

    name: str
    description: str
    factors: Mapping[str, float] = field(default_factory=dict)
    dead_output: bool = False
    inverted: bool = False
    strikes: tuple[Strike, ...] = ()

    def has(self, misbehaviour: Misbehaviour) -> bool:
        """Whether something goes wrong here, at whatever time."""
        return any(strike.misbehaviour is misbehaviour for strike in self.strikes)


def _standing(name: str, misbehaviour: Misbehaviour, description: str) -> Scenario:
    """What is wrong from the start."""
    return Scenario(
        name=name, description=description, strikes=(Strike(misbehaviour=misbehaviour, at=0.0),)
    )


_ALL = (
    Scenario(name="nominal", description="a unit as the station describes it, a bench that works"),
    Scenario(
        name="out-of-limits",
        description="a unit with far more noise and bias than its model allows",
        factors={
            "angle_random_walk": 4.0,
            "bias_instability_coefficient": 6.0,
            "rate_random_walk": 8.0,
            "turn_on_bias": 20.0,
        },
    ),
    Scenario(name="dead-output", description="a steady zero-rate voltage", dead_output=True),
    Scenario(name="inverted", description="a negative scale factor", inverted=True),
    Scenario(
        name="overload",
        description="the output leaves the meter's range for a while",
        strikes=(Strike(misbehaviour=Misbehaviour.RAIL, at=0.4, until=0.42),),
    ),
    Scenario(
        name="meter-timeout",
        description="one reply of the meter never comes",
        strikes=(Strike(misbehaviour=Misbehaviour.NO_REPLY, at=0.4),),
    ),
    Scenario(
        name="meter-disconnects",
        description="the meter closes the connection once and accepts a new one",
        strikes=(Strike(misbehaviour=Misbehaviour.HANG_UP, at=0.4),),
    ),
    Scenario(
        name="meter-dead",
        description="the meter stops answering for good",
        strikes=(Strike(misbehaviour=Misbehaviour.DEAD, at=0.4),),
    ),
    Scenario(
        name="garbled-replies",
        description="some replies of the meter are garbage",
        strikes=tuple(Strike(misbehaviour=Misbehaviour.GARBLE, at=at) for at in (0.3, 0.5, 0.7)),
    ),
    Scenario(
        name="stuck-reading",
        description="from some reading on the meter repeats the same value",
        strikes=(Strike(misbehaviour=Misbehaviour.STUCK, at=0.5),),
    ),
    Scenario(
        name="lost-frames",
        description="a digital gyro's frames are lost on the way, three times a few of them",
        strikes=tuple(Strike(misbehaviour=Misbehaviour.LOST_FRAMES, at=at) for at in (0.3, 0.5, 0.7)),
    ),
    Scenario(
        name="lost-counter-period",
        description="so many frames are lost at once that the frames' counter shows no jump",
        strikes=(Strike(misbehaviour=Misbehaviour.LOST_COUNTER_PERIOD, at=0.4),),
    ),
    Scenario(
        name="bad-crc",
        description="for a while every third frame of a digital gyro is damaged",
        strikes=(Strike(misbehaviour=Misbehaviour.BAD_CRC, at=0.4, until=0.41),),
    ),
    Scenario(
        name="garbage-on-the-line",
        description="noise on the serial line puts bytes between a digital gyro's frames",
        strikes=(Strike(misbehaviour=Misbehaviour.LINE_NOISE, at=0.4, until=0.41),),
    ),
    Scenario(
        name="unplugged",
        description="a digital gyro's line goes dead in the middle of the record",
        strikes=(Strike(misbehaviour=Misbehaviour.UNPLUGGED, at=0.4),),
    ),
    Scenario(
        name="overload-status",
        description="a digital gyro says for a while that its range is exceeded",
        strikes=(Strike(misbehaviour=Misbehaviour.OVERLOAD_STATUS, at=0.4, until=0.41),),
    ),
    Scenario(
        name="channel-error",
        description="a digital gyro reports a fault of its first axis for a while",
        strikes=(Strike(misbehaviour=Misbehaviour.CHANNEL_ERROR, at=0.4, until=0.41),),
    ),
    _standing(
        "wrong-baud-rate", Misbehaviour.WRONG_BAUD_RATE, "a digital gyro sends at another baud rate"
    ),
    _standing(
        "other-device", Misbehaviour.OTHER_DEVICE, "another unit sits in the slot: its serial number"
    ),
    _standing(
        "other-configuration",
        Misbehaviour.OTHER_CONFIGURATION,
        "a digital gyro is set to another output unit",
    ),
    Scenario(
        name="daq-overrun",
        description="a synchronous source cannot keep up for a moment: it says that samples were lost",
        strikes=(Strike(misbehaviour=Misbehaviour.LOST_SAMPLES, at=0.4),),
    ),
    Scenario(
        name="daq-bad-block",
        description="one block of a synchronous source is damaged on its way",
        strikes=(Strike(misbehaviour=Misbehaviour.BAD_BLOCK, at=0.4),),
    ),
    Scenario(
        name="daq-lost",
        description="a synchronous source breaks the connection once and accepts a new one",
        strikes=(Strike(misbehaviour=Misbehaviour.LOST_CONNECTION, at=0.4),),
    ),
    Scenario(
        name="encoder-lost",
        description="for a while the encoder gives no signal",
        strikes=(Strike(misbehaviour=Misbehaviour.ENCODER_DARK, at=0.4, until=0.45),),
    ),
    _standing(
        "table-does-not-reach-rate", Misbehaviour.TABLE_SLOW, "the table stays below the rate asked for"
    ),
    Scenario(
        name="table-interlock",
        description="the table's interlock opens in the middle of the record",
        strikes=(Strike(misbehaviour=Misbehaviour.TABLE_INTERLOCK, at=0.4),),
    ),
    _standing("table-refuses", Misbehaviour.TABLE_REFUSES, "the table refuses every rate"),
    _standing(
        "supply-no-voltage", Misbehaviour.SUPPLY_NO_VOLTAGE, "the supply's voltage does not come up"
    ),
    _standing(
        "supply-current-limit",
        Misbehaviour.SUPPLY_CURRENT_LIMIT,
        "the unit draws so much that the supply limits its current",
    ),
    _standing(
        "chamber-does-not-reach",
        Misbehaviour.CHAMBER_STUCK,
        "the chamber stays where it is, whatever it is asked for",
    ),
    Scenario(
        name="exciter-silent",
        description="the output that drives the vibration table goes off by itself",
        strikes=(Strike(misbehaviour=Misbehaviour.EXCITER_SILENT, at=0.4),),
    ),
    Scenario(
        name="exciter-lost",
        description="what drives the vibration table answers no more from the middle of the record on",
        strikes=(Strike(misbehaviour=Misbehaviour.EXCITER_LOST, at=0.4),),
    ),
)

SCENARIOS: Mapping[str, Scenario] = {scenario.name: scenario for scenario in _ALL}
