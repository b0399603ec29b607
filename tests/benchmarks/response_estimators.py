"""The estimators H1, H2 and Hv against truth, with noise on both channels in three ratios.

`python -m tests.benchmarks.response_estimators` draws docs/images/response-estimators.png and prints the
tables of docs/frequency-response.md: the estimators' errors, and how often uncertainties hold the truth.
"""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.cross_spectra import pooled
from gyrotest.analysis.frequency_response import h1, h2, hv
from gyrotest.analysis.noise_ratio import noise_ratio
from gyrotest.analysis.response_curve import (
    ResponseCurve,
    bandwidth,
    fit_response,
    group_delay,
    quarter_turn,
)
from gyrotest.certificate.figures import image
from gyrotest.records.figure import Band, Curve, Figure, Panel, Role
from tests.unit.analysis.vibration import Truth, Vibration

RATIOS = (0.1, 1.0, 10.0)
NOISE = 0.02
RUNS, RUN_S, REST_S = 3, 600.0, 60.0
DEGREE = 5
GRID = np.linspace(5.0, 100.0, 191)
NINETY_FIVE = 1.96
UNITS, SHORT_S = 300, 30.0
PLACES = np.array([5.0, 50.0, 100.0])
READINGS = (
    *(f"gain at {place:g} Hz" for place in PLACES),
    *(f"phase at {place:g} Hz" for place in PLACES),
    "−3 dB bandwidth",
    "−90° frequency",
    "group delay at 50 Hz",
)
PICTURE = Path("docs/images/response-estimators.png")


@dataclass(frozen=True, kw_only=True)
class Case:
    """One noise ratio, and what each estimator makes of the same records."""

    ratio: float
    vibration: Vibration
    curves: dict[str, ResponseCurve]

    def error_percent(self, name: str) -> NDArray[np.float64]:
        truth = np.abs(self.vibration.truth.response(GRID))
        return 100.0 * (self.curves[name].at(GRID).gain / truth - 1.0)

    def uncertainty_percent(self, name: str) -> NDArray[np.float64]:
        points = self.curves[name].at(GRID)
        return 100.0 * points.gain_uncertainty / points.gain


def cases() -> Iterator[Case]:
    for place, ratio in enumerate(RATIOS):
        truth = Truth(gain=1.0, natural_hz=160.0, damping=0.7, delay_s=4e-4)
        vibration = Vibration(truth=truth, reference=NOISE / ratio**0.5, output=NOISE * ratio**0.5)
        runs = pooled([vibration.spectra((place, run), duration_s=RUN_S) for run in range(RUNS)])
        rest = replace(vibration, rest=True).spectra((place, 9), duration_s=REST_S)
        responses = {"H1": h1(runs), "H2": h2(runs), "Hv": hv(runs, noise_ratio(rest))}
        yield Case(
            ratio=ratio,
            vibration=vibration,
            curves={
                name: fit_response(one, degree=DEGREE, coherence_floor=0.5)
                for name, one in responses.items()
            },
        )


def picture(found: Sequence[Case]) -> Figure:
    return Figure(
        name="response_estimators",
        title="Gain less truth, noise on both channels",
        panels=tuple(_panel(one) for one in found),
    )


def _panel(case: Case) -> Panel:
    x = tuple(GRID)
    bands, curves = [], []
    for series, name in enumerate(case.curves):
        error, spread = case.error_percent(name), NINETY_FIVE * case.uncertainty_percent(name)
        curves.append(Curve(x=x, y=tuple(error), label=name, series=series))
        bands.append(Band(x=x, lower=tuple(error - spread), upper=tuple(error + spread), series=series))
    curves.append(Curve(x=(x[0], x[-1]), y=(0.0, 0.0), role=Role.GUIDE, label="truth"))
    return Panel(
        y_label="Error of the gain / %",
        x_label="Frequency / Hz",
        y_range=(-8.0, 9.0),
        curves=tuple(curves),
        bands=tuple(bands),
        note=f"κ = {case.ratio:g}",
    )


def table(found: Sequence[Case]) -> Iterator[str]:
    yield "| κ | γ² at 20 Hz | H1 | H2 | Hv | u of Hv at 5, 50, 100 Hz |"
    yield "|---|---|---|---|---|---|"
    for one in found:
        rms = {name: float(np.sqrt(np.mean(one.error_percent(name) ** 2))) for name in one.curves}
        u = one.uncertainty_percent("Hv")[[0, 90, -1]]
        yield (
            f"| {one.ratio:g} | {one.vibration.coherence:.3f} | {rms['H1']:.2f} % | {rms['H2']:.2f} %"
            f" | **{rms['Hv']:.2f} %** | {', '.join(f'{value:.2f}' for value in u)} % |"
        )


def honesty(units: int) -> Iterator[str]:
    """How readings scatter about the truth, in their own standard uncertainties."""
    truth = Truth(gain=0.05, natural_hz=80.0, damping=0.65, delay_s=4e-4)
    scores = np.array([_scores(seed, truth) for seed in range(units)])
    yield "| of a unit | mean of z | standard deviation of z |"
    yield "|---|---|---|"
    for name, column in zip(READINGS, scores.T, strict=True):
        yield f"| {name} | {column.mean():+.2f} | {column.std(ddof=1):.2f} |".replace("-", "−")


def _scores(seed: int, truth: Truth) -> list[float]:
    vibration = Vibration(truth=truth)
    runs = pooled([vibration.spectra((seed, run), duration_s=SHORT_S) for run in range(RUNS)])
    rest = replace(vibration, rest=True).spectra((seed, 9), duration_s=20.0)
    curve = fit_response(hv(runs, noise_ratio(rest)), degree=8, coherence_floor=0.5)
    points, gain = curve.at(PLACES), np.abs(truth.response(PLACES))
    phase_deg = truth.phase_deg(PLACES)
    found = list((points.gain - gain) / points.gain_uncertainty)
    found += list((points.phase_deg - phase_deg) / points.phase_uncertainty_deg)
    dense = np.linspace(10.0, 100.0, 90_001)
    level = abs(truth.response(np.array([10.0]))[0]) / np.sqrt(2.0)
    expected = (
        dense[np.flatnonzero(np.abs(truth.response(dense)) <= level)[0]],
        dense[np.flatnonzero(truth.phase_deg(dense) <= -90.0)[0]],
        float(-np.diff(truth.phase_deg(np.array([49.9, 50.1])))[0]) / 0.2 / 360.0,
    )
    readings = (
        bandwidth(curve, reference_hz=10.0),
        quarter_turn(curve),
        group_delay(curve, frequency_hz=50.0),
    )
    for one, true in zip(readings, expected, strict=True):
        assert one is not None
        found.append((one.value - true) / one.uncertainty)
    return found


def main() -> None:
    found = list(cases())
    PICTURE.write_bytes(image(picture(found), "png"))
    sys.stdout.write("\n".join((*table(found), "", *honesty(UNITS), "")))


if __name__ == "__main__":
    main()
