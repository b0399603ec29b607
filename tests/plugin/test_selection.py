"""Selecting, stopping and repeating items: what is left out is said, nothing becomes a PASS."""

from .project import FAILING, TINY, Project, Session

TWICE = TINY.replace("interval: 1 s", "interval: 1 s\n    repeats: 3")
TWICE_FAILING = FAILING.replace("interval: 1 s", "interval: 1 s\n    repeats: 3")


def _listed(out: str) -> list[str]:
    return [line for line in out.splitlines() if "::" in line]


def test_looking_touches_no_bench_and_makes_no_run(project: Project) -> None:
    ended = project.pytest("--collect-only", "-q", serial=None)
    assert ended.code == 0
    assert _listed(ended.out) == [
        f"specs/short.yaml::rest-SERIAL-{suffix}" for suffix in ("r1", "r2", "repeats")
    ]
    for argument in ("--markers", "--fixtures", "--setup-plan", "--help", "--version"):
        assert project.pytest(argument, "--cache").code == 0, argument
    assert project.pytest("--cache-show", "--cache").code == 0
    assert not (project.path / "reports").exists()


def test_whatever_is_left_out_is_named_with_its_reason(project: Project) -> None:
    project.write("specs/twice.yaml", TWICE)
    project.write("specs/failing.yaml", TWICE_FAILING)
    r1 = "specs/twice.yaml::rest-1234-r1"
    selections = (("-k", "r1"), ("-m", "slow"), ("--deselect", r1), (r1,), ("--setup-only",))
    keyword, mark, deselected, named, setup_only, stopped = project.sessions(
        *(Session(spec="twice.yaml", arguments=one) for one in selections),
        Session(spec="failing.yaml", arguments=("-x",)),
    )
    for one in (keyword, mark, deselected, named, setup_only, stopped):
        assert one.code in {1, 2, 5}
        assert one.record["verdict"] == "INCOMPLETE"
        assert "INCOMPLETE" in one.certificates[0]
    assert keyword.record["missing"] == [
        "rest-1234-r2: deselected (-k r1)",
        "rest-1234-r3: deselected (-k r1)",
        "rest-1234-repeats: deselected (-k r1)",
    ]
    assert mark.record["missing"][0] == "rest-1234-r1: deselected (-m slow)"
    assert deselected.record["missing"] == [
        f"rest-1234-r1: deselected (--deselect {r1})",
        "rest-1234-repeats: skipped: lacks rest-1234-r1",
    ]
    assert named.record["missing"][0] == "rest-1234-r2: not run"
    assert setup_only.record["missing"][0] == "rest-1234-r1: acquired, but not judged"
    assert stopped.record["missing"][0].startswith("rest-1234-r2: not run (stopping after 1 fail")
    assert [one["verdict"] for one in stopped.record["results"] if one["limit"]] == ["FAIL"]


def test_last_failed_runs_only_what_failed_and_failed_first_keeps_the_plans_order(
    project: Project,
) -> None:
    project.write("specs/failing.yaml", TWICE_FAILING)
    project.pytest("--cache", "-k", "r2", spec="failing.yaml")
    first = project.pytest("--ff", "--cache", "--collect-only", "-q", spec="failing.yaml")
    assert [one.rpartition("-")[2] for one in _listed(first.out)] == ["r1", "r2", "r3", "repeats"]
    last = project.pytest("--lf", "--cache", spec="failing.yaml")
    assert "1 failed" in last
    assert "3 deselected" in last
    assert project.record()["verdict"] == "INCOMPLETE"


def test_the_plans_order_survives_a_shuffle(project: Project) -> None:
    project.write("conftest.py", "def pytest_collection_modifyitems(items):\n    items.reverse()\n")
    ended = project.pytest("--collect-only", "-q", serial="1234")
    listed = [line.rpartition("::")[2] for line in _listed(ended.out)]
    assert listed == ["rest-1234-r1", "rest-1234-r2", "rest-1234-repeats"]


def test_a_spec_is_collected_once_whatever_the_paths_say(project: Project) -> None:
    project.write("specs/tiny.yaml", TINY)
    project.write("test_own.py", "def test_own(): pass\n")
    (project.path / "link").symlink_to(project.path / "specs")
    look = ("--collect-only", "-q")
    for paths, expected in (
        ((), ["specs/tiny.yaml::rest-1234-r1"]),
        ((".",), ["specs/tiny.yaml::rest-1234-r1", "test_own.py::test_own"]),
        (("test_own.py",), ["test_own.py::test_own", "specs/tiny.yaml::rest-1234-r1"]),
        (("specs/tiny.yaml::rest-1234-r1",), ["specs/tiny.yaml::rest-1234-r1"]),
        (("link/tiny.yaml::rest-1234-r1",), ["specs/tiny.yaml::rest-1234-r1"]),
    ):
        assert _listed(project.pytest(*look, *paths, spec="tiny.yaml").out) == expected
    shipped = "mems50.yaml::bias_stability-1234-r2"
    assert shipped in _listed(project.pytest(*look, spec="mems50.yaml").out)
    assert _listed(project.pytest(*look, shipped, spec="mems50.yaml").out) == [shipped]
