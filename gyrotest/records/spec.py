"""The spec: what is tested of a gyro model, how long, how often, and the limits."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Annotated, Any

from gyrotest.units import Dimension, OfDimension, Quantity


class OutputKind(StrEnum):
    """What the gyro gives out."""

    VOLTAGE = "voltage"
    RATE = "rate"


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

    __pydantic_config__ = {"extra": "forbid", "strict": True}

    kind: OutputKind
    scale_factor: Annotated[
        Quantity | None, OfDimension(Dimension.SCALE_FACTOR_VOLTAGE, Dimension.NUMBER)
    ] = None
    scale_factor_uncertainty: Annotated[Quantity | None, OfDimension(Dimension.NUMBER)] = None
    zero_rate: Annotated[Quantity | None, OfDimension(Dimension.VOLTAGE, Dimension.RATE)] = None
    full_scale: Annotated[Quantity | None, OfDimension(Dimension.RATE)] = None
    bandwidth: Annotated[Quantity | None, OfDimension(Dimension.FREQUENCY)] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Limit:
    """A minimum, a maximum or both, and the rule by which a value is held against them."""

    __pydantic_config__ = {"extra": "forbid", "strict": True}

    min: Annotated[Quantity | None, OfDimension()] = None
    max: Annotated[Quantity | None, OfDimension()] = None
    decision: DecisionRule = DecisionRule.SIMPLE
    over: Over | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One entry of a spec: a procedure with its times, repeats, parameters and limits."""

    __pydantic_config__ = {"extra": "forbid", "strict": True}

    procedure: str
    duration: Annotated[Quantity, OfDimension(Dimension.TIME)]
    interval: Annotated[Quantity, OfDimension(Dimension.TIME)]
    warm_up: Annotated[Quantity | None, OfDimension(Dimension.TIME)] = None
    repeats: int = 1
    between_repeats: Between = Between.NOTHING
    retests: int = 0
    mounting: tuple[float, float, float] | None = None
    gaps: Gaps = Gaps.REFUSE
    parameters: Mapping[str, Any] = field(default_factory=dict)
    limits: Mapping[str, Limit] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Spec:
    """A gyro model's spec."""

    __pydantic_config__ = {"extra": "forbid", "strict": True}

    model: str
    output: Output
    cases: Mapping[str, Case]
    description: str = ""
    title: str = "Test certificate"
    document: str = ""
    manufacturer: str = ""
    serial_pattern: str | None = None
    datasheet: Mapping[str, Annotated[Quantity, OfDimension()]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class SpecDocument:
    """A spec, the file that it came from and that file's SHA-256 (hex)."""

    path: str
    sha256: str
    spec: Spec
