"""What is wrong with a case of either vibration beyond its types: what both have in common."""

from collections.abc import Iterator

from gyrotest.procedures.scaling import nominal_complaints
from gyrotest.records.spec import Case, Output
from gyrotest.units import Quantity

LEAST_OVERSAMPLING = 4.0
"""Samples in a period of the highest frequency that is kept, at least."""


def vibration_complaints(
    case: Case, output: Output, *, level: Quantity, settle: Quantity
) -> Iterator[tuple[str, str]]:
    """Give complaints of the output, the axes and how the table is driven: key below the case, and message."""
    yield from nominal_complaints(output)
    axes = case.axes or output.axes
    if len(axes) > 1:
        yield (
            "axes",
            f"names {len(axes)} axes, and the table vibrates about one; name that, e.g. [{axes[-1]}]",
        )
    if level.value <= 0.0:
        yield "parameters.level", f"'{level}' is not more than zero"
    if settle.value < 0.0:
        yield "parameters.settle", f"'{settle}' is less than zero"


def repeated_frequencies(frequencies: tuple[Quantity, ...]) -> Iterator[tuple[str, str]]:
    """Give a complaint of each frequency that is there before already."""
    seen: set[float] = set()
    for place, one in enumerate(frequencies):
        if one.to("Hz") in seen:
            yield f"parameters.frequencies[{place}]", f"'{one}' is there twice"
        seen.add(one.to("Hz"))
