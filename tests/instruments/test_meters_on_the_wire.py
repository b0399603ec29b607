"""Both meters over real sockets and pseudo-terminals, against the simulated bench."""

from collections import deque
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager

import numpy as np
import pytest

from gyrotest.errors import InstrumentError, InstrumentIdentityError, InstrumentTimeoutError
from gyrotest.instruments.agilent34401a import Agilent34401A, Agilent34401ASettings
from gyrotest.instruments.keysight34465a import Keysight34465A, Keysight34465ASettings
from gyrotest.instruments.transport.channel import SerialLine
from gyrotest.instruments.transport.conversation import Conversation
from gyrotest.instruments.transport.visa import open_channel
from gyrotest.ports import Source
from gyrotest.records.recording import SampleFlag
from gyrotest.records.spec import Output, OutputKind, Spec
from gyrotest.records.station import Instrument, Simulation, Slot, Station
from gyrotest.simulation.bench import SimulatedBench
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.meter_peer import new_meter
from gyrotest.simulation.prologix import PrologixDialogue
from gyrotest.simulation.server import TcpServer, has_pty
from gyrotest.units import Quantity

OUTPUT = Output(
    kind=OutputKind.VOLTAGE, scale_factor=Quantity(50.0, "mV/(deg/s)"), zero_rate=Quantity(2.5, "V")
)
SPEC = Spec(model="SIM50", output=OUTPUT, cases={})
needs_pty = pytest.mark.skipif(not has_pty(), reason="this platform has no pseudo-terminals")
WAYS = [
    "tcp",
    "prologix",
    pytest.param("pty", marks=needs_pty),
    pytest.param("prologix-pty", marks=needs_pty),
]
SAMPLES = 30


@contextmanager
def bench(driver: str, way: str, scenario: str = "nominal") -> Iterator[SimulatedBench]:
    station = Station(
        name="wire",
        instruments={"meter": Instrument(driver=driver, resource=f"simulated:{way}")},
        slots={"a": Slot(source="meter")},
        simulation=Simulation(scenario=scenario),
    )
    with SimulatedBench(station, SPEC) as served:
        served.begin(
            slot="a",
            serial_number="1234",
            case="static",
            power_cycle=1,
            repeat=1,
            elapsed_s=0,
            duration_s=SAMPLES,
        )
        yield served


def source_of(
    driver: str, address: str, served: SimulatedBench, *, io_timeout_s: float | None = None
) -> Agilent34401A | Keysight34465A:
    if driver == "agilent34401a":
        return Agilent34401A(
            address,
            Agilent34401ASettings(),
            clock=served.clock,
            line_frequency_hz=50.0,
            io_timeout_s=io_timeout_s,
        )
    return Keysight34465A(
        address,
        Keysight34465ASettings(),
        clock=served.clock,
        line_frequency_hz=50.0,
        io_timeout_s=io_timeout_s,
    )


def acquired(source: Source) -> tuple[list[int], list[float], list[float], list[int]]:
    """Positions, times, values, flags of a whole run, recovering from faults as an acquisition does."""
    positions: list[int] = []
    times: list[float] = []
    values: list[float] = []
    flags: list[int] = []
    source.open()
    source.configure(1.0)
    source.start(0, SAMPLES)
    for _ in range(2 * SAMPLES):
        try:
            block = source.fetch()
        except InstrumentError:
            source.start(source.recover(), SAMPLES)
            continue
        if block is None:
            break
        positions += range(block.first, block.first + len(block.flags))
        times += block.time_s.tolist()
        values += block.values[:, 0].tolist()
        flags += block.flags.tolist()
    return positions, times, values, flags


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("driver", ["agilent34401a", "keysight34465a"])
def test_a_run_over_the_wire_is_complete_and_on_its_grid(driver: str, way: str) -> None:
    if driver == "keysight34465a" and way == "pty":
        pytest.skip("the 34465A has no serial line")
    with (
        bench(driver, way) as served,
        closing(source_of(driver, served.address("meter"), served)) as source,
    ):
        positions, times, values, flags = acquired(source)
    assert positions == list(range(SAMPLES))
    assert times == pytest.approx(np.arange(SAMPLES), abs=1e-6)
    assert values == pytest.approx([2.5] * SAMPLES, abs=0.1)
    assert len(set(values)) > SAMPLES / 2
    assert not any(flags)


def test_every_way_to_the_same_meter_reads_the_same_values() -> None:
    runs = []
    for way in ("tcp", "prologix", "pty") if has_pty() else ("tcp", "prologix"):
        with (
            bench("agilent34401a", way) as served,
            closing(source_of("agilent34401a", served.address("meter"), served)) as source,
        ):
            runs.append(acquired(source)[2])
    assert all(run == runs[0] for run in runs)


# A time-out of minutes: a closed connection must be noticed without waiting for it.
@pytest.mark.parametrize("way", ["tcp", "prologix"])
@pytest.mark.parametrize("driver", ["agilent34401a", "keysight34465a"])
@pytest.mark.parametrize("scenario", ["meter-disconnects", "garbled-replies"])
def test_a_fault_is_noticed_at_once_and_bridged_with_a_gap(scenario: str, driver: str, way: str) -> None:
    with (
        bench(driver, way, scenario) as served,
        closing(source_of(driver, served.address("meter"), served, io_timeout_s=300.0)) as source,
    ):
        positions, times, values, _ = acquired(source)
    assert positions == sorted(set(positions))
    assert SAMPLES / 4 < len(positions) < SAMPLES
    assert times == pytest.approx(positions, abs=0.2)
    assert values == pytest.approx([2.5] * len(values), abs=0.1)


