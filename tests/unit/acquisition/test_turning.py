"""A table in an acquisition: plans that it cannot turn, rates that it reaches or does not."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from gyrotest.acquisition.turning import TableDrive, motion_faults
from gyrotest.errors import InstrumentError
from gyrotest.records.plan import Plan, Soaking, Step, Turning
from gyrotest.records.recording import Identity
from gyrotest.records.station import Motion
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.table import SimulatedTable, TableFaults, TableParameters
from gyrotest.units import Quantity

RING = Motion(
    max_rate=Quantity(200.0, "deg/s"), max_acceleration=Quantity(100.0, "deg/s/s"), slip_ring=True
)


def cables(max_turns: float | None) -> Motion:
    return replace(RING, slip_ring=False, max_turns=max_turns)


def plan_of(*rates_dps: float, samples: int = 10, settle_s: float = 1.0) -> Plan:
    steps = tuple(
        Step(
            samples=samples,
            name=f"{rate:+g} deg/s",
            stimulus=Turning(rate_dps=rate, settle_s=settle_s),
        )
        for rate in rates_dps
    )
    return Plan(warm_up_s=0.0, interval_s=1.0, steps=steps)


class DirectTable:
    """The port on a simulated table without a controller between."""

    def __init__(self, table: SimulatedTable) -> None:
        self.table = table
        self.enabled = 0

    def open(self) -> Identity:
        return Identity(manufacturer="none", model="table", serial_number="SIM1")

    def enable(self) -> None:
        self.enabled += 1
        self.table.acceleration_limit_dps2 = 100.0

    def set_rate(self, rate_dps: float) -> None:
        self.table.set_rate(rate_dps)

    def rate_dps(self) -> float:
        if self.table.interlock_open():
            raise InstrumentError("table: interlock fault")
        return self.table.read_rate_dps()

    def position_deg(self) -> float:
        return float(self.table.angle_deg(np.array([self.table._clock.now_s()]))[0])

    def move_to(self, position_deg: float) -> None:
        self.table.move_to(position_deg)

    def stop(self) -> None:
        self.table.set_rate(0.0)

    def close(self) -> None:
        self.stop()


class Bench:
    def __init__(self, motion: Motion = RING, faults: TableFaults | None = None) -> None:
        self.clock = VirtualClock()
        self.table = SimulatedTable("table", TableParameters(ripple=1e-4), seed=1, clock=self.clock)
        self.table.begin(Occasion(serial_number="1", duration_s=60.0), faults)
        self.port = DirectTable(self.table)
        self.drive = TableDrive(self.port, clock=self.clock, motion=motion, name="table")

    def dwell(self, duration_s: float) -> None:
        for _ in range(round(2 * duration_s)):
            self.clock.advance(0.5)
            self.drive.watch()


def test_a_plan_within_the_motion_has_no_faults() -> None:
    assert motion_faults(plan_of(10, -10, 200, -200), RING) == ()
    assert motion_faults(plan_of(10, -10), cables(1.0)) == ()
    assert motion_faults(Plan(warm_up_s=0, interval_s=1, steps=()), cables(None)) == ()


def test_every_rate_beyond_the_greatest_is_named() -> None:
    faults = motion_faults(plan_of(10, 250, -300), RING)
    assert len(faults) == 2
    assert faults[0].startswith("step '+250 deg/s': 250 deg/s is more than the table's 200 deg/s")
    assert faults[1].startswith("step '-300 deg/s'")


def test_the_step_that_winds_the_cables_up_is_named_with_the_turns() -> None:
    # 36 °/s for 1 s + 10 s are 1.1 turns a step, and the table is waited for up to 3 s more.
    (fault,) = motion_faults(plan_of(36, 36, 36), cables(4.0))
    assert fault.startswith("step '+36 deg/s' takes the table up to 4.3 turns from its start")
    assert "the cables allow ±4 (motion.max_turns); order the rates alternately" in fault


def test_rates_in_turn_need_fewer_turns_than_rates_one_after_the_other() -> None:
    assert motion_faults(plan_of(36, -36, 36, -36), cables(2.5)) == ()
    assert motion_faults(plan_of(36, 36, -36, -36), cables(2.5))


def test_turns_are_counted_from_run_up_to_run_down() -> None:
    # 200 °/s at 100 °/s²: 200° up, 200° down, 200° of settling, 3 s and a half ramp more waited for.
    plan = plan_of(200, samples=1)
    needed = (200 + 200 + 200 + 200 + 200 * (3.0 + 1.0)) / 360
    assert motion_faults(plan, cables(needed + 0.01)) == ()
    assert motion_faults(plan, cables(needed - 0.01))


def test_samples_count_with_their_interval_and_steps_without_a_rate_go_on_turning() -> None:
    plan = plan_of(36)
    assert motion_faults(replace(plan, interval_s=0.1), cables(2.0)) == ()
    going_on = replace(plan, steps=(*plan.steps, Step(samples=100)))
    assert motion_faults(going_on, cables(2.0))


def test_a_station_that_says_nothing_of_its_cables_is_refused_unless_the_table_rests() -> None:
    assert motion_faults(plan_of(0), cables(None)) == ()
    (fault,) = motion_faults(plan_of(0, 10), cables(None))
    assert "neither a slip ring nor how far the cables let it turn" in fault
    soaking = Step(samples=1, stimulus=Soaking(temperature_degc=20.0, soak_s=1.0))
    assert motion_faults(Plan(warm_up_s=0, interval_s=1, steps=(soaking,)), cables(None)) == ()


def test_a_rate_is_reached_settled_and_read_back() -> None:
    bench = Bench()
    bench.drive.reach(Turning(rate_dps=80.0, settle_s=2.0))
    reached_s = bench.clock.now_s()
    assert 2.8 < reached_s < 4.0
    bench.dwell(10.0)
    assert bench.port.enabled == 1
    assert bench.drive.read_back() == pytest.approx(80.0, abs=0.01)


def test_what_was_read_back_is_of_the_last_rate_only() -> None:
    bench = Bench()
    assert bench.drive.read_back() is None
    bench.drive.reach(Turning(rate_dps=80.0))
    bench.dwell(3.0)
    bench.drive.reach(Turning(rate_dps=-20.0, settle_s=1.0))
    bench.dwell(3.0)
    assert bench.drive.read_back() == pytest.approx(-20.0, abs=0.01)
    assert bench.port.enabled == 1


def test_a_table_that_stays_below_the_rate_is_stopped_and_named() -> None:
    bench = Bench(faults=TableFaults(reaches=0.6))
    with pytest.raises(
        InstrumentError, match=r"^table: 80 deg/s is demanded, 4[78]\.\d* deg/s read back"
    ):
        bench.drive.reach(Turning(rate_dps=80.0))
    assert bench.table.demanded_dps == 0.0
    assert bench.clock.now_s() == pytest.approx(1.5 * 0.8 + 3.0, abs=0.2)


def test_a_table_that_leaves_its_rate_in_a_dwell_is_an_error() -> None:
    bench = Bench()
    bench.drive.reach(Turning(rate_dps=10.0))
    bench.dwell(3.0)
    bench.table.set_rate(10.2)
    with pytest.raises(InstrumentError, match=r"left its rate: 10 deg/s is demanded, 10\.2"):
        bench.dwell(3.0)


def test_an_interlock_in_a_dwell_is_the_table_s_own_error() -> None:
    bench = Bench(faults=TableFaults(interlock_opens_s=5.0))
    bench.drive.reach(Turning(rate_dps=10.0))
    with pytest.raises(InstrumentError, match="interlock fault"):
        bench.dwell(10.0)


def test_the_table_is_looked_at_about_once_a_second_not_at_every_block() -> None:
    bench = Bench()
    bench.drive.reach(Turning(rate_dps=10.0))
    looked = []
    bench.port.rate_dps = lambda: looked.append(bench.clock.now_s()) or 10.0  # type: ignore[method-assign]
    for _ in range(1000):
        bench.clock.advance(0.01)
        bench.drive.watch()
    assert 9 <= len(looked) <= 10


def test_after_a_plan_the_cables_are_unwound_the_way_they_were_wound() -> None:
    bench = Bench(cables(5.0))
    for rate_dps in (80.0, 40.0):
        bench.drive.reach(Turning(rate_dps=rate_dps, settle_s=1.0))
        bench.dwell(8.0)
    wound_deg = bench.port.position_deg()
    bench.drive.rest()
    assert wound_deg > 720.0
    assert bench.port.position_deg() == pytest.approx(0.0, abs=5.0)
    assert bench.table.read_rate_dps() == pytest.approx(0.0, abs=0.1)
    assert bench.table.angle_deg(np.linspace(0.0, bench.clock.now_s(), 5000)).min() > -30.0


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.sampled_from([-150.0, -80.0, -10.0, 0.0, 10.0, 80.0, 150.0]), min_size=1, max_size=6),
    st.sampled_from([2.0, 4.0, 8.0]),
)
def test_a_plan_that_is_let_through_never_turns_beyond_the_cables(
    rates_dps: list[float], max_turns: float
) -> None:
    plan = plan_of(*rates_dps, samples=4)
    motion = cables(max_turns)
    assume(not motion_faults(plan, motion))
    bench = Bench(motion)
    for step in plan.steps:
        assert isinstance(step.stimulus, Turning)
        bench.drive.reach(replace(step.stimulus, tolerance_dps=0.1))
        bench.dwell(4.0)
    bench.drive.rest()
    turned_deg = bench.table.angle_deg(np.linspace(0.0, bench.clock.now_s(), 20_000))
    assert np.abs(turned_deg).max() <= 360.0 * max_turns
    assert abs(turned_deg[-1]) <= 5.0


def test_with_a_slip_ring_it_stays_where_it_comes_to_rest() -> None:
    bench = Bench()
    bench.drive.reach(Turning(rate_dps=80.0))
    bench.dwell(10.0)
    bench.drive.rest()
    assert bench.port.position_deg() > 720.0
    assert bench.table.read_rate_dps() == pytest.approx(0.0, abs=0.1)


def test_an_interrupted_plan_stops_the_table_and_the_next_one_turns_it_back_first() -> None:
    bench = Bench(cables(5.0))
    bench.drive.reach(Turning(rate_dps=80.0))
    bench.dwell(8.0)
    with pytest.raises(KeyboardInterrupt):
        rested_by_an_interruption(bench)
    bench.clock.advance(5.0)
    assert bench.port.position_deg() > 600.0
    bench.drive.reach(Turning(rate_dps=0.0))
    assert bench.port.position_deg() == pytest.approx(0.0, abs=5.0)


def rested_by_an_interruption(bench: Bench) -> None:
    try:
        raise KeyboardInterrupt
    finally:
        bench.drive.rest()


def test_resting_before_anything_was_switched_on_does_nothing() -> None:
    bench = Bench()
    bench.drive.rest()
    assert bench.port.enabled == 0
