"""A vibration table brought to what a plan asks for: driven, set by hand, or part of what is played back."""

from collections.abc import Callable
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from gyrotest.acquisition.acquire import Acquisition
from gyrotest.acquisition.progress import Silence
from gyrotest.acquisition.stimulation import Stimulation
from gyrotest.acquisition.tracks import Track
from gyrotest.acquisition.vibrating import (
    VibrationByHand,
    VibrationRecorded,
    VibrationTable,
    vibration_faults,
    vibration_words,
)
from gyrotest.errors import AcquisitionError, InstrumentError
from gyrotest.records.plan import Excitation, Plan, Step, Vibrating
from gyrotest.records.recording import Block, Identity, RecordingHeader, Sampling
from gyrotest.simulation.clock import VirtualClock
from tests.instruments.exciter_bench import Served, served, settings

IDENTITY = Identity(manufacturer="Maker", model="M1", serial_number="1", firmware="0")
REST = Vibrating(excitation=Excitation.NONE, settle_s=2.0)
RANDOM = Vibrating(excitation=Excitation.RANDOM, rms_dps=10.0, low_hz=5.0, high_hz=100.0, settle_s=3.0)
SINE = Vibrating(excitation=Excitation.SINE, rms_dps=5.0, low_hz=20.0, high_hz=20.0, settle_s=1.0)
SWEEP = Vibrating(excitation=Excitation.SWEEP, rms_dps=5.0, low_hz=5.0, high_hz=100.0, settle_s=1.0)


class Drive:
    """A drive that writes down what it is asked for; `broken` is what `check` then tells."""

    def __init__(self, clock: VirtualClock) -> None:
        self._clock = clock
        self.asked: list[str] = []
        self.broken: InstrumentError | None = None

    def _note(self, text: str) -> None:
        self.asked.append(f"{self._clock.now_s():g}: {text}")

    def open(self) -> Identity:
        self._note("open")
        return IDENTITY

    def random(self, *, rms_dps: float, low_hz: float, high_hz: float) -> None:
        self._note(f"random {rms_dps:g} {low_hz:g} {high_hz:g}")

    def sine(self, *, rms_dps: float, frequency_hz: float) -> None:
        self._note(f"sine {rms_dps:g} {frequency_hz:g}")

    def sweep(self, *, rms_dps: float, low_hz: float, high_hz: float, duration_s: float) -> None:
        self._note(f"sweep {rms_dps:g} {low_hz:g} {high_hz:g} {duration_s:g}")

    def check(self) -> None:
        self._note("check")
        if self.broken is not None:
            raise self.broken

    def stop(self) -> None:
        self._note("stop")

    def close(self) -> None:
        self._note("close")


class Source:
    """A sample a second, whatever it is that is sampled."""

    def __init__(
        self, clock: VirtualClock, fault: Callable[[int], None] = lambda position: None
    ) -> None:
        self._clock = clock
        self._fault = fault
        self._next = self._count = self.taken = 0

    def open(self) -> Identity:
        return IDENTITY

    def configure(self, interval_s: float) -> Sampling:
        return Sampling(interval_s=interval_s, aperture_s=interval_s, readings=1)

    def start(self, first: int, count: int) -> None:
        self._next, self._count = first, count

    def fetch(self) -> Block | None:
        if self._next >= self._count:
            return None
        self._clock.advance(1.0)
        self._fault(self.taken)
        self.taken += 1
        self._next += 1
        return Block(
            first=self._next - 1,
            time_s=np.array([float(self._next)]),
            values=np.array([[float(self.taken)]]),
            flags=np.zeros(1, dtype=np.uint8),
        )

    def recover(self) -> int:
        return self._next

    def close(self) -> None:
        pass


def plan_of(*stimuli: Vibrating, samples: int = 5) -> Plan:
    steps = tuple(
        Step(samples=samples, name=f"step {number}", stimulus=one)
        for number, one in enumerate(stimuli, start=1)
    )
    return Plan(warm_up_s=0.0, interval_s=1.0, steps=steps)


def acquisition(folder: Path, source: Source, stimulation: Stimulation, plan: Plan) -> Acquisition:
    clock = source._clock
    header = RecordingHeader(
        run_id="run", item="shaken", attempt=1, serial_number="SIM1", model="M1", spec_sha256="0",
        started_utc=datetime(2026, 1, 1, tzinfo=UTC), planned_samples=plan.samples,
        sampling=source.configure(1.0), source=IDENTITY, since_power_on_s=0.0,
    )  # fmt: skip
    track = Track(run_folder=folder, header=header, columns=(0,))
    return Acquisition(
        source=source, clock=clock, progress=Silence(), tracks=(track,), plan=plan,
        stimulation=stimulation,
    )  # fmt: skip


