"""Noise identification against known truths: 200 seeded records of each, coverage over all of them.

A record has 288,000 samples, four a second: 20 hours (a quarter of that where readings have dead
time, and 125 samples a second where there is a line at 20 Hz). Coefficients in °/h and seconds.
"""

import math
import multiprocessing
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.allan import overlapping_allan_deviation
from gyrotest.analysis.noise import identify_noise, spectral_lines
from tests.benchmarks.records import DPH, noise_record

RECORDS = 200
SAMPLES = 288_000
SPARSE = 6
LONG = 9_000_000
NAMES = (
    "quantization_noise",
    "angle_random_walk",
    "bias_instability_coefficient",
    "rate_random_walk",
    "rate_ramp",
)
LETTERS = "QNBKR"


@dataclass(frozen=True, kw_only=True)
class Truth:
    """Coefficients of a record's noise, and what else is in it."""

    noise: dict[str, float]
    exponential: tuple[float, float] | None = None  # °/h, s
    line: float = 0.0  # peak, °/h, at 20 Hz
    sample_rate_hz: float = 4.0
    sparse: bool = False
    bars: dict[str, tuple[float, float]] = field(default_factory=dict)


STIM210 = {"angle_random_walk": 9.0, "bias_instability": 0.5, "rate_random_walk": 0.01}
ADIS16375 = {"angle_random_walk": 60.0, "bias_instability": 12.0, "rate_random_walk": 0.3}
ANALOGUE = {"angle_random_walk": 180.0, "bias_instability": 40.0, "rate_random_walk": 2.0}
STILL = {"angle_random_walk": 9.0, "bias_instability": 0.5}

TRUTHS = {
    "STIM210": Truth(noise=STIM210),
    "ADIS16375": Truth(noise=ADIS16375),
    "analogue": Truth(noise=ANALOGUE),
    "white noise alone": Truth(noise={"angle_random_walk": 9.0}),
    "white noise and a walk": Truth(noise={"angle_random_walk": 9.0, "rate_random_walk": 0.05}),
    "STIM210, Q = 9": Truth(noise=STIM210 | {"quantization_noise": 9.0}),
    "STIM210, Q = 1": Truth(noise=STIM210 | {"quantization_noise": 1.0}),
    "ADIS16375, Q = 20, R = 0.002": Truth(
        noise=ADIS16375 | {"quantization_noise": 20.0, "rate_ramp": 0.002}
    ),
    "STIM210, R = 0.0002": Truth(noise=STIM210 | {"rate_ramp": 0.0002}),
    "STIM210, line at 20 Hz": Truth(noise=STIM210, line=40.0, sample_rate_hz=125.0),
    "analogue, duty 1/6": Truth(noise=ANALOGUE, sparse=True),
    "K = 0, ramp 0.7 °/h in all": Truth(noise=STILL | {"rate_ramp": 0.00001}),
    "K = 0, ramp 3.6 °/h": Truth(noise=STILL | {"rate_ramp": 0.00005}),
    "K = 0, ramp 36 °/h": Truth(noise=STILL | {"rate_ramp": 0.0005}),
    "K = 0, 5 °/h · exp(−t/3 h)": Truth(noise=STILL, exponential=(5.0, 10_800.0)),
    "K = 0, 20 °/h · exp(−t/20 min)": Truth(noise=STILL, exponential=(20.0, 1200.0)),
    "K = 0, 200 °/h · exp(−t/1 h)": Truth(noise=STILL, exponential=(200.0, 3600.0)),
}


@dataclass(frozen=True, kw_only=True)
class Found:
    """Of one record: value, bounds and whether resolved, (5, 6), and how the fit went."""

    terms: NDArray[np.float64]
    drift: str
    lines: int
    first_tau_s: float
    seconds: float


def main(names: tuple[str, ...] = tuple(TRUTHS)) -> None:
    """Print a Markdown table, a row a term of each truth."""
    _say(__doc__ or "")
    _say("| truth | term | bias | RMSE | within 95 % | within 68 % | resolved |")
    _say("|---|---|---|---|---|---|---|")
    seconds: list[float] = []
    with multiprocessing.Pool(2) as pool:
        for name in names:
            found = pool.starmap(identified, [(name, seed) for seed in range(RECORDS)], chunksize=5)
            seconds += [one.seconds for one in found]
            report(name, TRUTHS[name], found)
    _say(
        f"\nidentify_noise with curve and lines at hand: median {1e3 * statistics.median(seconds):.0f} ms"
    )
    long_record()


