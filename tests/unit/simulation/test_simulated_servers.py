"""The simulated meter over real sockets, pseudo-terminals and through a Prologix adapter."""

import contextlib
import socket
import threading
from collections.abc import Iterator
from dataclasses import replace

import pytest

from gyrotest.errors import RefusedError
from gyrotest.records.spec import Output, OutputKind, Spec
from gyrotest.records.station import Instrument, Simulation, Slot, Station
from gyrotest.simulation.bench import SimulatedBench
from gyrotest.simulation.serve import Standalone, serve
from gyrotest.simulation.server import has_pty
from gyrotest.units import Quantity

OUTPUT = Output(
    kind=OutputKind.VOLTAGE,
    scale_factor=Quantity(50.0, "mV/(deg/s)"),
    zero_rate=Quantity(2.5, "V"),
)
SPEC = Spec(model="SIM50", output=OUTPUT, cases={})

needs_pty = pytest.mark.skipif(not has_pty(), reason="this platform has no pseudo-terminals")


def station(resource: str, *, scenario: str = "nominal", driver: str = "agilent34401a") -> Station:
    return Station(
        name="simulated",
        instruments={"meter": Instrument(driver=driver, resource=resource)},
        slots={"a": Slot(source="meter")},
        simulation=Simulation(scenario=scenario),
    )


@contextlib.contextmanager
def bench(resource: str, scenario: str = "nominal") -> Iterator[SimulatedBench]:
    with SimulatedBench(station(resource, scenario=scenario), SPEC) as made:
        made.begin(
            slot="a",
            serial_number="1234",
            case="c",
            power_cycle=0,
            repeat=1,
            elapsed_s=600.0,
            duration_s=100.0,
        )
        yield made


def connect(made: SimulatedBench) -> socket.socket:
    address = made.address("meter").partition(" ")[0]
    connection = socket.create_connection(("127.0.0.1", int(address.split("::")[2])), timeout=5.0)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return connection


def ask(connection: socket.socket, message: bytes, *, lines: int = 1) -> bytes:
    connection.sendall(message)
    reply = b""
    while reply.count(b"\n") < lines:
        received = connection.recv(65_536)
        if not received:
            raise ConnectionResetError
        reply += received
    return reply


def test_a_socket_answers_and_readings_move_the_clock() -> None:
    with bench("simulated") as made, connect(made) as connection:
        assert ask(connection, b"*IDN?\n").startswith(b"HEWLETT-PACKARD,34401A,SIM")
        connection.sendall(b"TRIG:DEL 0\n")
        assert float(ask(connection, b"READ?\n")) == pytest.approx(2.5, abs=0.1)
        assert made.clock.now_s() == pytest.approx(0.4)


def test_messages_in_pieces_and_several_at_once_are_understood() -> None:
    with bench("simulated:tcp") as made, connect(made) as connection:
        for piece in (b"SAMP:CO", b"UN 3\nSAMP", b":COUN?\nSYST:VERS"):
            connection.sendall(piece)
        assert ask(connection, b"?\n", lines=2) == b"+3.00000000E+00\n1991.0\n"


def test_a_second_connection_is_served_after_the_first() -> None:
    with bench("simulated") as made:
        for _ in range(3):
            with connect(made) as connection:
                assert b"34401A" in ask(connection, b"*IDN?\n")


def test_the_meter_hangs_up_once_and_then_takes_a_new_connection() -> None:
    with bench("simulated", "meter-disconnects") as made:
        with connect(made) as connection:
            ask(connection, b"READ?\n")
            made.clock.sleep_until(50.0)
            with pytest.raises(ConnectionResetError):
                ask(connection, b"READ?\n")
        with connect(made) as connection:
            assert float(ask(connection, b"READ?\n")) == pytest.approx(2.5, abs=0.1)


def test_closing_the_bench_ends_its_connections_and_threads() -> None:
    before = threading.active_count()
    with bench("simulated") as made:
        connection = connect(made)
        ask(connection, b"*IDN?\n")
    with connection:
        assert connection.recv(10) == b""
    made.close()
    assert threading.active_count() == before


def gpib(made: SimulatedBench) -> socket.socket:
    connection = connect(made)
    connection.sendall(b"++mode 1\n++auto 0\n++read_tmo_ms 3000\n++eos 3\n++eoi 1\n++addr 22\n")
    return connection


