"""Station files → stations: `load_station` reads one and complains of everything in it at once."""

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from gyrotest.errors import Fault, GyrotestError, StationError
from gyrotest.records.station import Accuracy, Instrument, Site, Station, StationDocument
from gyrotest.registry import INSTRUMENTS, load
from gyrotest.specification.checked import Complaint, checked, related, unrelated
from gyrotest.specification.parameters import section, section_or_raise
from gyrotest.specification.reading import known_faults, raise_faults
from gyrotest.specification.shapes import nearest
from gyrotest.specification.slots import motion_complaints, shaft_complaints, slot_complaints
from gyrotest.specification.yaml_document import read_yaml
from gyrotest.specification.yaml_tree import KeyPath
from gyrotest.units import Quantity

SIMULATED = (
    "simulated",
    "simulated:tcp",
    "simulated:pty",
    "simulated:prologix",
    "simulated:prologix-pty",
)
LINE_FREQUENCIES_HZ = (50.0, 60.0)

Drivers = Callable[[str], Any]
SimulationCheck = Callable[[Station], Iterable[Fault]]


def installed_driver(name: str) -> Any:
    """Return the driver class that is installed under a name; raises `GyrotestError`."""
    return load(INSTRUMENTS, name)


def unchecked(_station: Station) -> tuple[Fault, ...]:
    """Leave a station's `simulation` to be checked when a bench is made of it."""
    return ()


def load_station(
    path: Path, drivers: Drivers = installed_driver, simulation: SimulationCheck = unchecked
) -> StationDocument:
    """Read and check a station file; raises `StationError` with all its faults.

    `simulation` complains of what only a simulated bench knows: its keys and figures. Where a driver's
    resource is a file (`resource_is_path`), a relative one begins at the station file's folder.
    """
    document = read_yaml(path, StationError)
    found = checked(document.tree, Station, known_faults(document))
    later = list(_complaints(found.record, drivers, found.complaints))
    known = (*found.complaints, *later)
    later += unrelated(_bench_complaints(found.record, simulation), known)
    raise_faults(document, (*found.complaints, *later), StationError)
    station = _with_paths(found.record, path.parent, drivers)
    return StationDocument(path=document.path, sha256=document.sha256, station=station)


def instrument_settings(instrument: Instrument, driver: Any) -> Any:
    """Return an instrument's settings as its driver's record; raises `StationError`."""
    return section_or_raise(instrument.settings, driver.settings, "settings", StationError)


def _complaints(
    station: Station, drivers: Drivers, earlier: tuple[Complaint, ...]
) -> Iterator[Complaint]:
    yield from unrelated(_head_complaints(station), earlier)
    yield from unrelated(slot_complaints(station), earlier)
    yield from unrelated(_simulation_complaints(station), earlier)
    if station.site is not None:
        yield from unrelated(_site_complaints(station.site), earlier)
    for name, instrument in station.instruments.items():
        key = ("instruments", name)
        yield from unrelated(_instrument_complaints(instrument, key), earlier)
        yield from unrelated(_driver_complaints(instrument, drivers, key, earlier), earlier)


def _head_complaints(station: Station) -> Iterator[Complaint]:
    if not station.name.strip() or not station.name.isprintable() or len(station.name) > 64:
        yield Complaint(
            ("name",), f"{station.name[:80]!r} is not a name of 1 to 64 printable characters"
        )
    if not station.instruments:
        yield Complaint(("instruments",), "is empty; a station has at least one instrument")
    frequency = station.line_frequency
    if frequency is not None and frequency.to("Hz") not in LINE_FREQUENCIES_HZ:
        yield Complaint(("line_frequency",), f"'{frequency}' is neither '50 Hz' nor '60 Hz'")


