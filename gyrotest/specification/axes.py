"""What must hold of a gyro's axes, in the output and in each case."""

import math
from collections import Counter
from collections.abc import Iterator

from gyrotest.records.spec import Case, Output
from gyrotest.specification.checked import Complaint
from gyrotest.specification.shapes import nearest
from gyrotest.specification.yaml_tree import KeyPath

_AXIS = "an axis is named by letters and digits, e.g. 'x'"


def output_axes_complaints(output: Output) -> Iterator[Complaint]:
    """Give what is wrong with the names of the axes."""
    for place, (axis, count) in enumerate(Counter(output.axes).items()):
        if not axis.isalnum() or not axis.isascii() or len(axis) > 16:
            yield Complaint(("output", "axes", place), f"{axis[:40]!r} is no name; {_AXIS}")
        if count > 1:
            yield Complaint(("output", "axes"), f"axis '{axis}' is named {count} times")


def case_axes_complaints(case: Case, output: Output, key: KeyPath) -> Iterator[Complaint]:
    """Give what is wrong with a case's axes and their mountings."""
    because = (("output", "axes"),)
    for place, axis in enumerate(case.axes):
        if axis not in output.axes:
            yield Complaint((*key, "axes", place), _unknown(axis, output), because)
    for axis, direction in case.mountings.items():
        if axis not in output.axes:
            yield Complaint((*key, "mountings", axis), _unknown(axis, output), because)
        if not is_direction(direction):
            message = "is no direction; give it as [up, north, east], e.g. [1, 0, 0]"
            yield Complaint((*key, "mountings", axis), message)
    judged = case.axes or output.axes
    if case.mounting is not None and len(judged) > 1:
        message = (
            "is the direction of one axis, and this case judges several; write 'mountings:"
            f" {{{judged[0]}: [1, 0, 0], …}}'"
        )
        yield Complaint((*key, "mounting"), message, because)
    if case.mounting is not None and case.mountings:
        yield Complaint((*key, "mountings"), "stands beside 'mounting'; one of the two is enough")


def _unknown(axis: str, output: Output) -> str:
    if not output.axes:
        return f"'{axis}' is no axis of this output; it names none in 'output.axes'"
    return f"'{axis}' is no axis of this output; {nearest(axis, output.axes)}"


def is_direction(axis: tuple[float, float, float]) -> bool:
    """Whether a vector has a direction."""
    length = math.hypot(*axis)
    return math.isfinite(length) and length > 0
