"""What a digital gyro says of itself is held against the serial number and the spec."""

import pytest

from gyrotest.errors import InstrumentIdentityError
from gyrotest.records.bench import Device
from gyrotest.records.spec import Output, OutputKind, OutputMode
from gyrotest.runner.device import check_device
from gyrotest.units import Quantity

OUTPUT = Output(
    kind=OutputKind.RATE,
    axes=("x", "y", "z"),
    full_scale=Quantity(400.0, "deg/s"),
    bandwidth=Quantity(33.0, "Hz"),
)


def _check(device: Device, serial_number: str = "25581234") -> None:
    check_device(device, who="/dev/ttyS0", serial_number=serial_number, output=OUTPUT)


@pytest.mark.parametrize("serial_number", ["25581234", "N25581234", "N00000025581234", "00025581234"])
def test_a_serial_number_may_be_written_with_its_letter_and_its_zeros(serial_number: str) -> None:
    _check(Device(serial_number="N25581234"), serial_number)


def test_what_cannot_be_asked_is_not_held_against_anything() -> None:
    _check(Device())


@pytest.mark.parametrize(
    ("device", "told"),
    [
        (Device(serial_number="25581235"), "serial number is 25581235, the run is for 25581234"),
        (Device(mode=OutputMode.INCREMENTAL_ANGLE), "set to give incremental_angle, the spec's"),
        (Device(range_dps=200.0), r"range is 200 deg/s, the spec's output.full_scale is 400 deg/s"),
        (Device(bandwidth_hz=262.0), "bandwidth is 262 Hz, the spec's output.bandwidth is 33 Hz"),
    ],
)
def test_another_unit_or_setting_is_refused(device: Device, told: str) -> None:
    with pytest.raises(InstrumentIdentityError, match=told):
        _check(device)


def test_all_that_is_wrong_is_told_at_once() -> None:
    with pytest.raises(InstrumentIdentityError) as refused:
        _check(Device(serial_number="1", range_dps=1.0, bandwidth_hz=1.0))
    assert str(refused.value).count("; ") == 2


@pytest.mark.parametrize(
    ("part_number", "simulated"),
    [(None, False), ("84420-440000-100L", False), ("00000-000000-0000L", True)],
)
def test_a_part_number_of_zeros_says_that_a_unit_is_simulated(
    part_number: str | None, simulated: bool
) -> None:
    assert Device(part_number=part_number).simulated is simulated
