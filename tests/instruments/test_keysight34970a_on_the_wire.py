"""The scanner over real sockets, pseudo-terminals and a GPIB adapter, against the simulated one."""

from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.errors import InstrumentError, InstrumentIdentityError, OverloadError
from gyrotest.instruments.keysight34970a import Keysight34970A
from gyrotest.instruments.scanner_settings import BesideChannel, Function, Keysight34970ASettings
from gyrotest.records.recording import SampleFlag, Sampling
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.converter import Converter, MeterErrors
from gyrotest.simulation.dialogue import LineDialogue
from gyrotest.simulation.faults import Faults
from gyrotest.simulation.gyro import SteadyOutput
from gyrotest.simulation.meter_state import Interface
from gyrotest.simulation.prologix import PrologixDialogue
from gyrotest.simulation.scanner import SimulatedScanner
from gyrotest.simulation.scanner_commands import speaker_of
from gyrotest.simulation.scenarios import Misbehaviour, Strike
from gyrotest.simulation.server import PtyServer, TcpServer, has_pty
from gyrotest.simulation.signal import Signal
from gyrotest.simulation.streams import Normals, generator

SAMPLES = 30
EXACT = MeterErrors(gain=0.0, offset_of_range=0.0, noise_v=0.0)
PROBES = {"110": BesideChannel(function=Function.THERMOCOUPLE, type="K")}


class Ramp:
    """A voltage that is its time in volts: what was read tells when."""

    def mean_voltage(self, start_s: float, aperture_s: float) -> float:
        return 1e-3 * (start_s + 0.5 * aperture_s)

    def mean_voltages(
        self, start_s: float, aperture_s: float, spacing_s: float, count: int
    ) -> NDArray[np.float64]:
        return 1e-3 * (start_s + 0.5 * aperture_s + spacing_s * np.arange(count))


@dataclass(frozen=True)
class Served:
    """A simulated scanner behind a server."""

    scanner: SimulatedScanner
    clock: VirtualClock
    address: str

    def driver(self, **options: Any) -> Keysight34970A:
        settings = Keysight34970ASettings(
            **{"nplc": 1.0, "beside": PROBES, **options.pop("settings", {})}
        )
        return Keysight34970A(
            self.address, settings, clock=self.clock, line_frequency_hz=50.0, **options
        )


@contextmanager
def served(
    signals: Mapping[int, Signal],
    *,
    way: str = "tcp",
    newer: bool = False,
    strikes: tuple[Strike, ...] = (),
) -> Iterator[Served]:
    clock = VirtualClock(0.0)
    model = "Keysight Technologies,DAQ970A" if newer else "HEWLETT-PACKARD,34970A"
    scanner = SimulatedScanner(clock=clock, line_frequency_hz=50.0, identity=f"{model},SIM00005,1")
    faults = Faults(strikes, start_s=0.0, duration_s=SAMPLES)
    converters = {
        number: Converter(signal, EXACT, Normals(generator(1, "test")), faults)
        for number, signal in signals.items()
    }
    scanner.connect(converters, faults)
    speaker = speaker_of(scanner, clock, newer=newer)
    if way == "pty":
        with PtyServer(lambda: LineDialogue(speaker, Interface.SERIAL), clock) as pty:
            yield Served(scanner, clock, f"ASRL{pty.path}::INSTR")
    elif way == "prologix":
        with TcpServer(lambda: PrologixDialogue({9: speaker}, clock), clock) as tcp:
            address = f"PRLGX-TCPIP7::127.0.0.1::{tcp.port}::INTFC GPIB7::9::INSTR"
            yield Served(scanner, clock, address)
    else:
        with TcpServer(lambda: LineDialogue(speaker, Interface.SOCKET), clock) as tcp:
            yield Served(scanner, clock, f"TCPIP::127.0.0.1::{tcp.port}::SOCKET")


@dataclass(frozen=True)
class Run:
    """What came of an acquisition."""

    sampling: Sampling
    positions: list[int]
    times_s: NDArray[np.float64]
    values: NDArray[np.float64]
    flags: list[int]


