"""What vibrates a slot's unit: told at the door where it cannot be, chosen by the bench where it can."""

from collections.abc import Mapping
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from gyrotest.acquisition.progress import Silence
from gyrotest.acquisition.vibrating import VibrationByHand, VibrationRecorded, VibrationTable
from gyrotest.errors import InstrumentError
from gyrotest.ports import Source
from gyrotest.records.plan import Excitation, Plan, Step, Vibrating
from gyrotest.records.recording import Block, Identity, Sampling
from gyrotest.records.spec import Output, OutputKind, Spec
from gyrotest.records.station import Encoder, Instrument, Simulation, Slot, Station
from gyrotest.runner.bench import Bench, SimulationChoice
from gyrotest.runner.door import Order, open_run
from gyrotest.runner.fitness import plan_faults
from gyrotest.runner.flow import UnitRun
from gyrotest.runner.items import planned_case
from gyrotest.runner.taking import Taking
from gyrotest.simulation.generator_peer import GeneratorPeer
from gyrotest.simulation.serve import Standalone
from gyrotest.specification.spec import load_spec
from gyrotest.specification.station import load_station
from gyrotest.units import Quantity
from tests.plugin.project import TINY

GRATING = Encoder(sine="ua", cosine="ub", lines=9000)
SETTINGS = {"sensitivity": "20 deg/s/V", "max_voltage": "5 V", "max_rate": "40 deg/s"}
SPEC = Spec(
    model="M1",
    cases={},
    output=Output(
        kind=OutputKind.VOLTAGE,
        scale_factor=Quantity(50.0, "mV/(deg/s)"),
        bandwidth=Quantity(80.0, "Hz"),
    ),
)


def shaken(rms_dps: float = 10.0) -> Plan:
    random = Vibrating(
        excitation=Excitation.RANDOM, rms_dps=rms_dps, low_hz=5.0, high_hz=100.0, settle_s=1.0
    )
    step = Step(samples=100, name="run 1", stimulus=random)
    return Plan(warm_up_s=0.0, interval_s=1e-3, steps=(step,), auxiliary=("encoder_",))


def station(
    *, source: str = "sync_stream", simulated: bool = False, exciter: str = "keysight33500b",
    settings: Mapping[str, Any] = SETTINGS, **slot: Any,
) -> Station:  # fmt: skip
    address = "simulated" if simulated else "TCPIP::127.0.0.1::1::SOCKET"
    return Station(
        name="bench",
        instruments={
            "daq": Instrument(driver=source, resource=address),
            "exciter": Instrument(driver=exciter, resource=address, settings=settings),
        },
        slots={"a": Slot(source="daq", channel="gyro", **slot)},
        simulation=Simulation() if simulated else None,
    )


def faults(one: Station, plan: Plan | None = None) -> str:
    return "\n".join(plan_faults(plan or shaken(), one, "a", one.slots["a"]))


@pytest.mark.parametrize("simulated", [False, True])
def test_a_slot_with_encoder_and_drive_is_fit(simulated: bool) -> None:
    assert not faults(station(simulated=simulated, encoder=GRATING, vibration="exciter"))


def test_without_an_encoder_it_is_told_which_one_to_give() -> None:
    told = faults(station(vibration="exciter"))
    assert told.startswith(
        "vibrates the unit against the angle of the table that carries it, and slot 'a'"
    )
    assert "give it an 'encoder', e.g. {sine: ua, cosine: ub, lines: 9000}" in told


def test_a_source_that_samples_one_after_the_other_is_refused() -> None:
    told = faults(station(source="keysight34970a", encoder=GRATING, vibration="exciter"))
    assert told.startswith("needs the gyro's output and the encoder sampled at the same instants")
    assert "'daq' (keysight34970a)" in told


def test_a_bench_without_a_drive_is_set_by_hand_but_a_simulated_one_is_refused() -> None:
    assert not faults(station(encoder=GRATING))
    told = faults(station(encoder=GRATING, simulated=True))
    assert (
        "a simulated one, has nothing that drives a vibration table; give the slot a 'vibration'" in told
    )


def test_what_is_played_back_needs_no_drive_even_on_a_simulated_bench() -> None:
    assert not faults(station(source="replay", encoder=GRATING, simulated=True))


def test_an_instrument_that_drives_no_vibration_table_is_refused() -> None:
    told = faults(station(encoder=GRATING, vibration="exciter", exciter="scpi_supply", settings={}))
    assert "the instrument 'exciter' (scpi_supply) does not drive a vibration table" in told


def test_a_level_beyond_the_station_is_told_before_anything_is_opened() -> None:
    told = faults(station(encoder=GRATING, vibration="exciter"), shaken(rms_dps=50.0))
    assert told.startswith("step 'run 1': 50 deg/s rms is asked for, the station allows more than 0 and")


class Something:
    """A source that is never read."""

    def open(self) -> Identity:
        return Identity(manufacturer="Maker", model="M1", serial_number="SIM1")

    def configure(self, interval_s: float) -> Sampling:
        return Sampling(interval_s=interval_s, aperture_s=interval_s, readings=1)

    def start(self, first: int, count: int) -> None:
        raise AssertionError

    def fetch(self) -> Block | None:
        raise AssertionError

    def recover(self) -> int:
        raise AssertionError

    def close(self) -> None:
        pass


