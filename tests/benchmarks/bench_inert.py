"""What an installed but unused gyrotest costs another project: time of `pytest --collect-only -q`."""

import statistics
import sys
import tempfile
from pathlib import Path

from tests.benchmarks.process import measure, pytest_command

_RUNS = 15


def main() -> None:
    """Print the difference, with and without the plugin in turn."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "pytest.ini").write_text("[pytest]\n")
        present = pytest_command("--collect-only", "-q")
        absent = [*present, "-p", "no:gyrotest"]
        differences = []
        for _ in range(_RUNS):
            with_it = measure(present, folder, accepted=(5,))
            without = measure(absent, folder, accepted=(5,))
            differences.append(with_it.wall_s - without.wall_s)
    median_ms = 1e3 * statistics.median(differences)
    sys.stdout.write(f"installed but not used: {median_ms:+.1f} ms of wall time (at most 20 ms)\n")


if __name__ == "__main__":
    main()