def test_it_vibrates_and_settles_before_the_samples_and_is_checked_about_once_a_second() -> None:
    clock = VirtualClock(100.0)
    drive = Drive(clock)
    table = VibrationTable(drive, clock=clock)
    table.reach(RANDOM, sampled_s=10.0)
    for _ in range(12):
        clock.advance(0.25)
        table.watch()
    table.rest()
    clock.advance(5.0)
    table.watch()
    assert drive.asked == [
        "100: random 10 5 100",
        "103: check",
        *[f"{at}: check" for at in (104, 105, 106)],
        "106: stop",
    ]


def test_a_step_at_rest_stops_it_and_lets_it_settle() -> None:
    clock = VirtualClock(100.0)
    drive = Drive(clock)
    VibrationTable(drive, clock=clock).reach(REST, sampled_s=10.0)
    assert drive.asked == ["100: stop"]
    assert clock.now_s() == 102.0


def test_a_sweep_settles_at_its_first_frequency_and_lasts_as_long_as_it_is_sampled() -> None:
    clock = VirtualClock(100.0)
    drive = Drive(clock)
    stimulation = Stimulation(vibration=VibrationTable(drive, clock=clock), interval_s=0.5)
    stimulation.reach(Step(samples=240, name="sweep", stimulus=SWEEP))
    assert drive.asked == ["100: sine 5 5", "101: check", "101: sweep 5 5 100 120"]


def test_after_a_fault_it_is_put_down_and_opened_anew_when_it_is_taken_up() -> None:
    clock = VirtualClock(100.0)
    drive = Drive(clock)
    table = VibrationTable(drive, clock=clock)
    table.take_up()
    table.reach(SINE, sampled_s=1.0)
    table.put_down()
    table.watch()
    table.take_up()
    table.take_up()
    assert drive.asked == ["100: sine 5 20", "101: check", "101: close", "101: open"]


def test_each_dwell_tells_what_was_asked_for(tmp_path: Path) -> None:
    clock = VirtualClock(100.0)
    table = VibrationTable(Drive(clock), clock=clock)
    plan = plan_of(REST, RANDOM, SINE, SWEEP)
    run = acquisition(tmp_path, Source(clock), Stimulation(vibration=table, interval_s=1.0), plan)
    (recording,) = run.run()
    assert [one.vibration_dps for one in recording.dwells] == [0.0, 10.0, 5.0, 5.0]
    assert [one.frequency_hz for one in recording.dwells] == [None, None, 20.0, None]
    assert [one.band_hz for one in recording.dwells] == [None, (5.0, 100.0), None, (5.0, 100.0)]
    assert [one.settling_s for one in recording.dwells] == pytest.approx([2.0, 3.0, 1.0, 1.0])
    assert [one.first for one in recording.dwells] == [0, 5, 10, 15]


def test_a_drive_that_breaks_off_ends_the_acquisition_with_the_step_and_is_stopped(
    tmp_path: Path,
) -> None:
    clock = VirtualClock(100.0)
    drive = Drive(clock)

    def breaks(position: int) -> None:
        if position == 7:
            drive.broken = InstrumentError("GPIB0::10::INSTR: the output has gone off by itself")

    stimulation = Stimulation(vibration=VibrationTable(drive, clock=clock), interval_s=1.0)
    run = acquisition(tmp_path, Source(clock, breaks), stimulation, plan_of(REST, RANDOM))
    with pytest.raises(
        InstrumentError,
        match=r"gone off by itself \(step 'step 2', random vibration of 10 °/s rms from 5 to 100 Hz\)",
    ):
        run.run()
    assert drive.asked[-1].endswith("stop")
    assert run.recordings[0].samples == 8
    assert not run.recordings[0].complete


