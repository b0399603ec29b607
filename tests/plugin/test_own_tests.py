"""A user's own tests beside a spec."""

from .project import Project, short_spec


def test_own_tests_use_the_instrument_and_are_certified(project: Project) -> None:
    project.write("specs/short.yaml", short_spec(repeats=1))
    project.write(
        "test_own.py",
        """
        def test_noise(instrument, gyro_spec, gyro_station, gyro_serial, gyro_acquire, gyro_verify):
            assert gyro_serial == "1234"
            assert gyro_spec.model == "SHORT50"
            assert instrument.identity.model == "34401A"
            assert 2.0 < instrument.read() < 3.0
            samples = gyro_acquire(duration="20 s", interval="1 s")
            assert samples.values.shape == (20, 1)
            gyro_verify("quiet_noise", float(samples.values.std() * 1e3), unit="mV", max="5 mV")
            gyro_verify("offset", float(samples.values.mean()), unit="V", min="2.4 V", max="2.6 V")
        """,
    )
    ended = project.pytest("test_own.py")
    assert ended.code == 0, ended.out
    assert "2 passed" in ended
    record = project.record()
    assert record["verdict"] == "PASS"
    own = {one["name"]: one for one in record["results"] if one["case"] == "test_noise"}
    assert own["quiet_noise"]["verdict"] == "PASS"
    assert own["offset"]["unit"] == "V"


def test_a_value_of_an_own_test_out_of_limits_fails_the_run(project: Project) -> None:
    project.write("specs/short.yaml", short_spec(repeats=1))
    project.write(
        "test_own.py",
        """
        def test_two(gyro_verify):
            gyro_verify("first", 3.0, unit="mV", max="2 mV")
            gyro_verify("second", float("nan"), unit="mV", max="2 mV")
        """,
    )
    ended = project.pytest("test_own.py")
    assert ended.code == 1
    assert "first = 3" in ended
    record = project.record()
    own = {one["name"]: one["verdict"] for one in record["results"] if one["case"] == "test_two"}
    assert own == {"first": "FAIL", "second": "INCOMPLETE"}
    assert record["verdict"] == "INCOMPLETE"


def test_a_failed_assertion_of_a_verifying_test_forbids_a_pass(project: Project) -> None:
    project.write("specs/short.yaml", short_spec(repeats=1))
    project.write(
        "test_own.py",
        """
        def test_three(gyro_verify):
            gyro_verify("fine", 1.0, unit="mV", max="2 mV")
            assert False, "something else"
        """,
    )
    ended = project.pytest("test_own.py")
    assert ended.code == 1
    assert project.record()["verdict"] == "FAIL"


def test_hooks_are_called(project: Project) -> None:
    project.write("specs/short.yaml", short_spec(repeats=1))
    project.write(
        "conftest.py",
        """
        def pytest_gyro_acquired(item, attempt):
            print("ACQUIRED", item.name, attempt.recording.samples)
        def pytest_gyro_judged(item, attempt):
            print("JUDGED", attempt.outcome.value)
        def pytest_gyro_certified(record, certificate):
            print("CERTIFIED", record.verdict.value, certificate.suffix)
        """,
    )
    ended = project.pytest("-s")
    assert "ACQUIRED rest-1234-r1 240" in ended
    assert "JUDGED passed" in ended
    assert "CERTIFIED PASS .pdf" in ended


def test_an_exception_in_a_hook_never_ends_in_pass(project: Project) -> None:
    project.write("specs/short.yaml", short_spec(repeats=1))
    for hook in (
        "pytest_gyro_acquired(item, attempt)",
        "pytest_gyro_judged(item, attempt)",
        "pytest_runtest_teardown(item)",
    ):
        project.write("conftest.py", f"def {hook}:\n    raise RuntimeError('broken hook')\n")
        ended = project.pytest()
        assert ended.code != 0, hook
        assert project.record()["verdict"] == "INCOMPLETE", hook
