"""What a serial gyro says of itself when it is asked, between its frames.

In normal mode a letter and a carriage return ask for a datagram: I the serial number, C the
configuration, N the part number (TS1524 sections 5.5 and 8). Nothing here changes the unit.

For the STIM210 no public text says so. It is asked the same way, and its datagrams are taken to be those
of the STIM300 with its own checksum; where it does not answer, what it says is not known.
"""

from dataclasses import dataclass

from gyrotest.instruments.stim.models import LINE_END, Model
from gyrotest.records.spec import OutputMode

_SERIAL_DIGITS = slice(2, 9)  # seven bytes of two digits, behind the letter N
_MODES = {
    0: OutputMode.RATE,
    1: OutputMode.INCREMENTAL_ANGLE,
    2: OutputMode.AVERAGE_RATE,
}
_BANDWIDTHS_HZ = {0: 16.0, 1: 33.0, 2: 66.0, 3: 131.0, 4: 262.0}
_SAMPLE_RATES_HZ = {0: 125.0, 1: 250.0, 2: 500.0, 3: 1000.0, 4: 2000.0}
_RANGES_DPS = {0: 400.0}


@dataclass(frozen=True, slots=True, kw_only=True)
class Question:
    """What is sent, and the datagram that answers: its identifiers, without and with a line end, and size."""

    command: bytes
    identifiers: tuple[int, int]
    size: int


SERIAL_NUMBER = Question(command=b"I\r", identifiers=(0xB5, 0xB7), size=16)
CONFIGURATION = Question(command=b"C\r", identifiers=(0xBC, 0xBD), size=22)
PART_NUMBER = Question(command=b"N\r", identifiers=(0xB1, 0xB3), size=16)


@dataclass(frozen=True, slots=True, kw_only=True)
class Configuration:
    """How the unit is set, by its own words; None where its code has no meaning that we know.

    `mode_as_set` may also be `integrated_angle`, which is no mode that is measured with.
    """

    firmware: str
    sample_rate_hz: float | None
    mode: OutputMode | None
    bandwidth_hz: float | None
    range_dps: float | None
    crlf: bool
    mode_as_set: str


def answer(question: Question, data: bytes, model: Model) -> bytes | None:
    """Find the datagram that answers among the frames; without its checksum and line end."""
    whole = question.size + model.crc.size
    for place in range(len(data) - whole + 1):
        if data[place] not in question.identifiers:
            continue
        message = data[place : place + question.size]
        sent = int.from_bytes(data[place + question.size : place + whole])
        ended = data[place] == question.identifiers[0] or data[place + whole :].startswith(LINE_END)
        if sent == model.crc.of(message) and ended and _plausible(question, message):
            return message
    return None


def _plausible(question: Question, message: bytes) -> bool:
    """Whether it can be that datagram: eight bits of checksum alone fit by chance."""
    if question is SERIAL_NUMBER:
        return message[1:2] == b"N" and message[_SERIAL_DIGITS].hex().isdecimal()
    if question is CONFIGURATION:
        return chr(message[1]).isalnum() and message[3] >> 5 <= 5
    return message[4:5] == b"-" and message[8:9] == b"-"


def serial_number(message: bytes) -> str:
    """Fourteen decimal digits, two in a byte (TS1524 table 5-15); zeros in front are left out."""
    return message[_SERIAL_DIGITS].hex().lstrip("0") or "0"


def part_number(message: bytes) -> str:
    """The part number with its revision (TS1524 tables 5-13 and 5-14)."""
    digits = message[1:].hex().upper()
    # The last group is put together from halves of its bytes: 17; 12 and 16; 13; 14 and 15.
    third = digits[16:22]
    last = third[5] + _combined(third[0], third[4]) + third[1] + _combined(third[2], third[3])
    return f"{digits[1:6]}-{digits[8:14]}-{last}{_printable(message[15])}"


def _combined(low: str, high: str) -> str:
    value = int(low, 16) + 16 * int(high, 16)
    return chr(value + (48 if value < 10 else 55))


def _printable(byte: int) -> str:
    return chr(byte) if chr(byte).isalnum() else ""


def configuration(message: bytes) -> Configuration:
    """What the configuration datagram says of the gyros (TS1524 table 5-16)."""
    # Two more bits say that the output is delayed, which changes neither its scale nor its meaning.
    mode_code = message[5] & 0x03
    filters = (message[6] >> 4 & 7, message[6] & 7, message[7] >> 4 & 7)
    bandwidths = [_BANDWIDTHS_HZ.get(code) for code in filters]
    known = [one for one in bandwidths if one is not None]
    return Configuration(
        firmware=f"{chr(message[1])}{message[2]}",
        sample_rate_hz=_SAMPLE_RATES_HZ.get(message[3] >> 5),
        mode=_MODES.get(mode_code),
        bandwidth_hz=min(known) if len(known) == len(filters) else None,
        range_dps=_RANGES_DPS.get(message[15] >> 4),
        crlf=bool(message[3] & 1),
        mode_as_set=_MODES[mode_code].value if mode_code in _MODES else "integrated_angle",
    )
