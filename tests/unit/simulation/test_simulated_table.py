"""The simulated table: its run-up, its own errors, its ripple, and what goes wrong with it."""

from dataclasses import replace

import numpy as np
import pytest

from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.table import SimulatedTable, TableFaults, TableParameters

OCCASION = Occasion(serial_number="1234", case="scale_factor", repeat=1, duration_s=100.0)
REAL = TableParameters(gain_error=50e-6, setting_error_dps=2e-4, ripple=1e-4)


def table_of(
    parameters: TableParameters, *, seed: int = 1, faults: TableFaults | None = None
) -> tuple[SimulatedTable, VirtualClock]:
    clock = VirtualClock(100.0)
    table = SimulatedTable("table", parameters, seed=seed, clock=clock)
    table.begin(OCCASION, faults)
    table.acceleration_limit_dps2 = 100.0
    return table, clock


def rates(table: SimulatedTable, from_s: float, to_s: float, step_s: float = 0.01) -> np.ndarray:
    times_s = np.arange(from_s, to_s, step_s)
    return np.diff(table.angle_deg(times_s)) / step_s


def test_it_runs_up_by_the_acceleration_and_settles_without_overshoot() -> None:
    table, clock = table_of(TableParameters(settling_time_constant_s=0.05))
    table.set_rate(80.0)
    clock.advance(5.0)
    found = rates(table, 100.0, 105.0)
    assert found[:70] == pytest.approx(100.0 * (np.arange(70) + 0.5) * 0.01, abs=1e-6)
    assert found.max() <= 80.0 + 1e-9
    assert found[200:] == pytest.approx(80.0, abs=1e-6)
    assert np.diff(found).max() <= 100.0 * 0.01 + 1e-9


def test_the_angle_is_the_rate_s_integral_through_every_change() -> None:
    table, clock = table_of(REAL)
    for rate_dps in (80.0, -40.0, 10.0, 0.0):
        table.set_rate(rate_dps)
        clock.advance(0.7)
    angles_deg = table.angle_deg(np.linspace(100.0, 102.8, 28_001))
    steps_deg = np.diff(angles_deg)
    # No jump anywhere, and no acceleration beyond the limit (ripple adds a little of its own).
    assert np.abs(steps_deg).max() < 80.1e-4
    assert np.abs(np.diff(steps_deg)).max() / 1e-8 < 130.0


def test_past_angles_do_not_change_when_they_are_asked_for_again() -> None:
    table, clock = table_of(REAL)
    times_s = np.linspace(100.0, 104.0, 400)
    table.set_rate(50.0)
    clock.advance(4.0)
    before = table.angle_deg(times_s)
    table.set_rate(-50.0)
    clock.advance(4.0)
    assert table.angle_deg(times_s).tolist() == before.tolist()


def test_the_gain_error_is_common_and_each_setting_has_an_error_of_its_own() -> None:
    table, clock = table_of(replace(REAL, ripple=0.0))
    own = []
    for rate_dps in (80.0, 40.0, 80.0, -80.0):
        table.set_rate(rate_dps)
        clock.advance(5.0)
        true_dps = rates(table, clock.now_s() - 1.0, clock.now_s()).mean()
        own.append(true_dps - rate_dps * (1.0 + table.errors.gain))
        assert table.read_rate_dps() == pytest.approx(rate_dps, abs=1e-9)
    assert 0.0 < abs(table.errors.gain) <= 50e-6
    assert table.truth() == {"table_gain_error": table.errors.gain}
    assert np.abs(own).max() <= 2e-4
    assert len({round(one, 9) for one in own}) == 4


def test_errors_are_spread_over_the_stated_accuracy_from_unit_to_unit() -> None:
    table, _ = table_of(REAL)
    gains = []
    for number in range(200):
        table.begin(replace(OCCASION, serial_number=str(number)))
        gains.append(table.errors.gain / 50e-6)
    assert np.abs(gains).max() <= 1.0
    assert np.std(gains) == pytest.approx(1.0 / np.sqrt(3.0), rel=0.1)


def test_ripple_is_in_proportion_to_the_rate_and_gone_over_whole_turns() -> None:
    table, clock = table_of(TableParameters(ripple=1e-3, ripple_per_turn=36))
    table.set_rate(36.0)
    clock.advance(21.0)
    found = rates(table, 110.0, 120.0, 1e-3)
    assert found.max() - 36.0 == pytest.approx(0.036, rel=0.01)
    assert found.mean() == pytest.approx(36.0, abs=1e-4)
    # 3.6 periods a second: 36 a turn of 10 s.
    assert np.sum(np.diff(np.sign(found - 36.0)) > 0) == 36


def test_the_same_commands_at_the_same_times_give_the_same_turning() -> None:
    def turned() -> list[float]:
        table, clock = table_of(REAL, seed=7)
        for rate_dps in (10.0, -20.0):
            table.set_rate(rate_dps)
            clock.advance(3.0)
        return table.angle_deg(np.linspace(100.0, 106.0, 50)).tolist()

    assert turned() == turned()


def test_a_slow_table_reaches_part_of_the_rate() -> None:
    table, clock = table_of(TableParameters(), faults=TableFaults(reaches=0.6))
    table.set_rate(50.0)
    clock.advance(5.0)
    assert table.read_rate_dps() == pytest.approx(30.0, abs=1e-6)


def test_an_interlock_stops_the_table_at_its_time_whenever_it_is_looked_at() -> None:
    angles = []
    for looks in (1, 10):
        table, clock = table_of(TableParameters(), faults=TableFaults(interlock_opens_s=103.0))
        table.set_rate(50.0)
        for _ in range(looks):
            clock.advance(10.0 / looks)
            table.angle_deg(np.array([clock.now_s()]))
        assert table.interlock_open()
        assert table.read_rate_dps() == pytest.approx(0.0, abs=1e-9)
        angles.append(float(table.angle_deg(np.array([clock.now_s()]))[0]))
    # 0.25 s of run-up lost, 3 s, and 0.25 s of run-down on average, both with their settling.
    assert angles[0] == pytest.approx(angles[1], abs=1e-9)
    assert angles[0] == pytest.approx(50.0 * 3.0, abs=1e-3)


def test_the_next_record_begins_where_it_stands_with_the_interlock_closed() -> None:
    table, clock = table_of(TableParameters(), faults=TableFaults(interlock_opens_s=101.0))
    table.set_rate(50.0)
    clock.advance(10.0)
    there_deg = table.angle_deg(np.array([clock.now_s()]))
    assert table.interlock_open()
    table.begin(OCCASION)
    assert not table.interlock_open()
    assert table.angle_deg(np.array([clock.now_s()])) == pytest.approx(there_deg)


def test_a_move_while_it_turns_brakes_first_and_ends_at_the_angle() -> None:
    table, clock = table_of(TableParameters())
    table.set_rate(50.0)
    clock.advance(2.0)
    table.move_to(10.0)
    clock.advance(30.0)
    angles_deg = table.angle_deg(np.linspace(100.0, 132.0, 3201))
    assert angles_deg[-1] % 360.0 == pytest.approx(10.0, abs=1e-4)
    assert np.abs(np.diff(angles_deg, 2)).max() / 1e-4 < 105.0
    assert table.read_angle_deg() == pytest.approx(10.0, abs=1e-4)
