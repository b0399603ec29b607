"""An acquisition: what it bridges, what it gives up on, what it leaves behind."""

import subprocess
import sys
from collections.abc import Callable
from contextlib import nullcontext
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from gyrotest.acquisition.acquire import MOST_RECOVERIES, Acquisition
from gyrotest.acquisition.progress import Silence
from gyrotest.acquisition.tracks import Track
from gyrotest.errors import (
    AcquisitionError,
    InstrumentError,
    InstrumentTimeoutError,
    OverloadError,
    RecordingError,
)
from gyrotest.records.bench import DaqChannel, Device
from gyrotest.records.plan import Plan, Step
from gyrotest.records.recording import (
    Block,
    Identity,
    RecordingHeader,
    SampleFlag,
    Sampling,
)
from gyrotest.simulation.clock import VirtualClock

SAMPLES = 100
IDENTITY = Identity(manufacturer="Maker", model="M1", serial_number="1", firmware="0")
SAMPLING = Sampling(interval_s=1.0, aperture_s=0.2, readings=1, noise=1e-6, range=10.0)


class Bench:
    """A source of one sample a second whose faults are written down beforehand.

    `faults` by position: that sample is preceded by an error. `starts` and `recoveries` give the
    errors of the next calls of that name, None where the call succeeds.
    """

    def __init__(
        self,
        clock: VirtualClock,
        *,
        faults: dict[int, InstrumentError] | None = None,
        starts: tuple[InstrumentError | None, ...] = (),
        recoveries: tuple[InstrumentError | None, ...] = (),
        value: Callable[[int], float] = float,
        end: int = SAMPLES,
    ) -> None:
        self._clock = clock
        self._faults = dict(faults or {})
        self._starts, self._recoveries = list(starts), list(recoveries)
        self._value = value
        self._end = end
        self._position = 0

    def open(self) -> Identity:
        return IDENTITY

    def configure(self, interval_s: float) -> Sampling:
        return SAMPLING

    def start(self, first: int, count: int) -> None:
        self._raise_next(self._starts)
        self._position = first

    def fetch(self) -> Block | None:
        if self._position >= self._end:
            return None
        fault = self._faults.pop(self._position, None)
        if fault is not None:
            self._clock.advance(1.0)  # what the time-out took
            raise fault
        position = self._position
        self._clock.sleep_until(float(position))
        self._position += 1
        value = self._value(position)
        flag = SampleFlag.OVERLOAD if abs(value) > 1e37 else SampleFlag.GOOD
        return Block(
            first=position,
            time_s=np.array([float(position)]),
            values=np.array([[value]]),
            flags=np.array([flag], dtype=np.uint8),
        )

    def recover(self) -> int:
        self._raise_next(self._recoveries)
        return int(np.ceil(self._clock.now_s()))

    def close(self) -> None:
        """Nothing to leave safe."""

    @staticmethod
    def _raise_next(planned: list[InstrumentError | None]) -> None:
        fault = planned.pop(0) if planned else None
        if fault is not None:
            raise fault


def _acquisition(folder: Path, clock: VirtualClock, bench: Bench) -> Acquisition:
    header = RecordingHeader(
        run_id="run",
        item="rest-1234-r1",
        attempt=1,
        serial_number="1234",
        model="MEMS50",
        spec_sha256="0" * 64,
        started_utc=datetime(2026, 1, 1, tzinfo=UTC),
        planned_samples=SAMPLES,
        sampling=SAMPLING,
        source=IDENTITY,
    )
    return Acquisition(
        source=bench,
        clock=clock,
        progress=Silence(),
        tracks=(Track(run_folder=folder, header=header),),
        plan=Plan(warm_up_s=0.0, interval_s=1.0, steps=(Step(samples=SAMPLES),)),
    )


class Observing(Bench):
    """A source that notes what is there when it starts and what is loaded until it ends."""

    def __init__(self, clock: VirtualClock, folder: Path) -> None:
        super().__init__(clock)
        self.at_start: set[str] = set()
        self.loaded_later: set[str] = set()
        self.segments: list[str] = []
        self._folder = folder

    def start(self, first: int, count: int) -> None:
        super().start(first, count)
        self.segments = [path.name for path in self._folder.rglob("*.arrows")]
        self.at_start = set(sys.modules)

    def fetch(self) -> Block | None:
        block = super().fetch()
        self.loaded_later = set(sys.modules) - self.at_start
        return block


@pytest.fixture
def clock() -> VirtualClock:
    return VirtualClock()


def _lost(text: str = "M1: no reply") -> InstrumentError:
    return InstrumentTimeoutError(text)


