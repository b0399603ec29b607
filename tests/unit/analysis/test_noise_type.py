"""Noise type by lag-1 autocorrelation."""

import numpy as np
import pytest

from gyrotest.analysis.angle import angle
from gyrotest.analysis.noise_type import NoiseType, noise_types
from tests.unit.analysis.generator import gyro_noise


@pytest.mark.parametrize(
    ("record", "expected"),
    [
        (gyro_noise(4000, angle_random_walk=1.0), NoiseType.ANGLE_RANDOM_WALK),
        (gyro_noise(4000, bias_instability=1.0), NoiseType.BIAS_INSTABILITY),
        (gyro_noise(4000, rate_random_walk=1.0), NoiseType.RATE_RANDOM_WALK),
        (np.diff(gyro_noise(40_001, angle_random_walk=1.0)), NoiseType.QUANTIZATION),
    ],
)
def test_each_noise_type_is_recognised(record: np.ndarray, expected: NoiseType) -> None:
    found = noise_types(angle(record), np.array([1, 4, 10]))
    assert found.tolist() == [expected] * 3


def test_where_few_averages_are_left_the_type_before_stands() -> None:
    record = gyro_noise(400, rate_random_walk=1.0)
    found = noise_types(angle(record), np.array([10, 40, 44]))
    assert found.tolist() == [NoiseType.RATE_RANDOM_WALK] * 3


def test_without_any_identification_white_noise_is_assumed() -> None:
    record = gyro_noise(20, rate_random_walk=1.0)
    found = noise_types(angle(record), np.array([1, 2]))
    assert found.tolist() == [NoiseType.ANGLE_RANDOM_WALK] * 2


def test_a_record_longer_than_a_piece_is_recognised_too() -> None:
    record = gyro_noise(140_000, angle_random_walk=1.0) + 1e-4 * np.arange(140_000.0)
    found = noise_types(angle(record), np.array([1, 2]))
    assert found.tolist() == [NoiseType.ANGLE_RANDOM_WALK] * 2
