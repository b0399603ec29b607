"""STIM210 and STIM300 over a pseudo-terminal and a socket, fed frame by frame."""

import math
import socket
from typing import Any

import numpy as np
import pytest

from gyrotest.errors import (
    InstrumentError,
    InstrumentIdentityError,
    InstrumentProtocolError,
    InstrumentTimeoutError,
)
from gyrotest.instruments.stim.settings import Stim210Settings, Stim300Settings
from gyrotest.instruments.stim210 import Stim210
from gyrotest.instruments.stim300 import Stim300
from gyrotest.ports import DigitalGyro
from gyrotest.records.bench import Device
from gyrotest.records.recording import Block, SampleFlag
from gyrotest.records.spec import OutputMode
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.server import has_pty
from gyrotest.units import Quantity

if not has_pty():
    pytest.skip("this platform has no pseudo-terminals", allow_module_level=True)

from tests.instruments.stim_unit import (
    Unit,
    configuration,
    crc8,
    crc32,
    datagram,
    serial_number,
    stim210,
    stim300,
    unit,
)

RATE = Quantity(125.0, "Hz")
COUNTS = 2.0**14


def frame(number: int) -> bytes:
    return stim210(0xA2, (number, 2 * number, -number), counter=16 * number)


def gyro(served: Unit, clock: VirtualClock, **settings: Any) -> Stim210:
    given: dict[str, Any] = {"frame": "rate_counter", "sample_rate": RATE, "ask": False, **settings}
    return Stim210(served.resource, Stim210Settings(**given), clock=clock, io_timeout_s=0.5)


def begun(
    served: Unit, clock: VirtualClock, samples: int, *, interval_s: float = 0.008, **settings: Any
) -> Stim210:
    source = gyro(served, clock, **settings)
    source.open()
    source.configure(interval_s)
    source.start(0, samples)
    return source


def run(source: Stim210 | Stim300) -> list[Block]:
    return list(iter(source.fetch, None))


def test_every_sample_arrives_at_its_position_with_its_values() -> None:
    clock = VirtualClock()
    with unit(clock, frame) as served:
        source = begun(served, clock, 3000)
        blocks = run(source)
        source.close()
    values = np.concatenate([block.values for block in blocks]) * COUNTS
    first = values[0, 0]
    assert np.array_equal(values[:, 0], first + np.arange(3000))
    assert np.array_equal(values[:, 1], 2 * values[:, 0])
    assert np.array_equal(values[:, 2], -values[:, 0])
    times = np.concatenate([block.time_s for block in blocks])
    assert np.allclose(times, 0.008 * np.arange(3000), atol=1e-12)
    assert source.remarks() == ("STIM210: no sample lost",)


def test_a_stim300_is_read_with_its_temperatures() -> None:
    clock = VirtualClock()

    def warm(number: int) -> bytes:
        made = stim300(
            0xA7, (number, 0, 0), clusters=2, temperatures=(6400, 6656, 6912), counter=16 * number
        )
        return made + b"\r\n"

    with unit(clock, warm) as served:
        settings = Stim300Settings(
            frame="rate_acceleration_inclination_temperature", sample_rate=RATE, crlf=True, ask=False
        )
        source = Stim300(served.resource, settings, clock=clock)
        source.open()
        sampling = source.configure(0.008)
        source.start(0, 400)
        blocks = run(source)
    assert sampling.columns == ("x", "y", "z", "temperature_x", "temperature_y", "temperature_z")
    assert {one.unit for one in sampling.auxiliary} == {"degC"}
    assert (sampling.unit, sampling.range) == ("deg/s", 400.0)
    values = np.concatenate([block.values for block in blocks])
    assert values.shape == (400, 6)
    assert np.unique(values[:, 3:], axis=0).tolist() == [[25.0, 26.0, 27.0]]


def test_a_socket_does_as_well() -> None:
    clock = VirtualClock()
    with socket.create_server(("127.0.0.1", 0)) as server:
        settings = Stim210Settings(frame="rate_counter", sample_rate=RATE, ask=False)
        resource = f"TCPIP::127.0.0.1::{server.getsockname()[1]}::SOCKET"
        source = Stim210(resource, settings, clock=clock)
        source.open()
        peer, _ = server.accept()
        sent = 0

        def send(now_s: float) -> None:
            nonlocal sent
            due = round(now_s / 0.008 - 0.01)
            peer.sendall(b"".join(frame(number) for number in range(sent, due)))
            sent = due

        clock.subscribe(send)
        source.configure(0.008)
        source.start(0, 500)
        assert sum(len(block.flags) for block in run(source)) == 500
        source.start(0, 5000)
        clock.unsubscribe(send)
        peer.close()
        with pytest.raises(InstrumentError, match="connection lost: the peer closed the connection"):
            run(source)
        source.close()