def long_record() -> None:
    """Print the processor time of each step with 9,000,000 samples, medians of nine."""
    coefficients = {name: value * DPH for name, value in STIM210.items()}
    rate = noise_record(LONG, interval_s=1.0 / 125.0, seed=1, **coefficients)
    curve = overlapping_allan_deviation(rate, sample_rate_hz=125.0)
    lines = spectral_lines(rate, sample_rate_hz=125.0)
    steps: dict[str, Callable[[], object]] = {
        "curve and lines at hand": lambda: identify_noise(
            rate, sample_rate_hz=125.0, deviation=curve, lines=lines
        ),
        "spectral lines": lambda: spectral_lines(rate, sample_rate_hz=125.0),
        "all of it": lambda: identify_noise(rate, sample_rate_hz=125.0),
    }
    for name, step in steps.items():
        seconds = []
        for _ in range(9):
            begin = time.process_time()
            step()
            seconds.append(time.process_time() - begin)
        _say(f"{LONG:,} samples, {name}: {1e3 * statistics.median(seconds):.0f} ms")


def _say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def identified(name: str, seed: int) -> Found:
    truth = TRUTHS[name]
    rate, duty = recorded(truth, seed)
    rate_hz = truth.sample_rate_hz
    curve = overlapping_allan_deviation(rate, sample_rate_hz=rate_hz)
    lines = spectral_lines(rate, sample_rate_hz=rate_hz)
    begin = time.process_time()
    model = identify_noise(rate, sample_rate_hz=rate_hz, duty=duty, deviation=curve, lines=lines)
    seconds = time.process_time() - begin
    rows = [
        (one.value, one.lower_68, one.upper_68, one.lower_95, one.upper_95, one.resolved)
        for one in model.terms
    ]
    return Found(
        terms=np.array(rows, dtype=np.float64) / np.array([DPH] * 5 + [1.0]),
        drift="none" if model.drift is None else model.drift.kind.value,
        lines=len(model.lines),
        first_tau_s=model.first_tau_s,
        seconds=seconds,
    )


def recorded(truth: Truth, seed: int) -> tuple[NDArray[np.float64], float]:
    """Return a record, °/s, and its duty."""
    interval_s = 1.0 / truth.sample_rate_hz
    coefficients = {name: value * DPH for name, value in truth.noise.items()}
    if truth.sparse:
        fine = noise_record(
            SAMPLES // 4 * SPARSE, interval_s=interval_s / SPARSE, seed=seed, **coefficients
        )
        return fine[::SPARSE].copy(), 1.0 / SPARSE
    rate = noise_record(SAMPLES, interval_s=interval_s, seed=seed, **coefficients)
    time_s = interval_s * np.arange(SAMPLES)
    if truth.exponential is not None:
        amplitude, constant_s = truth.exponential
        rate += amplitude * DPH * np.exp(-time_s / constant_s)
    if truth.line:
        rate += truth.line * DPH * np.sin(2.0 * np.pi * 20.0 * time_s + seed)
    return rate, 1.0


def report(name: str, truth: Truth, found: list[Found]) -> None:
    terms = np.array([one.terms for one in found])
    for place, (letter, term) in enumerate(zip(LETTERS, NAMES, strict=True)):
        value = truth.noise.get(term.replace("_coefficient", ""), 0.0)
        if truth.sparse and letter == "N":
            value *= math.sqrt(SPARSE)
        guess, lower_68, upper_68, lower_95, upper_95, resolved = terms[:, place].T
        error = "" if value == 0.0 else f"{100 * np.mean(guess / value - 1):+.2f} %"
        rmse = "" if value == 0.0 else f"{100 * np.sqrt(np.mean((guess / value - 1) ** 2)):.2f} %"
        within_95 = np.mean((lower_95 <= value) & (value <= upper_95))
        within_68 = np.mean((lower_68 <= value) & (value <= upper_68))
        _say(
            f"| {name} | {letter} = {value:g} | {error} | {rmse} | {100 * within_95:.1f} %"
            f" | {100 * within_68:.1f} % | {100 * resolved.mean():.1f} % |"
        )
    drifts = sorted({one.drift for one in found})
    counts = ", ".join(f"{one} {sum(each.drift == one for each in found)}" for one in drifts)
    lines = statistics.mean(one.lines for one in found)
    late = sum(one.first_tau_s > 1.0 / truth.sample_rate_hz * 1.01 for one in found)
    _say(f"| | drift: {counts}; lines: {lines:.2f} a record; short times left out: {late} | | | | | |")


if __name__ == "__main__":
    main(tuple(sys.argv[1:]) or tuple(TRUTHS))
