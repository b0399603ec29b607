"""Frames of STIM210 and STIM300 to numbers, against an encoder made apart from the driver."""

from typing import Any

import numpy as np
import pytest

from gyrotest.instruments.stim.crc import CRC_8, CRC_32_MPEG_2, ColumnCheck
from gyrotest.instruments.stim.decoding import FrameDecoder
from gyrotest.instruments.stim.models import STIM210, STIM300
from gyrotest.records.recording import SampleFlag
from gyrotest.records.spec import OutputMode
from tests.instruments.stim_unit import crc8, crc32, stim210, stim300

RATES = (1 << 14, -(1 << 23), (1 << 23) - 1)
RATES_DPS = (1.0, -512.0, 512.0 - 2.0**-14)
TEMPERATURES = (6400, -10240, -1)
TEMPERATURES_DEGC = (25.0, -40.0, -1 / 256)

OF_STIM210: dict[int, dict[str, Any]] = {
    0x90: {},
    0x92: {"reserve": b"abc"},
    0xA0: {"temperatures": TEMPERATURES},
    0xA2: {"counter": 200},
    0xA4: {"latency": 40000},
    0xA5: {"counter": 200, "latency": 40000},
    0x99: {"temperatures": TEMPERATURES, "counter": 200},
    0xA6: {"temperatures": TEMPERATURES, "latency": 40000},
    0xA8: {"temperatures": TEMPERATURES, "counter": 200, "latency": 40000},
}
OF_STIM300: dict[int, dict[str, Any]] = {
    identifier: {
        "clusters": clusters,
        "temperatures": TEMPERATURES if warm else None,
        "extra": extra,
        "counter": 200,
        "latency": 40000,
    }
    for identifiers, warm, extra in (
        ((0x90, 0x91, 0x92, 0x93), False, False),
        ((0x94, 0xA5, 0xA6, 0xA7), True, False),
        ((0x98, 0x99, 0x9A, 0x9B), False, True),
        ((0x9C, 0xAD, 0xAE, 0xAF), True, True),
        ((0xF0, 0xF1, 0xF2, 0xF3), False, True),
        ((0xF4, 0xF5, 0xF6, 0xF7), True, True),
    )
    for identifier, clusters in zip(identifiers, (0, 1, 1, 2), strict=True)
}
KINDS = [
    *((STIM210, stim210, identifier, parts) for identifier, parts in OF_STIM210.items()),
    *((STIM300, stim300, identifier, parts) for identifier, parts in OF_STIM300.items()),
]


@pytest.mark.parametrize(("model", "encode", "identifier", "parts"), KINDS)
@pytest.mark.parametrize("end", [b"", b"\r\n"])
def test_every_kind_of_frame_gives_what_was_put_in(
    model: Any, encode: Any, identifier: int, parts: dict[str, Any], end: bytes
) -> None:
    decoder = FrameDecoder(model, model.frame(identifier), crlf=bool(end))
    found = decoder.decode((encode(identifier, RATES, **parts) + end) * 3)
    warm = parts.get("temperatures") is not None
    expected = [*RATES_DPS, *(TEMPERATURES_DEGC if warm else ())]
    assert found.values.tolist() == [expected] * 3
    assert found.whole.all()
    assert not found.flags.any()
    assert (None if found.counter is None else found.counter.tolist()) == (
        [200] * 3 if "counter" in parts else None
    )
    assert (None if found.latency_us is None else found.latency_us.tolist()) == (
        [40000] * 3 if "latency" in parts else None
    )


def test_all_kinds_of_both_models_are_here() -> None:
    assert {frame.identifier for frame in STIM210.frames} == set(OF_STIM210)
    assert {frame.identifier for frame in STIM300.frames} == set(OF_STIM300)


@pytest.mark.parametrize(
    ("model", "frame"),
    [(STIM210, "90005000ffe00000000000e3"), (STIM300, "90005000ffe000000000001101fa3704a010")],
)
def test_frames_known_from_elsewhere_are_read(model: Any, frame: str) -> None:
    found = FrameDecoder(model, model.frame("rate")).decode(bytes.fromhex(frame))
    assert found.whole.all()
    assert found.values.tolist() == [[1.25, -0.5, 0.0]]


