"""Compiled functions: where they are kept, and that nothing there stops an analysis."""

import errno
import importlib.util
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from gyrotest.analysis.compiled import Floats, FloatsOut, compiled, compiled_sums

SOURCE = """
from gyrotest.analysis.compiled import Floats, compiled

STEP = 1.0

@compiled
def above(value: float) -> float:
    return value + STEP

@compiled
def total(values: Floats) -> float:
    found = 0.0
    for k in range(values.size):
        found += above(values[k])
    return found
"""
VALUES = np.array([1.0, 2.0, 3.0])


def load(folder: Path, name: str = "source") -> ModuleType:
    """The module as a new process would see it."""
    spec = importlib.util.spec_from_file_location(name, folder / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A source folder that cannot be written: root, too, makes no folder where a file is."""
    (tmp_path / "source.py").write_text(SOURCE)
    (tmp_path / "__pycache__").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "user"))
    return tmp_path


def kept(folder: Path, ending: str) -> list[Path]:
    return sorted((folder / "user").rglob(f"*.{ending}"))


def test_a_read_only_installation_keeps_them_in_the_users_cache(folder: Path) -> None:
    assert load(folder).total(VALUES) == 9.0
    assert len(kept(folder, "nbc")) == 1
    before = kept(folder, "nbc")[0].stat()
    assert load(folder).total(VALUES) == 9.0
    assert kept(folder, "nbc")[0].stat().st_mtime_ns == before.st_mtime_ns


def test_without_any_writable_cache_they_are_compiled_for_the_process(folder: Path) -> None:
    (folder / "user").write_text("")
    assert load(folder).total(VALUES) == 9.0
    assert sorted(path.name for path in folder.iterdir()) == ["__pycache__", "source.py", "user"]


@pytest.mark.parametrize("ending", ["nbc", "nbi"])
@pytest.mark.parametrize(
    "damage", [lambda data: data[: len(data) // 2], lambda data: b"", lambda data: b"\x80?"]
)
def test_a_damaged_cache_is_made_anew(
    folder: Path, ending: str, damage: Callable[[bytes], bytes]
) -> None:
    load(folder).total(VALUES)
    path = kept(folder, ending)[0]
    path.write_bytes(damage(path.read_bytes()))
    assert load(folder).total(VALUES) == 9.0
    assert len(path.read_bytes()) > 100


def test_damaged_code_is_not_run(folder: Path) -> None:
    load(folder).total(VALUES)
    path = kept(folder, "nbc")[0]
    whole = path.read_bytes()
    for place in range(len(whole) // 4, len(whole), len(whole) // 4):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0x10]) + whole[place + 1 :])
        assert load(folder).total(VALUES) == 9.0


def test_a_full_disk_does_not_stop_it(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from numba.core import caching

    def full(*arguments: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(caching.IndexDataCacheFile, "_save_data", full)
    assert load(folder).total(VALUES) == 9.0
    assert kept(folder, "nbc") == []


def test_what_changes_with_another_file_is_compiled_again(folder: Path) -> None:
    load(folder).total(VALUES)
    (folder / "top.py").write_text("from source import total\n")
    top = SOURCE.replace("STEP = 1.0", "from low import STEP")
    (folder / "source.py").write_text(top)
    for step in (2.0, 3.0):
        sys.modules["low"] = low = ModuleType("low")
        low.STEP = step  # type: ignore[attr-defined]
        assert load(folder).total(VALUES) == 6.0 + 3 * step
    del sys.modules["low"]


def test_several_processes_may_compile_at_once(folder: Path) -> None:
    program = "import numpy, source; print(source.total(numpy.array([1.0, 2.0, 3.0])))"
    running = [
        subprocess.Popen([sys.executable, "-c", program], cwd=folder, stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    assert [process.communicate()[0] for process in running] == ["9.0\n"] * 2
    assert len(kept(folder, "nbc")) == 1


def test_several_threads_may_call_it_first(folder: Path) -> None:
    module = load(folder)
    with ThreadPoolExecutor(4) as pool:
        assert set(pool.map(module.total, [VALUES] * 4)) == {9.0}


def test_an_array_that_is_read_only_makes_no_second_copy(folder: Path) -> None:
    module = load(folder)
    frozen = VALUES.copy()
    frozen.setflags(write=False)
    assert module.total(frozen) == module.total(VALUES) == 9.0
    assert len(kept(folder, "nbc")) == 1


def test_another_type_is_refused(folder: Path) -> None:
    with pytest.raises(TypeError, match="No matching definition"):
        load(folder).total(np.array([1, 2]))


def test_a_mistake_in_the_function_itself_is_shown() -> None:
    from numba.core.errors import TypingError

    @compiled
    def wrong(values: Floats) -> float:
        return values.no_such_thing  # type: ignore[attr-defined, no-any-return]

    with pytest.raises(TypingError):
        wrong(VALUES)


def test_infinity_and_nan_stay_what_they_are_in_reordered_sums() -> None:
    @compiled_sums
    def total(values: Floats, out: FloatsOut) -> None:
        found = 0.0
        for k in range(values.size):
            found += values[k]
        out[0] = found

    out = np.zeros(1)
    for last, expected in ((np.inf, np.inf), (np.nan, np.nan)):
        total(np.append(np.ones(100), last), out)
        np.testing.assert_equal(out[0], expected)


def test_importing_the_analysis_does_not_import_numba() -> None:
    program = (
        "import sys, gyrotest.analysis.allan, gyrotest.analysis.accumulator, gyrotest.analysis.noise;"
        "print('numba' in sys.modules)"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ended.stdout == "False\n"
