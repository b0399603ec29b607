"""The record over time as a min–max band with its means, and the histogram of its residuals."""

import math

import numpy as np
from numpy.typing import NDArray

from gyrotest.procedures.drawn_units import Unit, rate_unit, time_unit
from gyrotest.procedures.rest.record import RestRecord
from gyrotest.procedures.static.bins import MOST_BINS, Bins, binned, drawn
from gyrotest.procedures.wording import engineering, plain
from gyrotest.records.figure import Band, Bars, Curve, Figure, Panel, Role, Width

_MEAN_S = 60.0
_HISTOGRAM_BINS = 36
_MEANS_HEIGHT = 0.7
_TEMPERATURE_HEIGHT = 0.5
_TEMPERATURES = 300
_HISTOGRAM_HEIGHT = 1.79  # that of the record's panels and the space between them
_MORE_HEIGHT = 0.59  # with a panel of the temperature
_BLOCK = 65536


def record_figure(record: RestRecord) -> Figure:
    """Draw the rate over time: a band that hides no sample, and below it means that show drift."""
    bins = binned(record.rate_dps, math.ceil(record.rate_dps.size / MOST_BINS))
    bound = float(max(abs(bins.lowest.min()), abs(bins.highest.max())))
    rate, time = rate_unit(bound), time_unit(record.begin_s + record.duration_s)
    mean = float(record.rate_dps.mean())
    panels = (
        _band_panel(record, bins, rate, time),
        *_mean_panels(record, rate, time, mean),
        *_temperature_panels(record, time),
    )
    shown = (
        "the samples" if bins.size == 1 else f"shaded: minimum to maximum of every {bins.size} samples"
    )
    return Figure(
        name="record",
        title="Rate record",
        width=Width.WIDE,
        panels=panels,
        note=_record_note(record),
        caption=f"Output rate; {shown} (none hidden); line: their mean."
        + (
            f" Below: means of {plain(_panel_mean_s(record), 6)} s; dotted: mean of the record."
            if record.rate_dps.size >= 2 * _panel_mean_samples(record) >= 4
            else ""
        )
        + (" Bottom: temperature, recorded beside." if record.temperature_degc is not None else ""),
        alt=f"Rate over {plain(record.duration_s, 6)} s between {plain(float(bins.lowest.min()), 4)} and"
        f" {plain(float(bins.highest.max()), 4)} °/s, mean {plain(mean, 5)} °/s",
    )


def _record_note(record: RestRecord) -> str:
    parts = [
        f"{record.rate_dps.size:,} samples".replace(",", "\N{NARROW NO-BREAK SPACE}"),
        f"every {engineering(record.interval_s, 's', 4)}",
        f"{record.missing} missing",
    ]
    return ", ".join([*parts, record.condition] if record.condition else parts)


def _band_panel(record: RestRecord, bins: Bins, rate: Unit, time: Unit) -> Panel:
    middle = _middles(record, bins.mean.size, bins.size)
    x = drawn(middle, time)
    band = Band(x=x, lower=drawn(bins.lowest, rate), upper=drawn(bins.highest, rate))
    return Panel(
        y_label=f"Rate / ({rate.name})",
        x_label=f"Time / {time.name}",
        bands=(band,) if bins.size > 1 else (),
        curves=(Curve(x=x, y=drawn(bins.mean, rate), role=Role.MEAN),),
    )


def _middles(record: RestRecord, count: int, size: int) -> NDArray[np.float64]:
    """Return the times at which consecutive runs of `size` samples have their middle."""
    runs = np.arange(count, dtype=np.float64)
    return np.asarray(record.begin_s + (runs + 0.5) * size * record.interval_s, dtype=np.float64)


def _panel_mean_s(record: RestRecord) -> float:
    """Return 60 s, or longer means where that would be more than the bins of a page."""
    intervals = max(round(_MEAN_S / record.interval_s), 1)
    bins = record.rate_dps.size // intervals
    return intervals * record.interval_s * max(math.ceil(bins / MOST_BINS), 1)


def _panel_mean_samples(record: RestRecord) -> int:
    return round(_panel_mean_s(record) / record.interval_s)


