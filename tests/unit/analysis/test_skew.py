"""Skew: columns sampled one after another are brought to the first one's instants."""

import numpy as np
import pytest

from gyrotest.analysis.skew import Aligner

INTERVAL_S = 1e-4
OFFSETS_S = (0.0, 3.3e-5, -4.9e-5, 1.7e-4)


def sines(frequency_hz: float, samples: int, offsets_s: tuple[float, ...]) -> np.ndarray:
    time_s = np.arange(samples)[:, None] * INTERVAL_S + np.array(offsets_s)
    return np.sin(2.0 * np.pi * frequency_hz * time_s + 0.3)


def in_blocks(aligner: Aligner, values: np.ndarray, sizes: tuple[int, ...]) -> np.ndarray:
    parts, begin = [], 0
    for size in sizes:
        parts.append(aligner.push(values[begin : begin + size]))
        begin += size
    parts.append(aligner.push(values[begin:]))
    return np.concatenate(parts)


@pytest.mark.parametrize("of_nyquist", [0.002, 0.1, 0.33, 0.6])
def test_skewed_columns_become_what_they_are_at_the_first_ones_instants(of_nyquist: float) -> None:
    frequency_hz = of_nyquist * 0.5 / INTERVAL_S
    aligner = Aligner(OFFSETS_S, INTERVAL_S)
    aligned = aligner.push(sines(frequency_hz, 2000, OFFSETS_S))
    truth = sines(frequency_hz, 2000, (0.0,) * 4)[aligner.lost : 2000 - aligner.lost]
    assert aligned.shape == truth.shape
    assert np.abs(aligned - truth).max() < 2e-5


def test_the_error_grows_beyond_the_band_that_is_promised() -> None:
    aligner = Aligner((0.0, 0.5 * INTERVAL_S), INTERVAL_S)
    frequency_hz = 0.95 * 0.5 / INTERVAL_S
    aligned = aligner.push(sines(frequency_hz, 2000, (0.0, 0.5 * INTERVAL_S)))
    truth = sines(frequency_hz, 2000, (0.0, 0.0))[aligner.lost : 2000 - aligner.lost]
    assert np.abs(aligned - truth)[:, 1].max() > 0.1


def test_blocks_of_any_size_give_the_same_rows() -> None:
    values = np.random.default_rng(5).normal(size=(3000, 4))
    whole = Aligner(OFFSETS_S, INTERVAL_S).push(values)
    for sizes in ((1, 5, 13, 700), (29, 1), (1500,)):
        parts = in_blocks(Aligner(OFFSETS_S, INTERVAL_S), values, sizes)
        np.testing.assert_allclose(parts, whole, rtol=0, atol=1e-14)


def test_a_new_stretch_knows_nothing_of_the_one_before() -> None:
    values = np.random.default_rng(6).normal(size=(300, 4))
    aligner = Aligner(OFFSETS_S, INTERVAL_S)
    fresh = aligner.push(values)
    aligner.reset()
    np.testing.assert_array_equal(aligner.push(values), fresh)


def test_a_stretch_too_short_gives_no_row() -> None:
    aligner = Aligner(OFFSETS_S, INTERVAL_S)
    assert aligner.push(np.zeros((2 * aligner.lost, 4))).shape == (0, 4)
    assert aligner.push(np.zeros((1, 4))).shape == (1, 4)


def test_without_skew_rows_are_given_back_at_once() -> None:
    values = np.ones((7, 2))
    aligner = Aligner((0.0, 0.0), INTERVAL_S)
    assert aligner.lost == 0
    assert aligner.push(values) is values


def test_constants_stay_what_they_are() -> None:
    aligner = Aligner((0.0, 0.37 * INTERVAL_S), INTERVAL_S)
    aligned = aligner.push(np.full((200, 2), 2.5))
    np.testing.assert_allclose(aligned, 2.5, rtol=1e-14)


def test_offsets_count_from_the_first_column() -> None:
    values = np.random.default_rng(7).normal(size=(200, 2))
    from_zero = Aligner((0.0, 2e-5), INTERVAL_S).push(values)
    np.testing.assert_allclose(Aligner((5e-5, 7e-5), INTERVAL_S).push(values), from_zero, atol=1e-13)
