"""Reruns and workers: attempts are kept, and nobody tests until it passes."""

import pytest

from .project import Project, short_spec

pytest.importorskip("xdist")
pytest.importorskip("pytest_rerunfailures")


def test_a_rerun_does_not_replace_a_failed_acquisition(project: Project) -> None:
    project.write("specs/short.yaml", short_spec(repeats=1, bias_max="-1.9 deg/s"))
    ended = project.pytest("--reruns", "2")
    assert ended.code == 1
    assert "2 rerun" in ended
    (item,) = project.record()["items"]
    assert [one["outcome"] for one in item["attempts"]] == ["failed"]


def test_a_declared_retest_may_replace_it_and_is_kept(project: Project) -> None:
    text = short_spec(repeats=1, bias_max="-1.9 deg/s").replace(
        "repeats: 1", "repeats: 1\n    retests: 1"
    )
    project.write("specs/short.yaml", text)
    ended = project.pytest("--reruns", "2")
    assert ended.code == 1
    (item,) = project.record()["items"]
    assert [one["outcome"] for one in item["attempts"]] == ["failed", "failed"]


def test_a_rerun_replaces_a_bench_error(project: Project) -> None:
    project.write("specs/short.yaml", short_spec(repeats=1))
    project.write(
        "conftest.py",
        """
        import pytest
        from gyrotest.errors import InstrumentError
        tries = []

        @pytest.fixture(autouse=True)
        def loose_cable(gyro_session):
            bench = gyro_session.bench()
            real = bench.source
            def source(slot, serial_number):
                tries.append(slot)
                bench.source = real
                raise InstrumentError("the cable is loose")
            if not tries:
                bench.source = source
        """,
    )
    ended = project.pytest("--reruns", "1")
    assert ended.code == 0, ended.out
    (item,) = project.record()["items"]
    assert [one["outcome"] for one in item["attempts"]] == ["error", "passed"]
    assert project.record()["verdict"] == "PASS"


def test_workers_do_the_items_and_the_controller_certifies(project: Project) -> None:
    ended = project.pytest("-n", "2", "--gyro-yes", serial="1234,1235")
    assert ended.code == 0, ended.out
    assert "6 passed" in ended
    for serial in ("1234", "1235"):
        assert project.record(serial)["verdict"] == "PASS"
        assert len(project.certificates(serial)) == 1


def test_workers_give_the_values_of_a_single_process(project: Project) -> None:
    project.pytest("-n", "2")
    distributed = [one["value"] for one in project.record()["results"]]
    project.pytest()
    assert [one["value"] for one in project.record()["results"]] == distributed
