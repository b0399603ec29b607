"""Overlapping Allan deviation: speed, memory and streams, beside the public packages that compute it.

All in one process, one after another in turn, in CPU seconds. Prints tables for the documentation.
The extra `benchmark` installs the packages; one that is missing is left out.
"""

import importlib.util
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass

import allantools
import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.accumulator import AllanAccumulator, Mode
from gyrotest.analysis.allan import default_factors, overlapping_allan_deviation
from gyrotest.analysis.angle import angle
from gyrotest.analysis.kernels.chains import overlapping_variances
from gyrotest.analysis.kernels.record import STREAMS, scan
from gyrotest.analysis.noise_type import noise_types

_SAMPLES = 9_000_000
_RUNS = 5
_LONG_RUNS = 3
_KERNEL_NS = 0.21
"""Of a blocked kernel that takes each averaging time by itself, a sample and averaging time."""

_REALTIME_SAMPLES = 4000
_MEMORY = """
import re, sys
import numpy as np
from pathlib import Path
from tests.benchmarks import bench_allan as bench
run = bench.PEERS[sys.argv[1]]
def peak_kb():  # of this program alone: a process takes over its parent's ru_maxrss
    return int(re.search(r"VmHWM:\\s*(\\d+)", Path("/proc/self/status").read_text())[1])
run(np.random.default_rng(1).normal(size=2000), bench.default_factors(2000))
rate = np.random.default_rng(1).normal(size=int(sys.argv[2]))
before = peak_kb()
run(rate, bench.default_factors(rate.size))
print((peak_kb() - before) / 1024)
"""

_Rate = NDArray[np.float64]
_Factors = NDArray[np.int64]


def _ours(rate: _Rate, factors: _Factors) -> None:
    overlapping_variances(angle(rate), factors)


def _allantools(rate: _Rate, factors: _Factors) -> None:
    allantools.oadev(rate, rate=1.0, data_type="freq", taus=factors.astype(float))


def _allan_variance(rate: _Rate, factors: _Factors) -> None:
    """It chooses the averaging times itself: about as many, as long."""
    import allan_variance

    steps = round(10 * np.log10(factors[-1])) + 1
    allan_variance.compute_avar(rate, 1.0, tau_max=float(factors[-1]), n_clusters=steps)


def _avar(rate: _Rate, factors: _Factors) -> None:
    import avar

    avar.variance(rate, factors)


