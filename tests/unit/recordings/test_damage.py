"""A stopped writer, a flipped byte, a cut tail: found, told, and everything before it readable."""

import json
import random
import subprocess
import sys
from dataclasses import asdict

import numpy as np
import pytest

from gyrotest.errors import RecordingError
from gyrotest.recordings.reader import read_samples, recover
from gyrotest.recordings.verify import State, verify_folder
from gyrotest.recordings.writer import RecordingWriter
from gyrotest.records.recording import Gap

NAME = "recordings/static-1234-r1-a1"

WRITER = """
import sys
from datetime import UTC, datetime
from pathlib import Path
import numpy as np
from gyrotest.recordings.writer import RecordingWriter
from gyrotest.records.recording import Block, Identity, RecordingHeader, Sampling

header = RecordingHeader(
    run_id="r", item="static-1234-r1", attempt=1, serial_number="1234", model="M", spec_sha256="0",
    started_utc=datetime(2026, 1, 1, tzinfo=UTC), planned_samples=10**9,
    sampling=Sampling(interval_s=1.0, aperture_s=1.0),
    source=Identity(manufacturer="HP", model="34401A", serial_number="0"),
)
ticks = iter(range(10**9))
with RecordingWriter(Path(sys.argv[1]), header, monotonic_s=lambda: float(next(ticks))) as writer:
    first = 0
    while True:
        index = np.arange(first, first + 37)
        writer.push(Block(first=first, time_s=index * 1.0, values=np.sin(index)[:, None],
                          flags=np.zeros(37, np.uint8)))
        first += 37
        sys.stdout.write(f"{first}\\n")
        sys.stdout.flush()
"""


def killed_writer(folder, acknowledgements: int) -> int:
    """Run a writer in a process of its own, kill it, and return how many samples it had pushed."""
    with subprocess.Popen(
        [sys.executable, "-c", WRITER, str(folder)], stdout=subprocess.PIPE, text=True
    ) as child:
        try:
            acknowledged = [int(child.stdout.readline()) for _ in range(acknowledgements)][-1]
        finally:
            child.kill()
    return acknowledged


def written(folder, header, block, ticking, *, segments=1):
    """An incomplete recording of 100 samples a segment, in batches of 10; the folder of its segments."""
    with RecordingWriter(folder, header, monotonic_s=ticking) as writer:
        for segment in range(segments):
            if segment:
                writer.new_segment(Gap(after=segment * 105 - 6, missing=5, reason="meter was away"))
            for first in range(segment * 105, segment * 105 + 100, 10):
                writer.push(block(first, 10))
    return folder / NAME


@pytest.mark.parametrize("seed", range(3))
def test_every_acknowledged_sample_survives_a_kill(tmp_path, seed):
    acknowledged = killed_writer(tmp_path, random.Random(seed).randint(1, 400))
    found = recover(tmp_path / NAME)
    assert found.closed == ""
    assert not found.recording.complete
    assert found.recording.samples >= acknowledged
    finding = verify_folder(tmp_path)[0]
    assert finding.rows == found.recording.samples
    assert finding.state in (State.INCOMPLETE, State.DAMAGED)


def test_a_stopped_writer_is_told_from_an_ended_one(tmp_path, header, block, ticking):
    segment = written(tmp_path, header, block, ticking) / "0000.arrows"
    assert recover(segment.parent).closed == "incomplete"
    whole = segment.read_bytes()
    cuts = [
        size for size in range(len(whole) - 2000, len(whole), 8) if whole_batches(segment, whole[:size])
    ]
    segment.write_bytes(whole[: cuts[0]])
    assert recover(segment.parent).closed == ""
    assert "stopped before the end" in verify_folder(tmp_path)[0].message


def whole_batches(segment, content) -> bool:
    segment.write_bytes(content)
    return recover(segment.parent).damage == ()


