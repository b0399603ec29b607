"""The spread of the bias over repeats: over power cycles its repeatability, else its run-to-run spread."""

import math

from gyrotest.analysis.repeatability import Repeatability, repeatability
from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.rest.spread import Spread, spread_result
from gyrotest.procedures.wording import plain
from gyrotest.records.plan import Context
from gyrotest.records.result import Result
from gyrotest.records.spec import Between, Case
from gyrotest.units import conversion_factor

_FEWEST = 2
_TOLD = 0.05  # of the spread: less noise of the repeats is not worth telling


def run_to_run_name(case: Case) -> str:
    """Return what the spread of the bias over the repeats is called: by what lies between them."""
    return "bias_repeatability" if case.between_repeats is Between.POWER_CYCLE else "bias_run_to_run"


def biases(repeats: tuple[tuple[Result, ...], ...], context: Context) -> tuple[Result, ...]:
    """Return each repeat's bias; raises `InsufficientDataError` where one lacks, or all are the same."""
    found = [
        one
        for results in repeats
        for one in results
        if one.name == "bias" and one.value is not None and math.isfinite(one.value)
    ]
    if len(found) < max(len(repeats), _FEWEST):
        raise InsufficientDataError(
            f"{context.case_name}: {len(found)} of {len(repeats)} repeats have a bias;"
            f" its spread needs at least {_FEWEST}, and all of them"
        )
    if len({one.value for one in found}) == 1:
        raise InsufficientDataError(
            f"{context.case_name}: all {len(repeats)} repeats have the same bias to the last digit, as the same"
            " samples would give; was a recorded file played again?"
        )
    return tuple(found)


def bias_spread(found: tuple[Result, ...], context: Context, *, unit: str) -> Repeatability:
    """Return mean and spread of biases in a unit.

    Over power cycles the interval is that of the turn-on bias, without each cycle's own noise; with
    no power cycle between the repeats the noise is the very thing that is asked for.
    """
    noise = [_noise(one, unit) if _cycled(context) else 0.0 for one in found]
    return repeatability(
        [(one.value or 0.0) * conversion_factor(one.unit, unit) for one in found], uncertainties=noise
    )


def bias_over_repeats(repeats: tuple[tuple[Result, ...], ...], context: Context) -> Result:
    """Return the sample standard deviation of the bias over repeats; raises `InsufficientDataError`."""
    found = bias_spread(biases(repeats, context), context, unit="deg/h")
    cycled = _cycled(context)
    told = cycled and found.noise >= _TOLD * found.deviation
    condition = f"{found.count} repeats, {'with' if cycled else 'no'} power cycle between"
    noise = f"; contains the noise of each repeat, {plain(found.noise, 2)} °/h" if told else ""
    return spread_result(
        Spread(value=found.deviation, lower=found.lower_95, upper=found.upper_95),
        name=run_to_run_name(context.case),
        label="Bias repeatability" if cycled else "Bias, run to run",
        unit="deg/h",
        condition=condition + noise,
        context=context,
    )


def _cycled(context: Context) -> bool:
    return context.case.between_repeats is Between.POWER_CYCLE


def _noise(bias: Result, unit: str) -> float:
    """Return the standard uncertainty that a bias has by its own record."""
    squares = sum(one.standard_uncertainty**2 for one in bias.budget if one.kind == "A")
    return math.sqrt(squares) * conversion_factor(bias.unit, unit)
