"""Figures: sensible ticks, nothing outside the frame, texts beside one another."""

import dataclasses
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gyrotest.certificate.axes import axis
from gyrotest.certificate.gauge import gauge
from gyrotest.certificate.labels import Box, Layout, dense
from gyrotest.certificate.plots import svg
from gyrotest.records.figure import Curve, Figure, Mark, Panel, Role, Scale
from tests.unit.certificate import records

values = st.floats(min_value=-1e12, max_value=1e12, allow_subnormal=False)


def linear(*numbers: float) -> list[str]:
    laid = axis(numbers, Scale.LINEAR, begin=0.0, end=460.0, tight=True)
    return [tick.label for tick in laid.ticks]


def test_linear_ticks_are_round_with_equal_decimals_and_the_true_minus() -> None:
    assert linear(0.0, 60.0) == ["0", "10", "20", "30", "40", "50", "60"]
    assert linear(-0.4, 0.2) == ["−0.4", "−0.3", "−0.2", "−0.1", "0.0", "0.1", "0.2"]


def test_numbers_far_from_one_share_a_factor() -> None:
    laid = axis((0.0, 3e-6), Scale.LINEAR, begin=100.0, end=0.0, tight=False)
    assert laid.exponent == -6
    assert [tick.label for tick in laid.ticks] == ["0.0", "0.5", "1.0", "1.5", "2.0", "2.5", "3.0"]


def test_logarithmic_ticks_are_decades_with_a_fine_grid() -> None:
    laid = axis((0.1, 10_000.0), Scale.LOG, begin=0.0, end=460.0, tight=True)
    assert [tick.label for tick in laid.ticks] == ["0.1", "1", "10", "100", "1000", "10\u202f000"]
    assert 0.2 in [round(value, 6) for value in laid.minor]


def test_short_logarithmic_axis_has_labels_within_the_decade() -> None:
    laid = axis((3.0, 70.0), Scale.LOG, begin=0.0, end=460.0, tight=True)
    assert [tick.label for tick in laid.ticks] == ["5", "10", "20", "50"]


@given(st.lists(values, min_size=1, max_size=30), st.sampled_from(Scale), st.booleans())
def test_every_value_lies_on_its_axis_and_ticks_within_it(
    numbers: list[float], scale: Scale, tight: bool
) -> None:
    laid = axis(numbers, scale, begin=10.0, end=300.0, tight=tight)
    shown = [value for value in numbers if scale is Scale.LINEAR or value > 0]
    places = laid.place(shown)
    assert np.all((places >= 10.0 - 1e-6) & (places <= 300.0 + 1e-6))
    slack = 1e-6 * (laid.high - laid.low)
    assert all(laid.low - slack <= tick.value <= laid.high + slack for tick in laid.ticks)
    assert len(laid.ticks) <= 32
    assert len({tick.label for tick in laid.ticks}) == len(laid.ticks)


def test_what_a_logarithm_cannot_show_lies_at_the_low_end() -> None:
    laid = axis((1.0, 10.0), Scale.LOG, begin=100.0, end=0.0, tight=False)
    assert laid.place([0.0, -3.0]).tolist() == [100.0, 100.0]


@pytest.mark.parametrize("number", [0, 1, 2])
def test_figures_are_well_formed_and_drawn_within_their_size(number: int) -> None:
    figure = records.passing().items[0].attempts[0].figures[number]
    root = ET.fromstring(svg(figure))
    _, _, width, height = (float(part) for part in root.attrib["viewBox"].split())
    for path in root.iter("{http://www.w3.org/2000/svg}path"):
        points = re.findall(r"[ML](-?[\d.]+) (-?[\d.]+)", path.attrib["d"])
        assert all(0 <= float(x) <= width and 0 <= float(y) <= height for x, y in points)


