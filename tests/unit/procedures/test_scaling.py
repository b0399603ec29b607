"""From indications to outputs and rates: voltages, rates and counts."""

import numpy as np
import pytest

from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.scaling import output_scaling
from gyrotest.records.spec import Output, OutputKind
from gyrotest.units import Quantity
from tests.unit.procedures.bench import voltage_output
from tests.unit.procedures.turntable import counts_output


def test_millivolts_become_volts_above_the_output_at_rest_and_a_rate() -> None:
    scaling = output_scaling(voltage_output(), "mV")
    values = np.array([2500.0, 3000.0])
    assert scaling.outputs(values) == pytest.approx((0.0, 0.5))
    assert scaling.rates_dps(values) == pytest.approx((0.0, 10.0))
    assert scaling.spread_dps(-50.0) == pytest.approx(1.0)


def test_counts_have_a_scale_factor_of_their_own() -> None:
    scaling = output_scaling(counts_output(), "count")
    assert (scaling.unit, scaling.scale_factor) == ("count", pytest.approx(131.0))
    assert scaling.rates_dps(np.array([262.0])) == pytest.approx((2.0,))


def test_a_rate_without_scale_factor_is_taken_as_it_is() -> None:
    values = np.array([1.0, 2.0])
    scaling = output_scaling(Output(kind=OutputKind.RATE), "deg/s")
    assert scaling.rates_dps(values) is values
    assert scaling.outputs(values) is values


@pytest.mark.parametrize(
    ("output", "unit", "message"),
    [
        (Output(kind=OutputKind.VOLTAGE), "V", "a voltage is no rate without it"),
        (Output(kind=OutputKind.COUNT), "count", "counts are no rate without it"),
        (voltage_output(), "deg/s", "the spec's output is a voltage"),
        (
            Output(kind=OutputKind.COUNT, scale_factor=Quantity(131.0, "count/(deg/s)")),
            "V",
            "is a count",
        ),
    ],
)
def test_an_output_of_another_kind_is_refused(output: Output, unit: str, message: str) -> None:
    with pytest.raises(InsufficientDataError, match=message):
        output_scaling(output, unit)
