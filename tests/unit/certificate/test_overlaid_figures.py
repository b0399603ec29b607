"""Data of several records in one plot: told apart, named in a legend, the same on every paper."""

import io
import xml.etree.ElementTree as ET

import pytest
from matplotlib.text import Annotation

from gyrotest.certificate.figures import draw, svg
from gyrotest.certificate.style import SERIES, styled
from gyrotest.records.figure import Band, Curve, Figure, Panel, Role, Scale

TAU = (0.1, 1.0, 10.0, 100.0)


def _overlaid(count: int, *, legend: bool = True) -> Figure:
    panel = Panel(
        y_label="y",
        x_scale=Scale.LOG,
        y_scale=Scale.LOG,
        curves=tuple(
            Curve(x=TAU, y=tuple((n + 1) * t**-0.5 for t in TAU), series=n, label=f"axis {n}")
            for n in range(count)
        ),
        bands=tuple(
            Band(
                x=TAU,
                lower=tuple(0.8 * (n + 1) * t**-0.5 for t in TAU),
                upper=tuple(1.2 * (n + 1) * t**-0.5 for t in TAU),
                series=n,
            )
            for n in range(count)
        ),
        legend=legend,
    )
    return Figure(name="x", title="x", panels=(panel,))


def test_no_two_of_six_records_look_alike() -> None:
    lines = [one for one in draw(_overlaid(6)).axes[0].lines if len(one.get_xdata()) == len(TAU)]
    assert len({(one.get_color(), str(one._unscaled_dash_pattern)) for one in lines}) == 6
    assert len({stroke.colour for stroke in SERIES}) == len(SERIES)


def test_more_records_than_styles_are_drawn_all_the_same() -> None:
    lines = [one for one in draw(_overlaid(9)).axes[0].lines if len(one.get_xdata()) == len(TAU)]
    assert len(lines) == 9


def test_the_legend_names_every_record_once_within_the_frame() -> None:
    figure = draw(_overlaid(3))
    with styled():
        figure.savefig(io.BytesIO(), format="svg")
    axes = figure.axes[0]
    names = [one for one in axes.texts if isinstance(one, Annotation) and one.get_text()]
    assert [one.get_text() for one in names] == ["axis 0", "axis 1", "axis 2"]
    frame = axes.get_window_extent()
    boxes = [one.get_window_extent() for one in names]
    assert all(frame.x0 <= box.x0 and box.x1 <= frame.x1 for box in boxes)
    assert len({round(box.x0, 3) for box in boxes}) == 1
    # Each name has a piece of its line before it, at its height.
    samples = [one for one in axes.lines if len(one.get_xdata()) == 2]
    heights = [one.get_window_extent().y0 for one in samples]
    assert heights == pytest.approx([(box.y0 + box.y1) / 2 for box in boxes], abs=2.0)


def test_without_a_legend_names_stand_beside_their_curves() -> None:
    root = ET.fromstring(svg(_overlaid(2, legend=False)))
    texts = [one.text for one in root.iter("{http://www.w3.org/2000/svg}text")]
    assert {"axis 0", "axis 1"} <= set(texts)


def test_only_data_have_series() -> None:
    curves = tuple(Curve(x=TAU, y=TAU, role=Role.MODEL, series=n) for n in range(2))
    figure = draw(Figure(name="x", title="x", panels=(Panel(y_label="y", curves=curves),)))
    lines = [one for one in figure.axes[0].lines if len(one.get_xdata()) == len(TAU)]
    assert len({one.get_color() for one in lines}) == 1
