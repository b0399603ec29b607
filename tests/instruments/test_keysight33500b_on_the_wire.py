"""The drive of a vibration table over a real socket and a pseudo-terminal, and that it is never left on."""

import os
import signal
import subprocess
import sys
from contextlib import closing

import numpy as np
import pytest

from gyrotest.errors import InstrumentError
from gyrotest.instruments.transport.visa import open_channel
from gyrotest.simulation.server import has_pty
from gyrotest.units import Quantity
from tests.instruments.cut import Cut
from tests.instruments.exciter_bench import Served, served

needs_pty = pytest.mark.skipif(not has_pty(), reason="this platform has no pseudo-terminals")
WAYS = ["tcp", pytest.param("pty", marks=needs_pty)]
# Long enough that a test which waits for it is noticed.
MOST_S = 60.0

CHILD = """
import sys, threading
from gyrotest.clock import RealClock
from gyrotest.instruments.keysight33500b import Keysight33500B
from tests.instruments.exciter_bench import settings
drive = Keysight33500B(sys.argv[1], settings(), clock=RealClock())
drive.open()
drive.random(rms_dps=10.0, low_hz=5.0, high_hz=100.0)
print("moving", flush=True)
threading.Event().wait()
"""


def rms_v(bench: Served, duration_s: float = 20.0) -> float:
    """What is given in the time that passes now."""
    begun_s = bench.clock.now_s()
    bench.clock.advance(duration_s)
    volts = bench.peer.drive_v(0, int(duration_s * 1e3), origin_s=begun_s, interval_s=1e-3)
    return float(np.sqrt(np.mean(volts**2)))


@pytest.mark.parametrize("way", WAYS)
def test_noise_sine_and_sweep_have_the_rms_that_was_asked_for(way: str) -> None:
    with (
        served(way, figures={"gain_error": "0 %"}) as bench,
        closing(bench.driver()) as drive,
    ):
        assert drive.open().simulated
        drive.random(rms_dps=10.0, low_hz=5.0, high_hz=100.0)
        drive.check()
        assert rms_v(bench) == pytest.approx(0.5 * np.sqrt(100.0 / 95.0), rel=0.05)
        drive.sine(rms_dps=10.0, frequency_hz=7.0)
        drive.check()
        assert rms_v(bench) == pytest.approx(0.5, rel=1e-3)
        drive.sweep(rms_dps=10.0, low_hz=7.0, high_hz=90.0, duration_s=20.0)
        drive.check()
        assert rms_v(bench) == pytest.approx(0.5, rel=1e-2)
        drive.stop()
        assert rms_v(bench) == 0.0


def test_a_load_of_50_ohm_gets_the_same_voltage_as_an_open_input() -> None:
    with (
        served(figures={"gain_error": "0 %"}, load="50 ohm") as bench,
        closing(bench.driver(load="50 ohm")) as drive,
    ):
        drive.open()
        drive.sine(rms_dps=10.0, frequency_hz=7.0)
        assert rms_v(bench) == pytest.approx(0.5, rel=1e-3)


def test_an_output_that_goes_off_by_itself_is_told_by_the_check() -> None:
    with (
        served(scenario="exciter-silent") as bench,
        closing(bench.driver()) as drive,
    ):
        drive.open()
        drive.random(rms_dps=10.0, low_hz=5.0, high_hz=100.0)
        drive.check()
        bench.clock.advance(50.0)
        with pytest.raises(InstrumentError, match="the output has gone off by itself"):
            drive.check()


def test_a_level_that_the_generator_does_not_give_into_its_load_is_refused() -> None:
    with (
        served() as bench,
        closing(
            bench.driver(
                load="50 ohm", max_voltage=Quantity(50.0, "V"), max_rate=Quantity(200.0, "deg/s")
            )
        ) as drive,
    ):
        drive.open()
        with pytest.raises(
            InstrumentError, match=r"needs 9\.9 V peak, the generator gives 0\.0005 V to 5 V"
        ):
            drive.sine(rms_dps=140.0, frequency_hz=7.0)


@pytest.mark.parametrize("later", [False, True])
def test_an_output_whose_connection_broke_is_switched_off_over_a_new_one_or_by_the_guard(
    later: bool,
) -> None:
    cut = Cut(open_channel)
    with served() as bench, closing(bench.driver(connect=cut.connect)) as drive:
        drive.open()
        drive.sine(rms_dps=10.0, frequency_hz=7.0)
        cut.cut(later=later)
        with pytest.raises(InstrumentError, match="connection lost"):
            drive.check()
        drive.stop()
        assert bench.went_off.wait(MOST_S)
        assert not bench.wave.on


def test_a_drive_that_cannot_be_reached_any_more_is_left_without_an_exception() -> None:
    with served(scenario="exciter-lost") as bench, closing(bench.driver()) as drive:
        drive.open()
        drive.sine(rms_dps=10.0, frequency_hz=7.0)
        bench.clock.advance(50.0)
        with pytest.raises(InstrumentError):
            drive.check()
        drive.stop()
        drive.close()


@pytest.mark.skipif(sys.platform == "win32", reason="killed by a signal")
@pytest.mark.parametrize("way", WAYS)
def test_a_killed_run_leaves_the_vibration_table_at_rest(way: str) -> None:
    with (
        served(way) as bench,
        subprocess.Popen([sys.executable, "-c", CHILD, bench.address], stdout=subprocess.PIPE) as child,
    ):
        assert child.stdout is not None
        assert child.stdout.readline() == b"moving\n"
        assert bench.wave.on
        os.kill(child.pid, signal.SIGKILL)
        assert bench.went_off.wait(MOST_S)
        assert not bench.wave.on
