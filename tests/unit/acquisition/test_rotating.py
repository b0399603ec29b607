"""A rotation stage in an acquisition: the same angles there and back, never beyond the ends, angles held."""

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from gyrotest.acquisition.deadline import Deadline
from gyrotest.acquisition.rotating import RotationRecorded, StageDrive
from gyrotest.acquisition.rotation_limits import least_run_up_deg, rotation_faults, stopping_deg
from gyrotest.acquisition.stimulation import ReadBack, Stimulation
from gyrotest.errors import AcquisitionError, InstrumentError
from gyrotest.records.plan import Plan, Pointing, Rotating, Step, Turning
from gyrotest.records.recording import Identity
from gyrotest.records.station import Motion
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.table import SimulatedTable, TableFaults, TableParameters
from gyrotest.units import Quantity

MOTION = Motion(
    max_rate=Quantity(20.0, "deg/s"), max_acceleration=Quantity(50.0, "deg/s/s"), max_turns=1.0
)
THERE = Rotating(rate_dps=6.0, run_up_deg=5.0)
BACK = Rotating(rate_dps=-6.0, run_up_deg=5.0)
SAMPLED_S = THERE.sampled_deg / 6.0


@dataclass
class Stage:
    """The port on a simulated table without a controller between; every angle that it takes is kept.

    It tells an angle within one turn, as controllers do, counted on from where it was asked first. A rate
    takes `reading_s` to be told.
    """

    clock: VirtualClock
    table: SimulatedTable
    reading_s: float = 0.0
    stops: bool = True
    enabled: int = 0

    def open(self) -> Identity:
        return Identity(manufacturer="none", model="stage", serial_number="SIM1")

    def enable(self) -> None:
        self.enabled += 1
        self.table.acceleration_limit_dps2 = 50.0
        self.table.rate_limit_dps = 20.0

    def set_rate(self, rate_dps: float) -> None:
        if rate_dps or self.stops:
            self.table.set_rate(rate_dps)

    def rate_dps(self) -> float:
        if self.table.interlock_open():
            raise InstrumentError("stage: interlock fault")
        self.clock.advance(self.reading_s)
        return self.table.read_rate_dps()

    def position_deg(self) -> float:
        return float(self.table.angle_deg(np.array([self.clock.now_s()]))[0])

    def move_to(self, position_deg: float) -> None:
        self.table.move_to(position_deg)

    def stop(self) -> None:
        if self.stops:
            self.table.set_rate(0.0)

    def close(self) -> None:
        self.stop()


class Bench:
    """A stage that stands at an angle, and a record of where it was at every tick of the clock."""

    def __init__(
        self, at_deg: float = 0.0, faults: TableFaults | None = None, reading_s: float = 0.0
    ) -> None:
        self.clock = VirtualClock()
        parameters = TableParameters(ripple=1e-4, gain_error=5e-5, setting_error_dps=2e-4)
        self.table = SimulatedTable("stage", parameters, seed=1, clock=self.clock)
        self.table.begin(Occasion(serial_number="1", duration_s=60.0), faults)
        self._stand_at(at_deg)
        self.port = Stage(self.clock, self.table, reading_s)
        self.drive = StageDrive(self.port, clock=self.clock, motion=MOTION, name="stage")
        self.angles_deg: list[float] = []
        self.clock.subscribe(self._look)

    def _stand_at(self, at_deg: float) -> None:
        for part in (at_deg / 3, 2 * at_deg / 3, at_deg):
            self.table.move_to(part)
            self.clock.advance(100.0)

    def _look(self, now_s: float) -> None:
        # Between two ticks too: whatever passed since the last one.
        times_s = np.linspace(max(0.0, now_s - 2.0), now_s, 9)
        self.angles_deg += self.table.angle_deg(times_s).tolist()

    @property
    def now_deg(self) -> float:
        return self.port.position_deg()

    def sample(self, duration_s: float = SAMPLED_S, block_s: float = 0.25) -> list[float]:
        """What a source does: blocks, each looked at; the angles of the first and the last sample."""
        first_deg, begun_s = self.now_deg, self.clock.now_s()
        # The source goes on while the drive looks.
        for due_s in (*np.arange(block_s, duration_s, block_s), duration_s):
            self.clock.sleep_until(begun_s + due_s)
            self.drive.watch()
        return [first_deg, self.now_deg]

    def turn(self, rotating: Rotating) -> list[float]:
        sampled_s = rotating.sampled_deg / abs(rotating.rate_dps)
        self.drive.reach(rotating, sampled_s=sampled_s)
        found = self.sample(sampled_s)
        self.drive.leave()
        return found

    def within(self) -> bool:
        return min(self.angles_deg) >= -0.5 and max(self.angles_deg) <= 360.5


