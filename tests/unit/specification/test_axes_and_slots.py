"""Axes, power and what carries the units: every complaint names its key and what is accepted."""

from pathlib import Path

import pytest

from gyrotest.errors import SpecError, StationError
from gyrotest.specification.spec import load_spec
from gyrotest.specification.station import load_station

SPEC = """
model: TRIAD
output: {kind: rate, axes: [x, y, z]}
supply: {voltage: 5 V, current_limit: 200 mA, over_voltage: 5.5 V}
cases:
  rest:
    procedure: static
    duration: 100 s
    interval: 1 s
    mountings: {x: [0, 1, 0], y: [0, 0, 1], z: [1, 0, 0]}
    parameters: {smoothing: [1 s]}
"""

STATION = """
name: Bench
line_frequency: 50 Hz
instruments:
  meter: {driver: agilent34401a, resource: 'GPIB0::22::INSTR'}
  table:
    driver: agilent34401a
    resource: 'GPIB0::23::INSTR'
    motion: {max_rate: 100 deg/s, max_acceleration: 50 deg/s/s, max_turns: 3}
slots:
  a: {source: meter, channel: '101', table: table}
"""


def _spec(folder: Path, old: str, new: str) -> None:
    assert old in SPEC
    (folder / "spec.yaml").write_text(SPEC.replace(old, new))
    load_spec(folder / "spec.yaml")


def _station(folder: Path, old: str, new: str) -> None:
    assert old in STATION
    (folder / "station.yaml").write_text(STATION.replace(old, new))
    load_station(folder / "station.yaml")


def test_three_axes_with_their_mountings_and_a_supply_are_a_good_spec(tmp_path: Path) -> None:
    _spec(tmp_path, "TRIAD", "TRIAD")


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("x: [0, 1, 0]", "w: [0, 1, 0]", "mountings.w: 'w' is no axis of this output"),
        ("x: [0, 1, 0]", "x: [0, 0, 0]", "mountings.x: is no direction"),
        ("axes: [x, y, z]", "axes: [x, y, y]", "output.axes: axis 'y' is named 2 times"),
        ("axes: [x, y, z]", "axes: [x, y, 'z z']", "is no name"),
        ("interval: 1 s", "interval: 1 s\n    axes: [u]", "axes[0]: 'u' is no axis of this output"),
        (
            "mountings: {x: [0, 1, 0], y: [0, 0, 1], z: [1, 0, 0]}",
            "mounting: [1, 0, 0]",
            "is the direction of one axis, and this case judges several",
        ),
        ("over_voltage: 5.5 V", "over_voltage: 5 V", "supply.over_voltage: '5 V' is not above"),
        ("current_limit: 200 mA", "current_limit: 0 mA", "'0 mA' is not more than zero"),
        ("interval: 1 s", "interval: 1 s\n    allowed_loss: 100 %", "is not between 0 and 100 %"),
    ],
)
def test_what_is_wrong_with_axes_and_power_is_told_at_its_key(
    tmp_path: Path, old: str, new: str, told: str
) -> None:
    with pytest.raises(SpecError) as refused:
        _spec(tmp_path, old, new)
    assert told in str(refused.value)


def test_a_slot_on_a_table_with_motion_limits_is_a_good_station(tmp_path: Path) -> None:
    _station(tmp_path, "Bench", "Bench")


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (", max_turns: 3", "", "motion.max_turns: is missing; without a slip ring"),
        ("max_turns: 3", "slip_ring: true, max_turns: 3", "has no meaning with a slip ring"),
        ("max_turns: 3", "max_turns: 0", "max_turns: 0 is not more than zero"),
        ("max_rate: 100 deg/s", "max_rate: 0 deg/s", "max_rate: '0 deg/s' is not more than zero"),
        ("table: table", "table: tabel", "slots.a.table: 'tabel' is no instrument"),
        ("table: table", "table: meter", "slots.a.table: 'meter' has no 'motion'"),
        ("table: table", "supply: psu", "slots.a.supply: 'psu' is no instrument"),
        ("table: table", "supply_output: 0", "slots.a.supply_output: 0 is no output"),
        ("channel: '101'", "channel: '101', channels: {x: '102'}", "stands beside 'channel'"),
        ("channel: '101'", "channel: '101', auxiliary: {t: '101'}", "channel '101' is named twice"),
        (
            "slots:\n",
            "slots:\n  b: {source: meter, channel: '101'}\n",
            "reads 'meter' as slot 'b' does; give each slot its own 'channel'",
        ),
    ],
)
def test_what_is_wrong_with_slots_and_motion_is_told_at_its_key(
    tmp_path: Path, old: str, new: str, told: str
) -> None:
    with pytest.raises(StationError) as refused:
        _station(tmp_path, old, new)
    assert told in str(refused.value)


