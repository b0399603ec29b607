"""A bench that is addressed as a real one, and the operator at its terminal."""

import os
import select
import subprocess
import sys
import time
from collections.abc import Iterator

import pytest

from .project import TINY, Project

STATION = """
name: bench-7
line_frequency: 50 Hz
instruments:
  meter:
    driver: agilent34401a
    resource: {resource}
    settings: {{nplc: 0.02, autozero: false}}
    accuracy: {{of_reading: 35 ppm, of_range: 5 ppm, noise: 3 uV}}
slots:
  A: {{source: meter}}
"""
QUICK = (
    TINY.replace("duration: 40 s", "duration: 8 s\n    gaps: longest_stretch")  # time is real here
    .replace("interval: 1 s", "interval: 100 ms")
    .replace("[1 s]", "[100 ms]")
)
OWN = """
def test_first(instrument): assert 2 < instrument.read("100 ms") < 3
def test_second(instrument, gyro_verify):
    gyro_verify("offset", instrument.read("100 ms"), unit="V", max="3 V")
"""


@pytest.fixture
def bench(project: Project) -> Iterator[Project]:
    """A project whose station addresses a stand-alone simulator as if it were a bench."""
    project.write("specs/quick.yaml", QUICK)
    command = [sys.executable, "-m", "gyrotest", "simulate", "meter", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as meter:
        assert meter.stdout is not None
        resource = meter.stdout.readline().strip()
        project.write("bench.yaml", STATION.format(resource=resource))
        yield project
        meter.terminate()


def test_a_simulator_addressed_as_a_bench_marks_the_run_simulated(bench: Project) -> None:
    ended = bench.pytest("--gyro-station", "bench.yaml", spec="quick.yaml")
    assert ended.code == 0, ended.out
    assert "1234: PASS (SIMULATED)" in ended
    assert bench.record()["simulated"] is True
    assert bench.record()["header"]["station"]["station"]["simulation"] is None


def test_one_worker_has_the_bench_for_the_spec_and_own_tests(bench: Project) -> None:
    pytest.importorskip("xdist")
    bench.write("test_own.py", OWN)
    ended = bench.pytest("-n", "2", "test_own.py", "--gyro-station", "bench.yaml", spec="quick.yaml")
    assert ended.code == 0, ended.out
    assert "3 passed" in ended
    assert [one["attempts"][0]["origin"] for one in bench.record()["items"]] == ["simulated"] * 2


@pytest.mark.skipif(sys.platform == "win32", reason="there is no pseudo-terminal")
@pytest.mark.parametrize(("answer", "code", "verdict"), [("", 0, "PASS"), ("stop", 1, "INCOMPLETE")])
def test_the_operator_is_asked_between_two_units(
    project: Project, answer: str, code: int, verdict: str
) -> None:
    project.write("specs/tiny.yaml", TINY)
    ours, its = os.openpty()
    process = subprocess.Popen(
        [
            *(sys.executable, "-m", "pytest", "-p", "no:cacheprovider"),
            *("--gyro-spec", "tiny.yaml", "--serial", "1234,1235"),
        ],
        cwd=project.path,
        stdin=its,
        stdout=its,
        stderr=its,
    )
    os.close(its)
    shown = _read_until(ours, "(or type 'stop'): ")
    assert "Put unit 1235 into slot a in place of 1234" in shown
    os.write(ours, f"{answer}\n".encode())
    shown += _read_until(ours, " in ", then_end=True)
    assert process.wait(timeout=60) == code, shown
    os.close(ours)
    assert project.record("1234")["verdict"] == "PASS"
    assert project.record("1235")["verdict"] == verdict


def _read_until(terminal: int, text: str, *, then_end: bool = False) -> str:
    shown, until_s = "", time.monotonic() + 60
    while time.monotonic() < until_s and (then_end or text not in shown):
        if not select.select([terminal], [], [], 1.0)[0]:
            continue
        try:
            shown += os.read(terminal, 4096).decode(errors="replace")
        except OSError:  # the other side is closed
            break
    assert text in shown, shown
    return shown
