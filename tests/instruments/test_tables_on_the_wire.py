"""Rate tables over real sockets and pseudo-terminals, against the simulated table."""

from contextlib import closing

import pytest

from gyrotest.errors import InstrumentError, InstrumentProtocolError
from gyrotest.instruments.acutrol3000 import Acutrol3000, Acutrol3000Settings
from gyrotest.ports import RateTable
from gyrotest.simulation.server import has_pty
from gyrotest.simulation.table import TableFaults
from tests.instruments.table_bench import Served, motion, served

needs_pty = pytest.mark.skipif(not has_pty(), reason="this platform has no pseudo-terminals")
KINDS = ["plain", "status", pytest.param("aerosmith", marks=needs_pty)]
WAYS = [
    ("plain", False),
    ("status", False),
    pytest.param(("plain", True), marks=needs_pty),
    pytest.param(("aerosmith", True), marks=needs_pty),
]


def interrupted(bench: Served, table: RateTable) -> None:
    table.open()
    table.enable()
    table.set_rate(100.0)
    bench.wait(2.0)
    raise KeyboardInterrupt


def watched(bench: Served, table: RateTable, duration_s: float) -> None:
    for _ in range(int(duration_s)):
        bench.wait(1.0)
        table.position_deg()


@pytest.mark.parametrize("way", WAYS)
def test_a_table_reaches_its_rate_is_read_back_and_comes_to_rest(way: tuple[str, bool]) -> None:
    kind, pty = way
    with served(kind, pty=pty) as bench, closing(bench.driver()) as table:
        identity = table.open()
        table.enable()
        table.set_rate(-80.0)
        bench.wait(3.0)
        assert table.rate_dps() == pytest.approx(-80.0, abs=0.01)
        assert table.position_deg() == pytest.approx(-80.0 * 3.0 + 32.0, abs=90.0)
        table.stop()
        bench.wait(3.0)
        assert table.rate_dps() == pytest.approx(0.0, abs=0.01)
    assert identity.simulated


@pytest.mark.parametrize("kind", KINDS)
def test_the_acceleration_is_the_station_s(kind: str) -> None:
    with served(kind, pty=kind == "aerosmith") as bench, closing(bench.driver()) as table:
        table.open()
        table.enable()
        table.set_rate(100.0)
        bench.wait(0.5)
        assert bench.table.read_rate_dps() == pytest.approx(50.0, abs=0.5)
        assert bench.table.acceleration_limit_dps2 == 100.0


@pytest.mark.parametrize("kind", KINDS)
def test_an_error_while_it_turns_leaves_it_at_rest_with_the_drive_off(kind: str) -> None:
    with served(kind, pty=kind == "aerosmith") as bench:
        with pytest.raises(KeyboardInterrupt), closing(bench.driver()) as table:
            interrupted(bench, table)
        assert bench.table.demanded_dps == 0.0
        assert bench.table.read_rate_dps() == pytest.approx(0.0, abs=0.2)
        # The drive is off: a rate is refused until it is switched on again.
        with closing(bench.driver()) as again:
            again.open()
            if kind != "aerosmith":
                with pytest.raises(InstrumentProtocolError, match="refused"):
                    again.set_rate(10.0)


@pytest.mark.parametrize("kind", KINDS)
def test_closing_twice_and_stopping_without_a_connection_do_nothing(kind: str) -> None:
    with served(kind, pty=kind == "aerosmith") as bench:
        table = bench.driver()
        table.stop()
        table.close()
        table.open()
        table.close()
        table.close()


@pytest.mark.parametrize("kind", KINDS)
def test_a_rate_beyond_the_motion_is_refused_before_anything_is_sent(kind: str) -> None:
    with served(kind, pty=kind == "aerosmith") as bench, closing(bench.driver()) as table:
        table.open()
        table.enable()
        with pytest.raises(InstrumentError, match=r"201 deg/s is asked for, .* allows 200 deg/s"):
            table.set_rate(201.0)
        assert bench.table.demanded_dps == 0.0


@pytest.mark.parametrize("kind", KINDS)
def test_cables_that_wind_up_stop_the_table(kind: str) -> None:
    limits = motion(slip_ring=False, max_turns=1.0)
    with served(kind, pty=kind == "aerosmith") as bench, closing(bench.driver(limits)) as table:
        table.open()
        table.enable()
        table.set_rate(60.0)
        with pytest.raises(InstrumentError, match=r"it has turned by 1\.\d+ turns, .* allow ±1"):
            watched(bench, table, 20.0)
        assert bench.table.demanded_dps == 0.0


@pytest.mark.parametrize("kind", ["plain", "status"])
def test_an_interlock_that_opens_is_said_and_the_table_rests(kind: str) -> None:
    faults = TableFaults(interlock_opens_s=5.0)
    with served(kind, faults=faults) as bench, closing(bench.driver()) as table:
        table.open()
        table.enable()
        table.set_rate(50.0)
        bench.wait(4.0)
        assert table.rate_dps() == pytest.approx(50.0, abs=0.01)
        bench.wait(2.0)
        with pytest.raises(InstrumentError, match=r"interlock fault of axis 1 .* close its doors"):
            table.rate_dps()
        with pytest.raises(InstrumentError, match="interlock fault"):
            table.set_rate(10.0)
        assert bench.table.read_rate_dps() == pytest.approx(0.0, abs=0.01)


@needs_pty
def test_an_aerosmith_whose_interlock_opens_refuses_the_next_rate() -> None:
    faults = TableFaults(interlock_opens_s=2.0)
    with served("aerosmith", pty=True, faults=faults) as bench, closing(bench.driver()) as table:
        table.open()
        table.enable()
        bench.wait(3.0)
        with pytest.raises(InstrumentProtocolError, match=r"answers '\?' to JOG50: refused"):
            table.set_rate(50.0)


@pytest.mark.parametrize("kind", KINDS)
def test_a_table_that_refuses_is_said_when_it_is_switched_on(kind: str) -> None:
    faults = TableFaults(refuses=True)
    with (
        served(kind, pty=kind == "aerosmith", faults=faults) as bench,
        closing(bench.driver()) as table,
    ):
        table.open()
        with pytest.raises(InstrumentProtocolError, match="refused"):
            table.enable()


@pytest.mark.parametrize("kind", KINDS)
def test_it_goes_to_an_angle_by_the_shorter_way(kind: str) -> None:
    with served(kind, pty=kind == "aerosmith") as bench, closing(bench.driver()) as table:
        table.open()
        table.enable()
        table.move_to(350.0)
        bench.wait(10.0)
        assert table.position_deg() == pytest.approx(-10.0, abs=0.01)


def test_a_dialect_that_is_not_the_interface_s_is_said() -> None:
    with served("status") as bench:
        table = Acutrol3000(
            bench.address, Acutrol3000Settings(), clock=bench.clock, motion=motion(), io_timeout_s=0.2
        )
        with closing(table), pytest.raises(InstrumentError, match="settings of the line right"):
            table.open()


def test_another_table_at_the_address_is_refused() -> None:
    with served("plain") as bench:
        table = Acutrol3000(
            bench.address,
            Acutrol3000Settings(),
            clock=bench.clock,
            motion=motion(),
            serial_number="4711",
        )
        with closing(table), pytest.raises(InstrumentError, match="SIM00001, expected 4711"):
            table.open()
