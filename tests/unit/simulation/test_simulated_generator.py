"""The simulated generator: what it gives follows from when it was told what, and from nothing else."""

import argparse

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import welch

from gyrotest.cli.simulate import add_simulate
from gyrotest.errors import RefusedError, StationError
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.generator_noise import BandNoise
from gyrotest.simulation.generator_peer import GeneratorPeer
from gyrotest.simulation.meter_state import Interface
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.peer import Exciting
from gyrotest.simulation.peers import peer_class
from gyrotest.simulation.serve import KINDS, Standalone
from tests.instruments.exciter_bench import exciter, station

NOISE = "OUTP:LOAD INF;:FUNC NOIS;:VOLT:UNIT VRMS;:VOLT 0.5;:FUNC:NOIS:BAND 100;:OUTP ON"
SINE = "OUTP:LOAD INF;:FUNC SIN;:VOLT:UNIT VRMS;:VOLT 0.5;:FREQ 8;:OUTP ON"
INTERVAL_S = 1e-4


class Bench:
    """A generator that is told things at times."""

    def __init__(self, *, seed: int = 1, scenario: str = "nominal", gain_error: str = "0 %") -> None:
        self.clock = VirtualClock(100.0)
        self.peer: GeneratorPeer = exciter(
            self.clock, seed=seed, scenario=scenario, figures={"gain_error": gain_error}
        )

    def told(self, message: str) -> str:
        parts = self.peer.dialogue(Interface.SOCKET).receive(f"{message}\n".encode())
        return b"".join(part for _, part in parts).decode().strip()

    def given(
        self, first: int, count: int, *, origin_s: float = 100.0, interval_s: float = INTERVAL_S
    ) -> NDArray[np.float64]:
        return self.peer.drive_v(first, count, origin_s=origin_s, interval_s=interval_s)


def test_the_driver_leads_to_a_peer_that_excites_and_says_that_it_is_simulated() -> None:
    bench = Bench()
    assert peer_class(station(), "exciter") is GeneratorPeer
    assert isinstance(bench.peer, Exciting)
    assert bench.told("*IDN?").split(",")[2].startswith("SIM")


def test_a_generator_that_was_told_nothing_gives_nothing() -> None:
    assert not Bench().given(-100, 200).any()


def test_it_gives_nothing_before_it_is_switched_on_and_after_it_is_switched_off() -> None:
    bench = Bench()
    bench.clock.advance(1.0)
    bench.told(SINE)
    bench.clock.advance(1.0)
    bench.told("OUTP OFF")
    bench.clock.advance(1.0)
    volts = bench.given(0, 30_000)
    assert not volts[:10_000].any()
    assert not volts[20_100:].any()
    assert np.sqrt(np.mean(volts[10_100:20_000] ** 2)) == pytest.approx(0.5, rel=0.01)


def test_a_sine_begins_with_phase_0_and_is_exact_at_any_time() -> None:
    bench = Bench()
    bench.told(SINE)
    bench.clock.advance(600.0)
    # The sixth command of the message, a millisecond each.
    on_s = 100.006
    for origin_s, first in ((100.5, 0), (100.5, -1000), (600.0003, 7)):
        times_s = origin_s + INTERVAL_S * np.arange(first, first + 5000)
        wanted = np.sqrt(0.5) * np.sin(2.0 * np.pi * 8.0 * (times_s - on_s))
        given = bench.given(first, 5000, origin_s=origin_s)
        np.testing.assert_allclose(given, wanted, atol=1e-10)


