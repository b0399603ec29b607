"""The simulated bench as a whole: instruments on first use, and units that feel the table and the chamber."""

import socket
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gyrotest.errors import StationError
from gyrotest.records.spec import Output, OutputKind, Spec
from gyrotest.records.station import Instrument, Motion, Simulation, Site, Slot, Station
from gyrotest.simulation.bench import SimulatedBench
from gyrotest.simulation.complaints import simulation_faults
from gyrotest.simulation.response import response_of
from gyrotest.simulation.scenarios import SCENARIOS
from gyrotest.simulation.table_peer import TablePeer
from gyrotest.units import Quantity

ANALOGUE = Output(
    kind=OutputKind.VOLTAGE,
    scale_factor=Quantity(50.0, "mV/(deg/s)"),
    zero_rate=Quantity(2.5, "V"),
    full_scale=Quantity(100.0, "deg/s"),
)
DIGITAL = Output(kind=OutputKind.RATE, axes=("x", "y", "z"), full_scale=Quantity(400.0, "deg/s"))
QUIET = {
    "angle_random_walk": "0 deg/sqrt(h)",
    "bias_instability_coefficient": "0 deg/h",
    "rate_random_walk": "0 deg/h/sqrt(h)",
    "warm_up_drift": "0 deg/s",
    "nonlinearity": "1000 ppm",
    "asymmetry": "2000 ppm",
}
MOUNTINGS = {"x": (0.0, 1.0, 0.0), "y": (0.0, 0.0, 1.0), "z": (-1.0, 0.0, 0.0)}


def station(*, gyro: Mapping[str, Any] | None = None, table: Mapping[str, Any] | None = None) -> Station:
    motion = Motion(
        max_rate=Quantity(200.0, "deg/s"), max_acceleration=Quantity(100.0, "deg/s/s"), slip_ring=True
    )
    exact = {"gain_error": "0 %", "setting_error": "0 deg/s", "ripple": "0 %"}
    return Station(
        name="simulated",
        site=Site(latitude=Quantity(48.0, "deg"), heading=Quantity(0.0, "deg")),
        instruments={
            "meter": Instrument(driver="agilent34401a", resource="simulated"),
            "stim": Instrument(
                driver="stim210",
                resource="simulated",
                settings={"frame": "rate_counter", "sample_rate": "125 Hz"},
            ),
            "table": Instrument(driver="acutrol3000", resource="simulated", motion=motion),
            "chamber": Instrument(driver="scpi_chamber", resource="simulated"),
        },
        slots={
            "a": Slot(source="meter", table="table", chamber="chamber"),
            "s": Slot(source="stim", table="table", models=("STIM210",)),
        },
        simulation=Simulation(
            gyro={**QUIET, **(gyro or {})}, instruments={"table": {**exact, **(table or {})}}
        ),
    )


def spec(output: Output) -> Spec:
    return Spec(model="STIM210" if output is DIGITAL else "MEMS50", cases={}, output=output)


def begin(
    served: SimulatedBench, slot: str, mountings: Mapping[str, tuple[float, float, float]]
) -> None:
    served.begin(
        slot=slot,
        serial_number="77",
        case="c",
        power_cycle=1,
        repeat=1,
        elapsed_s=600.0,
        duration_s=100.0,
        mountings=mountings,
    )


def turn(served: SimulatedBench, rate_dps: float) -> None:
    """Turn the table, and wait until it does."""
    served.address("table")
    table = served._peers["table"]
    assert isinstance(table, TablePeer)
    table.table.set_rate(rate_dps)
    served.clock.sleep_until(served.clock.now_s() + 10.0)


def connect(served: SimulatedBench, name: str) -> socket.socket:
    return socket.create_connection(("127.0.0.1", int(served.address(name).split("::")[2])), 5.0)


def test_an_instrument_is_made_when_it_is_first_needed() -> None:
    with SimulatedBench(station(), spec(ANALOGUE)) as served:
        begin(served, "a", {})
        assert set(served._peers) == {"meter"}
        assert served.address("table") == served.address("table")
        assert set(served._peers) == {"meter", "table"}


def test_an_instrument_that_comes_later_has_the_errors_of_this_unit() -> None:
    made = station(table={"gain_error": "100 ppm"})
    truths = []
    for early in (True, False):
        with SimulatedBench(made, spec(ANALOGUE)) as served:
            if early:
                served.address("table")
            begin(served, "a", {})
            served.address("table")
            truths.append(served.truth("a", duration_s=1.0)["table_gain_error"])
    assert truths[0] == truths[1] != 0.0


