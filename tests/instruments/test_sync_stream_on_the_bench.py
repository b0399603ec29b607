"""The block protocol's driver on the simulated bench: units and encoders behind a real socket."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from gyrotest.errors import InstrumentError
from gyrotest.instruments.sync_stream import SyncStream
from gyrotest.instruments.sync_stream_settings import SyncStreamSettings
from gyrotest.instruments.synchronous.settings import Trigger
from gyrotest.records.recording import Block, Sampling
from gyrotest.records.spec import Output, OutputKind, Spec
from gyrotest.records.station import Encoder, Instrument, Simulation, Slot, Station
from gyrotest.simulation.bench import SimulatedBench
from gyrotest.units import Quantity

SPEC = Spec(
    model="FOG",
    output=Output(kind=OutputKind.VOLTAGE, scale_factor=Quantity(50.0, "mV/(deg/s)")),
    cases={},
)
GRATING = Slot(
    source="daq", channel="gyro", encoder=Encoder(sine="ua", cosine="ub", lines=9000), models=("FOG",)
)
SHAFT = Encoder(angle="theta")
INTERVAL_S = 1e-4
SAMPLES = 50_000


@contextmanager
def bench(
    slots: dict[str, Slot], scenario: str = "nominal", trigger: Trigger = Trigger.IMMEDIATE
) -> Iterator[tuple[SimulatedBench, SyncStream]]:
    station = Station(
        name="wire",
        instruments={"daq": Instrument(driver="sync_stream", resource="simulated:tcp")},
        slots=slots,
        simulation=Simulation(scenario=scenario),
    )
    with SimulatedBench(station, SPEC) as served:
        for number, slot in enumerate(slots):
            served.insert(slot=slot, serial_number=str(number))
        source = SyncStream(
            served.address("daq"),
            SyncStreamSettings(trigger=trigger),
            clock=served.clock,
            io_timeout_s=2.0,
        )
        try:
            assert source.open().simulated
            yield served, source
        finally:
            source.close()


def begin(served: SimulatedBench, slots: dict[str, Slot]) -> None:
    for number, slot in enumerate(slots):
        served.begin(
            slot=slot,
            serial_number=str(number),
            case="still",
            power_cycle=1,
            repeat=1,
            elapsed_s=0.0,
            duration_s=SAMPLES * INTERVAL_S,
        )


def grating(scenario: str = "nominal", trigger: Trigger = Trigger.IMMEDIATE) -> tuple[list[Block], str]:
    """A record of a unit beside a grating at rest, and the remarks on it."""
    slots = {"a": GRATING}
    with bench(slots, scenario, trigger) as (served, source):
        source.select(("gyro",), ("ua", "ub"))
        source.configure(INTERVAL_S)
        begin(served, slots)
        source.start(0, SAMPLES)
        return list(iter(source.fetch, None)), " ".join(source.remarks())


def missing(blocks: list[Block]) -> int:
    return SAMPLES - sum(len(one.flags) for one in blocks)


@pytest.mark.parametrize("trigger", Trigger)
def test_a_gyro_and_its_grating_come_without_a_gap(trigger: Trigger) -> None:
    blocks, remarks = grating(trigger=trigger)
    values = np.concatenate([one.values for one in blocks])
    position = np.concatenate([one.first + np.arange(len(one.flags)) for one in blocks])
    np.testing.assert_array_equal(position, np.arange(SAMPLES))
    assert not np.concatenate([one.flags for one in blocks]).any()
    # The table rests: the grating's signals stand still on their circle, the gyro shows its noise.
    assert np.hypot(values[:, 1], values[:, 2]).mean() == pytest.approx(1.0, abs=0.06)
    assert values[:, 1:].std(axis=0).max() < 0.001
    assert 1e-4 < values[:, 0].std() < 0.1
    assert remarks.endswith("no sample lost")


def test_two_units_on_a_shaft_come_with_its_angle() -> None:
    slots = {
        name: Slot(source="daq", channel=f"gyro_{name}", encoder=SHAFT, models=("FOG",))
        for name in ("x", "z")
    }
    with bench(slots) as (served, source):
        source.select(("gyro_x", "gyro_z"), ("theta",))
        sampling: Sampling = source.configure(INTERVAL_S)
        begin(served, slots)
        source.start(0, 1000)
        values = np.concatenate([one.values for one in iter(source.fetch, None)])
    assert sampling.columns == ("gyro_x", "gyro_z", "theta")
    assert [one.unit for one in sampling.auxiliary] == ["deg"]
    assert abs(np.corrcoef(values[:, 0], values[:, 1])[0, 1]) < 0.2
    assert values[:, 2].std() < 0.01


def test_an_overrun_is_a_gap_of_the_grid_and_told() -> None:
    blocks, remarks = grating("daq-overrun")
    assert missing(blocks) == 200
    assert "200 samples lost by overrun in 1 gap" in remarks


def test_a_damaged_block_is_a_gap_of_the_grid_and_told() -> None:
    blocks, remarks = grating("daq-bad-block")
    assert missing(blocks) > 0
    assert f"{missing(blocks)} samples lost on the way in 1 gap" in remarks
    assert "1 block with bad CRC" in remarks


def test_a_broken_connection_is_bridged_on_the_grid() -> None:
    slots = {"a": GRATING}
    with bench(slots, "daq-lost") as (served, source):
        source.select(("gyro",), ("ua", "ub"))
        source.configure(INTERVAL_S)
        begin(served, slots)
        source.start(0, SAMPLES)
        with pytest.raises(InstrumentError, match="connection lost"):
            list(iter(source.fetch, None))
        first = source.recover()
        source.start(first, SAMPLES)
        blocks = list(iter(source.fetch, None))
        assert 0 < first < SAMPLES
        assert (blocks[0].first, blocks[-1].first + len(blocks[-1].flags)) == (first, SAMPLES)
        assert "connected anew 1 time" in " ".join(source.remarks())


def test_the_same_record_comes_again() -> None:
    first, second = grating()[0], grating()[0]
    np.testing.assert_array_equal(
        np.concatenate([one.values for one in first]), np.concatenate([one.values for one in second])
    )
