"""Checking a file of which nobody says whether it is a spec or a station."""

from pathlib import Path

from gyrotest.errors import DocumentError
from gyrotest.records.spec import Spec
from gyrotest.records.station import Station
from gyrotest.specification.cases import Catalogue
from gyrotest.specification.shapes import fields_of
from gyrotest.specification.spec import installed_procedure, load_spec
from gyrotest.specification.station import (
    Drivers,
    SimulationCheck,
    installed_driver,
    load_station,
    unchecked,
)
from gyrotest.specification.yaml_document import read_yaml


def check_file(
    path: Path,
    procedures: Catalogue = installed_procedure,
    drivers: Drivers = installed_driver,
    simulation: SimulationCheck = unchecked,
) -> str:
    """Check a spec or a station, whichever it is, and return what it is; raises `DocumentError`."""
    document = read_yaml(path, DocumentError)
    in_spec, in_station = (
        len(document.tree.keys() & fields_of(record).keys()) for record in (Spec, Station)
    )
    if in_spec == in_station == 0:
        message = "is neither a spec (model, output, cases) nor a station (name, instruments, slots)"
        raise DocumentError([document.fault((), message)])
    if in_station > in_spec:
        station = load_station(path, drivers, simulation).station
        return f"a good station, '{station.name}' ({_counted(len(station.instruments), 'instrument')})"
    spec = load_spec(path, procedures).spec
    return f"a good spec of {spec.model} ({_counted(len(spec.cases), 'case')})"


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