def test_the_adapter_passes_messages_on_and_reads_when_told_to() -> None:
    with bench("simulated:prologix") as made, gpib(made) as connection:
        connection.sendall(b"*IDN?\n")
        assert ask(connection, b"++read eoi\n").startswith(b"HEWLETT-PACKARD,34401A,SIM")
        assert ask(connection, b"++addr\n") == b"22\r\n"
        assert ask(connection, b"++ver\n").startswith(b"Prologix")
        assert ask(connection, b"++nonsense\n") == b"Unrecognized command\r\n"


def test_the_adapter_does_not_wait_longer_than_its_time_out() -> None:
    with bench("simulated:prologix") as made, gpib(made) as connection:
        connection.sendall(b"TRIG:DEL 0\n++read_tmo_ms 50\nREAD?\n++read eoi\n")
        # Nothing came; the clock shows that the adapter has waited.
        assert ask(connection, b"++read_tmo_ms\n") == b"50\r\n"
        assert made.clock.now_s() == pytest.approx(0.05)
        connection.sendall(b"++read_tmo_ms 3000\n")
        assert float(ask(connection, b"++read eoi\n")) == pytest.approx(2.5, abs=0.1)
        assert made.clock.now_s() == pytest.approx(0.4)


def test_a_reply_that_nobody_read_is_an_interrupted_query() -> None:
    with bench("simulated:prologix") as made, gpib(made) as connection:
        connection.sendall(b"*IDN?\nSYST:ERR?\n")
        assert ask(connection, b"++read eoi\n") == b'-410,"Query INTERRUPTED"\n'


def test_the_adapter_clears_the_meter() -> None:
    with bench("simulated:prologix") as made, gpib(made) as connection:
        connection.sendall(b"*IDN?\n++clr\nSYST:VERS?\n")
        assert ask(connection, b"++read eoi\n") == b"1991.0\n"


def test_the_adapter_reads_by_itself_when_told_to() -> None:
    with bench("simulated:prologix") as made, gpib(made) as connection:
        connection.sendall(b"++auto 1\n")
        assert ask(connection, b"SYST:VERS?\n") == b"1991.0\n"


def test_an_escaped_plus_belongs_to_the_message() -> None:
    with bench("simulated:prologix") as made, gpib(made) as connection:
        connection.sendall(b"VOLT:DC:NPLC \x1b+1\nVOLT:DC:NPLC?\n")
        assert ask(connection, b"++read eoi\n") == b"+1.00000000E+00\n"


def test_pyvisa_reads_over_every_way() -> None:
    pyvisa = pytest.importorskip("pyvisa")
    ways = ["simulated:tcp", "simulated:prologix"]
    if has_pty():
        ways += ["simulated:pty", "simulated:prologix-pty"]
    values = []
    for way in ways:
        with bench(way) as made, contextlib.closing(pyvisa.ResourceManager("@py")) as manager:
            *interfaces, address = made.address("meter").split()
            opened = [manager.open_resource(one) for one in interfaces]
            for one in opened:
                one.write_raw(b"++read_tmo_ms 3000\n")
            meter = manager.open_resource(address)
            if not interfaces:
                meter.read_termination = meter.write_termination = "\n"
            meter.write("SYST:REM")
            meter.write("TRIG:DEL 0")
            values.append(float(meter.query("READ?")))
            for one in (meter, *opened):
                one.close()
    # The same unit, the same record: the same reading, whatever the way.
    assert len(set(values)) == 1


@needs_pty
def test_a_serial_device_clear_drops_half_a_message() -> None:
    import serial

    with bench("simulated:pty") as made:
        path = made.address("meter").removeprefix("ASRL").removesuffix("::INSTR")
        with serial.Serial(path, timeout=5.0) as line:
            line.write(b"VOLT:DC:NP\x03SYST:VERS?\n")
            assert line.readline() == b"1991.0\r\n"
            line.write(b"SYST:ERR?\n")
            assert line.readline() == b'+0,"No error"\r\n'