@pytest.mark.parametrize("way", WAYS)
def test_a_missing_reply_is_a_time_out_that_is_bridged(way: str) -> None:
    with (
        bench("agilent34401a", way, "meter-timeout") as served,
        closing(source_of("agilent34401a", served.address("meter"), served, io_timeout_s=0.5)) as source,
    ):
        positions, _, _, _ = acquired(source)
    missing = set(range(SAMPLES)) - set(positions)
    assert 1 <= len(missing) <= 6
    assert positions[-1] == SAMPLES - 1


@pytest.mark.parametrize("driver", ["agilent34401a", "keysight34465a"])
def test_an_overload_is_flagged(driver: str) -> None:
    with (
        bench(driver, "tcp", "overload") as served,
        closing(source_of(driver, served.address("meter"), served)) as source,
    ):
        _, _, values, flags = acquired(source)
    bad = [flag for flag in flags if flag]
    assert bad
    assert set(bad) == {int(SampleFlag.OVERLOAD)}
    assert np.isnan(values).tolist() == [bool(flag) for flag in flags]


def test_slow_readings_go_through_an_adapter_that_waits_for_three_seconds_at_most() -> None:
    with bench("agilent34401a", "prologix") as served:
        source = Agilent34401A(
            served.address("meter"),
            Agilent34401ASettings(nplc=100.0),
            clock=served.clock,
            line_frequency_hz=50.0,
        )
        with closing(source):
            source.open()
            sampling = source.configure(10.0)
            source.start(0, 3)
            blocks = [source.fetch() for _ in range(4)]
    assert sampling.readings == 2
    assert [None if block is None else block.first for block in blocks] == [0, 1, 2, None]
    assert blocks[2] is not None
    assert blocks[2].time_s.tolist() == [pytest.approx(20.0)]
    assert blocks[2].values[0, 0] == pytest.approx(2.5, abs=0.1)


def test_the_wrong_meter_is_named() -> None:
    with bench("keysight34465a", "tcp") as served:
        source = source_of("agilent34401a", served.address("meter"), served)
        with pytest.raises(
            InstrumentIdentityError, match=r"found Keysight Technologies 34465A .*expected an HP"
        ):
            source.open()


def test_the_meters_are_left_local_and_can_be_opened_again() -> None:
    with bench("agilent34401a", "tcp") as served:
        for _ in range(3):
            with closing(source_of("agilent34401a", served.address("meter"), served)) as source:
                assert source.open().simulated


@pytest.mark.parametrize("driver", ["agilent34401a", "keysight34465a"])
def test_a_user_can_ask_the_meter_anything(driver: str) -> None:
    with (
        bench(driver, "tcp") as served,
        closing(source_of(driver, served.address("meter"), served)) as source,
    ):
        source.open()
        assert source.query("*IDN?").split(",")[1].lower() in driver


def test_two_instruments_share_one_adapter() -> None:
    clock = VirtualClock()
    meters = {
        address: new_meter(
            "34401A", serial_number=f"SIM{address}", line_frequency_hz=50.0, clock=clock, live=False
        )
        for address in (5, 22)
    }
    with TcpServer(lambda: PrologixDialogue(meters, clock), clock) as server, ExitStack() as stack:
        adapter = f"PRLGX-TCPIP7::127.0.0.1::{server.port}::INTFC"
        sources = [
            Agilent34401A(
                f"{adapter} GPIB7::{address}::INSTR",
                Agilent34401ASettings(),
                clock=clock,
                line_frequency_hz=50.0,
            )
            for address in (5, 22)
        ]
        for source in sources:
            stack.callback(source.close)
        assert [source.open().serial_number for source in sources] == ["SIM5", "SIM22"]
        sources[0].close()
        assert sources[1].configure(1.0).readings == 2
        assert sources[0].open().serial_number == "SIM5"


def test_two_threads_never_get_each_others_replies() -> None:
    from concurrent.futures import ThreadPoolExecutor

    with bench("agilent34401a", "tcp") as served:
        address = served.address("meter")
        talk = Conversation(address, open_channel(address, SerialLine(), 3.0))

        def ask(query: str) -> set[str]:
            return {talk.query(query, 5.0) for _ in range(200)}

        with closing(talk), ThreadPoolExecutor(2) as threads:
            found = [list(one) for one in threads.map(ask, ["*IDN?", "SYST:VERS?"])]
    assert [len(one) for one in found] == [1, 1]
    assert "34401A" in found[0][0]
    assert found[1] == ["1991.0"]


def test_a_meter_that_is_dead_for_good_cannot_be_recovered() -> None:
    with (
        bench("agilent34401a", "tcp", "meter-dead") as served,
        closing(source_of("agilent34401a", served.address("meter"), served, io_timeout_s=0.2)) as source,
    ):
        source.open()
        source.configure(1.0)
        source.start(0, SAMPLES)
        with pytest.raises(InstrumentTimeoutError, match="READ"):
            deque(iter(source.fetch, None))
        with pytest.raises(InstrumentTimeoutError, match=r"no reply to \*IDN\? within 0\.2 s"):
            source.recover()