def _temperature_panels(record: RestRecord, time: Unit) -> tuple[Panel, ...]:
    """Draw what was recorded beside: means of runs, of the readings that are there."""
    if record.temperature_degc is None:
        return ()
    size = math.ceil(record.temperature_degc.size / _TEMPERATURES)
    there = np.isfinite(record.temperature_degc)
    starts = np.arange(0, there.size, size)
    counts = np.add.reduceat(there.astype(np.int64), starts)
    sums = np.add.reduceat(np.where(there, record.temperature_degc, 0.0), starts)
    x = _middles(record, starts.size, size)[counts > 0]
    y = (sums[counts > 0] / counts[counts > 0]).tolist()
    panel = Panel(
        y_label="Temp. / °C",
        x_label=f"Time / {time.name}",
        height=_TEMPERATURE_HEIGHT,
        curves=(Curve(x=drawn(x, time), y=tuple(y), role=Role.DATA),),
    )
    return (panel,)


def _mean_panels(record: RestRecord, rate: Unit, time: Unit, mean: float) -> tuple[Panel, ...]:
    mean_s, size = _panel_mean_s(record), _panel_mean_samples(record)
    if size < 2 or record.rate_dps.size < 2 * size:
        return ()
    count = record.rate_dps.size // size
    means = record.rate_dps[: count * size].reshape(count, size).mean(axis=1)
    x = drawn(_middles(record, count, size), time)
    panel = Panel(
        y_label=f"{plain(mean_s, 4)} s mean / ({rate.name})",
        x_label=f"Time / {time.name}",
        height=_MEANS_HEIGHT,
        curves=(
            Curve(x=x, y=drawn(means, rate), role=Role.DATA),
            Curve(x=(x[0], x[-1]), y=(mean * rate.factor,) * 2, role=Role.GUIDE),
        ),
    )
    return (panel,)


def histogram_figure(record: RestRecord) -> Figure:
    """Draw the distribution of the rates about their mean beside a normal one."""
    mean, deviation = float(record.rate_dps.mean()), float(record.rate_dps.std(ddof=1))
    unit = rate_unit(4.0 * deviation)
    half = max(abs(float(record.rate_dps.max()) - mean), abs(float(record.rate_dps.min()) - mean))
    edges = _edges(record, mean, half)
    heights = _densities(record.rate_dps, mean, edges) / unit.factor
    grid = np.linspace(-half, half, 121)
    normal = (
        np.exp(-0.5 * (grid / deviation) ** 2) / (deviation * math.sqrt(2.0 * math.pi)) / unit.factor
    )
    sigma = f"σ = {plain(deviation * unit.factor, 4)} {unit.name}"
    return Figure(
        name="residuals",
        title="Residual histogram",
        width=Width.NARROW,
        panels=(
            Panel(
                y_label=f"Density / ({unit.name})⁻¹",
                x_label=f"Residual / ({unit.name})",
                height=_HISTOGRAM_HEIGHT + (0.0 if record.temperature_degc is None else _MORE_HEIGHT),
                bars=Bars(edges=drawn(edges, unit), heights=tuple(heights.tolist())),
                curves=(Curve(x=drawn(grid, unit), y=tuple(normal.tolist()), role=Role.MODEL),),
                note=sigma,
            ),
        ),
        caption="Samples less their mean; curve: normal distribution of the same σ.",
        alt=f"Histogram of the residuals, {sigma}",
    )


def _edges(record: RestRecord, mean: float, half: float) -> NDArray[np.float64]:
    """Return the bins' edges: of a digitised record each bin holds as many steps, or it would look like a comb."""
    if record.step_dps is None:
        return np.linspace(-half, half, _HISTOGRAM_BINS + 1)
    steps = max(math.ceil(2.0 * half / record.step_dps / _HISTOGRAM_BINS), 1)
    width = steps * record.step_dps
    between = float(record.rate_dps[0]) - mean - 0.5 * record.step_dps
    first = math.floor((-half - between) / width)
    count = math.floor((half - between) / width) - first + 1
    return np.asarray(between + width * np.arange(first, first + count + 1), dtype=np.float64)


def _densities(
    rate: NDArray[np.float64], mean: float, edges: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Count block by block: a histogram of the whole would copy the record."""
    counts = np.zeros(edges.size - 1)
    for begin in range(0, rate.size, _BLOCK):
        counts += np.histogram(rate[begin : begin + _BLOCK] - mean, bins=edges)[0]
    density: NDArray[np.float64] = counts / (rate.size * (edges[1] - edges[0]))
    return density