def plan_of(*stimuli: Rotating | Pointing | Turning, samples: int = 500) -> Plan:
    steps = tuple(
        Step(samples=samples, name=f"step {number}", stimulus=one)
        for number, one in enumerate(stimuli, start=1)
    )
    return Plan(warm_up_s=0.0, interval_s=0.1, steps=steps)


def test_it_turns_there_and_back_over_the_same_angles_and_ends_at_0() -> None:
    bench = Bench()
    for _ in range(2):
        first_deg, last_deg = bench.turn(THERE)
        assert 5.0 <= first_deg < 5.7
        assert last_deg - first_deg == pytest.approx(350.0, abs=0.1)
        last_back_deg, first_back_deg = reversed(bench.turn(BACK))
        assert 354.3 < 360.0 - (360.0 - first_back_deg) <= 355.0
        assert first_back_deg - last_back_deg == pytest.approx(350.0, abs=0.1)
    bench.drive.rest()
    bench.clock.advance(1.0)
    assert bench.now_deg == pytest.approx(0.0, abs=0.3)
    assert bench.within()
    assert bench.port.enabled == 1


def test_the_rate_is_reached_before_the_first_sample_and_its_mean_is_read_back() -> None:
    bench = Bench()
    bench.drive.reach(BACK, sampled_s=SAMPLED_S)
    assert bench.port.rate_dps() == pytest.approx(-6.0, abs=0.01)
    bench.sample()
    bench.drive.leave()
    found = bench.drive.read_back()
    assert found.demanded_rate_dps == -6.0
    assert found.rate_dps == pytest.approx(-6.0, abs=0.005)
    assert bench.port.rate_dps() == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize("at_deg", [0.3, -0.3, 4.0, 90.0, 180.0, 271.0, 359.0, 359.8])
def test_from_wherever_it_stands_it_goes_to_0_first_by_the_way_it_may_have_come(at_deg: float) -> None:
    bench = Bench(at_deg)
    bench.port.position_deg = _within_a_turn(bench)  # type: ignore[method-assign]
    first_deg, last_deg = bench.turn(THERE)
    assert 5.0 <= first_deg % 360.0 < 5.7
    assert last_deg - first_deg == pytest.approx(350.0, abs=0.1)
    bench.drive.rest()
    bench.clock.advance(1.0)
    # Never once around the other way.
    turned = np.array(bench.angles_deg)
    assert turned.max() - turned.min() <= 361.0


def _within_a_turn(bench: Bench) -> Callable[[], float]:
    """What a driver tells: an angle within one turn at first, its whole turns counted from then on."""
    plain = Stage.position_deg
    start_deg = plain(bench.port)
    whole_deg = start_deg % 360.0 - start_deg
    return lambda: plain(bench.port) + whole_deg


def test_after_a_turn_it_begins_the_next_one_where_it_stands_if_there_is_way_enough() -> None:
    bench = Bench()
    bench.turn(replace(THERE, run_up_deg=15.0))
    stood_deg = bench.now_deg
    assert 345.0 < stood_deg < 347.0
    # So near to the first sample it could not run up: it goes to the end first.
    bench.drive.reach(replace(BACK, run_up_deg=15.0), sampled_s=1.0)
    assert max(bench.angles_deg) == pytest.approx(360.0, abs=0.3)
    slow = Bench()
    slow.turn(replace(THERE, run_up_deg=15.0))
    slow.drive.reach(Rotating(rate_dps=-1.0, run_up_deg=15.5), sampled_s=1.0)
    assert max(slow.angles_deg) < 350.0


