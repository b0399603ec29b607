"""The running Allan deviation as text: for a known record, growing, begun anew, on little room."""

import itertools
import re
from collections.abc import Iterable

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.analysis.allan import overlapping_allan_deviation
from gyrotest.analysis.minimum import allan_minimum
from gyrotest.plugin.allan_screen import Room, allan_lines, time_axis
from gyrotest.plugin.running_allan import RunningAllan, RunningCurve
from gyrotest.records.recording import Block, Sampling

DPH = 3600.0
WIDE = Room(width=100, height=30)
_BRAILLE = range(0x2801, 0x2900)
_ROW_OF_BIT = (0, 1, 2, 0, 1, 2, 3, 3)


def running(
    *, interval_s: float = 1.0, channels: tuple[str, ...] = ("output",), scale: float = 1.0
) -> RunningAllan:
    sampling = Sampling(interval_s=interval_s, aperture_s=interval_s, channels=channels)
    return RunningAllan(sampling, dps_per_unit=scale)


def block(values: NDArray[np.float64], *, first: int = 0, flagged: Iterable[int] = ()) -> Block:
    rows = values[:, np.newaxis] if values.ndim == 1 else values
    flags = np.zeros(len(rows), dtype=np.uint8)
    flags[list(flagged)] = 2
    return Block(first=first, time_s=first + np.arange(len(rows), dtype=float), values=rows, flags=flags)


def white(
    samples: int, *, deviation: float = 20.0 / DPH, channels: int | None = None, seed: int = 1
) -> NDArray[np.float64]:
    size = samples if channels is None else (samples, channels)
    return np.random.default_rng(seed).normal(scale=deviation, size=size)


def drawn(allan: RunningAllan, *, planned: int = 3600, room: Room = WIDE, anew: str = "") -> list[str]:
    axis = time_axis(1.0, planned)
    return [line.plain for line in allan_lines(allan.curves(), axis=axis, anew=anew, room=room)]


def only(allan: RunningAllan) -> RunningCurve:
    (curve,) = allan.curves()
    return curve


def heights(lines: list[str]) -> dict[int, float]:
    """Mean height of the dots in each column of cells, in cells from below."""
    found: dict[int, list[float]] = {}
    for row, line in enumerate(reversed(lines)):
        for column, cell in enumerate(line):
            if ord(cell) in _BRAILLE:
                rows = [_ROW_OF_BIT[bit] for bit in range(8) if ord(cell) >> bit & 1]
                found.setdefault(column, []).append(row - float(np.mean(rows)) / 4.0)
    return {column: float(np.mean(one)) for column, one in sorted(found.items())}


def test_white_noise_is_drawn_as_a_straight_line_that_falls_half_a_decade_a_decade() -> None:
    allan = running()
    allan.push(block(white(200_000)))
    lines = drawn(allan, planned=200_000)
    assert lines[0].startswith("Allan deviation so far, °/h")
    found = heights(lines[1:11])
    columns = np.array(list(found))[2:40]
    level = np.array(list(found.values()))[2:40]
    slope, offset = np.polyfit(columns, level, 1)
    assert np.abs(level - (slope * columns + offset)).max() < 0.3
    axis_decades = np.log10(200_000 / 9)
    labels = [float(line[:7]) for line in lines[1:11] if line[:7].strip()]
    decades_a_row = (
        np.log10(labels[0] / labels[-1])
        / ([row for row, line in enumerate(lines[1:11]) if line[:7].strip()][-1])
    )
    assert slope * decades_a_row / (axis_decades / 60.0) == pytest.approx(-0.5, abs=0.06)


def test_the_curve_never_rises_where_the_deviation_falls() -> None:
    allan = running()
    allan.push(block(white(50_000)))
    level = list(heights(drawn(allan, planned=50_000)[1:11]).values())
    assert len(level) > 40
    assert all(after <= before for before, after in itertools.pairwise(level[:30]))


def test_the_readings_are_those_of_the_record_in_the_unit_of_a_rate() -> None:
    volts = 2.5 + white(3600) * 0.05
    allan = running(scale=1.0 / 0.05)
    allan.push(block(volts))
    curve = only(allan)
    whole = overlapping_allan_deviation((volts - 2.5) / 0.05, sample_rate_hz=1.0)
    lowest = allan_minimum(whole, first_tau_s=0.0)
    assert lowest is not None
    assert curve.lowest is not None
    assert curve.lowest.deviation_dps == pytest.approx(lowest.deviation_dps, rel=0.1)
    lines = drawn(allan)
    shown = re.search(r"so far: lowest (\S+) °/h at τ = (\S+) s", "\n".join(lines))
    assert shown is not None
    assert float(shown[1]) == pytest.approx(curve.lowest.deviation_dps * DPH, rel=0.05)
    assert float(shown[2]) == curve.lowest.tau_s
    walk = whole.deviation_dps[0] * 60.0
    assert f"so far: apparent angle random walk {walk:.2f} °/√h at τ = 1 s" in lines