def test_a_fault_is_bridged_by_a_gap(tmp_path: Path, clock: VirtualClock) -> None:
    acquisition = _acquisition(tmp_path, clock, Bench(clock, faults={40: _lost()}))
    recording = acquisition.run()[0]
    (gap,) = recording.gaps
    assert (gap.after, gap.missing, gap.reason) == (39, 1, "M1: no reply")
    assert recording.complete
    assert recording.samples == SAMPLES - 1


def test_the_pauses_between_tries_grow(tmp_path: Path, clock: VirtualClock) -> None:
    bench = Bench(clock, faults={40: _lost()}, recoveries=(_lost("M1: second"), _lost("M1: third")))
    acquisition = _acquisition(tmp_path, clock, bench)
    recording = acquisition.run()[0]
    (gap,) = recording.gaps
    assert gap.reason == "M1: third"
    assert gap.missing == 39 + 1 + (1 + 5 + 30) - 40
    tries = [event.partition("UTC: ")[2] for event in acquisition.events]
    assert tries[0] == "M1: no reply; try 1 of 3 in 1 s"
    assert tries[1] == "M1: second; try 2 of 3 in 5 s"
    assert tries[2] == "M1: third; try 3 of 3 in 30 s"
    assert tries[3].startswith("recovered; ")


def test_a_start_that_fails_after_a_recovery_is_another_try(tmp_path: Path, clock: VirtualClock) -> None:
    bench = Bench(clock, faults={40: _lost()}, starts=(None, _lost("M1: INIT is refused")))
    recording = _acquisition(tmp_path, clock, bench).run()[0]
    (gap,) = recording.gaps
    assert gap.reason == "M1: INIT is refused"
    assert recording.complete
    assert recording.samples + gap.missing == SAMPLES


def test_a_source_that_stays_away_ends_the_record_and_keeps_it(
    tmp_path: Path, clock: VirtualClock
) -> None:
    bench = Bench(clock, faults={40: _lost()}, recoveries=(_lost(),) * 3)
    acquisition = _acquisition(tmp_path, clock, bench)
    with pytest.raises(AcquisitionError, match="M1: no reply; given up after 3 tries"):
        acquisition.run()
    assert acquisition.recordings[0] is not None
    assert not acquisition.recordings[0].complete
    assert acquisition.recordings[0].samples == 40


def test_a_source_that_fails_again_and_again_is_given_up(tmp_path: Path, clock: VirtualClock) -> None:
    faults = {position: _lost() for position in range(0, SAMPLES, 5)}
    acquisition = _acquisition(tmp_path, clock, Bench(clock, faults=faults))
    with pytest.raises(AcquisitionError, match=f"given up after {MOST_RECOVERIES} recoveries"):
        acquisition.run()


def test_a_source_that_comes_back_too_late_ends_the_record(tmp_path: Path, clock: VirtualClock) -> None:
    bench = Bench(clock, faults={90: _lost()}, recoveries=(_lost(), _lost()))
    with pytest.raises(AcquisitionError, match="came back after the record's end"):
        _acquisition(tmp_path, clock, bench).run()[0]


def test_an_overload_is_not_tried_again(tmp_path: Path, clock: VirtualClock) -> None:
    bench = Bench(clock, value=lambda position: 9.9e37 if position == 7 else float(position))
    acquisition = _acquisition(tmp_path, clock, bench)
    with pytest.raises(OverloadError, match=r"M1: overload at sample 7 \(range 10 V\)"):
        acquisition.run()
    assert acquisition.recordings[0] is not None
    assert acquisition.recordings[0].samples == 8


def test_a_source_that_ends_early_is_an_error(tmp_path: Path, clock: VirtualClock) -> None:
    with pytest.raises(AcquisitionError, match=r"ended after 50 of 100 samples \(50 of 100 s\)"):
        _acquisition(tmp_path, clock, Bench(clock, end=50)).run()


def test_a_stuck_reading_is_found_after_a_minute(tmp_path: Path, clock: VirtualClock) -> None:
    bench = Bench(clock, value=lambda position: float(min(position, 20)))
    with pytest.raises(InstrumentError, match="stuck at 20 V for 60 samples"):
        _acquisition(tmp_path, clock, bench).run()[0]


def test_whatever_ends_it_the_record_is_closed(tmp_path: Path, clock: VirtualClock) -> None:
    def interrupted(position: int) -> float:
        if position == 30:
            raise KeyboardInterrupt
        return float(position)

    acquisition = _acquisition(tmp_path, clock, Bench(clock, value=interrupted))
    with pytest.raises(KeyboardInterrupt):
        acquisition.run()
    assert acquisition.recordings[0] is not None
    assert acquisition.recordings[0].samples == 30
    assert not acquisition.recordings[0].complete


