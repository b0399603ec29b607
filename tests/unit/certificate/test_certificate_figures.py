"""Figures: sensible ticks, nothing outside the frame, texts beside one another, the same bytes each time."""

import dataclasses
import io
import logging
import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import matplotlib
import matplotlib.figure
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.text import Annotation
from matplotlib.transforms import Bbox

from gyrotest.certificate.axes import log_label
from gyrotest.certificate.figures import draw, image, svg
from gyrotest.certificate.gauge import gauge
from gyrotest.certificate.labels import Layout, dense
from gyrotest.certificate.style import STROKES, styled
from gyrotest.records.figure import Band, Bars, Curve, Figure, Mark, Panel, Role, Scale
from tests.unit.certificate import records

values = st.floats(min_value=-1e12, max_value=1e12, allow_subnormal=False)
SVG = "{http://www.w3.org/2000/svg}"


def one(panel: Panel) -> Figure:
    return Figure(name="x", title="x", panels=(panel,))


def lines(*numbers: float, x: Scale = Scale.LINEAR, y: Scale = Scale.LINEAR) -> Panel:
    curve = Curve(x=tuple(map(float, range(1, len(numbers) + 1))), y=numbers)
    return Panel(y_label="y", x_scale=x, y_scale=y, curves=(curve,))


def texts(drawn: str) -> list[str]:
    return [element.text or "" for element in ET.fromstring(drawn).iter(f"{SVG}text")]


def ticks(axis: "matplotlib.axis.Axis") -> list[str]:
    low, high = axis.get_view_interval()
    places = axis.get_majorticklocs()
    labels = axis.get_major_formatter().format_ticks(places)
    return [label for place, label in zip(places, labels, strict=True) if low <= place <= high]


def test_linear_ticks_are_round_with_equal_decimals_and_the_true_minus() -> None:
    axes = draw(one(lines(-0.4, 0.2))).axes[0]
    assert ticks(axes.yaxis) == ["−0.4", "−0.2", "0.0", "0.2"]


def test_time_axis_ends_with_the_tick_that_it_nearly_reaches() -> None:
    panel = Panel(y_label="y", curves=(Curve(x=(0.03, 59.97), y=(1.0, 2.0)),))
    axes = draw(one(panel)).axes[0]
    assert axes.get_xlim() == (0.0, 60.0)
    assert ticks(axes.xaxis) == ["0", "10", "20", "30", "40", "50", "60"]


def test_numbers_far_from_one_share_a_factor_that_the_label_says() -> None:
    drawn = texts(svg(one(lines(0.0, 3e-6))))
    assert "y, × 10⁻⁶" in drawn
    assert {"0.0", "1.0", "2.0", "3.0"} <= set(drawn)
    assert not any("1e" in text for text in drawn)


def test_logarithmic_ticks_are_decades_with_a_fine_grid() -> None:
    panel = lines(0.1, 10_000.0, y=Scale.LOG)
    axes = draw(one(panel)).axes[0]
    assert ticks(axes.yaxis) == ["0.1", "1", "10", "100", "1000", "10\u202f000"]
    fine = next(line for line in axes.lines if line.get_color() == "#e9edf1")
    assert np.any(np.isclose(np.asarray(fine.get_ydata(), dtype=float), 0.2))


def test_short_logarithmic_axis_has_labels_within_the_decade() -> None:
    assert ticks(draw(one(lines(3.0, 70.0, y=Scale.LOG))).axes[0].yaxis) == ["5", "10", "20", "50"]


@pytest.mark.parametrize(
    ("value", "label"),
    [(0.001, "0.001"), (2e5, "200\u202f000"), (1e6, "10⁶"), (5e-4, "5·10⁻⁴"), (1e-9, "10⁻⁹")],
)
def test_numbers_of_a_logarithmic_axis_are_plain_or_powers_of_ten(value: float, label: str) -> None:
    assert log_label(value) == label


@settings(deadline=None, max_examples=25)
@given(st.lists(values, min_size=1, max_size=30), st.sampled_from(Scale), st.sampled_from(Scale))
def test_every_value_is_shown_and_ticks_differ(numbers: list[float], x: Scale, y: Scale) -> None:
    axes = draw(one(lines(*numbers, x=x, y=y))).axes[0]
    low, high = axes.get_ylim()
    deepest = 1e-14 * max(numbers)
    assert all(low <= one <= high for one in numbers if y is Scale.LINEAR or one > max(deepest, 0.0))
    labels = ticks(axes.yaxis)
    assert len(labels) <= 32
    assert len(set(labels)) == len(labels)