@needs_pty
def test_many_readings_pass_a_serial_line_whole() -> None:
    import serial

    with bench("simulated:pty") as made:
        path = made.address("meter").removeprefix("ASRL").removesuffix("::INSTR")
        with serial.Serial(path, timeout=5.0) as line:
            line.write(b"SYST:REM\nSAMP:COUN 3000\nREAD?\n")
            assert len(line.readline().split(b",")) == 3000


def test_several_instruments_have_addresses_of_their_own() -> None:
    two = replace(
        station("simulated:prologix"),
        instruments={
            name: Instrument(driver="agilent34401a", resource="simulated:prologix") for name in "ab"
        },
        slots={name: Slot(source=name) for name in "ab"},
    )
    with SimulatedBench(two, SPEC) as made:
        first, second = (made.address(name) for name in "ab")
        assert first.startswith("PRLGX-TCPIP0::127.0.0.1::")
        assert first.endswith("::INTFC GPIB0::22::INSTR")
        assert second.startswith("PRLGX-TCPIP1::")
        assert second.endswith("::INTFC GPIB1::22::INSTR")


def test_only_simulated_resources_are_served() -> None:
    mixed = replace(
        station("simulated"),
        instruments={
            "meter": Instrument(driver="agilent34401a", resource="simulated"),
            "real": Instrument(driver="agilent34401a", resource="GPIB0::22::INSTR"),
        },
    )
    with SimulatedBench(mixed, SPEC) as made:
        assert [made.simulates(name) for name in ("meter", "real")] == [True, False]


def test_a_meter_alone_serves_any_program() -> None:
    with Standalone(fast=True, model="34465A") as meter:
        port = int(meter.address.split("::")[2])
        with socket.create_connection(("127.0.0.1", port), timeout=5.0) as connection:
            assert b",34465A,SIM" in ask(connection, b"*IDN?\n")
            assert float(ask(connection, b"READ?\n")) == pytest.approx(2.5, abs=0.2)
            # Nobody but the meter moves its time: samples paced by it come when asked for.
            connection.sendall(b"SAMP:SOUR TIM;TIM 1;COUN 5;:INIT\n")
            assert ask(connection, b"R?\n").count(b",") == 4


def test_a_busy_port_is_refused_with_its_number() -> None:
    with (
        Standalone(fast=True) as meter,
        pytest.raises(RefusedError, match=meter.address.split("::")[2]),
    ):
        Standalone(fast=True, port=int(meter.address.split("::")[2]))


def test_serving_announces_the_address_and_stops() -> None:
    stop = threading.Event()
    said: list[str] = []

    def announce(text: str) -> None:
        said.append(text)
        stop.set()

    serve(
        "meter",
        model="34401A",
        port=0,
        pty=False,
        fast=True,
        serial_number="1",
        scenario="nominal",
        seed=1,
        announce=announce,
        stop=stop,
    )
    assert said[0].startswith("TCPIP::127.0.0.1::")


def test_ctrl_c_stops_serving_without_a_traceback() -> None:
    said: list[str] = []

    class Impatient(threading.Event):
        def wait(self, timeout: float | None = None) -> bool:
            raise KeyboardInterrupt

    serve(
        "meter",
        model="34401A",
        port=0,
        pty=False,
        fast=False,
        serial_number="1",
        scenario="nominal",
        seed=1,
        announce=said.append,
        stop=Impatient(),
    )
    assert said[-1] == "stopped"


@pytest.mark.parametrize(
    ("line", "reply"),
    [
        (b"++auto\n", b"0\r\n"),
        (b"++read_tmo_ms 5000\n", b"Unrecognized command\r\n"),
        (b"++addr 31\n", b"Unrecognized command\r\n"),
        (b"++loc\n++srq\n", b"0\r\n"),
        (b"*ESE 60;*SRE 32;FOO\n++spoll\n", b"96\r\n"),
        (b"++rst\n++read_tmo_ms\n", b"500\r\n"),
        (b"TRIG:SOUR BUS;:INIT\n++trg\nFETC?\n++read_tmo_ms 3000\n++read eoi\n++addr\n", b"+2."),
        (b"++addr 5\n*IDN?\n++read eoi\n++addr\n", b"5\r\n"),
    ],
)
def test_the_adapter_answers(line: bytes, reply: bytes) -> None:
    with bench("simulated:prologix") as made, gpib(made) as connection:
        assert ask(connection, line).startswith(reply)