@pytest.mark.parametrize("cut", [1, 9, 100, 777, 2000])
def test_a_cut_tail_loses_only_what_was_cut(tmp_path, header, block, ticking, cut):
    segment = written(tmp_path, header, block, ticking) / "0000.arrows"
    whole = segment.read_bytes()
    segment.write_bytes(whole[:-cut])
    found = recover(segment.parent)
    rows = found.recording.samples
    assert rows % 10 == 0
    assert rows >= 100 - 10 * (1 + cut // 300)
    assert verify_folder(tmp_path)[0].rows == rows


def test_a_tail_of_zeros_leaves_the_samples_before(tmp_path, header, block, ticking):
    segment = written(tmp_path, header, block, ticking) / "0000.arrows"
    whole = segment.read_bytes()
    segment.write_bytes(whole[:-1500] + bytes(1500))
    found = recover(segment.parent)
    assert 0 < found.recording.samples < 100
    assert found.closed == ""


def test_no_flipped_bit_changes_what_is_read(tmp_path, header, block, ticking):
    segment = written(tmp_path, header, block, ticking) / "0000.arrows"
    whole = segment.read_bytes()
    expected = block(0, 100)
    chance = random.Random(1)
    noticed = 0
    for _ in range(300):
        at, bit = chance.randrange(len(whole)), chance.randrange(8)
        segment.write_bytes(whole[:at] + bytes([whole[at] ^ (1 << bit)]) + whole[at + 1 :])
        try:
            samples = read_samples(segment.parent, own_time=True)
        except RecordingError:
            noticed += 1
            continue
        rows = len(samples.flags)
        assert np.array_equal(samples.values, expected.values[:rows])
        assert np.array_equal(samples.time_s, expected.time_s[:rows])
        assert np.array_equal(samples.flags, expected.flags[:rows])
    assert noticed > 150


def test_a_flipped_sample_is_found(tmp_path, header, block, ticking):
    segment = written(tmp_path, header, block, ticking) / "0000.arrows"
    whole = segment.read_bytes()
    at = whole.index(block(50, 10).values.tobytes())
    segment.write_bytes(whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :])
    with pytest.raises(RecordingError, match=r"0000\.arrows: damaged after row 50: .*checksum"):
        read_samples(segment.parent)
    found = recover(segment.parent)
    assert found.recording.samples == 50
    finding = verify_folder(tmp_path)[0]
    assert finding.state is State.DAMAGED
    assert finding.rows == 50


def test_a_damaged_segment_does_not_take_the_next_one_along(tmp_path, header, block, ticking):
    folder = written(tmp_path, header, block, ticking, segments=2)
    first = folder / "0000.arrows"
    first.write_bytes(first.read_bytes()[:-1500])
    found = recover(folder)
    assert 100 < found.recording.samples < 200
    assert found.lost_rows == 200 - found.recording.samples
    with pytest.raises(RecordingError, match="rows"):
        read_samples(folder)


def test_a_missing_segment_is_noticed(tmp_path, header, block, ticking):
    folder = written(tmp_path, header, block, ticking, segments=3)
    (folder / "0001.arrows").unlink()
    with pytest.raises(
        RecordingError, match=r"0002\.arrows: begins with row 200, yet 100 rows come before"
    ):
        read_samples(folder)
    assert recover(folder).lost_rows == 100
    assert verify_folder(tmp_path)[0].state is State.DAMAGED


def test_a_flipped_byte_in_parquet_is_found(tmp_path, header, block):
    path, whole = parquet_recording(tmp_path, header, block)
    path.write_bytes(whole[:400] + bytes([whole[400] ^ 16]) + whole[401:])
    with pytest.raises(RecordingError, match="damaged"):
        read_samples(path)
    assert verify_folder(tmp_path)[0].state is State.DAMAGED


