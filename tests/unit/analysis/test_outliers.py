"""Which samples of a dwell are kept."""

import numpy as np

from gyrotest.analysis.outliers import inside_window, median_deviation, near_median


def test_windows_of_opposite_rates_are_mirror_images() -> None:
    values = np.array([8.9, 9.0, 10.0, 11.0, 11.1])
    kept = inside_window(values, centre=10.0, half_width=1.0)
    assert kept.tolist() == [False, True, True, True, False]
    assert inside_window(-values, centre=-10.0, half_width=1.0).tolist() == kept.tolist()


def test_spikes_are_found_and_normal_noise_is_kept() -> None:
    values = np.random.default_rng(1).normal(5.0, 0.1, 1000)
    assert near_median(values, mads=7.5).all()
    values[[10, 500]] = (6.0, 3.0)
    assert np.flatnonzero(~near_median(values, mads=7.5)).tolist() == [10, 500]


def test_coarse_steps_are_not_outliers_of_one_another() -> None:
    values = np.rint(np.random.default_rng(2).normal(0.0, 0.4, 500))
    assert np.median(np.abs(values)) == 0.0
    assert median_deviation(values) == 1.0
    assert near_median(values, mads=7.5).all()


def test_a_constant_keeps_every_sample() -> None:
    assert near_median(np.full(20, 3.0), mads=7.5).all()


def test_few_samples_borrow_the_deviation_of_many() -> None:
    values = np.array([0.0, 0.0, 0.01, 0.01, -0.01, -0.01, 0.9])
    assert not near_median(values, mads=7.5).all()
    assert near_median(values, mads=7.5, least_deviation=0.2).all()
