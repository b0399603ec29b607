"""What one axis of a simulated unit makes of what acts on it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.records.spec import Output, OutputKind, Spec
from gyrotest.records.station import Simulation
from gyrotest.simulation.carriage import Carriage, Swing
from gyrotest.simulation.element import Element
from gyrotest.simulation.gyro_settings import gyro_parameters
from gyrotest.simulation.surroundings import Acting
from gyrotest.simulation.unit import Dice, PowerOn, draw_axis
from gyrotest.units import Quantity

SPEC = Spec(
    model="MEMS50",
    cases={},
    output=Output(
        kind=OutputKind.VOLTAGE,
        scale_factor=Quantity(50.0, "mV/(deg/s)"),
        zero_rate=Quantity(2.5, "V"),
        full_scale=Quantity(100.0, "deg/s"),
    ),
)
STEADY = {"turn_on_bias": "0 deg/s", "warm_up_drift": "0 deg/s"}
ON = PowerOn(cycle=1, on_s=0.0)
ANGLES = (0.0, 30.0, 90.0, 200.0)


def element(serial: str = "1", *, share: float = 1.0, inverted: bool = False, **figures: str) -> Element:
    gyro = gyro_parameters(Simulation(gyro={**STEADY, **figures}), SPEC)
    dice = Dice(seed=1, serial_number=serial)
    axis = draw_axis("", gyro, dice, inverted=inverted)
    return Element(axis, gyro, Carriage(table_share=share, earth_dps=0.003), dice)


def turned(rates_dps: list[float], *, degc: float = 23.0) -> Acting:
    aperture_s = 0.1
    to_deg = np.array(rates_dps) * aperture_s
    return Acting(
        aperture_s=aperture_s,
        from_deg=np.zeros(to_deg.shape),
        to_deg=to_deg,
        temperature_degc=np.full(to_deg.shape, degc),
    )


def felt(one: Element, rates_dps: list[float], *, degc: float = 23.0) -> NDArray[np.float64]:
    starts_s = 1000.0 + np.arange(len(rates_dps), dtype=np.float64)
    return one.rates_dps(ON, starts_s, turned(rates_dps, degc=degc))


def test_it_feels_its_share_of_the_table_and_the_earth() -> None:
    assert felt(element(share=-0.5), [0.0, 40.0]) == pytest.approx([0.003, -20.0 + 0.003])


def test_at_rest_both_ways_to_a_rate_agree() -> None:
    one = element(input_rate="2 deg/s", asymmetry="1 %", nonlinearity="1 %")
    starts_s = np.array([1000.0, 1000.1])
    still = one.still_rates_dps(ON, starts_s, 0.1)
    assert still == pytest.approx(one.rates_dps(ON, starts_s, turned([0.0, 0.0])))
    assert still[0] == pytest.approx(one.still_rate_dps(ON, 1000.0, 0.1))


def test_both_signs_have_scale_factors_that_differ_by_the_asymmetry() -> None:
    one = element(asymmetry="1 %")
    up, down = felt(one, [50.0, -50.0]) - 0.003
    share = one.axis.response.asymmetry
    assert 0.0 < abs(share) <= 0.01
    assert (up + down) / 50.0 == pytest.approx(share, rel=1e-3)


def test_nonlinearity_is_a_cubic_that_is_known_at_full_scale() -> None:
    one = element(nonlinearity="1000 ppm")
    rates = np.array([-100.0, -50.0, 50.0, 100.0])
    share = one.axis.response.nonlinearity
    assert 0.0 < abs(share) <= 1e-3
    departure = felt(one, rates.tolist()) - 0.003 - rates
    assert departure == pytest.approx(share * rates**3 / 1e4, rel=1e-3)


def test_units_are_spread_within_the_half_widths() -> None:
    drawn = [
        element(str(k), nonlinearity="1000 ppm", asymmetry="2000 ppm").axis.response for k in range(300)
    ]
    for values, most in (
        ([one.nonlinearity for one in drawn], 1e-3),
        ([one.asymmetry for one in drawn], 2e-3),
    ):
        assert 0.95 * most < np.abs(values).max() <= most
        assert abs(np.mean(values)) < 0.15 * most


def test_it_saturates_at_a_quarter_more_than_full_scale() -> None:
    one = element()
    assert one.saturation_dps == pytest.approx(125.0)
    assert one.clipped(np.array([-300.0, 120.0, 126.0])) == pytest.approx([-125.0, 120.0, 125.0])


def test_a_turning_within_the_dead_zone_is_not_felt() -> None:
    one = element(dead_zone="0.05 deg/s")
    assert felt(one, [0.04, -0.04, 0.06]) == pytest.approx([0.003, 0.003, 0.063])


def test_temperature_moves_bias_and_scale_factor() -> None:
    one = element(
        temperature_sensitivity="0.1 deg/s/degC", scale_factor_temperature_sensitivity="500 ppm/degC"
    )
    (warm,), (room,) = felt(one, [0.0], degc=33.0), felt(one, [0.0])
    sensitivity = one.axis.temperature_sensitivity_dps_per_c
    assert 0.0 < abs(sensitivity) <= 0.1
    assert warm - room == pytest.approx(10.0 * sensitivity)
    factors = one.scale_factors(turned([0.0], degc=33.0))
    share = one.axis.scale_factor_sensitivity_per_c
    assert 0.0 < abs(share) <= 500e-6
    assert factors[0] / one.scale_factor == pytest.approx(1.0 + 10.0 * share)


def test_an_inverted_unit_has_its_scale_factor_alone_turned_round() -> None:
    plain, inverted = element(asymmetry="1 %"), element(asymmetry="1 %", inverted=True)
    assert inverted.scale_factor == -plain.scale_factor
    assert felt(inverted, [10.0]) == pytest.approx(felt(plain, [10.0]))


def test_each_power_on_has_a_bias_of_its_own_and_the_first_comes_again() -> None:
    one = element(turn_on_bias="1 deg/s")
    biases = [one.turn_on_bias_dps(replace(ON, cycle=cycle)) for cycle in (1, 2, 1)]
    assert biases[0] == biases[2] != biases[1]


def test_a_model_has_figures_of_its_own_beside_those_of_any_gyro() -> None:
    simulation = Simulation(
        gyro={"turn_on_bias": "1 deg/s", "dead_zone": "2 deg/s"},
        models={"MEMS50": {"turn_on_bias": "3 deg/s"}, "OTHER": {"dead_zone": "5 deg/s"}},
    )
    made = gyro_parameters(simulation, SPEC)
    assert (made.turn_on_bias_dps, made.dead_zone_dps) == (3.0, 2.0)


def test_without_a_full_scale_nothing_saturates_and_the_truth_has_no_limit() -> None:
    made = gyro_parameters(Simulation(), replace(SPEC, output=replace(SPEC.output, full_scale=None)))
    dice = Dice(seed=1, serial_number="1")
    one = Element(
        draw_axis("", made, dice, inverted=False), made, Carriage(table_share=1.0, earth_dps=0.0), dice
    )
    assert one.clipped(np.array([1e6])) == pytest.approx([1e6])
    assert felt(one, [1e4]) == pytest.approx([1e4], rel=1e-4)


def test_gravity_along_its_own_axes_makes_a_drift_that_its_truth_tells() -> None:
    gyro = gyro_parameters(Simulation(gyro={**STEADY, "g_sensitivity": "0.1 deg/s/g"}), SPEC)
    dice = Dice(seed=1, serial_number="7")
    sits = Carriage(
        table_share=0.0,
        earth_dps=0.0,
        force_g={"x": Swing(sine=-1.0), "y": Swing(constant=0.5), "z": Swing(cosine=1.0)},
    )
    one = Element(draw_axis("", gyro, dice, inverted=False), gyro, sits, dice)
    truth = one.truth(ON, 1000.0, 10.0)
    x, y, z = (truth[f"g_sensitivity_{own}_dps_per_g"] for own in "xyz")
    assert len({x, y, z, 0.0}) == 4
    assert max(abs(x), abs(y), abs(z)) <= 0.1
    expected = [
        0.5 * y + z * math.cos(math.radians(at)) - x * math.sin(math.radians(at)) for at in ANGLES
    ]
    angles = np.array(ANGLES)
    acting = replace(turned([0.0] * len(ANGLES)), from_deg=angles, to_deg=angles)
    assert one.rates_dps(ON, 1000.0 + angles, acting) == pytest.approx(expected)
    assert one.still_rate_dps(ON, 1000.0, 1.0) == pytest.approx(0.5 * y + z)
    # Away from a stage it cannot be told from the bias.
    assert truth["bias_dps"] == pytest.approx(0.5 * y + z)
    staged = Element(one.axis, gyro, replace(sits, staged=True), dice)
    assert staged.truth(ON, 1000.0, 10.0)["bias_dps"] == 0.0
