"""The table of coefficients: of each mounting, of all together, and of the other method where there is one."""

from collections.abc import Iterator, Mapping

from gyrotest.analysis.mounting import AXES
from gyrotest.procedures.g_sensitivity.measurands import PER_G, coefficient_name, mounted_name
from gyrotest.procedures.g_sensitivity.repeats import Mountings
from gyrotest.procedures.wording import ending, places_of
from gyrotest.records.figure import Figure
from gyrotest.records.result import Result
from gyrotest.records.table import Cell, Column, Table
from gyrotest.units import conversion_factor, printed_unit


def combined_figures(
    found: Mountings, results: tuple[Result, ...], others: Mapping[str, Result], other_name: str
) -> tuple[Figure, ...]:
    """Return the table as a figure of its own; `others` are the other method's coefficients by their axes."""
    by_name = {one.name: one for one in results}
    headings = [f"Mounting {one.number + 1}" for one in found.mountings]
    headings += ["Together"] + ([f"Case {other_name}"] if others else [])
    columns = [Column(heading=f"Coefficient / ({printed_unit(PER_G)})", share=20)]
    for heading in headings:
        columns += [
            Column(heading=heading, share=14, numbers=True),
            Column(heading="U", share=9, numbers=True),
        ]
    rows = []
    for axis in AXES:
        cells = [one.results.get(mounted_name(axis)) for one in found.mountings]
        cells.append(by_name[coefficient_name(axis)])
        cells += [others[axis]] if others else []
        rows.append((Cell(text=f"ζ{axis}"), *(cell for one in cells for cell in _cells(one))))
    return (
        Figure(
            name="coefficients",
            title="Coefficients of the mountings",
            panels=(),
            alt="Table of the coefficients of each mounting and of all together",
            table=Table(
                title="Coefficients of the mountings",
                columns=tuple(columns),
                rows=tuple(rows),
                note="U: expanded uncertainty (95.45 %)",
                sentences=tuple(_sentences(found)),
            ),
        ),
    )


def _cells(one: Result | None) -> tuple[Cell, Cell]:
    """Give a value and its uncertainty, told to the same place."""
    if one is None or one.value is None or one.expanded_uncertainty is None:
        return Cell(text="–"), Cell(text="–")
    factor = conversion_factor(one.unit, PER_G)
    uncertainty = one.expanded_uncertainty * factor
    return (
        Cell(text=ending(one.value * factor, places_of(uncertainty))),
        Cell(text=ending(uncertainty, places_of(uncertainty))),
    )


def _sentences(found: Mountings) -> Iterator[str]:
    for one in found.mountings:
        yield f"Mounting {one.number + 1}: {one.unit.words}, whose coefficient it does not show."