def acquired(
    source: Keysight34970A,
    outputs: tuple[str, ...] = ("101",),
    auxiliary: tuple[str, ...] = (),
    *,
    interval_s: float = 1.0,
    samples: int = SAMPLES,
) -> Run:
    source.open()
    source.select(outputs, auxiliary)
    sampling = source.configure(interval_s)
    blocks, positions = [], []
    source.start(0, samples)
    for _ in range(2 * samples):
        try:
            block = source.fetch()
        except OverloadError:
            raise
        except InstrumentError:
            source.start(source.recover(), samples)
            continue
        if block is None:
            break
        blocks.append(block)
        positions += range(block.first, block.first + len(block.flags))
    return Run(
        sampling,
        positions,
        np.concatenate([one.time_s for one in blocks]),
        np.concatenate([one.values for one in blocks]),
        np.concatenate([one.flags for one in blocks]).tolist(),
    )


WAYS = [
    "tcp",
    "prologix",
    pytest.param("pty", marks=pytest.mark.skipif(not has_pty(), reason="no pseudo-terminals here")),
]


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("newer", [False, True])
def test_several_gyros_and_a_temperature_come_in_one_acquisition(way: str, newer: bool) -> None:
    signals = {101: SteadyOutput(2.5), 205: SteadyOutput(-1.25), 110: SteadyOutput(0.2345)}
    with served(signals, way=way, newer=newer) as bench, closing(bench.driver()) as source:
        run = acquired(source, ("205", "101"), ("110",))
    assert run.positions == list(range(SAMPLES))
    assert run.times_s == pytest.approx(np.arange(SAMPLES), abs=0.2)
    assert np.diff(run.times_s) == pytest.approx(np.ones(SAMPLES - 1), abs=2e-3)
    assert run.values == pytest.approx(np.tile([-1.25, 2.5, 23.45], (SAMPLES, 1)), abs=1e-3)
    assert not any(run.flags)
    sampling = run.sampling
    assert (sampling.interval_s, sampling.aperture_s, sampling.readings) == (1.0, 0.02, 1)
    assert sampling.columns == ("205", "101", "110")
    assert sampling.auxiliary[0].unit == "degC"


def test_the_offsets_are_those_between_the_channels_readings_whatever_their_order() -> None:
    signals = {number: Ramp() for number in (101, 110, 205)}
    beside = {"110": BesideChannel(function=Function.VOLTAGE, nplc=10.0)}
    with served(signals) as bench, closing(bench.driver(settings={"beside": beside})) as source:
        run = acquired(source, ("205", "101"), ("110",))
        remarks = source.remarks()
    read_s = 1e3 * run.values
    # The mean of a ramp belongs to the middle of its aperture.
    middle_s = np.array([0.0, 0.0, 0.5 * (0.2 - 0.02)])
    offsets_s = (read_s - read_s[:, :1]).mean(axis=0) - middle_s
    assert run.sampling.offsets_s == pytest.approx(offsets_s.tolist(), abs=2e-3)
    assert run.sampling.offsets_s[0] == 0.0
    assert run.sampling.offsets_s[1] < run.sampling.offsets_s[2] < 0.0
    assert run.times_s - run.times_s[0] == pytest.approx(read_s[:, 0] - read_s[0, 0], abs=4e-3)
    (told,) = remarks
    assert "101 -" in told
    assert "from channel 205" in told


def test_an_interval_shorter_than_a_sweep_is_refused_with_the_shortest_which_works() -> None:
    signals = {101: SteadyOutput(1.0), 102: SteadyOutput(2.0)}
    with served(signals) as bench, closing(bench.driver()) as source:
        source.open()
        source.select(("101", "102"), ())
        message = r"0.1 s cannot be reached with 2 channel\(s\) at nplc 1 .* the shortest is 0.126 s"
        with pytest.raises(InstrumentError, match=message):
            source.configure(0.1)
        assert acquired(source, ("101", "102"), interval_s=0.126).positions == list(range(SAMPLES))


def test_the_interval_is_what_the_timer_is_set_to() -> None:
    with served({101: Ramp()}) as bench, closing(bench.driver()) as source:
        run = acquired(source, interval_s=0.3333)
    assert run.sampling.interval_s == 0.333
    assert np.diff(run.values[:, 0]) == pytest.approx(np.full(SAMPLES - 1, 0.333e-3), abs=1e-5)


