"""Selecting, stopping and repeating items: what is left out is said, nothing becomes a PASS."""

import xml.etree.ElementTree as ET

from .project import Project, short_spec


def test_collect_only_lists_the_plan_without_touching_a_bench(project: Project) -> None:
    ended = project.pytest("--collect-only", "-q", serial=None)
    assert ended.code == 0
    assert "specs/short.yaml::rest-SERIAL-r1" in ended
    assert "specs/short.yaml::rest-SERIAL-repeats" in ended
    assert not (project.path / "reports").exists()


def test_a_deselected_item_makes_the_run_incomplete(project: Project) -> None:
    ended = project.pytest("-k", "r1")
    assert ended.code == 1
    assert "1 passed, 2 deselected" in ended
    record = project.record()
    assert record["verdict"] == "INCOMPLETE"
    assert any("rest-1234-r2" in one and "deselected (-k r1)" in one for one in record["missing"])
    assert "INCOMPLETE" in project.certificates()[0].name


def test_what_is_over_the_repeats_is_skipped_when_one_lacks(project: Project) -> None:
    ended = project.pytest("-k", "r1 or repeats", "-rs")
    assert "1 passed, 1 skipped" in ended
    assert "lacks rest-1234-r2" in ended
    assert project.record()["verdict"] == "INCOMPLETE"


def test_stopping_at_the_first_failure_names_what_did_not_run(project: Project) -> None:
    project.write("specs/short.yaml", short_spec(bias_max="-1.9 deg/s"))
    ended = project.pytest("-x")
    assert ended.code in {1, 2}
    record = project.record()
    assert record["verdict"] == "INCOMPLETE"
    assert any("rest-1234-r2" in one and "not run" in one for one in record["missing"])
    assert [one["verdict"] for one in record["results"] if one["name"] == "bias"] == ["FAIL"]


def test_last_failed_runs_only_what_failed(project: Project) -> None:
    project.write("specs/short.yaml", short_spec(repeats=2, bias_max="-1.9 deg/s"))
    project.pytest("--cache", "-k", "r2")
    ended = project.pytest("--lf", "--cache")
    assert "1 failed" in ended
    assert "2 deselected" in ended
    assert project.record()["verdict"] == "INCOMPLETE"


def test_junit_xml_has_every_item_and_the_failing_values(project: Project) -> None:
    project.write("specs/short.yaml", short_spec(bias_max="-1.9 deg/s"))
    project.pytest("--junitxml", "out.xml")
    suite = ET.parse(project.path / "out.xml").getroot()
    cases = {case.get("name"): case for case in suite.iter("testcase")}
    assert set(cases) == {"rest-1234-r1", "rest-1234-r2", "rest-1234-repeats"}
    failure = cases["rest-1234-r1"].find("failure")
    assert failure is not None
    assert "bias = " in (failure.get("message") or "")


def test_naming_an_item_runs_it(project: Project) -> None:
    ended = project.pytest("specs/short.yaml::rest-1234-r1")
    assert "1 passed" in ended
    assert project.record()["verdict"] == "INCOMPLETE"


def test_the_plans_order_survives_a_shuffle(project: Project) -> None:
    project.write(
        "conftest.py",
        """
        def pytest_collection_modifyitems(items):
            items.reverse()
        """,
    )
    ended = project.pytest("--collect-only", "-q", serial="1234")
    listed = [line.rpartition("::")[2] for line in ended.out.splitlines() if "::" in line]
    assert listed == ["rest-1234-r1", "rest-1234-r2", "rest-1234-repeats"]