def test_it_holds_angles_and_goes_to_each_without_passing_0() -> None:
    bench = Bench()
    for angle_deg in (0.0, 350.0, 10.0, 360.0, 180.0, 90.0, 0.0):
        bench.drive.reach(Pointing(position_deg=angle_deg, settle_s=2.0), sampled_s=5.0)
        begun_s = bench.clock.now_s()
        assert bench.sample(5.0) == pytest.approx([angle_deg] * 2, abs=0.1)
        bench.drive.leave()
        assert bench.clock.now_s() == pytest.approx(begun_s + 5.0)
        found = bench.drive.read_back()
        assert found.demanded_position_deg == angle_deg
        assert found.position_deg == pytest.approx(angle_deg, abs=0.1)
    assert bench.within()


def test_a_stage_that_does_not_reach_its_rate_is_stopped() -> None:
    bench = Bench(faults=TableFaults(reaches=0.6))
    with pytest.raises(InstrumentError, match=r"6 deg/s is demanded, 3\.59.* read back") as caught:
        bench.drive.reach(THERE, sampled_s=SAMPLED_S)
    assert "it is stopped" in str(caught.value)
    bench.clock.advance(5.0)
    assert bench.port.rate_dps() == pytest.approx(0.0, abs=0.1)
    assert bench.within()


def test_one_that_stands_still_is_told_of_after_the_time_that_it_may_take() -> None:
    bench = Bench(faults=TableFaults(reaches=0.0))
    with pytest.raises(
        InstrumentError, match=r"read back after all the time that the acceleration gives"
    ):
        bench.drive.reach(THERE, sampled_s=SAMPLED_S)


def test_a_source_that_is_late_is_not_waited_for_beyond_the_end() -> None:
    bench = Bench()
    bench.drive.reach(THERE, sampled_s=SAMPLED_S)
    with pytest.raises(InstrumentError, match=r"stopped before it came to the end of its turn.*late"):
        bench.sample(SAMPLED_S + 2.0)
    bench.drive.rest()
    bench.clock.advance(5.0)
    assert 350.0 < max(bench.angles_deg) <= 360.0


def test_a_source_that_keeps_everybody_waiting_does_not_keep_the_stage_turning() -> None:
    bench = Bench()
    bench.drive.reach(THERE, sampled_s=SAMPLED_S)
    bench.sample(SAMPLED_S - 1.0)
    stopped = threading.Event()
    stop = bench.port.stop

    def told() -> None:
        stop()
        stopped.set()

    bench.port.stop = told  # type: ignore[method-assign]
    # The acquiring thread hangs in its source while time goes by.
    bench.clock.advance(1.66)
    assert stopped.wait(10.0)
    bench.clock.advance(30.0)
    assert max(bench.angles_deg) <= 360.0
    with pytest.raises(InstrumentError, match="stopped before it came to the end"):
        bench.drive.watch()


def test_a_pause_in_which_it_would_come_too_far_is_refused() -> None:
    bench = Bench()
    bench.drive.reach(THERE, sampled_s=SAMPLED_S)
    bench.sample(30.0)
    bench.drive.allow_pause(5.0)
    with pytest.raises(InstrumentError, match="stopped before it came to the end"):
        bench.drive.allow_pause(30.0)
    bench.clock.advance(2.0)
    assert bench.port.rate_dps() == pytest.approx(0.0, abs=0.1)
    pointing = Bench()
    pointing.drive.reach(Pointing(position_deg=20.0), sampled_s=5.0)
    pointing.drive.allow_pause(3600.0)


