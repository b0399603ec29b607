"""Frames and datagrams of simulated STIM gyros, against the documented layouts, byte by byte."""

import numpy as np
import pytest

from gyrotest.records.spec import OutputMode
from gyrotest.simulation.checksum import STIM210_CHECKSUM, STIM300_CHECKSUM, FrameChecksum
from gyrotest.simulation.stim_datagrams import Setup, Subject, datagram
from gyrotest.simulation.stim_frames import STIM210, STIM300, Content, FramePacker, StimModel

# Sizes on the wire without line end, by identifier.
STIM300_SIZES = {
    0x90: 18, 0x91: 28, 0x92: 28, 0x93: 38, 0x94: 25, 0xA5: 42, 0xA6: 42, 0xA7: 59,
    0x98: 22, 0x99: 32, 0x9A: 32, 0x9B: 42, 0x9C: 29, 0xAD: 46, 0xAE: 46, 0xAF: 63,
}  # fmt: skip
STIM210_SIZES = {
    0x90: 12, 0x92: 15, 0xA0: 18, 0xA2: 13, 0xA4: 14, 0xA5: 15, 0x99: 19, 0xA6: 20, 0xA8: 21,
}  # fmt: skip


def content(
    rates_dps: tuple[float, float, float], *, status: int = 0, degc: float = 23.0, counter: int = 0
) -> Content:
    return Content(
        counts=np.array(rates_dps)[:, None] * 2.0**14,
        status=np.array([status], dtype=np.uint8),
        temperature_degc=np.array([degc]),
        counter=np.array([counter]),
    )


@pytest.mark.parametrize(
    ("model", "identifier", "size"),
    [
        *((STIM300, identifier, size) for identifier, size in STIM300_SIZES.items()),
        *((STIM210, identifier, size) for identifier, size in STIM210_SIZES.items()),
    ],
)
@pytest.mark.parametrize("crlf", [False, True])
def test_every_kind_has_its_documented_size_and_checksum(
    model: StimModel, identifier: int, size: int, crlf: bool
) -> None:
    packer = FramePacker(model, identifier, crlf=crlf, latency_us=506)
    frame = packer.pack(content((1.0, -2.0, 3.0))).tobytes()
    assert len(frame) == packer.size == size + 2 * crlf
    assert frame[0] == identifier
    message = frame[: size - model.checksum.size]
    assert frame[len(message) : size] == model.checksum.of(message)
    assert frame[size:] == (b"\r\n" if crlf else b"")


def test_known_frames_of_both_models() -> None:
    rates = (1.25, -0.5, 0.0)
    stim300 = FramePacker(STIM300, 0x90, crlf=False, latency_us=506).pack(content(rates, counter=17))
    stim210 = FramePacker(STIM210, 0x90, crlf=False, latency_us=506).pack(content(rates))
    assert stim300.tobytes().hex() == "90005000ffe000000000001101fa3704a010"
    assert stim210.tobytes().hex() == "90005000ffe00000000000e3"


def test_checksums_have_their_check_values() -> None:
    assert STIM300_CHECKSUM.of(b"123456789") == bytes.fromhex("ae24e09d")
    assert (
        STIM300_CHECKSUM.of(b"12345678")
        == FrameChecksum(STIM300_CHECKSUM, 8)
        .of(np.frombuffer(b"12345678", dtype=np.uint8)[:, None])
        .tobytes()
    )
    assert len(STIM210_CHECKSUM.of(b"123456789")) == 1


def test_temperature_counter_and_latency_stand_where_they_should() -> None:
    packer = FramePacker(STIM210, 0xA8, crlf=False, latency_us=0x0102)
    frame = packer.pack(content((0.0, 0.0, 0.0), status=0x12, degc=-1.5, counter=300)).tobytes()
    assert frame[10] == 0x12
    assert frame[11:17] == bytes.fromhex("fe80") * 3
    assert frame[17] == 300 - 256
    assert frame[18:20] == bytes.fromhex("0102")


def test_a_rate_beyond_the_numbers_is_held_at_the_last_one() -> None:
    frame = FramePacker(STIM210, 0x90, crlf=False, latency_us=0).pack(content((600.0, -600.0, 0.0)))
    assert frame.tobytes()[1:7] == bytes.fromhex("7fffff800000")


def setup_of(*, crlf: bool = False, identifier: int = 0x94) -> Setup:
    return Setup(
        identifier=identifier,
        rate_hz=500.0,
        mode=OutputMode.AVERAGE_RATE,
        crlf=crlf,
        bandwidth_hz=130.0,
        baud_rate=921_600,
    )


def test_the_serial_number_is_fourteen_digits_behind_an_n() -> None:
    said = datagram(Subject.SERIAL_NUMBER, STIM300, setup_of(), "N2555-1234")
    assert said[:9] == b"\xb5N" + bytes.fromhex("00000025551234")
    assert said[9:16] == bytes(7)
    assert said[16:] == STIM300_CHECKSUM.of(said[:16])
    ended = datagram(Subject.SERIAL_NUMBER, STIM300, setup_of(crlf=True), "1")
    assert (ended[0], ended[-2:]) == (0xB7, b"\r\n")


def test_the_configuration_says_rate_mode_filters_and_contents() -> None:
    said = datagram(Subject.CONFIGURATION, STIM300, setup_of(), "1")
    assert len(said) == 26
    assert said[3] == 2 << 5 | 8  # 500 Hz, with temperature
    assert said[4] == 2 << 4  # 921600 bit/s
    assert said[5] == 0x72  # three gyros, average rate
    assert (said[6], said[7]) == (0x33, 0x30)  # 131 Hz


@pytest.mark.parametrize(("subject", "size"), [(Subject.PART_NUMBER, 17), (Subject.CONFIGURATION, 23)])
def test_the_stim210_closes_its_datagrams_by_its_own_checksum(subject: Subject, size: int) -> None:
    said = datagram(subject, STIM210, setup_of(identifier=0x99), "1")
    assert len(said) == size
    assert said[-1:] == STIM210_CHECKSUM.of(said[:-1])
