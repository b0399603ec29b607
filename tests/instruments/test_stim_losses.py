"""Lost frames are found by counter and host clock together, whatever the jitter and the crystals."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import numpy as np
import pytest

from gyrotest.errors import InstrumentError, InstrumentProtocolError
from gyrotest.instruments.stim.settings import Stim210Settings
from gyrotest.instruments.stim210 import Stim210
from gyrotest.instruments.transport.channel import SerialLine
from gyrotest.records.recording import Block
from gyrotest.units import Quantity
from tests.instruments.meter_turns import StepClock
from tests.instruments.stim_unit import stim210


@dataclass
class Line:
    """Frames that arrive late by a jitter, from a unit with a crystal of its own; some never arrive."""

    clock: StepClock
    frame: Callable[[int], bytes]
    period_s: float = 0.008
    ppm: float = 0.0
    jitter_s: float = 0.0
    lost: set[int] = field(default_factory=set)
    late_s: dict[int, float] = field(default_factory=dict)
    number: int = 0

    def __post_init__(self) -> None:
        self.begun_s = self.clock.now_s()
        self.rng = np.random.default_rng(17)
        self.arrival_s = 0.0
        self.pending: list[tuple[float, bytes]] = []

    def connect(self, resource: str, line: SerialLine, timeout_s: float) -> "Line":
        return self

    def read(self, least: int = 0, timeout_s: float = 0.0) -> bytes:
        now_s = self.clock.now_s()
        self._make(now_s)
        arrived = [frame for at_s, frame in self.pending if at_s <= now_s]
        self.pending = self.pending[len(arrived) :]
        return b"".join(arrived)

    def _make(self, now_s: float) -> None:
        step_s = self.period_s * (1 + self.ppm * 1e-6)
        while (due_s := self.begun_s + self.number * step_s) <= now_s:
            late_s = self.late_s.get(self.number, 0.0) + self.rng.uniform(0.0, self.jitter_s)
            self.arrival_s = max(self.arrival_s, due_s + late_s)
            if self.number not in self.lost:
                self.pending.append((self.arrival_s, self.frame(self.number)))
            self.number += 1

    def write(self, data: bytes) -> None:
        pass

    def discard(self) -> None:
        self.read()

    def close(self) -> None:
        pass


# Frames number themselves modulo this in their first value, so that few need to be made.
WRAP = 4096


@cache
def _counted(number: int) -> bytes:
    return stim210(0xA2, (number, 0, 0), counter=16 * number)


def counted(number: int) -> bytes:
    return _counted(number % WRAP)


@cache
def _by_one(number: int) -> bytes:
    return stim210(0xA2, (number, 0, 0), counter=number)


def by_one(number: int) -> bytes:
    return _by_one(number % WRAP)


@cache
def _bare(number: int) -> bytes:
    return stim210(0x90, (number, 0, 0))


def bare(number: int) -> bytes:
    return _bare(number % WRAP)


def begun(line: Line, frame: str, samples: int, rate: float = 125.0) -> Stim210:
    settings = Stim210Settings(frame=frame, sample_rate=Quantity(rate, "Hz"), ask=False)
    source = Stim210("ASRL/dev/ttyUSB0::INSTR", settings, clock=line.clock, connect=line.connect)
    source.open()
    source.configure(1 / rate)
    source.start(0, samples)
    return source


def run(source: Stim210) -> list[Block]:
    return list(iter(source.fetch, None))


def offsets(blocks: list[Block]) -> np.ndarray:
    """Number of the frame less its position: the same for all samples if all losses were found."""
    numbers = np.concatenate([block.values[:, 0] for block in blocks]) * 2.0**14
    positions = [np.arange(block.first, block.first + len(block.flags)) for block in blocks]
    return np.unique(np.round(numbers - np.concatenate(positions)) % WRAP)


@pytest.mark.parametrize("ppm", [-200.0, -50.0, 0.0, 50.0, 200.0])
@pytest.mark.parametrize("lost", [1, 16, 17, 160])
def test_every_loss_is_found_in_spite_of_jitter_and_drift(ppm: float, lost: int) -> None:
    """Crystals that differ by 200 ppm move the frames by more than the counter's period meanwhile."""
    line = Line(StepClock(), counted, ppm=ppm, jitter_s=0.07)
    source = begun(line, "rate_counter", 100_000)
    at = line.number + 90_000
    line.lost = set(range(at, at + lost))
    blocks = run(source)
    assert len(offsets(blocks[-5:])) == 1
    early, late = offsets(blocks[:5]), offsets(blocks[-5:])
    assert early == late
    assert sum(len(block.flags) for block in blocks) == 100_000 - lost
    assert source.remarks() == (f"STIM210: {lost} sample{'s' * (lost > 1)} lost in 1 gap",)


