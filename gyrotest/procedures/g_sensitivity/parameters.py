"""What a g-sensitivity case may be told, and the steps that follow from it."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, ClassVar

from gyrotest.procedures.case_plan import step_samples
from gyrotest.records.described import Described, EarlierCase
from gyrotest.records.plan import Placement, Pointing, Rotating, Step
from gyrotest.records.spec import Case
from gyrotest.units import Dimension, OfDimension, Quantity

_RATE = Quantity(6.0, "deg/s")
_TOLERANCE = Quantity(0.05, "deg/s")
_RUN_UP = Quantity(5.0, "deg")
_SETTLE = Quantity(2.0, "s")
_WITHIN = Quantity(0.2, "deg")


class OwnAxis(StrEnum):
    """An axis of the unit's own."""

    X = "x"
    Y = "y"
    Z = "z"


@dataclass(frozen=True, slots=True, kw_only=True)
class GSensitivityParameters:
    """Parameters of a g-sensitivity case.

    Its `duration` is that of the records at rest before and after the turns, at the angle 0; where the
    shaft stands at `positions` instead of turning, that of the record at each of them. How long a turn
    lasts follows from its rate.
    """

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}

    sensitive_axis: Annotated[
        OwnAxis,
        Described("which of its own axes the unit senses rotation about"),
    ] = OwnAxis.X
    rate: Annotated[
        Quantity,
        OfDimension(Dimension.RATE),
        Described("how fast the shaft turns", "6 deg/s"),
    ] = _RATE
    turns: Annotated[int, Described("how often it turns from 0° to 360° and back to 0°", "5")] = 5
    run_up: Annotated[
        Quantity,
        OfDimension(Dimension.ANGLE),
        Described("within it from either end the shaft runs up or stops, and is not sampled", "5 deg"),
    ] = _RUN_UP
    tolerance: Annotated[
        Quantity,
        OfDimension(Dimension.RATE),
        Described("how far the stage's read-back may be from the rate", "0.05 deg/s"),
    ] = _TOLERANCE
    positions: Annotated[
        tuple[Annotated[Quantity, OfDimension(Dimension.ANGLE)], ...],
        Described(
            "angles at which the shaft stands, in their order, instead of turning: the conventional static"
            " method",
            "[0 deg, 90 deg, 180 deg, 270 deg]",
        ),
    ] = ()
    settle: Annotated[
        Quantity,
        OfDimension(Dimension.TIME),
        Described("how long the shaft has stood before a record at rest begins", "2 s"),
    ] = _SETTLE
    placements: Annotated[
        tuple[Annotated[Quantity, OfDimension(Dimension.ANGLE)], ...],
        Described(
            "by how much the unit is turned about its own sensitive axis in each repeat; in quarters of a turn",
            "[0 deg, 90 deg]",
        ),
    ] = (Quantity(0.0, "deg"), Quantity(90.0, "deg"))
    placement_uncertainty: Annotated[
        Quantity,
        OfDimension(Dimension.ANGLE),
        Described("how well the unit is put there: a half-width", "0.2 deg"),
    ] = _WITHIN
    outlier_mads: Annotated[
        float,
        Described(
            "so many median absolute deviations from the model a sample is an outlier; more than 1 % of them"
            " are an error",
            "7.5",
        ),
    ] = 7.5
    scale_factor_from: Annotated[
        str | None,
        EarlierCase(),
        Described(
            "an earlier case of the spec whose scale factor is used; the nominal one by default",
            "scale_factor",
        ),
    ] = None
    compare_with: Annotated[
        str | None,
        EarlierCase("g_sensitivity"),
        Described(
            "an earlier case of this procedure that measured the same by the other method", "positions"
        ),
    ] = None

    @property
    def turning(self) -> bool:
        """Whether the shaft turns; else it stands at the positions."""
        return not self.positions

    @property
    def rate_dps(self) -> float:
        """How fast the shaft turns, °/s."""
        return self.rate.to("deg/s")

    @property
    def placements_deg(self) -> tuple[float, ...]:
        """How the unit is turned in each repeat, °."""
        return tuple(one.to("deg") for one in self.placements)

    @property
    def mounted(self) -> tuple[Placement, ...]:
        """The same for a plan."""
        return tuple(
            Placement(sensitive_axis=self.sensitive_axis.value, turned_deg=one)
            for one in self.placements_deg
        )

    def placement(self, repeat: int | None) -> Placement:
        """How the unit is mounted in a repeat, counted from 1."""
        return self.mounted[((repeat or 1) - 1) % len(self.mounted)]


def steps_of(case: Case, parameters: GSensitivityParameters) -> tuple[Step, ...]:
    """Return the steps of a repeat: at rest, there and back as often as asked for, at rest; or the positions."""
    if parameters.turning:
        return (
            _standing(case, parameters, "rest before", 0.0),
            *_turns(case, parameters),
            _standing(case, parameters, "rest after", 0.0),
        )
    return tuple(
        _standing(case, parameters, f"position {number}", one.to("deg"))
        for number, one in enumerate(parameters.positions, start=1)
    )


def turn_samples(case: Case, parameters: GSensitivityParameters) -> int:
    """Return how many samples fit between the run-ups of a turn."""
    sampled_deg = 360.0 - 2.0 * parameters.run_up.to("deg")
    return math.floor(sampled_deg / parameters.rate_dps / case.interval.to("s"))


def _standing(case: Case, parameters: GSensitivityParameters, name: str, position_deg: float) -> Step:
    pointing = Pointing(position_deg=position_deg, settle_s=parameters.settle.to("s"))
    return Step(samples=step_samples(case), name=name, stimulus=pointing)


def _turns(case: Case, parameters: GSensitivityParameters) -> Iterator[Step]:
    for number in range(1, parameters.turns + 1):
        for way, sign in (("forward", 1.0), ("back", -1.0)):
            yield Step(
                samples=turn_samples(case, parameters),
                name=f"turn {number} {way}",
                stimulus=Rotating(
                    rate_dps=sign * parameters.rate_dps,
                    run_up_deg=parameters.run_up.to("deg"),
                    tolerance_dps=parameters.tolerance.to("deg/s"),
                ),
            )
