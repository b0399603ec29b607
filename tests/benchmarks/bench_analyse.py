"""`gyrotest analyse` of 9,000,000 samples, from the shell: wall time, processor time and peak memory."""

import statistics
import sys
import tempfile
from pathlib import Path

import numpy as np

from tests.benchmarks.process import measure, median

_SAMPLES, _RATE_HZ = 9_000_000, 125.0
_RUNS = 5
_BOUND_S = 3.0
_EMPTY = (
    "import matplotlib.figure, matplotlib.backends.backend_pdf, numba, pint, scipy.fft, scipy.linalg"
)


def main() -> None:
    """Print what the command takes, beside what loading its packages alone takes, in turn."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        np.save(folder / "rest.npy", _rates())
        options = ("--unit", "deg/s", "--rate", f"{_RATE_HZ:g} Hz", "--plot", "allan.pdf")
        command = [sys.executable, "-m", "gyrotest", "analyse", "rest.npy", *options]
        empty = [sys.executable, "-c", _EMPTY]
        measure(command, folder)  # the first run may compile
        pairs = [(measure(command, folder), measure(empty, folder)) for _ in range(_RUNS)]
    whole, loading = (median([pair[side] for pair in pairs]) for side in (0, 1))
    ratio = statistics.median(pair[0].cpu_s / pair[1].cpu_s for pair in pairs)
    sys.stdout.write(
        f"gyrotest analyse, {_SAMPLES:,} samples with a plot: {whole.wall_s:.2f} s (at most {_BOUND_S:g} s),"
        f" {whole.cpu_s:.2f} s of processor time, {whole.peak_mb:.0f} MB peak;"
        f" loading its packages alone {loading.wall_s:.2f} s, {ratio:.1f} times less processor time\n"
    )


def _rates() -> np.ndarray:
    """Twenty hours of a STIM210: angle random walk 0.15 °/√h, rate random walk 0.6 °/h/√h."""
    generator = np.random.default_rng(5)
    white = generator.standard_normal(_SAMPLES) * 9.0 / 3600.0 * np.sqrt(_RATE_HZ)
    walk = np.cumsum(generator.standard_normal(_SAMPLES)) * 0.01 / 3600.0 / np.sqrt(_RATE_HZ)
    return white + walk


if __name__ == "__main__":
    main()
