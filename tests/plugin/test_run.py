"""A run from the command line to the certificate."""

import re
import xml.etree.ElementTree as ET
from pathlib import Path

from .project import FAILING, TINY, Project, Session

KEYS = {
    "case", "repeat", "name", "value", "unit", "expanded_uncertainty", "coverage_factor", "lower_95",
    "upper_95", "limit", "verdict",
}  # fmt: skip


def test_a_nominal_unit_passes_and_gets_a_certificate_with_every_result(project: Project) -> None:
    ended = project.pytest("--gyro-meta", "order=4711", "--gyro-operator", "A. Tester", "-W", "error")
    assert ended.code == 0, ended.out
    assert "3 passed" in ended
    assert "SIMULATED" in ended
    (certificate,) = project.certificates()
    assert re.fullmatch(r"1234_SHORT50_\d{8}T\d{6}Z_PASS\.pdf", certificate.name)
    assert str(certificate) in ended.out.replace("\n", "")
    record = project.record()
    assert [record[key] for key in ("verdict", "simulated", "serial_number", "model")] == [
        "PASS", True, "1234", "SHORT50",
    ]  # fmt: skip
    header = record["header"]
    assert header["meta"] == {"order": "4711"}
    assert header["operator"] == "A. Tester"
    assert header["station"]["station"]["name"]
    assert all(set(one) >= KEYS for one in record["results"])
    bias = [one for one in record["results"] if one["name"] == "bias"]
    assert [one["repeat"] for one in bias] == [1, 2]
    assert all(one["expanded_uncertainty"] > 0 and one["lower_95"] is None for one in bias)
    walk = [one for one in record["results"] if one["name"] == "angle_random_walk"]
    assert all(one["expanded_uncertainty"] is None and one["lower_95"] < one["value"] for one in walk)
    (run_to_run,) = [one for one in record["results"] if one["name"] == "bias_run_to_run"]
    assert (run_to_run["repeat"], run_to_run["verdict"]) == (None, "PASS")


def test_a_failing_unit_fails_naming_the_values_in_the_terminal_and_in_junit_xml(
    project: Project,
) -> None:
    project.write("specs/failing.yaml", FAILING)
    ended = project.pytest("--junitxml", "out.xml", spec="failing.yaml")
    assert ended.code == 1
    assert project.record()["verdict"] == "FAIL"
    line = r"bias = \S+ ± \S+ °/s, limit −2 … −1\.9 °/s"
    assert re.search(line, ended.out)
    assert "Traceback" not in ended
    assert "_FAIL.pdf" in ended.out.replace("\n", "")
    (case,) = ET.parse(project.path / "out.xml").getroot().iter("testcase")
    assert case.get("name") == "rest-1234-r1"
    failure = case.find("failure")
    assert failure is not None
    assert re.search(line, failure.get("message") or "")
    properties = {one.get("name"): one.get("value") for one in case.iter("property")}
    (bias,) = [one for one in project.record()["results"] if one["name"] == "bias"]
    assert properties["gyro.bias"] == f"{bias['value']!r} deg/s"
    assert properties["gyro.bias.limit"] == "min -2.0 deg/s, max -1.9 deg/s"
    assert properties["gyro.bias.verdict"] == "FAIL"


def test_runs_in_the_same_second_do_not_meet(project: Project) -> None:
    project.write("specs/tiny.yaml", TINY)
    both = [project.start(spec="tiny.yaml") for _ in range(2)]
    for one in both:
        one.communicate(timeout=120)
    assert [one.returncode for one in both] == [0, 0]
    assert len(project.runs()) == 2


def _content(folder: Path) -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def test_a_second_run_is_attempt_two_and_one_repeat_alone_is_that_of_the_full_run(
    project: Project,
) -> None:
    project.pytest("--gyro-sim-seed", "5")
    full = [one["value"] for one in project.record()["results"] if one["repeat"] == 2]
    before = _content(project.runs()[0])
    project.pytest("--gyro-sim-seed", "5", "-k", "r2")
    assert _content(project.runs()[0]) == before
    record = project.record()
    assert [one["value"] for one in record["results"]] == full
    first, second = project.runs()
    assert record["header"]["attempt"] == 2
    assert record["header"]["earlier_runs"] == [first.name]
    assert first != second


def test_several_serial_numbers_take_turns_when_the_operator_agrees(project: Project) -> None:
    project.write("specs/tiny.yaml", TINY)
    refused = project.pytest(serial="1234,1235")
    assert refused.code == 4
    assert "1 slot" in refused
    ended = project.pytest("--gyro-yes", serial="1234,1235", spec="tiny.yaml")
    assert ended.code == 0, ended.out
    assert [project.record(serial)["verdict"] for serial in ("1234", "1235")] == ["PASS", "PASS"]
    values = [project.record(serial)["results"][0]["value"] for serial in ("1234", "1235")]
    assert values[0] != values[1]


def test_progress_comes_as_lines_of_its_own_and_never_with_q(project: Project) -> None:
    project.write("specs/tiny.yaml", TINY)
    shown = project.pytest("-v", spec="tiny.yaml")
    lines = [line.strip() for line in shown.out.splitlines()]
    at = lines.index("rest-1234-r1: 40 samples every 1 s")
    assert lines[at - 1] == "specs/tiny.yaml::rest-1234-r1"
    assert lines[at + 1].startswith("PASSED")
    (quiet,) = project.sessions(Session(spec="tiny.yaml", arguments=("-q",)))
    assert "samples every" not in quiet.out
    assert "1234: PASS (SIMULATED)" in quiet.out


def test_ini_entries_are_defaults_and_count_from_the_ini_file(project: Project) -> None:
    project.write("specs/tiny.yaml", TINY)
    project.write("pytest.ini", "[pytest]\ngyro_operator = B. Tester\ngyro_out = results/here\n")
    project.write("sub/readme", "")
    ended = project.pytest(spec="tiny.yaml", folder="sub")
    assert ended.code == 0, ended.out
    (record,) = (project.path / "results" / "here" / "1234").glob("*/run.json")
    assert '"B. Tester"' in record.read_text(encoding="utf-8")
    named = project.pytest(spec="tiny.yaml", environment={"GYRO_STATION": "nowhere"})
    assert named.code == 4
    assert "nowhere: no such station" in named
