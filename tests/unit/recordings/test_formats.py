"""Every format gives the same rows; what cannot be read is told with its place."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gyrotest.errors import RecordingError
from gyrotest.recordings.formats import text_fast
from gyrotest.recordings.formats.detect import Format, detect, read_parts
from gyrotest.recordings.formats.selection import Selection

T = np.array([0.0, 0.5, 1.0, 1.5])
G = np.array([1.25, -2.5, 3.0, 4e-3])
TABLE = np.column_stack([T, G])


def rows(path: Path, **selection) -> tuple[list[int], list[float], list[float] | None]:
    parts = list(read_parts(path, Selection(**selection)))
    times = [part.time for part in parts]
    return (
        np.concatenate([part.row for part in parts]).tolist(),
        np.concatenate([part.values for part in parts]).tolist(),
        None if times[0] is None else np.concatenate(times).tolist(),
    )


def npy(path):
    np.save(path, TABLE)


def npz(path):
    np.savez(path, gyro=TABLE, rate=100.0)


def mat(path):
    from scipy.io import savemat

    savemat(path, {"gyro": TABLE, "t": T, "note": "text"})


def mat73(path):
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        # MATLAB's n × 2 array lies in HDF5 as 2 × n.
        file["gyro"] = TABLE.T
        file["gyro"].attrs["MATLAB_class"] = np.bytes_("double")
    with Path(path).open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512))


def hdf5(path):
    import h5py

    with h5py.File(path, "w") as file:
        file["imu/gyro"] = TABLE


def parquet(path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table({"t": T, "gz": G, "part": ["a", "b", "b", "a"]}), path)


def arrow_file(path):
    import pyarrow as pa

    table = pa.table({"t": T, "gz": G.astype(np.float32)})
    with pa.OSFile(str(path), "wb") as sink, pa.ipc.new_file(sink, table.schema) as writer:
        writer.write_table(table)


def arrow_stream(path):
    import pyarrow as pa

    table = pa.table({"t": T, "gz": G})
    with pa.OSFile(str(path), "wb") as sink, pa.ipc.new_stream(sink, table.schema) as writer:
        writer.write_table(table)


@pytest.mark.parametrize(
    ("write", "suffix", "selection", "found"),
    [
        (npy, "npy", {"column": 2, "time_column": 1}, Format.NPY),
        (npz, "npz", {"array": "gyro", "column": 2, "time_column": 1}, Format.NPZ),
        (mat, "mat", {"array": "gyro", "column": 2, "time_column": "t"}, Format.MAT),
        (mat73, "mat", {"array": "gyro", "column": 2, "time_column": 1}, Format.HDF5),
        (hdf5, "h5", {"array": "/imu/gyro", "column": 2, "time_column": 1}, Format.HDF5),
        (parquet, "parquet", {"column": "gz", "time_column": "t"}, Format.PARQUET),
        (arrow_file, "arrow", {"column": "gz", "time_column": 1}, Format.ARROW),
        (arrow_stream, "arrows", {"column": 2, "time_column": "t"}, Format.ARROW),
    ],
)
def test_a_binary_file_gives_its_rows_whatever_its_name(tmp_path, write, suffix, selection, found):
    write(tmp_path / f"file.{suffix}")
    path = (tmp_path / f"file.{suffix}").rename(tmp_path / "file")
    assert detect(path) is found
    number, values, times = rows(path, **selection)
    assert number == [0, 1, 2, 3]
    assert values == pytest.approx(G.tolist(), rel=1e-7)
    assert times == T.tolist()


TEXTS = {
    "one value a line": ("1.25\n-2.5\n3.0\n4e-3\n", {}),
    "comments and blank lines": ("% gyro\n# V\n\n1.25\n-2.5\n% pause\n3.0\n4e-3\n\n% end\n\n", {}),
    "blank lines about the numbers": ("\n\n1.25\n-2.5\n3.0\n4e-3\n\n  \n", {}),
    "blank lines under the names": ("t,gz\n\n \n0,1.25\n0.5,-2.5\n1,3\n1.5,0.004\n\n", {"column": "gz"}),
    "a blank line, a comment, numbers": ("gz\n\n# V\n\n1.25\n-2.5\n3\n.004\n", {"column": "gz"}),
    "a name above": ("Rate in dps\r\n1.25\r\n-2.5\r\n3.0\r\n4e-3\r\n", {}),
    "columns by white space": ("0 1.25\n 0.5   -2.5\n1 3.0\n1.5 4e-3", {"column": 2, "time_column": 1}),
    "csv with header lines": (
        "Fs,2\nMode,1\nt,gz\n0,1.25\n0.5,-2.5\n1,3\n1.5,0.004\n",
        {"column": "gz", "time_column": "t"},
    ),
    "csv without names": ("0,1.25\n.5,-2.5\n1,3.\n1.5,0.004\n", {"column": 2, "time_column": 1}),
    "names and units": ("time;rate\ns;°/s\n0;1.25\n0.5;-2.5\n1;3\n1.5;0.004\n", {"column": "rate"}),
    "decimal comma": (
        "Zeit;Rate\n0;1,25\n0,5;-2,5\n1;3\n1,5;0,004\n",
        {"column": "Rate", "time_column": 1},
    ),
    "tabs and a marked header": (
        "% Time (s)\tRate (dps)\t%17:42\r\n0\t1.25\r\n0.5\t-2.5\r\n1\t3\r\n1.5\t.004\r\n",
        {"column": "Rate (dps)", "time_column": "Time (s)"},
    ),
    "a separator at the end": ("t,gz,\n0,1.25,\n0.5,-2.5,\n1,3,\n1.5,0.004,\n", {"column": "gz"}),
    "quotes": ('"t","g, z"\n"0","1.25"\n"0.5","-2.5"\n"1","3"\n"1.5","0.004"\n', {"column": "g, z"}),
    "a comment among rows": ("t,gz\n0,1.25\n#1,2\n0.5,-2.5\n1,3\n1.5,0.004\n", {"column": "gz"}),
    "lines left out": (
        "9,9\n9,9\nt,gz\n0,1.25\n0.5,-2.5\n1,3\n1.5,0.004\n",
        {"column": 2, "skip_rows": 3},
    ),
}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1", "utf-16"])
@pytest.mark.parametrize("name", TEXTS)
def test_a_text_file_gives_its_rows(tmp_path, name, encoding):
    text, selection = TEXTS[name]
    path = tmp_path / "data.txt"
    path.write_bytes(text.encode(encoding))
    number, values, times = rows(path, **selection)
    assert number == [0, 1, 2, 3]
    assert values == G.tolist()
    assert times == (T.tolist() if "time_column" in selection else None)


def test_missing_cells_are_not_numbers(tmp_path):
    path = tmp_path / "data.csv"
    path.write_text("t,gz\n0,1\n1,\n2,NaN\n3,n/a\n4,--\n5,inf\n")
    _, values, _ = rows(path, column="gz")
    assert np.isnan(values).tolist() == [False, True, True, True, True, False]
    assert values[5] == np.inf


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("t,gz\n0,1\n1,abc\n", r"data\.csv:3: column 'gz': 'abc' is no number"),
        ("t,gz\n0,abc\n1,1\n2,1\n", r"data\.csv:2: column 'gz': 'abc' is no number"),
        ("t,gz\n0,1\n1,1_000\n2,1\n", r"data\.csv:3: column 'gz': '1_000' is no number"),
        ("t,gz\n0,1\n1,0x10\n", r"data\.csv:3: column 'gz': '0x10' is no number"),
        ("t,gz\n0,1\n# note\n1\n2,2\n", r"data\.csv:4: has 1 cells where the other rows have 2"),
        ("t,gz\n0,1\n1,2,3\n2,2\n", r"data\.csv:3: has 3 cells where the other rows have 2"),
        ("t,gyro_z\n0,1\n", r"has no column 'gz'; its columns are t, gyro_z"),
        ("t,gzz\n0,1\n", r"has no column 'gz'; its columns are t, gzz; is 'gzz' meant\?"),
        ("% nothing\n\n", r"data\.csv: holds no rows of data"),
        ("only,words\n", r"data\.csv: holds no rows of data|has no column"),
        ("", r"data\.csv: is empty"),
    ],
)
def test_a_fault_in_a_text_file_is_told_with_its_place(tmp_path, text, fault):
    path = tmp_path / "data.csv"
    path.write_text(text)
    with pytest.raises(RecordingError, match=fault):
        rows(path, column="gz")


@pytest.mark.parametrize(
    "text",
    ["gz\n0,53\n0,61\n-1,2\n", "# V\n\ngz\n\n0,53\n12\n-0,61e-3\n0,5\n", "t,gz\n0,0,1,25\n0,5,-2,5\n"],
)
def test_numbers_with_a_decimal_comma_are_not_taken_for_two_columns(tmp_path, text):
    path = tmp_path / "data.csv"
    path.write_text(text)
    line = text.splitlines().index(next(one for one in text.splitlines() if "gz" in one)) + 1
    with pytest.raises(RecordingError, match=rf"data\.csv:{line}: names .* decimal comma"):
        rows(path, column=2)


@pytest.mark.parametrize(
    "text",
    ["a record\n0,1.25\n1,-2.5\n2,3.0\n3,4e-3\n", "gz\n0;1,25\n1;-2,5\n2;3\n3;0,004\n"],
)
def test_a_title_over_two_columns_is_no_fault(tmp_path, text):
    path = tmp_path / "data.csv"
    path.write_text(text)
    assert rows(path, column=2)[1] == G.tolist()


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("blank", ["", "  "])
@pytest.mark.parametrize(
    ("lines", "column"),
    [
        (["t,gz", "0,1", "1,2", "2,3", "", "3,4", "", "4,5"], "gz"),
        (["gz", "1", "2", "3", "", "4"], "gz"),
        (["", "1", "2", "3", "", "# a pause", "", "4", ""], None),
        (["0 1", "1 2", "", "", "", "2 3"], 2),
        (["1", "2", "3", "4", "", "nan"], None),
    ],
)
def test_a_blank_line_between_numbers_is_told_and_never_skipped(tmp_path, lines, column, blank, end):
    path = tmp_path / "data.csv"
    path.write_bytes(end.join(line or blank for line in lines).encode())
    place = 3 if column == 2 else 5
    with pytest.raises(RecordingError, match=rf"data\.csv:{place}: is blank, between rows of numbers"):
        rows(path, column=column)


@pytest.mark.parametrize("blanks", [1, 3000])
def test_a_blank_line_far_down_is_found_wherever_blocks_end(tmp_path, monkeypatch, blanks):
    path = tmp_path / "data.csv"
    lines = [*(str(row) for row in range(2000)), *[""] * blanks, "2000"]
    path.write_text("\n".join(lines))
    for size in (1000, 1001, 1 << 12):
        monkeypatch.setattr(text_fast, "_BLOCK_BYTES", size)
        with pytest.raises(RecordingError, match=r"data\.csv:2001: is blank"):
            rows(path)


def test_a_fault_far_down_is_found_in_the_line_where_it_is(tmp_path, monkeypatch):
    monkeypatch.setattr(text_fast, "_BLOCK_BYTES", 1 << 12)
    path = tmp_path / "data.csv"
    lines = ["t,gz", *(f"{row},{row * 2}" for row in range(5000))]
    lines[4001] = "4000,8o00"
    path.write_text("\n".join(lines))
    with pytest.raises(RecordingError, match=r"data\.csv:4002: column 'gz': '8o00' is no number"):
        rows(path, column="gz")


def test_rows_after_a_comment_far_down_are_neither_lost_nor_doubled(tmp_path, monkeypatch):
    monkeypatch.setattr(text_fast, "_BLOCK_BYTES", 1 << 12)
    path = tmp_path / "data.csv"
    lines = ["t,gz", *(f"{row},{row * 2}" for row in range(5000))]
    lines.insert(4001, "# a pause")
    path.write_text("\n".join(lines))
    number, values, _ = rows(path, column="gz")
    assert number == list(range(5000))
    assert values == [2.0 * row for row in range(5000)]


@settings(deadline=None, max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    table=st.lists(
        st.tuples(st.floats(allow_infinity=False), st.sampled_from(["a", "b"]), st.integers(-9, 9)),
        min_size=1,
        max_size=30,
    ),
    slow=st.booleans(),
)
def test_the_fast_and_the_careful_way_read_the_same(tmp_path_factory, table, slow):
    path = tmp_path_factory.mktemp("text") / "data.csv"
    lines = [f"{value!r},{part},{count}" for value, part, count in table]
    path.write_text("\n".join(["gz,part,n", *lines, *(["# end"] if slow else [])]))
    number, values, times = rows(path, column="gz", time_column="n", where={"part": "a"})
    expected = [(row, one) for row, one in enumerate(table) if one[1] == "a"]
    assert number == [row for row, _ in expected]
    assert np.array_equal(values, [one[0] for _, one in expected], equal_nan=True)
    assert times == [float(one[2]) for _, one in expected]


@pytest.mark.parametrize("content", ["a", "b"])
def test_rows_of_a_part_keep_their_numbers(tmp_path, content):
    parquet(tmp_path / "p.parquet")
    (tmp_path / "p.csv").write_text("part,gz\na,1.25\nb,-2.5\nb,3\na,0.004\n")
    of_parquet = rows(tmp_path / "p.parquet", column="gz", where={"part": content})
    of_text = rows(tmp_path / "p.csv", column="gz", where={"part": content})
    assert of_parquet == of_text
    assert of_parquet[0] == ([0, 3] if content == "a" else [1, 2])


def test_a_filter_compares_numbers_as_numbers(tmp_path):
    (tmp_path / "p.csv").write_text("mode,gz\n1.0,5\n2,6\n1,7\n")
    assert rows(tmp_path / "p.csv", column="gz", where={"mode": 1})[1] == [5.0, 7.0]


@pytest.mark.parametrize(
    ("write", "name", "selection", "fault"),
    [
        (npy, "f.npy", {"column": 3}, "has no column 3; its 2 columns are 1, 2"),
        (npy, "f.npy", {}, "has 2 columns .* choose one with 'column'"),
        (npy, "f.npy", {"column": 1, "array": "x"}, "leave 'array' out"),
        (npy, "f.npy", {"column": 1, "where": {"part": "a"}}, "'where' is for tables"),
        (npz, "f.npz", {"column": 1}, "holds gyro, rate; choose one with 'array'"),
        (npz, "f.npz", {"column": 1, "array": "gyr"}, "holds no 'gyr', but gyro, rate; is 'gyro' meant"),
        (npz, "f.npz", {"array": "rate"}, "0 dimensions"),
        (mat, "f.mat", {"array": "note"}, "not real numbers"),
        (hdf5, "f.h5", {"array": "imu/giro", "column": 1}, "is 'imu/gyro' meant"),
        (parquet, "f.parquet", {"column": "part"}, "column 'part' holds string and not numbers"),
    ],
)
def test_a_choice_that_the_file_does_not_offer_names_those_that_it_does(
    tmp_path, write, name, selection, fault
):
    write(tmp_path / name)
    with pytest.raises(RecordingError, match=fault):
        rows(tmp_path / name, **selection)


@pytest.mark.parametrize(
    "head",
    [
        b"\x93NUMPY\x01",
        b"PK\x03\x04zip",
        b"\x89HDF\r\n\x1a\n",
        b"MATLAB 5.0 MAT-file",
        b"PAR1",
        b"ARROW1",
        b"a\0b",
    ],
)
def test_a_cut_file_is_a_recording_error(tmp_path, head):
    path = tmp_path / "cut"
    path.write_bytes(head + b"\n1\n2\n")
    with pytest.raises(RecordingError, match="cut"):
        rows(path)


def test_objects_are_never_unpickled(tmp_path):
    np.save(tmp_path / "o.npy", np.array([{}], dtype=object), allow_pickle=True)
    with pytest.raises(RecordingError, match="cannot be read as npy"):
        rows(tmp_path / "o.npy")


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(RecordingError, match=r"gone\.csv: cannot be read: No such file"):
        rows(tmp_path / "gone.csv")


def stamped(path, unit, *, zone=None, kind="timestamp"):
    import pyarrow as pa
    import pyarrow.parquet as pq

    ticks = np.rint(T * {"ms": 1e3, "us": 1e6, "ns": 1e9}[unit]).astype(np.int64)
    begin = 0 if kind == "duration" else 1_700_000_000 * {"ms": 10**3, "us": 10**6, "ns": 10**9}[unit]
    times = pa.array([*(ticks + begin).tolist(), None])
    of = pa.duration(unit) if kind == "duration" else pa.timestamp(unit, tz=zone)
    pq.write_table(pa.table({"t": times.cast(of), "gz": [*G, 9.0]}), path, row_group_size=2)


@pytest.mark.parametrize(
    "made",
    [
        {"unit": "ns"},
        {"unit": "us", "zone": "Europe/Vienna"},
        {"unit": "ms"},
        {"unit": "us", "kind": "duration"},
    ],
)
def test_stamps_of_parquet_are_seconds_since_the_first(tmp_path, made):
    stamped(tmp_path / "t.parquet", **made)
    parts = list(read_parts(tmp_path / "t.parquet", Selection(column="gz", time_column="t")))
    assert all(part.time_in_s for part in parts)
    times = np.concatenate([part.time for part in parts])
    assert times.tolist()[:4] == T.tolist()
    assert np.isnan(times[4])


@pytest.mark.parametrize(
    "stamps",
    [
        ["2026-03-29T00:59:59.5", "2026-03-29T01:00:00", "2026-03-29T01:00:00.5", "2026-03-29T01:00:01"],
        [
            "2026-01-01 00:00:00.500000000Z",
            "2026-01-01 00:00:01Z",
            "2026-01-01 01:00:01.5+01:00",
            "20260101T000002Z",
        ],
    ],
)
def test_dates_in_a_text_are_seconds_since_the_first(tmp_path, stamps):
    path = tmp_path / "data.csv"
    path.write_text(
        "time,gz\n" + "".join(f"{t},{g!r}\n" for t, g in zip(stamps, G.tolist(), strict=True))
    )
    (part,) = read_parts(path, Selection(column="gz", time_column="time"))
    assert part.time_in_s
    assert part.time.tolist() == T.tolist()
    assert part.values.tolist() == G.tolist()


@pytest.mark.parametrize(
    ("stamps", "fault"),
    [
        (["today", "0.5"], r"csv:2: column 'time': 'today' is no number; times are numbers .* or dates"),
        (["2026-01-01T00:00:00", "soon"], r"csv:3: column 'time': 'soon' is no date and time"),
        (
            ["2026-01-01T00:00:00", "2026-01-01T00:00:01Z"],
            r"csv:3: .* has a time zone and others have none",
        ),
        (["0.5", "2026-01-01T00:00:00"], r"csv:3: column 'time': '2026-01-01T00:00:00' is no number"),
    ],
)
def test_stamps_of_two_kinds_are_refused(tmp_path, stamps, fault):
    path = tmp_path / "data.csv"
    path.write_text("time,gz\n" + "".join(f"{t},1.5\n" for t in stamps))
    with pytest.raises(RecordingError, match=fault):
        rows(path, column="gz", time_column="time")


def test_a_row_vector_is_a_column_of_samples(tmp_path):
    np.save(tmp_path / "v.npy", G[np.newaxis, :])
    assert rows(tmp_path / "v.npy")[1] == G.tolist()
