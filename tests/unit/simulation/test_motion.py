"""What carries a unit: vibration table, rate table; the angle between knots."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.errors import StationError
from gyrotest.records.station import Instrument, Simulation, Slot, Station
from gyrotest.simulation.motion import Carried, Kept, Knots, Path, Resting
from gyrotest.simulation.vibration import Shaken, SteadyDrive, VibrationTable, vibration_table

KNOT_S = 1e-4
TABLE = VibrationTable(sensitivity_dps_per_v=20.0)


class EvenTable:
    """Turns at 12 °/s."""

    def angle_deg(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        return 5.0 + 12.0 * times_s


def shaken(frequency_hz: float, count: int = 60_000, parts: int = 1) -> Knots:
    motion = Shaken(SteadyDrive(peak_v=0.5, frequency_hz=frequency_hz), TABLE)
    first = -math.ceil(motion.settling_s / KNOT_S)
    motion.begin(first, origin_s=7.0, interval_s=KNOT_S)
    motion.take(-first)
    taken = [motion.take(len(part)) for part in np.array_split(np.arange(count), parts)]
    return Knots(
        angle_deg=np.concatenate([one.angle_deg for one in taken]),
        rate_dps=np.concatenate([one.rate_dps for one in taken]),
    )


@pytest.mark.parametrize("frequency_hz", [2.0, 5.0, 50.0, 100.0, 250.0])
def test_a_vibration_table_moves_by_its_transfer_function(frequency_hz: float) -> None:
    knots = shaken(frequency_hz)
    expected = 0.5 * abs(TABLE.response(np.array([frequency_hz]), rate_hz=1.0 / KNOT_S)[0])
    assert np.sqrt(2.0 * np.mean(knots.rate_dps**2)) == pytest.approx(expected, rel=1e-6)


def test_a_vibration_table_is_flat_in_the_middle_and_bounded_at_both_ends() -> None:
    found = np.abs(TABLE.response(np.array([0.2, 2.0, 20.0, 250.0, 2500.0]), rate_hz=20e3)) / 20.0
    assert found == pytest.approx([0.01, math.sqrt(0.5), 1.006, 2.5, 0.0095], rel=0.06)


def test_the_angle_swings_about_0_and_is_the_integral_of_the_rate() -> None:
    knots = shaken(10.0)
    mean_dps = 0.5 * (knots.rate_dps[1:] + knots.rate_dps[:-1])
    assert np.diff(knots.angle_deg) == pytest.approx(mean_dps * KNOT_S, abs=1e-12)
    assert abs(knots.angle_deg.mean()) < 1e-6 * np.ptp(knots.angle_deg)


def test_a_motion_is_the_same_however_it_is_asked_for() -> None:
    once, often = shaken(33.0, count=5000), shaken(33.0, count=5000, parts=123)
    assert once.angle_deg == pytest.approx(often.angle_deg, abs=1e-12)
    assert once.rate_dps == pytest.approx(often.rate_dps, abs=1e-12)


@pytest.mark.parametrize("shift_s", [0.0, 1e-6, -1e-6, 0.4e-4, 2.3e-4, -3.1e-4])
def test_between_knots_the_angle_is_a_parabola(shift_s: float) -> None:
    # A rate that grows evenly: its angle is one parabola all the way.
    times_s = KNOT_S * np.arange(-20, 200)
    path = Path(-20, KNOT_S)
    for part in np.array_split(times_s, 9):
        path.extend(Knots(angle_deg=3.0 * part + 50.0 * part**2, rate_dps=3.0 + 100.0 * part))
    knot = 180
    found = path.angles_deg(knot, 3, step=2, shift_s=shift_s)
    at_s = KNOT_S * (knot + 2 * np.arange(3)) + shift_s
    assert found == pytest.approx(3.0 * at_s + 50.0 * at_s**2, abs=1e-12)


def test_knots_that_are_forgotten_or_to_come_are_refused() -> None:
    kept = Kept(0, 4)
    kept.extend(np.arange(10.0))
    kept.extend(np.arange(10.0, 20.0))
    assert kept.every(3, 8, 4) == pytest.approx([8.0, 11.0, 14.0, 17.0])
    for knot in (5, 11):
        with pytest.raises(ValueError, match="knots 6 to 19 are known"):
            kept.every(3, knot, 4)


def test_a_rate_table_s_rates_are_those_of_half_a_knot_before() -> None:
    motion = Carried(EvenTable())
    motion.begin(-5, origin_s=100.0, interval_s=0.002)
    knots = motion.take(20)
    assert motion.late_s == pytest.approx(0.001)
    assert knots.rate_dps == pytest.approx(12.0)
    assert knots.angle_deg[5] == pytest.approx(5.0 + 1200.0)


def test_where_nothing_moves_nothing_turns() -> None:
    knots = Resting().take(4)
    assert not knots.angle_deg.any()
    assert not knots.rate_dps.any()


def station(simulated: dict[str, object], sensitivity: object = "10 deg/s/V") -> Station:
    return Station(
        name="v",
        instruments={
            "exciter": Instrument(
                driver="keysight33500b",
                resource="simulated",
                settings={"sensitivity": sensitivity},
            )
        },
        slots={"a": Slot(source="exciter")},
        simulation=Simulation(instruments={"exciter": simulated}),
    )


def test_a_table_is_what_the_station_says() -> None:
    given = {"resonance": "300 Hz", "resonance_damping": 0.1, "gain_error": "1 %"}
    assert vibration_table(station(given), "exciter") == VibrationTable(
        sensitivity_dps_per_v=10.0, low_edge_hz=2.0, resonance_hz=300.0, resonance_damping=0.1
    )


def test_complaints_about_a_table_come_together() -> None:
    with pytest.raises(StationError) as refused:
        vibration_table(station({"low_edge": "0 Hz", "resonance": "1 V"}, "3 V"), "exciter")
    for key in ("exciter.low_edge", "exciter.resonance", "exciter.settings.sensitivity"):
        assert key in str(refused.value)
