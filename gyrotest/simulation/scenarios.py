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
)

SCENARIOS: Mapping[str, Scenario] = {scenario.name: scenario for scenario in _ALL}
