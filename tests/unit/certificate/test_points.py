"""Single points: each series its own shape, bars of uncertainty, a frame and ticks that fit them."""

import dataclasses
import io
import xml.etree.ElementTree as ET

import matplotlib.figure
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.text import Annotation

from gyrotest.certificate.figures import draw, image, svg
from gyrotest.certificate.style import marker_of, styled
from gyrotest.records.figure import Curve, Figure, Panel, Points, Role, Scale
from tests.unit.certificate import bench_records

SVG = "{http://www.w3.org/2000/svg}"
values = st.floats(min_value=-1e6, max_value=1e6, allow_subnormal=False)


def one(*points: Points, curves: tuple[Curve, ...] = (), scale: Scale = Scale.LINEAR) -> Figure:
    panel = Panel(y_label="y", points=points, curves=curves, y_scale=scale)
    return Figure(name="x", title="x", panels=(panel,))


def counted(count: int) -> Points:
    return Points(x=tuple(float(n) for n in range(1, count + 1)), y=(1.0,) * count)


def drawn(figure: Figure) -> matplotlib.figure.Figure:
    paper = draw(figure)
    with styled():
        paper.savefig(io.BytesIO(), format="svg")  # puts the labels of the axes in their places
    return paper


def test_each_series_has_a_shape_and_a_filling_of_its_own() -> None:
    markers = [marker_of(series) for series in range(5)]
    assert len({(marker.shape, marker.filled) for marker in markers}) == 5


def test_bars_reach_as_far_as_the_uncertainty() -> None:
    axes = draw(one(Points(x=(1.0, 2.0), y=(10.0, 20.0), u=(3.0, 4.0)))).axes[0]
    bars = np.asarray(axes.lines[0].get_xydata())
    assert bars[0].tolist() == [1.0, 7.0]
    assert bars[1].tolist() == [1.0, 13.0]
    assert np.isnan(bars[2, 1])
    low, high = axes.get_ylim()
    assert low < 7.0
    assert high > 24.0


def test_points_without_uncertainty_have_no_bars() -> None:
    lines = draw(one(counted(3))).axes[0].lines
    assert [line.get_marker() for line in lines if line.get_marker() != "None"] == ["o"]
    assert not any(np.isnan(np.asarray(line.get_xydata())).any() for line in lines[:1])


@pytest.mark.parametrize("count", [1, 2, 3, 5, 7, 12, 30])
def test_axis_of_power_cycles_has_whole_numbers(count: int) -> None:
    axes = draw(one(counted(count))).axes[0]
    low, high = axes.get_xlim()
    shown = [tick for tick in axes.xaxis.get_majorticklocs() if low <= tick <= high]
    assert shown
    assert all(float(tick).is_integer() for tick in shown)
    labels = axes.xaxis.get_major_formatter().format_ticks(shown)
    assert labels == [f"{tick:.0f}" for tick in shown]
    if count <= 7:
        assert shown == list(range(1, count + 1))


def test_points_stand_clear_of_the_frame() -> None:
    axes = draw(one(Points(x=(-80.0, 0.5, 80.0), y=(0.0, 1.0, 2.0)))).axes[0]
    low, high = axes.get_xlim()
    assert low <= -86.0
    assert high >= 86.0


def test_limits_run_from_frame_to_frame_beside_points() -> None:
    limit = Curve(x=(1.0, 3.0), y=(2.0, 2.0), role=Role.LIMIT, label="limit")
    axes = draw(one(counted(3), curves=(limit,))).axes[0]
    level = next(line for line in axes.lines if line.get_color() == "#c1272d")
    box = level.get_window_extent()
    frame = axes.get_window_extent()
    assert (box.x0, box.x1) == pytest.approx((frame.x0, frame.x1))


def test_names_of_points_stand_in_a_legend_clear_of_points_and_limits() -> None:
    paper = drawn(bench_records.residuals())
    axes = paper.axes[0]
    texts = [text for text in axes.texts if isinstance(text, Annotation) and text.get_text()]
    boxes = {text.get_text(): text.get_window_extent() for text in texts}
    assert {"forwards", "backwards", "limit 150 ppm"} == set(boxes)
    every = list(boxes.values())
    assert not any(a.overlaps(b) for n, a in enumerate(every) for b in every[n + 1 :])
    places = np.vstack(
        [
            axes.transData.transform(np.column_stack((p.x, p.y)))
            for p in bench_records.residuals().panels[0].points
        ]
    )
    assert all(box.count_contains(places) == 0 for box in every)
    level = axes.transData.transform((0.0, 150.0))[1]
    assert not any(box.y0 < level < box.y1 for box in every)


def test_a_panel_does_not_name_again_what_one_above_has_named() -> None:
    figure = bench_records.residuals()
    upper = figure.panels[0]
    lower = dataclasses.replace(upper, points=(*upper.points, Points(x=(1.0,), y=(1.0,), label="rest")))
    paper = drawn(dataclasses.replace(figure, panels=(upper, lower)))
    texts = [[text.get_text() for text in axes.texts if text.get_text()] for axes in paper.axes]
    assert {"forwards", "backwards"} <= set(texts[0])
    assert set(texts[1]) == {"rest", "limit 150 ppm"}


def test_points_of_two_series_on_one_place_are_both_seen() -> None:
    same = Points(x=(1.0,), y=(1.0,))
    other = Points(x=(1.0,), y=(1.0,), series=1)
    first, second = (
        line for line in draw(one(same, other)).axes[0].lines if line.get_marker() in {"o", "s"}
    )
    assert second.get_markerfacecolor() == "none"
    assert second.get_markersize() > first.get_markersize()


@settings(deadline=None, max_examples=20)
@given(
    st.lists(st.tuples(values, values, st.floats(0.0, 1e6)), min_size=1, max_size=12),
    st.sampled_from(Scale),
)
def test_any_points_give_well_formed_svg(rows: list[tuple[float, float, float]], scale: Scale) -> None:
    x, y, u = (tuple(column) for column in zip(*rows, strict=True))
    assert ET.fromstring(svg(one(Points(x=x, y=y, u=u, label="a"), scale=scale))).tag == f"{SVG}svg"


@pytest.mark.parametrize("scale", list(Scale))
def test_no_points_at_all_are_drawn_too(scale: Scale) -> None:
    ET.fromstring(svg(one(Points(x=(), y=(), label="none"), scale=scale)))


def test_same_points_give_the_same_bytes() -> None:
    figure = bench_records.cycles()
    assert image(figure, "svg") == image(figure, "svg")


@pytest.mark.parametrize(
    ("ends", "whole"), [((1.0, 5.0), True), ((1.0, 3.0), True), ((1.9, 2.1), False)]
)
def test_a_limit_of_a_few_points_is_drawn_at_these_alone(ends: tuple[float, float], whole: bool) -> None:
    limit = Curve(x=ends, y=(2.0, 2.0), role=Role.LIMIT)
    lines = draw(one(counted(5), curves=(limit,))).axes[0].lines
    (drawn_limit,) = [line for line in lines if np.asarray(line.get_ydata()).tolist() == [2.0, 2.0]]
    assert np.asarray(drawn_limit.get_xdata()).tolist() == ([0.0, 1.0] if whole else list(ends))
