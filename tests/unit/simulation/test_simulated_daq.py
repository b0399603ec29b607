"""The simulated acquisition system: its protocol over a real socket, what it samples and when, what strikes it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.errors import StationError
from gyrotest.records.spec import OutputKind, Supply
from gyrotest.records.station import Accuracy, Slot
from gyrotest.simulation.bench import SimulatedBench
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.dynamics import frequency_response
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.serve import Standalone
from gyrotest.simulation.vibration import SteadyDrive
from gyrotest.units import Quantity
from tests.unit.simulation.daq_bench import (
    CLIPPED,
    GRATING,
    LAST,
    OVERRUN,
    SHAKEN,
    SPEC,
    THETA,
    Caller,
    Heard,
    bench,
    station,
)

RATE_HZ = 10_000.0
SECOND_ORDER = {"damping": 0.7, "bandwidth_error": "5 %", "delay": "0.5 ms"}
WITH_GRATING = {"a": replace(SHAKEN["a"], encoder=GRATING)}
AT_REST = {"a": Slot(source="daq", channel="gyro", encoder=GRATING)}


FIVE_VOLTS = Supply(
    voltage=Quantity(5.0, "V"), current_limit=Quantity(0.1, "A"), over_voltage=Quantity(5.5, "V")
)


def phasor(values: NDArray[np.float64], frequency_hz: float, rate_hz: float) -> complex:
    """Of a sine in values, by least squares."""
    turn = 2.0 * math.pi * frequency_hz / rate_hz * np.arange(values.size)
    columns = np.column_stack([np.cos(turn), np.sin(turn), np.ones(turn.size)])
    cosine, sine, _ = np.linalg.lstsq(columns, values, rcond=None)[0]
    return complex(cosine, -sine)


def measured_and_true(
    frequency_hz: float, rate_hz: float = RATE_HZ, serial_number: str = "1", **given: object
) -> tuple[complex, complex]:
    """The gyro's response by the angle that is read, and as it truly is with the system's own errors."""
    made = station(**given)  # type: ignore[arg-type]
    with bench(made, drive=SteadyDrive(peak_v=0.4, frequency_hz=frequency_hz)) as spoken:
        spoken.caller.configure("gyro", "theta", rate_hz=rate_hz)
        spoken.begin(serial_number)
        values = spoken.values(spoken.caller.record(int(2 * rate_hz), rate_hz=rate_hz))
        skew_s = spoken.caller.ask("CHANNELS")[1]["skew_s"]
        truth = spoken.truth()
    gyro, angle = (phasor(column, frequency_hz, rate_hz) for column in values.T)
    late = np.exp(-2j * math.pi * frequency_hz * (skew_s + truth["theta.skew_error_s"]))
    expected = frequency_response(np.array([frequency_hz]), truth)[0] * late
    return gyro / (angle * 2j * math.pi * frequency_hz), expected * (1.0 + truth["gyro.gain_error"])


@pytest.mark.parametrize("frequency_hz", [5.0, 20.0, 50.0, 100.0])
@pytest.mark.parametrize(
    ("gyro", "daq", "rate_hz"),
    [
        (SECOND_ORDER, {}, RATE_HZ),
        (SECOND_ORDER, {"skew": "28 us"}, RATE_HZ),
        (SECOND_ORDER | {"damping": 0.4, "bandwidth": "120 Hz"}, {}, 1_000.0),
        ({}, {}, RATE_HZ),
    ],
)
def test_the_simulated_response_is_the_analytic_one(
    gyro: dict[str, object], daq: dict[str, object], rate_hz: float, frequency_hz: float
) -> None:
    found, expected = measured_and_true(
        frequency_hz, rate_hz, gyro=gyro, daq=daq, settings={"skew_uncertainty": "1 us"}
    )
    assert abs(found / expected) == pytest.approx(1.0, abs=1e-4)
    assert np.degrees(np.angle(found / expected)) == pytest.approx(0.0, abs=0.01)


def test_a_grating_tells_the_angle_that_an_encoder_tells() -> None:
    both = {
        "a": Slot(source="daq", channel="gyro", vibration="exciter", encoder=THETA),
        "b": Slot(source="daq", channel="other", vibration="exciter", encoder=GRATING),
    }
    with bench(station(slots=both), drive=SteadyDrive(peak_v=0.4, frequency_hz=30.0)) as spoken:
        spoken.caller.configure("gyro", "theta", "other", "ua", "ub")
        spoken.begin()
        values = spoken.values(spoken.caller.record(10_000))
    decoded = np.degrees(np.unwrap(np.arctan2(values[:, 3], values[:, 4]))) / 9000
    theta = values[:, 1]
    assert np.ptp(theta) > 0.05
    assert decoded - decoded.mean() == pytest.approx(theta - theta.mean(), abs=2e-6)


def test_a_reversed_encoder_counts_against_the_motion() -> None:
    turned = {"a": replace(SHAKEN["a"], encoder=replace(THETA, reversed=True))}
    forwards, expected = measured_and_true(20.0)
    backwards, _ = measured_and_true(20.0, slots=turned)
    assert forwards == pytest.approx(expected, rel=1e-4)
    assert backwards == pytest.approx(-forwards, rel=1e-6)


def test_a_low_pass_in_front_acts_on_the_voltages() -> None:
    found, expected = measured_and_true(100.0, daq={"filter": "200 Hz"})
    # A Butterworth filter of second order at half its cut-off; digital, at a fiftieth of the rate.
    assert abs(found / expected) == pytest.approx(1.0 / math.sqrt(1.0 + 0.5**4), rel=2e-3)


class EvenStage:
    """A stage that turns at 12 °/s."""

    def begin(self, occasion: Occasion) -> None: ...

    def truth(self) -> dict[str, float]:
        return {}

    def angle_deg(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        return 12.0 * np.asarray(times_s)


def test_two_units_on_a_stage_feel_its_rate_and_share_its_angle() -> None:
    accuracy = Quantity(0.01, "deg")
    encoder = replace(THETA, accuracy=accuracy)
    slots = {
        name: Slot(source="daq", channel=f"gyro_{name}", table="stage", encoder=encoder) for name in "ab"
    }
    with bench(station(slots=slots, gyro={"scale_factor_error": "0 %"})) as spoken:
        spoken.served._peers["stage"] = EvenStage()
        spoken.caller.configure("gyro_a", "gyro_b", "theta", rate_hz=100.0)
        spoken.begin()
        begun_s = spoken.served.clock.now_s()
        scales = [1.0 / 2**23 * 10.0, 1.0 / 2**23 * 10.0, 1e-6]
        heard = spoken.caller.record(200, rate_hz=100.0)
        truth = spoken.truth()
    values = heard.rows * scales
    for column, name in enumerate(("gyro_a", "gyro_b")):
        gain = 1.0 + truth[f"{name}.gain_error"]
        assert values[:, column] == pytest.approx(0.6 * gain, abs=2e-6)
    true_deg = 12.0 * (begun_s + np.arange(200) / 100.0)
    error = truth["theta.encoder_error_deg"] * np.sin(
        np.radians(true_deg + truth["theta.encoder_error_phase_deg"])
    )
    assert 0.0 < truth["theta.encoder_error_deg"] <= 0.01
    assert values[:, 2] == pytest.approx(true_deg + error, abs=1e-6)


# The protocol


def test_it_says_who_it_is_and_what_it_has() -> None:
    with bench(station(slots=WITH_GRATING, daq={"skew": "5 us"})) as spoken:
        assert spoken.caller.ask("IDENTIFY")["serial_number"].startswith("SIM")
        found = spoken.caller.ask("CHANNELS")
        assert [one["name"] for one in found] == ["gyro", "ua", "ub"]
        assert [one["skew_s"] for one in found] == pytest.approx([0.0, 5e-6, 10e-6])
        assert {one["unit"] for one in found} == {"V"}
        said = spoken.caller.configure("ub", "gyro", rate_hz=3000.0)
    assert said["rate_hz"] == pytest.approx(3000.0, rel=1e-3)
    assert (said["filter_hz"], said["full_scale"]) == (None, 10.0)


@pytest.mark.parametrize(
    ("command", "told"),
    [
        ("HELLO", "no command"),
        ("CONFIGURE", "no JSON object"),
        ('CONFIGURE {"channels": ["gyro", "uc"], "rate_hz": 100}', "not among gyro, ua, ub"),
        ('CONFIGURE {"channels": ["gyro"], "rate_hz": 1e6}', "'rate_hz' 1000000.0 is not"),
        ('CONFIGURE {"channels": ["gyro"], "rate_hz": 10, "trigger": "soon"}', "neither"),
        ('START {"samples": 5}', "not configured"),
    ],
)
def test_what_cannot_be_done_is_answered_in_words(command: str, told: str) -> None:
    with bench(station(slots=WITH_GRATING)) as spoken:
        assert told in spoken.caller.ask(command)["error"]
        assert spoken.caller.ask("STOP") == {"stopped": True}


def test_blocks_follow_one_another_to_the_last() -> None:
    with bench(station(slots=WITH_GRATING)) as spoken:
        spoken.caller.configure("gyro", "ua", "ub")
        spoken.begin()
        heard = spoken.caller.record(12_345)
        again = spoken.caller.record(100)
    assert (heard.position == np.arange(12_345)).all()
    assert heard.sequences == list(range(len(heard.sequences)))
    assert heard.flags == [0] * (len(heard.flags) - 1) + [LAST]
    assert again.sequences == [0]


def test_all_samples_are_there_when_the_last_of_them_has_ended() -> None:
    with bench(station(slots=WITH_GRATING, daq={"skew": "20 us"})) as spoken:
        spoken.caller.configure("gyro", "ua", "ub")
        spoken.begin()
        spoken.caller.ask('START {"samples": 0}')
        begun_s = spoken.served.clock.now_s()
        for end_s in (0.05, 0.1, 0.7):
            spoken.served.clock.sleep_until(begun_s + end_s)
        spoken.caller.say("STOP")
        heard = spoken.caller.rest(Heard())
        assert spoken.caller.ask("IDENTIFY") == {"stopped": True}
    assert len(heard.rows) == 7000
    assert len(heard.numbers[-1]) == 0


def test_while_it_samples_it_hears_nothing_but_stop() -> None:
    with bench(station(slots=WITH_GRATING)) as spoken:
        spoken.caller.configure("gyro")
        spoken.begin()
        spoken.caller.ask('START {"samples": 100}')
        assert "send STOP first" in spoken.caller.ask("CHANNELS")["error"]


def test_a_new_caller_ends_what_the_one_before_had_started() -> None:
    with bench(station(slots=WITH_GRATING)) as spoken:
        spoken.caller.configure("gyro")
        spoken.begin()
        spoken.caller.ask('START {"samples": 0}')
        other = Caller(spoken.served.address("daq"), spoken.served.clock)
        assert other.ask("IDENTIFY")["firmware"] == "1"
        assert "not configured" in other.ask('START {"samples": 1}')["error"]
        other.close()


def test_an_external_trigger_comes_a_while_after_the_start() -> None:
    with bench(station(slots=WITH_GRATING)) as spoken:
        spoken.caller.configure("gyro", trigger="external")
        spoken.begin()
        spoken.caller.ask('START {"samples": 0}')
        spoken.served.clock.sleep_until(spoken.served.clock.now_s() + 1.0)
        spoken.caller.say("STOP")
        heard = spoken.caller.rest(Heard())
    assert 5000 <= len(heard.rows) <= 9500
    assert heard.indices[0] == 0


def test_what_nobody_takes_is_lost_in_the_end_and_said_to_be() -> None:
    with bench(station(slots=AT_REST)) as spoken:
        spoken.caller.configure("gyro", "ua", "ub", rate_hz=100e3)
        spoken.begin()
        spoken.caller.ask('START {"samples": 0}')
        clock = spoken.served.clock
        clock.sleep_until(clock.now_s() + 8.0)
        heard = Heard()
        for _ in range(10):
            spoken.caller.block(heard)
        spoken.caller.say("STOP")
        spoken.caller.rest(heard)
    lost = 800_000 - len(heard.rows)
    assert 200_000 < lost < 500_000
    assert [flag & OVERRUN for flag in heard.flags].count(OVERRUN) == 1
    assert heard.flags[-1] & LAST
    assert heard.indices[-1] + len(heard.numbers[-1]) == 800_000


def test_how_the_time_passes_changes_no_sample() -> None:
    found = []
    for step_s in (0.013, 0.4):
        made = station(slots=WITH_GRATING, gyro={"angle_random_walk": "0.5 deg/sqrt(h)"})
        with bench(made, drive=SteadyDrive(peak_v=0.4, frequency_hz=30.0)) as spoken:
            spoken.caller.configure("gyro", "ua", "ub")
            spoken.begin()
            found.append(spoken.caller.record(6000, step_s=step_s).rows)
    assert np.abs(found[0] - found[1]).max() <= 1


# Its own errors


def test_gains_and_skews_are_drawn_within_what_the_station_states() -> None:
    accuracy = Accuracy(of_reading=Quantity(200.0, "ppm"), noise=Quantity(10.0, "uV"))
    made = station(slots=WITH_GRATING, settings={"skew_uncertainty": "3 us"}, accuracy=accuracy)
    gains, skews = [], []
    with bench(made) as spoken:
        for number in range(60):
            spoken.begin(str(number))
            truth = spoken.truth()
            gains.append(truth["gyro.gain_error"])
            skews += [truth["ua.skew_error_s"], truth["ub.skew_error_s"]]
            assert truth["gyro.skew_error_s"] == 0.0
    assert 1.6e-4 < np.abs(gains).max() <= 2e-4
    assert 2.5e-6 < np.abs(skews).max() <= 3e-6


def test_a_unit_has_its_own_bandwidth_and_the_model_its_damping_and_delay() -> None:
    bandwidths = []
    with bench(station(gyro=SECOND_ORDER)) as spoken:
        for number in range(60):
            spoken.begin(str(number))
            bandwidths.append(spoken.truth()["bandwidth_hz"])
        truth = spoken.truth()
    assert (truth["damping"], truth["delay_s"]) == (0.7, 5e-4)
    assert 3.0 < np.abs(np.array(bandwidths) - 80.0).max() <= 4.0


def test_the_converter_adds_its_noise_and_the_grating_its_own() -> None:
    daq = {"noise": "100 uV", "grating_noise": "1 mV"}
    with bench(station(slots=AT_REST, daq=daq)) as spoken:
        spoken.caller.configure("gyro", "ua", "ub")
        spoken.begin()
        noise = spoken.values(spoken.caller.record(20_000)).std(axis=0)
    assert noise == pytest.approx([1e-4, 1.005e-3, 1.005e-3], rel=0.03)


@pytest.mark.parametrize(
    ("gyro", "daq", "number"),
    [
        ({"input_rate": "90 deg/s"}, {"range": "4 V"}, CLIPPED),
        ({"input_rate": "-90 deg/s"}, {"range": "4 V"}, -CLIPPED),
        ({"input_rate": "90 deg/s", "saturation": "60 deg/s"}, {"range": "4 V"}, round(0.75 * 2**23)),
    ],
)
def test_what_leaves_the_range_is_clipped_and_a_gyro_that_saturates_stays_within(
    gyro: dict[str, object], daq: dict[str, object], number: int
) -> None:
    made = station(slots=AT_REST, gyro={"scale_factor_error": "0 %"} | gyro, daq=daq)
    with bench(made) as spoken:
        spoken.caller.configure("gyro")
        spoken.begin()
        rows = spoken.caller.record(100).rows
    assert rows == pytest.approx(number, rel=1.5e-4)
    if abs(number) == CLIPPED:
        assert (rows == number).all()


def test_a_channel_of_a_slot_that_is_empty_shows_noise_and_nothing_else() -> None:
    slots = AT_REST | {"b": Slot(source="daq", channel="other", models=("ANOTHER",))}
    with SimulatedBench(station(slots=slots, daq={"noise": "50 uV"}), SPEC) as served:
        served.insert(slot="a", serial_number="1")
        caller = Caller(served.address("daq"), served.clock)
        caller.configure("other")
        rows = caller.record(5000).rows * (10.0 / 2**23)
        caller.close()
    assert rows.std() == pytest.approx(50e-6, rel=0.1)
    assert abs(rows.mean()) < 5e-6


def test_a_temperature_is_read_beside() -> None:
    slots = {"a": replace(AT_REST["a"], auxiliary={"temperature": "t"})}
    with bench(station(slots=slots)) as spoken:
        spoken.caller.configure("t")
        spoken.begin()
        assert spoken.caller.record(10).rows * (10.0 / 2**23) == pytest.approx(0.23, rel=2e-4)


class Switch:
    """A supply whose output is switched by hand."""

    on_since_s: float | None = None

    def begin(self, occasion: Occasion) -> None: ...

    def truth(self) -> dict[str, float]:
        return {}

    def output(self, number: int) -> "Switch":
        return self


def test_a_unit_without_power_gives_nothing() -> None:
    supply = Switch()
    slots = {"a": replace(AT_REST["a"], supply="supply")}
    made = station(slots=slots, gyro={"input_rate": "10 deg/s", "scale_factor_error": "0 %"})
    spec = replace(SPEC, supply=FIVE_VOLTS)
    with bench(made, spec=spec, supply=supply) as spoken:
        spoken.caller.configure("gyro", "ua", "ub")
        spoken.begin()
        off = spoken.values(spoken.caller.record(100))
        supply.on_since_s = spoken.served.clock.now_s()
        on = spoken.values(spoken.caller.record(100))
    assert np.abs(off[:, 0]).max() < 1e-9
    assert on[:, 0] == pytest.approx(0.5, rel=2e-4)
    assert np.hypot(off[:, 1], off[:, 2]) == pytest.approx(1.0, rel=2e-4)


# What strikes it


def struck(scenario: str, slots: dict[str, Slot] | None = None) -> tuple[Heard, NDArray[np.float64]]:
    made = station(slots=slots or AT_REST, scenario=scenario, gyro={"input_rate": "10 deg/s"})
    with bench(made) as spoken:
        spoken.caller.configure(*(one["name"] for one in spoken.caller.ask("CHANNELS")))
        spoken.begin(duration_s=2.0)
        heard = spoken.caller.record(20_000)
        return heard, spoken.values(heard)


def test_an_overrun_is_flagged_and_the_index_goes_on_with_the_time() -> None:
    heard, _ = struck("daq-overrun")
    lost = np.setdiff1d(np.arange(20_000), heard.position)
    assert lost.tolist() == list(range(8000, 8200))
    flagged = [index for index, flag in zip(heard.indices, heard.flags, strict=True) if flag & OVERRUN]
    assert flagged == [8200]


def test_one_block_is_damaged() -> None:
    assert struck("daq-bad-block")[0].damaged == 1
    assert struck("nominal")[0].damaged == 0


def test_a_connection_that_breaks_can_be_made_again() -> None:
    with bench(station(slots=AT_REST, scenario="daq-lost")) as spoken:
        spoken.caller.configure("gyro")
        spoken.begin(duration_s=1.0)
        spoken.caller.ask('START {"samples": 0}')
        spoken.served.clock.sleep_until(spoken.served.clock.now_s() + 0.5)
        with pytest.raises(ConnectionResetError):
            spoken.caller.rest(Heard())
        again = Caller(spoken.served.address("daq"), spoken.served.clock)
        again.configure("gyro")
        assert len(again.record(1000).rows) == 1000
        again.close()


@pytest.mark.parametrize("slots", [AT_REST, {"a": replace(AT_REST["a"], encoder=THETA)}])
def test_an_encoder_gives_nothing_for_a_while(slots: dict[str, Slot]) -> None:
    _, values = struck("encoder-lost", slots)
    dark = (np.abs(values[:, 1:]) < 1e-9).all(axis=1)
    if len(values.T) == 3:
        assert np.flatnonzero(dark).tolist() == list(range(8000, 9000))
    assert dark[8000:9000].all()
    assert values[:, 0].std() < 1e-4


def test_an_output_that_leaves_the_range_is_clipped_for_a_while() -> None:
    heard, _ = struck("overload")
    assert np.flatnonzero(heard.rows[:, 0] == CLIPPED).tolist() == list(range(8000, 8400))


def test_a_dead_output_stays_where_it_is() -> None:
    _, values = struck("dead-output")
    assert np.abs(values[:, 0]).max() < 1e-9


# Complaints


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"daq": {"grating_ofset": "1 %"}}, "did you mean 'grating_offset'"),
        ({"daq": {"range": "0 V"}}, "more than zero"),
        ({"settings": {"skew_uncertainty": "1 V"}}, "daq.settings.skew_uncertainty"),
        ({"settings": {"skew": {"ua": "1 V"}}}, "daq.settings.skew.ua"),
    ],
)
def test_a_complaint_names_the_key(given: dict[str, dict[str, object]], told: str) -> None:
    with pytest.raises(StationError) as refused:
        SimulatedBench(station(**given), SPEC)  # type: ignore[arg-type]
    assert told in str(refused.value)


def test_a_gyro_of_another_kind_is_refused() -> None:
    spec = replace(SPEC, output=replace(SPEC.output, kind=OutputKind.RATE, scale_factor=None))
    with pytest.raises(StationError, match="voltage output"):
        SimulatedBench(station(), spec)


def test_a_serial_line_is_refused() -> None:
    made = station()
    instruments = dict(made.instruments)
    instruments["daq"] = replace(instruments["daq"], resource="simulated:pty")
    with (
        SimulatedBench(replace(made, instruments=instruments), SPEC) as served,
        pytest.raises(StationError, match="no serial line"),
    ):
        served.address("daq")


def test_alone_it_samples_a_table_that_swings_as_fast_as_it_is_read() -> None:
    with Standalone("daq", fast=True) as served:
        caller = Caller(served.address, VirtualClock())
        caller.configure("gyro", "ua", "ub")
        caller.ask('START {"samples": 300000}')
        heard = caller.rest(Heard())
        caller.close()
    assert (heard.position == np.arange(300_000)).all()
    volts = heard.rows[:20_000, 0] * 10.0 / 2**23
    assert abs(phasor(volts, 20.0, RATE_HZ)) == pytest.approx(0.05 * 10.0, rel=0.03)