CARRIED = STATION.replace(
    "channel: '101', table: table",
    "channel: '101', encoder: {sine: ua, cosine: ub, lines: 9000}, frame: {x: z, y: x, z: y}",
).replace("max_turns: 3}", "max_turns: 3}\n    shaft: {azimuth: 30 deg, tilt: -0.02 deg}")


def test_a_slot_with_a_grating_and_a_stage_with_a_level_shaft_are_a_good_station(
    tmp_path: Path,
) -> None:
    (tmp_path / "station.yaml").write_text(CARRIED)
    station = load_station(tmp_path / "station.yaml").station
    encoder = station.slots["a"].encoder
    assert encoder is not None
    assert (encoder.sine, encoder.cosine, encoder.lines) == ("ua", "ub", 9000)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("sine: ua, cosine: ub, lines: 9000", "", "slots.a.encoder: is empty; write e.g. {sine: ua,"),
        ("cosine: ub, ", "", "slots.a.encoder: lacks cosine; write e.g. {sine: ua, cosine: ub,"),
        (", lines: 9000", "", "slots.a.encoder: lacks lines"),
        ("lines: 9000", "lines: 9000, angle: th", "encoder.angle: stands beside 'sine'"),
        ("lines: 9000", "lines: 0", "encoder.lines: 0 lines are no grating"),
        (
            "lines: 9000",
            "lines: 9000, accuracy: -1 arcsec",
            "encoder.accuracy: '-1 arcsec' is less than",
        ),
        ("cosine: ub", "cosine: ua", "slots.a: channel 'ua' is named twice"),
        ("sine: ua", "sine: '101'", "slots.a: channel '101' is named twice"),
        (
            "encoder: {",
            "auxiliary: {encoder_sine: '7'}, encoder: {",
            "auxiliary.encoder_sine: names that begin with 'encoder_' are the encoder's",
        ),
        ("y: x, z: y", "z: y", "slots.a.frame: a frame says where x, y and z lie, found x, z"),
        ("x: z, y: x", "x: w, y: x", "slots.a.frame: 'w' is no axis of the stage"),
        ("x: z, y: x", "x: x, y: x", "two axes lie along one"),
        ("x: z, y: x", "x: -z, y: x", "they are left-handed"),
        ("tilt: -0.02 deg", "tilt: 12 deg", "shaft.tilt: '12 deg' is more than 5 deg"),
        ("azimuth: 30 deg", "azimuth: 400 deg", "shaft.azimuth: '400 deg' is not between"),
        (
            "tilt:",
            "tilt_uncertainty: -1 deg, tilt:",
            "shaft.tilt_uncertainty: '-1 deg' is less than zero",
        ),
        ("tilt:", "index_uncertainty: -1 deg, tilt:", "shaft.index_uncertainty: '-1 deg' is less"),
        ("tilt:", "azimuth_uncertainty: -1 deg, tilt:", "shaft.azimuth_uncertainty: '-1 deg' is less"),
    ],
)
def test_what_is_wrong_with_encoder_frame_and_shaft_is_told_at_its_key(
    tmp_path: Path, old: str, new: str, told: str
) -> None:
    assert old in CARRIED
    (tmp_path / "station.yaml").write_text(CARRIED.replace(old, new))
    with pytest.raises(StationError) as refused:
        load_station(tmp_path / "station.yaml")
    assert told in str(refused.value)