def _simulation_complaints(station: Station) -> Iterator[Complaint]:
    simulation = station.simulation
    for name, instrument in station.instruments.items():
        key, resource = ("instruments", name, "resource"), instrument.resource
        if resource.split(":")[0].lower() == "simulated":
            if resource not in SIMULATED:
                message = f"'{resource}' is not one of {', '.join(SIMULATED)}"
                yield Complaint(key, message)
            if simulation is None:
                message = f"'{resource}' needs a section 'simulation:' in this file"
                yield Complaint(key, message, (("simulation",),))
        elif simulation is not None:
            message = (
                f"'{resource}' is not simulated, but the bench is: remove the section 'simulation:', "
                "or write 'simulated'"
            )
            yield Complaint(key, message)
    for name in simulation.instruments if simulation else ():
        if name not in station.instruments:
            message = f"is no instrument of this station; {nearest(name, station.instruments)}"
            yield Complaint(("simulation", "instruments", name), message, (("instruments",),))


def _bench_complaints(station: Station, simulation: SimulationCheck) -> Iterator[Complaint]:
    for fault in simulation(station):
        yield Complaint(tuple(fault.key.split(".")), fault.message)


def _site_complaints(site: Site) -> Iterator[Complaint]:
    if abs(site.latitude.to("deg")) > 90:
        yield Complaint(("site", "latitude"), f"'{site.latitude}' is not between '-90 deg' and '90 deg'")
    if site.heading is not None and abs(site.heading.to("deg")) > 360:
        yield Complaint(("site", "heading"), f"'{site.heading}' is not between '-360 deg' and '360 deg'")


def _instrument_complaints(instrument: Instrument, key: KeyPath) -> Iterator[Complaint]:
    if not re.fullmatch("[a-z][a-z0-9_]{0,63}", str(key[-1])):
        message = "an instrument is named by small letters, digits and '_', a letter first, e.g. 'meter'"
        yield Complaint(key, message)
    if not instrument.resource.strip() or not instrument.resource.isprintable():
        message = "is empty or not printable; write e.g. 'GPIB0::22::INSTR'"
        yield Complaint((*key, "resource"), message)
    calibration, timeout = instrument.calibration, instrument.io_timeout
    if calibration is not None and calibration.due < calibration.date:
        message = f"due on {calibration.due}, before the calibration itself ({calibration.date})"
        yield Complaint((*key, "calibration", "due"), message, ((*key, "calibration", "date"),))
    if timeout is not None and timeout.value <= 0:
        yield Complaint((*key, "io_timeout"), f"'{timeout}' is not more than zero")
    if instrument.motion is not None:
        yield from motion_complaints(instrument.motion, (*key, "motion"))
    if instrument.shaft is not None:
        yield from shaft_complaints(instrument.shaft, (*key, "shaft"))
    if instrument.accuracy is not None:
        yield from _accuracy_complaints(instrument.accuracy, (*key, "accuracy"))


def _accuracy_complaints(accuracy: Accuracy, key: KeyPath) -> Iterator[Complaint]:
    for name in ("of_reading", "of_range", "of_setting", "noise"):
        value: Quantity | None = getattr(accuracy, name)
        if value is not None and value.value < 0:
            yield Complaint((*key, name), f"'{value}' is less than zero")


def _driver_complaints(
    instrument: Instrument, drivers: Drivers, key: KeyPath, earlier: tuple[Complaint, ...]
) -> Iterator[Complaint]:
    if related((*key, "driver"), earlier):
        return
    try:
        driver = drivers(instrument.driver)
    except (GyrotestError, ImportError) as error:
        yield Complaint((*key, "driver"), f"cannot be used: {error}")
        return
    yield from section(instrument.settings, driver.settings, (*key, "settings")).complaints


def _with_paths(station: Station, folder: Path, drivers: Drivers) -> Station:
    found = {name: _with_path(one, folder, drivers) for name, one in station.instruments.items()}
    return replace(station, instruments=found)


def _with_path(instrument: Instrument, folder: Path, drivers: Drivers) -> Instrument:
    if not getattr(drivers(instrument.driver), "resource_is_path", False):
        return instrument
    return replace(instrument, resource=str(folder.absolute() / instrument.resource))