def test_a_stage_that_leaves_its_rate_or_its_angle_is_told_of() -> None:
    bench = Bench()
    bench.drive.reach(THERE, sampled_s=SAMPLED_S)
    bench.sample(5.0)
    bench.table.set_rate(12.0)
    bench.clock.advance(1.0)
    with pytest.raises(InstrumentError, match=r"11\.99\d* deg/s read back on its way"):
        bench.drive.watch()
    pushed = Bench()
    pushed.drive.reach(Pointing(position_deg=20.0), sampled_s=5.0)
    pushed.table.move_to(21.0)
    pushed.clock.advance(2.0)
    with pytest.raises(InstrumentError, match=r"stands at 21.000°, 20° is demanded, ±0.1° is accepted"):
        pushed.drive.watch()


def test_a_stage_that_does_not_stop_is_told_of() -> None:
    bench = Bench()
    bench.drive.reach(THERE, sampled_s=SAMPLED_S)
    bench.sample()
    bench.port.stops = False
    with pytest.raises(InstrumentError, match="does not come to rest"):
        bench.drive.leave()


def test_one_that_stops_too_late_has_come_beyond_its_end() -> None:
    bench = Bench()
    bench.drive.reach(THERE, sampled_s=SAMPLED_S)
    bench.sample()
    bench.table.acceleration_limit_dps2 = 2.0
    with pytest.raises(InstrumentError, match=r"came to rest 3\.\d\d° beyond the end of its turn"):
        bench.drive.leave()


def test_an_angle_that_is_not_reached_is_told_of() -> None:
    bench = Bench()
    bench.drive.reach(Pointing(position_deg=0.0), sampled_s=1.0)
    bench.port.move_to = lambda position_deg: None  # type: ignore[method-assign]
    with pytest.raises(InstrumentError, match=r"does not come to 20°: it is at 0\.000°"):
        bench.drive.reach(Pointing(position_deg=20.0), sampled_s=1.0)


def test_an_open_interlock_ends_a_turn() -> None:
    bench = Bench(faults=TableFaults(interlock_opens_s=320.0))
    bench.drive.reach(THERE, sampled_s=SAMPLED_S)
    with pytest.raises(InstrumentError, match="interlock fault"):
        bench.sample()


def test_a_controller_that_takes_long_to_tell_the_rate_needs_a_longer_run_up() -> None:
    slow = Bench(reading_s=1.0)
    slow.drive.reach(replace(THERE, run_up_deg=10.0), sampled_s=340.0 / 6.0)
    first_deg, last_deg = slow.sample(340.0 / 6.0)
    slow.drive.leave()
    assert first_deg < 11.0
    assert last_deg < 352.0
    short = Bench(reading_s=1.0)
    with pytest.raises(
        InstrumentError, match=r"a controller that takes 1 s to tell the rate; lengthen it"
    ):
        short.drive.reach(THERE, sampled_s=SAMPLED_S)


def test_while_an_error_is_dealt_with_it_is_stopped_and_not_turned_back() -> None:
    bench = Bench()
    bench.drive.reach(THERE, sampled_s=SAMPLED_S)
    bench.sample(20.0)
    try:
        raise AcquisitionError("source")
    except AcquisitionError:
        bench.drive.rest()
    stood_deg = bench.now_deg
    assert 120.0 < stood_deg < 130.0
    bench.clock.advance(10.0)
    assert bench.now_deg == pytest.approx(stood_deg, abs=0.01)
    bench.drive.turning.put_down()
    bench.drive.turning.take_up()
    first_deg, _ = bench.turn(THERE)
    assert 5.0 <= first_deg < 5.7
    assert bench.within()


def test_a_stage_also_turns_like_any_rate_table_and_comes_back_to_0() -> None:
    bench = Bench()
    bench.drive.turning.reach(Turning(rate_dps=5.0, settle_s=1.0))
    bench.clock.advance(20.0)
    bench.drive.turning.rest()
    bench.clock.advance(1.0)
    assert bench.now_deg == pytest.approx(0.0, abs=0.3)


