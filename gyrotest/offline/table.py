"""Analyses as tables for a terminal."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from gyrotest.certificate.numbers import plain, printed, significant
from gyrotest.offline.analysis import Analysis
from gyrotest.offline.readings import Reading, readings
from gyrotest.procedures.wording import engineering
from gyrotest.units import printed_unit

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table


_LABEL = 20  # columns to which names of values are wrapped on a narrow terminal
_ENDLESS = 500


def tables(console: "Console", analyses: Sequence[Analysis]) -> str:
    """Return a heading, a table and the remarks of each analysis, as the console would show them."""
    from rich.padding import Padding
    from rich.text import Text

    with console.capture() as shown:
        for analysis in analyses:
            console.print(Text(_heading(analysis), style="bold"), soft_wrap=True)
            console.print(Text(f"  {_extent(analysis)}"), soft_wrap=True)
            console.print(Text(f"  {_mean(analysis)}"), soft_wrap=True)
            _print(console, _table(analysis))
            for remark in (fit_quality(analysis), *analysis.remarks):
                console.print(Padding(Text(f"• {remark}"), (0, 0, 0, 2)))
            console.print()
    return "".join(f"{line.rstrip()}\n" for line in shown.get().splitlines())


def _print(console: "Console", table: "Table") -> None:
    """Print a table; where a terminal is too narrow, its lines are too long rather than its numbers cut."""
    options = console.options.update(max_width=_ENDLESS)
    needed = console.measure(table, options=options).maximum
    shown = console.width
    if needed > shown:
        longest = max(len(str(cell)) for cell in table.columns[0].cells)
        console.width = max(shown, needed - longest + _LABEL)
    console.print(table)
    console.width = shown


def _heading(analysis: Analysis) -> str:
    source = analysis.source
    return f"{source.path}: {source.name}" if source.name else str(source.path)


def duration(seconds: float) -> str:
    """A duration in the unit in which it is a number of ordinary size: `20 h`."""
    for length, unit in ((3600.0, "h"), (60.0, "min")):
        if seconds >= 2.0 * length:
            return f"{significant(seconds / length, digits=4)} {unit}"
    return f"{significant(seconds, digits=4)} s"


def fit_quality(analysis: Analysis) -> str:
    """How well the noise model describes the record, in a line."""
    model = analysis.model
    return (
        f"Fitted over τ = {_seconds(model.first_tau_s)} … {_seconds(model.last_tau_s)} s:"
        f" χ²/ν = {significant(model.misfit, digits=2)}; by chance alone"
        f" {significant(100.0 * model.fit_probability, digits=2)} % of records fit no better."
    )


def _extent(analysis: Analysis) -> str:
    rate = engineering(1.0 / analysis.interval_s, "Hz", 6)
    begin = f", from {duration(analysis.begin_s)} on" if analysis.begin_s > 0.0 else ""
    return f"{plain(analysis.samples)} samples at {rate}, {duration(analysis.duration_s)}{begin}"


def _mean(analysis: Analysis) -> str:
    from gyrotest.analysis.interval import NORMAL_95

    shown = printed(analysis.mean_dps, uncertainty=NORMAL_95 * analysis.mean_standard_uncertainty_dps)
    stated = analysis.datasheet.get("bias")
    beside = f"; datasheet {plain(stated.to('deg/s'))} °/s" if stated else ""
    return f"mean {shown.value} °/s ± {shown.uncertainty} °/s{beside}"


def _table(analysis: Analysis) -> "Table":
    from rich import box
    from rich.table import Table

    rows = readings(analysis)
    compared = any(row.datasheet is not None for row in rows)
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1), header_style="")
    table.add_column("", min_width=_LABEL)
    table.add_column("value", justify="right", no_wrap=True)
    for heading in ("95 % interval", "", "carried by τ"):
        table.add_column(heading, no_wrap=True)
    if compared:
        table.add_column("datasheet", justify="right", no_wrap=True)
        table.add_column("ratio", justify="right", no_wrap=True)
    for row in rows:
        cells = (row.label, *_value(row), printed_unit(row.unit), _tau(row))
        table.add_row(*(cells + _beside(row) if compared else cells))
    return table


def _value(row: Reading) -> tuple[str, str]:
    if row.value is None:
        return "—", row.note
    if row.at_most:
        return f"≤ {significant(row.value, digits=3)}", row.note
    shown = printed(row.value, lower=row.lower_95, upper=row.upper_95)
    return shown.value, f"{shown.lower} … {shown.upper}"


def _tau(row: Reading) -> str:
    if row.tau_s is not None:
        return f"at {_seconds(row.tau_s)} s"
    if row.carries is None:
        return ""
    return f"{_seconds(row.carries.first_s)} … {_seconds(row.carries.last_s)} s"


def _seconds(tau_s: float) -> str:
    return significant(tau_s, digits=3)


def _beside(row: Reading) -> tuple[str, str]:
    if row.datasheet is None:
        return "", ""
    ratio = "" if row.ratio is None else f"{'≤ ' * row.at_most}{significant(row.ratio, digits=3)}"
    return plain(row.datasheet, digits=4), ratio