def test_wrong_and_lost_frames_are_gaps_at_their_place_and_counted() -> None:
    clock = VirtualClock()
    with unit(clock, frame) as served:
        source = begun(served, clock, 2000)
        next_one = served.sent
        served.spoilt = {
            next_one + 300: lambda one: one[:5] + b"\x55" + one[6:],
            next_one + 700: lambda one: one[:-3],
            next_one + 900: lambda one: b"garbage" + one,
        }
        served.lost = {next_one + 1200, next_one + 1201}
        blocks = run(source)
    numbers = np.concatenate([block.values[:, 0] for block in blocks]) * COUNTS
    positions = np.concatenate([np.arange(b.first, b.first + len(b.flags)) for b in blocks])
    assert np.array_equal(numbers - numbers[0], positions)
    missing = sorted(set(range(2000)) - set(positions.tolist()))
    assert np.diff(missing).tolist() == [400, 500, 1]
    assert source.remarks() == (
        "STIM210: 4 samples lost in 3 gaps",
        "STIM210: 2 frames with bad CRC",
        "STIM210: step with the frames lost 2 times, 17 bytes skipped",
    )


def test_frames_are_averaged_to_the_interval_and_one_that_misses_a_frame_is_missing() -> None:
    clock = VirtualClock()
    with unit(clock, frame) as served:
        source = gyro(served, clock)
        source.open()
        sampling = source.configure(0.4)
        assert (sampling.interval_s, sampling.aperture_s, sampling.readings) == (0.4, 0.008, 50)
        source.start(0, 40)
        served.lost = {served.sent + 50 * 10}
        blocks = run(source)
    positions = [b.first + k for b in blocks for k in range(len(b.flags))]
    assert len(positions) == 39
    values = np.concatenate([block.values[:, 0] for block in blocks]) * COUNTS
    assert np.array_equal(values, values[0] + 50.0 * np.array(positions))
    assert source.remarks() == ("STIM210: 1 sample lost in 1 gap",)


@pytest.mark.parametrize("interval_s", [0.004, 0.012, 0.1])
def test_an_interval_that_is_no_multiple_of_the_period_is_refused(interval_s: float) -> None:
    clock = VirtualClock()
    with unit(clock, frame) as served:
        source = gyro(served, clock)
        source.open()
        with pytest.raises(InstrumentError, match=r"is no whole multiple; the shortest is 0\.008 s"):
            source.configure(interval_s)


def test_increments_are_rates() -> None:
    clock = VirtualClock()
    with unit(clock, lambda number: stim210(0xA2, (1 << 14, 0, 0), counter=16 * number)) as served:
        source = begun(served, clock, 10, interval_s=0.08, mode=OutputMode.INCREMENTAL_ANGLE)
        values = np.concatenate([block.values for block in run(source)])
    assert np.allclose(values[:, 0], 2.0**-7 / 0.008)


def test_start_up_is_waited_out_and_overload_is_flagged() -> None:
    clock = VirtualClock()

    def starting(number: int) -> bytes:
        status = 0x40 if number < 500 else 0x11 if number == 900 else 0
        return stim210(0xA2, (number, 0, 0), status=status, counter=16 * number)

    with unit(clock, starting) as served:
        source = begun(served, clock, 1000)
        blocks = run(source)
    assert blocks[0].values[0, 0] * COUNTS == 500
    flags = np.concatenate([block.flags for block in blocks])
    assert np.flatnonzero(flags).tolist() == [400]
    assert flags[400] == SampleFlag.OVERLOAD


def test_what_is_lost_adds_up_over_the_steps_of_an_acquisition() -> None:
    clock = VirtualClock()
    with unit(clock, frame) as served:
        source = gyro(served, clock)
        source.open()
        source.configure(0.008)
        for _ in range(3):
            source.start(0, 500)
            served.lost = {served.sent + 100}
            run(source)
            clock.advance(3.0)
        assert source.remarks() == ("STIM210: 3 samples lost in 3 gaps",)
        source.configure(0.008)
        assert source.remarks() == ("STIM210: no sample lost",)


def test_a_unit_outside_its_conditions_is_told_and_goes_on() -> None:
    clock = VirtualClock()

    def hot(number: int) -> bytes:
        return stim210(0xA2, status=0x20 * (900 <= number < 910), counter=16 * number)

    with unit(clock, hot) as served:
        source = begun(served, clock, 1000)
        flags = np.concatenate([block.flags for block in run(source)])
    assert not flags.any()
    told = "STIM210: 10 frames from outside the operating conditions, as the unit says"
    assert source.remarks()[1] == told


