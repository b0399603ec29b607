"""What acts on a unit in its slot: Earth and table by its mounting, temperature, power."""

import math
from dataclasses import dataclass, field

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.analysis.earth import EARTH_RATE_DPS, earth_share_dps
from gyrotest.records.station import Site, Slot
from gyrotest.simulation.carriage import Carriage, carriages
from gyrotest.simulation.surroundings import Surroundings
from gyrotest.simulation.unit import PowerOn, PowerOns
from gyrotest.units import Quantity

UP = (1.0, 0.0, 0.0)
SITE = Site(latitude=Quantity(48.0, "deg"), heading=Quantity(30.0, "deg"))
XYZ = {"x": (0.0, 1.0, 0.0), "y": (0.0, 0.0, 1.0), "z": UP}


@dataclass
class Output:
    on_since_s: float | None = None


@dataclass
class Instruments:
    """A table that turns evenly, a chamber that warms up, a supply; whatever a slot asks for."""

    rate_dps: float = 0.0
    outputs: dict[int, Output] = field(default_factory=dict)

    def begin(self, occasion: object) -> None: ...

    def truth(self) -> dict[str, float]:
        return {}

    def angle_deg(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.rate_dps * times_s

    def temperature_degc(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        return 20.0 + times_s

    def output(self, number: int) -> Output:
        return self.outputs[number]


def one(mounting: tuple[float, float, float] | None, site: Site | None = SITE) -> Carriage:
    mountings = {} if mounting is None else {"": mounting}
    (found,) = carriages([""], mountings, table_axis=UP, site=site)
    return found


@pytest.mark.parametrize(
    "mounting", [UP, (-2.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0), (1.0, -2.0, 0.5)]
)
def test_the_earths_share_is_what_the_analysis_subtracts(mounting: tuple[float, float, float]) -> None:
    expected = earth_share_dps(mounting, latitude_deg=48.0, heading_deg=30.0)
    assert one(mounting).at_rest_dps == pytest.approx(expected, abs=EARTH_RATE_DPS * 1e-4)


def test_a_unit_whose_mounting_is_not_known_points_up() -> None:
    assert one(None).at_rest_dps == pytest.approx(one(UP).at_rest_dps)
    assert one(None).table_share == 1.0


def test_without_a_site_there_is_no_earth() -> None:
    assert one(UP, None).at_rest_dps == 0.0


def test_an_axis_feels_its_share_of_the_table() -> None:
    assert one((-1.0, 0.0, 0.0)).table_share == pytest.approx(-1.0)
    assert one((1.0, 1.0, 0.0)).table_share == pytest.approx(math.sqrt(0.5))
    found = carriages("xyz", XYZ, table_axis=(0.0, 1.0, 0.0), site=None)
    assert [each.table_share for each in found] == pytest.approx([1.0, 0.0, 0.0])


def test_of_several_axes_with_no_known_mounting_the_last_lies_along_the_tables() -> None:
    found = carriages("xyz", {}, table_axis=UP, site=SITE)
    assert [each.table_share for each in found] == [0.0, 0.0, 1.0]
    assert found[2].at_rest_dps == pytest.approx(one(UP).at_rest_dps)


def test_a_level_axis_turns_past_north_with_the_table() -> None:
    level = one((0.0, 1.0, 0.0))
    angles = np.array([0.0, 90.0, 180.0, 270.0])
    # A right-handed turn about the up-pointing axis carries north to west.
    west = earth_share_dps((0.0, 0.0, -1.0), latitude_deg=48.0, heading_deg=30.0)
    found = level.earth_at_dps(angles, angles)
    assert found[1] == pytest.approx(west, abs=1e-6)
    assert found[:2] == pytest.approx(-found[2:])
    assert level.earth_at_dps(np.zeros(1), np.full(1, 360.0)) == pytest.approx([0.0], abs=1e-12)


def test_only_what_is_in_use_acts() -> None:
    slot = Slot(source="meter", table="table", chamber="chamber", supply="supply")
    there = Instruments(rate_dps=10.0)
    nothing = Surroundings(slot, {}, powered=False)
    times_s = np.arange(4.0)
    assert nothing.quiet
    assert nothing.acting(times_s, 0.5).from_deg is None
    assert list(nothing.temperatures_degc(times_s)) == [23.0] * 4
    turned = Surroundings(slot, {"table": there}, powered=False)
    assert not turned.quiet
    acting = turned.acting(times_s, 0.5)
    assert acting.from_deg is not None
    assert acting.to_deg is not None
    assert acting.to_deg - acting.from_deg == pytest.approx([5.0] * 4)
    warmed = Surroundings(slot, {"chamber": there}, powered=False)
    assert list(warmed.temperatures_degc(times_s)) == [20.0, 21.0, 22.0, 23.0]


def test_a_supply_counts_only_where_the_spec_says_how_to_feed_the_unit() -> None:
    slot = Slot(source="meter", supply="supply", supply_output=2)
    there = Instruments(outputs={2: Output(on_since_s=3.0)})
    fed = Surroundings(slot, {"supply": there}, powered=True).power
    assert fed is not None
    assert fed.on_since_s == 3.0
    assert Surroundings(slot, {"supply": there}, powered=False).power is None
    assert Surroundings(slot, {}, powered=True).power is None


def test_switching_on_again_is_the_next_power_on() -> None:
    output = Output(on_since_s=0.0)
    power_ons = PowerOns(PowerOn(cycle=3, on_s=-600.0), output)
    assert power_ons.current(output) == PowerOn(cycle=3, on_s=-600.0)
    output.on_since_s = None
    assert power_ons.current(output) is None
    output.on_since_s = 20.0
    assert power_ons.current(output) == PowerOn(cycle=4, on_s=20.0)
    assert power_ons.current(output) == PowerOn(cycle=4, on_s=20.0)


def test_a_unit_that_was_off_when_its_record_was_planned_is_powered_on_as_planned() -> None:
    output = Output()
    power_ons = PowerOns(PowerOn(cycle=3, on_s=0.0), output)
    output.on_since_s = 5.0
    assert power_ons.current(output) == PowerOn(cycle=3, on_s=5.0)
