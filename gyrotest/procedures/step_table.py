"""The table of steps: what was asked for and read back, what was kept and dropped, the mean output."""

from collections.abc import Iterator

from gyrotest.procedures.dwells import DwellRecord
from gyrotest.procedures.wording import plain
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
_MINUS = "\N{MINUS SIGN}"


def steps_figure(records: tuple[DwellRecord, ...]) -> Figure:
    """Return the table of steps as a figure of its own."""
    table = Table(title="Steps", columns=STEP_COLUMNS, rows=tuple(step_cells(one) for one in records))
    return Figure(
        name="steps", title="Steps", panels=(), table=table, alt=f"Table of {len(records)} steps"
    )


def step_cells(record: DwellRecord) -> tuple[Cell, ...]:
    """Return a step's row; its saturated samples are told where they are kept."""
    dwell = record.dwell
    read_back = dwell.measured_rate_dps
    unit = printed_unit(record.scaling.unit)
    return (
        Cell(text=dwell.name),
        Cell(text=signed(record.rate_dps, 6)),
        Cell(text="–" if read_back is None else signed(read_back, 6)),
        Cell(text=f"{signed(record.mean, 7)} {unit}" if record.kept else "–"),
        Cell(text=str(record.kept)),
        Cell(text=str(record.dropped)),
        Cell(text=f"{plain(dwell.settling_s, 3)} s"),
    )


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
