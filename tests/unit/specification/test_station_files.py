"""Stations: what is read, and every complaint, all at once and with its line."""

from collections.abc import Callable
from datetime import date
from pathlib import Path

import pytest

from gyrotest.errors import StationError
from gyrotest.records.station import Instrument, StationDocument
from gyrotest.specification.station import instrument_settings
from gyrotest.units import Quantity

from .conftest import Meter, Settings

Read = Callable[[str], StationDocument]
Faults = Callable[[str], list[str]]

GOOD = """\
name: Bench 1
line_frequency: 50 Hz
site: {latitude: 48 deg, heading: 10 deg}
instruments:
  meter:
    driver: meter
    resource: GPIB0::22::INSTR
    settings: {range: 10 V, nplc: 10}
    accuracy: {of_reading: 35 ppm, of_range: 5 ppm, noise: 3 uV}
    io_timeout: 5 s
    calibration: {certificate: C-1, date: 2026-01-15, due: 2027-01-15}
slots:
  a: {source: meter}
"""
SIMULATION = "simulation: {gyro: {}, instruments: {meter: {}}}\n"
SIMULATED = GOOD.replace("GPIB0::22::INSTR", "simulated") + SIMULATION


def edited(old: str, new: str, text: str = GOOD) -> str:
    assert old in text
    return text.replace(old, new, 1)


def test_a_good_station_becomes_a_record(station: Read) -> None:
    found = station(GOOD).station
    meter = found.instruments["meter"]
    assert meter.calibration is not None
    assert meter.calibration.due == date(2027, 1, 15)
    assert meter.accuracy is not None
    assert meter.accuracy.of_reading.to("") == pytest.approx(35e-6)
    assert found.simulation is None
    assert meter.resource == "GPIB0::22::INSTR"


def test_a_simulated_station_has_a_simulation(station: Read) -> None:
    assert station(SIMULATED).station.simulation is not None


@pytest.mark.parametrize("way", ["", ":tcp", ":pty", ":prologix", ":prologix-pty"])
def test_every_way_to_a_simulated_instrument_is_known(station: Read, way: str) -> None:
    station(edited("resource: simulated", f"resource: simulated{way}", SIMULATED))


def test_settings_become_the_drivers_own_record() -> None:
    instrument = Instrument(driver="meter", resource="x", settings={"nplc": 1})
    assert instrument_settings(instrument, Meter) == Settings(nplc=1.0)
    assert instrument_settings(Instrument(driver="meter", resource="x"), Meter).range == Quantity(
        10.0, "V"
    )


def test_settings_that_do_not_fit_are_refused() -> None:
    with pytest.raises(StationError, match=r"settings\.nplcs: unknown key; did you mean 'nplc'\?"):
        instrument_settings(Instrument(driver="meter", resource="x", settings={"nplcs": 1}), Meter)


