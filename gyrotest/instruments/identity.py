"""Who answers at an address: `*IDN?` read and held against what the station names."""

import re
from dataclasses import dataclass

from gyrotest.errors import InstrumentIdentityError
from gyrotest.records.recording import Identity

_FIELDS = 4


@dataclass(frozen=True, slots=True)
class Expected:
    """The instruments that a driver speaks to: patterns of maker and model, and how they are called."""

    manufacturer: re.Pattern[str]
    model: re.Pattern[str]
    spoken: str


def parse_identity(reply: str) -> Identity | None:
    """The four fields of `*IDN?` (IEEE 488.2 10.14); None if this is no such reply."""
    fields = [field.strip() for field in reply.split(",", _FIELDS - 1)]
    if len(fields) < _FIELDS or not all(fields[:3]):
        return None
    return Identity(manufacturer=fields[0], model=fields[1], serial_number=fields[2], firmware=fields[3])


def check_identity(
    identity: Identity, *, who: str, expected: Expected, serial_number: str | None
) -> None:
    """Refuse another instrument than the expected one; raises `InstrumentIdentityError`."""
    named = f"{identity.manufacturer} {identity.model}"
    if not (
        expected.manufacturer.search(identity.manufacturer) and expected.model.fullmatch(identity.model)
    ):
        raise InstrumentIdentityError(
            f"{who}: found {named} (serial number {identity.serial_number}), expected {expected.spoken};"
            " correct the station's resource or driver"
        )
    if serial_number is not None and identity.serial_number != serial_number:
        raise InstrumentIdentityError(
            f"{who}: found {named} with serial number {identity.serial_number}, expected {serial_number};"
            " correct the station's serial_number or connect that instrument"
        )