def test_what_a_stage_can_do_has_no_faults() -> None:
    assert rotation_faults(plan_of(THERE, BACK, Pointing(position_deg=360.0)), MOTION) == ()
    ring = replace(MOTION, slip_ring=True, max_turns=None)
    assert rotation_faults(plan_of(THERE), ring) == ()


def test_everything_that_it_cannot_do_is_named_with_its_numbers() -> None:
    plan = plan_of(
        replace(THERE, rate_dps=30.0),
        replace(THERE, rate_dps=0.0),
        replace(BACK, run_up_deg=2.0),
        Pointing(position_deg=-1.0),
    )
    faults = rotation_faults(plan, MOTION)
    assert faults[0].startswith(
        "step 'step 1': 30 deg/s is not more than 0 and at most the stage's 20 deg/s"
    )
    assert faults[1].startswith("step 'step 2': 0 deg/s")
    assert "the run-up of 2° is too short: from rest to 6 deg/s at 50 deg/s²" in faults[2]
    assert "takes 3.5°" in faults[2]
    assert faults[3] == "step 'step 4': -1° is not within 0° to 360°; correct the case's angles"
    (late,) = rotation_faults(plan_of(THERE, samples=600), MOTION)
    assert "its samples last 60 s, in which 360° are turned" in late


def test_what_several_steps_have_wrong_alike_is_told_once() -> None:
    short = (replace(THERE, run_up_deg=2.0), replace(BACK, run_up_deg=2.0))
    (fault,) = rotation_faults(plan_of(*short, *short), MOTION)
    assert fault.startswith("step 'step 1' and 3 more steps: the run-up of 2° is too short")
    (fault,) = rotation_faults(plan_of(*short), MOTION)
    assert fault.startswith("step 'step 1' and 1 more step: ")


@pytest.mark.parametrize(
    ("turns", "stated"), [(None, "nothing is stated"), (0.5, "±0.5 turns are stated")]
)
def test_cables_that_do_not_stand_a_turn_are_refused(turns: float | None, stated: str) -> None:
    (fault,) = rotation_faults(plan_of(THERE), replace(MOTION, max_turns=turns))
    assert stated in fault
    assert "write 'max_turns: 1', or 'slip_ring: true'" in fault


def test_the_longest_way_to_stop_is_shorter_than_the_shortest_run_up() -> None:
    for rate_dps in (0.1, 6.0, 20.0):
        assert stopping_deg(rate_dps, 50.0) < least_run_up_deg(rate_dps, 50.0)


def test_what_is_played_back_is_not_turned() -> None:
    recorded = RotationRecorded()
    assert recorded.read_back() == ReadBack()
    stimulation = Stimulation(stage=recorded, interval_s=0.1)
    stimulation.reach(Step(samples=10, stimulus=BACK))
    stimulation.watch()
    stimulation.allow_pause(1000.0)
    stimulation.leave()
    assert stimulation.read_back() == ReadBack(demanded_rate_dps=-6.0)
    stimulation.reach(Step(samples=10, stimulus=Pointing(position_deg=90.0)))
    assert stimulation.read_back() == ReadBack(demanded_position_deg=90.0)
    stimulation.rest()


def test_a_slot_without_a_stage_says_what_to_give_it() -> None:
    with pytest.raises(AcquisitionError, match="no rotation stage; give it a 'table' with a 'shaft'"):
        Stimulation().reach(Step(samples=10, name="turn", stimulus=THERE))


def test_what_is_due_is_done_once_and_not_after_it_was_called_off() -> None:
    clock = VirtualClock()
    done = threading.Event()
    deadline = Deadline(clock, done.set, name="test")
    deadline.set(10.0)
    assert not deadline.call_off()
    clock.advance(20.0)
    assert not done.is_set()
    deadline.set(30.0)
    deadline.set(40.0)
    clock.advance(15.0)
    assert not done.wait(0.2)
    clock.advance(5.0)
    assert done.wait(10.0)
    deadline.set(100.0)
    assert deadline.call_off()
    assert not deadline.call_off()
