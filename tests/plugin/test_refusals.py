"""Bad input: a clear error of a line or two naming the place, exit code not 0, nothing lost."""

import os
import socket
import sys

import pytest

from .project import Ended, Project, Session, SessionEnded, short_spec


def _refused(ended: Ended, *texts: str) -> None:
    assert ended.code == 4, ended.out
    assert "Traceback" not in ended
    for text in texts:
        assert text in ended, ended.out


def _refused_session(ended: SessionEnded, *texts: str) -> None:
    assert (ended.code, ended.record) == (4, None), ended.out
    assert "Traceback" not in ended.out
    for text in texts:
        assert text in ended.out, ended.out


def test_serial_numbers_that_are_no_plain_names_or_break_the_pattern_are_refused(
    project: Project,
) -> None:
    serials = [
        "", "../1234", "12\n34", "1" * 300, "con", "12 34", "1..2", "ÄÖ12", "-1234", "1234,1234", None, "12",
    ]  # fmt: skip
    ended = project.sessions(*(Session(serial=one) for one in serials))
    for one in ended:
        _refused_session(one, "serial number")
    _refused_session(ended[-3], "'1234' is given twice")
    _refused_session(ended[-2], "needs the serial number", "--serial")
    _refused_session(ended[-1], "serial_pattern '[0-9]{4,8}'")


def test_senseless_options_are_refused_naming_what_was_tried(project: Project) -> None:
    senseless: tuple[tuple[tuple[str, ...], *tuple[str, ...]], ...] = (
        (("--gyro-spec", "short.yaml"), "2 times"),
        (("--gyro-meta", "order"), "KEY=VALUE"),
        (("--gyro-meta", "a=1", "--gyro-meta", "a=2"), "given twice"),
        (("--gyro-station", "simulatd"), "simulatd", "simulated"),
        (("--gyro-sim-scenario", "nominl"), "nominal"),
        (("--gyro-sim-seed", "-1"), "whole number"),
        (("--gyro-resume", "nowhere"), "nowhere", "is this a run's folder?"),
    )
    *ended, missing = project.sessions(
        *(Session(arguments=arguments) for arguments, *_ in senseless), Session(spec="shrt.yaml")
    )
    for one, (_, *texts) in zip(ended, senseless, strict=True):
        _refused_session(one, *texts)
    _refused_session(missing, "shrt.yaml", "short")


def test_a_faulty_spec_names_file_line_and_key(project: Project) -> None:
    faults = (
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
    )
    for number, (found, written, _) in enumerate(faults):
        assert found in short_spec()
        project.write(f"specs/faulty_{number}.yaml", short_spec().replace(found, written, 1))
    ended = project.sessions(*(Session(spec=f"faulty_{number}.yaml") for number in range(len(faults))))
    for number, (one, (_, written, named)) in enumerate(zip(ended, faults, strict=True)):
        text = (project.path / "specs" / f"faulty_{number}.yaml").read_text(encoding="utf-8")
        line = next(n for n, content in enumerate(text.splitlines(), 1) if written in content)
        _refused_session(one, f"faulty_{number}.yaml:{line}:", named)


def test_an_interval_that_the_meter_cannot_reach_is_an_error_before_sampling(project: Project) -> None:
    project.write(
        "specs/short.yaml",
        short_spec().replace("interval: 1 s", "interval: 0.1 s").replace("4 min", "1 min"),
    )
    ended = project.pytest()
    assert ended.code == 1
    assert "0.1 s" in ended
    assert project.record()["verdict"] == "INCOMPLETE"


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
