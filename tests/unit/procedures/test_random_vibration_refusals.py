"""What a random-vibration case refuses: at the spec's door, and in what was recorded."""

import dataclasses
from typing import Any

import numpy as np
import pytest

from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.random_vibration import RandomVibration
from gyrotest.records.plan import Excitation, Vibrating
from gyrotest.records.recording import Gap
from gyrotest.records.result import Result
from gyrotest.records.spec import Case, Limit, Output, OutputKind
from gyrotest.units import Quantity
from tests.unit.procedures.random_vibration_bench import (
    QUIET,
    RUN_S,
    Random,
    context,
    parameters,
    reduced,
    runs,
)
from tests.unit.procedures.vibration_bench import (
    RATE_HZ,
    daq_sampling,
    recorded,
    streamed,
    vibration_output,
)


def hz(value: float) -> Quantity:
    return Quantity(value, "Hz")


def seconds(value: float) -> Quantity:
    return Quantity(value, "s")


def spec_case(**changes: Any) -> Case:
    plain = Case(
        procedure="random_vibration", duration=Quantity(2.0, "min"), interval=Quantity(0.1, "ms")
    )
    return dataclasses.replace(plain, **changes)


def given(**changes: Any) -> Any:
    return parameters(**({"low": hz(5.0), "rest": seconds(60.0)} | changes))


def complaints(case: Case | None = None, output: Output | None = None, **changes: Any) -> dict[str, str]:
    found = RandomVibration().complaints(
        case or spec_case(), given(**changes), output or vibration_output()
    )
    return dict(found)


def limited(*names: str) -> Case:
    return spec_case(limits={name: Limit(max=Quantity(1.0, "%")) for name in names})


def test_an_ordinary_case_is_not_complained_of() -> None:
    assert complaints() == {}


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        ({"low": hz(0.0)}, "low", "'0 Hz' is not more than zero"),
        ({"low": hz(120.0)}, "high", "'100 Hz' does not lie above the lowest frequency, '120 Hz'"),
        ({"level": Quantity(0.0, "deg/s")}, "level", "is not more than zero"),
        ({"runs": 0}, "runs", "0 is not between 1 and 50"),
        ({"settle": seconds(-1.0)}, "settle", "'-1 s' is less than zero"),
        ({"degree": 0}, "degree", "0 is not between 1 and 20"),
        ({"coherence_floor": 1.0}, "coherence_floor", "1 is not between 0 and 1"),
        ({"cutoff": hz(90.0)}, "cutoff", "does not lie above the highest frequency, '100 Hz'"),
        ({"segment": seconds(3.0)}, "segment", "fewer than 20 periods of '5 Hz'; at least 4 s"),
        ({"rest": seconds(10.0)}, "rest", "too short for the noise at rest; at least 5 segments of 4 s"),
        ({"rest": seconds(60.00005)}, "rest", "is no whole number of intervals of '0.1 ms'"),
        (
            {"frequencies": (hz(20.0), hz(4.0))},
            "frequencies[1]",
            "'4 Hz' is outside the band, 5 Hz … 100",
        ),
        ({"frequencies": (hz(20.0), Quantity(0.02, "kHz"))}, "frequencies[1]", "is there twice"),
        ({"reference_frequency": hz(3.0)}, "reference_frequency", "outside the band"),
        ({"flat_to": hz(101.0)}, "flat_to", "outside the band"),
        ({"compare_with": " "}, "compare_with", "is empty; name an earlier case"),
        ({"amplitude_goal": Quantity(0.0, "%")}, "amplitude_goal", "is not more than zero"),
    ],
)
def test_parameters_that_make_no_sense_are_complained_of(
    changes: dict[str, Any], key: str, words: str
) -> None:
    found = complaints(**changes)
    assert list(found) == [f"parameters.{key}"]
    assert words in found[f"parameters.{key}"]


def test_runs_that_are_too_short_are_complained_of() -> None:
    found = complaints(spec_case(duration=seconds(30.0)))
    assert found == {
        "duration": "'30 s' is too short for a run; at least 10 segments of 4 s, 40 s",
    }


def test_sampling_that_is_too_slow_for_the_low_pass_is_complained_of() -> None:
    found = complaints(spec_case(interval=Quantity(2.0, "ms")))
    assert "too slow for a low-pass of 250 Hz; at most 1 ms" in found["interval"]


def test_repeatability_needs_two_runs() -> None:
    case = limited("amplitude_repeatability")
    assert list(complaints(case, runs=1)) == ["limits.amplitude_repeatability"]
    assert complaints(case, runs=2) == {}


def test_agreement_needs_a_case_to_agree_with() -> None:
    case = limited("amplitude_agreement")
    assert list(complaints(case)) == ["limits.amplitude_agreement"]
    assert complaints(case, compare_with="sine") == {}


def test_one_axis_vibrates_at_a_time_and_counts_need_a_scale_factor() -> None:
    axes = complaints(output=vibration_output(axes=("x", "y")))
    assert "the table vibrates about one" in axes["axes"]
    counts = Output(kind=OutputKind.COUNT)
    assert "needs 'output.scale_factor'" in complaints(output=counts)["procedure"]


def test_the_plan_is_a_record_at_rest_and_then_the_runs() -> None:
    plan = RandomVibration().plan(spec_case(), given(settle=seconds(3.0)))
    assert [one.name for one in plan.steps] == ["rest", "run 1", "run 2", "run 3"]
    assert [one.samples for one in plan.steps] == [600_000, *[1_200_000] * 3]
    still, moving = plan.steps[0].stimulus, plan.steps[1].stimulus
    assert isinstance(still, Vibrating)
    assert (still.excitation, still.rms_dps) == (Excitation.NONE, 0.0)
    assert moving == Vibrating(
        excitation=Excitation.RANDOM, rms_dps=8.0, low_hz=5.0, high_hz=100.0, settle_s=3.0
    )
    assert plan.auxiliary == ("encoder_",)
    assert plan.vibrates


