"""Threshold or resolution as a result, and the response at the stated value."""

from dataclasses import dataclass

from gyrotest.analysis.interval import coverage_factor
from gyrotest.analysis.small_steps import Followed, Level, Response, SmallestFollowed, smallest_followed
from gyrotest.procedures.threshold.levels import Levels, table_uncertainty_dps
from gyrotest.procedures.threshold.parameters import ThresholdParameters
from gyrotest.procedures.wording import ending, places_of, plain, rate_text
from gyrotest.records.plan import Context
from gyrotest.records.result import Measurand, Result
from gyrotest.units import Dimension

_K = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """Which of the two is measured: its name, and how its result and the response are labelled."""

    name: str
    label: str

    @property
    def response_name(self) -> str:
        """Name of the response at the stated value."""
        return f"{self.name}_response"

    @property
    def response_label(self) -> str:
        """Label of the response at the stated value."""
        return f"{self.label}, response at the stated value"


def small_step_measurands(kind: Kind) -> tuple[Measurand, ...]:
    """Return all that a case measures."""
    return (
        Measurand(name=kind.name, label=kind.label, dimension=Dimension.RATE, unit="deg/s"),
        Measurand(
            name=kind.response_name,
            label=kind.response_label,
            dimension=Dimension.NUMBER,
            unit="%",
        ),
    )


def small_step_results(
    found: Levels, kind: Kind, parameters: ThresholdParameters, context: Context
) -> tuple[Result, ...]:
    """Return the smallest change that is followed, and how much of the stated one is."""
    stated = found.levels[parameters.levels.index(1.0)]
    return (
        _smallest_result(found, kind, parameters, context),
        _response_result(stated, kind),
    )


def _response_result(stated: Level, kind: Kind) -> Result:
    weaker = stated.weaker
    factor = coverage_factor(weaker.degrees_of_freedom)
    way = "up" if weaker is stated.up else "down"
    return Result(
        name=kind.response_name,
        label=kind.response_label,
        value=weaker.share * 100.0,
        unit="%",
        expanded_uncertainty=factor * weaker.standard_uncertainty * 100.0,
        coverage_factor=factor,
        condition=f"of the nominal scale factor, changes {way} by {rate_text(stated.size_dps, 3)}",
    )


def _smallest_result(
    found: Levels, kind: Kind, parameters: ThresholdParameters, context: Context
) -> Result:
    levels, smallest = found.levels, smallest_followed(found.levels)
    if smallest.place is None:
        return _beyond(levels[-1], kind, parameters, context)
    level = levels[smallest.place]
    below = None if smallest.not_followed is None else levels[smallest.not_followed]
    half_dps = _half_dps(level, parameters, context)
    return Result(
        name=kind.name,
        label=kind.label,
        value=level.size_dps,
        unit="deg/s",
        lower_95=0.0
        if below is None
        else max(below.size_dps - _half_dps(below, parameters, context), 0.0),
        upper_95=level.size_dps + half_dps,
        at_most=smallest.place == 0,
        condition=_condition(levels, smallest, parameters),
    )


def _condition(
    levels: tuple[Level, ...], smallest: SmallestFollowed, parameters: ThresholdParameters
) -> str:
    """Say what the level gives, and what the next one below it does."""
    place = smallest.place or 0
    told = [_about(parameters), f"gives {_shares(levels[place])}"]
    if place == 0:
        told.append("nothing smaller was tried")
    else:
        below = levels[place - 1]
        word = "is not followed" if below.followed is Followed.NO else "noise does not let tell"
        told.append(f"{rate_text(below.size_dps, 3)} gives {_shares(below)}: {word}")
    return "; ".join(told)


def _beyond(largest: Level, kind: Kind, parameters: ThresholdParameters, context: Context) -> Result:
    """Return that not even the largest change is followed, or that noise does not let tell."""
    size = rate_text(largest.size_dps, 3)
    shares = f"{_about(parameters)}; the largest change of {size} gives {_shares(largest)}"
    if largest.followed is Followed.UNDECIDED:
        return Result(
            name=kind.name,
            label=kind.label,
            value=None,
            unit="deg/s",
            condition=f"{shares}: noise does not let tell; take longer or more steps",
        )
    return Result(
        name=kind.name,
        label=kind.label,
        value=largest.size_dps,
        unit="deg/s",
        lower_95=max(largest.size_dps - _half_dps(largest, parameters, context), 0.0),
        condition=f"more than that: {shares}",
    )


def _half_dps(level: Level, parameters: ThresholdParameters, context: Context) -> float:
    if context.table is None:
        return 0.0
    return _K * table_uncertainty_dps(context.table, level.size_dps, parameters)


def _about(parameters: ThresholdParameters) -> str:
    around = parameters.around_dps
    where = "rest" if around == 0.0 else rate_text(around, 4)
    return f"{parameters.steps} changes each way from {where}"


def _shares(level: Level) -> str:
    return f"{_share(level.up)} up, {_share(level.down)} down"


def _share(response: Response) -> str:
    half = response.half_width * 100.0
    return f"({ending(response.share * 100.0, places_of(half))} ± {plain(half, 2)}) %"
