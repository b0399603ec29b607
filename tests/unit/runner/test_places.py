"""Which slots the units of a spec take."""

import pytest

from gyrotest.records.plan import Excitation, Plan, Rotating, Soaking, Step, Stimulus, Vibrating
from gyrotest.records.station import Instrument, Motion, Shaft, Slot, Station
from gyrotest.runner.places import moved_together
from gyrotest.units import Quantity

MOTION = Motion(
    max_rate=Quantity(20.0, "deg/s"), max_acceleration=Quantity(50.0, "deg/s/s"), max_turns=1.0
)


def _station(**slots: Slot) -> Station:
    return Station(
        name="bench",
        instruments={
            "meter": Instrument(driver="agilent34401a", resource="GPIB0::22::INSTR"),
            "exciter": Instrument(driver="keysight33500b", resource="GPIB0::10::INSTR"),
            "table": Instrument(driver="acutrol3000", resource="GPIB0::1::INSTR", motion=MOTION),
            "stage": Instrument(
                driver="acutrol3000", resource="GPIB0::2::INSTR", motion=MOTION, shaft=Shaft()
            ),
        },
        slots=slots,
    )


PLAIN = Slot(source="meter", table="table")
SHAKEN = Slot(source="meter", vibration="exciter")
ON_SHAFT = Slot(source="meter", table="stage")
HEATED = Slot(source="meter", table="table", chamber="oven")
ROTATING = Rotating(rate_dps=6.0, run_up_deg=5.0)
SHAKING = Vibrating(excitation=Excitation.RANDOM, rms_dps=1.0, low_hz=5.0, high_hz=100.0)


@pytest.mark.parametrize(
    ("vibrates", "rotates", "taken"),
    [(False, False, ("a",)), (True, False, ("b",)), (False, True, ("c", "d"))],
)
def test_a_spec_goes_where_what_it_needs_is(
    vibrates: bool, rotates: bool, taken: tuple[str, ...]
) -> None:
    station = _station(a=PLAIN, b=SHAKEN, c=ON_SHAFT, d=ON_SHAFT)
    assert station.slots_for("M1", vibrates=vibrates, rotates=rotates) == taken


def test_where_no_slot_has_what_is_needed_all_are_named() -> None:
    assert _station(a=PLAIN, b=PLAIN).slots_for("M1", vibrates=True) == ("a", "b")


def test_a_bench_of_one_kind_takes_every_spec() -> None:
    assert _station(c=ON_SHAFT).slots_for("M1") == ("c",)


def test_a_slot_that_names_the_model_comes_before_what_is_needed() -> None:
    named = Slot(source="meter", models=("M1",))
    assert _station(a=named, b=SHAKEN).slots_for("M1", vibrates=True) == ("a",)


def test_only_units_that_the_same_instruments_move_are_acquired_together() -> None:
    turning, shaking, still = (_plan(one) for one in (ROTATING, SHAKING, None))
    assert moved_together(turning, ON_SHAFT, ON_SHAFT)
    assert not moved_together(turning, ON_SHAFT, PLAIN)
    assert not moved_together(_plan(Soaking(temperature_degc=40.0, soak_s=1.0)), HEATED, PLAIN)
    assert not moved_together(shaking, SHAKEN, PLAIN)
    assert moved_together(shaking, ON_SHAFT, PLAIN)
    assert moved_together(still, ON_SHAFT, SHAKEN)


def _plan(stimulus: Stimulus | None) -> Plan:
    return Plan(warm_up_s=0.0, interval_s=1.0, steps=(Step(samples=10, stimulus=stimulus),))
