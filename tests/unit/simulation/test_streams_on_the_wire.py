"""Simulated digital gyros over a real socket and a real pseudo-terminal, in step with the virtual clock."""

import contextlib
import os
import socket
import time
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.errors import StationError
from gyrotest.records.spec import Output, OutputKind, Spec, Supply
from gyrotest.records.station import Instrument, Simulation, Slot, Station
from gyrotest.simulation.bench import SimulatedBench
from gyrotest.simulation.checksum import STIM210_CHECKSUM
from gyrotest.simulation.response import response_of
from gyrotest.simulation.serve import Standalone
from gyrotest.simulation.server import has_pty
from gyrotest.units import Quantity

SPEC = Spec(
    model="STIM210",
    cases={},
    output=Output(
        kind=OutputKind.RATE,
        axes=("x", "y", "z"),
        full_scale=Quantity(400.0, "deg/s"),
        bandwidth=Quantity(262.0, "Hz"),
    ),
)
POWERED = replace(
    SPEC,
    supply=Supply(
        voltage=Quantity(5.0, "V"),
        current_limit=Quantity(0.5, "A"),
        over_voltage=Quantity(5.5, "V"),
    ),
)
QUIET = {
    "angle_random_walk": "0 deg/sqrt(h)",
    "bias_instability_coefficient": "0 deg/h",
    "rate_random_walk": "0 deg/h/sqrt(h)",
}
SIZE = 13  # identifier, rates, status, counter, checksum
DURATION_S = 8.0
needs_pty = pytest.mark.skipif(not has_pty(), reason="this platform has no pseudo-terminals")
WAYS = ["tcp", pytest.param("pty", marks=needs_pty)]


def station(
    way: str = "tcp",
    *,
    gyro: Mapping[str, Any] | None = None,
    settings: Mapping[str, Any] | None = None,
    simulated: Mapping[str, Any] | None = None,
    driver: str = "stim210",
) -> Station:
    return Station(
        name="simulated",
        instruments={
            "gyro": Instrument(
                driver=driver,
                resource=f"simulated:{way}",
                settings=settings or {"frame": "rate_counter", "sample_rate": "125 Hz"},
            ),
            "supply": Instrument(driver="scpi_supply", resource="simulated"),
        },
        slots={"a": Slot(source="gyro", supply="supply")},
        simulation=Simulation(
            gyro=QUIET if gyro is None else gyro,
            instruments={"gyro": simulated} if simulated is not None else {},
        ),
    )


class Line:
    """The other end of a gyro's line: what has arrived, and no waiting beyond a moment."""

    def __init__(self, address: str) -> None:
        self._socket: socket.socket | None = None
        self._file = -1
        if address.startswith("TCPIP"):
            self._socket = socket.create_connection(("127.0.0.1", int(address.split("::")[2])), 5.0)
            self._socket.setblocking(False)
        else:
            path = address.removeprefix("ASRL").removesuffix("::INSTR")
            self._file = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)

    def send(self, data: bytes) -> None:
        if self._socket is not None:
            self._socket.sendall(data)
        else:
            os.write(self._file, data)

    def read(self, count: int = 0) -> bytes:
        """All that has arrived; a pseudo-terminal may need a moment to hand on so many bytes."""
        data, until_s = b"", time.monotonic() + 5.0
        while True:
            with contextlib.suppress(BlockingIOError):
                part = self._socket.recv(1 << 20) if self._socket else os.read(self._file, 1 << 16)
                if not part:
                    raise ConnectionAbortedError("the other end is gone")
                data += part
            if len(data) >= count or time.monotonic() > until_s:
                return data

    def close(self) -> None:
        if self._socket is not None:
            self._socket.close()
        elif self._file >= 0:
            os.close(self._file)
            self._file = -1


@contextlib.contextmanager
def bench(
    made: Station, spec: Spec = SPEC, *, scenario: str = "nominal", serial: str = "4711"
) -> Iterator[tuple[SimulatedBench, Line]]:
    with SimulatedBench(made, spec, scenario=scenario) as served:
        served.insert(slot="a", serial_number=serial)
        line = Line(served.address("gyro"))
        served.clock.sleep_until(0.0)
        with contextlib.closing(line):
            yield served, line


def begin(served: SimulatedBench, *, repeat: int = 1, elapsed_s: float = 600.0) -> None:
    served.begin(
        slot="a",
        serial_number="4711",
        case="c",
        power_cycle=1,
        repeat=repeat,
        elapsed_s=elapsed_s,
        duration_s=DURATION_S,
    )


def advance(served: SimulatedBench, duration_s: float) -> None:
    served.clock.sleep_until(served.clock.now_s() + duration_s)


