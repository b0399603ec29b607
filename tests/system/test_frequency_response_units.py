"""Simulated units on the vibration table, each with its own grating, skew and gain errors: the truth, honestly."""

import cmath
import math
import statistics
from pathlib import Path

import numpy as np
import pytest

from gyrotest.records.result import JudgedResult
from gyrotest.records.run import RunRecord
from gyrotest.simulation.dynamics import frequency_response
from gyrotest.specification.lookup import shipped_specs
from gyrotest.specification.spec import load_spec
from gyrotest.specification.station import load_station
from gyrotest.units import conversion_factor

from .units import run_units

pytestmark = [pytest.mark.slow]
UNITS = [str(9000 + 53 * number) for number in range(30)]
FREQUENCIES_HZ = (10, 40, 90)
SPEC = """
model: FOG50D
output: {kind: voltage, scale_factor: 20 mV/(deg/s), full_scale: 100 deg/s, bandwidth: 80 Hz}
cases:
  random:
    procedure: random_vibration
    duration: 40 s
    interval: 400 us
    parameters: {level: 2.5 deg/s, rest: 20 s, frequencies: [10 Hz, 40 Hz, 90 Hz]}
"""


@pytest.fixture(scope="module")
def records(tmp_path_factory: pytest.TempPathFactory) -> list[RunRecord]:
    folder: Path = tmp_path_factory.mktemp("vibration")
    (folder / "spec.yaml").write_text(SPEC, encoding="utf-8")
    shipped = (shipped_specs() / "stations" / "simulated.yaml").read_text(encoding="utf-8")
    # With so much noise the random error shows beside what is systematic.
    noisy = shipped.replace("angle_random_walk: 0.05 deg/sqrt(h)", "angle_random_walk: 0.6 deg/sqrt(h)")
    assert noisy != shipped
    (folder / "station.yaml").write_text(noisy, encoding="utf-8")
    spec, station = load_spec(folder / "spec.yaml"), load_station(folder / "station.yaml")
    return list(run_units(folder, UNITS, spec=spec, station=station))


def found(record: RunRecord, name: str) -> JudgedResult:
    (one,) = [one for one in record.results if one.name == name]
    return one


def true_response(record: RunRecord, frequency_hz: float) -> complex:
    (attempt,) = [item.last for item in record.items]
    assert attempt is not None
    return complex(frequency_response(np.array([frequency_hz]), attempt.truth)[0])


def z(one: JudgedResult, unit: str, truth: float) -> float:
    assert one.value is not None
    assert one.expanded_uncertainty is not None
    assert one.coverage_factor is not None
    assert not one.not_included
    factor = conversion_factor(one.unit, unit)
    standard = one.expanded_uncertainty * factor / one.coverage_factor
    return (one.value * factor - truth) / standard


def assert_honest(ratios: list[float]) -> None:
    assert abs(statistics.fmean(ratios)) <= 0.55, ratios
    assert 0.65 <= statistics.stdev(ratios) <= 1.4, ratios


@pytest.mark.parametrize("frequency_hz", FREQUENCIES_HZ)
def test_the_gain_is_within_its_stated_uncertainty(records: list[RunRecord], frequency_hz: int) -> None:
    assert_honest(
        [
            z(
                found(one, f"sensitivity_{frequency_hz}Hz"),
                "V*s/deg",
                abs(true_response(one, frequency_hz)),
            )
            for one in records
        ]
    )


@pytest.mark.parametrize("frequency_hz", FREQUENCIES_HZ)
def test_the_phase_is_within_its_stated_uncertainty(records: list[RunRecord], frequency_hz: int) -> None:
    def truth_deg(record: RunRecord) -> float:
        return math.degrees(cmath.phase(true_response(record, frequency_hz)))

    assert_honest([z(found(one, f"phase_{frequency_hz}Hz"), "deg", truth_deg(one)) for one in records])


def test_the_bandwidth_is_within_its_stated_uncertainty(records: list[RunRecord]) -> None:
    def truth_hz(record: RunRecord) -> float:
        (attempt,) = [item.last for item in record.items]
        assert attempt is not None
        # The −3 dB point counts from the reference frequency, not from 0 Hz.
        at_reference = abs(true_response(record, 5.0))
        grid = np.linspace(60.0, 100.0, 40_001)
        gain = np.abs(frequency_response(grid, attempt.truth))
        return float(grid[np.argmax(gain < at_reference / math.sqrt(2.0))])

    assert_honest([z(found(one, "bandwidth_3db"), "Hz", truth_hz(one)) for one in records])
