"""Twenty hours of a digital gyro: frames over a socket, decoded, stored, analysed axis by axis, certified."""

import sys
import tempfile
from pathlib import Path

from tests.benchmarks.process import measure, median, pytest_command

_RUNS = 3
_VALUES = 27_000_000


def main() -> None:
    """Print the figures."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "pytest.ini").write_text("[pytest]\n")
        command = pytest_command("--gyro-spec", "stim210.yaml", "--serial", "1234")
        usage = median([measure(command, folder) for _ in range(_RUNS)])
    sys.stdout.write(
        f"STIM210, 125 Hz, 20 h, 3 axes ({_VALUES:,} values), and the PDF: {usage.wall_s:.0f} s wall,"
        f" {usage.cpu_s:.0f} s CPU, {usage.peak_mb:.0f} MB peak (at most 120 s, 700 MB)\n"
    )


if __name__ == "__main__":
    main()
