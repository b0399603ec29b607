"""The table of steps: what was asked for and read back, what was kept and dropped, the mean output."""

import math
from collections.abc import Iterator

import numpy as np

from gyrotest.procedures.dwells import DwellRecord
from gyrotest.procedures.wording import ending, places_of, plain
from gyrotest.records.figure import Figure
from gyrotest.records.table import Cell, Column, Table
from gyrotest.units import printed_unit

STEP_COLUMNS = (
    Column(heading="Step", share=16),
    Column(heading="Rate / (°/s)", share=13, numbers=True),
    Column(heading="Read back", share=13, numbers=True),
    Column(heading="Mean output", share=18, numbers=True),
    Column(heading="Kept", share=10, numbers=True),
    Column(heading="Dropped", share=10, numbers=True),
    Column(heading="Settling", share=11, numbers=True),
)
_READ_BACK_PLACES = 4
_MINUS = "\N{MINUS SIGN}"


def steps_figure(records: tuple[DwellRecord, ...]) -> Figure:
    """Return the table of steps as a figure of its own."""
    places = mean_places(records)
    table = Table(
        title="Steps",
        note=output_words(records),
        columns=STEP_COLUMNS,
        rows=tuple(step_cells(one, places) for one in records),
    )
    return Figure(
        name="steps", title="Steps", panels=(), table=table, alt=f"Table of {len(records)} steps"
    )


def step_cells(record: DwellRecord, places: int) -> tuple[Cell, ...]:
    """Return a step's row, its mean to so many places; its saturated samples are told where they are kept."""
    dwell = record.dwell
    read_back = dwell.measured_rate_dps
    unit = printed_unit(record.scaling.unit)
    return (
        Cell(text=dwell.name),
        Cell(text=signed(record.rate_dps, 6)),
        Cell(text="–" if read_back is None else ending(read_back, _READ_BACK_PLACES)),
        Cell(text=f"{ending(record.mean, places)} {unit}" if record.kept else "–"),
        Cell(text=str(record.kept)),
        Cell(text=str(record.dropped)),
        Cell(text=f"{plain(dwell.settling_s, 3)} s"),
    )


def output_words(records: tuple[DwellRecord, ...]) -> str:
    """Say what the mean outputs are less, where they are not as the source indicates them."""
    scaling = records[0].scaling
    if scaling.zero == 0.0:
        return ""
    zero = f"{signed(scaling.zero, 6)} {printed_unit(scaling.unit)}"
    return f"mean output less the nominal one at rest, {zero}"


def mean_places(records: tuple[DwellRecord, ...]) -> int:
    """Return the places that the steps' means are told to: two digits of what their scatter leaves."""
    scatter = [float(one.output.std()) / math.sqrt(one.kept) for one in records if one.kept]
    return places_of(float(np.median(scatter)))


def signed(value: float, digits: int) -> str:
    """Return a number in plain digits with a true minus."""
    return plain(value, digits).replace("-", _MINUS)


def dropped_samples(records: tuple[DwellRecord, ...]) -> Iterator[str]:
    """Say how many samples were outliers or are missing, where some were or are."""
    dropped, missing = sum(one.dropped for one in records), sum(one.missing for one in records)
    total = sum(one.dwell.samples for one in records)
    if dropped:
        steps = sum(one.dropped > 0 for one in records)
        yield f"Outliers: {dropped} of {total} samples dropped, in {steps} of {len(records)} steps."
    if missing:
        yield f"{missing} of {total} samples are missing; the means are of the others."
