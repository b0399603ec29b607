"""What a reader of a certificate must know of the steps: few rates, samples dropped, a sign, read-backs."""

from collections.abc import Iterator

from gyrotest.procedures.scale_factor.parameters import (
    FEWEST_RATES,
    ScaleFactorParameters,
    rates_of_sign,
)
from gyrotest.procedures.step_table import dropped_samples
from gyrotest.procedures.turns import Turns
from gyrotest.procedures.wording import plain, rate_text
from gyrotest.records.plan import Context

_MINUS = "\N{MINUS SIGN}"
_OF_TOLERANCE = 0.5


def turn_remarks(turns: Turns, context: Context) -> Iterator[str]:
    """Give the remarks of one acquisition."""
    yield from few_rates(tuple(float(one) for one in turns.rates_dps))
    yield from dropped_samples((*turns.rest, *turns.turning))
    if turns.fit.scale_factor.value * turns.scaling.scale_factor < 0.0:
        yield "The scale factor has the opposite sign of the nominal one: the gyro or the table is inverted."
    yield from _off_readings(turns, context)


def few_rates(rates_dps: tuple[float, ...]) -> Iterator[str]:
    """Say that there are fewer rates than the method asks for."""
    forward, backward = rates_of_sign(rates_dps, 1), rates_of_sign(rates_dps, -1)
    if min(forward, backward) < FEWEST_RATES:
        yield (
            f"Deviation: {forward} rates forward and {backward} backward; the method asks for at least"
            f" {FEWEST_RATES} of each sign."
        )


def _off_readings(turns: Turns, context: Context) -> Iterator[str]:
    """Name the step whose read-back is farthest from its rate, where it comes close to the tolerance.

    A read-back is a mean of a few, ripple in it: smaller differences say nothing.
    """
    parameters: ScaleFactorParameters = context.parameters
    worrying_dps = _OF_TOLERANCE * parameters.tolerance.to("deg/s")
    off = [
        (abs(one.dwell.measured_rate_dps - one.rate_dps), one)
        for one in turns.turning
        if one.dwell.measured_rate_dps is not None
    ]
    largest, record = max(off, key=lambda pair: pair[0], default=(0.0, turns.turning[0]))
    if largest > worrying_dps:
        rate = plain(record.rate_dps, 6).replace("-", _MINUS)
        yield (
            f"The table's read-back is off by {rate_text(largest)} at {rate} °/s; the rates asked for are used."
        )
