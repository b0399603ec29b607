"""STIM210, STIM300 and a board of lines on the simulated bench, over real sockets and pseudo-terminals."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

from gyrotest.errors import InstrumentError, InstrumentProtocolError
from gyrotest.instruments.line_stream import LineStream
from gyrotest.instruments.stim210 import Stim210
from gyrotest.instruments.stim300 import Stim300
from gyrotest.records.recording import Block, SampleFlag
from gyrotest.records.spec import Output, OutputKind, Spec
from gyrotest.records.station import Instrument, Simulation, Slot, Station
from gyrotest.registry import INSTRUMENTS, load
from gyrotest.simulation.bench import SimulatedBench
from gyrotest.simulation.server import has_pty
from gyrotest.specification.station import instrument_settings

needs_pty = pytest.mark.skipif(not has_pty(), reason="this platform has no pseudo-terminals")
WAYS = ["tcp", pytest.param("pty", marks=needs_pty)]
SPEC = Spec(model="STIM", output=Output(kind=OutputKind.RATE, axes=("x", "y", "z")), cases={})
SETTINGS: dict[str, dict[str, Any]] = {
    "stim210": {"frame": "rate_temperature_counter", "sample_rate": "125 Hz"},
    "stim300": {"frame": "rate_temperature", "sample_rate": "125 Hz", "crlf": True},
    "line_stream": {
        "sample_rate": "125 Hz",
        "columns": ["n", "x", "y", "z"],
        "counter": "n",
        "counter_modulus": 256,
        "channels": {"x": "0.001 deg/s", "y": "0.001 deg/s", "z": "0.001 deg/s"},
    },
}
SAMPLES = 5000
DURATION_S = SAMPLES / 125
Source = Stim210 | Stim300 | LineStream


@contextmanager
def bench(
    driver: str, way: str = "tcp", scenario: str = "nominal", **settings: Any
) -> Iterator[tuple[SimulatedBench, Source]]:
    given = SETTINGS[driver] | settings
    station = Station(
        name="wire",
        instruments={"gyro": Instrument(driver=driver, resource=f"simulated:{way}", settings=given)},
        slots={"a": Slot(source="gyro")},
        simulation=Simulation(scenario=scenario),
    )
    with SimulatedBench(station, SPEC) as served:
        served.insert(slot="a", serial_number="1234")
        kind = load(INSTRUMENTS, driver)
        source: Source = kind(
            served.address("gyro"),
            instrument_settings(station.instruments["gyro"], kind),
            clock=served.clock,
            io_timeout_s=1.0,
        )
        try:
            yield served, source
        finally:
            source.close()


def begin(served: SimulatedBench, source: Source) -> None:
    served.begin(
        slot="a",
        serial_number="1234",
        case="static",
        power_cycle=1,
        repeat=1,
        elapsed_s=0.0,
        duration_s=DURATION_S,
    )
    source.start(0, SAMPLES)


def run(source: Source) -> list[Block]:
    return list(iter(source.fetch, None))


def acquired(driver: str, way: str = "tcp", scenario: str = "nominal") -> tuple[list[Block], Source]:
    with bench(driver, way, scenario) as (served, source):
        source.open()
        source.configure(0.008)
        begin(served, source)
        return run(source), source


def count(blocks: list[Block]) -> int:
    return sum(len(block.flags) for block in blocks)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("driver", SETTINGS)
def test_a_record_is_whole_and_looks_like_a_gyro_at_rest(driver: str, way: str) -> None:
    blocks, source = acquired(driver, way)
    values = np.concatenate([block.values for block in blocks])
    assert count(blocks) == SAMPLES
    assert np.abs(values[:, :3]).max() < 2.0
    assert values[:, :3].std() > 0.0
    assert "no sample lost" in source.remarks()[0]
    assert len(source.remarks()) == 1
    if driver != "line_stream":
        assert values.shape[1] == 6
        assert np.all((values[:, 3:] > -40.0) & (values[:, 3:] < 85.0))


@pytest.mark.parametrize("driver", ["stim210", "stim300"])
def test_the_unit_says_who_it_is_and_how_it_is_set(driver: str) -> None:
    with bench(driver) as (_, source):
        assert source.open().serial_number == "1234"
        source.configure(0.008)
        said = source.device()
    assert (said.serial_number, said.sample_rate_hz, said.range_dps) == ("1234", 125.0, 400.0)
    assert said.mode is not None
    assert said.bandwidth_hz is not None


@pytest.mark.parametrize(
    ("scenario", "lost", "told"),
    [
        ("lost-frames", 21, "21 samples lost in 3 gaps"),
        ("lost-counter-period", 48, "48 samples lost in 1 gap"),
        ("garbage-on-the-line", 0, "no sample lost"),
    ],
)
@pytest.mark.parametrize("driver", ["stim210", "stim300"])
def test_what_is_lost_is_found(driver: str, scenario: str, lost: int, told: str) -> None:
    blocks, source = acquired(driver, scenario=scenario)
    assert count(blocks) == SAMPLES - lost
    assert blocks[-1].first + len(blocks[-1].flags) == SAMPLES
    assert source.remarks()[0].endswith(f": {told}")


@pytest.mark.parametrize("driver", ["stim210", "stim300"])
def test_damaged_frames_are_lost_and_counted(driver: str) -> None:
    blocks, source = acquired(driver, scenario="bad-crc")
    lost = SAMPLES - count(blocks)
    assert lost > 10
    assert source.remarks()[0].split(": ")[1].startswith(f"{lost} samples lost in")
    assert source.remarks()[1].endswith(f": {lost} frames with bad CRC")


@pytest.mark.parametrize(
    ("scenario", "flag"),
    [("overload-status", SampleFlag.OVERLOAD), ("channel-error", SampleFlag.FAULT)],
)
def test_what_the_unit_says_of_its_samples_becomes_flags(scenario: str, flag: SampleFlag) -> None:
    blocks, _ = acquired("stim210", scenario=scenario)
    flags = np.concatenate([block.flags for block in blocks])
    assert 40 < np.count_nonzero(flags) < 60
    assert set(flags[flags > 0].tolist()) == {flag}


@pytest.mark.parametrize("way", WAYS)
def test_a_line_that_goes_dead_is_a_lost_connection(way: str) -> None:
    with bench("stim210", way, "unplugged") as (served, source):
        source.open()
        source.configure(0.008)
        begin(served, source)
        with pytest.raises(InstrumentError, match="connection lost"):
            run(source)


def test_another_baud_rate_is_said_before_the_record() -> None:
    with bench("stim210", scenario="wrong-baud-rate") as (served, source):
        source.open()
        with pytest.raises(InstrumentProtocolError, match="is baud_rate that of the unit"):
            source.configure(0.008)
        assert served.clock.now_s() < 10.0


def test_a_unit_set_otherwise_is_said_before_the_record() -> None:
    with bench("stim300", scenario="other-configuration") as (_, source):
        source.open()
        with pytest.raises(
            InstrumentError, match="its mode is incremental_angle, the station says rate"
        ):
            source.configure(0.008)
