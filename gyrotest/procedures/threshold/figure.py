"""The figure: how much of each change the output followed, up and down, with uncertainty bars."""

from gyrotest.analysis.small_steps import HALF, Followed, Level, smallest_followed
from gyrotest.procedures.threshold.levels import Levels
from gyrotest.procedures.threshold.results import Kind
from gyrotest.procedures.wording import ending, places_of, plain, rate_text
from gyrotest.records.figure import Curve, Figure, Panel, Points, Role, Scale
from gyrotest.records.table import Cell, Column, Table

_MARGIN = 1.3
_APART = 1.02  # by which factor the points of changes up and down stand apart
_WORDS = {Followed.YES: "followed", Followed.NO: "not followed", Followed.UNDECIDED: "undecided"}
_COLUMNS = (
    Column(heading="Change / (°/s)", share=20),
    Column(heading="Up / %", share=20, numbers=True),
    Column(heading="Down / %", share=20, numbers=True),
    Column(heading="95 % half-width / %", share=22, numbers=True),
    Column(heading="Finding", share=18),
)


def small_step_figure(found: Levels, kind: Kind) -> Figure:
    """Draw the responses over the sizes of the changes."""
    levels = found.levels
    ends = (levels[0].size_dps / _MARGIN, levels[-1].size_dps * _MARGIN)
    smallest = smallest_followed(levels).place
    reached = (
        "none is followed for certain"
        if smallest is None
        else f"smallest followed: {rate_text(levels[smallest].size_dps, 3)}"
    )
    return Figure(
        name=f"{kind.name}_steps",
        title=f"{kind.label}: response to small changes",
        panels=(
            Panel(
                y_label="Response / %",
                x_label="Change of the rate / (°/s)",
                x_scale=Scale.LOG,
                height=1.3,
                curves=(
                    Curve(x=ends, y=(100.0 * HALF,) * 2, role=Role.LIMIT, label="half"),
                    Curve(x=ends, y=(100.0, 100.0), role=Role.GUIDE),
                ),
                points=(_side(levels, up=True), _side(levels, up=False)),
                legend=True,
            ),
        ),
        note=reached,
        caption="Mean change of the output over what the nominal scale factor promises; bars: 95 %. A change is"
        " followed where both bars lie above one half; all larger ones must be as well.",
        alt=f"Response to {len(levels)} sizes of change, {reached}",
        table=_table(levels),
    )


def _side(levels: tuple[Level, ...], *, up: bool) -> Points:
    responses = [one.up if up else one.down for one in levels]
    factor = 1.0 / _APART if up else _APART
    return Points(
        x=tuple(one.size_dps * factor for one in levels),
        y=tuple(one.share * 100.0 for one in responses),
        u=tuple(one.half_width * 100.0 for one in responses),
        label="up" if up else "down",
        series=0 if up else 1,
    )


def _table(levels: tuple[Level, ...]) -> Table:
    return Table(title="Changes", columns=_COLUMNS, rows=tuple(_row(one) for one in levels))


def _row(level: Level) -> tuple[Cell, ...]:
    widest = max(level.up.half_width, level.down.half_width) * 100.0
    return (
        Cell(text=plain(level.size_dps, 4)),
        *(Cell(text=ending(one.share * 100.0, places_of(widest))) for one in (level.up, level.down)),
        Cell(text=plain(widest, 2)),
        Cell(text=_WORDS[level.followed]),
    )