def test_every_measurand_is_declared_with_its_names() -> None:
    found = RandomVibration().measurands(spec_case(), given(), vibration_output())
    names = [one.name for one in found]
    assert names[:3] == ["sensitivity_22.5Hz", "sensitivity_40Hz", "sensitivity_80Hz"]
    assert names[3] == "phase_22.5Hz"
    assert names[6:] == [
        "flatness",
        "bandwidth_3db",
        "phase_90_frequency",
        "group_delay",
        "amplitude_repeatability",
        "phase_repeatability",
        "coherence_minimum",
        "amplitude_agreement",
        "phase_agreement",
    ]


def test_channels_that_are_not_synchronous_are_refused() -> None:
    with pytest.raises(InsufficientDataError, match="does not sample its channels by one clock"):
        reduced(streamed(runs(), sampling=daq_sampling(synchronous=False)))


def test_sampling_without_a_filter_that_keeps_from_aliasing_is_refused() -> None:
    slow = daq_sampling(interval_s=5e-4)
    with pytest.raises(InsufficientDataError, match=r"sampled at 2000 Hz .*none is stated"):
        reduced(streamed(runs(), sampling=slow))


def test_a_low_pass_above_half_the_sampling_rate_is_refused() -> None:
    wide = context(parameters(cutoff=hz(5000.0)))
    with pytest.raises(InsufficientDataError, match="the low-pass is 5000 Hz; it must lie below half"):
        reduced(runs(), wide)


def test_a_run_of_less_than_a_segment_is_refused_by_name() -> None:
    length = runs().shape[0] // 4
    short = context(dwells=_shortened(context().dwells, 5000))
    with pytest.raises(InsufficientDataError, match="'run 3'"):
        reduced(runs()[: 3 * length + 5000], short)


def _shortened(dwells: tuple[Any, ...], samples: int) -> tuple[Any, ...]:
    return (*dwells[:-1], dataclasses.replace(dwells[-1], samples=samples))


def test_a_table_that_does_not_move_is_refused() -> None:
    values = np.array(runs())
    length = values.shape[0] // 4
    for number in range(1, 4):
        values[number * length : (number + 1) * length] = values[:length]
    values += np.random.default_rng(7).normal(size=values.shape) * 1e-3
    with pytest.raises(InsufficientDataError, match="do not go round a circle"):
        reduced(values)


def test_a_rest_in_which_the_table_moves_is_refused() -> None:
    moved = [Random(rms_dps=2.0, seed=99), *(Random(seed=number) for number in range(3))]
    values = recorded(moved, samples=round(RUN_S * RATE_HZ), gyro=QUIET, seed=1)
    with pytest.raises(
        InsufficientDataError, match=r"step 'rest': the table moves with .*runs \d\.\d+ °/s"
    ):
        reduced(values)


def test_a_unit_that_does_not_follow_has_no_coherent_frequency() -> None:
    values = np.array(runs())
    values[:, 0] = 2.5 + 2e-3 * np.random.default_rng(7).normal(size=values.shape[0])
    with pytest.raises(InsufficientDataError, match=r"coherence is below 0\.8 over the whole band"):
        reduced(values)


def test_a_clipped_output_is_refused() -> None:
    values = np.array(runs())
    values[:, 0] = np.clip(values[:, 0], 2.3, 2.7)
    with pytest.raises(InsufficientDataError, match="it is clipped"):
        reduced(values)


def test_an_overload_is_refused() -> None:
    with pytest.raises(InsufficientDataError, match="overload"):
        reduced(streamed(runs(), overloaded=(150_000,)))


def test_an_encoder_that_is_starved_of_samples_is_refused() -> None:
    with pytest.raises(InsufficientDataError, match="the encoder is starved of samples"):
        reduced(runs(rms_dps=30.0))


def test_missing_samples_are_refused_unless_the_case_allows_them() -> None:
    lost = tuple(range(150_000, 150_050))
    gaps = (Gap(after=lost[0] - 1, missing=len(lost), reason="lost"),)
    with pytest.raises(InsufficientDataError, match="missing"):
        reduced(streamed(runs(), lost=lost), context(gaps=gaps))


def test_frequencies_of_low_coherence_are_left_out_named_and_drawn_in_grey() -> None:
    noisy = dataclasses.replace(QUIET, noise_v=0.1)
    found = reduced(runs(noisy, silent_hz=(54.0, 61.0)))
    (told,) = (text for text in found.remarks if text.startswith("Left out"))
    assert "coherence below 0.8" in told
    assert "of 81 frequencies (56 … 59 Hz)" in told
    bode = found.figures[0]
    grey = [one for panel in bode.panels for one in panel.curves if one.role.value == "floor"]
    assert len(grey) == 2
    assert grey[0].x[0] == pytest.approx(55.0)


def test_a_reported_frequency_beyond_what_is_coherent_has_no_value_but_a_reason() -> None:
    noisy = dataclasses.replace(QUIET, noise_v=0.1)
    found = reduced(runs(noisy, silent_hz=(70.0, 200.0)))
    named = {one.name: one for one in found.results}
    gone: Result = named["sensitivity_80Hz"]
    assert gone.value is None
    assert "80 Hz lies outside of what was measured with enough coherence" in gone.condition
    assert named["sensitivity_40Hz"].value is not None
    assert named["bandwidth_3db"].at_least
    bound = named["bandwidth_3db"].value
    assert bound is not None
    assert bound < 75.0
