"""The figure of a turn: the rate over time, the rests marked, and the angle that it sums up to."""

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.turn import Parts, TurnIntegral
from gyrotest.procedures.scale_factor_recorded.outputs import Outputs
from gyrotest.procedures.scale_factor_recorded.thinning import stretches, thinned
from gyrotest.procedures.wording import plain
from gyrotest.records.figure import Band, Curve, Figure, Panel, Role

_MOST_POINTS = 900


def turn_figure(
    outputs: Outputs, parts: Parts, found: TurnIntegral, slope: float, angle_deg: float
) -> Figure:
    """Draw rate and angle over time."""
    rate = (outputs.values - found.rest_level) / slope
    time_s = (outputs.place - outputs.place[0]) * outputs.interval_s
    turn = slice(parts.begin, parts.end)
    angle = np.cumsum(rate[turn]) * outputs.interval_s
    x, y = thinned(time_s[turn] + outputs.interval_s, angle, most=_MOST_POINTS)
    peak = float(rate[np.argmax(np.abs(rate))])
    return Figure(
        name="turn",
        title="Turn by a known angle",
        panels=(
            Panel(
                y_label="Rate / (°/s)",
                curves=stretches(outputs, rate, role=Role.DATA, most=_MOST_POINTS),
                bands=tuple(_rests(time_s, rate, parts)),
            ),
            Panel(
                y_label="Angle / °",
                x_label="Time / s",
                height=0.7,
                curves=(
                    Curve(x=tuple(x.tolist()), y=tuple(y.tolist()), role=Role.DATA),
                    Curve(
                        x=(float(time_s[0]), float(time_s[-1])),
                        y=(angle_deg, angle_deg),
                        role=Role.GUIDE,
                    ),
                ),
            ),
        ),
        note=f"{parts.end - parts.begin} samples in {plain(found.lasts_s, 4)} s of turning",
        caption="Top: output less that at rest, over the scale factor found; shaded: at rest. Bottom: its"
        " integral; dotted: the angle stated.",
        alt=f"A turn by {plain(angle_deg, 6)}° with a peak of {plain(peak, 4)} °/s".replace(
            "-", "\N{MINUS SIGN}"
        ),
    )


def _rests(time_s: NDArray[np.float64], rate: NDArray[np.float64], parts: Parts) -> list[Band]:
    low, high = float(rate.min()), float(rate.max())
    bands = []
    for part in (slice(0, parts.begin), slice(parts.end, None)):
        times = time_s[part]
        if times.size:
            ends = (float(times[0]), float(times[-1]))
            bands.append(Band(x=ends, lower=(low, low), upper=(high, high), label="at rest"))
    return bands
