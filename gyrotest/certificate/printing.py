"""Texts of a record as they are printed for people."""

import re
from collections.abc import Sequence

from gyrotest.units import printed_unit

_DEGREES = re.compile(r" °(?![/A-Z])")  # an angle's sign follows its number at once


def printed_text(text: str) -> str:
    """Print the units of a text."""
    return _DEGREES.sub("°", printed_unit(text))


def numbers_in_words(numbers: Sequence[int]) -> str:
    """Print rising numbers one after another; more than two that follow one another as a span."""
    first, last = min(numbers, default=0), max(numbers, default=0)
    if len(numbers) > 2 and list(numbers) == list(range(first, last + 1)):
        return f"{first} … {last}"
    return ", ".join(str(one) for one in numbers)
