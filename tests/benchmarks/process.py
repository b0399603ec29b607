"""Whole processes, measured from outside: wall time, processor time and peak memory."""

import os
import statistics
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True, kw_only=True)
class Usage:
    """What one process used."""

    wall_s: float
    cpu_s: float
    peak_mb: float


def measure(command: Sequence[str], folder: Path, *, accepted: Sequence[int] = (0,)) -> Usage:
    """Run a command to its end; raises `RuntimeError` with its output where it fails."""
    started = time.perf_counter()
    with (folder / "output.txt").open("wb") as output:
        process = subprocess.Popen(command, cwd=folder, stdout=output, stderr=subprocess.STDOUT)
        _, status, usage = os.wait4(process.pid, 0)
    wall_s = time.perf_counter() - started
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in accepted:
        raise RuntimeError((folder / "output.txt").read_text(errors="replace"))
    return Usage(wall_s=wall_s, cpu_s=usage.ru_utime + usage.ru_stime, peak_mb=usage.ru_maxrss / 1024)


def median(usages: Sequence[Usage]) -> Usage:
    """The median of each figure."""
    return Usage(
        wall_s=statistics.median(one.wall_s for one in usages),
        cpu_s=statistics.median(one.cpu_s for one in usages),
        peak_mb=statistics.median(one.peak_mb for one in usages),
    )


def pytest_command(*arguments: str) -> list[str]:
    """The command line of a pytest run without its cache."""
    return [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *arguments]
