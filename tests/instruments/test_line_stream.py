"""Boards that print their readings: columns, patterns, counters, units, over a pseudo-terminal and TCP."""

import socket
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gyrotest.errors import (
    InstrumentError,
    InstrumentIdentityError,
    InstrumentProtocolError,
    StationError,
)
from gyrotest.instruments.line_stream import LineStream
from gyrotest.instruments.line_stream_settings import LineStreamSettings
from gyrotest.records.recording import Auxiliary, Block, SampleFlag
from gyrotest.records.station import Instrument
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.server import has_pty
from gyrotest.specification.station import instrument_settings
from gyrotest.units import Quantity

if not has_pty():
    pytest.skip("this platform has no pseudo-terminals", allow_module_level=True)

from tests.instruments.stim_unit import Unit, unit

RATE = Quantity(100.0, "Hz")
DPS = Quantity(1.0, "deg/s")
PLAIN: dict[str, Any] = {"columns": ("n", "gx", "t"), "channels": {"gx": DPS}, "sample_rate": RATE}
COUNTED: dict[str, Any] = {**PLAIN, "counter": "n", "counter_modulus": 256}


def line(number: int) -> bytes:
    return b"%d,%d.5,2350\r\n" % (number % 256, number)


def board(served: Unit, clock: VirtualClock, **given: Any) -> LineStream:
    settings = LineStreamSettings(**{**COUNTED, **given})
    return LineStream(served.resource, settings, clock=clock)


def run(source: LineStream) -> list[Block]:
    return list(iter(source.fetch, None))


def acquired(make: Callable[[int], bytes], samples: int = 500, **given: Any) -> list[Block]:
    clock = VirtualClock()
    with unit(clock, make, period_s=0.01) as served:
        source = board(served, clock, **given)
        source.open()
        source.configure(0.01)
        source.start(0, samples)
        blocks = run(source)
        source.close()
    return blocks


def values_of(blocks: list[Block]) -> np.ndarray:
    return np.concatenate([block.values for block in blocks])


def test_columns_become_channels_and_auxiliaries_in_their_units() -> None:
    clock = VirtualClock()
    with unit(clock, line, period_s=0.01) as served:
        source = board(
            served,
            clock,
            channels={"gx": Quantity(0.5, "rad/s")},
            auxiliary={"t": Quantity(0.01, "degC")},
            range=Quantity(1e6, "deg/s"),
        )
        source.open()
        sampling = source.configure(0.01)
        source.start(0, 300)
        values = values_of(run(source))
    assert (sampling.unit, sampling.channels) == ("deg/s", ("gx",))
    assert sampling.auxiliary == (Auxiliary(name="t", unit="degC"),)
    assert sampling.range == 1e6
    assert np.allclose(values[:, 1], 23.5)
    assert np.allclose(np.diff(values[:, 0]), np.degrees(0.5))


def test_a_pattern_finds_its_groups_wherever_they_stand() -> None:
    blocks = acquired(
        lambda n: b"T=%d G: y%d x%d!\n" % (20, -n, n),
        columns=(),
        pattern=r"T=(?P<t>\d+) G: y(?P<y>\S+) x(?P<x>\S+)!",
        channels={"x": DPS, "y": DPS},
        counter=None,
        counter_modulus=None,
    )
    values = values_of(blocks)
    assert values.shape == (500, 2)
    assert np.array_equal(values[:, 0], -values[:, 1])
    assert np.array_equal(np.diff(values[:, 0]), np.ones(499))


@pytest.mark.parametrize(
    ("unit_given", "unit_out", "factor"), [("2 mV", "V", 0.002), ("1 count", "count", 1)]
)
def test_voltages_and_counts_do_as_well(unit_given: str, unit_out: str, factor: float) -> None:
    number, name = unit_given.split()
    clock = VirtualClock()
    with unit(clock, line, period_s=0.01) as served:
        source = board(served, clock, channels={"gx": Quantity(float(number), name)})
        source.open()
        assert source.configure(0.01).unit == unit_out
        source.start(0, 10)
        assert np.allclose(np.diff(values_of(run(source))[:, 0]), factor)


def test_fields_between_spaces_need_no_separator() -> None:
    blocks = acquired(lambda n: b"  %d \t %d   0\n" % (n % 256, n), separator="")
    assert np.array_equal(np.diff(values_of(blocks)[:, 0]), np.ones(499))