PEERS: dict[str, Callable[[_Rate, _Factors], None]] = {
    "gyrotest": _ours,
    "allantools": _allantools,
    "allan-variance": _allan_variance,
    "avar": _avar,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One line of a table: CPU seconds of each run."""

    name: str
    runs: list[float]

    @property
    def cpu_s(self) -> float:
        """The median."""
        return statistics.median(self.runs)


def main() -> None:
    """Print all tables."""
    rate = np.random.default_rng(1).normal(size=_SAMPLES)
    there = [name for name in PEERS if importlib.util.find_spec(name.replace("-", "_"))]
    reference = _whole_records(rate, there, _RUNS)
    _streams(rate, reference)
    _intervals(rate)
    _where_time_goes(rate)
    long = np.concatenate([rate] * 10)
    del rate
    _whole_records(long, ["gyrotest", "allantools"], _LONG_RUNS)


def _in_turn(cases: dict[str, Callable[[], None]], runs: int) -> dict[str, Case]:
    found: dict[str, list[float]] = {name: [] for name in cases}
    for _ in range(runs):
        for name, run in cases.items():
            started = time.process_time()
            run()
            found[name].append(time.process_time() - started)
    return {name: Case(name=name, runs=runs_s) for name, runs_s in found.items()}


def _whole_records(rate: _Rate, names: list[str], runs: int) -> Case:
    factors = default_factors(rate.size)
    _ours(rate[:2000], default_factors(2000))
    cases = _in_turn({name: lambda name=name: PEERS[name](rate, factors) for name in names}, runs)
    theirs, ours = cases["allantools"], cases["gyrotest"]
    say = sys.stdout.write
    say(f"\n{rate.size:,} samples, {factors.size} averaging times from 1 to {factors[-1]:,}\n\n")
    say("| | CPU s | allantools is slower by | extra memory, MB |\n|---|---|---|---|\n")
    for name, case in cases.items():
        ratio = statistics.median(t / o for t, o in zip(theirs.runs, case.runs, strict=True))
        say(f"| {name} | {case.cpu_s:.3f} | {ratio:.1f} | {_memory_mb(name, rate.size):.0f} |\n")
    _limits(rate, factors, ours.cpu_s)
    return theirs


def _limits(rate: _Rate, factors: _Factors, ours_s: float) -> None:
    found = np.empty(1 + STREAMS)
    one_pass = _in_turn({"pass": lambda: scan(rate, found)}, 5)["pass"].cpu_s
    work = float(np.sum(rate.size + 1.0 - 2.0 * factors))
    kernel = one_pass + work * _KERNEL_NS * 1e-9
    sys.stdout.write(
        f"\nLimits: one pass over the record {one_pass * 1e3:.1f} ms, {ours_s / one_pass:.0f} times that is ours;"
        f" {_KERNEL_NS} ns a sample and averaging time {kernel:.3f} s, {ours_s / kernel:.2f} times"
        f" that is ours: {ours_s / work * 1e9:.3f} ns.\n"
    )


def _memory_mb(name: str, samples: int) -> float:
    command = [sys.executable, "-c", _MEMORY, name, str(samples)]
    return float(subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()[-1])


def _streams(rate: _Rate, reference: Case) -> None:
    factors = default_factors(rate.size)
    say = sys.stdout.write
    say(f"\nStreams: {rate.size:,} samples in blocks, the curve at the end included\n\n")
    say(
        "| | block | CPU s | µs a sample, wall | allantools' batch is slower by |\n|---|---|---|---|---|\n"
    )
    for mode, wanted in ((Mode.BOUNDED, None), (Mode.EXACT, factors)):
        for size in (125, 10_000):
            runs, walls = [], []
            for _ in range(_RUNS):
                stream = AllanAccumulator(1.0, mode=mode, averaging_factors=wanted)
                started, wall = time.process_time(), time.perf_counter()
                for begin in range(0, rate.size, size):
                    stream.push(rate[begin : begin + size])
                stream.result()
                runs.append(time.process_time() - started)
                walls.append(time.perf_counter() - wall)
            cpu_s, wall_us = statistics.median(runs), statistics.median(walls) / rate.size * 1e6
            say(f"| {mode} | {size:,} | {cpu_s:.3f} | {wall_us:.3f} | {reference.cpu_s / cpu_s:.1f} |\n")
    say(f"| allantools' real-time class, 12 averaging times | 1 | | {_realtime_us(rate):.1f} | |\n")


def _realtime_us(rate: _Rate) -> float:
    stream = allantools.realtime.oadev_realtime(afs=[2**k for k in range(12)], tau0=1.0)
    started = time.perf_counter()
    for sample in rate[:_REALTIME_SAMPLES]:
        stream.add_frequency(sample)
    return (time.perf_counter() - started) / _REALTIME_SAMPLES * 1e6


def _intervals(rate: _Rate) -> None:
    factors = default_factors(rate.size)
    theta = angle(rate)
    cases = _in_turn(
        {
            "deviations": lambda: _ours(rate, factors),
            "noise types": lambda: _discard(noise_types(theta, factors)),
            "all": lambda: _discard(overlapping_allan_deviation(rate, sample_rate_hz=1.0)),
        },
        _RUNS,
    )
    alone, whole = cases["deviations"], cases["all"]
    on_top = statistics.median(w / a - 1 for w, a in zip(whole.runs, alone.runs, strict=True))
    sys.stdout.write(
        f"\nDeviations {alone.cpu_s:.3f} s; with noise types ({cases['noise types'].cpu_s:.3f} s) and intervals"
        f" {whole.cpu_s:.3f} s: {on_top:.0%} on top.\n"
    )


def _where_time_goes(rate: _Rate) -> None:
    factors, theta = default_factors(rate.size), angle(rate)
    parts = {"check, mean and running sum": lambda: _discard(angle(rate))}
    for first, last in ((1, 199), (200, 3999), (4000, 65535), (65536, rate.size)):
        chosen = factors[(factors >= first) & (factors <= last)]
        name = f"{chosen.size} averaging times from {chosen[0]:,} to {chosen[-1]:,}"
        parts[name] = lambda chosen=chosen: _discard(overlapping_variances(theta, chosen))
    sys.stdout.write("\n")
    for name, case in _in_turn(parts, _RUNS).items():
        sys.stdout.write(f"{name}: {case.cpu_s * 1e3:.1f} ms\n")


def _discard(_: object) -> None:
    """Take a result and do nothing with it."""


if __name__ == "__main__":
    main()
