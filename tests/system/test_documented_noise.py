"""What the page on noise identification says of a real recording is what is found in it."""

import re
from pathlib import Path

import pytest

from tests.benchmarks.filtered_record import Axis, axes, picture, table

_NUMBER = re.compile(r"\d+\.\d+")


@pytest.fixture(scope="module")
def found(real_data: Path) -> list[Axis]:
    return list(axes(real_data / "adis16405-static" / "gyro_lsb.npz"))


def test_the_documented_table_of_a_filtered_record_is_what_is_found(
    pytestconfig: pytest.Config, found: list[Axis]
) -> None:
    text = (pytestconfig.rootpath / "docs" / "noise.md").read_text(encoding="utf-8")
    documented = re.findall(r"<!-- filtered record: begin.*?-->\n(.*?)\n<!--", text, re.DOTALL)
    assert len(documented) == 1
    said, printed = "\n".join(table(found)), documented[0]
    assert _NUMBER.sub("#", said) == _NUMBER.sub("#", printed)
    assert _numbers(said) == pytest.approx(_numbers(printed), rel=0.006)


def test_the_identified_walk_agrees_with_the_spectrums_level(found: list[Axis]) -> None:
    """The spectrum at 1 … 5 Hz knows nothing of Allan variances, filters and lines."""
    for axis in found:
        walk = axis.model.angle_random_walk
        assert walk.lower_95 * 60.0 < axis.from_spectrum < walk.upper_95 * 60.0
        assert axis.reading(0.01) < 0.98 * axis.from_spectrum


def test_the_pictures_curves_and_marks_are_those_of_two_axes(found: list[Axis]) -> None:
    panels = picture([found[0], found[2]]).panels
    assert [len(panel.marks) for panel in panels] == [2, 3]
    assert [curve.label for curve in panels[0].curves][1:] == ["fit", panels[0].curves[2].label]


def _numbers(text: str) -> list[float]:
    return [float(one) for one in _NUMBER.findall(text)]
