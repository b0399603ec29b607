"""Whatever breaks, is marked or is tampered with: what went wrong never ends in a PASS or in exit code 0."""

import pytest

from .project import FAILING, TINY, Project, Session

MARKED = """
import pytest
def pytest_collection_modifyitems(items):
    for item in items:
        item.add_marker(pytest.mark.{mark})
"""
AUTOUSE = """
import pytest
@pytest.fixture(autouse=True, scope="{scope}")
def breaking():
    {before}
    yield
    {after}
"""
BOOM = "raise RuntimeError('boom')"


@pytest.fixture
def tiny(project: Project) -> Project:
    project.write("specs/tiny.yaml", TINY)
    project.write("specs/failing.yaml", FAILING)
    return project


def _broken(plugin: str) -> Session:
    return Session(spec="tiny.yaml", plugin=plugin)


def test_a_fault_anywhere_in_the_session_ends_in_one_incomplete_certificate(tiny: Project) -> None:
    hooks = (
        "gyro_acquired(item)", "gyro_judged(item)", "gyro_certified(record)", "runtest_setup(item)",
        "runtest_call(item)", "runtest_teardown(item)", "runtest_logreport(report)", "sessionstart()",
        "sessionfinish()", "collection_finish()",
    )  # fmt: skip
    fixtures = [
        AUTOUSE.format(scope="function", before="pass", after=BOOM),
        AUTOUSE.format(scope="session", before="pass", after=BOOM),
        AUTOUSE.format(scope="function", before="raise KeyboardInterrupt", after="pass"),
        AUTOUSE.format(scope="function", before="pass", after="raise KeyboardInterrupt"),
        AUTOUSE.format(scope="function", before="pass", after="pytest.exit('enough', returncode=0)"),
        MARKED.format(mark="xfail()") + f"def pytest_gyro_judged(item):\n    {BOOM}\n",
        MARKED.format(mark="xfail()") + AUTOUSE.format(scope="function", before="pass", after=BOOM),
    ]
    plugins = [f"def pytest_{hook}:\n    {BOOM}\n" for hook in hooks] + fixtures
    for plugin, ended in zip(plugins, tiny.sessions(*map(_broken, plugins)), strict=True):
        assert ended.code != 0, plugin
        assert ended.record["verdict"] == "INCOMPLETE", plugin
        assert len(ended.certificates) == 1, plugin
        assert "INCOMPLETE" in ended.certificates[0], plugin


def test_a_certificate_that_cannot_be_written_leaves_no_pass(tiny: Project) -> None:
    plugin = """
    import gyrotest.certificate.pdf as pdf
    def broken(record, folder):
        raise OSError("No space left on device")
    pdf.write_certificate = broken
    """
    (ended,) = tiny.sessions(_broken(plugin))
    assert ended.code == 1
    assert ended.record["verdict"] == "INCOMPLETE"
    assert ended.record["missing"] == ["no certificate: OSError: No space left on device"]
    assert ended.certificates == []
    assert "1234: no certificate: OSError: No space left on device" in ended.out


def test_marks_and_other_plugins_change_no_verdict(tiny: Project) -> None:
    lowering = """
    import pytest
    @pytest.hookimpl(wrapper=True)
    def pytest_sessionfinish(session):
        yield
        session.exitstatus = 0
    """
    praising = """
    import pytest
    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_makereport():
        report = yield
        report.outcome = "passed"
        return report
    """
    xfail = MARKED.format(mark="xfail(reason='known')")
    failing = tiny.sessions(
        *(Session(spec="failing.yaml", plugin=one) for one in (lowering, praising, xfail))
    )
    assert [(one.code, one.record["verdict"]) for one in failing] == [(1, "FAIL")] * 3


def test_skipped_and_emptied_plans_are_incomplete_with_their_reason(tiny: Project) -> None:
    tiny.write("test_broken.py", "import nonsense_that_is_not_there\n")
    go_on = ("test_broken.py", "--continue-on-collection-errors")
    skipped, emptied, uncollected = tiny.sessions(
        _broken(MARKED.format(mark="skip(reason='no time')")),
        _broken("def pytest_collection_modifyitems(items):\n    items.clear()\n"),
        Session(spec="tiny.yaml", arguments=go_on),
    )
    assert (skipped.code, emptied.code, uncollected.code) == (1, 5, 1)
    assert skipped.record["missing"] == ["rest-1234-r1: skipped (no time)"]
    assert emptied.record["missing"] == ["rest-1234-r1: not run"]
    assert uncollected.record["missing"] == ["test_broken.py could not be collected"]
    assert uncollected.record["verdict"] == "INCOMPLETE"


def test_a_passing_session_in_a_process_of_others_passes(tiny: Project) -> None:
    first, second = tiny.sessions(Session(spec="tiny.yaml"), Session(spec="tiny.yaml"))
    assert [first.code, second.code] == [0, 0], first.out
    assert first.record["verdict"] == second.record["verdict"] == "PASS"
    values = [[one["value"] for one in ended.record["results"]] for ended in (first, second)]
    assert values[0] == values[1]