def frames(data: bytes) -> NDArray[np.uint8]:
    rows = np.frombuffer(data, dtype=np.uint8).reshape(-1, SIZE)
    assert (rows[:, 0] == 0xA2).all()
    assert all(row[-1:].tobytes() == STIM210_CHECKSUM.of(row[:-1].tobytes()) for row in rows)
    return rows


def rates_dps(rows: NDArray[np.uint8]) -> NDArray[np.float64]:
    raw = rows[:, 1:10].reshape(-1, 3, 3).astype(np.int32)
    return np.asarray((raw[:, :, 0] << 24 | raw[:, :, 1] << 16 | raw[:, :, 2] << 8) / 2**22)


@pytest.mark.parametrize("way", WAYS)
def test_exactly_the_frames_that_are_due_are_there_when_time_has_moved(way: str) -> None:
    with bench(station(way)) as (served, line):
        begin(served)
        advance(served, 0.0)
        line.read()
        begin(served)
        for duration_s, count in ((1.0, 125), (0.004, 0), (0.004, 1), (2.0, 250)):
            advance(served, duration_s)
            rows = frames(line.read(count * SIZE))
            assert len(rows) == count
        assert (np.diff(rows[:, 11].astype(int)) % 256 == 16).all()


@pytest.mark.parametrize("way", WAYS)
def test_of_a_long_time_the_newest_half_of_the_line_is_sent(way: str) -> None:
    with bench(station(way)) as (served, line):
        begin(served)
        advance(served, 3600.0)
        advance(served, 0.0)
        most = 8192 if way == "pty" else 1 << 18
        data = line.read(most // SIZE * SIZE)
        assert len(data) == most // SIZE * SIZE
        rows = frames(data[-100 * SIZE :])
        assert rows[-1, 11] == 3600 * 125 * 16 % 256


def test_nothing_is_kept_for_a_reader_that_is_not_there() -> None:
    with SimulatedBench(station(), SPEC) as served:
        begin(served)
        served.address("gyro")
        served.clock.sleep_until(3600.0)
        line = Line(served.address("gyro"))
        advance(served, 0.0)
        assert line.read() == b""
        advance(served, 1.0)
        assert len(frames(line.read(125 * SIZE))) == 125
        line.close()


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(("letter", "identifier", "size"), [(b"N", 0xB1, 17), (b"I", 0xB5, 17)])
def test_a_question_is_answered_between_frames(
    way: str, letter: bytes, identifier: int, size: int
) -> None:
    with bench(station(way), serial="N-00815") as (served, line):
        line.read()
        line.send(letter + b"\r")
        data = b""
        for _ in range(500):
            advance(served, 0.008)
            data += line.read(1)
            if len(data) % SIZE:
                break
        place = data.index(bytes([identifier]) + (b"N" if letter == b"I" else b"\x00\x00\x00-"))
        said = data[place : place + size]
        assert said[-1:] == STIM210_CHECKSUM.of(said[:-1])
        if letter == b"I":
            assert int(said[2:9].hex()) == 815


def test_a_quiet_unit_says_what_its_truth_is_in_every_mode() -> None:
    for mode, scale in (("rate", 1.0), ("average_rate", 1.0), ("incremental_angle", 128 / 125)):
        settings = {"frame": "rate_counter", "sample_rate": "125 Hz", "mode": mode}
        with bench(station(gyro={**QUIET, "warm_up_drift": "0 deg/s"}, settings=settings)) as (
            served,
            line,
        ):
            begin(served)
            advance(served, 1.0)
            found = rates_dps(frames(line.read(125 * SIZE))) * 1.0
            truth = served.truth("a", duration_s=1.0)
        for place, axis in enumerate("xyz"):
            expected = response_of(truth, axis).output(np.zeros(1), bias_dps=truth[f"{axis}.bias_dps"])
            assert found[:, place] == pytest.approx(np.full(125, expected[0] * scale), abs=2**-14)


def test_the_axes_are_units_of_their_own() -> None:
    with bench(station()) as (served, _):
        begin(served)
        truth = served.truth("a", duration_s=1.0)
    for name in ("turn_on_bias_dps", "scale_factor"):
        assert len({truth[f"{axis}.{name}"] for axis in "xyz"}) == 3


def test_a_record_depends_on_its_name_and_not_on_those_before() -> None:
    taken = []
    for repeats in ((1, 2), (2,)):
        with bench(station(gyro={})) as (served, line):
            for repeat in repeats:
                advance(served, 0.0123)
                line.read()
                begin(served, repeat=repeat)
                advance(served, 4.0)
                last = rates_dps(frames(line.read(500 * SIZE)))
            taken.append(last)
    assert np.array_equal(taken[0], taken[1])
    assert taken[0].std() > 1e-3


def test_beyond_its_range_it_clips_and_says_so() -> None:
    with bench(station(gyro={**QUIET, "input_rate": "505 deg/s"})) as (served, line):
        begin(served)
        advance(served, 1.0)
        rows = frames(line.read(125 * SIZE))
        scale = served.truth("a", duration_s=1.0)["z.scale_factor"]
    assert (rows[:, 10] == 0x17).all()
    assert rates_dps(rows)[:, 2] == pytest.approx(np.full(125, 500.0 * scale), abs=2**-13)


def switch(served: SimulatedBench, command: bytes) -> None:
    """Talk to the supply as a driver does."""
    port = int(served.address("supply").split("::")[2])
    with socket.create_connection(("127.0.0.1", port), 5.0) as connection:
        connection.sendall(command + b";*OPC?\n")
        assert connection.recv(100)


def test_without_power_it_is_silent_and_after_it_starts_up_with_another_bias() -> None:
    with bench(station(), POWERED) as (served, line):
        switch(served, b"VOLT 5;CURR 1;OUTP ON")
        advance(served, 2.0)
        begin(served)
        line.read()
        advance(served, 1.0)
        before = rates_dps(frames(line.read(125 * SIZE)))[-1]
        switch(served, b"OUTP OFF")
        advance(served, 5.0)
        line.read()
        advance(served, 5.0)
        assert line.read() == b""
        switch(served, b"OUTP ON")
        advance(served, 2.0)
        data = line.read(200 * SIZE)
        assert data[:1] == b"\xb1"  # part number, serial number, configuration once
        rows = frames(data[17 + 17 + 23 :])
        starting = rows[:, 10] == 0x40
        assert starting[:60].all()
        assert not starting[80:].any()
        assert np.abs(rates_dps(rows)[-1] - before).min() > 1e-3


def test_a_meter_reads_nothing_while_the_supply_is_off() -> None:
    made = replace(
        station(),
        instruments={
            "meter": Instrument(driver="agilent34401a", resource="simulated"),
            "supply": Instrument(driver="scpi_supply", resource="simulated"),
        },
        slots={"a": Slot(source="meter", supply="supply")},
    )
    voltage = Output(
        kind=OutputKind.VOLTAGE, scale_factor=Quantity(50, "mV/(deg/s)"), zero_rate=Quantity(2.5, "V")
    )
    with SimulatedBench(made, replace(POWERED, output=voltage)) as served:
        begin(served)
        port = int(served.address("meter").split("::")[2])
        with socket.create_connection(("127.0.0.1", port), 5.0) as connection:
            found = []
            for command in (b"OUTP OFF", b"VOLT 5;CURR 1;OUTP ON"):
                switch(served, command)
                advance(served, 2.0)
                connection.sendall(b"READ?\n")
                found.append(float(connection.recv(100)))
    assert found[0] == pytest.approx(0.0, abs=1e-3)
    assert found[1] == pytest.approx(2.5, abs=0.1)


def received(scenario: str, made: Station | None = None) -> bytes:
    with bench(made or station(), scenario=scenario) as (served, line):
        begin(served)
        data = b""
        for _ in range(8):
            advance(served, DURATION_S / 8)
            data += line.read(1)
        return data


@pytest.mark.parametrize(("scenario", "lost"), [("lost-frames", 21), ("lost-counter-period", 48)])
def test_lost_frames_are_missing_and_the_others_are_whole(scenario: str, lost: int) -> None:
    rows = frames(received(scenario))
    assert len(rows) == 1000 - lost
    steps = np.diff(rows[:, 11].astype(int)) % 256
    assert (steps == 16).all() == (scenario == "lost-counter-period")


def test_damaged_frames_fail_their_checksum() -> None:
    rows = np.frombuffer(received("bad-crc"), dtype=np.uint8).reshape(1000, SIZE)
    bad = [row[-1:].tobytes() != STIM210_CHECKSUM.of(row[:-1].tobytes()) for row in rows]
    assert 2 <= sum(bad) <= 5


def test_noise_on_the_line_comes_between_whole_frames() -> None:
    assert len(received("garbage-on-the-line")) > 1000 * SIZE


def test_at_another_baud_rate_there_is_garbage_only() -> None:
    data = received("wrong-baud-rate")
    assert 3000 < len(data) < 1000 * SIZE
    assert len(set(data)) == 256


@pytest.mark.parametrize(
    ("scenario", "status", "count"),
    [("overload-status", 0x11, 10), ("channel-error", 0x09, 10), ("overload", 0x11, 20)],
)
def test_the_status_tells_of_a_fault_for_a_while(scenario: str, status: int, count: int) -> None:
    told = frames(received(scenario))[:, 10]
    assert sorted(set(told.tolist())) == [0, status]
    assert (told > 0).sum() == count


@pytest.mark.parametrize("way", WAYS)
def test_a_reader_that_comes_back_gets_what_is_sent_from_then_on(way: str) -> None:
    with bench(station(way)) as (served, line):
        begin(served)
        advance(served, 1.0)
        first = frames(line.read(125 * SIZE))
        line.close()
        again = Line(served.address("gyro"))
        advance(served, 0.0)
        advance(served, 1.0)
        second = frames(again.read(125 * SIZE))
        again.close()
    assert (int(second[0, 11]) - int(first[-1, 11])) % 256 == 16


@pytest.mark.parametrize("way", WAYS)
def test_an_unplugged_line_breaks(way: str) -> None:
    with bench(station(way), scenario="unplugged") as (served, line):
        begin(served)
        advance(served, 3.0)
        line.read(375 * SIZE)
        advance(served, 1.0)
        with pytest.raises(OSError):  # noqa: PT011 - reset by peer, or an input/output error
            line.read(1)


LINES = {
    "sample_rate": "100 Hz",
    "columns": ["n", "x", "y", "z", "temperature"],
    "channels": {"x": "0.5 deg/s", "y": "1 deg/s", "z": "1 deg/s"},
    "counter": "n",
    "counter_modulus": 65536,
}


@pytest.mark.parametrize("way", WAYS)
def test_a_board_prints_the_columns_of_its_driver(way: str) -> None:
    with bench(station(way, settings=LINES, driver="line_stream")) as (served, line):
        begin(served)
        line.read()
        advance(served, 1.0)
        lines = line.read(100 * 30).decode().splitlines()
        truth = served.truth("a", duration_s=1.0)
    assert len(lines) == 100
    fields = [float(one) for one in lines[-1].split(",")]
    assert fields[0] == 99
    assert fields[1] == pytest.approx(truth["x.bias_dps"] * truth["x.scale_factor"] / 0.5, abs=1e-4)
    assert fields[2] == pytest.approx(truth["y.bias_dps"] * truth["y.scale_factor"], abs=1e-4)
    assert fields[4] == 23.0


def test_a_board_may_print_anything_wait_to_be_started_and_tell_who_it_is() -> None:
    settings = {**LINES, "start": "go\n", "stop": "halt\n", "ask_serial_number": "id?\n"}
    simulated = {"format": "t={time_s:.2f} w={z:+.3f}", "reply": "I am {serial_number}"}
    made = station(settings=settings, simulated=simulated, driver="line_stream")
    with bench(made) as (served, line):
        begin(served)
        said = []
        for command in (b"", b"go\n", b"id?\n", b"halt\n"):
            line.send(command)
            advance(served, 0.05)
            said.append(line.read().decode().splitlines())
    assert said[0] == []
    assert len(said[1]) == 5
    assert said[1][0].startswith("t=0.06 w=")
    assert said[2][0] == "I am 4711"
    assert said[3] == []


@pytest.mark.parametrize(
    ("driver", "simulated", "complaint"),
    [
        ("stim210", {"frame": "rate_contour"}, "did you mean 'rate_counter'"),
        ("stim300", {"sample_rate": "100 Hz"}, "none of 125 Hz"),
        ("stim210", {"mode": "angle"}, "none of rate"),
        ("stim210", {"latency": "1 s"}, "at most 65 ms"),
        ("stim210", {"lateny": "1 ms"}, "did you mean 'latency'"),
        ("line_stream", {"format": "{x"}, "gyro.format"),
        ("line_stream", {"sample_rate": "0 Hz"}, "more than zero"),
    ],
)
def test_a_complaint_names_the_key(driver: str, simulated: dict[str, Any], complaint: str) -> None:
    settings = {"frame": "rate", "sample_rate": "125 Hz"} if driver != "line_stream" else LINES
    made = station(settings=settings, simulated=simulated, driver=driver)
    with pytest.raises(StationError) as refused:
        SimulatedBench(made, SPEC)
    assert "simulation.instruments.gyro" in str(refused.value)
    assert complaint in str(refused.value)


def test_a_voltage_is_not_what_a_digital_gyro_gives() -> None:
    voltage = Output(kind=OutputKind.VOLTAGE, scale_factor=Quantity(50, "mV/(deg/s)"))
    with pytest.raises(StationError, match=r"output\.kind is 'voltage', which 'gyro' does not have"):
        SimulatedBench(station(), replace(SPEC, output=voltage))


@pytest.mark.parametrize("instrument", ["stim210", "stim300", "line"])
def test_a_digital_gyro_alone_sends_as_fast_as_it_is_read(instrument: str) -> None:
    with Standalone(instrument, fast=True) as served:
        line = Line(served.address)
        assert len(line.read(100_000)) >= 100_000
        line.close()