def test_a_voltage_beside_is_turned_into_what_it_stands_for() -> None:
    beside = {
        "102": BesideChannel(function=Function.VOLTAGE, unit="degC", per_volt=100.0, at_zero_volt=-50.0)
    }
    signals = {101: SteadyOutput(1.0), 102: SteadyOutput(0.75)}
    with served(signals) as bench, closing(bench.driver(settings={"beside": beside})) as source:
        run = acquired(source, ("101",), ("102",))
    assert run.values[:, 1] == pytest.approx(np.full(SAMPLES, 25.0), abs=1e-3)
    assert run.sampling.auxiliary[0].unit == "degC"


def test_an_overloaded_output_is_flagged_and_is_no_number() -> None:
    with served({101: SteadyOutput(15.0)}) as bench, closing(bench.driver()) as source:
        run = acquired(source)
    assert np.isnan(run.values).all()
    assert run.flags == [SampleFlag.OVERLOAD] * SAMPLES


def test_a_probe_that_is_not_connected_is_told() -> None:
    with (
        served({101: SteadyOutput(1.0)}) as bench,
        closing(bench.driver()) as source,
        pytest.raises(OverloadError, match=r"overload on channel 110 \(thermocouple\); is the probe"),
    ):
        acquired(source, ("101",), ("110",))


@pytest.mark.parametrize(
    "misbehaviour", [Misbehaviour.HANG_UP, Misbehaviour.GARBLE, Misbehaviour.NO_REPLY]
)
def test_a_fault_is_bridged_with_a_gap(misbehaviour: Misbehaviour) -> None:
    strikes = (Strike(misbehaviour=misbehaviour, at=0.4),)
    with (
        served({101: Ramp()}, strikes=strikes) as bench,
        closing(bench.driver(io_timeout_s=0.5)) as source,
    ):
        run = acquired(source)
    assert run.positions == sorted(set(run.positions))
    assert SAMPLES / 2 < len(run.positions) < SAMPLES
    assert run.times_s == pytest.approx(run.positions, abs=0.2)


def test_a_memory_that_overflowed_is_a_fault() -> None:
    with served({101: Ramp()}) as bench, closing(bench.driver()) as source:
        source.open()
        source.select(("101",), ())
        source.configure(0.1)
        source.start(0, 100_000)
        bench.clock.sleep_until(6000.0)
        with pytest.raises(InstrumentError, match="its memory overflowed"):
            source.fetch()


@pytest.mark.parametrize(
    ("outputs", "auxiliary", "message"),
    [
        ((), (), "no channel is named for the unit's output"),
        (("1",), (), "'1' is no channel; write slot and channel"),
        (("101", "101"), (), "channel 101 is chosen twice"),
        (("101",), ("101",), "channel 101 is chosen twice"),
        (("401",), (), "'401' is no channel"),
    ],
)
def test_channels_are_checked_before_anything_is_sent(
    outputs: tuple[str, ...], auxiliary: tuple[str, ...], message: str
) -> None:
    with served({}) as bench, pytest.raises(InstrumentError, match=message):
        bench.driver().select(outputs, auxiliary)


def test_a_channel_that_the_scanner_lacks_is_told_in_its_own_words() -> None:
    with served({}) as bench, closing(bench.driver()) as source:
        source.open()
        source.select(("130",), ())
        with pytest.raises(InstrumentError, match="Data out of range"):
            source.configure(1.0)


def test_a_step_that_was_broken_off_is_followed_by_the_next() -> None:
    with served({101: Ramp()}) as bench, closing(bench.driver()) as source:
        source.open()
        source.select(("101",), ())
        source.configure(1.0)
        source.start(0, 100)
        source.fetch()
        source.start(0, 10)
        block = source.fetch()
    assert block is not None
    assert block.first == 0
    assert block.time_s[0] == pytest.approx(0.0, abs=0.1)


def test_nothing_is_configured_before_channels_are_chosen_nor_started_before_that() -> None:
    with served({}) as bench, closing(bench.driver()) as source:
        source.open()
        with pytest.raises(InstrumentError, match="no channels are selected"):
            source.configure(1.0)
        with pytest.raises(InstrumentError, match="not configured"):
            source.start(0, 1)
        assert source.remarks() == ()


def test_another_instrument_is_refused() -> None:
    with (
        served({}) as bench,
        closing(bench.driver(serial_number="MY1")) as source,
        pytest.raises(InstrumentIdentityError, match="SIM00005, expected MY1"),
    ):
        source.open()
