"""From a file's numbers to rates."""

import pytest

from gyrotest.errors import RecordingError
from gyrotest.offline.request import Request
from gyrotest.units import parse_quantity


@pytest.mark.parametrize(
    ("request_", "own_unit", "number", "rate_dps"),
    [
        (Request(unit="deg/s"), None, 2.0, 2.0),
        (Request(unit="rad/s"), None, 1.0, 57.29577951308232),
        (Request(unit="deg/h", scale=-1.0), None, 3600.0, -1.0),
        (Request(), "deg/s", 2.0, 2.0),
        (Request(unit="deg/s", zero_rate=parse_quantity("3600 deg/h")), None, 2.5, 1.5),
        (Request(unit="V", scale_factor=parse_quantity("50 mV/(deg/s)")), None, 0.1, 2.0),
        (
            Request(
                unit="mV",
                scale_factor=parse_quantity("-50 mV/(deg/s)"),
                zero_rate=parse_quantity("2.5 V"),
            ),
            None,
            2600.0,
            -2.0,
        ),
        (Request(unit="count", scale_factor=parse_quantity("20 count/(deg/s)")), None, 50.0, 2.5),
        (Request(scale_factor=parse_quantity("50 mV/(deg/s)")), "V", 0.1, 2.0),
    ],
)
def test_numbers_become_rates(
    request_: Request, own_unit: str | None, number: float, rate_dps: float
) -> None:
    conversion = request_.conversion(own_unit)
    assert number * conversion.factor - conversion.offset_dps == pytest.approx(rate_dps)


@pytest.mark.parametrize(
    ("request_", "message"),
    [
        (Request(), "the unit of its values is not known; give e.g. --unit deg/s"),
        (Request(unit="V"), r"its values are in 'V'; give --scale-factor, e.g. '50 mV/\(deg/s\)'"),
        (Request(unit="m"), "unit 'm' is neither a rate nor a voltage nor 'count'"),
    ],
)
def test_what_is_not_known_is_asked_for(request_: Request, message: str) -> None:
    with pytest.raises(RecordingError, match=message):
        request_.conversion(None)


@pytest.mark.parametrize("unit", ["deg/s", "mV"])
def test_a_recording_is_not_read_in_another_unit_than_its_own(unit: str) -> None:
    with pytest.raises(RecordingError, match=f"is a recording in 'V', not in '{unit}'"):
        Request(unit=unit, scale_factor=parse_quantity("50 mV/(deg/s)")).conversion("V")
