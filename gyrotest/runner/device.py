"""A digital gyro's own words held against the serial number that was given and against the spec."""

import math
import re
from collections.abc import Iterator

from gyrotest.errors import InstrumentIdentityError
from gyrotest.records.bench import Device
from gyrotest.records.spec import Output

_AGREE = 1e-3


def check_device(device: Device, *, who: str, serial_number: str, output: Output) -> None:
    """Refuse another unit, or one that is set otherwise; raises `InstrumentIdentityError` with all faults."""
    faults = [*_of_serial_number(device, serial_number), *_of_setting(device, output)]
    if faults:
        raise InstrumentIdentityError(f"{who}: {'; '.join(faults)}")


def _of_serial_number(device: Device, serial_number: str) -> Iterator[str]:
    found = device.serial_number
    if found is not None and _plain(found) != _plain(serial_number):
        yield (
            f"the unit says that its serial number is {found}, the run is for {serial_number}:"
            " connect that unit, or give --serial as the unit has it"
        )


def _plain(serial_number: str) -> str:
    """The number that counts: units send it with leading zeros, labels write a letter before it."""
    return re.sub(r"^[A-Za-z]?0*", "", serial_number).upper()


def _of_setting(device: Device, output: Output) -> Iterator[str]:
    if device.mode is not None and device.mode is not output.mode:
        yield (
            f"the unit is set to give {device.mode.value}, the spec's output.mode is {output.mode.value}:"
            " correct the spec, or set the unit up anew"
        )
    for what, found, wanted, unit in (
        ("range", device.range_dps, output.full_scale, "deg/s"),
        ("bandwidth", device.bandwidth_hz, output.bandwidth, "Hz"),
    ):
        if found is None or wanted is None or math.isclose(found, wanted.to(unit), rel_tol=_AGREE):
            continue
        key = "full_scale" if what == "range" else what
        yield (
            f"the unit's {what} is {found:g} {unit}, the spec's output.{key} is {wanted}:"
            " correct the spec, or set the unit up anew"
        )
