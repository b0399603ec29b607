"""Rate-table controllers as rotation stages, over real sockets and pseudo-terminals."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from gyrotest.acquisition.rotating import StageDrive
from gyrotest.errors import GyrotestError, InstrumentError
from gyrotest.ports import RateTable
from gyrotest.records.plan import Pointing, Rotating
from gyrotest.records.station import Motion
from gyrotest.simulation.server import has_pty
from gyrotest.simulation.table import TableFaults
from gyrotest.units import Quantity
from tests.instruments.table_bench import Served, served

needs_pty = pytest.mark.skipif(not has_pty(), reason="this platform has no pseudo-terminals")
WAYS = [
    ("plain", False),
    pytest.param(("aerosmith", True), marks=needs_pty),
]
# One turn is enough for 0° to 360° and back.
MOTION = Motion(
    max_rate=Quantity(20.0, "deg/s"), max_acceleration=Quantity(50.0, "deg/s/s"), max_turns=1.0
)
THERE = Rotating(rate_dps=6.0, run_up_deg=10.0)
BACK = Rotating(rate_dps=-6.0, run_up_deg=10.0)
SAMPLED_S = THERE.sampled_deg / 6.0


class Turned:
    """A stage driven over its controller, and where it was all the while."""

    def __init__(self, bench: Served, table: RateTable) -> None:
        self.bench = bench
        self.table = table
        table.open()
        self.drive = StageDrive(table, clock=bench.clock, motion=MOTION, name="stage")
        self.angles_deg: list[float] = []
        bench.clock.subscribe(self._look)

    def _look(self, now_s: float) -> None:
        self.angles_deg += bench_angles(self.bench, np.array([now_s]))

    @property
    def at_rest(self) -> bool:
        return abs(self.bench.table.read_rate_dps()) < 0.01

    def sample(self, duration_s: float = SAMPLED_S, *, block_s: float = 1.0) -> None:
        begun_s = self.bench.clock.now_s()
        for due_s in (*np.arange(block_s, duration_s, block_s), duration_s):
            self.bench.clock.sleep_until(begun_s + due_s)
            self.drive.watch()


def bench_angles(bench: Served, times_s: np.ndarray[tuple[int], np.dtype[np.float64]]) -> list[float]:
    return [float(one) for one in bench.table.angle_deg(times_s)]


@contextmanager
def stage(
    way: tuple[str, bool], *, faults: TableFaults | None = None, at_deg: float = 0.0
) -> Iterator[Turned]:
    kind, pty = way
    with served(kind, pty=pty, faults=faults) as bench:
        bench.table.move_to(at_deg)
        bench.wait(60.0)
        table = bench.driver(MOTION)
        try:
            yield Turned(bench, table)
        finally:
            table.close()


@pytest.mark.parametrize("way", WAYS)
def test_it_turns_there_and_back_within_one_turn_of_its_cables(way: tuple[str, bool]) -> None:
    with stage(way) as turned:
        for rotating in (THERE, BACK):
            turned.drive.reach(rotating, sampled_s=SAMPLED_S)
            turned.sample()
            turned.drive.leave()
            found = turned.drive.read_back()
            assert found.rate_dps == pytest.approx(rotating.rate_dps, abs=0.01)
        turned.drive.rest()
        assert turned.at_rest
        assert turned.angles_deg[-1] == pytest.approx(0.0, abs=0.3)
        assert -0.5 <= min(turned.angles_deg) <= 0.5 < 340.0 < max(turned.angles_deg) <= 360.5


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("at_deg", [-0.4, 150.0])
def test_one_that_stands_elsewhere_goes_to_0_first_and_to_360_without_a_refusal(
    way: tuple[str, bool], at_deg: float
) -> None:
    with stage(way, at_deg=at_deg) as turned:
        for angle_deg in (0.0, 360.0, 10.0):
            turned.drive.reach(Pointing(position_deg=angle_deg, settle_s=1.0), sampled_s=1.0)
            assert turned.drive.read_back().position_deg == pytest.approx(angle_deg, abs=0.1)
            assert turned.angles_deg[-1] == pytest.approx(angle_deg, abs=0.1)


def test_a_controller_that_answers_every_command_is_a_stage_too() -> None:
    quick = Rotating(rate_dps=18.0, run_up_deg=15.0)
    with stage(("status", False)) as turned:
        turned.drive.reach(quick, sampled_s=330.0 / 18.0)
        turned.sample(330.0 / 18.0, block_s=6.0)
        turned.drive.leave()
        assert 340.0 < max(turned.angles_deg) <= 360.0
        assert turned.drive.read_back().rate_dps == pytest.approx(18.0, abs=0.01)


@pytest.mark.parametrize("way", WAYS)
def test_a_late_source_a_slow_stage_and_a_refusal_leave_it_at_rest(way: tuple[str, bool]) -> None:
    with stage(way) as turned:
        turned.drive.reach(THERE, sampled_s=SAMPLED_S)
        turned.sample(SAMPLED_S)
        with pytest.raises(InstrumentError, match="stopped before it came to the end of its turn"):
            turned.sample(5.0, block_s=0.1)
        turned.bench.wait(2.0)
        assert turned.at_rest
        assert turned.angles_deg[-1] < 360.0
    with stage(way, faults=TableFaults(reaches=0.6)) as slow:
        with pytest.raises(InstrumentError, match=r"6 deg/s is demanded, 3\.\d+ deg/s read back"):
            slow.drive.reach(THERE, sampled_s=SAMPLED_S)
        slow.bench.wait(2.0)
        assert slow.at_rest
    with (
        stage(way, faults=TableFaults(refuses=True)) as refusing,
        pytest.raises(InstrumentError, match="refused"),
    ):
        refusing.drive.reach(THERE, sampled_s=SAMPLED_S)


def test_an_open_interlock_is_told_of_on_the_way() -> None:
    with stage(("plain", False)) as turned:
        turned.drive.reach(THERE, sampled_s=SAMPLED_S)
        turned.bench.table.faults = TableFaults(interlock_opens_s=turned.bench.clock.now_s() + 20.0)
        with pytest.raises(InstrumentError, match="interlock fault"):
            turned.sample()
        turned.drive.rest()
        turned.bench.wait(1.0)
        assert turned.at_rest


def test_after_a_fault_it_is_put_down_and_goes_on_from_where_it_stands() -> None:
    with stage(("plain", False)) as turned:
        turned.drive.reach(THERE, sampled_s=SAMPLED_S)
        turned.sample(30.0)
        _fail(turned)
        turned.bench.wait(1.0)
        assert turned.at_rest
        stood_deg = turned.angles_deg[-1]
        assert 180.0 < stood_deg < 200.0
        turned.drive.turning.put_down()
        turned.drive.turning.take_up()
        turned.drive.reach(THERE, sampled_s=SAMPLED_S)
        turned.sample()
        turned.drive.leave()
        assert min(turned.angles_deg) >= -0.5
        assert max(turned.angles_deg) <= 360.5


def _fail(turned: Turned) -> None:
    try:
        raise GyrotestError("the source failed")
    except GyrotestError:
        turned.drive.rest()


@needs_pty
def test_an_aerosmith_that_tells_its_rate_by_two_positions_needs_way_for_it() -> None:
    with (
        stage(("aerosmith", True)) as turned,
        pytest.raises(
            InstrumentError, match=r"a controller that takes 1 s to tell the rate; lengthen it"
        ),
    ):
        turned.drive.reach(Rotating(rate_dps=6.0, run_up_deg=4.0), sampled_s=352.0 / 6.0)