def test_a_sweep_waits_at_its_first_frequency_goes_evenly_in_octaves_and_returns() -> None:
    bench = Bench()
    bench.told(SINE)
    bench.told("FREQ:STAR 8;STOP 64;:SWE:SPAC LOG;TIME 30;:TRIG:SOUR BUS;:FREQ:MODE SWE")
    bench.clock.advance(2.0)
    triggered_s = bench.clock.now_s()
    bench.told("*TRG")
    bench.clock.advance(40.0)
    volts = bench.given(0, 450_000)
    upwards = np.flatnonzero((volts[:-1] < 0.0) & (volts[1:] >= 0.0))
    times_s = 100.0 + INTERVAL_S * (upwards - volts[upwards] / (volts[upwards + 1] - volts[upwards]))
    frequency_hz = 1.0 / np.diff(times_s)
    middle_s = 0.5 * (times_s[1:] + times_s[:-1]) - triggered_s
    wanted_hz = np.where((middle_s > 0.0) & (middle_s < 30.0), 8.0 * 2.0 ** (middle_s / 10.0), 8.0)
    # A period in which the frequency jumps is neither.
    steady = (np.abs(middle_s) > 0.2) & (np.abs(middle_s - 30.0) > 0.2)
    np.testing.assert_allclose(frequency_hz[steady], wanted_hz[steady], rtol=2e-3)


def test_sweeps_that_nobody_triggers_follow_one_another() -> None:
    bench = Bench()
    bench.told(SINE)
    bench.told("FREQ:STAR 8;STOP 64;:SWE:TIME 10;:FREQ:MODE SWE")
    bench.clock.advance(30.0)
    volts = bench.given(0, 300_000)
    for begun in (0, 100_000, 200_000):
        tenth = volts[begun + 500 : begun + 10_500]
        last = volts[begun + 89_000 : begun + 99_000]
        assert np.count_nonzero(np.diff(np.sign(tenth))) < 0.3 * np.count_nonzero(np.diff(np.sign(last)))


@pytest.mark.parametrize("bandwidth_hz", [100.0, 2e3, 20e6])
def test_noise_has_its_rms_and_reaches_to_its_bandwidth(bandwidth_hz: float) -> None:
    noise = BandNoise(1, ("a",), bandwidth_hz=bandwidth_hz, interval_s=INTERVAL_S)
    taken = noise.take(0, 1 << 21)
    below = min(1.0, 0.5 / INTERVAL_S / bandwidth_hz)
    assert np.std(taken) == pytest.approx(np.sqrt(below), rel=0.02)
    found_hz, density = welch(taken, 1.0 / INTERVAL_S, nperseg=20_000)
    in_band = found_hz < 0.6 * min(bandwidth_hz, 4e3)
    assert np.mean(density[in_band]) * bandwidth_hz == pytest.approx(1.0, rel=0.05)
    if bandwidth_hz < 1e3:
        half = np.interp(bandwidth_hz, found_hz, density) / np.mean(density[in_band])
        assert half == pytest.approx(0.5, abs=0.06)
        assert np.mean(density[found_hz > 4.0 * bandwidth_hz]) * bandwidth_hz < 1e-4


@pytest.mark.parametrize("size", [1, 777, 4096, 99_999])
def test_noise_is_the_same_however_much_of_it_is_asked_for_at_a_time(size: int) -> None:
    total = min(160_000, 40 * size)
    whole = BandNoise(3, ("u",), bandwidth_hz=150.0, interval_s=INTERVAL_S).take(-65_000, total)
    parts = BandNoise(3, ("u",), bandwidth_hz=150.0, interval_s=INTERVAL_S)
    taken = [parts.take(-65_000 + at, min(size, total - at)) for at in range(0, total, size)]
    np.testing.assert_array_equal(np.concatenate(taken), whole)


def test_noise_goes_on_from_one_grid_of_samples_to_the_next() -> None:
    bench = Bench()
    bench.told(NOISE)
    bench.clock.advance(30.0)
    bench.given(0, 1, origin_s=101.0)
    early = bench.given(0, 100_000, origin_s=101.0)
    late = bench.given(0, 100_000, origin_s=101.0 + 5.0 + 1e-9)
    np.testing.assert_array_equal(late[:50_000], early[50_000:])
    assert abs(np.corrcoef(early[:50_000], late[50_000:])[0, 1]) < 0.1


def noise_of(bench: Bench, occasion: Occasion | None = None) -> NDArray[np.float64]:
    if occasion is not None:
        bench.peer.begin(occasion)
    bench.told(NOISE)
    bench.clock.advance(3.0)
    return bench.given(0, 10_000, origin_s=bench.clock.now_s() - 2.0)


