"""What goes wrong on a vibration table and on a level shaft: an error that says what, and never a number."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from numpy.typing import NDArray
from scipy import signal

from gyrotest.errors import RefusedError
from gyrotest.records.result import JudgedResult, Verdict
from gyrotest.records.run import Attempt, Outcome, RunRecord
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.generator_peer import GeneratorPeer
from gyrotest.simulation.table_peer import TablePeer
from gyrotest.specification.lookup import shipped_specs

from .bench_run import SHORT_TURN, BenchRun, bench_run

Rows = NDArray[np.float64]
Spoil = Callable[[Rows], Rows]

RATE_HZ = 5000.0
SINE = """
  sine:
    procedure: sine_vibration
    duration: 2 s
    interval: 200 us
    parameters: {level: 4 deg/s, settle: 1 s, frequencies: [10 Hz, 20 Hz, 40 Hz, 60 Hz]}
    limits: {sensitivity_20Hz: {min: 40 mV/(deg/s), max: 60 mV/(deg/s)}, bandwidth_3db: {min: 30 Hz}}
"""
RANDOM = """
  random:
    procedure: random_vibration
    duration: 10 s
    interval: 200 us
    parameters:
      {level: 4 deg/s, runs: 2, rest: 5 s, settle: 1 s, low: 20 Hz, high: 60 Hz, segment: 1 s, degree: 3,
       frequencies: [20 Hz, 40 Hz]}
    limits: {sensitivity_20Hz: {min: 40 mV/(deg/s), max: 60 mV/(deg/s)}, bandwidth_3db: {min: 30 Hz}}
"""
FOG = """
model: FOG50
output: {kind: voltage, scale_factor: 50 mV/(deg/s), scale_factor_uncertainty: 1 %, full_scale: 60 deg/s}
cases:
"""
VIBRATION = """
name: Vibration
instruments:
  daq:
    driver: sync_stream
    resource: simulated
    settings: {skew_uncertainty: 1 us}
    accuracy: {of_reading: 100 ppm}
  exciter:
    driver: keysight33500b
    resource: simulated
    io_timeout: 0.5 s
    settings: {sensitivity: 20 deg/s/V, max_voltage: 5 V, max_rate: 40 deg/s}
slots:
  a: {source: daq, channel: gyro, encoder: {sine: ua, cosine: ub, lines: 9000}, vibration: exciter}
simulation: {gyro: {bandwidth: 50 Hz, damping: 0.7, angle_random_walk: 0.05 deg/sqrt(h)}}
"""
TAPE = """
name: Tape
instruments:
  tape:
    driver: replay
    resource: samples.npy
    settings:
      columns: {gyro: 1}
      auxiliary: {ua: {column: 2, unit: V}, ub: {column: 3, unit: V}}
      unit: V
      sample_rate: 5 kHz
      skew_uncertainty: 1 us
    accuracy: {of_reading: 100 ppm}
slots:
  a: {source: tape, channel: gyro, encoder: {sine: ua, cosine: ub, lines: 9000}}
"""
SHAFT = (shipped_specs() / "stations" / "simulated.yaml").read_text("utf-8")
SHAFT_TAPE = """
name: Tape
site: {latitude: 48.14 deg}
instruments:
  tape:
    driver: replay
    resource: samples.npy
    settings:
      columns: {gyro: 1}
      auxiliary: {angle: {column: 2, unit: deg}}
      unit: V
      sample_rate: 50 Hz
      skew_uncertainty: 1 us
    accuracy: {of_reading: 100 ppm}
  stage:
    driver: acutrol3000
    resource: TCPIP::127.0.0.1::1::SOCKET
    motion: {max_rate: 20 deg/s, max_acceleration: 50 deg/s/s, max_turns: 1}
    shaft: {azimuth: 30 deg, azimuth_uncertainty: 0.5 deg}
slots:
  a: {source: tape, channel: gyro, encoder: {angle: angle, accuracy: 0.005 deg}, table: stage}
