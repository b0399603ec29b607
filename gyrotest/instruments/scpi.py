"""What SCPI instruments have in common: settings read back, the error queue, readings in text."""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InstrumentProtocolError
from gyrotest.instruments.transport.conversation import Conversation, shown
from gyrotest.records.recording import SampleFlag

# SCPI 1999 vol. 1, 7.2.1.4 and 7.2.1.5: an overload is ±9.9E37, not-a-number 9.91E37.
_LARGEST_VALUE = 9.8e37
_NOT_A_NUMBER = 9.91e37
_QUEUE_LENGTH = 20

# Meters always write the exponent in full, so that a reply that lost its end is not taken for a value.
_READING = re.compile(rb"[+-]?\d\.\d+E[+-]\d\d")


@dataclass(frozen=True, slots=True)
class Setting:
    """A command, and the query that must then answer `expected` (None: not read back)."""

    command: str
    query: str | None = None
    expected: float | str = ""


def apply(talk: Conversation, settings: Iterable[Setting], timeout_s: float) -> None:
    """Send settings, see that nothing was refused, read all back; raises `InstrumentProtocolError`."""
    applied = tuple(settings)
    for setting in applied:
        talk.write(setting.command)
    refuse_errors(talk, timeout_s)
    for setting in applied:
        if setting.query is not None:
            _read_back(talk, setting, setting.query, timeout_s)


def number(talk: Conversation, query: str, timeout_s: float) -> float:
    """Ask for one number; raises `InstrumentProtocolError`."""
    reply = talk.query(query, timeout_s)
    try:
        return float(reply)
    except ValueError:
        raise InstrumentProtocolError(
            f"{talk.who}: {query} gives {shown(reply.encode())}, expected a number"
        ) from None


def refuse_errors(talk: Conversation, timeout_s: float) -> None:
    """Empty the error queue; raises `InstrumentProtocolError` naming what was in it."""
    found = drain_errors(talk, timeout_s)
    if found:
        raise InstrumentProtocolError(
            f"{talk.who}: the instrument reports {'; '.join(found)}; does it understand this driver's commands?"
        )


def drain_errors(talk: Conversation, timeout_s: float) -> tuple[str, ...]:
    """Read the error queue until it is empty and return what was in it."""
    found: list[str] = []
    for _ in range(_QUEUE_LENGTH + 1):
        reply = talk.query("SYST:ERR?", timeout_s)
        if _error_code(talk, reply) == 0:
            break
        found.append(reply)
    return tuple(found)


def initiate(talk: Conversation, timeout_s: float) -> None:
    """Start a measurement, and see that the instrument has done so; raises `InstrumentProtocolError`."""
    reply = talk.query("INIT;:SYST:ERR?", timeout_s)
    if _error_code(talk, reply):
        raise InstrumentProtocolError(f"{talk.who}: INIT is refused: {reply}; is it measuring already?")


def readings(reply: bytes, count: int, who: str) -> list[float]:
    """The readings in a reply, counted; raises `InstrumentProtocolError`."""
    fields = reply.strip().split(b",")
    if not all(map(_READING.fullmatch, fields)):
        raise InstrumentProtocolError(
            f"{who}: the reply begins {shown(reply)}, expected {count} reading(s) like +1.23456789E+00"
        )
    if len(fields) != count:
        raise InstrumentProtocolError(f"{who}: {len(fields)} readings in one reply, expected {count}")
    return [float(field) for field in fields]


def flag_of(value: float) -> SampleFlag:
    """What is wrong with one reading."""
    if -_LARGEST_VALUE < value < _LARGEST_VALUE:
        return SampleFlag.GOOD
    if math.isnan(value) or math.isclose(value, _NOT_A_NUMBER, rel_tol=1e-6):
        return SampleFlag.NOT_A_NUMBER
    return SampleFlag.OVERLOAD


def sample_of(values: list[float]) -> tuple[float, int]:
    """The mean of one sample's readings and its flags; not a number where any reading is bad."""
    if max(values) < _LARGEST_VALUE and min(values) > -_LARGEST_VALUE:
        return sum(values) / len(values), 0
    flags = SampleFlag.GOOD
    for value in values:
        flags |= flag_of(value)
    return math.nan, int(flags)


def samples_of(
    values: NDArray[np.float64], readings: int
) -> tuple[NDArray[np.float64], NDArray[np.uint8]]:
    """Means of so many readings each, (n, 1), and their flags (n,); not a number where any reading is bad."""
    each = values.reshape(-1, readings)
    bad = ~(np.abs(each) < _LARGEST_VALUE)
    flags = np.zeros(len(each), dtype=np.uint8)
    for sample, reading in np.argwhere(bad):
        flags[sample] |= flag_of(float(each[sample, reading]))
    means = np.where(bad.any(axis=1), np.nan, np.where(bad, 0.0, each).mean(axis=1))
    return means.reshape(-1, 1), flags


def _error_code(talk: Conversation, reply: str) -> int:
    code = reply.partition(",")[0]
    if not re.fullmatch(r"[+-]?\d+", code):
        raise InstrumentProtocolError(
            f"{talk.who}: SYST:ERR? gives {shown(reply.encode())}, expected a number and a text"
        )
    return int(code)


def _read_back(talk: Conversation, setting: Setting, query: str, timeout_s: float) -> None:
    reply = talk.query(query, timeout_s)
    if not _agrees(reply, setting.expected):
        raise InstrumentProtocolError(
            f"{talk.who}: {query} gives {reply} after '{setting.command}', expected {setting.expected};"
            " is the setting within what this model can do?"
        )


def _agrees(reply: str, expected: float | str) -> bool:
    if isinstance(expected, str):
        return reply.strip('"').upper() == expected.upper()
    try:
        return math.isclose(float(reply), expected, rel_tol=1e-6, abs_tol=1e-12)
    except ValueError:
        return False
