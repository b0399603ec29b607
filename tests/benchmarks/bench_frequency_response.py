"""Three 10-minute runs at 10 kHz: low-pass, spectra, Hv and the fitted curve; accuracy and memory beside."""

import resource
import statistics
import sys
import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.cross_spectra import CrossSpectra, Spectra, pooled
from gyrotest.analysis.frequency_response import hv
from gyrotest.analysis.lowpass import Lowpass
from gyrotest.analysis.noise_ratio import noise_ratio
from gyrotest.analysis.response_curve import ResponseCurve, fit_response

_RATE_HZ = 10_000.0
_CUTOFF_HZ = 250.0
_BAND_HZ = (5.0, 100.0)
_BLOCK = 10_000
_BLOCKS = 600
_RUNS = 3
_DELAY = 4  # samples
_NOISE = 0.005**0.5
_DEGREE = 5
_ROUNDS = 3


@dataclass(frozen=True, kw_only=True)
class Figures:
    """Of one round: processor time of the parts, s, and the curve."""

    filter_s: float
    spectra_s: float
    rest_s: float
    curve: ResponseCurve


class Signals:
    """Blocks of angle and output (2, n): white rate, a delay of four samples, white noise on both."""

    def __init__(self, seed: int, *, moving: bool) -> None:
        self._random = np.random.default_rng(seed)
        self._moving = float(moving)
        self._late = np.zeros(_DELAY)
        self._angle = 0.0

    def block(self) -> NDArray[np.float64]:
        motion, reference, output = self._random.normal(size=(3, _BLOCK))
        motion *= self._moving
        angle = self._angle + np.cumsum(motion + _NOISE * reference) / _RATE_HZ
        self._angle = float(angle[-1])
        delayed = np.concatenate((self._late, motion))
        self._late = delayed[_BLOCK:]
        return np.stack((angle, delayed[:_BLOCK] + _NOISE * output))


def main() -> None:
    """Print the figures."""
    found = [_round(seed) for seed in range(_ROUNDS)]
    filter_s, spectra_s, rest_s = (_median(found, one) for one in ("filter_s", "spectra_s", "rest_s"))
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    sys.stdout.write(
        f"frequency response, {_RUNS} runs of 10 min at 10 kHz ({_RUNS * _BLOCKS * _BLOCK:,} samples of two"
        f" signals): low-pass {filter_s:.2f} s, spectra {spectra_s:.2f} s CPU (together at most 4 s), Hv and"
        f" curve {rest_s:.2f} s; {peak_mb:.0f} MB peak of the process\n"
    )
    for one in found:
        sys.stdout.write(f"  {_accuracy(one.curve)}\n")


def _round(seed: int) -> Figures:
    begun = time.process_time()
    spent = {"filter": 0.0, "spectra": 0.0, "signals": 0.0}
    rest = _run(Signals(1000 * seed + 99, moving=False), 30, spent)
    runs = [_run(Signals(1000 * seed + k, moving=True), _BLOCKS, spent) for k in range(_RUNS)]
    curve = fit_response(hv(pooled(runs), noise_ratio(rest)), degree=_DEGREE, coherence_floor=0.5)
    total = time.process_time() - begun
    return Figures(
        filter_s=spent["filter"],
        spectra_s=spent["spectra"],
        rest_s=total - sum(spent.values()),
        curve=curve,
    )


def _run(signals: Signals, blocks: int, spent: dict[str, float]) -> Spectra:
    low_pass = Lowpass(_CUTOFF_HZ, _RATE_HZ, 2)
    made = CrossSpectra(rate_hz=_RATE_HZ, low_hz=_BAND_HZ[0], high_hz=_BAND_HZ[1])
    for _ in range(blocks):
        times = [time.process_time()]
        block = signals.block()
        times.append(time.process_time())
        filtered = low_pass.push(block)
        times.append(time.process_time())
        made.push(filtered[0], filtered[1])
        times.append(time.process_time())
        for part, seconds in zip(("signals", "filter", "spectra"), np.diff(times), strict=True):
            spent[part] += float(seconds)
    return made.spectra()


def _accuracy(curve: ResponseCurve) -> str:
    """Beside the truth: an angle that goes evenly from sample to sample has its rate half a sample before."""
    points = curve.at(np.linspace(*_BAND_HZ, 96))
    phase = points.phase_deg + 360.0 * points.frequency_hz * (_DELAY + 0.5) / _RATE_HZ
    expected = np.sinc(points.frequency_hz / _RATE_HZ)
    return (
        f"coherence {np.median(curve.lines.coherence):.4f}: gain within"
        f" {100 * np.abs(points.gain / expected - 1).max():.3f} %, phase within {np.abs(phase).max():.3f}°"
        f" (at most 0.2 %, 0.2°); u at the ends and in the middle"
        f" {100 * (points.gain_uncertainty / points.gain)[[0, -1]].max():.3f} %,"
        f" {100 * (points.gain_uncertainty / points.gain)[48]:.3f} %"
    )


def _median(found: list[Figures], name: str) -> float:
    return statistics.median(getattr(one, name) for one in found)


if __name__ == "__main__":
    main()