"""
FIRST, SECOND, BOTH = "gravity-1234-r1", "gravity-1234-r2", "gravity-1234-repeats"
BY_SINE, BY_NOISE = "sine-1234-r1", "random-1234-r1"


@dataclass
class Ended:
    """A run that ended: its record, what each item raised, the last attempt at each."""

    record: RunRecord
    said: dict[str, str]
    attempts: dict[str, Attempt]

    def result(self, item: str, name: str) -> JudgedResult:
        (found,) = [one for one in self.attempts[item].results if one.name == name]
        return found


def ended(folder: Path, spec: str, station: str, *, scenario: str = "nominal") -> Ended:
    """Carry a run out; nothing but what gyrotest says itself may come out of it."""
    with bench_run(folder, spec, station, scenario=scenario) as ran:
        record = ran.carry_out()
        attempts = {
            one.name: found[-1]
            for one in ran.run.header.plan
            if (found := ran.run.folder.attempts(one.name))
        }
    return Ended(record=record, said=ran.said, attempts=attempts)


def swapped(text: str, before: str, after: str) -> str:
    assert before in text
    return text.replace(before, after)


def played(folder: Path, rows: Rows, spec: str, station: str) -> Ended:
    """A run of what was recorded, out of a file."""
    np.save(folder / "samples.npy", rows)
    return ended(folder, spec, station)


def taken(folder: Path, spec: str, station: str, columns: tuple[str, ...]) -> Rows:
    """Everything that the simulated bench records of a run, one acquisition after the other."""
    found = ended(folder, spec, station)
    assert found.record.verdict is Verdict.PASS
    (run,) = folder.glob("out/1234/*")
    tables = [
        pq.read_table(run / recording.path, columns=list(columns))
        for attempt in found.attempts.values()
        if (recording := attempt.recording) is not None
    ]
    return np.concatenate(
        [np.column_stack([one.to_numpy() for one in table.columns]) for table in tables]
    )


@pytest.fixture(scope="module")
def vibrated(tmp_path_factory: pytest.TempPathFactory) -> Rows:
    """Output, sine and cosine: 8 s by four sines, 5 s at rest, twice 10 s by noise."""
    columns = ("output", "encoder_sine", "encoder_cosine")
    return taken(tmp_path_factory.mktemp("vibrated"), FOG + SINE + RANDOM, VIBRATION, columns)


@pytest.fixture(scope="module")
def turned(tmp_path_factory: pytest.TempPathFactory) -> Rows:
    """Output and angle: both mountings, 2950 samples each."""
    return taken(tmp_path_factory.mktemp("turned"), SHORT_TURN, SHAFT, ("output", "encoder_angle"))


# The simulated bench's faults

OF_VIBRATION = {
    "daq-overrun": "100 of 50000 samples are missing; find out where they are lost",
    "daq-bad-block": "samples are missing",
    "daq-lost": "samples are missing",
    "encoder-lost": "step 'run 1' at 4 °/s rms: the encoder's signal is lost in",
    "dead-output": "the coherence is below 0.8 over the whole band",
    "overload": "overload at sample",
    "exciter-silent": "the output has gone off by itself",
    "exciter-lost": "connection lost",
}
OF_SHAFT = {
    "encoder-lost": "the encoder's angle jumps by up to",
    "dead-output": "is the unit connected and powered?",
    "overload": "overload at sample",
}


@pytest.mark.parametrize("scenario", OF_VIBRATION)
def test_a_vibration_that_fails_ends_without_a_number(tmp_path: Path, scenario: str) -> None:
    found = ended(tmp_path, FOG + RANDOM, VIBRATION, scenario=scenario)
    assert OF_VIBRATION[scenario] in found.said[BY_NOISE]
    assert found.attempts[BY_NOISE].outcome is Outcome.ERROR
    assert found.attempts[BY_NOISE].results == ()
    assert found.attempts[BY_NOISE].recording is not None
    assert found.record.verdict is Verdict.INCOMPLETE


@pytest.mark.parametrize("scenario", OF_SHAFT)
def test_a_turn_that_fails_ends_without_a_number(tmp_path: Path, scenario: str) -> None:
    found = ended(tmp_path, SHORT_TURN, SHAFT, scenario=scenario)
    for item in (FIRST, SECOND):
        assert OF_SHAFT[scenario] in found.said[item]
        assert found.attempts[item].results == ()
    assert found.record.verdict is Verdict.INCOMPLETE


def test_losses_beyond_the_allowance_end_a_turn(tmp_path: Path) -> None:
    spec = swapped(SHORT_TURN, "interval: 20 ms", "interval: 20 ms\n    allowed_loss: 10 ppm")
    found = ended(tmp_path, spec, SHAFT, scenario="daq-bad-block")
    assert "10 ppm are allowed" in found.said[FIRST]
    assert found.record.verdict is Verdict.INCOMPLETE


# Ctrl-C


@contextmanager
def interrupted(ran: BenchRun, due: Callable[[float], bool]) -> Iterator[None]:
    """Press Ctrl-C once something is so."""
    clock, pressed = ran.bench.clock, list[float]()

    def look(now_s: float) -> None:
        if not pressed and due(now_s):
            pressed.append(now_s)
            raise KeyboardInterrupt

    assert isinstance(clock, VirtualClock)
    clock.subscribe(look)
    with pytest.raises(KeyboardInterrupt):
        yield
    assert pressed


def test_ctrl_c_in_mid_vibration_leaves_the_generator_off_and_keeps_the_record(tmp_path: Path) -> None:
    with bench_run(tmp_path, FOG + RANDOM, VIBRATION) as ran:
        ran.simulated.address("exciter")
        peer = ran.simulated._peers["exciter"]
        assert isinstance(peer, GeneratorPeer)
        wave = peer.generator.outputs[1]
        on_s: list[float] = []

        def some_seconds_into_it(now_s: float) -> bool:
            on_s.extend([now_s] if wave.is_on(now_s) else [])
            return bool(on_s) and now_s > on_s[0] + 4.0

        with interrupted(ran, some_seconds_into_it):
            ran.run.acquire(ran.run.header.plan[0])
        assert not wave.is_on(ran.bench.clock.now_s())
        record = ran.run.update_record()
    assert record.verdict is Verdict.INCOMPLETE
    assert any(tmp_path.glob("out/1234/*/recordings/random-1234-r1*"))


def test_ctrl_c_in_mid_turn_leaves_the_stage_at_rest(tmp_path: Path) -> None:
    with bench_run(tmp_path, SHORT_TURN, SHAFT) as ran:
        ran.simulated.address("stage")
        peer = ran.simulated._peers["stage"]
        assert isinstance(peer, TablePeer)
        stage = peer.table
        with interrupted(
            ran, lambda _: float(stage.angle_deg(np.array([ran.bench.clock.now_s()]))[0]) > 90.0
        ):
            ran.run.acquire(ran.run.header.plan[0])
        ran.bench.clock.sleep_until(ran.bench.clock.now_s() + 2.0)
        assert abs(stage.read_rate_dps()) < 0.01
        record = ran.run.update_record()
    assert record.verdict is Verdict.INCOMPLETE
    assert any(tmp_path.glob("out/1234/*/recordings/gravity-1234-r1*"))


# Recorded vibration, spoiled


def one_signal_stuck(rows: Rows) -> Rows:
    return np.column_stack((rows[:, :2], np.full(len(rows), 0.3)))


def no_encoder(rows: Rows) -> Rows:
    noise = np.random.default_rng(1).normal(0.0, 1e-4, (len(rows), 2))
    return np.column_stack((rows[:, 0], noise))


def clipped_encoder(rows: Rows) -> Rows:
    return np.column_stack((rows[:, 0], np.clip(rows[:, 1:], -0.8, 0.8)))


def clipped_output(rows: Rows) -> Rows:
    return np.column_stack((np.clip(rows[:, 0], -0.2, 0.2), rows[:, 1:]))


def no_number(rows: Rows) -> Rows:
    return np.where(
        (np.arange(len(rows)) % 20000 == 777)[:, np.newaxis] & [False, True, False], np.nan, rows
    )


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (one_signal_stuck, "the encoder's cosine signal is constant: dead, or not connected"),
        (no_encoder, "the encoder's signals do not go round a circle"),
        (clipped_encoder, "it is clipped; lower its gain, or widen the channel's range"),
        (clipped_output, "it is clipped (full scale is 60 deg/s); lower the level"),
        (
            no_number,
            "values of output or encoder, in 10000 samples, are no numbers; look at the channels",
        ),
    ],
)
def test_a_spoiled_vibration_gives_a_clear_error_and_no_number(
    tmp_path: Path, vibrated: Rows, spoil: Spoil, said: str
) -> None:
    found = played(tmp_path, spoil(vibrated), FOG + SINE, TAPE)
    assert said in found.said[BY_SINE]
    assert found.attempts[BY_SINE].results == ()
    assert found.record.verdict is Verdict.INCOMPLETE


def test_an_angle_in_volts_is_none(tmp_path: Path, vibrated: Rows) -> None:
    station = swapped(TAPE, "{sine: ua, cosine: ub, lines: 9000}", "{angle: ua}")
    found = played(tmp_path, vibrated, FOG + SINE, station)
    assert "the encoder's angle comes in 'V', which is none of an angle" in found.said[BY_SINE]


def test_an_output_that_goes_with_nothing_has_neither_sensitivity_nor_bandwidth(
    tmp_path: Path, vibrated: Rows
) -> None:
    noise = np.random.default_rng(1).normal(0.0, 0.1, len(vibrated))
    rows = np.column_stack((noise, vibrated[:, 1:]))
    found = played(tmp_path, rows, FOG + SINE + RANDOM, TAPE)
    for name in ("sensitivity_20Hz", "phase_20Hz", "flatness", "bandwidth_3db", "phase_90_frequency"):
        result = found.result(BY_SINE, name)
        assert result.value is None
        assert "not told from its noise" in result.condition
    assert "the coherence is below 0.8 over the whole band" in found.said[BY_NOISE]
    assert found.record.verdict is Verdict.INCOMPLETE


def test_signals_that_are_exchanged_show_as_a_negative_sensitivity_and_it_is_said(
    tmp_path: Path, vibrated: Rows
) -> None:
    found = played(tmp_path, vibrated[:, [0, 2, 1]], FOG + SINE + RANDOM, TAPE)
    for item in (BY_SINE, BY_NOISE):
        value = found.result(item, "sensitivity_20Hz").value
        assert value is not None
        assert value < -40.0
        assert any("which signal is 'sine'" in one for one in found.attempts[item].remarks)
    assert found.record.verdict is Verdict.FAIL


def test_a_table_that_moves_otherwise_than_asked_for_is_told_by_both_methods(
    tmp_path: Path, vibrated: Rows
) -> None:
    found = played(tmp_path, vibrated, FOG + SINE + RANDOM, swapped(TAPE, "lines: 9000", "lines: 4500"))
    for item in (BY_SINE, BY_NOISE):
        assert any("lines of its grating stated rightly?" in one for one in found.attempts[item].remarks)
    assert found.record.verdict is Verdict.FAIL


def test_a_frequency_among_those_left_out_is_named_and_has_no_value(
    tmp_path: Path, vibrated: Rows
) -> None:
    band = signal.butter(4, [35.0, 40.0], "bandpass", fs=RATE_HZ, output="sos")
    hum = signal.sosfilt(band, np.random.default_rng(3).normal(0.0, 1.0, len(vibrated)))
    rows = np.column_stack((vibrated[:, 0] + 0.2 * hum / hum.std(), vibrated[:, 1:]))
    found = played(tmp_path, rows[round(8.0 * RATE_HZ) :], FOG + RANDOM, TAPE)
    disturbed = found.result(BY_NOISE, "sensitivity_40Hz")
    assert disturbed.value is None
    assert (
        "40 Hz is among the frequencies that are left out for want of coherence" in disturbed.condition
    )
    assert found.result(BY_NOISE, "sensitivity_20Hz").value is not None
    assert any("Left out, their coherence below 0.8" in one for one in found.attempts[BY_NOISE].remarks)


def test_runs_of_the_same_samples_do_not_repeat_without_an_error(tmp_path: Path, vibrated: Rows) -> None:
    station = swapped(TAPE, "      unit: V\n", "      unit: V\n      rewind: true\n")
    found = played(tmp_path, vibrated[-50000:], FOG + RANDOM, station)
    assert "runs 1 and 2 hold the same samples" in found.said[BY_NOISE]


# Recorded turns, spoiled


def stretched(rows: Rows) -> Rows:
    return np.column_stack((rows[:, 0], rows[:, 1] * 1.01 % 360.0))


def unconnected(rows: Rows) -> Rows:
    noise = np.random.default_rng(1).normal(2.5, 3e-5, len(rows))
    return np.column_stack((noise, rows[:, 1]))


@pytest.mark.parametrize(
    ("spoil", "station", "said"),
    [
        (
            stretched,
            SHAFT_TAPE,
            "the encoder turned at 12.12 °/s, the stage was asked for 12 °/s (to within",
        ),
        (unconnected, SHAFT_TAPE, "where the Earth's rate alone makes 10 °/h: is the unit connected"),
        (
            unconnected,
            swapped(SHAFT_TAPE, "of_reading: 100 ppm}", "of_reading: 100 ppm, noise: 0.1 mV}"),
            "signal not distinguishable from the meter: over all angles",
        ),
        (
            np.copy,
            swapped(SHAFT_TAPE, "unit: V\n", "unit: mV\n"),
            "are its unit and its scale factor those of the spec and the station?",
        ),
    ],
    ids=["wrong-angle", "unconnected", "unconnected-known-noise", "millivolts"],
)
def test_a_spoiled_turn_gives_a_clear_error_and_no_number(
    tmp_path: Path, turned: Rows, spoil: Spoil, station: str, said: str
) -> None:
    found = played(tmp_path, spoil(turned), SHORT_TURN, station)
    assert said in found.said[FIRST]
    assert found.attempts[FIRST].results == ()
    assert found.record.verdict is Verdict.INCOMPLETE


def test_a_grating_that_loses_its_signal_in_a_turn_is_told_with_the_step(
    tmp_path: Path, turned: Rows
) -> None:
    phase = np.radians(turned[:, 1]) * 90.0
    noise = np.random.default_rng(2).normal(0.0, 1e-4, (len(turned), 2))
    signals = np.column_stack((np.sin(phase), np.cos(phase))) + noise
    signals[700:703] = 0.0
    station = swapped(SHAFT_TAPE, "{angle: angle,", "{sine: ua, cosine: ub, lines: 90,")
    station = swapped(
        station,
        "{angle: {column: 2, unit: deg}}",
        "{ua: {column: 2, unit: V}, ub: {column: 3, unit: V}}",
    )
    found = played(tmp_path, np.column_stack((turned[:, 0], signals)), SHORT_TURN, station)
    assert "step 'turn 1 forward': the encoder's signal is lost in 3 samples" in found.said[FIRST]
    assert found.attempts[SECOND].outcome is Outcome.PASSED
    assert found.record.verdict is Verdict.INCOMPLETE


def test_one_recording_taken_for_both_mountings_is_refused(tmp_path: Path, turned: Rows) -> None:
    once = turned[: len(turned) // 2]
    found = played(tmp_path, np.concatenate((once, once)), SHORT_TURN, SHAFT_TAPE)
    assert "repeats 1 and 2 hold the same samples" in found.said[BOTH]
    assert found.attempts[FIRST].outcome is Outcome.PASSED
    assert found.record.verdict is Verdict.INCOMPLETE


def test_a_meter_does_not_read_what_turns(tmp_path: Path) -> None:
    station = SHAFT.replace("    source: shaft_daq\n", "    source: meter\n")
    with (
        pytest.raises(RefusedError, match="sampled at the same instants"),
        bench_run(tmp_path, SHORT_TURN, station),
    ):
        raise AssertionError("the door is open")
