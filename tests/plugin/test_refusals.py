"""Bad input: a clear error of a line or two naming the place, exit code not 0, nothing lost."""

import os
import socket
import sys
from pathlib import Path

import pytest

from .project import Ended, Project, short_spec


def _refused(ended: Ended, *texts: str) -> None:
    assert ended.code == 4, ended.out
    assert "Traceback" not in ended
    for text in texts:
        assert text in ended, ended.out


@pytest.mark.parametrize(
    "serial",
    ["", "../1234", "12\n34", "1" * 300, "con", "12 34", "1..2", "ÄÖ12"],
    ids=["empty", "path", "newline", "long", "device", "blank", "dots", "umlaut"],
)
def test_a_serial_number_that_is_no_plain_name_is_refused(project: Project, serial: str) -> None:
    _refused(project.pytest(serial=serial), "serial number")
    assert not (project.path / "reports").exists()


def test_a_serial_number_with_a_leading_dash_is_refused(project: Project) -> None:
    _refused(project.pytest("--serial=-1234", serial=None), "serial number '-1234'")


def test_a_missing_serial_number_is_refused(project: Project) -> None:
    _refused(project.pytest(serial=None), "needs the serial number", "--serial")


def test_a_serial_number_that_breaks_the_pattern_is_refused(project: Project) -> None:
    _refused(project.pytest(serial="12"), "serial_pattern '[0-9]{4,8}'")


def test_a_missing_spec_names_what_was_tried(project: Project) -> None:
    _refused(project.pytest(spec="shrt.yaml"), "shrt.yaml", "short")


def test_two_specs_are_refused(project: Project) -> None:
    _refused(project.pytest("--gyro-spec", "short.yaml"), "2 times")


@pytest.mark.parametrize(
    ("found", "written", "named"),
    [
        ("duration: 4 min", "duration: -4 min", "duration"),
        ("duration: 4 min", "duration: 0 s", "duration"),
        ("interval: 1 s", "interval: 1", "interval"),
        ("interval: 1 s", "interval: 3,5 s", "interval"),
        ("repeats: 2", "repeat: 2", "repeats"),
        ("smoothing: [1 s, 10 s]", "smoothing: [1 s, 2.5 s]", "smoothing"),
        ("min: -2 deg/s, max: 2 deg/s", "min: 3 deg/s, max: 2 deg/s", "bias"),
        ("bias_stability_1s:", "bias_stability_7s:", "bias_stability_1s"),
        ("bias_stability_1s:", "bias_instability:", "allan_minimum"),
        ("max: 200 deg/h}", "max: 200 V}", "200 V"),
    ],
)
def test_a_faulty_spec_names_file_line_and_key(
    project: Project, found: str, written: str, named: str
) -> None:
    text = short_spec()
    assert found in text
    faulty = text.replace(found, written, 1)
    project.write("specs/short.yaml", faulty)
    line = next(
        n for n, one in enumerate(faulty.splitlines(), 1) if written.split("\n", maxsplit=1)[0] in one
    )
    _refused(project.pytest(), f"short.yaml:{line}:", named)


def test_an_interval_that_the_meter_cannot_reach_is_an_error_before_sampling(project: Project) -> None:
    project.write(
        "specs/short.yaml",
        short_spec().replace("interval: 1 s", "interval: 0.1 s").replace("4 min", "1 min"),
    )
    ended = project.pytest()
    assert ended.code == 1
    assert "0.1 s" in ended
    assert project.record()["verdict"] == "INCOMPLETE"


def test_an_unknown_station_is_refused(project: Project) -> None:
    _refused(project.pytest("--gyro-station", "simulatd"), "simulatd", "simulated")


def test_an_unknown_scenario_is_refused(project: Project) -> None:
    ended = project.pytest("--gyro-sim-scenario", "nominl")
    assert ended.code != 0
    assert "nominal" in ended


STATION = """
name: bench-7
line_frequency: 50 Hz
instruments:
  meter:
    driver: agilent34401a
    resource: {resource}
    accuracy: {{of_reading: 35 ppm, of_range: 5 ppm, noise: 3 uV}}
    {calibration}
slots:
  A: {{source: meter}}
"""