def test_roles_have_styles_of_their_own_and_labels_are_escaped() -> None:
    curves = tuple(
        Curve(x=(0.0, 1.0), y=(float(n), float(n)), role=role, label=f"<{role.value}> & more")
        for n, role in enumerate(Role)
    )
    drawn = svg(Figure(name="x", title="x", panels=(Panel(y_label="y", curves=curves),)))
    root = ET.fromstring(drawn)
    texts = [element.text for element in root.iter("{http://www.w3.org/2000/svg}text")]
    assert {f"<{role.value}> & more" for role in Role} <= set(texts)
    lines = [
        (path.attrib["stroke"], path.attrib.get("stroke-dasharray"))
        for path in root.iter("{http://www.w3.org/2000/svg}path")
        if path.attrib.get("stroke-linejoin") == "round"
    ]
    assert len(set(lines)) == len(Role)


def test_noise_floor_far_below_leaves_the_frame_but_is_seen() -> None:
    tau = (1.0, 1000.0)
    curves = (
        Curve(x=tau, y=(100.0, 10.0)),
        Curve(x=tau, y=(0.1, 0.0001), role=Role.FLOOR, label="meter"),
    )
    panel = Panel(y_label="y", x_scale=Scale.LOG, y_scale=Scale.LOG, curves=curves)
    root = ET.fromstring(svg(Figure(name="x", title="x", panels=(panel,))))
    frame = next(iter(root.iter("{http://www.w3.org/2000/svg}rect"))).attrib
    bottom = float(frame["y"]) + float(frame["height"])
    floor = next(
        path.attrib["d"]
        for path in root.iter("{http://www.w3.org/2000/svg}path")
        if path.attrib.get("stroke") == "#7d8791"
    )
    places = [float(place) for place in re.findall(r"[ML][\d.]+ ([\d.]+)", floor)]
    assert len(places) > 2
    assert bottom - 4 < max(places) <= bottom + 0.1


def test_panel_without_data_is_still_drawn() -> None:
    root = ET.fromstring(svg(Figure(name="x", title="x", panels=(Panel(y_label="y"),))))
    assert root.tag.endswith("svg")


def test_texts_of_marks_keep_clear_of_each_other() -> None:
    layout = Layout(Box(left=0, top=0, width=500, height=200), 7.0)
    boxes = [layout.around(f"mark number {n}", 250.0, 100.0) for n in range(6)]
    assert not any(a.overlaps(b) for n, a in enumerate(boxes) for b in boxes[n + 1 :])
    assert not any(box.outside(layout.frame) for box in boxes)


def test_name_of_a_curve_keeps_clear_of_other_curves() -> None:
    layout = Layout(Box(left=0, top=0, width=500, height=200), 7.0)
    x = np.linspace(0, 500, 50)
    for height in (40.0, 100.0, 108.0):
        layout.avoid(x, np.full(50, height))
    box = layout.along("limit 12 °/h", x, np.full(50, 100.0))
    assert box.contains(layout.curves) == 0


def test_points_along_a_line_are_close_together() -> None:
    points = dense(np.array([0.0, 100.0]), np.array([0.0, 0.0]))
    assert np.max(np.diff(points[:, 0])) <= 3.0
    assert points[-1].tolist() == [100.0, 0.0]


def test_mark_is_labelled_even_in_a_crowd() -> None:
    marks = tuple(Mark(x=float(n), y=1.0, label=f"m{n}") for n in range(5))
    drawn = svg(Figure(name="x", title="x", panels=(Panel(y_label="y", marks=marks),)))
    assert all(f">m{n}<" in drawn for n in range(5))


@given(value=values, low=st.none() | values, high=st.none() | values)
def test_gauge_stays_within_its_drawing(value: float, low: float | None, high: float | None) -> None:
    if low is not None and high is not None and low > high:
        low, high = high, low
    result = records.results_of(1)[0]
    limit = records.limit(low, high, "deg/s")
    drawn = gauge(dataclasses.replace(result, value=value, limit=limit), "#000000")
    assert (drawn is None) == (low is None and high is None)
