"""A table is never left turning: what happens when the process that turned it is killed."""

import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import closing

import pytest

from gyrotest.errors import InstrumentError
from gyrotest.instruments.acutrol3000 import Acutrol3000, Acutrol3000Settings
from gyrotest.instruments.aerosmith import Aerosmith, AerosmithSettings
from gyrotest.instruments.guard import Guard, Orders, stop_table
from gyrotest.instruments.transport.serial_port import open_commands_only
from gyrotest.ports import RateTable
from gyrotest.simulation.server import has_pty
from tests.instruments.cut import Cut
from tests.instruments.table_bench import Served, motion, served

needs_pty = pytest.mark.skipif(not has_pty(), reason="this platform has no pseudo-terminals")
# Long enough that a test which waits for it is noticed.
MOST_S = 60.0

CHILD = """
import sys, threading
from gyrotest.clock import RealClock
from gyrotest.instruments.acutrol3000 import Acutrol3000, Acutrol3000Settings, Dialect
from gyrotest.instruments.aerosmith import Aerosmith, AerosmithSettings
from tests.instruments.table_bench import motion
kind, address = sys.argv[1:]
if kind == "aerosmith":
    table = Aerosmith(address, AerosmithSettings(), clock=RealClock(), motion=motion())
else:
    settings = Acutrol3000Settings(dialect=Dialect(kind))
    table = Acutrol3000(address, settings, clock=RealClock(), motion=motion())
table.open()
table.enable()
table.set_rate(50.0)
print("turning", flush=True)
threading.Event().wait()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="killed by a signal")
@pytest.mark.parametrize(
    ("kind", "pty"),
    [
        ("plain", False),
        ("status", False),
        pytest.param("plain", True, marks=needs_pty),
        pytest.param("aerosmith", True, marks=needs_pty),
    ],
)
def test_a_killed_run_leaves_the_table_at_rest(kind: str, pty: bool) -> None:
    with (
        served(kind, pty=pty) as bench,
        subprocess.Popen(
            [sys.executable, "-c", CHILD, kind, bench.address], stdout=subprocess.PIPE
        ) as child,
    ):
        assert child.stdout is not None
        assert child.stdout.readline() == b"turning\n"
        bench.wait(2.0)
        assert bench.table.read_rate_dps() == pytest.approx(50.0, abs=0.01)
        os.kill(child.pid, signal.SIGKILL)
        assert bench.table.wait_until(lambda: bench.table.demanded_dps == 0.0, MOST_S)
        bench.wait(2.0)
        assert bench.table.read_rate_dps() == pytest.approx(0.0, abs=0.01)


def turning(bench: Served, cut: Cut) -> RateTable:
    table: RateTable
    if bench.kind == "aerosmith":
        table = Aerosmith(
            bench.address,
            AerosmithSettings(),
            clock=bench.clock,
            motion=motion(),
            connect=cut.connect,
        )
    else:
        table = Acutrol3000(
            bench.address,
            Acutrol3000Settings(),
            clock=bench.clock,
            motion=motion(),
            connect=cut.connect,
        )
    table.open()
    table.enable()
    table.set_rate(50.0)
    bench.wait(2.0)
    return table


KINDS = ["plain", pytest.param("aerosmith", marks=needs_pty)]
LOST = r"connection lost at .* see that the table is at rest"


@pytest.mark.parametrize("kind", KINDS)
def test_a_table_whose_connection_broke_is_stopped_over_a_new_one(kind: str) -> None:
    cut = Cut(open_commands_only)
    with served(kind, pty=kind == "aerosmith") as bench, closing(turning(bench, cut)) as table:
        cut.cut(later=False)
        with pytest.raises(InstrumentError, match=LOST):
            table.rate_dps()
        table.stop()
        assert bench.table.demanded_dps == 0.0
        bench.wait(2.0)
        assert table.rate_dps() == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("kind", KINDS)
def test_a_table_that_this_process_cannot_reach_any_more_is_stopped_by_the_guard(kind: str) -> None:
    cut = Cut(open_commands_only)
    with served(kind, pty=kind == "aerosmith") as bench, closing(turning(bench, cut)) as table:
        cut.cut(later=True)
        with pytest.raises(InstrumentError, match=LOST):
            table.rate_dps()
        table.stop()
        assert bench.table.wait_until(lambda: bench.table.demanded_dps == 0.0, MOST_S)


def test_a_guard_that_hears_that_all_is_well_commands_nothing() -> None:
    with served("plain") as bench:
        host, port = bench.address.split("::")[1:3]
        bench.table.set_rate(5.0)
        guard = Guard(Orders(commands=(":Demand:Rate 1,0\n",), host=host, port=int(port)))
        guard.start()
        guard.start()
        guard.release()
        guard.release()
        assert bench.table.demanded_dps == 5.0


def test_a_simulated_table_that_is_gone_with_its_run_is_given_up_at_once() -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    begun_s = time.monotonic()
    assert not stop_table(Orders(commands=("STO\r",), host="127.0.0.1", port=port))
    assert not stop_table(Orders(commands=("STO\r",), device="/dev/pts/no-such-terminal"))
    assert time.monotonic() - begun_s < MOST_S


def test_the_guard_needs_the_standard_library_only() -> None:
    listed = subprocess.run(
        [
            sys.executable,
            "-P",
            "-c",
            "import sys, gyrotest.instruments.guard; print(*sys.modules)",
        ],
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()
    foreign = {name.partition(".")[0] for name in listed} & {
        "numpy",
        "pint",
        "pyvisa",
        "pydantic",
        "serial",
    }
    assert not foreign
    assert {name for name in listed if name.startswith("gyrotest")} == {
        "gyrotest",
        "gyrotest.instruments",
        "gyrotest.instruments.guard",
    }
