"""The main job: three virtual hours on the simulated bench and the certificate; and a long replay."""

import sys
import tempfile
from pathlib import Path

import numpy as np

from tests.benchmarks.process import Usage, measure, median, pytest_command

_SAMPLES = 9_000_000
_RUNS = 5

_REPLAY_SPEC = """
model: LONG
output: {kind: rate, bandwidth: 50 Hz}
cases:
  rest:
    procedure: static
    duration: 90000 s
    interval: 10 ms
    parameters: {smoothing: [1 s, 10 s, 100 s]}
    limits: {bias: {min: -2 deg/s, max: 2 deg/s}}
"""

_REPLAY_STATION = """
name: replay
instruments:
  file:
    driver: replay
    resource: long.npy
    settings: {sample_rate: 100 Hz, unit: deg/s}
slots:
  A: {source: file}
"""


def main() -> None:
    """Print the figures."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "pytest.ini").write_text("[pytest]\n")
        shipped = _main_job(folder)
        _say("main job, 3 virtual hours and the PDF", shipped, "at most 10 s, 450 MB")
        replay = _replay(folder)
        _say(f"replay of {_SAMPLES:,} samples", replay, "at most 300 MB above the main job")
        sys.stdout.write(f"  above the main job's peak: {replay.peak_mb - shipped.peak_mb:.0f} MB\n")


def _main_job(folder: Path) -> Usage:
    command = pytest_command("--gyro-spec", "mems50.yaml", "--serial", "1234")
    measure(command, folder)
    return median([measure(command, folder) for _ in range(_RUNS)])


def _replay(folder: Path) -> Usage:
    noise = np.random.default_rng(1).normal(0.1, 0.1, _SAMPLES)
    np.save(folder / "long.npy", noise)
    (folder / "long.yaml").write_text(_REPLAY_SPEC)
    (folder / "station.yaml").write_text(_REPLAY_STATION)
    command = pytest_command(
        "--gyro-spec", "long.yaml", "--serial", "1", "--gyro-station", "station.yaml"
    )
    return median([measure(command, folder) for _ in range(3)])


def _say(what: str, usage: Usage, bound: str) -> None:
    sys.stdout.write(
        f"{what}: {usage.wall_s:.1f} s wall, {usage.cpu_s:.1f} s CPU, {usage.peak_mb:.0f} MB peak ({bound})\n"
    )


if __name__ == "__main__":
    main()