def test_no_flipped_bit_in_parquet_changes_what_is_read(tmp_path, header, block):
    path, whole = parquet_recording(tmp_path, header, block)
    expected = block(0, 100)
    chance = random.Random(2)
    noticed = 0
    for _ in range(300):
        at, bit = chance.randrange(len(whole)), chance.randrange(8)
        path.write_bytes(whole[:at] + bytes([whole[at] ^ (1 << bit)]) + whole[at + 1 :])
        try:
            samples = read_samples(path, own_time=True)
        except RecordingError:
            noticed += 1
            continue
        assert np.array_equal(samples.values, expected.values)
        assert np.array_equal(samples.time_s, expected.time_s)
        assert np.array_equal(samples.flags, expected.flags)
        assert samples.index is None
    assert noticed > 150


def parquet_recording(folder, header, block):
    """The path of a complete recording of 100 samples, and its bytes."""
    with RecordingWriter(folder, header) as writer:
        writer.push(block(0, 100))
        recording = writer.close(complete=True)
    path = folder / recording.path
    return path, path.read_bytes()


def test_another_programs_parquet_is_no_recording(tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table({"x": [1.0]}), tmp_path / "other.parquet")
    with pytest.raises(RecordingError, match="no recording of gyrotest"):
        read_samples(tmp_path / "other.parquet")


def run_record(folder, recording, **changes) -> None:
    listed = asdict(recording) | {"header": None} | changes
    record = {"items": [{"attempts": [{"recording": listed}, {"recording": None}]}]}
    (folder / "run.json").write_text(json.dumps(record), encoding="utf-8")


def test_a_recording_is_held_against_the_run_record(tmp_path, header, block):
    with RecordingWriter(tmp_path, header) as writer:
        writer.push(block(0, 100))
        recording = writer.close(complete=True)
    run_record(tmp_path, recording)
    assert [(one.state, one.sha256_agrees, one.good) for one in verify_folder(tmp_path)] == [
        (State.COMPLETE, True, True)
    ]
    run_record(tmp_path, recording, sha256="f" * 64)
    assert verify_folder(tmp_path)[0].state is State.ALTERED
    run_record(tmp_path, recording, path="recordings/elsewhere.parquet")
    assert [one.state for one in verify_folder(tmp_path)] == [State.COMPLETE, State.MISSING]
    (tmp_path / "run.json").write_text("{", encoding="utf-8")
    with pytest.raises(RecordingError, match=r"run\.json: cannot be read"):
        verify_folder(tmp_path)


def test_one_recording_can_be_verified_alone(tmp_path, header, block, ticking):
    folder = written(tmp_path, header, block, ticking)
    assert [one.state for one in verify_folder(folder)] == [State.INCOMPLETE]
    assert [one.state for one in verify_folder(folder.parent)] == [State.INCOMPLETE]


def test_an_empty_folder_has_nothing_to_verify(tmp_path):
    with pytest.raises(RecordingError, match="holds no recordings"):
        verify_folder(tmp_path)
    with pytest.raises(RecordingError, match="does not exist"):
        verify_folder(tmp_path / "nowhere")


def test_every_run_below_a_folder_is_verified(tmp_path, header, block, ticking):
    """`verify_folder` on the folder of all reports: each finding tells its run."""
    for serial in ("1234", "1235"):
        written(tmp_path / serial / "run-1", header, block, ticking)
    (tmp_path / "1235" / "run-2" / "recordings").mkdir(parents=True)  # nothing was recorded there
    findings = verify_folder(tmp_path)
    assert [one.path for one in findings] == [f"1234/run-1/{NAME}", f"1235/run-1/{NAME}"]
    assert {one.state for one in findings} == {State.INCOMPLETE}


def test_an_unreadable_record_does_not_hide_the_other_runs(tmp_path, header, block, ticking):
    for run in ("run-1", "run-2"):
        written(tmp_path / run, header, block, ticking)
    (tmp_path / "run-1" / "run.json").write_text("{", encoding="utf-8")
    first, second = verify_folder(tmp_path)
    assert (first.path, first.state) == ("run-1/run.json", State.DAMAGED)
    assert second.state is State.INCOMPLETE
