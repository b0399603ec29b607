"""A recorded file plays as an instrument: its unit, its window, its gaps, its end."""

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from gyrotest.clock import RealClock
from gyrotest.errors import InstrumentError, InstrumentIdentityError, RecordingError
from gyrotest.instruments.replay import Replay
from gyrotest.instruments.replay_settings import AuxiliaryColumn, ReplaySettings
from gyrotest.ports import Source
from gyrotest.recordings.writer import RecordingWriter
from gyrotest.records.recording import (
    Block,
    Identity,
    RecordingHeader,
    SampleFlag,
    Sampling,
)
from gyrotest.records.station import Accuracy
from gyrotest.units import Quantity


def replay(
    path: Path, *, accuracy: Accuracy | None = None, serial_number: str | None = None, **settings
) -> Replay:
    given = ReplaySettings(**settings)
    return Replay(str(path), given, clock=RealClock(), accuracy=accuracy, serial_number=serial_number)


def played(source: Source, count: int = 10**9, first: int = 0) -> list[Block]:
    source.start(first, count)
    blocks = []
    while (block := source.fetch()) is not None:
        blocks.append(block)
    return blocks


def values(blocks: list[Block]) -> list[float]:
    return np.concatenate([block.values[:, 0] for block in blocks]).tolist() if blocks else []


HZ_10 = Quantity(10.0, "Hz")
BESIDE = AuxiliaryColumn(column=3, unit="rpm")


@pytest.fixture
def ramp(tmp_path) -> Path:
    path = tmp_path / "data.txt"
    path.write_text("".join(f"{row}\n" for row in range(100)))
    return path


def test_a_file_is_an_instrument_with_its_hash_as_serial_number(ramp):
    import hashlib

    source = replay(ramp, unit="V", sample_rate=HZ_10)
    identity = source.open()
    assert (identity.manufacturer, identity.model) == ("replay", "data.txt")
    assert identity.serial_number == "REPLAY-" + hashlib.sha256(ramp.read_bytes()).hexdigest()[:8]
    assert source.configure(0.1) == Sampling(interval_s=0.1, aperture_s=0.1, unit="V")
    blocks = played(source)
    assert values(blocks) == [float(row) for row in range(100)]
    assert blocks[0].first == 0
    assert blocks[0].time_s.tolist() == pytest.approx([0.1 * row for row in range(100)])
    source.close()
    source.close()


def test_another_file_than_the_station_names_is_refused(ramp):
    with pytest.raises(
        InstrumentIdentityError, match=r"is REPLAY-.*, the station names REPLAY-00000000"
    ):
        replay(ramp, unit="V", sample_rate=HZ_10, serial_number="REPLAY-00000000").open()


@pytest.mark.parametrize(
    ("settings", "unit", "second"),
    [
        ({"unit": "mV"}, "V", 1e-3),
        ({"unit": "rad/s"}, "deg/s", np.degrees(1.0)),
        ({"unit": "deg/h", "scale": -1.0}, "deg/s", -1 / 3600),
        ({"unit": "deg/s", "scale": 0.05}, "deg/s", 0.05),
        ({"unit": "count"}, "count", 1.0),
        ({"unit": "LSB", "scale": -2.0}, "count", -2.0),
        ({"unit": "count", "scale_factor": Quantity(131.0, "count/(deg/s)")}, "deg/s", 1 / 131),
    ],
)
def test_values_come_in_volts_degrees_per_second_or_counts(ramp, settings, unit, second):
    source = replay(ramp, sample_rate=HZ_10, **settings)
    source.open()
    assert source.configure(0.1).unit == unit
    assert values(played(source))[1] == pytest.approx(second, rel=1e-12)