class Tape(Something):
    """One that plays back."""

    def cue(self, position_s: float) -> None:
        raise AssertionError


def open_bench(**slot: Any) -> Bench:
    # The source is not asked for here: any that can be simulated will do.
    one = station(source="agilent34401a", simulated=True, encoder=GRATING, **slot)
    return Bench(replace(one, line_frequency=Quantity(50.0, "Hz")), SPEC, SimulationChoice())


def generator_of(bench: Bench) -> GeneratorPeer:
    assert bench._simulated is not None
    peer = bench._simulated._peers["exciter"]
    assert isinstance(peer, GeneratorPeer)
    return peer


def test_the_bench_opens_the_drive_on_first_use_and_leaves_it_off() -> None:
    with closing(open_bench(vibration="exciter")) as bench:
        plan, source = shaken(), Something()
        stimulation = bench.stimuli.of("a", plan, source=source)
        assert isinstance(stimulation.vibration, VibrationTable)
        assert [use.name for use in bench.used("a")] == ["exciter"]
        stimulation.reach(plan.steps[0])
        wave = generator_of(bench).generator.outputs[1]
        assert wave.wave.on
        bench.stimuli.put_down("a")
        assert not wave.wave.on
        again = bench.stimuli.of("a", plan, source=source)
        assert again.vibration is stimulation.vibration
        again.reach(plan.steps[0])
        assert wave.wave.on
    assert not wave.wave.on


def test_what_is_played_back_leaves_the_drive_alone() -> None:
    source: Source = Tape()
    with closing(open_bench(vibration="exciter")) as bench:
        stimulation = bench.stimuli.of("a", shaken(), source=source)
        assert isinstance(stimulation.vibration, VibrationRecorded)
        assert not bench.used("a")


def test_without_a_drive_the_operator_is_asked() -> None:
    with closing(open_bench()) as bench:
        asked: list[str] = []
        by_hand = VibrationByHand(clock=bench.clock, ask=asked.append, told=print, note=print)
        stimulation = bench.stimuli.of("a", shaken(), source=Something(), by_hand=by_hand)
        stimulation.reach(shaken().steps[0])
        assert asked == [
            "set the vibration table to random vibration of 10 °/s rms from 5 to 100 Hz and switch it on"
        ]


def test_a_drive_that_does_not_answer_is_told_before_the_first_sample() -> None:
    one = station(encoder=GRATING, vibration="exciter")
    with (
        closing(Bench(one, SPEC, SimulationChoice())) as bench,
        pytest.raises(InstrumentError, match=r"127\.0\.0\.1::1"),
    ):
        bench.stimuli.of("a", shaken(), source=Something())


BY_HAND = """
name: bench
line_frequency: 50 Hz
instruments:
  meter: {driver: agilent34401a, resource: '%s', settings: {nplc: 0.02}}
slots:
  a: {source: meter}
"""


def test_a_vibration_set_by_hand_is_asked_for_and_told_on_the_certificate(tmp_path: Path) -> None:
    def steps(*stimuli: Vibrating) -> Plan:
        made = (Step(samples=3, name=f"{one.excitation}", stimulus=one) for one in stimuli)
        return Plan(warm_up_s=0.0, interval_s=0.1, steps=tuple(made))

    asked: list[str] = []
    (tmp_path / "spec.yaml").write_text(TINY, encoding="utf-8")
    with Standalone("meter", fast=True) as meter:
        (tmp_path / "station.yaml").write_text(BY_HAND % meter.address, encoding="utf-8")
        order = Order(
            spec=load_spec(tmp_path / "spec.yaml"),
            station=load_station(tmp_path / "station.yaml"),
            serial_numbers=("1234",),
            out=tmp_path / "reports",
        )
        folder, header = open_run(order, "1234", "a")
        with closing(Bench(order.station.station, order.spec.spec, SimulationChoice())) as bench:
            run = UnitRun(
                folder=folder,
                header=header,
                bench=lambda: bench,
                progress=Silence(),
                confirm=asked.append,
            )
            part = run.takes_part(header.plan[0])
            random = Vibrating(excitation=Excitation.RANDOM, rms_dps=8.0, low_hz=5.0, high_hz=100.0)
            plan = steps(Vibrating(excitation=Excitation.NONE), random, random)
            planned = replace(planned_case("rest", order.spec.spec), plan=plan)
            Taking([part], planned, bench=bench, progress=Silence(), confirm=asked.append).acquire()
    assert asked == [
        "rest-1234-r1: switch the vibration table off and wait until it rests",
        "rest-1234-r1: set the vibration table to random vibration of 8 °/s rms from 5 to 100 Hz and switch"
        " it on",
    ]
    assert part.attempt.remarks[:2] == (
        "Vibration set by hand, as the operator confirmed: at rest.",
        "Vibration set by hand, as the operator confirmed: random vibration of 8 °/s rms from 5 to 100 Hz.",
    )
    assert folder.attempts(part.item.name)[-1].remarks == part.attempt.remarks
    assert part.attempt.recording is not None
    assert [one.vibration_dps for one in part.attempt.recording.dwells] == [0.0, 8.0, 8.0]