def test_a_unit_that_was_exchanged_says_so_at_the_next_record() -> None:
    clock = VirtualClock()
    with unit(clock, frame) as served:
        served.answers = answers(crc8)
        source = gyro(served, clock, ask=True)
        source.open()
        source.configure(0.008)
        served.answers[b"I"] = datagram(serial_number("00000000000099"), crc8)
        source.configure(0.008)
    assert source.device().serial_number == "99"


def test_a_unit_that_was_starting_when_it_was_asked_is_asked_again() -> None:
    clock = VirtualClock()
    with unit(clock, frame) as served:
        source = gyro(served, clock, ask=True)
        assert source.open().serial_number == ""
        served.answers = answers(crc8)
        source.configure(0.008)
    assert source.device().serial_number == "12345678"


def test_a_unit_that_never_ends_starting_up_is_refused() -> None:
    clock = VirtualClock()
    with unit(clock, lambda number: stim210(0xA2, status=0x40, counter=16 * number)) as served:
        source = gyro(served, clock)
        source.open()
        source.configure(0.008)
        with pytest.raises(InstrumentError, match="has been starting up for 10 s"):
            source.start(0, 100)


def test_a_wrong_baud_rate_is_said_within_seconds() -> None:
    clock = VirtualClock()
    noise = np.random.default_rng(2)
    with unit(clock, lambda _: noise.bytes(9)) as served:
        source = gyro(served, clock)
        source.open()
        began_s = clock.now_s()
        with pytest.raises(InstrumentProtocolError, match=r"is baud_rate that of the unit\?") as raised:
            source.configure(0.008)
        assert clock.now_s() - began_s < 5.0
    assert "no rate_counter frame (0xA2) of a STIM210" in str(raised.value)


@pytest.mark.parametrize(
    ("sent", "named"),
    [
        (stim300(0x90), r"rate frames \(0x90\) of a STIM300 without CR LF"),
        (stim210(0x90), r"rate frames \(0x90\) of a STIM210 without CR LF"),
        (stim210(0xA2, counter=0) + b"\r\n", r"rate_counter frames \(0xA2\) of a STIM210 with CR LF"),
    ],
)
def test_other_frames_than_expected_are_named(sent: bytes, named: str) -> None:
    clock = VirtualClock()
    with unit(clock, lambda _: sent) as served:
        source = gyro(served, clock)
        source.open()
        with pytest.raises(InstrumentProtocolError, match=f"they are {named}: correct the station's"):
            source.configure(0.008)


def test_a_silent_unit_is_a_time_out() -> None:
    clock = VirtualClock()
    with unit(clock, frame) as served:
        served.silent = True
        source = gyro(served, clock)
        source.open()
        with pytest.raises(
            InstrumentTimeoutError, match=r"nothing has arrived for 0\.5 s; is the unit powered"
        ):
            source.configure(0.008)


def test_a_unit_that_falls_silent_goes_on_where_it_would_be() -> None:
    clock = VirtualClock()
    with unit(clock, frame) as served:
        source = begun(served, clock, 3000)
        before = source.fetch()
        assert before is not None
        served.silent = True
        with pytest.raises(InstrumentTimeoutError):
            run(source)
        served.silent = False
        clock.advance(5.0)
        first = source.recover()
        source.start(first, 3000)
        after = run(source)
    assert after[0].first == first
    last = after[-1].first + len(after[-1].flags) - 1
    assert last == 2999
    numbers = (before.values[0, 0] * COUNTS, after[-1].values[-1, 0] * COUNTS)
    assert numbers[1] - numbers[0] == last - before.first


def test_an_unplugged_port_is_said_at_once() -> None:
    clock = VirtualClock()
    with unit(clock, frame) as served:
        source = begun(served, clock, 3000)
        assert source.fetch() is not None
        served.unplug()
        with pytest.raises(InstrumentError, match=r"connection lost: .*; is the cable plugged in"):
            run(source)
        with pytest.raises(InstrumentError, match="cannot be opened"):
            source.recover()
        source.close()
        source.close()


def test_a_port_that_is_not_there_is_said_when_it_is_opened() -> None:
    settings = Stim210Settings(frame="rate_counter", sample_rate=RATE)
    source = Stim210("ASRL/dev/no-such-port::INSTR", settings, clock=VirtualClock())
    with pytest.raises(InstrumentError, match="ASRL/dev/no-such-port::INSTR: cannot be opened"):
        source.open()
    other = Stim210("GPIB0::4::INSTR", settings, clock=VirtualClock())
    with pytest.raises(InstrumentError, match="is no stream of bytes; write ASRL"):
        other.open()


