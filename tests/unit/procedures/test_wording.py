"""Numbers in texts carry no exponents."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gyrotest.procedures.wording import ending, engineering, freedom, places_of, plain


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (8.76e-5, "V", "88 µV"),
        (5e-5, "V", "50 µV"),
        (9.96e-4, "V", "1 mV"),
        (2.5, "V", "2.5 V"),
        (0.0, "V", "0 V"),
        (1.2e-12, "V", "0.0012 nV"),
        (0.0048828125, "s", "4.9 ms"),
        (12345.0, "deg/h", "12000 °/h"),
    ],
)
def test_quantities_have_the_prefix_that_suits_them(value: float, unit: str, text: str) -> None:
    assert engineering(value, unit) == text


@pytest.mark.parametrize(
    ("degrees", "text"),
    [(2530.4, "2530 d.o.f."), (9.03, "9 d.o.f."), (3.46, "3.5 d.o.f."), (35.6, "36 d.o.f.")],
)
def test_degrees_of_freedom_are_short(degrees: float, text: str) -> None:
    assert freedom(degrees) == text


@given(st.floats(-1e12, 1e12), st.integers(1, 8))
def test_plain_digits_are_the_rounded_number_without_an_exponent(value: float, digits: int) -> None:
    text = plain(value, digits)
    assert "e" not in text.lower()
    assert float(text) == float(f"{value:.{digits}g}")


@pytest.mark.parametrize(
    ("value", "uncertainty", "told"),
    [
        (92.87, 15.2, "93"),
        (0.0283, 0.0995, "0.03"),
        (-1.0020551, 4.1e-5, "−1.002055"),
        (-0.2, 31.0, "0"),
    ],
)
def test_a_value_ends_where_two_digits_of_its_uncertainty_end(value, uncertainty, told):
    assert ending(value, places_of(uncertainty)) == told
