"""Sine vibration: what is found on a table with a grating, what is uncertain, what is refused."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.sine_vibration import SineVibration, SineVibrationParameters
from gyrotest.records.plan import Context, Excitation, Reduction, Vibrating
from gyrotest.records.recording import Auxiliary, SampleStream, Sampling
from gyrotest.records.result import Result
from gyrotest.records.spec import Case, Gaps, Limit
from gyrotest.units import Quantity
from tests.unit.procedures.vibration_bench import (
    ENCODER,
    RATE_HZ,
    Gyro,
    Signals,
    Sine,
    daq_sampling,
    recorded,
    streamed,
    vibration_context,
    vibration_output,
)

FREQUENCIES_HZ = (10.0, 40.0, 80.0, 100.0, 120.0)
LEVEL_DPS = 8.0
GYRO = Gyro(noise_v=2e-4)


def parameters(**changes: Any) -> SineVibrationParameters:
    plain = SineVibrationParameters(
        level=Quantity(LEVEL_DPS, "deg/s"),
        frequencies=tuple(Quantity(one, "Hz") for one in FREQUENCIES_HZ),
        reference_frequency=Quantity(10.0, "Hz"),
    )
    return dataclasses.replace(plain, **changes)


def case(**changes: Any) -> Case:
    plain = Case(procedure="sine_vibration", duration=Quantity(2.0, "s"), interval=Quantity(0.1, "ms"))
    return dataclasses.replace(plain, **changes)


def context(told: SineVibrationParameters | None = None, **changes: Any) -> Context:
    given, asked = changes.pop("case", case()), told or parameters()
    return vibration_context(given, asked, SineVibration().plan(given, asked), **changes)


def motions(
    frequencies_hz: tuple[float, ...] = FREQUENCIES_HZ, rms_dps: float = LEVEL_DPS
) -> list[Sine]:
    return [Sine(frequency_hz=one, rms_dps=rms_dps) for one in frequencies_hz]


def recording(**changes: Any) -> NDArray[np.float64]:
    return recorded(motions(), samples=20_000, **({"gyro": GYRO} | changes))


def sampling(**changes: Any) -> Sampling:
    return daq_sampling(filter_hz=2500.0, **changes)


def stream(values: NDArray[np.float64], **changes: Any) -> SampleStream:
    return streamed(values, **({"sampling": sampling()} | changes))


def reduced(source: SampleStream, where: Context | None = None) -> Reduction:
    return SineVibration().reduce_stream(source, where or context())


def by_name(reduction: Reduction) -> dict[str, Result]:
    return {one.name: one for one in reduction.results}


@pytest.fixture(scope="module")
def found() -> Reduction:
    return reduced(stream(recording()))


def test_sensitivity_and_phase_are_the_gyros_at_every_frequency(found: Reduction) -> None:
    results = by_name(found)
    for frequency_hz in FREQUENCIES_HZ:
        truth = GYRO.response(frequency_hz)
        sensitivity = results[f"sensitivity_{frequency_hz:g}Hz"]
        phase = results[f"phase_{frequency_hz:g}Hz"]
        assert sensitivity.unit == "mV/(deg/s)"
        assert sensitivity.value == pytest.approx(1000.0 * abs(truth), rel=3e-4)
        assert phase.value == pytest.approx(np.degrees(np.angle(truth)), abs=0.02)
        for one, true in ((sensitivity, 1000.0 * abs(truth)), (phase, np.degrees(np.angle(truth)))):
            assert one.value is not None
            assert one.expanded_uncertainty is not None
            assert abs(one.value - true) < one.expanded_uncertainty


def test_what_is_measured_is_what_was_declared(found: Reduction) -> None:
    declared = SineVibration().measurands(case(), parameters(), vibration_output())
    assert [one.name for one in declared] == [one.name for one in found.results]
    assert [one.label for one in declared] == [one.label for one in found.results]


def test_skew_left_uncorrected_would_be_a_false_phase() -> None:
    none = sampling(offsets_s=(0.0, 0.0, 0.0))
    results = by_name(reduced(stream(recording(), sampling=none)))
    truth_deg = float(np.degrees(np.angle(GYRO.response(100.0))))
    value = results["phase_100Hz"].value
    assert value is not None
    # the encoder's signals are taken 25 and 50 µs after the output: it seems to lag by 37.5 µs
    assert value - truth_deg == pytest.approx(-360.0 * 100.0 * 37.5e-6, abs=0.1)


def test_a_known_delay_gives_its_phase_at_every_frequency() -> None:
    pure = Gyro(natural_hz=1e9, delay_s=1.234e-3)
    results = by_name(reduced(stream(recording(gyro=pure, signals=Signals(noise_v=0.0)))))
    for frequency_hz in FREQUENCIES_HZ:
        value = results[f"phase_{frequency_hz:g}Hz"].value
        assert value == pytest.approx(-360.0 * frequency_hz * 1.234e-3, abs=2e-3)


def test_the_bandwidth_and_the_quarter_turn_lie_between_the_frequencies(found: Reduction) -> None:
    results = by_name(found)
    fine = np.linspace(10.0, 120.0, 100_001)
    response = np.array([GYRO.response(one) for one in fine[::100]])
    level = abs(GYRO.response(10.0)) / math.sqrt(2.0)
    assert (np.abs(response) > level).all()
    bandwidth = results["bandwidth_3db"]
    assert bandwidth.value == pytest.approx(120.0)
    assert bandwidth.at_least
    assert "not reached" in bandwidth.condition
    quarter = results["phase_90_frequency"]
    truth = float(np.interp(90.0, -np.unwrap(np.angle(response)) * 180.0 / np.pi, fine[::100]))
    assert quarter.value == pytest.approx(truth, rel=3e-3)
    assert "between 100 and 120 Hz" in quarter.condition
    assert {"interpolation between the frequencies", "skew of the channels"} <= {
        one.source for one in quarter.budget
    }


def test_a_slower_gyros_bandwidth_is_found_with_what_interpolation_adds() -> None:
    slow = Gyro(natural_hz=70.0)
    results = by_name(reduced(stream(recording(gyro=slow))))
    fine = np.linspace(40.0, 90.0, 50_001)
    gains = np.abs([slow.response(one) for one in fine])
    truth = float(fine[np.argmax(gains < abs(slow.response(10.0)) / math.sqrt(2.0))])
    bandwidth = results["bandwidth_3db"]
    assert bandwidth.value is not None
    assert bandwidth.expanded_uncertainty is not None
    assert abs(bandwidth.value - truth) < max(bandwidth.expanded_uncertainty, 0.02 * truth)
    assert not bandwidth.at_least


def test_flatness_is_highest_less_lowest_over_the_reference(found: Reduction) -> None:
    gains = [abs(GYRO.response(one)) for one in FREQUENCIES_HZ]
    flatness = by_name(found)["flatness"]
    assert flatness.value == pytest.approx(100.0 * (max(gains) - min(gains)) / gains[0], abs=0.05)
    to_40 = by_name(reduced(stream(recording()), context(parameters(flat_to=Quantity(40.0, "Hz")))))
    expected = 100.0 * abs(gains[1] - gains[0]) / gains[0]
    assert to_40["flatness"].value == pytest.approx(expected, abs=0.05)


def test_the_budget_names_noise_source_encoder_and_skew(found: Reduction) -> None:
    results = by_name(found)
    sensitivity, phase = results["sensitivity_80Hz"], results["phase_80Hz"]
    sources = [one.source for one in sensitivity.budget]
    assert sources[0] == "noise beside the frequency"
    assert any(one.startswith("source, 0.01 % of reading") for one in sources)
    assert any(one.startswith("encoder, 5.0 arcsec") or "arcsec" in one for one in sources)
    (skew,) = [one for one in phase.budget if one.source == "skew of the channels"]
    assert skew.standard_uncertainty == pytest.approx(360.0 * 80.0 * 1e-6 / math.sqrt(3.0))
    assert not phase.not_included


def test_what_is_not_stated_is_named_as_not_included() -> None:
    unknown = sampling(skew_uncertainty_s=None)
    bare = dataclasses.replace(ENCODER, accuracy=None)
    results = by_name(
        reduced(stream(recording(), sampling=unknown), context(accuracy=None, encoder=bare))
    )
    assert "skew of the channels" in results["phase_40Hz"].not_included
    assert results["sensitivity_40Hz"].not_included == (
        "accuracy of the source",
        "accuracy of the encoder",
    )


def test_noise_is_told_honestly_over_seeds() -> None:
    one = (40.0,)
    told = parameters(frequencies=(Quantity(40.0, "Hz"),), reference_frequency=None)
    where = context(told, case=case(duration=Quantity(0.5, "s")))
    noisy, truth, z = Gyro(noise_v=0.05), 1000.0 * abs(Gyro().response(40.0)), []
    for seed in range(40):
        values = recorded(motions(one), samples=5000, gyro=noisy, seed=seed)
        result = by_name(reduced(stream(values), where))["sensitivity_40Hz"]
        assert result.value is not None
        z.append((result.value - truth) / result.budget[0].standard_uncertainty)
    assert abs(np.mean(z)) < 0.55
    assert 0.7 < np.std(z, ddof=1) < 1.35


def test_an_inverted_gyro_has_a_negative_sensitivity_and_its_phase_less_half_a_turn() -> None:
    inverted = reduced(stream(recording(gyro=Gyro(scale=-0.05))))
    results = by_name(inverted)
    assert results["sensitivity_10Hz"].value == pytest.approx(-50.0, rel=2e-3)
    assert -20.0 < (results["phase_10Hz"].value or 0.0) < 0.0
    assert any("against the sign" in one for one in inverted.remarks)
    known = vibration_output(scale_factor=Quantity(-50.0, "mV/(deg/s)"))
    as_known = reduced(stream(recording(gyro=Gyro(scale=-0.05))), context(output=known))
    assert by_name(as_known)["sensitivity_10Hz"].value == pytest.approx(-50.0, rel=2e-3)
    assert not any("against the sign" in one for one in as_known.remarks)


def test_an_encoder_that_gives_the_angle_is_as_good() -> None:
    values = recording()
    angles = np.concatenate([one.angle_deg(np.arange(20_000) / RATE_HZ) for one in motions()])
    values = np.stack((values[:, 0], np.deg2rad(angles)), axis=1)
    told = sampling(auxiliary=(Auxiliary(name="encoder_angle", unit="rad"),), offsets_s=(0.0, 0.0))
    encoder = dataclasses.replace(ENCODER, sine=None, cosine=None, lines=None, angle="angle")
    results = by_name(reduced(stream(values, sampling=told), context(encoder=encoder)))
    assert results["sensitivity_80Hz"].value == pytest.approx(
        1000.0 * abs(GYRO.response(80.0)), rel=1e-4
    )
    assert "errors of the encoder within small angles" in results["phase_80Hz"].not_included


def test_a_swept_table_gives_the_same() -> None:
    told = parameters(
        frequencies=(Quantity(30.0, "Hz"), Quantity(50.0, "Hz")),
        reference_frequency=None,
        sweep_from=Quantity(26.0, "Hz"),
        sweep_to=Quantity(58.0, "Hz"),
    )
    length = case(duration=Quantity(12.0, "s"))
    (step,) = SineVibration().plan(length, told).steps
    assert step.stimulus == Vibrating(
        excitation=Excitation.SWEEP, rms_dps=8.0, low_hz=26.0, high_hz=58.0, settle_s=2.0
    )
    sweep = Swept(low_hz=26.0, growth_per_s=math.log(58.0 / 26.0) / 12.0)
    values = recorded([sweep], samples=120_000, gyro=Gyro(delay_s=0.9e-3, noise_v=1e-4))
    results = by_name(reduced(stream(values), context(told, case=length)))
    for frequency_hz in (30.0, 50.0):
        phase = results[f"phase_{frequency_hz:g}Hz"].value
        assert results[f"sensitivity_{frequency_hz:g}Hz"].value == pytest.approx(50.0, rel=5e-4)
        assert phase == pytest.approx(-360.0 * frequency_hz * 0.9e-3, abs=0.02)


def test_the_speed_of_a_sweep_is_in_the_uncertainty() -> None:
    """A delay τ: H″/H is −τ², so that swept through with α the gain keeps and the phase errs by ατ²/2 at most."""
    growth_per_s, delay_s = math.log(58.0 / 26.0) / 12.0, 0.9e-3
    told = parameters(
        frequencies=(Quantity(30.0, "Hz"), Quantity(50.0, "Hz")),
        reference_frequency=None,
        sweep_from=Quantity(26.0, "Hz"),
        sweep_to=Quantity(58.0, "Hz"),
    )
    sweep = Swept(low_hz=26.0, growth_per_s=growth_per_s)
    values = recorded([sweep], samples=120_000, gyro=Gyro(delay_s=delay_s, noise_v=1e-4))
    results = by_name(reduced(stream(values), context(told, case=case(duration=Quantity(12.0, "s")))))
    (line,) = (one for one in results["phase_50Hz"].budget if one.source == "speed of the sweep")
    # the phase over ln f is not straight: the slope between 30 and 50 Hz is that at their logarithmic mean
    mean_hz = 20.0 / math.log(50.0 / 30.0)
    omega = 2.0 * math.pi * 50.0
    share = growth_per_s * omega * (delay_s * mean_hz / 50.0) ** 2 / 2.0
    assert line.standard_uncertainty == pytest.approx(math.degrees(share) / math.sqrt(3.0), rel=0.02)
    assert not results["phase_50Hz"].not_included


@dataclasses.dataclass(frozen=True, kw_only=True)
class Swept:
    """A sweep of the table, under a gyro that is nothing but a delay."""

    low_hz: float
    growth_per_s: float

    def _moved(self, time_s: NDArray[np.float64]) -> NDArray[np.complex128]:
        """The angle's wave and, imaginary, its rate."""
        phase = 2.0 * np.pi * self.low_hz * np.expm1(self.growth_per_s * time_s) / self.growth_per_s
        omega = 2.0 * np.pi * self.low_hz * np.exp(self.growth_per_s * time_s)
        peak = LEVEL_DPS * math.sqrt(2.0) / omega
        rate = peak * (omega * np.cos(phase) - self.growth_per_s * np.sin(phase))
        moved: NDArray[np.complex128] = peak * np.sin(phase) + 1j * rate
        return moved

    def angle_deg(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        return self._moved(time_s).real

    def output_v(self, gyro: Gyro, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        output: NDArray[np.float64] = gyro.zero + gyro.scale * self._moved(time_s - gyro.delay_s).imag
        return output


def test_gaps_are_refused_or_the_longest_stretch_is_used() -> None:
    lost = tuple(range(24_000, 24_010))
    with pytest.raises(InsufficientDataError, match=r"step '40 Hz' .*: 10 of 20000 samples are missing"):
        reduced(stream(recording(), lost=lost))
    kept = case(gaps=Gaps.LONGEST_STRETCH)
    reduction = reduced(stream(recording(), lost=lost), context(case=kept))
    results = by_name(reduction)
    assert results["sensitivity_40Hz"].value == pytest.approx(
        1000.0 * abs(GYRO.response(40.0)), rel=1e-3
    )
    assert results["phase_40Hz"].value == pytest.approx(
        np.degrees(np.angle(GYRO.response(40.0))), abs=0.05
    )
    assert any("longest stretch" in one and "15966 of 20000" in one for one in reduction.remarks)


@pytest.mark.parametrize("block", [65_536, 1000, 7777])
def test_blocks_of_any_size_give_the_same(block: int, found: Reduction) -> None:
    again = by_name(reduced(stream(recording(), block=block)))
    for name, one in by_name(found).items():
        assert again[name].value == pytest.approx(one.value, rel=1e-6)


def test_a_source_without_one_clock_is_refused() -> None:
    with pytest.raises(InsufficientDataError, match="does not sample its channels by one clock"):
        reduced(stream(recording(), sampling=sampling(synchronous=False)))


def test_a_slot_without_an_encoder_is_refused() -> None:
    with pytest.raises(InsufficientDataError, match="give the slot an 'encoder'"):
        reduced(stream(recording()), context(encoder=None))
    bare = sampling(auxiliary=(), offsets_s=(0.0,))
    with pytest.raises(InsufficientDataError, match="give the slot an 'encoder'"):
        reduced(stream(recording()[:, :1], sampling=bare))
    unknown = dataclasses.replace(ENCODER, lines=None)
    with pytest.raises(InsufficientDataError, match="how many lines"):
        reduced(stream(recording()), context(encoder=unknown))


def test_an_encoder_starved_of_samples_is_refused_with_both_rates() -> None:
    fast = recorded(motions(rms_dps=55.0), samples=20_000)
    with pytest.raises(InsufficientDataError, match=r"step '10 Hz'.*starved.*10000 Hz"):
        reduced(stream(fast))


def test_a_clipped_gyro_is_refused() -> None:
    with pytest.raises(InsufficientDataError, match=r"step '10 Hz' .* 2 are overloads"):
        reduced(stream(recording(), overloaded=(50, 51)))
    clipped = recording()
    clipped[:, 0] = np.minimum(clipped[:, 0], 2.9)
    with pytest.raises(InsufficientDataError, match=r"read 2.9 V, its greatest: it is clipped"):
        reduced(stream(clipped))
    small = vibration_output(full_scale=Quantity(10.0, "deg/s"))
    with pytest.raises(InsufficientDataError, match=r"beyond the full scale of 10.* deg/s"):
        reduced(stream(recording()), context(output=small))
    stuck = recording()
    stuck[20_000:40_000, 0] = 2.5
    with pytest.raises(InsufficientDataError, match=r"step '40 Hz' .* stuck"):
        reduced(stream(stuck))


@pytest.mark.parametrize(
    ("filter_hz", "said"), [(None, "none is stated"), (1300.0, "1300 Hz is stated")]
)
def test_sampling_that_may_alias_is_refused(filter_hz: float | None, said: str) -> None:
    slow = daq_sampling(interval_s=4e-4, filter_hz=filter_hz)
    with pytest.raises(InsufficientDataError, match=f"sampled at 2500 Hz .*{said}"):
        reduced(stream(recording(), sampling=slow))


def test_a_table_that_does_not_move_as_asked_is_refused() -> None:
    faint = recorded(
        [*motions(FREQUENCIES_HZ[:4]), Sine(frequency_hz=120.0, rms_dps=1e-4)], samples=20_000
    )
    with pytest.raises(InsufficientDataError, match=r"step '120 Hz' .*(raise the level|moves at)"):
        reduced(stream(faint))
    other = recorded(motions((10.0, 40.0, 80.0, 100.0, 115.0)), samples=20_000)
    with pytest.raises(InsufficientDataError, match="moves at 115 Hz, and was asked for 120 Hz"):
        reduced(stream(other))


def test_a_dead_output_gives_no_value() -> None:
    dead = recording()
    dead[:, 0] = 2.5 + 1e-3 * np.random.default_rng(3).normal(size=dead.shape[0])
    results = by_name(reduced(stream(dead)))
    assert results["sensitivity_40Hz"].value is None
    assert "not told from its noise" in results["phase_40Hz"].condition


def test_a_frequency_a_little_off_is_told_and_in_the_budget() -> None:
    values = recorded(motions((10.0, 40.02, 80.0, 100.0, 120.0)), samples=20_000, gyro=GYRO)
    reduction = reduced(stream(values))
    assert any("most at 40 Hz, where it is 40.02 Hz" in one for one in reduction.remarks)
    budget = by_name(reduction)["phase_40Hz"].budget
    assert any(one.source == "frequency of the drive" for one in budget)


def test_the_figure_has_points_with_bars_limits_and_a_row_a_frequency() -> None:
    limits = {
        "sensitivity_10Hz": Limit(min=Quantity(49.0, "mV/(deg/s)"), max=Quantity(51.0, "mV/(deg/s)")),
        "phase_100Hz": Limit(min=Quantity(-120.0, "deg")),
    }
    (figure,) = reduced(stream(recording()), context(case=case(limits=limits))).figures
    gain, phase = figure.panels
    assert gain.points[0].x == FREQUENCIES_HZ
    assert gain.points[0].y[0] == pytest.approx(0.0)
    assert all(one > 0.0 for one in (*gain.points[0].u, *phase.points[0].u))
    assert sum(one.role.value == "limit" for one in gain.curves) == 2
    assert sum(one.role.value == "limit" for one in phase.curves) == 1
    assert figure.table is not None
    assert [row[0].text for row in figure.table.rows] == ["10", "40", "80", "100", "120"]


@pytest.mark.parametrize(
    ("told", "given", "key", "message"),
    [
        ({"level": Quantity(0.0, "deg/s")}, {}, "parameters.level", "not more than zero"),
        ({"frequencies": ()}, {}, "parameters.frequencies", "gives none"),
        ({"frequencies": (Quantity(5.0, "Hz"),) * 2}, {}, "parameters.frequencies[1]", "twice"),
        ({"reference_frequency": Quantity(11.0, "Hz")}, {}, "parameters.reference_frequency", "none of"),
        ({"flat_to": Quantity(130.0, "Hz")}, {}, "parameters.flat_to", "outside"),
        ({}, {"duration": Quantity(1.0, "s")}, "duration", "at least 1.1 s"),
        ({}, {"duration": Quantity(400.0, "s")}, "duration", "at most 300 s"),
        ({}, {"interval": Quantity(5.0, "ms")}, "interval", "too slow for 120 Hz"),
        ({"sweep_from": Quantity(4.5, "Hz")}, {}, "parameters.sweep_to", "needs both ends"),
        (
            {"sweep_from": Quantity(9.9, "Hz"), "sweep_to": Quantity(140.0, "Hz")},
            {"duration": Quantity(60.0, "s")},
            "parameters.sweep_from",
            "at most 9.32 Hz",
        ),
        (
            {"sweep_from": Quantity(9.0, "Hz"), "sweep_to": Quantity(121.0, "Hz")},
            {"duration": Quantity(60.0, "s")},
            "parameters.sweep_to",
            "at least 128.7 Hz",
        ),
        (
            {"sweep_from": Quantity(9.0, "Hz"), "sweep_to": Quantity(140.0, "Hz")},
            {"duration": Quantity(20.0, "s")},
            "duration",
            "sweeps too fast for 10 Hz",
        ),
    ],
)
def test_a_case_that_cannot_be_measured_is_complained_of(
    told: dict[str, Any], given: dict[str, Any], key: str, message: str
) -> None:
    found = dict(SineVibration().complaints(case(**given), parameters(**told), vibration_output()))
    assert message in found[key]


def test_a_sound_case_has_no_complaints() -> None:
    assert not list(SineVibration().complaints(case(), parameters(), vibration_output()))
