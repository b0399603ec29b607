"""A run from the command line to the certificate."""

import re

from .project import Project, short_spec


def test_a_nominal_unit_passes_and_gets_a_certificate(project: Project) -> None:
    ended = project.pytest()
    assert ended.code == 0, ended.out
    assert "3 passed" in ended
    record = project.record()
    assert record["verdict"] == "PASS"
    assert record["simulated"] is True
    assert record["serial_number"] == "1234"
    assert record["model"] == "SHORT50"
    (certificate,) = project.certificates()
    assert re.fullmatch(r"1234_SHORT50_\d{8}T\d{6}Z_PASS\.pdf", certificate.name)
    assert str(certificate) in ended.out.replace("\n", "")
    assert "SIMULATED" in ended


def test_the_record_lists_every_result_with_limit_and_verdict(project: Project) -> None:
    project.pytest()
    results = project.record()["results"]
    keys = {
        "case", "repeat", "name", "value", "unit", "expanded_uncertainty", "coverage_factor", "lower_95",
        "upper_95", "limit", "verdict",
    }  # fmt: skip
    assert all(keys <= set(one) for one in results)
    bias = [one for one in results if one["name"] == "bias"]
    assert [one["repeat"] for one in bias] == [1, 2]
    assert all(one["expanded_uncertainty"] > 0 and one["lower_95"] is None for one in bias)
    walk = [one for one in results if one["name"] == "angle_random_walk"]
    assert all(one["expanded_uncertainty"] is None and one["lower_95"] < one["value"] for one in walk)
    (run_to_run,) = [one for one in results if one["name"] == "bias_run_to_run"]
    assert run_to_run["repeat"] is None
    assert run_to_run["verdict"] == "PASS"


def test_a_failing_unit_fails_naming_the_values(project: Project) -> None:
    project.write("specs/short.yaml", short_spec(bias_max="-1.9 deg/s"))
    ended = project.pytest()
    assert ended.code == 1
    assert project.record()["verdict"] == "FAIL"
    assert re.search(r"bias = \S+ ± \S+ °/s, limit −2 … −1\.9 °/s", ended.out)
    assert "Traceback" not in ended
    assert "_FAIL.pdf" in ended.out.replace("\n", "")


def test_runs_in_the_same_second_do_not_meet(project: Project) -> None:
    first, second = project.start(), project.start()
    assert first.wait(timeout=120) == 0
    assert second.wait(timeout=120) == 0
    first.communicate()
    second.communicate()
    assert len(project.runs()) == 2


def test_a_second_run_is_attempt_two_and_names_the_first(project: Project) -> None:
    project.pytest()
    project.pytest()
    first, second = project.runs()
    assert project.record()["header"]["attempt"] == 2
    assert project.record()["header"]["earlier_runs"] == [first.name]
    assert first != second


def test_several_serial_numbers_take_turns_when_the_operator_agrees(project: Project) -> None:
    refused = project.pytest(serial="1234,1235")
    assert refused.code == 4
    assert "1 slot" in refused
    ended = project.pytest("--gyro-yes", serial="1234,1235")
    assert ended.code == 0, ended.out
    assert project.record("1234")["verdict"] == "PASS"
    assert project.record("1235")["verdict"] == "PASS"
    values = [project.record(serial)["results"][0]["value"] for serial in ("1234", "1235")]
    assert values[0] != values[1]


def test_meta_operator_and_station_are_on_record(project: Project) -> None:
    project.pytest("--gyro-meta", "order=4711", "--gyro-operator", "A. Tester")
    header = project.record()["header"]
    assert header["meta"] == {"order": "4711"}
    assert header["operator"] == "A. Tester"
    assert header["station"]["station"]["name"]


def test_the_same_seed_gives_the_same_values(project: Project) -> None:
    project.pytest("--gyro-sim-seed", "5")
    first = [one["value"] for one in project.record()["results"]]
    project.pytest("--gyro-sim-seed", "5")
    second = [one["value"] for one in project.record()["results"]]
    assert first == second


def test_one_repeat_alone_is_that_of_the_full_run(project: Project) -> None:
    project.pytest()
    full = [one["value"] for one in project.record()["results"] if one["repeat"] == 2]
    project.pytest("-k", "r2")
    alone = [one["value"] for one in project.record()["results"] if one["repeat"] == 2]
    assert alone == full