def test_noise_is_a_records_own_and_the_same_whatever_came_before_it() -> None:
    wanted = Occasion(serial_number="SIM1", case="shaken", repeat=2, duration_s=100.0)
    later = Bench()
    first = noise_of(later)
    second = noise_of(later, wanted)
    np.testing.assert_array_equal(noise_of(Bench(), wanted), second)
    for other in (first, noise_of(Bench(seed=2), wanted)):
        assert abs(np.corrcoef(other, second)[0, 1]) < 0.2


def test_its_level_has_an_error_of_its_own_within_what_the_station_says() -> None:
    levels = []
    for seed in range(1, 20):
        bench = Bench(seed=seed, gain_error="2 %")
        bench.told(SINE)
        bench.clock.advance(2.0)
        levels.append(float(bench.given(0, 10_000, origin_s=100.5).std()) / 0.5 - 1.0)
    assert max(np.abs(levels)) <= 0.02
    assert max(levels) - min(levels) > 0.01


@pytest.mark.parametrize(
    ("message", "error"),
    [
        ("FUNC NOIS;:FREQ:MODE SWE", '-221,"Settings conflict"'),
        ("VOLT 25", '-222,"Data out of range"'),
        ("VOLT 11", '-222,"Data out of range"'),
        ("FUNC TRI", '-224,"Illegal parameter value"'),
        ("*TRG", '-211,"Trigger ignored"'),
        ("SWE:SPAC LOG;TIME 600", '-221,"Settings conflict"'),
        ("OUTP3 ON", '-113,"Undefined header"'),
    ],
)
def test_what_it_cannot_do_stands_in_its_error_queue(message: str, error: str) -> None:
    bench = Bench()
    bench.told(message)
    assert bench.told("SYST:ERR?") == error
    assert bench.told("SYST:ERR?") == '+0,"No error"'


def test_a_level_is_shown_for_the_load_and_in_the_unit_that_it_is_told() -> None:
    bench = Bench()
    assert float(bench.told("VOLT 2;:OUTP:LOAD INF;:VOLT?")) == pytest.approx(4.0)
    assert float(bench.told("VOLT:UNIT VRMS;:VOLT?")) == pytest.approx(np.sqrt(2.0))
    assert bench.told("OUTP:LOAD?") == "+9.9000000000000000E+37"
    assert bench.told("SOUR2:FUNC NOIS;:SOUR2:FUNC?;:FUNC?") == "NOIS;SIN"
    assert bench.told("*RST;:OUTP?;:VOLT:UNIT?;:OUTP:LOAD?") == "0;VPP;+5.000000000000000E+01"


def test_an_output_that_goes_off_by_itself_in_the_record_says_so_and_gives_nothing() -> None:
    bench = Bench(scenario="exciter-silent")
    bench.told(SINE)
    assert bench.told("OUTP?") == "1"
    bench.clock.advance(60.0)
    assert bench.told("OUTP?") == "0"
    volts = bench.given(0, 60_000, interval_s=1e-3)
    assert volts[39_900:40_000].any()
    assert not volts[40_000:].any()


def test_a_complaint_about_its_figures_names_the_key() -> None:
    with pytest.raises(StationError, match=r"simulation.instruments.exciter.gain: unknown key"):
        GeneratorPeer.check(station(figures={"gain": "1 %"}), "exciter")


def test_it_is_served_alone_for_any_program() -> None:
    with Standalone("generator") as served:
        assert served.address.startswith("TCPIP::127.0.0.1::")
    with pytest.raises(RefusedError, match="leave --fast out"):
        Standalone("generator", fast=True)


@pytest.mark.parametrize("instrument", list(KINDS))
def test_every_instrument_that_can_be_served_alone_is_a_choice_on_the_command_line(
    instrument: str,
) -> None:
    parser = argparse.ArgumentParser()
    add_simulate(parser)
    assert parser.parse_args([instrument]).instrument == instrument
