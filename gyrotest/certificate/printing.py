"""Texts of a record as they are printed for people."""

import re

from gyrotest.units import printed_unit

_DEGREES = re.compile(r" °(?![/A-Z])")  # an angle's sign follows its number at once


def printed_text(text: str) -> str:
    """Print the units of a text."""
    return _DEGREES.sub("°", printed_unit(text))