def test_angle_random_walk_waits_for_an_averaging_time_next_to_a_second() -> None:
    allan = running(interval_s=0.01)
    allan.push(block(white(500)))
    assert only(allan).walk is None
    allan.push(block(white(2000, seed=2), first=500))
    walk = only(allan).walk
    assert walk is not None
    assert walk.tau_s == 1.0


def test_angle_random_walk_of_slow_samples_is_read_at_their_interval() -> None:
    allan = running(interval_s=10.0)
    allan.push(block(white(100)))
    walk = only(allan).walk
    assert walk is not None
    assert walk.tau_s == 10.0


def test_the_curve_grows_towards_longer_averaging_times() -> None:
    allan, record = running(), white(3600)
    reach = []
    for begin in range(0, 3600, 600):
        allan.push(block(record[begin : begin + 600], first=begin))
        reach.append(max(heights(drawn(allan)[1:11])))
    assert reach == sorted(set(reach))


def test_the_uncertain_end_is_dotted_and_the_legend_says_so() -> None:
    allan = running()
    allan.push(block(white(3600)))
    curve = only(allan)
    assert curve.certain[0]
    assert not curve.certain[-1]
    assert "dotted: ± 13 % and more" in drawn(allan)[0]


def test_too_few_samples_show_axes_and_no_readings() -> None:
    allan = running()
    assert drawn(allan)[0] == "Allan deviation: too few samples yet"
    allan.push(block(white(8)))
    lines = drawn(allan)
    assert lines[0] == "Allan deviation: too few samples yet"
    assert lines[-1] == ""
    assert not heights(lines)


def test_a_constant_output_has_no_curve() -> None:
    allan = running()
    allan.push(block(np.full(500, 2.5)))
    assert allan.curves() == ()


def test_a_gap_begins_the_curve_anew() -> None:
    first, second = white(1000) + 1.0, white(700, seed=2)
    allan, fresh = running(), running()
    allan.push(block(first))
    assert allan.anew is None
    allan.push(block(second, first=1005))
    fresh.push(block(second))
    assert allan.anew is not None
    assert (allan.anew.first, allan.anew.reason) == (1005, "a gap")
    np.testing.assert_array_equal(only(allan).deviation_dps, only(fresh).deviation_dps)


@pytest.mark.parametrize("way", ["flag", "nan"])
def test_a_bad_sample_begins_the_curve_anew_after_it(way: str) -> None:
    record = white(1000)
    seen = record.copy()
    if way == "nan":
        seen[[100, 300]] = np.nan
    allan, fresh = running(), running()
    allan.push(block(seen, flagged=(100, 300) if way == "flag" else ()))
    fresh.push(block(record[301:]))
    assert allan.anew is not None
    assert (allan.anew.first, allan.anew.reason) == (301, "a bad sample")
    np.testing.assert_array_equal(only(allan).deviation_dps, only(fresh).deviation_dps)


def test_three_axes_are_drawn_side_by_side_below_one_another_or_the_first_alone() -> None:
    allan = running(channels=("x", "y", "z"))
    allan.push(block(white(3600, channels=3)))
    beside = drawn(allan, room=Room(width=120, height=20))
    assert re.match(r"x: Allan .* y: Allan .* z: Allan", beside[0])
    below = drawn(allan, room=Room(width=60, height=45))
    assert [line[0] for line in below if "Allan deviation" in line] == ["x", "y", "z"]
    alone = drawn(allan, room=Room(width=60, height=14))
    assert [line[0] for line in alone if "Allan deviation" in line] == ["x"]


@pytest.mark.parametrize("width", [1, 10, 20, 31, 32, 45, 60, 80, 200])
@pytest.mark.parametrize("height", [-3, 0, 1, 2, 5, 9, 12, 40])
@pytest.mark.parametrize("channels", [1, 3])
def test_nothing_is_drawn_beyond_the_room_there_is(width: int, height: int, channels: int) -> None:
    allan = running(channels=tuple("xyz"[:channels]))
    allan.push(block(white(300, channels=channels)))
    lines = drawn(allan, room=Room(width=width, height=height), anew="begun anew")
    assert len(lines) <= max(height, 0)
    if len(lines) > 3:
        assert max(map(len, lines)) <= width


@pytest.mark.parametrize("deviation", [1e-12, 1e-6, 0.3, 5e3])
def test_any_noise_finds_its_place_on_the_axis(deviation: float) -> None:
    allan = running()
    allan.push(block(white(900, deviation=deviation)))
    lines = drawn(allan, planned=900)
    assert ("°/s" if deviation > 0.5 else "°/h") in lines[0]
    assert len(heights(lines[1:11])) > 30
    assert max(map(len, lines)) <= 68


def test_a_record_longer_than_its_plan_stays_at_the_edge() -> None:
    allan = running()
    allan.push(block(white(5000)))
    assert max(map(len, drawn(allan, planned=100))) <= 68
