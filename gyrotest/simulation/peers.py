"""Which simulated instrument stands behind a driver."""

import importlib
from collections.abc import Callable, Iterable
from typing import Protocol

from gyrotest.errors import StationError
from gyrotest.records.station import Station
from gyrotest.simulation.figures import fault, given_figures
from gyrotest.simulation.peer import Making, Peer

# By the driver's name, or the model that is a part of it (`agilent34401a` drives a 34401A): where the
# peer's class is. It is loaded on first use.
_CLASSES = {
    "34401a": "gyrotest.simulation.meter_peer:MeterPeer",
    "34465a": "gyrotest.simulation.meter_peer:MeterPeer",
    "stim210": "gyrotest.simulation.stim_peer:StimPeer",
    "stim300": "gyrotest.simulation.stim_peer:StimPeer",
    "line_stream": "gyrotest.simulation.line_peer:LinePeer",
    "acutrol3000": "gyrotest.simulation.table_peer:TablePeer",
    "aerosmith": "gyrotest.simulation.table_peer:TablePeer",
    "34970a": "gyrotest.simulation.scanner_peer:ScannerPeer",
    "34972a": "gyrotest.simulation.scanner_peer:ScannerPeer",
    "daq970a": "gyrotest.simulation.scanner_peer:ScannerPeer",
    "daq973a": "gyrotest.simulation.scanner_peer:ScannerPeer",
    "scpi_supply": "gyrotest.simulation.supply_peer:SupplyPeer",
    "33500b": "gyrotest.simulation.generator_peer:GeneratorPeer",
    "sync_stream": "gyrotest.simulation.daq_peer:DaqPeer",
    "scpi_chamber": "gyrotest.simulation.chamber_peer:ChamberPeer",
}
_SIMULATED = "simulated"


class PeerClass(Protocol):
    """A peer's class."""

    def __call__(self, making: Making) -> Peer:
        """Make one."""

    def check(self, station: Station, name: str) -> None:
        """Raise `StationError` with all complaints about an entry of `simulation.instruments`."""


def is_simulated(resource: str) -> bool:
    """Whether the simulated bench serves an instrument with this resource."""
    return resource == _SIMULATED or resource.startswith(f"{_SIMULATED}:")


def peer_class(station: Station, name: str) -> PeerClass:
    """The class of the simulated instrument; raises `StationError` where there is none."""
    driver = station.instruments[name].driver.lower()
    given = given_figures(station, name)
    wanted = (str(given.get("model", "")).lower(), driver)
    found = next((path for one in wanted for path in _paths(one)), None)
    if found is None:
        message = f"the driver '{driver}' cannot be simulated (known: {', '.join(sorted(_CLASSES))})"
        raise StationError([fault(f"instruments.{name}.driver", message)])
    module, _, attribute = found.partition(":")
    made: PeerClass = getattr(importlib.import_module(module), attribute)
    return made


def _paths(wanted: str) -> Iterable[str]:
    exact = _CLASSES.get(wanted)
    return [exact] if exact else [path for part, path in _CLASSES.items() if part in wanted]


def make_peer(making: Making) -> Peer:
    """Make an instrument's peer; raises `StationError`."""
    made: Callable[[Making], Peer] = peer_class(making.station, making.name)
    return made(making)
