"""The line through step means: the formula, its weights, forward and backward, refusals."""

import numpy as np
import pytest

from gyrotest.analysis.scale_factor import StepFit, fit_steps
from gyrotest.errors import InsufficientDataError

RATES = np.array([10.0, -10.0, 20.0, -20.0, 40.0, -40.0, 60.0, -60.0, 80.0, -80.0])
TIMES = np.arange(1.0, 11.0)


def fitted(outputs: np.ndarray, rest: tuple[float, float] = (0.0, 0.0), **changes: float) -> StepFit:
    return fit_steps(
        rates_dps=RATES,
        outputs=outputs,
        times_s=TIMES,
        rest_outputs=np.array(rest),
        rest_times_s=np.array([0.0, 11.0]),
        **changes,
    )


def test_slope_and_offset_are_those_of_the_methods_formula() -> None:
    outputs = 0.05 * RATES + np.random.default_rng(1).normal(0.0, 1e-3, RATES.size)
    m = RATES.size
    slope = (RATES @ outputs - RATES.sum() * outputs.sum() / m) / (RATES @ RATES - RATES.sum() ** 2 / m)
    found = fitted(outputs)
    assert found.scale_factor.value == pytest.approx(slope, rel=1e-12)
    assert found.offset.value == pytest.approx(outputs.mean() - slope * RATES.mean())
    assert found.residual == pytest.approx(outputs - slope * RATES - found.offset.value)


def test_a_drift_that_is_linear_in_time_changes_nothing_but_the_rest_difference() -> None:
    straight = 0.05 * RATES + 0.01
    drifting = fitted(straight + 0.002 * TIMES, rest=(0.01, 0.01 + 0.002 * 11.0))
    assert drifting.scale_factor.value == pytest.approx(0.05, rel=1e-12)
    assert drifting.residual == pytest.approx(0.0, abs=1e-15)
    assert drifting.offset.value == pytest.approx(0.01 + 0.001 * 11.0)
    assert drifting.rest_difference is not None
    assert drifting.rest_difference.value == pytest.approx(0.022)


def test_what_is_found_is_the_sum_of_the_means_by_its_weights() -> None:
    outputs = 0.05 * RATES + 0.2 + 1e-4 * RATES**2 / 80.0
    found, means = fitted(outputs, rest=(0.2, 0.21)), np.append(outputs, (0.2, 0.21))
    for one in (found.scale_factor, found.offset, found.forward, found.backward, *found.residuals):
        assert one is not None
        assert one.value == pytest.approx(float(one.weights @ means), abs=1e-14)
    assert found.bias.value == pytest.approx(found.offset.value / found.scale_factor.value)
    step = 1e-6 * np.arange(1.0, 13.0)
    moved = fitted(outputs + step[:10], rest=(0.2 + step[10], 0.21 + step[11]))
    assert moved.bias.value - found.bias.value == pytest.approx(found.bias.weights @ step, rel=1e-3)


def test_forward_and_backward_have_intercepts_of_their_own() -> None:
    outputs = np.where(RATES > 0, 0.0501, 0.0499) * RATES + np.where(RATES > 0, 0.003, -0.002)
    found = fitted(outputs)
    assert found.forward is not None
    assert found.backward is not None
    assert (found.forward.value, found.backward.value) == pytest.approx((0.0501, 0.0499))
    assert found.asymmetry is not None
    assert found.asymmetry.value == pytest.approx(0.004)


def test_an_inverted_gyro_has_the_same_asymmetry_but_for_its_sign() -> None:
    outputs = -np.where(RATES > 0, 0.0501, 0.0499) * RATES
    found = fitted(outputs).asymmetry
    assert found is not None
    assert found.value == pytest.approx(-0.004)


def test_a_line_to_slow_steps_leaves_the_fast_ones_as_residuals() -> None:
    outputs = np.clip(0.05 * RATES, -2.5, 2.5)
    found = fitted(outputs, line_to_dps=40.0)
    assert found.scale_factor.value == pytest.approx(0.05)
    assert found.residual[8:] == pytest.approx((-1.5, 1.5))


def test_one_sign_alone_has_no_asymmetry() -> None:
    found = fit_steps(
        rates_dps=np.array([10.0, 20.0, 40.0]),
        outputs=np.array([0.5, 1.0, 2.0]),
        times_s=np.arange(3.0),
        rest_outputs=np.zeros(1),
        rest_times_s=np.zeros(1),
    )
    assert (found.backward, found.asymmetry, found.rest_difference) == (None, None, None)


@pytest.mark.parametrize(
    ("rates", "rest", "message"),
    [((40.0, 40.0), (0.0,), "1 rate;"), ((40.0, -40.0), (), "no step at rest")],
)
def test_too_little_is_refused(rates: tuple[float, ...], rest: tuple[float, ...], message: str) -> None:
    with pytest.raises(InsufficientDataError, match=message):
        fit_steps(
            rates_dps=np.array(rates),
            outputs=np.array(rates),
            times_s=np.arange(2.0),
            rest_outputs=np.array(rest),
            rest_times_s=np.array(rest),
        )
