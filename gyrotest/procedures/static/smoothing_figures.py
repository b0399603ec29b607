"""The record smoothed over each time side by side: the longer the smoothing, the smaller the figure."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.procedures.drawn_units import Unit, rate_unit, time_unit
from gyrotest.procedures.rest.record import RestRecord
from gyrotest.procedures.static.bins import MOST_BINS, Bins, binned, drawn
from gyrotest.procedures.static.parameters import StaticParameters, stability_name
from gyrotest.procedures.wording import plain
from gyrotest.records.figure import Band, Curve, Figure, Panel, Role, Width
from gyrotest.records.result import Result
from gyrotest.units import Quantity, conversion_factor

_ABREAST = 3
_HEIGHT = 1.1
_ROOM = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class _Smoothed:
    """Averages (n,) over a time, the first of which begins `begin_s` after the recording does."""

    smoothing: Quantity
    averages: NDArray[np.float64]
    begin_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class _Scales:
    """The units and the ends of the y axis that all figures share."""

    rate: Unit
    time: Unit
    ends: tuple[float, float]


def smoothing_figures(
    record: RestRecord, parameters: StaticParameters, results: tuple[Result, ...]
) -> tuple[Figure, ...]:
    """Draw the averages of the first three smoothing times on one scale, with their deviations."""
    made = (_smoothed(record, one, parameters) for one in parameters.smoothing[:_ABREAST])
    shown = [one for one in made if one.averages.size > 1]
    if len(shown) < 2:
        return ()
    scales = _scales(max((one.averages for one in shown), key=np.ptp), record)
    found = {one.name: one for one in results}
    return tuple(_figure(one, found.get(stability_name(one.smoothing)), scales) for one in shown)


def _smoothed(record: RestRecord, smoothing: Quantity, parameters: StaticParameters) -> _Smoothed:
    start_s = 0.0 if parameters.start is None else parameters.start.to("s")
    rates = record.since(start_s)
    size = round(smoothing.to("s") / record.interval_s)
    count = rates.size // size
    return _Smoothed(
        smoothing=smoothing,
        averages=np.asarray(rates[: count * size].reshape(count, size).mean(axis=1), dtype=np.float64),
        begin_s=record.begin_s + (record.rate_dps.size - rates.size) * record.interval_s,
    )


def _scales(widest: NDArray[np.float64], record: RestRecord) -> _Scales:
    rate, room = rate_unit(float(np.abs(widest).max())), _ROOM * float(np.ptp(widest))
    return _Scales(
        rate=rate,
        time=time_unit(record.begin_s + record.duration_s),
        ends=((float(widest.min()) - room) * rate.factor, (float(widest.max()) + room) * rate.factor),
    )


def _figure(smoothed: _Smoothed, result: Result | None, scales: _Scales) -> Figure:
    bins = binned(smoothed.averages, math.ceil(smoothed.averages.size / (MOST_BINS // _ABREAST)))
    several = f" (shaded: all of them; line: means of {bins.size})" if bins.size > 1 else ""
    told = (
        f"Averages of {smoothed.smoothing}{several}, on the scale of its neighbours{_deviation(result)}."
    )
    return Figure(
        name=f"smoothed_{str(smoothed.smoothing).replace(' ', '')}",
        title=f"Smoothed, {smoothed.smoothing}",
        width=Width.NARROW,
        panels=(_panel(smoothed, bins, scales),),
        caption=told,
        alt=told,
    )


def _deviation(result: Result | None) -> str:
    if result is None or result.value is None:
        return ""
    return f"; σ = {plain(result.value * conversion_factor(result.unit, 'deg/h'), 4)} °/h"


def _panel(smoothed: _Smoothed, bins: Bins, scales: _Scales) -> Panel:
    middles = (np.arange(bins.mean.size) + 0.5) * bins.size * smoothed.smoothing.to("s")
    x = drawn(np.asarray(smoothed.begin_s + middles, dtype=np.float64), scales.time)
    band = Band(x=x, lower=drawn(bins.lowest, scales.rate), upper=drawn(bins.highest, scales.rate))
    return Panel(
        y_label=f"Rate / ({scales.rate.name})",
        x_label=f"Time / {scales.time.name}",
        height=_HEIGHT,
        y_range=scales.ends,
        bands=(band,) if bins.size > 1 else (),
        curves=(Curve(x=x, y=drawn(bins.mean, scales.rate), role=Role.DATA),),
    )