def test_frames_that_are_held_up_for_long_are_not_taken_for_lost() -> None:
    line = Line(StepClock(), counted, jitter_s=0.05)
    source = begun(line, "rate_counter", 20_000)
    line.late_s = {line.number + 5_000 + k: 0.2 - 0.008 * k for k in range(25)}
    blocks = run(source)
    assert len(offsets(blocks)) == 1
    assert source.remarks() == ("STIM210: no sample lost",)


def test_a_loss_of_a_whole_period_in_the_middle_of_a_block_is_placed_within_that_block() -> None:
    line = Line(StepClock(), counted)
    source = begun(line, "rate_counter", 5_000)
    at = line.number + 1_060
    line.lost = set(range(at, at + 16))
    blocks = run(source)
    assert sum(len(block.flags) for block in blocks) == 5_000 - 16
    assert offsets(blocks[:5]) == offsets(blocks[-5:])
    ends = [block.first + len(block.flags) for block in blocks[:-1]]
    gap = next(end for end, block in zip(ends, blocks[1:], strict=True) if block.first != end)
    assert abs(gap - 1_060) <= 130


def test_at_2000_frames_a_second_the_counter_has_the_same_period() -> None:
    line = Line(
        StepClock(),
        by_one,
        period_s=0.0005,
        ppm=50.0,
        jitter_s=0.07,
    )
    source = begun(line, "rate_counter", 200_000, rate=2000.0)
    at = line.number + 100_000
    line.lost = {at - 40_000, *range(at, at + 256)}
    blocks = run(source)
    assert offsets(blocks[:5]) == offsets(blocks[-5:])
    assert source.remarks() == ("STIM210: 257 samples lost in 2 gaps",)


def test_without_a_counter_the_clock_alone_finds_losses_longer_than_its_jitter() -> None:
    line = Line(StepClock(), bare, ppm=50.0)
    source = begun(line, "rate", 50_000)
    at = line.number + 20_000
    line.lost = set(range(at, at + 25))
    blocks = run(source)
    assert abs(offsets(blocks[:5]) - offsets(blocks[-5:])) <= 1
    assert "in 1 gap" in source.remarks()[0]


def test_without_a_counter_jitter_is_not_taken_for_losses() -> None:
    line = Line(StepClock(), bare, ppm=-50.0, jitter_s=0.07)
    source = begun(line, "rate", 200_000)
    assert len(offsets(run(source))) == 1
    assert source.remarks() == ("STIM210: no sample lost",)


def test_a_counter_that_steps_otherwise_is_another_sample_rate() -> None:
    line = Line(StepClock(), lambda number: stim210(0xA2, counter=8 * number), period_s=0.004)
    with pytest.raises(InstrumentError, match="sends 250 samples a second, the station says 125"):
        begun(line, "rate_counter", 100)


@pytest.mark.parametrize("period_s", [0.004, 0.016])
def test_without_a_counter_the_clock_tells_another_sample_rate(period_s: float) -> None:
    line = Line(StepClock(), bare, period_s=period_s)
    with pytest.raises(
        InstrumentError, match=r"samples a second, the station says 125; correct sample_rate"
    ):
        begun(line, "rate", 100)


def test_a_slower_unit_with_a_counter_is_not_one_that_loses_every_other_frame() -> None:
    line = Line(StepClock(), lambda number: stim210(0xA2, counter=16 * number))
    with pytest.raises(InstrumentError, match="sends 125 samples a second, the station says 250"):
        begun(line, "rate_counter", 100, rate=250.0)


def test_a_counter_out_of_its_grid_means_that_the_unit_was_reset() -> None:
    line = Line(StepClock(), counted)
    source = begun(line, "rate_counter", 5_000)
    line.frame = lambda number: stim210(0xA2, counter=16 * number + 5)
    with pytest.raises(
        InstrumentProtocolError, match="its counter went on by 21, expected multiples of 16"
    ):
        run(source)


@pytest.mark.parametrize("pause_s", [0.05, 0.5, 5.0, 300.0])
def test_after_a_fault_the_grid_goes_on_where_it_would_be(pause_s: float) -> None:
    line = Line(StepClock(), counted, ppm=50.0, jitter_s=0.05)
    source = begun(line, "rate_counter", 60_000)
    before = [source.fetch() for _ in range(20)]
    line.clock.sleep_until(line.clock.now_s() + pause_s)
    first = source.recover()
    source.start(first, 60_000)
    after = run(source)
    assert after[0].first == first
    early = offsets([block for block in before if block is not None])
    assert offsets(after) == early


def test_after_a_reset_the_clock_alone_says_where_the_grid_goes_on() -> None:
    line = Line(StepClock(), counted)
    source = begun(line, "rate_counter", 10_000)
    before = source.fetch()
    assert before is not None
    line.frame = lambda number: stim210(0xA2, (number, 0, 0), counter=16 * number + 5)
    line.clock.sleep_until(line.clock.now_s() + 7.0)
    first = source.recover()
    source.start(first, 10_000)
    assert np.abs(offsets(run(source)) - offsets([before])).max() <= 1
