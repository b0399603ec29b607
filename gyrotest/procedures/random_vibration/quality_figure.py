"""How well the response is known: the coherence, and how far the other estimators are from Hv."""

import numpy as np
from numpy.typing import NDArray

from gyrotest.procedures.random_vibration.measured import MeasuredResponse
from gyrotest.procedures.random_vibration.parameters import RandomVibrationParameters
from gyrotest.procedures.random_vibration.stretches import thinned
from gyrotest.procedures.wording import plain
from gyrotest.records.figure import Curve, Figure, Panel, Role, Scale, Width
from gyrotest.records.plan import Context

_LINES = 200
_Array = NDArray[np.float64]


def quality_figure(measured: MeasuredResponse, context: Context) -> Figure:
    """Draw coherence, and H1 and H2 less Hv."""
    lowest = float(measured.response.coherence.min())
    return Figure(
        name="coherence",
        title="Coherence and estimators",
        width=Width.HALF,
        panels=(_coherence_panel(measured, context), _estimator_panel(measured)),
        note=_ratio_words(measured),
        caption="Top: coherence of encoder and output, all runs together; dashed: the floor below which"
        " frequencies are left out. Bottom: what estimators give instead that take all noise to be on the output"
        " (H1) or on the encoder (H2).",
        alt=f"Coherence over frequency, {plain(lowest, 3)} at least",
    )


def _ratio_words(measured: MeasuredResponse) -> str:
    """Say what the ratio of the noises at rest is."""
    kappa = measured.noise.at(measured.response.frequency_hz)
    if not np.isfinite(kappa).all():
        return "κ infinite: no noise of the encoder"
    low, high = (plain(float(one), 2) for one in (kappa.min(), kappa.max()))
    return f"κ at rest {low}" if low == high else f"κ at rest {low} … {high}"


def _coherence_panel(measured: MeasuredResponse, context: Context) -> Panel:
    parameters: RandomVibrationParameters = context.parameters
    x, floor = measured.response.frequency_hz, parameters.coherence_floor
    low = min(floor, float(measured.response.coherence.min()))
    margin = 0.05 * (1.0 - low)
    return Panel(
        y_label="Coherence γ²",
        x_scale=Scale.LOG,
        y_range=(max(low - margin, 0.0), 1.0 + margin),
        curves=(
            _curve(x, measured.response.coherence, 0),
            Curve(x=(float(x[0]), float(x[-1])), y=(floor, floor), role=Role.LIMIT, label="floor"),
        ),
    )


def _estimator_panel(measured: MeasuredResponse) -> Panel:
    x, own = measured.response.frequency_hz, measured.response.gain
    others = (("H1", measured.output_noise.gain), ("H2", measured.reference_noise.gain))
    return Panel(
        y_label="Less Hv / %",
        x_label="Frequency / Hz",
        x_scale=Scale.LOG,
        curves=tuple(
            _curve(x, 100.0 * (gain / own - 1.0), series, label)
            for series, (label, gain) in enumerate(others)
        ),
        legend=True,
    )


def _curve(x: _Array, y: _Array, series: int, label: str = "") -> Curve:
    return Curve(
        x=tuple(thinned(x, _LINES).tolist()),
        y=tuple(thinned(y, _LINES).tolist()),
        label=label,
        series=series,
    )