class Counting(Silence):
    def __init__(self) -> None:
        self.begun = self.ended = 0

    def begin(self, header: RecordingHeader) -> None:
        self.begun += 1

    def end(self) -> None:
        self.ended += 1


def test_nothing_is_left_on_the_screen_by_a_record_that_cannot_begin(
    tmp_path: Path, clock: VirtualClock
) -> None:
    progress = Counting()
    for refused in (False, True):
        acquisition = _acquisition(tmp_path, clock, Bench(clock))
        acquisition.progress = progress
        with pytest.raises(RecordingError) if refused else nullcontext():
            acquisition.run()
    assert progress.begun == progress.ended == 1


_FIRST_OF_A_PROCESS = """
import sys
from pathlib import Path
from tests.unit.acquisition.test_acquire import Observing, _acquisition
from gyrotest.simulation.clock import VirtualClock
clock, folder = VirtualClock(), Path(sys.argv[1])
bench = Observing(clock, folder)
_acquisition(folder, clock, bench).run()
print(bench.segments, sorted(bench.loaded_later))
"""


def test_no_sample_waits_for_something_to_be_loaded(tmp_path: Path) -> None:
    """In a process of its own: in this one, other tests have loaded it all."""
    ended = subprocess.run(
        [sys.executable, "-c", _FIRST_OF_A_PROCESS, str(tmp_path)],
        cwd=Path(__file__).parents[3],
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    assert ended.stdout.strip() == "['0000.arrows'] []"


def _ending_early(
    clock: VirtualClock, end: int, folder: Path, allowed_loss: float | None
) -> Acquisition:
    acquisition = _acquisition(folder, clock, Bench(clock, end=end))
    acquisition.allowed_loss = allowed_loss
    return acquisition


def test_samples_lost_at_the_very_end_count_against_the_allowance(
    tmp_path: Path, clock: VirtualClock
) -> None:
    acquisition = _ending_early(clock, SAMPLES - 1, tmp_path, 0.01)
    (recording,) = acquisition.run()
    assert recording.complete
    assert recording.samples == SAMPLES - 1
    assert "the last 1 samples of the step were lost" in acquisition.events[0]


class Gyro(Bench):
    """A source that is the unit itself."""

    def device(self) -> Device:
        return Device()


class Daq(Bench):
    """A synchronous source."""

    def channels(self) -> tuple[DaqChannel, ...]:
        return (DaqChannel(name="gyro", unit="V"),)

    def select(self, outputs: tuple[str, ...], auxiliary: tuple[str, ...]) -> None:
        """There is one only."""


@pytest.mark.parametrize("kind", [Gyro, Daq])
def test_what_counts_its_samples_itself_may_lose_the_last_ones_like_any(
    tmp_path: Path, clock: VirtualClock, kind: type[Bench]
) -> None:
    acquisition = _acquisition(tmp_path, clock, kind(clock, end=SAMPLES - 1))
    (recording,) = acquisition.run()
    assert recording.complete
    assert recording.samples == SAMPLES - 1


def test_more_samples_lost_than_allowed_end_the_acquisition(tmp_path: Path, clock: VirtualClock) -> None:
    acquisition = _ending_early(clock, SAMPLES - 2, tmp_path, 0.01)
    with pytest.raises(AcquisitionError, match=r"2 samples are lost, of 100 10000 ppm are allowed"):
        acquisition.run()
    assert acquisition.recordings[0].samples == SAMPLES - 2


class Told(Silence):
    """Progress that keeps its notes."""

    def __init__(self) -> None:
        self.notes: list[str] = []

    def note(self, text: str) -> None:
        self.notes.append(text)


def test_each_step_of_several_is_told_as_it_begins(tmp_path: Path, clock: VirtualClock) -> None:
    steps = (Step(samples=50, name="first"), Step(samples=50, name="second"))
    acquisition = _acquisition(tmp_path, clock, Bench(clock, end=50))
    acquisition.plan = Plan(warm_up_s=0.0, interval_s=1.0, steps=steps)
    acquisition.progress = told = Told()
    (recording,) = acquisition.run()
    assert told.notes == ["step 'first', 1 of 2", "step 'second', 2 of 2"]
    assert [(one.name, one.first, one.samples) for one in recording.dwells] == [
        ("first", 0, 50),
        ("second", 50, 50),
    ]
    assert recording.gaps == ()