@pytest.mark.parametrize("rate_dps", [-80.0, -5.0, 0.0, 20.0, 90.0])
def test_a_meter_reads_what_the_response_makes_of_the_tables_rate(rate_dps: float) -> None:
    with SimulatedBench(station(), spec(ANALOGUE)) as served, connect(served, "meter") as meter:
        begin(served, "a", {"": (1.0, 0.0, 0.0)})
        turn(served, rate_dps)
        meter.sendall(b"READ?\n")
        found_v = float(meter.recv(100))
        truth = served.truth("a", duration_s=1.0)
    expected = response_of(truth).output(
        np.array([rate_dps + truth["earth_dps"]]), bias_dps=truth["bias_dps"]
    )
    assert truth["nonlinearity"] != 0.0
    assert found_v == pytest.approx(expected[0], abs=3e-4)


def test_each_axis_of_a_digital_gyro_feels_its_share() -> None:
    with SimulatedBench(station(), spec(DIGITAL)) as served, connect(served, "stim") as line:
        served.insert(slot="s", serial_number="77")
        served.clock.sleep_until(1.0)
        turn(served, 40.0)
        begin(served, "s", MOUNTINGS)
        line.setblocking(False)
        while True:  # what came before the record
            try:
                line.recv(1 << 20)
            except BlockingIOError:
                break
        served.clock.sleep_until(served.clock.now_s() + 9.0)  # a whole turn
        line.settimeout(5.0)
        data = b""
        while len(data) < 1125 * 13:
            data += line.recv(1 << 20)
        truth = served.truth("s", duration_s=9.0)
    raw = np.frombuffer(data, dtype=np.uint8).reshape(-1, 13)[:, 1:10].reshape(-1, 3, 3).astype(np.int32)
    rates_dps = (raw[:, :, 0] << 24 | raw[:, :, 1] << 16 | raw[:, :, 2] << 8) / 2**22
    assert len(rates_dps) == 1125
    for place, axis in enumerate("xyz"):
        down = -40.0 - abs(truth["z.earth_dps"]) if axis == "z" else 0.0
        expected = response_of(truth, axis).output(np.array([down]), bias_dps=truth[f"{axis}.bias_dps"])[
            0
        ]
        assert rates_dps[:, place].mean() == pytest.approx(expected, abs=4e-5)
    level = np.ptp(rates_dps[:, 0])
    assert level == pytest.approx(2.0 * 15.041 / 3600.0 * np.cos(np.radians(48.0)), abs=2e-4)


def test_a_table_may_lie_on_its_side() -> None:
    made = station(table={"axis": [0, 1, 0]})
    with SimulatedBench(made, spec(ANALOGUE)) as served:
        begin(served, "a", {"": (0.0, 2.0, 0.0)})
        assert served.truth("a", duration_s=1.0)["table_share"] == pytest.approx(1.0)
        begin(served, "a", {"": (1.0, 0.0, 0.0)})
        assert served.truth("a", duration_s=1.0)["table_share"] == pytest.approx(0.0)


@pytest.mark.parametrize("axis", ["up", [0, 0, 0], [1, 0], None])
def test_a_tables_axis_that_is_no_direction_is_refused(axis: object) -> None:
    faults = simulation_faults(station(table={"axis": axis}))
    assert [one.key for one in faults] == ["simulation.instruments.table.axis"]


def test_complaints_about_models_name_the_model() -> None:
    made = replace(station(), simulation=Simulation(models={"MEMS50": {"asymetry": "1 ppm"}}))
    (fault,) = simulation_faults(made)
    assert fault.key == "simulation.models.MEMS50.asymetry"
    assert "did you mean 'asymmetry'" in fault.message
    with pytest.raises(StationError, match="asymetry"):
        SimulatedBench(made, spec(ANALOGUE))


def test_a_driver_that_cannot_be_simulated_is_named() -> None:
    made = replace(station(), instruments={"meter": Instrument(driver="k2000", resource="simulated")})
    (fault,) = simulation_faults(
        replace(made, slots={"a": Slot(source="meter")}, simulation=Simulation())
    )
    assert fault.key == "instruments.meter.driver"
    assert "'k2000' cannot be simulated" in fault.message


def test_a_units_clock_may_be_off() -> None:
    made = station(gyro={"clock_error": "1 %"})
    with SimulatedBench(made, spec(DIGITAL)) as served, connect(served, "stim") as line:
        served.insert(slot="s", serial_number="77")
        served.clock.sleep_until(0.5)
        begin(served, "s", {})
        line.settimeout(5.0)
        line.recv(1 << 20)
        served.clock.sleep_until(8.5)
        data = line.recv(1 << 20)
    assert len(data) / 13 == pytest.approx(1010, abs=1)


def test_every_scenario_says_what_it_is() -> None:
    assert all(name == one.name and len(one.description) > 10 for name, one in SCENARIOS.items())
