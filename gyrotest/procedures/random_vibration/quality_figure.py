"""How well the response is known: the coherence, and how far the other estimators are from Hv."""

import numpy as np
from numpy.typing import NDArray

from gyrotest.procedures.random_vibration.measured import MeasuredResponse
from gyrotest.procedures.random_vibration.parameters import RandomVibrationParameters
from gyrotest.procedures.random_vibration.stretches import log_bins
from gyrotest.procedures.wording import plain
from gyrotest.records.figure import Curve, Figure, Panel, Role, Scale, Width
from gyrotest.records.plan import Context

_LINES = 120
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
    """Draw the coherence; of neighbouring frequencies the least."""
    parameters: RandomVibrationParameters = context.parameters
    x, floor = measured.response.frequency_hz, parameters.coherence_floor
    bins, least = log_bins(x, _LINES), float(measured.response.coherence.min())
    low = min(floor, least)
    margin = 0.05 * (1.0 - low)
    return Panel(
        y_label="Coherence γ²",
        x_scale=Scale.LOG,
        y_range=(max(low - margin, 0.0), 1.0 + margin),
        curves=(
            Curve(x=_drawn(bins.frequency_hz), y=_drawn(bins.least(measured.response.coherence))),
            Curve(x=(float(x[0]), float(x[-1])), y=(floor, floor), role=Role.LIMIT, label="floor"),
        ),
    )


def _estimator_panel(measured: MeasuredResponse) -> Panel:
    """Draw the estimators where the frequencies count."""
    used = ~np.isin(measured.response.frequency_hz, measured.curve.excluded_hz)
    bins, own = log_bins(measured.response.frequency_hz[used], _LINES), measured.response.gain[used]
    others = (("H1", measured.output_noise.gain), ("H2", measured.reference_noise.gain))
    return Panel(
        y_label="Less Hv / %",
        x_label="Frequency / Hz",
        x_scale=Scale.LOG,
        curves=tuple(
            Curve(
                x=_drawn(bins.frequency_hz),
                y=_drawn(bins.means(100.0 * (gain[used] / own - 1.0))),
                label=label,
                series=series,
            )
            for series, (label, gain) in enumerate(others)
        ),
        legend=True,
    )


def _drawn(values: _Array) -> tuple[float, ...]:
    return tuple(values.tolist())
