"""Three 10-minute runs at 10 kHz and three channels: from the recording to the certificate, and the whole job."""

import shutil
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from gyrotest.records.run import Outcome
from gyrotest.runner.folder import RECORD, RunFolder
from tests.benchmarks.process import Usage, measure, median, pytest_command

_RUNS = 3
_VALUES = 54_000_000
_SPEC = """
model: FOG50D
output: {kind: voltage, scale_factor: 20 mV/(deg/s), full_scale: 100 deg/s, bandwidth: 80 Hz}
cases:
  random:
    procedure: random_vibration
    duration: 10 min
    interval: 0.1 ms
    parameters: {level: 8 deg/s, rest: 60 s, frequencies: [5 Hz, 20 Hz, 50 Hz, 100 Hz]}
    limits:
      sensitivity_20Hz: {min: 19 mV/(deg/s), max: 21 mV/(deg/s)}
"""


def main() -> None:
    """Print the figures."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "pytest.ini").write_text("[pytest]\n")
        (folder / "vibration.yaml").write_text(_SPEC)
        command = pytest_command("--gyro-spec", "vibration.yaml", "--serial", "1234")
        whole = measure(command, folder)
        (run,) = (folder / "reports" / "1234").iterdir()
        reduced = median([_reduced(command, folder, run, number) for number in range(_RUNS)])
    sys.stdout.write(
        f"random vibration, 3 × 10 min at 10 kHz × 3 channels ({_VALUES:,} values), recording to PDF:"
        f" {_words(reduced)} (at most 15 s, 500 MB)\n"
        f"  with the simulated bench, the acquisition and the recording: {_words(whole)}\n"
    )


def _reduced(command: list[str], folder: Path, run: Path, number: int) -> Usage:
    """The run taken up again where it was acquired and nothing was computed of it yet."""
    acquired = run.with_name(f"{run.name}-{number}")
    shutil.copytree(run, acquired)
    opened = RunFolder(acquired)
    for item in opened.header().plan:
        (attempt,) = opened.attempts(item.name)
        opened.write_attempt(
            replace(attempt, outcome=Outcome.ACQUIRED, results=(), figures=(), exports=())
        )
    for made in (acquired / RECORD, *acquired.glob("*.pdf")):
        made.unlink()
    shutil.rmtree(acquired / "exports")
    return measure([*command, "--gyro-resume", str(acquired)], folder)


def _words(usage: Usage) -> str:
    return f"{usage.wall_s:.1f} s wall, {usage.cpu_s:.1f} s CPU, {usage.peak_mb:.0f} MB peak"


if __name__ == "__main__":
    main()
