"""A simulated generator behind a server, for the tests of the driver that drives a vibration table."""

import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from gyrotest.instruments.keysight33500b import Keysight33500B
from gyrotest.instruments.keysight33500b_settings import Keysight33500BSettings
from gyrotest.instruments.transport.channel import Connect
from gyrotest.instruments.transport.visa import open_channel
from gyrotest.ports import Clock
from gyrotest.records.station import Instrument, Simulation, Slot, Station
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.dialogue import Dialogue, Parts
from gyrotest.simulation.generator import Wave
from gyrotest.simulation.generator_peer import GeneratorPeer
from gyrotest.simulation.meter_state import Interface
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.peer import Making
from gyrotest.simulation.scenarios import SCENARIOS
from gyrotest.simulation.server import PtyServer, TcpServer
from gyrotest.units import Quantity

SETTINGS: Mapping[str, Any] = {
    "sensitivity": Quantity(20.0, "deg/s/V"),
    "max_voltage": Quantity(5.0, "V"),
    "max_rate": Quantity(40.0, "deg/s"),
}


def settings(**changed: Any) -> Keysight33500BSettings:
    """The settings of a common table, some of them changed."""
    return Keysight33500BSettings(**{**SETTINGS, **changed})


def station(*, figures: Mapping[str, Any] | None = None, **stated: Any) -> Station:
    """A bench with a generator alone, its settings as a station file has them."""
    return Station(
        name="bench",
        instruments={
            "exciter": Instrument(driver="keysight33500b", resource="simulated", settings=stated)
        },
        slots={"a": Slot(source="exciter", vibration="exciter")},
        simulation=Simulation(instruments={"exciter": figures} if figures else {}),
    )


def exciter(
    clock: Clock,
    *,
    scenario: str = "nominal",
    seed: int = 1,
    figures: Mapping[str, Any] | None = None,
    **stated: Any,
) -> GeneratorPeer:
    """The generator on the simulated bench, at the begin of a record of 100 s."""
    making = Making(
        station=station(figures=figures, **stated),
        name="exciter",
        clock=clock,
        seed=seed,
        scenario=SCENARIOS[scenario],
    )
    peer = GeneratorPeer(making)
    peer.begin(Occasion(serial_number="SIM1", case="shaken", repeat=1, duration_s=100.0))
    return peer


class Watched:
    """A dialogue that tells when the output was switched off."""

    def __init__(self, dialogue: Dialogue, peer: GeneratorPeer, went_off: threading.Event) -> None:
        self._dialogue = dialogue
        self._peer = peer
        self._went_off = went_off

    def receive(self, data: bytes) -> Parts:
        """Carry out every complete message."""
        before = self._peer.generator.outputs[1].wave.on
        parts = tuple(self._dialogue.receive(data))
        if before and not self._peer.generator.outputs[1].wave.on:
            self._went_off.set()
        return parts


@dataclass(frozen=True)
class Served:
    """A simulated generator behind a server; `went_off` is set when it was switched off."""

    peer: GeneratorPeer
    clock: VirtualClock
    address: str
    went_off: threading.Event

    @property
    def wave(self) -> Wave:
        """What the first output is set to."""
        return self.peer.generator.outputs[1].wave

    def driver(self, *, connect: Connect = open_channel, **changed: Any) -> Keysight33500B:
        """A driver of it, not opened yet."""
        return Keysight33500B(self.address, settings(**changed), clock=self.clock, connect=connect)


@contextmanager
def served(way: str = "tcp", **of_peer: Any) -> Iterator[Served]:
    """Serve a generator over a socket or a pseudo-terminal."""
    clock, went_off = VirtualClock(10.0), threading.Event()
    peer = exciter(clock, **of_peer)
    interface = Interface.SERIAL if way == "pty" else Interface.SOCKET

    def dialogue() -> Dialogue:
        return Watched(peer.dialogue(interface), peer, went_off)

    if way == "pty":
        with PtyServer(dialogue, clock) as pty:
            yield Served(peer, clock, f"ASRL{pty.path}::INSTR", went_off)
        return
    with TcpServer(dialogue, clock) as tcp:
        yield Served(peer, clock, f"TCPIP::127.0.0.1::{tcp.port}::SOCKET", went_off)