@settings(deadline=None, max_examples=15)
@given(st.lists(values, min_size=1, max_size=30), st.sampled_from(Scale))
def test_any_numbers_give_well_formed_svg(numbers: list[float], scale: Scale) -> None:
    ET.fromstring(svg(one(lines(*numbers, x=scale, y=scale))))


@pytest.mark.parametrize("number", [0, 1, 2])
def test_texts_lie_within_the_paper_and_not_on_each_other(number: int) -> None:
    figure = draw(records.passing().items[0].attempts[0].figures[number])
    with styled():
        figure.savefig(io.BytesIO(), format="svg")  # puts the labels of the axes in their places
    for axes in figure.axes:
        boxes = [one.get_window_extent() for one in axes.texts if one.get_text()]
        frame = axes.get_window_extent()
        assert all(box.x0 >= frame.x0 and box.x1 <= frame.x1 for box in boxes)
        assert all(box.y0 >= frame.y0 and box.y1 <= frame.y1 for box in boxes)
        assert not any(a.overlaps(b) for n, a in enumerate(boxes) for b in boxes[n + 1 :])
        paper = figure.bbox
        for label in (axes.xaxis.label, axes.yaxis.label):
            box = label.get_window_extent()
            assert box.x0 >= paper.x0
            assert box.y0 >= paper.y0


def test_svg_has_the_papers_size_in_points_and_real_text_in_the_certificates_font() -> None:
    root = ET.fromstring(svg(records.passing().items[0].attempts[0].figures[1]))
    assert root.attrib["width"] == "510pt"
    assert root.attrib["viewBox"].startswith("0 0 510 ")
    written = list(root.iter(f"{SVG}text"))
    assert "ARW 0.494 °/√h" in [element.text for element in written]
    assert all("font-family: 'Inter'" in element.attrib["style"] for element in written)


def test_panels_share_their_x_axis_and_only_the_last_has_its_numbers() -> None:
    upper, lower = draw(records.passing().items[0].attempts[0].figures[0]).axes
    assert upper.get_xlim() == lower.get_xlim() == (0.0, 60.0)
    assert not any(label.get_visible() for label in upper.get_xticklabels())
    assert lower.get_xlabel() == "Time / min"


def test_roles_have_styles_of_their_own_and_labels_are_escaped() -> None:
    curves = tuple(
        Curve(x=(0.0, 1.0), y=(float(n), float(n)), role=role, label=f"<{role.value}> & $more$")
        for n, role in enumerate(Role)
    )
    written = texts(svg(one(Panel(y_label="y", curves=curves))))
    assert {f"<{role.value}> & $more$" for role in Role} <= set(written)
    assert len({(stroke.colour, stroke.dashes, stroke.width) for stroke in STROKES.values()}) == len(
        Role
    )


def test_noise_floor_far_below_leaves_the_frame_but_is_seen() -> None:
    tau = (1.0, 1000.0)
    curves = (
        Curve(x=tau, y=(100.0, 10.0)),
        Curve(x=tau, y=(0.1, 0.0001), role=Role.FLOOR, label="meter"),
    )
    panel = Panel(y_label="y", x_scale=Scale.LOG, y_scale=Scale.LOG, curves=curves)
    axes = draw(one(panel)).axes[0]
    low, high = axes.get_ylim()
    assert 0.015 < low < 0.025
    assert 100.0 < high < 200.0
    root = ET.fromstring(svg(one(panel)))
    floor = [path for path in root.iter(f"{SVG}path") if "#7d8791" in path.attrib.get("style", "")]
    assert len(floor) == 1
    assert "clip-path" in floor[0].attrib
    assert "meter" in texts(svg(one(panel)))


def test_bars_stand_on_the_axis() -> None:
    panel = Panel(y_label="y", bars=Bars(edges=(0.0, 1.0, 2.0), heights=(3.0, 5.0)))
    axes = draw(one(panel)).axes[0]
    assert axes.get_ylim()[0] == 0.0
    assert axes.get_ylim()[1] > 5.0


@pytest.mark.parametrize("scale", list(Scale))
@pytest.mark.parametrize(
    "panel",
    [
        Panel(y_label="y"),
        Panel(y_label="y", curves=(Curve(x=(), y=(), label="none", role=Role.FLOOR),)),
        Panel(y_label="y", curves=(Curve(x=(1.0, 2.0), y=(0.0, -3.0), label="below"),)),
        Panel(y_label="y", bands=(Band(x=(), lower=(), upper=(), label="none"),)),
        Panel(y_label="y", marks=(Mark(x=1.0, y=1.0, label="alone"),)),
    ],
)
def test_panel_without_anything_to_show_is_still_drawn(panel: Panel, scale: Scale) -> None:
    figure = one(dataclasses.replace(panel, x_scale=scale, y_scale=scale))
    assert ET.fromstring(svg(figure)).tag == f"{SVG}svg"


