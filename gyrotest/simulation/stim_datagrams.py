"""What a simulated STIM gyro says of itself: part number, serial number, configuration."""

import re
from dataclasses import dataclass
from enum import Enum

from gyrotest.records.spec import OutputMode
from gyrotest.simulation.stim_frames import LINE_END, Part, StimModel

_DIGITS = 14
RATES_HZ = (125.0, 250.0, 500.0, 1000.0, 2000.0)
FILTERS_HZ = (16.0, 33.0, 66.0, 131.0, 262.0)
_BIT_RATES = (374_400, 460_800, 921_600, 1_843_200)
_USER_DEFINED = 15
_MODES = (OutputMode.RATE, OutputMode.INCREMENTAL_ANGLE, OutputMode.AVERAGE_RATE)
_PART_BITS = {
    Part.AUXILIARY: 16,
    Part.TEMPERATURE_STATUS: 8,
    Part.TEMPERATURE: 8,
    Part.INCLINATION: 4,
    Part.ACCELERATION: 2,
}
_ALL_GYROS = 0x70
_REVISION, _FIRMWARE = b"G", 15
# No unit is made with a part number of zeros: it tells that this one is simulated, as digits can.
_PART_NUMBER = bytes(3) + b"-" + bytes(3) + b"-" + bytes(6) + b"L"


class Subject(Enum):
    """What a datagram tells: its identifiers without and with a line end, and the letter that asks for it."""

    PART_NUMBER = (0xB1, 0xB3, b"N")
    SERIAL_NUMBER = (0xB5, 0xB7, b"I")
    CONFIGURATION = (0xBC, 0xBD, b"C")


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """How a unit is set."""

    identifier: int
    rate_hz: float
    mode: OutputMode
    crlf: bool
    bandwidth_hz: float
    baud_rate: int


def datagram(subject: Subject, model: StimModel, setup: Setup, serial_number: str) -> bytes:
    """A datagram with its checksum and, where the unit is set so, its line end."""
    plain, ended, _ = subject.value
    payload = {
        Subject.PART_NUMBER: lambda: _PART_NUMBER,
        Subject.SERIAL_NUMBER: lambda: b"N" + bytes.fromhex(digits(serial_number)) + bytes(7),
        Subject.CONFIGURATION: lambda: _configuration(model, setup),
    }[subject]()
    message = bytes([ended if setup.crlf else plain]) + payload
    return message + model.checksum.of(message) + (LINE_END if setup.crlf else b"")


def digits(serial_number: str) -> str:
    """The digits of a serial number, as many as the datagram has room for."""
    return re.sub(r"[^0-9]", "", serial_number)[-_DIGITS:].zfill(_DIGITS)


def _configuration(model: StimModel, setup: Setup) -> bytes:
    parts = sum(_PART_BITS.get(one, 0) for one in model.kinds[setup.identifier])
    rate = RATES_HZ.index(setup.rate_hz) << 5
    nearest = min(FILTERS_HZ, key=lambda one: abs(one - setup.bandwidth_hz))
    filters = FILTERS_HZ.index(nearest)
    known = setup.baud_rate in _BIT_RATES
    bit_rate = _BIT_RATES.index(setup.baud_rate) if known else _USER_DEFINED
    return (
        _REVISION
        + bytes(
            [
                _FIRMWARE,
                rate | parts | setup.crlf,
                bit_rate << 4 | setup.crlf,
                _ALL_GYROS | _MODES.index(setup.mode),
                filters << 4 | filters,
                filters << 4,
            ]
        )
        + bytes(14)
    )
