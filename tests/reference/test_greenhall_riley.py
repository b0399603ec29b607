"""Degrees of freedom against the fitted tables of Greenhall and Riley (2003), at their three digits."""

import numpy as np
import pytest

from gyrotest.analysis.edf import Variance, allan_edf

M = 10_000
MODIFIED = {
    2: (0.778, 0.500),
    1: (0.997, 0.616),
    0: (1.033, 0.607),
    -1: (1.048, 0.534),
    -2: (1.302, 0.535),
}
ALLAN = {0: (2 / 3, 1 / 3), -1: (0.852, 0.375), -2: (1.079, 0.368)}
HADAMARD = {0: (7 / 9, 1 / 2), -1: (0.997, 0.617), -2: (1.033, 0.607)}


@pytest.mark.parametrize(
    ("variance", "table"),
    [(Variance.ALLAN, ALLAN), (Variance.HADAMARD, HADAMARD), (Variance.MODIFIED, MODIFIED)],
    ids=["allan", "hadamard", "modified"],
)
@pytest.mark.parametrize("r", [5, 40])
def test_a_long_record_has_the_tabled_degrees_of_freedom(variance: Variance, table, r: int) -> None:
    beyond = M if variance is Variance.MODIFIED else 1
    points = r * M + variance.order * M + beyond - 1
    edf = allan_edf(points, M, list(table), variance=variance)
    np.testing.assert_allclose(edf, [r / (a0 - a1 / r) for a0, a1 in table.values()], rtol=1.2e-3)


@pytest.mark.parametrize(
    ("variance", "a0", "a1", "b0", "b1"),
    [(Variance.ALLAN, 790.0, 410.0, 15.23, 12.0), (Variance.HADAMARD, 9950.0, 6520.0, 47.8, 40.0)],
)
@pytest.mark.parametrize("m", [300, 1000, 100_000])
def test_flicker_angle_noise_depends_on_the_averaging_factor_as_tabled(
    variance: Variance, a0: float, a1: float, b0: float, b1: float, m: int
) -> None:
    r = 20
    edf = allan_edf(r * m + variance.order * m, m, 1, variance=variance)
    assert float(edf) == pytest.approx(r * (b0 + b1 * np.log(m)) ** 2 / (a0 - a1 / r), rel=1e-2)


@pytest.mark.parametrize(
    ("noise_type", "kept"),
    [(0, [1.001, 0.995, 0.949, 0.788, 0.474]), (-2, [1.0, 1.0, 1.0, 1.0, 0.957])],
)
def test_strides_keep_what_a_simulation_found_them_to_keep(noise_type: int, kept: list[float]) -> None:
    """Of 2000 simulated records, m = 64 and 4096 points; each figure is good to a few percent."""
    full = allan_edf(4097, 64, noise_type)
    strided = allan_edf(4097, 64, noise_type, strides=[16, 8, 4, 2, 1])
    np.testing.assert_allclose(strided / full, kept, rtol=0.06)