def test_the_checksums_have_their_published_check_values() -> None:
    assert CRC_8.of(b"123456789") == 0xFB
    assert CRC_32_MPEG_2.of(b"12345678") == int.from_bytes(crc32(b"12345678"), "big")
    # Nine bytes are filled up with zeros to twelve; without them it would be 0x0376E6E7.
    assert CRC_32_MPEG_2.of(b"123456789") == 0xAE24E09D


@pytest.mark.parametrize(("crc", "slow"), [(CRC_8, crc8), (CRC_32_MPEG_2, crc32)])
def test_columns_are_checked_as_long_division_does(crc: Any, slow: Any) -> None:
    rng = np.random.default_rng(7)
    for size in (11, 14, 20, 59):
        messages = [rng.bytes(size) for _ in range(20)]
        rows = np.array([list(one + slow(one)) for one in messages], dtype=np.uint8)
        check = ColumnCheck(crc, size)
        assert check.passes(np.ascontiguousarray(rows.T)).all()
        rows[np.arange(20), rng.integers(0, rows.shape[1], 20)] ^= np.uint8(0x10)
        assert not check.passes(np.ascontiguousarray(rows.T)).any()


def test_an_increment_is_the_angle_of_one_sample_and_a_mean_rate_a_rate() -> None:
    frame = stim210(0x90, (1 << 21, 1 << 14, 0))
    kind = STIM210.frame("rate")
    turned = FrameDecoder(STIM210, kind, mode=OutputMode.INCREMENTAL_ANGLE, period_s=0.008)
    mean = FrameDecoder(STIM210, kind, mode=OutputMode.AVERAGE_RATE, period_s=0.008)
    assert turned.decode(frame).values.tolist() == [[125.0, 125.0 / 128, 0.0]]
    assert mean.decode(frame).values.tolist() == [[128.0, 1.0, 0.0]]


@pytest.mark.parametrize(
    ("status", "flag"),
    [
        (0x00, SampleFlag.GOOD),
        (0x07, SampleFlag.GOOD),
        (0x40, SampleFlag.START_UP),
        (0x12, SampleFlag.OVERLOAD),
        (0x09, SampleFlag.FAULT),
        (0x80, SampleFlag.FAULT),
        (0x20, SampleFlag.GOOD),
        (0x51, SampleFlag.START_UP | SampleFlag.OVERLOAD),
    ],
)
def test_the_status_becomes_flags(status: int, flag: SampleFlag) -> None:
    of_210 = FrameDecoder(STIM210, STIM210.frame("rate")).decode(stim210(0x90, status=status))
    of_300 = FrameDecoder(STIM300, STIM300.frame("rate")).decode(stim300(0x90, status=status))
    assert (of_210.flags[0], of_300.flags[0]) == (flag, flag)


def test_the_status_of_the_temperatures_counts_too() -> None:
    frame = stim300(0x94, temperatures=(0, 0, 0), temperature_status=0x88)
    found = FrameDecoder(STIM300, STIM300.frame(0x94)).decode(frame)
    assert found.flags.tolist() == [SampleFlag.FAULT]


def test_a_kind_is_named_by_contents_or_identifier() -> None:
    assert STIM210.frame("rate_temperature_counter") is STIM210.frame("0x99") is STIM210.frame(0x99)
    with pytest.raises(ValueError, match=r"no kind of frame of the STIM210: write one of rate \(0x90\)"):
        STIM210.frame("0x93")


def test_half_a_frame_is_refused() -> None:
    with pytest.raises(ValueError, match="reshape"):
        FrameDecoder(STIM210, STIM210.frame("rate")).decode(stim210()[:-1])


def test_more_frames_than_are_worked_on_at_once_stay_in_order() -> None:
    frames = [stim210(0xA2, (one, 0, 0), counter=one) for one in range(256)]
    found = FrameDecoder(STIM210, STIM210.frame(0xA2)).decode(b"".join(frames) * 70)
    assert found.whole.all()
    assert found.counter is not None
    assert np.array_equal(found.counter, np.tile(np.arange(256), 70))
    assert np.array_equal(found.values[:, 0] * 2.0**14, np.tile(np.arange(256.0), 70))