@pytest.mark.parametrize(
    "window",
    [
        {"start": Quantity(2.0, "s"), "end": Quantity(3.0, "s")},
        {"first": 21, "last": 30},
        {"start": Quantity(2000.0, "ms"), "last": 30},
    ],
)
def test_a_window_ends_before_its_end(ramp, window):
    source = replay(ramp, unit="V", sample_rate=HZ_10, **window)
    source.open()
    source.configure(0.1)
    blocks = played(source)
    assert values(blocks) == [float(row) for row in range(20, 30)]
    assert (blocks[0].first, blocks[0].time_s[0]) == (0, 0.0)


def test_a_longer_interval_averages_as_a_meter_would(ramp):
    source = replay(
        ramp,
        unit="V",
        sample_rate=HZ_10,
        accuracy=Accuracy(
            of_reading=Quantity(0.0, "%"), of_range=Quantity(0.0, "%"), noise=Quantity(3.0, "uV")
        ),
    )
    source.open()
    sampling = source.configure(0.9)
    assert (sampling.interval_s, sampling.aperture_s, sampling.readings) == (pytest.approx(0.9), 0.1, 9)
    assert sampling.noise == pytest.approx(1e-6)
    assert sampling.duty == pytest.approx(1.0)
    assert values(played(source)) == [4.0 + 9 * group for group in range(11)]
    assert "each sample is the mean of 9 rows" in " ".join(source.remarks())


@pytest.mark.parametrize("interval_s", [0.05, 0.15, 0.1002])
def test_an_interval_that_does_not_fit_names_both(ramp, interval_s):
    source = replay(ramp, unit="V", sample_rate=HZ_10)
    source.open()
    with pytest.raises(InstrumentError, match=rf"every 0\.1 s.*{interval_s} s is no whole multiple"):
        source.configure(interval_s)


def test_an_acquisition_goes_on_where_the_last_one_ended(ramp):
    source = replay(ramp, unit="V", sample_rate=HZ_10)
    source.open()
    source.configure(0.1)
    assert values(played(source, 40)) == [float(row) for row in range(40)]
    source.configure(0.2)
    second = played(source, 20)
    assert second[0].first == 0
    assert second[0].time_s[0] == 0.0
    assert values(second) == [40.5 + 2 * row for row in range(20)]
    assert source.remarks()[0] == "data.txt: 20 samples from positions 41 to 80 of the window"
    source.configure(0.1)
    assert len(values(played(source, 40))) == 20
    assert values(played(source, 40)) == []


def test_a_file_played_again_says_so(ramp):
    source = replay(ramp, unit="V", sample_rate=HZ_10, rewind=True)
    source.open()
    source.configure(0.1)
    first = values(played(source, 40))
    assert "played again" not in " ".join(source.remarks())
    assert values(played(source, 40)) == first
    assert "played again from the start: the same samples as before" in " ".join(source.remarks())


def test_after_a_recovery_it_goes_on_at_the_next_sample(ramp):
    source = replay(ramp, unit="V", sample_rate=HZ_10)
    source.open()
    source.configure(0.1)
    source.start(0, 60)
    assert source.fetch().first == 0
    assert source.recover() == 60
    assert played(source, 60, first=60) == []
    rest = played(source, 100, first=60)
    assert (rest[0].first, values(rest)[0]) == (60, 60.0)
    assert rest[0].time_s[0] == pytest.approx(6.0)


def test_gaps_in_the_time_stamps_are_jumps_of_the_position(tmp_path):
    path = tmp_path / "gaps.csv"
    stamps = [0, 100, 200, 700, 800, 800, 900]
    path.write_text("ms,gyro\n" + "".join(f"{1000 + ms},{ms}\n" for ms in stamps * 1))
    path.write_text(
        path.read_text() + "".join(f"{2000 + 100 * n},{1000 + 100 * n}\n" for n in range(200))
    )
    source = replay(path, unit="V", column="gyro", time_column="ms", time_unit="ms")
    source.open()
    sampling = source.configure(0.1)
    assert sampling.interval_s == pytest.approx(0.1)
    blocks = played(source)
    assert [(block.first, len(block.flags)) for block in blocks] == [(0, 3), (7, 203)]
    assert blocks[1].time_s[0] == pytest.approx(0.7)
    told = " ".join(source.remarks())
    assert (
        "gaps (intervals above 1.5 × the median): 1, with room for 4 samples, the longest 0.5 s after 1.2 s"
        in told
    )
    assert "1 repeated, 0 gone back, 0 missing" in told


