"""What is written can be read, is never overwritten, and survives a full disk."""

import hashlib
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gyrotest.errors import RecordingError, RefusedError
from gyrotest.recordings.reader import gaps_in, read_header, read_samples, recover
from gyrotest.recordings.writer import RecordingWriter, check_free_space
from gyrotest.records.recording import Block, Gap


@pytest.fixture
def largest_file() -> Iterator[Callable[[int], None]]:
    """Stand in for a disk that fills up: no file may grow beyond a size."""
    resource = pytest.importorskip("resource", reason="the system cannot limit the size of a file")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    yield lambda size: resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


def push_all(writer: RecordingWriter, block, count: int) -> None:
    for first in range(0, count, 100):
        writer.push(block(first, 100))


def test_a_complete_recording_becomes_one_parquet_file(tmp_path, header, block):
    with RecordingWriter(tmp_path, header) as writer:
        writer.push(block(0, 60))
        writer.push(block(60, 40))
        recording = writer.close(complete=True)
    assert recording.path == "recordings/static-1234-r1-a1.parquet"
    assert [path.name for path in (tmp_path / "recordings").iterdir()] == ["static-1234-r1-a1.parquet"]
    assert recording.samples == 100
    assert recording.complete
    assert recording.gaps == ()
    assert recording.flagged == 15
    assert recording.largest_lateness_s == pytest.approx(0.001)
    content = (tmp_path / recording.path).read_bytes()
    assert recording.sha256 == hashlib.sha256(content).hexdigest()


@pytest.mark.parametrize("complete", [True, False])
def test_what_was_written_is_read(tmp_path, header, block, complete):
    with RecordingWriter(tmp_path, header) as writer:
        writer.push(block(0, 100))
        recording = writer.close(complete=complete)
    path = tmp_path / recording.path
    samples = read_samples(path, own_time=True)
    expected = block(0, 100)
    assert np.array_equal(samples.values, expected.values)
    assert np.array_equal(samples.flags, expected.flags)
    assert np.array_equal(samples.time_s, expected.time_s)
    assert samples.index is None
    assert samples.sampling == header.sampling
    assert not samples.values.flags.writeable
    assert read_header(path) == header


def test_two_channels_keep_their_order(tmp_path, header):
    from dataclasses import replace

    header = replace(header, sampling=replace(header.sampling, channels=("gx", "gy")))
    values = np.array([[1.0, 2.0], [3.0, 4.0]])
    with RecordingWriter(tmp_path, header) as writer:
        writer.push(Block(first=0, time_s=np.zeros(2), values=values, flags=np.zeros(2, np.uint8)))
        recording = writer.close(complete=True)
    assert np.array_equal(read_samples(tmp_path / recording.path).values, values)


def test_not_a_number_survives(tmp_path, header):
    values = np.array([[np.nan], [np.inf], [-0.0]])
    with RecordingWriter(tmp_path, header) as writer:
        writer.push(Block(first=0, time_s=np.zeros(3), values=values, flags=np.full(3, 2, np.uint8)))
        recording = writer.close(complete=True)
    assert read_samples(tmp_path / recording.path).values.tobytes() == values.tobytes()


def test_a_file_of_somebody_else_in_the_folder_does_not_spoil_the_recording(tmp_path, header, block):
    """A virus scanner's or a file browser's: the folder then stays, the recording is the Parquet file."""
    writer = RecordingWriter(tmp_path, header)
    writer.push(block(0, 100))
    (tmp_path / "recordings" / "static-1234-r1-a1" / "Thumbs.db").write_bytes(b"")
    recording = writer.close(complete=True)
    assert recording.path == "recordings/static-1234-r1-a1.parquet"
    assert len(read_samples(tmp_path / recording.path).values) == 100


def test_an_incomplete_recording_keeps_its_segments(tmp_path, header, block):
    with RecordingWriter(tmp_path, header) as writer:
        writer.push(block(0, 10))
    recording = writer.close(complete=False)
    assert recording.path == "recordings/static-1234-r1-a1"
    assert not recording.complete
    segment = tmp_path / recording.path / "0000.arrows"
    assert recording.sha256 == hashlib.sha256(segment.read_bytes()).hexdigest()


def test_a_recording_without_samples_can_be_read(tmp_path, header):
    with RecordingWriter(tmp_path, header) as writer:
        recording = writer.close(complete=True)
    assert recording.samples == 0
    assert recording.largest_lateness_s is None
    assert read_samples(tmp_path / recording.path).values.shape == (0, 1)


def test_a_restart_opens_a_segment_and_names_the_gap(tmp_path, header, block):
    with RecordingWriter(tmp_path, header) as writer:
        writer.push(block(0, 10))
        writer.new_segment(Gap(after=9, missing=5, reason="no reply to READ? within 5 s"))
        writer.push(block(15, 10))
        assert len(list((tmp_path / "recordings/static-1234-r1-a1").iterdir())) == 2
        recording = writer.close(complete=True)
    assert recording.gaps == (Gap(after=9, missing=5, reason="no reply to READ? within 5 s"),)
    samples = read_samples(tmp_path / recording.path)
    assert samples.index is not None
    assert samples.index.tolist() == [*range(10), *range(15, 25)]
    assert [(gap.after, gap.missing) for gap in gaps_in(samples.index)] == [(9, 5)]


