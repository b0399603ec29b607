"""Without a spec, nobody notices that gyrotest is installed."""

import json

from .project import Project

HEAVY = ("numpy", "pyvisa", "weasyprint", "pyarrow", "pint", "pydantic", "scipy", "matplotlib", "rich")


def test_collecting_without_a_spec_imports_nothing_heavy(project: Project) -> None:
    project.write(
        "conftest.py",
        f"""
        import json, sys
        def pytest_sessionfinish():
            print("LOADED", json.dumps(sorted(set({HEAVY!r}) & set(sys.modules))))
        """,
    )
    ended = project.pytest("--collect-only", "-q", "-s", spec=None, serial=None)
    loaded = next(line for line in ended.out.splitlines() if line.startswith("LOADED"))
    assert json.loads(loaded.removeprefix("LOADED ")) == []


def test_no_file_appears_without_a_spec(project: Project) -> None:
    project.write("test_own.py", "def test_one(): pass\n")
    before = sorted(path.name for path in project.path.iterdir())
    ended = project.pytest("-p", "no:cacheprovider", spec=None, serial=None)
    after = sorted(path.name for path in project.path.iterdir() if path.name != "__pycache__")
    assert ended.code == 0
    assert after == before


def test_a_yaml_file_is_not_collected_without_a_spec(project: Project) -> None:
    ended = project.pytest("specs", spec=None, serial=None)
    assert ended.code == 5


def test_serial_without_a_spec_is_unknown(project: Project) -> None:
    ended = project.pytest(spec=None, serial="1234")
    assert ended.code == 4
    assert "unrecognized arguments: --serial" in ended


def test_a_project_keeps_its_own_serial_option(project: Project) -> None:
    project.write(
        "conftest.py",
        """
        def pytest_addoption(parser):
            parser.addoption("--serial", default="none", help="the project's own")
        """,
    )
    project.write(
        "test_own.py",
        """
        def test_own(pytestconfig):
            assert pytestconfig.getoption("--serial") == "COM3"
        """,
    )
    without_spec = project.pytest("test_own.py", spec=None, serial="COM3")
    assert without_spec.code == 0
    with_spec = project.pytest("test_own.py", "--gyro-serial", "1234", serial="COM3")
    assert with_spec.code == 0, with_spec.out
    assert project.record()["serial_number"] == "1234"


def test_a_project_with_its_own_serial_option_must_use_the_long_one(project: Project) -> None:
    project.write(
        "conftest.py",
        """
        def pytest_addoption(parser):
            parser.addoption("--serial", default="none", help="the project's own")
        """,
    )
    ended = project.pytest(serial="1234")
    assert ended.code == 4
    assert "needs the serial number" in ended
    assert "--gyro-serial" in ended