def test_a_column_that_is_no_time_is_refused(ramp, tmp_path):
    path = tmp_path / "coarse.csv"
    path.write_text("t,g\n" + "".join(f"{row // 10},{row}\n" for row in range(100)))
    with pytest.raises(InstrumentError, match=r"90 time stamps repeat.*give 'sample_rate' instead"):
        replay(path, unit="V", column="g", time_column="t").open()


def test_a_rate_that_the_stamps_contradict_is_refused(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("t,g\n" + "".join(f"{row / 100},{row}\n" for row in range(100)))
    with pytest.raises(InstrumentError, match="10 Hz is stated, its time stamps say 100 Hz"):
        replay(path, unit="V", column="g", time_column="t", sample_rate=HZ_10).open()


def test_what_is_missing_is_flagged_and_counted(tmp_path):
    path = tmp_path / "data.txt"
    path.write_text("1\nNaN\n3\ninf\n")
    source = replay(path, unit="V", sample_rate=HZ_10)
    source.open()
    source.configure(0.1)
    (block,) = played(source)
    assert block.flags.tolist() == [0, SampleFlag.NOT_A_NUMBER, 0, SampleFlag.OVERLOAD]
    assert source.remarks() == (
        "data.txt: 4 samples from positions 1 to 4 of the window",
        "data.txt: 2 samples are missing, infinite or not a number",
    )


@pytest.mark.parametrize(
    ("settings", "fault"),
    [
        ({"unit": "V"}, "sampling rate is not known; give 'sample_rate'"),
        ({"sample_rate": HZ_10}, "unit of its values is not known; give 'unit'"),
        ({"unit": "V", "sample_rate": HZ_10, "array": "x", "where": {"a": 1}}, "has no column 'a'"),
    ],
)
def test_what_the_file_does_not_say_is_asked_for(ramp, settings, fault):
    source = replay(ramp, **settings)
    with pytest.raises((InstrumentError, RecordingError), match=fault):
        source.open() and source.configure(0.1) and played(source)


@pytest.mark.parametrize(
    ("settings", "fault"),
    [
        ({"unit": "m"}, "neither a voltage nor a rate nor 'count'"),
        ({"unit": "furlong"}, "no unit"),
        (
            {"unit": "V", "scale_factor": Quantity(131.0, "count/(deg/s)")},
            "'scale_factor' is for the unit 'count'",
        ),
        ({"column": "gx", "columns": {"x": "gx"}}, "give one of them"),
        ({"columns": {"time_s": "gx"}}, "'time_s' cannot name a column"),
        ({"columns": {"x": "gx"}, "auxiliary": {"x": BESIDE}}, "an axis and an auxiliary column"),
        ({"scale": 0.0}, "scale is 0"),
        ({"scale": float("nan")}, "scale is nan"),
        ({"first": 0}, "rows count from 1"),
        ({"first": 5, "last": 4}, "rows count from 1"),
        ({"start": Quantity(5.0, "s"), "end": Quantity(5.0, "s")}, "not after its start"),
        ({"sample_rate": Quantity(-1.0, "Hz")}, "more than 0"),
        ({"time_unit": "V"}, "cannot be converted"),
        ({"time_unit": "sample"}, "needs 'sample_rate'"),
    ],
)
def test_settings_without_sense_are_refused_at_the_door(settings, fault):
    with pytest.raises(ValueError, match=fault):
        ReplaySettings(**settings)


@pytest.mark.parametrize("complete", [True, False])
def test_our_own_recording_plays_with_its_gaps_its_unit_and_its_duty(tmp_path, complete):
    header = RecordingHeader(
        run_id="r",
        item="static-1-r1",
        attempt=1,
        serial_number="1",
        model="M",
        spec_sha256="0",
        started_utc=datetime(2026, 1, 1, tzinfo=UTC),
        planned_samples=8,
        sampling=Sampling(interval_s=1.0, aperture_s=0.2, readings=4, unit="V", noise=2e-6, range=10.0),
        source=Identity(manufacturer="HP", model="34401A", serial_number="0"),
    )
    with RecordingWriter(tmp_path, header) as writer:
        for first in (0, 6):
            index = np.arange(first, first + 4)
            flags = (index == 7).astype(np.uint8)
            writer.push(Block(first=first, time_s=index * 1.0, values=index[:, None] * 1.0, flags=flags))
        recording = writer.close(complete=complete)
    source = replay(tmp_path / recording.path)
    source.open()
    assert source.configure(1.0) == header.sampling
    blocks = played(source)
    assert [(block.first, len(block.flags)) for block in blocks] == [(0, 4), (6, 4)]
    assert blocks[1].flags.tolist() == [0, SampleFlag.NOT_A_NUMBER, 0, 0]
    assert source.configure(2.0).noise == pytest.approx(2e-6 / np.sqrt(2))


@pytest.fixture
def data(real_data: Path) -> Path:
    return real_data


def test_the_adis16405_at_rest(data):
    source = replay(
        data / "adis16405-static" / "gyro_lsb.npz",
        array="gyro_lsb",
        column=3,
        unit="deg/s",
        scale=0.05,
        sample_rate=Quantity(100.0, "Hz"),
    )
    source.open()
    source.configure(0.01)
    with np.load(data / "adis16405-static" / "gyro_lsb.npz") as file:
        expected = file["gyro_lsb"][:, 2] * 0.05
    assert np.allclose(values(played(source)), expected, rtol=1e-12, atol=0)


def test_the_mpu6050_at_rest(data):
    source = replay(
        data / "mpu6050-static" / "static_449s.csv",
        column="gz",
        unit="count",
        scale_factor=Quantity(131.0, "count/(deg/s)"),
        sample_rate=Quantity(100.0, "Hz"),
    )
    source.open()
    source.configure(0.01)
    found = values(played(source))
    assert len(found) == 44_930
    assert found[:2] == pytest.approx([-53 / 131, -75 / 131])


def test_a_part_of_the_annotated_session(data):
    source = replay(
        data / "imucal-ferraris" / "annotated_session.csv",
        column="gyr_z",
        time_column="samples",
        time_unit="sample",
        sample_rate=Quantity(204.8, "Hz"),
        where={"part": "z_p"},
        unit="deg/s",
    )
    source.open()
    source.configure(1 / 204.8)
    (block,) = played(source)
    assert len(block.flags) == 881
    assert "no jitter" in " ".join(source.remarks())


@pytest.mark.parametrize("name", ["Auto_1", "Auto_2", "Auto_3", "Auto_4", "Manual_1", "Manual_2"])
def test_the_spin_tables_first_row_and_gaps_are_found(data, name):
    path = data / "spin-table-2020" / f"Unit7_Gyro_{name}"
    table = np.loadtxt(path, comments="%")
    for settings in (
        {"column": 2, "time_column": 1},
        {"column": "Gyro Output (rads/s)", "time_column": "Time (s)", "scale": -1.0},
    ):
        source = replay(path, unit="rad/s", **settings)
        source.open()
        assert source.configure(0.01).interval_s == pytest.approx(0.01)
        blocks = played(source)
        assert [(block.first, len(block.flags)) for block in blocks[:1]] == [(0, 1)]
        assert blocks[1].first == round(table[1, 0] / 0.01)
        sign = settings.get("scale", 1.0)
        assert values(blocks) == pytest.approx(np.degrees(table[:, 1] * sign).tolist(), rel=1e-9)
        assert "gaps (intervals above 1.5 × the median)" in " ".join(source.remarks())