def test_a_jump_without_a_restart_is_a_gap_too(tmp_path, header, block):
    with RecordingWriter(tmp_path, header) as writer:
        writer.push(block(3, 10))
        writer.push(block(20, 1))
        recording = writer.close(complete=False)
    assert [(gap.after, gap.missing) for gap in recording.gaps] == [(-1, 3), (12, 7)]


def test_positions_never_go_back(tmp_path, header, block):
    with RecordingWriter(tmp_path, header) as writer:
        writer.push(block(0, 10))
        with pytest.raises(RecordingError, match="sample 9 comes after sample 9"):
            writer.push(block(9, 1))


def test_a_block_of_another_shape_is_refused(tmp_path, header, block):
    wrong = Block(first=0, time_s=np.zeros(2), values=np.zeros((2, 3)), flags=np.zeros(2, np.uint8))
    with RecordingWriter(tmp_path, header) as writer, pytest.raises(RecordingError, match="1 channels"):
        writer.push(wrong)


@pytest.mark.parametrize("complete", [True, False])
def test_an_existing_recording_is_not_overwritten(tmp_path, header, block, complete):
    with RecordingWriter(tmp_path, header) as writer:
        writer.push(block(0, 10))
        recording = writer.close(complete=complete)
    with pytest.raises(RecordingError, match="not overwritten"):
        RecordingWriter(tmp_path, header)
    assert read_samples(tmp_path / recording.path).values.size == 10


def test_nothing_is_accepted_after_the_end(tmp_path, header, block):
    with RecordingWriter(tmp_path, header) as writer:
        writer.close(complete=True)
        with pytest.raises(RecordingError, match="closed"):
            writer.push(block(0, 1))
    assert writer.close(complete=False).complete


def test_slow_blocks_are_written_at_once_and_fast_ones_gathered(tmp_path, header, block):
    now_s = 0.0
    folder = tmp_path / "recordings/static-1234-r1-a1"
    with RecordingWriter(tmp_path, header, monotonic_s=lambda: now_s) as writer:
        writer.push(block(0, 1))
        assert recover(folder).recording.samples == 1
        now_s = 0.1
        writer.push(block(1, 1))
        assert recover(folder).recording.samples == 1
        now_s = 1.0
        writer.push(block(2, 1))
        assert recover(folder).recording.samples == 3
        now_s = 1.1
        writer.push(block(3, 65_536))
        assert recover(folder).recording.samples == 65_539


def test_a_folder_that_cannot_be_made_is_named(tmp_path, header):
    (tmp_path / "recordings").write_text("a file where the folder should be")
    with pytest.raises(RecordingError, match=r"static-1234-r1-a1: cannot be written"):
        RecordingWriter(tmp_path, header)


def test_a_full_disk_keeps_the_batches_before(tmp_path, header, block, ticking, largest_file):
    with RecordingWriter(tmp_path, header, monotonic_s=ticking) as writer:
        largest_file(60_000)
        with pytest.raises(RecordingError, match=r"-a1: cannot be written .* are kept") as refused:
            push_all(writer, block, 100_000)
        with pytest.raises(RecordingError, match="earlier write failed"):
            writer.push(block(200_000, 1))
        recording = writer.close(complete=True)
    assert not recording.complete
    assert recording.samples > 1000
    assert f"the first {recording.samples} of 100 samples" in str(refused.value)
    found = recover(tmp_path / recording.path)
    assert found.damage == ()
    assert found.recording.samples == recording.samples
    kept = read_samples(tmp_path / recording.path)
    assert np.array_equal(kept.values, block(0, recording.samples).values)


def test_a_disk_that_fills_up_at_the_end_keeps_the_segments(
    tmp_path, header, block, ticking, largest_file, caplog
):
    with RecordingWriter(tmp_path, header, monotonic_s=ticking) as writer:
        push_all(writer, block, 20_000)
        writer.new_segment(Gap(after=19_999, missing=0, reason="restart"))
        largest_file(50_000)
        recording = writer.close(complete=True)
        largest_file(10_000_000)
    assert recording.complete
    assert recording.path == "recordings/static-1234-r1-a1"
    assert "cannot become Parquet" in caplog.text
    assert [path.name for path in (tmp_path / "recordings").iterdir()] == ["static-1234-r1-a1"]
    assert np.array_equal(read_samples(tmp_path / recording.path).values, block(0, 20_000).values)


@settings(deadline=None, max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(sizes=st.lists(st.integers(0, 40), max_size=12), slow=st.booleans(), complete=st.booleans())
def test_any_split_into_blocks_gives_the_same_recording(
    tmp_path_factory, header, block, ticking, sizes, slow, complete
):
    folder = tmp_path_factory.mktemp("run")
    first = 0
    with RecordingWriter(folder, header, monotonic_s=ticking if slow else lambda: 0.0) as writer:
        for size in sizes:
            writer.push(block(first, size))
            first += size
        recording = writer.close(complete=complete)
    samples = read_samples(folder / recording.path, own_time=True)
    expected = block(0, first)
    assert recording.samples == first
    assert np.array_equal(samples.values, expected.values)
    assert np.array_equal(samples.flags, expected.flags)
    assert np.array_equal(samples.time_s, expected.time_s)
    assert samples.index is None


def test_room_on_the_disk_is_checked_for_a_folder_that_is_not_there_yet(tmp_path):
    check_free_space(tmp_path / "reports" / "1234", 1000)
    with pytest.raises(RefusedError, match=r"MB are free on the disk"):
        check_free_space(tmp_path / "reports" / "1234", 10**18)