def answers(check: Any, **settings: Any) -> dict[bytes, bytes]:
    part = bytes.fromhex("b1 08 42 00 2d 05 00 01 2d 00 00 00 00 00 00 44")
    return {
        b"I": datagram(serial_number("00000012345678"), check),
        b"C": datagram(configuration(**settings), check),
        b"N": datagram(part, check),
    }


def test_a_unit_says_who_it_is_and_how_it_is_set() -> None:
    clock = VirtualClock()
    with unit(clock, lambda n: stim300(0x90, (n, 0, 0), counter=16 * n)) as served:
        served.answers = answers(crc32, mode=2, filters=1)
        settings = Stim300Settings(frame="rate", sample_rate=RATE, mode=OutputMode.AVERAGE_RATE)
        source = Stim300(served.resource, settings, clock=clock, serial_number="12345678")
        identity = source.open()
        source.configure(0.008)
        said = source.device()
    assert isinstance(source, DigitalGyro)
    assert (identity.manufacturer, identity.model) == ("Sensonor", "STIM300")
    assert (identity.serial_number, identity.firmware) == ("12345678", "G15")
    assert said == Device(
        serial_number="12345678",
        part_number="84200-050001-0000D",
        mode=OutputMode.AVERAGE_RATE,
        range_dps=400.0,
        bandwidth_hz=33.0,
        sample_rate_hz=125.0,
    )


def test_of_a_unit_that_does_not_answer_the_stations_words_stand() -> None:
    clock = VirtualClock()
    with unit(clock, frame) as served:
        source = gyro(served, clock, ask=True)
        identity = source.open()
        source.configure(0.008)
    assert identity.serial_number == ""
    assert source.device() == Device(mode=OutputMode.RATE, range_dps=400.0)


@pytest.mark.parametrize(
    ("set_up", "message"),
    [
        ({"rate_code": 1}, "its sample_rate is 250 Hz, the station says 125 Hz"),
        ({"mode": 1}, "its mode is incremental_angle, the station says rate"),
        ({"mode": 3}, "its mode is integrated_angle, the station says rate"),
        ({"crlf": True}, "its crlf is True, the station says False"),
    ],
)
def test_a_unit_that_is_set_otherwise_is_refused(set_up: dict[str, Any], message: str) -> None:
    clock = VirtualClock()
    with unit(clock, frame) as served:
        served.answers = answers(crc8, **set_up)
        if set_up.get("crlf"):
            served.answers[b"C"] += b"\r\n"
        source = gyro(served, clock, ask=True)
        source.open()
        with pytest.raises(InstrumentError, match=message):
            source.configure(0.008)


def test_another_unit_than_the_station_names_is_refused() -> None:
    clock = VirtualClock()
    with unit(clock, frame) as served:
        served.answers = answers(crc8)
        settings = Stim210Settings(frame="rate_counter", sample_rate=RATE)
        source = Stim210(served.resource, settings, clock=clock, serial_number="99")
        with pytest.raises(InstrumentIdentityError, match="found serial number 12345678, expected 99"):
            source.open()
        source.close()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"frame": "0x91"}, "no kind of frame of the STIM210"),
        ({"sample_rate": Quantity(100.0, "Hz")}, "none of the STIM210's: write one of 125 Hz"),
        ({"sample_rate": Quantity(2000.0, "Hz"), "baud_rate": 115200}, "too slow .* need 260000 bit/s"),
        ({"range": Quantity(0.0, "deg/s")}, "range 0 deg/s is not more than zero"),
    ],
)
def test_settings_that_cannot_be_are_refused(given: dict[str, Any], message: str) -> None:
    settings: dict[str, Any] = {"frame": "rate_counter", "sample_rate": RATE, **given}
    with pytest.raises(ValueError, match=message):
        Stim210Settings(**settings)


def test_2000_frames_a_second_pass_a_pseudo_terminal_without_loss() -> None:
    clock = VirtualClock()
    made = [stim210(0xA2, (number, 0, 0), counter=number) for number in range(256)]
    with unit(clock, lambda number: made[number % 256], period_s=0.0005) as served:
        source = begun(served, clock, 20_000, interval_s=0.0005, sample_rate=Quantity(2000.0, "Hz"))
        blocks = run(source)
    assert sum(len(block.flags) for block in blocks) == 20_000
    assert math.isclose(blocks[-1].time_s[-1], 19_999 * 0.0005)