def test_signs_that_the_font_lacks_are_no_warning() -> None:
    panel = Panel(y_label="速率", note="Ω 𓀀")
    assert {"速率", "Ω 𓀀"} <= set(texts(svg(one(panel))))


@pytest.mark.parametrize(("form", "begin"), [("svg", b"<?xml"), ("pdf", b"%PDF"), ("png", b"\x89PNG")])
def test_same_figure_gives_the_same_bytes_in_every_format(form: str, begin: bytes) -> None:
    figure = records.passing().items[0].attempts[0].figures[1]
    first = image(figure, form)  # type: ignore[arg-type]
    assert first.startswith(begin)
    assert image(figure, form) == first  # type: ignore[arg-type]


def test_users_settings_have_no_influence_and_come_back() -> None:
    figure = one(lines(1.0, 2.0))
    before = svg(figure)
    with matplotlib.rc_context({"font.size": 30, "axes.linewidth": 9, "svg.fonttype": "path"}):
        assert svg(figure) == before
        assert matplotlib.rcParams["font.size"] == 30


def test_home_that_cannot_be_written_is_no_remark(tmp_path: Path) -> None:
    home = tmp_path / "home"
    home.write_text("a file where a folder is looked for", encoding="utf-8")
    program = (
        "import sys; from gyrotest.certificate.figures import svg\n"
        "from gyrotest.records.figure import Figure, Panel\n"
        "svg(Figure(name='x', title='x', panels=(Panel(y_label='y'),)))\n"
        "assert 'matplotlib.pyplot' not in sys.modules"
    )
    unset = ("MPLCONFIGDIR", "XDG_CONFIG_HOME", "XDG_CACHE_HOME")
    environment = {name: value for name, value in os.environ.items() if name not in unset}
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", program],
        env={**environment, "HOME": str(home), "USERPROFILE": str(home), "LOCALAPPDATA": str(home)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")


def test_matplotlibs_log_speaks_again_after_a_figure() -> None:
    level = logging.getLogger("matplotlib").level
    svg(one(lines(1.0)))
    assert logging.getLogger("matplotlib").level == level


def test_texts_of_marks_keep_clear_of_each_other() -> None:
    layout = Layout(frame=Bbox([[0, 0], [500, 200]]), ink=np.empty((0, 2)))
    boxes = [layout.around(f"mark number {n}", 250.0, 100.0) for n in range(6)]
    assert not any(a.overlaps(b) for n, a in enumerate(boxes) for b in boxes[n + 1 :])
    assert not any(np.any(box.min < 0) or np.any(box.max > (500, 200)) for box in boxes)


def test_name_of_a_curve_keeps_clear_of_other_curves() -> None:
    x = np.linspace(0, 500, 50)
    curves = [dense(np.column_stack((x, np.full(50, height)))) for height in (40.0, 100.0, 108.0)]
    layout = Layout(frame=Bbox([[0, 0], [500, 200]]), ink=np.vstack(curves))
    box = layout.along("limit 12 °/h", curves[1])
    assert box.count_contains(layout.ink) == 0


def test_points_along_a_line_are_close_together() -> None:
    points = dense(np.array([[0.0, 0.0], [100.0, 0.0]]))
    assert np.max(np.diff(points[:, 0])) <= 3.0
    assert points[-1].tolist() == [100.0, 0.0]


def test_mark_is_labelled_even_in_a_crowd() -> None:
    marks = tuple(Mark(x=float(n), y=1.0, label=f"m{n}") for n in range(5))
    written = texts(svg(one(Panel(y_label="y", marks=marks))))
    assert {f"m{n}" for n in range(5)} <= set(written)


def test_mark_is_joined_to_a_text_that_stands_away() -> None:
    marks = tuple(Mark(x=1.0 + n * 1e-3, y=1.0, label=f"mark number {n}") for n in range(8))
    axes = draw(one(Panel(y_label="y", marks=(*marks, Mark(x=5.0, y=2.0, label="far"))))).axes[0]
    assert any(isinstance(text, Annotation) and text.arrow_patch for text in axes.texts)


@given(value=values, low=st.none() | values, high=st.none() | values)
def test_gauge_stays_within_its_drawing(value: float, low: float | None, high: float | None) -> None:
    if low is not None and high is not None and low > high:
        low, high = high, low
    result = records.results_of(1)[0]
    limit = records.limit(low, high, "deg/s")
    drawn = gauge(dataclasses.replace(result, value=value, limit=limit), "#000000")
    assert (drawn is None) == (low is None and high is None)
