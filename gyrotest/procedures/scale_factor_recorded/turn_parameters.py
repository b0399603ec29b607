"""What a case with a turn by a known angle may be told."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, ClassVar

from gyrotest.records.described import Described
from gyrotest.records.spec import Case
from gyrotest.units import Dimension, OfDimension, Quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class TurnParameters:
    """Parameters of a `scale_factor_turn` case."""

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}

    angle: Annotated[
        Quantity,
        OfDimension(Dimension.ANGLE),
        Described("the angle of the turn, signed about the sensitive axis", "-360 deg"),
    ]
    angle_uncertainty: Annotated[
        Quantity | None,
        OfDimension(Dimension.ANGLE),
        Described(
            "how far the angle may be off: the half-width of a rectangular distribution", "0.5 deg"
        ),
    ] = None
    time_uncertainty: Annotated[
        Quantity | None,
        OfDimension(Dimension.NUMBER),
        Described("how far the sampling rate may be off: a half-width too", "50 ppm"),
    ] = None
    rest: Annotated[
        Quantity | None,
        OfDimension(Dimension.TIME),
        Described("how long the gyro is at rest at each end; found in the record by default", "1 s"),
    ] = None
    rest_before: Annotated[
        Quantity | None,
        OfDimension(Dimension.TIME),
        Described(
            "how long it is at rest before the turn, in the place of `rest`; 0 s: not at all", "10 s"
        ),
    ] = None
    rest_after: Annotated[
        Quantity | None,
        OfDimension(Dimension.TIME),
        Described(
            "how long it is at rest after the turn, in the place of `rest`; 0 s: not at all", "10 s"
        ),
    ] = None

    @property
    def before(self) -> Quantity | None:
        """The rest before the turn, where it is given."""
        return self.rest if self.rest_before is None else self.rest_before

    @property
    def after(self) -> Quantity | None:
        """The rest after the turn, where it is given."""
        return self.rest if self.rest_after is None else self.rest_after


def turn_complaints(case: Case, parameters: TurnParameters) -> Iterator[tuple[str, str]]:
    """Give what is wrong with a case beyond its types: key and message."""
    if parameters.angle.value == 0.0:
        yield "parameters.angle", f"'{parameters.angle}' is no turn; write e.g. '360 deg'"
    for name in ("angle_uncertainty", "time_uncertainty", "rest", "rest_before", "rest_after"):
        value: Quantity | None = getattr(parameters, name)
        if value is not None and value.value < 0.0:
            yield f"parameters.{name}", f"'{value}' is less than zero"
    given = [one.to("s") for one in (parameters.before, parameters.after) if one is not None]
    if len(given) == 1:
        missing = "rest_before" if parameters.before is None else "rest_after"
        other = "rest_after" if parameters.before is None else "rest_before"
        yield (
            f"parameters.{other}",
            f"is given without '{missing}'; give both, 0 s where there is no rest",
        )
    elif given and sum(given) <= 0.0:
        yield "parameters.rest", "leaves no rest at either end, and the output at rest is not known then"
    elif given and sum(given) >= case.duration.to("s"):
        yield "parameters.rest", f"leaves nothing for the turn of the record's {case.duration}"
