"""Several columns of a file play side by side: axes, a reference rate, a temperature."""

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from gyrotest.clock import RealClock
from gyrotest.errors import InstrumentError, RecordingError
from gyrotest.instruments.replay import Replay
from gyrotest.instruments.replay_settings import AuxiliaryColumn, ReplaySettings
from gyrotest.recordings.writer import RecordingWriter
from gyrotest.records.recording import (
    Auxiliary,
    Block,
    Identity,
    RecordingHeader,
    SampleFlag,
    Sampling,
)
from gyrotest.specification.parameters import section
from gyrotest.units import Quantity

HZ_10 = Quantity(10.0, "Hz")
ROWS = np.arange(60.0).reshape(20, 3)
REFERENCE = AuxiliaryColumn(column=3, unit="rpm")


def opened(path: Path, interval_s: float = 0.1, **settings) -> tuple[Replay, Sampling]:
    source = Replay(str(path), ReplaySettings(**settings), clock=RealClock())
    source.open()
    return source, source.configure(interval_s)


def played(source: Replay, count: int = 10**9) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions, values and flags."""
    source.start(0, count)
    blocks = []
    while (block := source.fetch()) is not None:
        blocks.append(block)
    return (
        np.concatenate([np.arange(len(one.flags)) + one.first for one in blocks]),
        np.concatenate([one.values for one in blocks]),
        np.concatenate([one.flags for one in blocks]),
    )


def csv(path: Path, rows=ROWS, names: str = "gx,gy,enc") -> Path:
    lines = [names, *(",".join(str(one) for one in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_axes_and_what_is_recorded_beside_them_come_in_one_acquisition(tmp_path):
    source, sampling = opened(
        csv(tmp_path / "a.csv"),
        columns={"x": "gx", "y": 2},
        auxiliary={"reference": REFERENCE, "raw": AuxiliaryColumn(column=3, unit="m", scale=2.0)},
        unit="rad/s",
        sample_rate=HZ_10,
    )
    assert (sampling.channels, sampling.unit) == (("x", "y"), "deg/s")
    assert sampling.auxiliary == (
        Auxiliary(name="reference", unit="deg/s"),
        Auxiliary(name="raw", unit="m"),
    )
    _, values, flags = played(source)
    factors = [np.degrees(1.0), np.degrees(1.0), 6.0, 2.0]
    np.testing.assert_allclose(values, ROWS[:, [0, 1, 2, 2]] * factors, rtol=1e-12)
    assert not flags.any()


def written(tmp_path: Path, form: str) -> tuple[Path, dict]:
    """The same rows in a format, and the settings that choose from it."""
    named = {"columns": {"x": "gx", "y": "gy"}, "auxiliary": {"reference": "enc"}}
    numbered = {"columns": {"x": 1, "y": 2}, "auxiliary": {"reference": 3}}
    apart = {"gx": ROWS[:, 0], "gy": ROWS[:, 1], "enc": ROWS[:, 2]}
    path = tmp_path / f"a.{form}"
    if form == "csv":
        return csv(path), named
    if form == "parquet":
        import pyarrow as pa
        import pyarrow.parquet as pq

        pq.write_table(pa.table(apart), path)
        return path, named
    if form == "npy":
        np.save(path, ROWS)
        return path, numbered
    if form == "npz":
        np.savez(path, **apart)
        return path, named
    if form == "mat":
        from scipy.io import savemat

        savemat(path, apart)
        return path, named
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for name, values in apart.items():
            file[name] = values
    return path, named


@pytest.mark.parametrize("form", ["csv", "parquet", "npy", "npz", "mat", "h5"])
def test_every_format_gives_several_columns_or_several_arrays(tmp_path, form):
    path, chosen = written(tmp_path, form)
    auxiliary = {
        name: AuxiliaryColumn(column=column, unit="rpm") for name, column in chosen["auxiliary"].items()
    }
    source, _ = opened(
        path, columns=chosen["columns"], auxiliary=auxiliary, unit="deg/s", sample_rate=HZ_10
    )
    _, values, _ = played(source)
    np.testing.assert_allclose(values, ROWS * [1.0, 1.0, 6.0], rtol=1e-12)


def test_all_columns_are_averaged_alike(tmp_path):
    source, sampling = opened(
        csv(tmp_path / "a.csv"),
        0.4,
        column="gx",
        auxiliary={"reference": REFERENCE},
        unit="V",
        sample_rate=HZ_10,
    )
    assert (sampling.channels, sampling.readings) == (("output",), 4)
    _, values, _ = played(source)
    means = ROWS.reshape(5, 4, 3).mean(axis=1)
    np.testing.assert_allclose(values, means[:, [0, 2]] * [1.0, 6.0], rtol=1e-12)


def test_a_row_without_its_auxiliary_value_is_kept_and_told_and_one_without_its_output_flagged(tmp_path):
    rows = ROWS.copy()
    rows[4, 2] = np.nan
    rows[7, 1] = np.nan
    source, _ = opened(
        csv(tmp_path / "a.csv", rows),
        columns={"x": "gx", "y": "gy"},
        auxiliary={"reference": REFERENCE},
        unit="V",
        sample_rate=HZ_10,
    )
    _, values, flags = played(source)
    assert np.flatnonzero(flags).tolist() == [7]
    assert flags[7] == SampleFlag.NOT_A_NUMBER
    assert np.flatnonzero(np.isnan(values[:, 2])).tolist() == [4]
    assert "a.csv: 'reference' is missing in 1 of them" in source.remarks()


def test_gaps_by_the_time_column_are_gaps_of_all_columns(tmp_path):
    times = np.array([0.0, 0.1, 0.2, 0.6, 0.7])
    source, _ = opened(
        csv(tmp_path / "a.csv", np.column_stack([times, ROWS[:5]]), "t,gx,gy,enc"),
        column="gx",
        time_column="t",
        auxiliary={"reference": AuxiliaryColumn(column="enc", unit="rpm")},
        unit="V",
    )
    positions, values, _ = played(source)
    assert positions.tolist() == [0, 1, 2, 6, 7]
    np.testing.assert_allclose(values[:, 1], 6.0 * ROWS[:5, 2], rtol=1e-12)
    assert any("the longest 0.4 s after 0.2 s" in one for one in source.remarks())


@pytest.mark.parametrize("form", ["csv", "parquet"])
def test_rows_of_one_of_several_contents_play_with_the_gap_between_them(tmp_path, form):
    parts = ["a"] * 3 + ["b"] * 4 + ["c"] * 2
    path = tmp_path / f"p.{form}"
    if form == "csv":
        lines = ["part,gx", *(f"{part},{row}" for row, part in enumerate(parts))]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    else:
        import pyarrow as pa
        import pyarrow.parquet as pq

        pq.write_table(pa.table({"part": parts, "gx": np.arange(9.0)}), path)
    source, _ = opened(path, column="gx", where={"part": ("a", "c")}, unit="count", sample_rate=HZ_10)
    positions, values, _ = played(source)
    assert positions.tolist() == values[:, 0].tolist() == [0, 1, 2, 7, 8]


def test_a_list_of_contents_comes_through_the_station_file():
    tree = {
        "columns": {"x": "gx", "y": 5},
        "auxiliary": {"reference": {"column": "enc", "unit": "rpm", "scale": -1.0}},
        "where": {"part": ["x_a", "x_rot"], "run": [1, 2]},
        "unit": "count",
    }
    found = section(tree, ReplaySettings, ("settings",))
    assert found.complaints == ()
    assert found.record.where == {"part": ("x_a", "x_rot"), "run": (1, 2)}
    assert found.record.auxiliary["reference"].factor(None) == pytest.approx(-6.0)


def test_what_is_wrong_with_an_auxiliary_column_is_told_at_its_place():
    for wrong, told in (
        ({"column": 3, "unit": "RPM"}, "did you mean 'rpm'"),
        ({"column": 3, "unit": "rpm", "scale": 0.0}, "scale is 0"),
        ({"unit": "rpm"}, "column"),
        ({"column": 3, "units": "rpm"}, "unit"),
    ):
        found = section({"auxiliary": {"reference": wrong}}, ReplaySettings, ("settings",))
        (complaint,) = found.complaints
        assert complaint.key[:3] == ("settings", "auxiliary", "reference")
        assert told in complaint.message or told in complaint.key


def test_an_auxiliary_column_of_a_foreign_file_needs_its_unit(tmp_path):
    with pytest.raises(InstrumentError, match="unit of column 'enc' is not known; give its 'unit'"):
        opened(
            csv(tmp_path / "a.csv"),
            column="gx",
            auxiliary={"reference": AuxiliaryColumn(column="enc")},
            unit="V",
            sample_rate=HZ_10,
        )


def test_a_column_that_is_not_there_is_told_with_those_that_are(tmp_path):
    source, _ = opened(
        csv(tmp_path / "a.csv"),
        column="gx",
        auxiliary={"reference": AuxiliaryColumn(column="encoder", unit="rpm")},
        unit="V",
        sample_rate=HZ_10,
    )
    with pytest.raises(RecordingError, match="has no column 'encoder'; its columns are gx, gy, enc"):
        played(source)


def own_recording(tmp_path: Path) -> Path:
    header = RecordingHeader(
        run_id="r",
        item="static-1-r1",
        attempt=1,
        serial_number="1",
        model="M",
        spec_sha256="0",
        started_utc=datetime(2026, 1, 1, tzinfo=UTC),
        planned_samples=20,
        sampling=Sampling(
            interval_s=0.1,
            aperture_s=0.1,
            unit="deg/s",
            channels=("x", "y"),
            auxiliary=(Auxiliary(name="temperature", unit="degC"),),
            offsets_s=(0.0, 0.01, 0.02),
        ),
        source=Identity(manufacturer="Sensonor", model="STIM210", serial_number="0"),
    )
    with RecordingWriter(tmp_path, header) as writer:
        writer.push(
            Block(
                first=0,
                time_s=np.arange(20) * 0.1,
                values=ROWS.copy(),
                flags=np.zeros(20, dtype=np.uint8),
            )
        )
        recording = writer.close(complete=True)
    return tmp_path / recording.path


def test_a_recording_of_ours_plays_whole_or_in_the_columns_chosen(tmp_path):
    path = own_recording(tmp_path)
    source, sampling = opened(path)
    assert sampling.channels == ("x", "y")
    assert sampling.auxiliary == (Auxiliary(name="temperature", unit="degC"),)
    assert sampling.offsets_s == (0.0, 0.01, 0.02)
    np.testing.assert_array_equal(played(source)[1], ROWS)
    source, sampling = opened(
        path, column="y", auxiliary={"warmth": AuxiliaryColumn(column="temperature")}
    )
    assert (sampling.channels, sampling.offsets_s) == (("output",), (0.01, 0.02))
    assert sampling.auxiliary == (Auxiliary(name="warmth", unit="degC"),)
    np.testing.assert_array_equal(played(source)[1], ROWS[:, 1:])


def test_a_million_rows_of_four_columns_are_read_in_parts(tmp_path):
    """A tenth of it here: in blocks of many rows, and not row by row."""
    rows = np.round(np.random.default_rng(1).normal(size=(100_000, 4)), 3)
    np.savetxt(tmp_path / "big.csv", rows, delimiter=",", fmt="%.3f")
    source, _ = opened(
        tmp_path / "big.csv",
        columns={"x": 1, "y": 2, "z": 3},
        auxiliary={"reference": AuxiliaryColumn(column=4, unit="deg/s")},
        unit="count",
        sample_rate=HZ_10,
    )
    source.start(0, 100_000)
    sizes, parts = [], []
    while (block := source.fetch()) is not None:
        sizes.append(len(block.flags))
        parts.append(block.values)
    assert min(sizes[:-1]) > 10_000
    np.testing.assert_allclose(np.concatenate(parts), rows, rtol=1e-12)