@pytest.mark.parametrize("counted", [True, False])
def test_lines_that_do_not_fit_are_lost_samples_and_counted(counted: bool) -> None:
    given = {} if counted else {"counter": None, "counter_modulus": None}
    clock = VirtualClock()
    with unit(clock, line, period_s=0.01) as served:
        source = board(served, clock, **given)
        source.open()
        source.configure(0.01)
        source.start(0, 1000)
        served.spoilt = {
            served.sent + 100: lambda one: one.replace(b",", b";", 1),
            served.sent + 101: lambda one: b"12,abc,3\n",
            served.sent + 400: lambda one: one[:-2],
        }
        blocks = run(source)
    numbers = values_of(blocks)[:, 0]
    positions = np.concatenate([np.arange(b.first, b.first + len(b.flags)) for b in blocks])
    # Two lines that run into one are two lost samples, of which without a counter only one is seen.
    assert np.unique(numbers - numbers[0] - positions).tolist() == ([0.0] if counted else [0.0, 1.0])
    assert len(blocks) > 2
    lost = 4 if counted else 3
    assert source.remarks()[0] == f"line stream: {lost} samples lost in 2 gaps"
    assert source.remarks()[1].startswith("line stream: 3 lines did not fit, the last one '")


def test_lost_lines_are_found_by_the_counter_also_whole_periods_of_it() -> None:
    clock = VirtualClock()
    with unit(clock, line, period_s=0.01) as served:
        source = board(served, clock)
        source.open()
        source.configure(0.01)
        source.start(0, 2000)
        served.lost = {served.sent + 100, *range(served.sent + 700, served.sent + 700 + 256)}
        blocks = run(source)
    numbers = values_of(blocks)[:, 0]
    assert numbers[-1] - numbers[0] == blocks[-1].first + len(blocks[-1].flags) - 1 == 1999
    assert source.remarks() == ("line stream: 257 samples lost in 2 gaps",)


def test_what_is_no_number_and_what_is_at_full_scale_is_flagged() -> None:
    def odd(number: int) -> bytes:
        said = {700: b"nan", 701: b"-250.0", 702: b"inf"}.get(number, b"249.9")
        return b"%d,%s,0\n" % (number % 256, said)

    blocks = acquired(odd, samples=800, range=Quantity(250.0, "deg/s"))
    flags = np.concatenate([block.flags for block in blocks])
    (first,) = np.flatnonzero(flags & SampleFlag.NOT_A_NUMBER)[:1]
    assert flags[first : first + 4].tolist() == [
        SampleFlag.NOT_A_NUMBER,
        SampleFlag.OVERLOAD,
        SampleFlag.NOT_A_NUMBER | SampleFlag.OVERLOAD,
        SampleFlag.GOOD,
    ]
    assert np.count_nonzero(flags) == 3


def test_commands_make_the_board_send_and_stop_and_say_who_it_is() -> None:
    clock = VirtualClock()
    with unit(clock, line, period_s=0.01) as served:
        served.answers = {b"id?": b"SN 0042\n"}
        source = board(
            served,
            clock,
            start="go\r",
            stop="halt\r",
            ask_serial_number="id?\r",
            serial_number_pattern=r"SN (\S+)",
        )
        assert source.open().serial_number == "0042"
        assert source.device().serial_number == "0042"
        source.configure(0.01)
        source.close()
        served.send_until(clock.now_s())
        assert served.commands == [b"id?", b"go", b"halt"]


def test_another_board_than_the_station_names_is_refused() -> None:
    clock = VirtualClock()
    with unit(clock, line, period_s=0.01) as served:
        served.answers = {b"id?": b"SN 0042\n"}
        settings = LineStreamSettings(
            **COUNTED, ask_serial_number="id?\r", serial_number_pattern=r"SN (\S+)"
        )
        source = LineStream(served.resource, settings, clock=clock, serial_number="43")
        with pytest.raises(InstrumentIdentityError, match="found serial number 0042, expected 43"):
            source.open()


