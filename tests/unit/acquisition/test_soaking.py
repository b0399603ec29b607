"""Temperatures reached, soaked, watched, and those that are not."""

import math

import numpy as np
import pytest

from gyrotest.acquisition.soaking import ChamberDrive
from gyrotest.errors import InstrumentError
from gyrotest.records.plan import Soaking
from gyrotest.records.recording import Identity
from gyrotest.simulation.chamber import ChamberFigures, SimulatedChamber
from gyrotest.simulation.clock import VirtualClock

HOT = Soaking(temperature_degc=60.0, soak_s=600.0, tolerance_c=0.5)


class Bench:
    """A chamber that is a simulated one without a wire."""

    def __init__(self, figures: ChamberFigures | None = None) -> None:
        self.clock = VirtualClock(100.0)
        self.chamber = SimulatedChamber(clock=self.clock, figures=figures)
        self.disturbance_c = 0.0
        self.drive = ChamberDrive(self, clock=self.clock)

    def open(self) -> Identity:
        return Identity(manufacturer="Maker", model="T1", serial_number="1")

    def set_temperature(self, temperature_degc: float) -> None:
        self.chamber.now_s = self.clock.now_s()
        self.chamber.set_temperature(temperature_degc)
        self.chamber.switch(on=True)

    def temperature_degc(self) -> float:
        shown = self.chamber.shown_degc(np.array([self.clock.now_s()]))
        return float(shown[0]) + self.disturbance_c

    def close(self) -> None:
        self.chamber.switch(on=False)


def test_a_temperature_is_held_within_the_tolerance_for_the_soak_time() -> None:
    bench = Bench(ChamberFigures(lag_s=240.0))
    bench.drive.reach(HOT)
    within_s = 240.0 * math.log((60.0 - 23.0) / 0.5)
    took_s = bench.clock.now_s() - 100.0
    assert within_s + 600.0 <= took_s <= within_s + 610.0
    assert bench.temperature_degc() == pytest.approx(60.0, abs=0.05)


def test_a_temperature_that_holds_already_is_soaked_for_exactly_its_time() -> None:
    bench = Bench()
    bench.drive.reach(Soaking(temperature_degc=23.0, soak_s=95.0))
    assert bench.clock.now_s() == pytest.approx(195.0)


def test_the_soak_begins_anew_where_the_temperature_leaves_the_tolerance() -> None:
    bench = Bench()
    bench.clock.subscribe(lambda now_s: setattr(bench, "disturbance_c", 2.0 * (150.0 < now_s < 170.0)))
    bench.drive.reach(Soaking(temperature_degc=23.0, soak_s=100.0))
    assert bench.clock.now_s() == pytest.approx(270.0)


def test_a_chamber_that_stands_still_is_told_long_before_the_time_out() -> None:
    bench = Bench(ChamberFigures(stuck=True))
    with pytest.raises(
        InstrumentError, match=r"60 °C is asked for, found 23.00 °C after 20 min, from 23.00 °C"
    ):
        bench.drive.reach(HOT)


def test_a_chamber_that_creeps_is_waited_for_as_long_as_the_slowest_takes() -> None:
    bench = Bench(ChamberFigures(lag_s=20_000.0))
    with pytest.raises(InstrumentError, match=r"after 11[34] min"):
        bench.drive.reach(HOT)


def test_the_read_back_is_the_mean_over_the_dwell_alone() -> None:
    bench = Bench()
    bench.drive.reach(HOT)
    assert bench.drive.read_back() is None
    for _ in range(60):
        bench.clock.advance(1.0)
        bench.drive.watch()
    assert bench.drive.read_back() == pytest.approx(60.0, abs=0.05)
    bench.drive.reach(Soaking(temperature_degc=30.0, soak_s=600.0))
    bench.drive.watch()
    assert bench.drive.read_back() == pytest.approx(30.0, abs=0.2)


def test_a_temperature_that_drifts_away_in_a_dwell_is_a_fault() -> None:
    bench = Bench()
    bench.drive.reach(HOT)
    bench.drive.watch()
    bench.disturbance_c = 0.9
    bench.clock.advance(10.0)
    bench.drive.watch()
    bench.disturbance_c = 1.2
    bench.clock.advance(10.0)
    with pytest.raises(InstrumentError, match=r"61\.\d+ °C in the middle of a step at 60 °C"):
        bench.drive.watch()


def test_nothing_is_watched_before_a_temperature_was_asked_for() -> None:
    bench = Bench()
    bench.drive.watch()
    assert bench.drive.read_back() is None
