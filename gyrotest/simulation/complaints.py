"""Everything that is wrong with a station's `simulation`, before a bench is made of it."""

from collections.abc import Callable

from gyrotest.errors import Fault, StationError
from gyrotest.records.station import Station
from gyrotest.simulation.bench import find_scenario
from gyrotest.simulation.gyro_settings import figure_faults
from gyrotest.simulation.peers import is_simulated, peer_class
from gyrotest.simulation.settings import table_axis


def simulation_faults(station: Station) -> tuple[Fault, ...]:
    """The complaints about a station's scenario and about its simulated gyro and instruments."""
    simulation = station.simulation
    if simulation is None:
        return ()
    simulated = [name for name, one in station.instruments.items() if is_simulated(one.resource)]
    return (
        *_faults_of(find_scenario, simulation.scenario),
        *figure_faults(simulation),
        *(fault for name in simulated for fault in _faults_of(_check, station, name)),
    )


def _check(station: Station, name: str) -> None:
    peer_class(station, name).check(station, name)
    table_axis(station, name)


def _faults_of(make: Callable[..., object], *given: object) -> tuple[Fault, ...]:
    try:
        make(*given)
    except StationError as error:
        return error.faults
    return ()