def test_a_board_on_the_network_is_read_too() -> None:
    clock = VirtualClock()
    with socket.create_server(("127.0.0.1", 0)) as server:
        settings = LineStreamSettings(**COUNTED)
        source = LineStream(
            f"TCPIP::127.0.0.1::{server.getsockname()[1]}::SOCKET", settings, clock=clock
        )
        source.open()
        peer, _ = server.accept()
        sent = 0

        def send(now_s: float) -> None:
            nonlocal sent
            due = round(now_s / 0.01 - 0.01)
            peer.sendall(b"".join(line(number) for number in range(sent, due)))
            sent = due

        clock.subscribe(send)
        source.configure(0.05)
        source.start(0, 60)
        blocks = run(source)
        peer.close()
        source.close()
    assert np.array_equal(np.diff(values_of(blocks)[:, 0]), np.full(59, 5.0))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda n: b"%d %d\n" % (n, n), r"no line fits; the last one is '\d+ \d+': correct pattern"),
        (lambda n: b"\xf0\x80" * 5, r"\d+ bytes but no line end among them; is baud_rate"),
    ],
)
def test_other_text_than_expected_is_said_within_seconds(
    make: Callable[[int], bytes], message: str
) -> None:
    clock = VirtualClock()
    with unit(clock, make, period_s=0.01) as served:
        source = board(served, clock)
        source.open()
        with pytest.raises(InstrumentProtocolError, match=message):
            source.configure(0.01)
    assert clock.now_s() < 6.0


def test_lines_that_come_otherwise_than_said_are_another_sample_rate() -> None:
    clock = VirtualClock()
    with unit(clock, line, period_s=0.02) as served:
        source = board(served, clock, counter=None, counter_modulus=None)
        source.open()
        # The last lines of what was listened to may still be on their way.
        told = r"sends (49|50)\S* samples a second, the station says 100"
        with pytest.raises(InstrumentError, match=told):
            source.configure(0.01)


def test_a_station_writes_units_as_text() -> None:
    settings = instrument_settings(
        Instrument(
            driver="line_stream",
            resource="ASRL/dev/ttyACM0::INSTR",
            settings={
                "sample_rate": "100 Hz",
                "columns": ["gx", "t"],
                "channels": {"gx": "61 mdeg/s"},
                "auxiliary": {"t": "0.01 degC"},
            },
        ),
        LineStream,
    )
    assert settings.channels["gx"].to("deg/s") == pytest.approx(0.061)
    assert settings.auxiliary["t"] == Quantity(0.01, "degC")


@pytest.mark.parametrize("unit_given", ["1 furlong", "1 degC", "5", "1 m/s"])
def test_a_unit_that_is_none_of_an_output_is_refused(unit_given: str) -> None:
    instrument = Instrument(
        driver="line_stream",
        resource="ASRL/dev/ttyACM0::INSTR",
        settings={"sample_rate": "100 Hz", "columns": ["gx"], "channels": {"gx": unit_given}},
    )
    with pytest.raises(StationError, match=r"settings\.channels\.gx"):
        instrument_settings(instrument, LineStream)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"pattern": "(?P<gx>.*)"}, "give either columns or pattern"),
        ({"columns": ()}, "give either columns or pattern"),
        ({"columns": (), "pattern": "(?P<gx>["}, "is no regular expression"),
        ({"columns": ("n", "a")}, "gx: no such column or group; there are n, a"),
        ({"columns": ("n", "gx", "gx")}, "named twice"),
        ({"channels": {}}, "channels is empty"),
        ({"channels": {"gx": DPS, "t": Quantity(1.0, "V")}}, "t is in V, gx in deg/s"),
        ({"channels": {"gx": Quantity(0.0, "deg/s")}}, "a number 1 cannot stand for zero"),
        ({"counter": None}, "counter and counter_modulus belong together"),
        ({"counter_modulus": 10}, r"the counter begins anew after 0\.1 s"),
        ({"counter_modulus": 255, "counter_step": 2}, "must be a multiple of counter_step"),
        ({"sample_rate": Quantity(0.0, "Hz")}, "is not more than zero"),
        ({"ask_serial_number": "id?"}, "belong together"),
        ({"ask_serial_number": "id?", "serial_number_pattern": "SN"}, "has no group"),
    ],
)
def test_settings_that_cannot_be_are_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        LineStreamSettings(**{**COUNTED, **given})
