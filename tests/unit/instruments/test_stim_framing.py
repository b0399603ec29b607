"""Frames in a stream of bytes with garbage, losses and interruptions anywhere."""

import numpy as np
import pytest

from gyrotest.instruments.stim.decoding import FrameDecoder
from gyrotest.instruments.stim.framing import Framed, Framer
from gyrotest.instruments.stim.models import STIM210, STIM300
from tests.instruments.stim_unit import crc8, datagram, serial_number, stim210, stim300

DECODER = FrameDecoder(STIM210, STIM210.frame("rate_counter"))


def frame(number: int) -> bytes:
    return stim210(0xA2, (number * 7919, -number, -0x5D5D5E), counter=number)


def numbers(found: Framed) -> list[int]:
    return [int(row[11]) for row in found.frames]


def pushed(framer: Framer, *pieces: bytes) -> tuple[list[int], list[int]]:
    found = [framer.push(piece) for piece in pieces]
    return [n for one in found for n in numbers(one)], [int(n) for one in found for n in one.broken]


def run(first: int, end: int) -> bytes:
    return b"".join(frame(number) for number in range(first, end))


def test_frames_come_out_whole_however_the_bytes_are_cut() -> None:
    data = run(0, 60)
    rng = np.random.default_rng(3)
    for _ in range(20):
        cuts = np.sort(rng.integers(0, len(data), 15)).tolist()
        pieces = [data[a:b] for a, b in zip([0, *cuts], [*cuts, len(data)], strict=True)]
        framer = Framer(DECODER)
        assert pushed(framer, *pieces) == (list(range(60)), [0] * 60)
        assert framer.counts.broken == framer.counts.resynchronised == 0


def test_what_comes_first_may_be_part_of_a_frame_and_is_no_fault() -> None:
    framer = Framer(DECODER)
    assert pushed(framer, run(0, 10)[5:])[0] == list(range(1, 10))
    assert (framer.counts.broken, framer.counts.resynchronised) == (0, 0)


def test_a_frame_with_a_wrong_crc_is_counted_in_its_place() -> None:
    data = bytearray(run(0, 20))
    data[7 * DECODER.size + 4] ^= 1
    framer = Framer(DECODER)
    found, broken = pushed(framer, bytes(data))
    assert found == [*range(7), *range(8, 20)]
    assert broken == [0] * 7 + [1] + [0] * 11
    assert (framer.counts.broken, framer.counts.resynchronised) == (1, 0)


def test_several_wrong_frames_in_a_row_keep_their_places() -> None:
    data = bytearray(run(0, 20))
    for number in (7, 8, 9):
        data[number * DECODER.size + 4] ^= 1
    framer = Framer(DECODER)
    found, broken = pushed(framer, bytes(data[:100]), bytes(data[100:]))
    assert found == [*range(7), *range(10, 20)]
    assert sum(broken) == framer.counts.broken == 3
    assert broken[7] == 3


def test_a_lost_byte_costs_one_frame() -> None:
    data = run(0, 20)
    framer = Framer(DECODER)
    found, broken = pushed(framer, data[:95] + data[96:])
    assert found == [*range(7), *range(8, 20)]
    assert broken[7] == 1
    assert (framer.counts.broken, framer.counts.resynchronised) == (1, 1)


@pytest.mark.parametrize("garbage", [b"\x00", b"\xa2" * 40, b"x" * 1000, frame(3)[:-2]])
def test_step_is_found_again_after_garbage(garbage: bytes) -> None:
    framer = Framer(DECODER)
    found, _ = pushed(framer, run(0, 7), garbage, run(7, 20))
    assert found == list(range(20))
    assert framer.counts.resynchronised == 1
    assert framer.counts.skipped_bytes == len(garbage)


def test_an_answer_between_two_frames_is_skipped() -> None:
    framer = Framer(DECODER)
    answer = datagram(serial_number("00000012345678"), crc8)
    assert pushed(framer, run(0, 7) + answer + run(7, 9))[0] == list(range(9))
    assert framer.counts.broken == 0


def test_noise_gives_no_frames() -> None:
    """An eight-bit checksum fits by chance once in 65,536 bytes; two in a row hardly ever."""
    framer = Framer(DECODER)
    noise = np.random.default_rng(5).bytes(2_000_000)
    assert pushed(framer, *(noise[k : k + 5000] for k in range(0, len(noise), 5000)))[0] == []
    assert len(framer.skipped()) > 1000


def test_frames_that_look_like_frames_inside_do_not_lead_astray() -> None:
    """A frame whose values hold another whole frame's bytes: step is kept by where frames lie."""
    rng = np.random.default_rng(11)
    kind = FrameDecoder(STIM210, STIM210.frame(0x90))
    frames = [
        stim210(0x90, tuple(int(v) for v in rng.integers(-(1 << 23), 1 << 23, 3)))  # type: ignore[arg-type]
        for _ in range(30_000)
    ]
    framer = Framer(kind)
    data = b"".join(frames)
    found = sum(len(framer.push(data[k : k + 4000]).frames) for k in range(0, len(data), 4000))
    assert found == 30_000
    assert framer.counts.broken == framer.counts.resynchronised == 0


def test_line_ends_must_be_where_they_belong() -> None:
    kind = FrameDecoder(STIM300, STIM300.frame("rate"), crlf=True)
    good = b"".join(stim300(counter=n) + b"\r\n" for n in range(6))
    framer = Framer(kind)
    assert len(framer.push(good + stim300() * 4 + good).frames) == 12