def _station(project: Project, resource: str, calibration: str = "asset: DMM-7") -> None:
    project.write("bench.yaml", STATION.format(resource=resource, calibration=calibration))


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def test_an_unreachable_address_is_an_error_of_every_item(project: Project) -> None:
    _station(project, f"TCPIP::127.0.0.1::{_free_port()}::SOCKET")
    ended = project.pytest("--gyro-station", "bench.yaml")
    assert ended.code == 1
    assert "2 errors" in ended
    assert "Traceback" not in ended
    assert project.record()["verdict"] == "INCOMPLETE"
    assert project.record()["simulated"] is False


def test_an_expired_calibration_is_refused_unless_the_station_allows_it(project: Project) -> None:
    calibration = "calibration: {certificate: K-1, date: 2020-01-01, due: 2021-01-01}"
    resource = f"TCPIP::127.0.0.1::{_free_port()}::SOCKET"
    _station(project, resource, calibration)
    _refused(project.pytest("--gyro-station", "bench.yaml"), "K-1 was due on 2021-01-01")
    path = project.path / "bench.yaml"
    path.write_text(path.read_text() + "allow_expired_calibration: true\n")
    project.pytest("--gyro-station", "bench.yaml")
    (deviation,) = project.record()["header"]["deviations"]
    assert "out of calibration" in deviation


def test_a_bench_owned_by_another_run_is_refused_naming_the_owner(project: Project) -> None:
    from gyrotest.runner.locks import ResourceLocks

    resource = f"TCPIP::127.0.0.1::{_free_port()}::SOCKET"
    _station(project, resource)
    locks = ResourceLocks("the test of 9999")
    locks.acquire([resource])
    try:
        _refused(project.pytest("--gyro-station", "bench.yaml"), "already owned by the test of 9999")
    finally:
        locks.release()


def test_simulation_options_on_a_real_bench_are_refused(project: Project) -> None:
    _station(project, f"TCPIP::127.0.0.1::{_free_port()}::SOCKET")
    ended = project.pytest("--gyro-station", "bench.yaml", "--gyro-sim-seed", "3")
    assert ended.code != 0
    assert "is no simulated bench" in ended


@pytest.mark.skipif(sys.platform == "win32" or os.geteuid() == 0, reason="root may write anywhere")
def test_an_output_folder_that_cannot_be_written_is_refused(project: Project) -> None:
    folder = project.path / "locked"
    folder.mkdir(mode=0o500)
    _refused(project.pytest("--gyro-out", str(folder / "out")), "cannot be written")


def test_an_output_folder_that_is_a_file_is_refused(project: Project) -> None:
    project.write("taken", "a file\n")
    _refused(project.pytest("--gyro-out", "taken"), "taken", "--gyro-out")
    assert (project.path / "taken").read_text() == "a file\n"


def test_without_pango_the_run_is_refused_before_it_starts(project: Project) -> None:
    project.write(
        "conftest.py",
        """
        import ctypes, sys

        class NoPango:
            def find_spec(self, name, path=None, target=None):
                if name == "weasyprint":
                    raise OSError("cannot load library 'libpango-1.0-0'")

        def load(name, *arguments, loader=ctypes.CDLL):
            if name and "pango" in str(name):
                raise OSError(f"cannot load library {name!r}")
            return loader(name, *arguments)

        sys.meta_path.insert(0, NoPango())
        ctypes.CDLL = load
        """,
    )
    _refused(project.pytest(), "Pango")
    assert not (project.path / "reports").exists() or not project.runs()


def test_meta_without_a_value_is_refused(project: Project) -> None:
    _refused(project.pytest("--gyro-meta", "order"), "KEY=VALUE")


def test_nothing_of_an_earlier_run_is_touched(project: Project) -> None:
    project.pytest("-k", "r1")
    (run,) = project.runs()

    def content(folder: Path) -> dict[str, bytes]:
        return {str(path): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}

    before = content(run)
    project.pytest("-k", "r1")
    assert content(run) == before
