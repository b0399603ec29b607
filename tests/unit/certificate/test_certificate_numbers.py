"""Numbers are printed by the GUM, and never tell another story than the value."""

import math
import re
from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gyrotest.certificate.numbers import MINUS, plain, printed, significant

ordinary = st.floats(min_value=1e-4, max_value=1e5) | st.floats(min_value=-1e5, max_value=-1e-4)
anything = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e200, max_value=1e200).filter(
    lambda value: value == 0 or abs(value) > 1e-200
)


def number(text: str) -> Decimal:
    """Read a printed number back."""
    mantissa, _, power = text.partition(" × 10")
    exponent = power.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")) or "0"
    return Decimal(mantissa.replace(MINUS, "-").replace("\N{NARROW NO-BREAK SPACE}", "")).scaleb(
        int(exponent)
    )


def places(text: str) -> int:
    return len(text.partition(" ")[0].partition(".")[2])


@pytest.mark.parametrize(
    ("value", "uncertainty", "expected"),
    [
        (21.8634, 0.9, ("21.86", "0.90")),
        (-0.2184, 0.0041, (f"{MINUS}0.2184", "0.0041")),
        (10.00312, 0.00083, ("10.00312", "0.00083")),
        (9.96, 0.00996, ("9.960", "0.010")),
        (0.0, 0.3, ("0.00", "0.30")),
        (-0.001, 0.3, ("0.00", "0.30")),
        (1234567.8, 12345.0, ("1\u202f235\u202f000", "12\u202f000")),
        (1.2e-9, 3e-11, ("1.200 × 10⁻⁹", "0.030 × 10⁻⁹")),
    ],
)
def test_uncertainty_has_two_digits_and_the_value_ends_there(
    value: float, uncertainty: float, expected: tuple[str, str]
) -> None:
    shown = printed(value, uncertainty=uncertainty)
    assert (shown.value, shown.uncertainty) == expected


def test_interval_keeps_two_digits_of_its_shorter_side() -> None:
    shown = printed(10.31, lower=5.36, upper=64.93)
    assert (shown.lower, shown.value, shown.upper) == ("5.4", "10.3", "64.9")


def test_a_number_near_1_with_many_places_has_no_power_of_ten() -> None:
    shown = printed(0.9999893, lower=0.9999833, upper=0.9999955)
    assert (shown.value, shown.lower, shown.upper) == ("0.9999893", "0.9999833", "0.9999955")
    assert printed(99.99998931, uncertainty=6e-7).value == "99.99998931"
    assert printed(0.00123456789, uncertainty=6e-9).value == "1.2345679 × 10⁻³"


def test_value_just_beyond_its_limit_is_not_rounded_onto_it() -> None:
    assert printed(12.0003, uncertainty=1.0, limits=(12.0,)).value == "12.0003"
    assert printed(12.0, uncertainty=1.0, limits=(12.0,)).value == "12.0"


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (12.0, "12"),
        (40.00000000001, "40"),
        (-0.5, f"{MINUS}0.5"),
        (0.6, "0.6"),
        (0.0, "0"),
        (3600.0000000000005, "3600"),
        (720000.0, "720\u202f000"),
        (1e-8, "1 × 10⁻⁸"),
    ],
)
def test_limits_keep_the_digits_that_the_user_wrote(value: float, expected: str) -> None:
    assert plain(value) == expected


@given(value=ordinary, relative=st.floats(min_value=1e-5, max_value=10.0))
def test_value_and_uncertainty_end_at_the_same_place(value: float, relative: float) -> None:
    uncertainty = abs(value) * relative
    shown = printed(value, uncertainty=uncertainty)
    assert places(shown.value) == places(shown.uncertainty)
    assert abs(number(shown.uncertainty) - Decimal(uncertainty)) <= Decimal(uncertainty) * Decimal(
        "0.051"
    )
    assert abs(number(shown.value) - Decimal(value)) <= Decimal(uncertainty) * Decimal("0.051")


@given(value=anything)
def test_any_number_is_printed_within_its_digits(value: float) -> None:
    for text, digits in (
        (plain(value), 10),
        (significant(value, digits=2), 2),
        (printed(value).value, 4),
    ):
        assert abs(number(text) - Decimal(value)) <= abs(Decimal(value)) * Decimal(10) ** (1 - digits)
        assert "-" not in text
        assert not re.search("[eE]", text)
        assert len(text) < 25


@given(value=ordinary, limit=ordinary, relative=st.floats(min_value=1e-4, max_value=10.0))
def test_printed_value_lies_on_the_same_side_of_a_printed_limit(
    value: float, limit: float, relative: float
) -> None:
    limit = float(f"{limit:.4g}")
    shown = number(printed(value, uncertainty=abs(value) * relative, limits=(limit,)).value)
    if math.isclose(value, limit, rel_tol=1e-9):
        return
    assert (shown > number(plain(limit))) == (value > limit)
    assert (shown < number(plain(limit))) == (value < limit)


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.int64])
def test_numbers_of_numpy_are_printed_as_python_s(kind):
    value, uncertainty = kind(21), kind(2)
    assert printed(value, uncertainty=uncertainty, limits=[kind(20)]) == printed(
        21.0, uncertainty=2.0, limits=[20.0]
    )
    assert (plain(value), significant(value, digits=3)) == ("21", "21.0")