@pytest.mark.parametrize(
    "fault", [InstrumentError("the source is gone"), KeyboardInterrupt()], ids=["fault", "Ctrl-C"]
)
def test_the_generators_output_is_off_after_whatever_ended_the_acquisition(
    tmp_path: Path, fault: BaseException
) -> None:
    def strikes(position: int) -> None:
        if position == 3:
            assert bench.wave.on
            raise fault

    bench: Served
    with served() as bench, closing(bench.driver()) as drive:
        drive.open()
        stimulation = Stimulation(vibration=VibrationTable(drive, clock=bench.clock), interval_s=1.0)
        run = acquisition(tmp_path, Source(bench.clock, strikes), stimulation, plan_of(RANDOM))
        with pytest.raises((AcquisitionError, KeyboardInterrupt)):
            run.run()
        assert not bench.wave.on


def test_a_slot_without_a_vibration_table_is_told_by_the_step() -> None:
    with pytest.raises(
        AcquisitionError, match="step 'shake' vibrates the unit, and the slot has nothing"
    ):
        Stimulation().reach(Step(samples=1, name="shake", stimulus=RANDOM))


class Operator:
    """Somebody who does what is asked for in ten seconds, or refuses the request of that number."""

    def __init__(self, refuses: int | None = None) -> None:
        self.clock = VirtualClock(100.0)
        self.requests: list[str] = []
        self.told: list[str] = []
        self.notes: list[str] = []
        self._refuses = refuses

    def does(self, text: str) -> None:
        self.requests.append(text)
        if len(self.requests) == self._refuses:
            raise AcquisitionError(f"{text}: stopped by the operator")
        self.clock.advance(10.0)

    def table(self) -> VibrationByHand:
        return VibrationByHand(
            clock=self.clock, ask=self.does, told=self.told.append, note=self.notes.append
        )


def test_a_table_set_by_hand_is_asked_for_once_for_each_vibration(tmp_path: Path) -> None:
    operator = Operator()
    stimulation = Stimulation(vibration=operator.table(), interval_s=1.0)
    plan = plan_of(REST, RANDOM, RANDOM, RANDOM, SWEEP)
    run = acquisition(tmp_path, Source(operator.clock), stimulation, plan)
    (recording,) = run.run()
    assert operator.requests == [
        "switch the vibration table off and wait until it rests",
        "set the vibration table to random vibration of 10 °/s rms from 5 to 100 Hz and switch it on",
        "set the vibration table to a sine of 5 °/s rms swept from 5 to 100 Hz in 5 s, logarithmically, and"
        " begin the sweep",
    ]
    assert operator.told[1] == (
        "Vibration set by hand, as the operator confirmed: random vibration of 10 °/s rms from 5 to 100 Hz."
    )
    assert operator.notes == ["the vibration table may be switched off"]
    assert [one.settling_s for one in recording.dwells] == [12.0, 13.0, 3.0, 3.0, 10.0]


def test_an_operator_who_stops_ends_the_acquisition_and_nothing_is_told_of_it(tmp_path: Path) -> None:
    operator = Operator(refuses=2)
    stimulation = Stimulation(vibration=operator.table(), interval_s=1.0)
    run = acquisition(tmp_path, Source(operator.clock), stimulation, plan_of(REST, RANDOM))
    with pytest.raises(AcquisitionError, match="stopped by the operator"):
        run.run()
    assert operator.told == ["Vibration set by hand, as the operator confirmed: at rest."]
    assert operator.notes == []


def test_what_is_played_back_moves_nothing_and_takes_no_time(tmp_path: Path) -> None:
    clock = VirtualClock(100.0)
    stimulation = Stimulation(vibration=VibrationRecorded(), interval_s=1.0)
    run = acquisition(tmp_path, Source(clock), stimulation, plan_of(REST, RANDOM))
    (recording,) = run.run()
    assert [one.settling_s for one in recording.dwells] == [0.0, 0.0]
    assert clock.now_s() == 110.0


def test_what_a_drive_cannot_do_of_a_plan_is_told_step_by_step() -> None:
    loud = Vibrating(excitation=Excitation.RANDOM, rms_dps=35.0, low_hz=5.0, high_hz=100.0)
    faults = vibration_faults(plan_of(REST, RANDOM, loud, SWEEP, samples=600), settings())
    assert [fault.split(":")[0] for fault in faults] == ["step 'step 3'", "step 'step 4'"]
    assert "the station allows 5 V (settings.max_voltage)" in faults[0]
    assert "a sweep of 600 s is asked for" in faults[1]


@pytest.mark.parametrize(
    ("vibrating", "words"),
    [(REST, "at rest"), (SINE, "a sine of 5 °/s rms at 20 Hz")],
)
def test_a_vibration_is_told_in_words(vibrating: Vibrating, words: str) -> None:
    assert vibration_words(vibrating) == words
