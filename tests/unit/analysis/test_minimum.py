"""The lowest point of an Allan deviation curve."""

import numpy as np
import pytest
from numpy.typing import ArrayLike

from gyrotest.analysis.allan import AllanDeviation
from gyrotest.analysis.minimum import allan_minimum
from gyrotest.analysis.noise_type import NoiseType


def _curve(deviation: ArrayLike, edf: ArrayLike = 50.0) -> AllanDeviation:
    deviation_dps = np.asarray(deviation, dtype=np.float64)
    size = deviation_dps.shape[-1]
    return AllanDeviation(
        averaging_factor=2 ** np.arange(size),
        tau_s=0.1 * 2.0 ** np.arange(size),
        deviation_dps=deviation_dps,
        n_differences=np.full(size, 100),
        edf=np.broadcast_to(np.asarray(edf, dtype=np.float64), (size,)),
        lower_dps=0.9 * deviation_dps,
        upper_dps=1.1 * deviation_dps,
        noise_type=np.full(size, NoiseType.BIAS_INSTABILITY, dtype=np.int8),
    )


def test_the_lowest_point_has_its_chi_square_interval() -> None:
    found = allan_minimum(_curve([4.0, 2.0, 1.0, 3.0]), first_tau_s=0.0)
    assert found is not None
    assert found.reached
    assert found.tau_s == pytest.approx(0.4)
    assert found.deviation_dps == 1.0
    # √(50/χ²₅₀) at 97.5 % and 2.5 %: χ² = 71.420 and 32.357
    assert found.lower_95_dps == pytest.approx(0.8367, rel=1e-4)
    assert found.upper_95_dps == pytest.approx(1.2431, rel=1e-4)


@pytest.mark.parametrize("deviation", [[4.0, 3.0, 2.0, 1.0], [1.0, 2.0, 3.0, 4.0]])
def test_a_lowest_point_at_an_end_is_no_floor(deviation: list[float]) -> None:
    found = allan_minimum(_curve(deviation), first_tau_s=0.0)
    assert found is not None
    assert not found.reached
    assert found.deviation_dps == 1.0


def test_points_of_few_degrees_of_freedom_do_not_count() -> None:
    found = allan_minimum(_curve([4.0, 2.0, 3.0, 0.5], [50, 50, 10, 9.9]), first_tau_s=0.0)
    assert found is not None
    assert found.deviation_dps == 2.0
    assert found.reached


def test_averaging_times_that_the_model_leaves_out_do_not_count() -> None:
    curve = _curve([0.5, 4.0, 2.0, 3.0])
    found = allan_minimum(curve, first_tau_s=0.2)
    assert found is not None
    assert found.deviation_dps == 2.0


def test_a_time_that_is_equal_but_for_rounding_counts() -> None:
    found = allan_minimum(_curve([4.0, 1.0, 2.0, 3.0]), first_tau_s=0.2 * (1.0 + 1e-12))
    assert found is not None
    assert found.tau_s == pytest.approx(0.2)


def test_a_record_that_is_too_short_has_none() -> None:
    assert allan_minimum(_curve([2.0, 1.0, 2.0], 9.0), first_tau_s=0.0) is None


def test_several_axes_at_once_are_a_mistake() -> None:
    with pytest.raises(ValueError, match="one record"):
        allan_minimum(_curve(np.ones((2, 4))), first_tau_s=0.0)
