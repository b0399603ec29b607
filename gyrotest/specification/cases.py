"""What must hold in a case beyond its types: times, repeats, the procedure's own demands."""

import math
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from gyrotest.errors import GyrotestError
from gyrotest.ports import Procedure
from gyrotest.records.spec import Case, Output
from gyrotest.specification.axes import case_axes_complaints, is_direction
from gyrotest.specification.checked import Complaint, related, unrelated
from gyrotest.specification.limits import limit_complaints, order_complaints
from gyrotest.specification.parameters import section
from gyrotest.specification.yaml_tree import KeyPath
from gyrotest.units import Quantity

Catalogue = Callable[[str], Procedure]

MOST_SAMPLES = 10**9
MOST_REPEATS = 1000
MOST_RETESTS = 100


def case_complaints(
    case: Case, output: Output, procedures: Catalogue, key: KeyPath, earlier: tuple[Complaint, ...]
) -> Iterator[Complaint]:
    """Give what is wrong with a case; `earlier` are the complaints about types."""
    plain = (*_plain_complaints(case, key), *case_axes_complaints(case, output, key))
    own = unrelated(plain, earlier)
    yield from own
    known = (*earlier, *own)
    if related((*key, "procedure"), known):
        return
    try:
        procedure = procedures(case.procedure)
    except (GyrotestError, ImportError) as error:
        yield Complaint((*key, "procedure"), f"cannot be used: {error}")
        return
    yield from _procedure_complaints(case, output, procedure, key, known)


def _plain_complaints(case: Case, key: KeyPath) -> Iterator[Complaint]:
    yield from _time_complaints(case, key)
    yield from _count_complaints(case, key)
    if case.mounting is not None and not is_direction(case.mounting):
        message = "is no direction; give the sensitive axis as [up, north, east], e.g. [1, 0, 0]"
        yield Complaint((*key, "mounting"), message)
    for name, limit in case.limits.items():
        yield from order_complaints(limit, (*key, "limits", name))


def _time_complaints(case: Case, key: KeyPath) -> Iterator[Complaint]:
    duration, interval = (*key, "duration"), (*key, "interval")
    positive = True
    for place, time in ((duration, case.duration), (interval, case.interval)):
        if time.value <= 0:
            positive = False
            yield Complaint(place, f"'{time}' is not more than zero")
    if positive:
        for message in _grid_complaints(case.duration, case.interval):
            yield Complaint(duration, message, because=(interval,))
    if case.warm_up is not None and case.warm_up.value < 0:
        yield Complaint((*key, "warm_up"), f"'{case.warm_up}' is less than zero")


def _grid_complaints(duration: Quantity, interval: Quantity) -> Iterator[str]:
    samples = duration.to("s") / interval.to("s")
    if not math.isfinite(samples) or samples > MOST_SAMPLES:
        yield f"'{duration}' in intervals of '{interval}' is more than {MOST_SAMPLES:,} samples"
    elif abs(samples - round(samples)) > 1e-9 * samples:
        fits = math.floor(samples) * interval.to("s")
        yield f"'{duration}' is no whole number of intervals of '{interval}'; write e.g. '{fits:.10g} s'"
    elif round(samples) < 2:
        yield f"'{duration}' is less than two intervals of '{interval}'"


def _count_complaints(case: Case, key: KeyPath) -> Iterator[Complaint]:
    if not 1 <= case.repeats <= MOST_REPEATS:
        yield Complaint((*key, "repeats"), f"{case.repeats} is not between 1 and {MOST_REPEATS}")
    if case.allowed_loss is not None and not 0 <= case.allowed_loss.to("") < 1:
        yield Complaint((*key, "allowed_loss"), f"'{case.allowed_loss}' is not between 0 and 100 %")
    if not 0 <= case.retests <= MOST_RETESTS:
        yield Complaint((*key, "retests"), f"{case.retests} is not between 0 and {MOST_RETESTS}")


def _procedure_complaints(
    case: Case, output: Output, procedure: Procedure, key: KeyPath, earlier: Iterable[Complaint]
) -> Iterator[Complaint]:
    before = tuple(earlier)
    parameters = section(case.parameters, procedure.parameters, (*key, "parameters"))
    yield from parameters.complaints
    before = (*before, *parameters.complaints)
    if not _about(before, key, but="limits") and not related(("output",), before):
        own = procedure.complaints(case, parameters.record, output)
        yield from (_at(key, place, message) for place, message in own)
    needed = ("procedure", "parameters", "repeats", "between_repeats")
    if not any(related((*key, one), before) for one in needed):
        measurands = procedure.measurands(case, parameters.record, output)
        yield from unrelated(limit_complaints(case, measurands, (*key, "limits")), before)


def _about(complaints: Iterable[Complaint], key: KeyPath, but: str) -> bool:
    """Whether a complaint is about something at or below `key`, one section left out."""
    depth = len(key)
    return any(
        one.key[:depth] == key[: len(one.key)] and one.key[depth : depth + 1] != (but,)
        for one in complaints
    )


def _at(key: KeyPath, place: str, message: str) -> Complaint:
    """Return a procedure's complaint at its place in the document (`parameters.smoothing`)."""
    parts: list[Any] = [part for part in place.replace("[", ".[").split(".") if part]
    below = [
        int(part[1:-1]) if part.startswith("[") and part[1:-1].isdecimal() else part for part in parts
    ]
    return Complaint((*key, *below), message)
