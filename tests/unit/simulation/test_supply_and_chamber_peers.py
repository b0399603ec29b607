"""Supply and chamber on the simulated bench: what the station says of them, and what the unit feels."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from gyrotest.errors import StationError
from gyrotest.records.station import Accuracy, Instrument, Simulation, Slot, Station
from gyrotest.simulation.chamber_peer import ChamberPeer
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.meter_state import Interface
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.peer import Heating, Making, Peer, Powering, Talking
from gyrotest.simulation.peers import make_peer, peer_class
from gyrotest.simulation.scenarios import SCENARIOS
from gyrotest.simulation.supply_peer import SupplyPeer
from gyrotest.units import Quantity


def making(
    name: str, *, scenario: str = "nominal", seed: int = 1, figures: Mapping[str, Any] | None = None
) -> Making:
    accuracy = Accuracy(of_reading=Quantity(0.0, "%"), of_setting=Quantity(0.5, "degC"))
    station = Station(
        name="bench",
        instruments={
            "psu": Instrument(driver="scpi_supply", resource="simulated", settings={"outputs": 2}),
            "oven": Instrument(driver="scpi_chamber", resource="simulated", accuracy=accuracy),
        },
        slots={"a": Slot(source="psu", supply="psu", supply_output=3, chamber="oven")},
        simulation=Simulation(instruments={name: figures} if figures else {}),
    )
    return Making(
        station=station, name=name, clock=VirtualClock(), seed=seed, scenario=SCENARIOS[scenario]
    )


def told(peer: Peer, message: str) -> str:
    assert isinstance(peer, Talking)
    parts = peer.dialogue(Interface.SOCKET).receive(f"{message}\n".encode())
    return b"".join(part for _, part in parts).decode().strip()


@pytest.mark.parametrize(("name", "made"), [("psu", SupplyPeer), ("oven", ChamberPeer)])
def test_the_driver_leads_to_its_simulated_peer_that_says_it_is_one(name: str, made: type) -> None:
    peer = make_peer(making(name))
    assert isinstance(peer, made)
    assert told(peer, "*IDN?").split(",")[2].startswith("SIM")


def test_a_supply_has_as_many_outputs_as_the_slots_use_and_feeds_the_unit_from_one() -> None:
    made = making("psu")
    peer = make_peer(made)
    assert isinstance(peer, Powering)
    told(peer, "INST:NSEL 3;:VOLT:PROT 6;:VOLT 5;:CURR 0.2;:OUTP ON")
    made.clock.sleep_until(1.0)
    assert peer.output(1).on_since_s is None
    assert peer.output(3).on_since_s == pytest.approx(0.035, abs=0.005)
    assert float(told(peer, "MEAS:CURR?")) == pytest.approx(0.04, abs=1e-3)


def test_outputs_have_errors_of_their_own_that_a_seed_repeats() -> None:
    def voltage_v(seed: int) -> float:
        made = making("psu", seed=seed, figures={"gain_error": "1 %"})
        peer = SupplyPeer(made)
        told(peer, "VOLT 10;:OUTP ON")
        made.clock.sleep_until(1.0)
        return peer.output(1).voltage_v(1.0)

    assert voltage_v(1) == voltage_v(1) != voltage_v(2)
    assert abs(voltage_v(1) - 10.0) < 0.1


@pytest.mark.parametrize(
    ("scenario", "least_v", "most_v"),
    [("nominal", 4.9, 5.1), ("supply-no-voltage", 0.0, 0.0), ("supply-current-limit", 0.4, 0.6)],
)
def test_scenarios_take_the_voltage_away(scenario: str, least_v: float, most_v: float) -> None:
    made = making("psu", scenario=scenario)
    peer = SupplyPeer(made)
    told(peer, "VOLT 5;:CURR 0.2;:OUTP ON")
    made.clock.sleep_until(1.0)
    assert least_v <= peer.output(1).voltage_v(1.0) <= most_v


def test_a_chamber_is_warmer_than_it_shows_by_an_error_of_its_accuracy_for_each_unit() -> None:
    peer = make_peer(making("oven"))
    assert isinstance(peer, Heating)
    errors = []
    for unit in range(200):
        peer.begin(Occasion(serial_number=str(unit)))
        errors.append(float(peer.temperature_degc(np.zeros(1))[0]) - 23.0)
        assert peer.truth() == {"chamber_offset_c": pytest.approx(errors[-1])}
    assert max(np.abs(errors)) <= 0.5
    assert np.std(errors) == pytest.approx(0.5 / np.sqrt(3), rel=0.15)


def test_a_stuck_chamber_stays_at_the_room_s_temperature() -> None:
    peer = ChamberPeer(making("oven", scenario="chamber-does-not-reach"))
    told(peer, "SOUR:TEMP 60;:OUTP ON")
    assert peer.temperature_degc(np.array([1e5])).tolist() == [23.0]


@pytest.mark.parametrize(
    ("name", "figures", "message"),
    [
        ("psu", {"load": "40 mA"}, "simulation.instruments.psu.load: unknown key"),
        ("psu", {"rise_time": "0 s"}, "rise_time: '0 s' must be more than zero"),
        ("oven", {"lag": "4 V"}, "simulation.instruments.oven.lag"),
    ],
)
def test_wrong_figures_are_complained_of(name: str, figures: dict[str, Any], message: str) -> None:
    made = making(name, figures=figures)
    with pytest.raises(StationError, match=message):
        peer_class(made.station, name).check(made.station, name)
    with pytest.raises(StationError, match=message):
        make_peer(made)