def test_a_relative_file_begins_at_the_stations_folder(station: Read, tmp_path: Path) -> None:
    found = station(
        edited("driver: meter\n    resource: GPIB0::22::INSTR", "driver: player\n    resource: a/b.csv")
    )
    assert found.station.instruments["meter"].resource == str(tmp_path / "a" / "b.csv")
    absolute = tmp_path / "c.csv"
    found = station(
        edited(
            "driver: meter\n    resource: GPIB0::22::INSTR", f"driver: player\n    resource: {absolute}"
        )
    )
    assert found.station.instruments["meter"].resource == str(absolute)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("name: Bench 1", "name: ''", "1: name: '' is not a name of 1 to 64"),
        ("name: Bench 1\n", "", "name: is missing (The bench's name, as it is printed)"),
        ("50 Hz", "55 Hz", "2: line_frequency: '55 Hz' is neither '50 Hz' nor '60 Hz'"),
        ("50 Hz", "50", "50 is not a quantity"),
        ("50 Hz", "50 V", "'50 V' is not a frequency"),
        ("48 deg", "91 deg", "3: site.latitude: '91 deg' is not between '-90 deg' and '90 deg'"),
        ("10 deg", "400 deg", "site.heading: '400 deg' is not between"),
        ("latitude: 48 deg, ", "", "site.latitude: is missing"),
        (
            "driver: meter",
            "driver: metre",
            "6: instruments.meter.driver: cannot be used: 'metre' is not installed",
        ),
        (
            "driver: meter",
            "drivers: meter",
            "instruments.meter.drivers: unknown key; did you mean 'driver'?",
        ),
        (
            "  meter:\n",
            "  Meter 1:\n",
            "5: instruments.Meter 1: an instrument is named by small letters",
        ),
        ("GPIB0::22::INSTR", "''", "7: instruments.meter.resource: is empty or not printable"),
        ("GPIB0::22::INSTR", "22", "22 is not text; put it in quotes: '22'"),
        ("GPIB0::22::INSTR", "simulated", "'simulated' needs a section 'simulation:'"),
        ("GPIB0::22::INSTR", "simulated:usb", "'simulated:usb' is not one of simulated, simulated:tcp"),
        ("nplc: 10", "nplc: ten", "8: instruments.meter.settings.nplc: 'ten' is not a number"),
        ("nplc: 10", "nplc: 1000", "instruments.meter.settings: nplc is at most 100"),
        ("nplc: 10", "npcl: 10", "settings.npcl: unknown key; did you mean 'nplc'?"),
        ("range: 10 V", "range: 10 A", "settings.range: '10 A' is not a voltage"),
        (
            "of_reading: 35 ppm",
            "of_reading: -35 ppm",
            "9: instruments.meter.accuracy.of_reading: '-35 ppm' is less",
        ),
        ("of_reading: 35 ppm, ", "", "accuracy.of_reading: is missing"),
        ("noise: 3 uV", "noise: 3 s", "'3 s' is not a voltage or an angular rate"),
        ("io_timeout: 5 s", "io_timeout: 0 s", "'0 s' is not more than zero"),
        (
            "due: 2027-01-15",
            "due: 2025-01-15",
            "calibration.due: due on 2025-01-15, before the calibration itself",
        ),
        ("due: 2027-01-15", "due: 15.1.2027", "'15.1.2027' is not a date such as 2026-03-31"),
        ("due: 2027-01-15", "due: 2027-02-30", "'2027-02-30' is not a date"),
        ("due: 2027-01-15", "due: 20270115", "20270115 is not a date"),
        ("due: 2027-01-15", "due: '20270115'", "'20270115' is not a date"),
        ("due: 2027-01-15", "due: '1700000000'", "'1700000000' is not a date"),
        ("due: 2027-01-15", "due: '2027-01-15T00:00:00'", "'2027-01-15T00:00:00' is not a date"),
        (
            "source: meter",
            "source: metr",
            "13: slots.a.source: 'metr' is no instrument of this station; did you mean",
        ),
        ("source: meter", "source: meter, channel: 101", "101 is not text; put it in quotes: '101'"),
        ("slots:\n  a: {source: meter}", "slots: {}", "slots: is empty"),
        ("site:", "allow_expired_calibration: yes\nsite:", "'yes' is not true or false"),
    ],
)
def test_what_is_wrong_is_told_in_the_users_words(
    station_faults: Faults, old: str, new: str, expected: str
) -> None:
    faults = station_faults(edited(old, new))
    assert any(expected in fault for fault in faults), faults


def test_a_simulated_bench_has_no_real_instrument(station_faults: Faults) -> None:
    faults = station_faults(GOOD + SIMULATION)
    assert len(faults) == 1
    assert (
        "7: instruments.meter.resource: 'GPIB0::22::INSTR' is not simulated, but the bench is"
        in faults[0]
    )


def test_simulated_figures_are_of_an_instrument_of_the_station(station_faults: Faults) -> None:
    faults = station_faults(edited("{meter: {}}", "{metre: {}}", SIMULATED))
    assert faults == [
        "14: simulation.instruments.metre: is no instrument of this station; did you mean 'meter'?"
    ]


def test_a_station_without_instruments_is_refused(station_faults: Faults) -> None:
    faults = station_faults("name: x\ninstruments: {}\nslots: {a: {source: meter}}\n")
    assert any("2: instruments: is empty" in fault for fault in faults)
