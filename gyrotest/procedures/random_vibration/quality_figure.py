"""How well the response is known: the coherence, and how far the other estimators are from Hv."""

import numpy as np
from numpy.typing import NDArray

from gyrotest.procedures.random_vibration.least_coherence import coherence_text
from gyrotest.procedures.random_vibration.measured import MeasuredResponse
from gyrotest.procedures.random_vibration.parameters import RandomVibrationParameters
from gyrotest.procedures.random_vibration.stretches import log_bins
from gyrotest.procedures.wording import plain
from gyrotest.records.figure import Curve, Figure, Panel, Role, Scale, Width
from gyrotest.records.plan import Context

_LINES = 120
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_Array = NDArray[np.float64]


def quality_figure(measured: MeasuredResponse, context: Context) -> Figure:
    """Draw coherence, and H1 and H2 less Hv."""
    lowest = float(measured.response.coherence.min())
    return Figure(
        name="coherence",
        title="Coherence",
        width=Width.HALF,
        panels=(_coherence_panel(measured, context), _estimator_panel(measured)),
        note=f"least {coherence_text(lowest)}",
        caption="Top: coherence of encoder and output, all runs together; dashed: the floor below which"
        " frequencies are left out. Bottom: what estimators give instead that take all noise to be on the output"
        f" (H1) or on the encoder (H2). {_ratio_words(measured)}",
        alt=f"Coherence over frequency, {coherence_text(lowest)} at least",
    )


def _ratio_words(measured: MeasuredResponse) -> str:
    """Say what the ratio of the noises at rest is."""
    kappa = measured.noise.at(measured.response.frequency_hz)
    if not np.isfinite(kappa).all():
        return "At rest the encoder has no noise."
    low, high = (_round_number(float(one)) for one in (kappa.min(), kappa.max()))
    span = low if low == high else f"{low} … {high}"
    return f"Power of the output's noise at rest over that of the encoder's rate: κ = {span}."


def _round_number(value: float) -> str:
    """Return two digits, with a power of ten where they are far from the point."""
    if 1e-3 <= value < 1e5 or value == 0.0:
        return plain(value, 2)
    digits, power = f"{value:.1e}".split("e")
    return f"{digits}·10{str(int(power)).translate(_SUPERSCRIPTS)}"


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
