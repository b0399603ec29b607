"""A real six-axis MEMS in six positions and turned by hand: bias, g-sensitivity, scale factors.

The bench's azimuth is not known: the Earth's rate cannot be taken off and is in the uncertainty.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.analysis.accelerometer import accelerometer_in_positions
from gyrotest.analysis.earth import EARTH_RATE_DPS
from gyrotest.analysis.noise_terms import Grid
from gyrotest.analysis.six_positions import Positions, six_positions
from gyrotest.analysis.step_noise import step_noise
from gyrotest.analysis.turn import Parts, turn_integral

RATE_HZ = 204.8
AXES = "xyz"
# Counts per °/s, computed independently of this project from turns of −360°.
SCALE_FACTORS = {"x": -16.677, "y": -16.177, "z": -16.240}
UP = {
    f"{axis}_{end}": (place, sign)
    for place, axis in enumerate(AXES)
    for end, sign in (("p", 1), ("a", -1))
}


@dataclass(frozen=True)
class Session:
    """The parts of the session in their order, and the samples (n, 6): accelerometers, then gyros, in counts."""

    part: NDArray[np.str_]
    counts: NDArray[np.float64]

    def of(self, name: str) -> NDArray[np.float64]:
        """The samples of a part."""
        return self.counts[self.part == name]

    def scale_factor(self, axis: str) -> float:
        """Counts per °/s by a turn of −360° and the parts at rest about it."""
        at_rest = np.isin(self.part, (*UP, f"{axis}_rot"))
        values, part = self.counts[at_rest, 3 + AXES.index(axis)], self.part[at_rest]
        turning = np.flatnonzero(part == f"{axis}_rot")
        parts = Parts(begin=int(turning[0]), end=int(turning[-1]) + 1)
        found = turn_integral(values, np.arange(values.size), parts, interval_s=1.0 / RATE_HZ)
        return found.integral / -360.0


@pytest.fixture(scope="module")
def session(real_data: Path) -> Session:
    path = real_data / "imucal-ferraris" / "annotated_session.csv"
    rows = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines()]
    names = [f"{kind}_{axis}" for kind in ("acc", "gyr") for axis in AXES]
    places = [rows[0].index(one) for one in names]
    return Session(
        part=np.array([row[0] for row in rows[1:]]),
        counts=np.array([[float(row[at]) for at in places] for row in rows[1:]]),
    )


@pytest.fixture(scope="module")
def positions(session: Session) -> Positions:
    """All six channels in all six positions; the means' noise from the samples of all of them together."""
    parts = [session.of(name) for name in UP]
    forces = np.zeros((len(UP), 3))
    for row, (place, sign) in enumerate(UP.values()):
        forces[row, place] = sign
    grid = Grid(interval_s=1.0 / RATE_HZ, aperture_s=1.0 / RATE_HZ)
    covariance = []
    for channel in range(6):
        noise = step_noise([part[:, channel] for part in parts], grid)
        covariance.append(np.diag([noise.of_mean(len(part) / RATE_HZ).value for part in parts]))
    earth = [0.0] * 3 + [abs(SCALE_FACTORS[axis]) * EARTH_RATE_DPS for axis in AXES]
    return six_positions(
        np.stack([part.mean(axis=0) for part in parts]),
        forces,
        np.stack(covariance),
        unknown_rate=np.array(earth),
    )


@pytest.mark.parametrize("axis", AXES)
def test_the_scale_factors_of_the_turns_are_those_computed_independently(
    session: Session, axis: str
) -> None:
    assert session.scale_factor(axis) == pytest.approx(SCALE_FACTORS[axis], abs=0.001)


def test_six_positions_give_each_gyros_bias_and_g_sensitivity_with_the_earth_in_the_uncertainty(
    session: Session, positions: Positions
) -> None:
    scale = np.array([session.scale_factor(axis) for axis in AXES])
    bias = positions.bias[3:] / scale
    zeta = positions.sensitivity[3:] / scale[:, np.newaxis]
    uncertainty = np.sqrt(positions.covariance[3:, 1:, 1:].diagonal(axis1=1, axis2=2)) / np.abs(
        scale[:, np.newaxis]
    )
    # Means of six positions, by hand: 1.97, −4.47 and −3.66 counts.
    assert bias * scale == pytest.approx([1.97, -4.47, -3.66], abs=0.01)
    assert np.abs(zeta).max() < 0.03
    assert uncertainty.min() >= EARTH_RATE_DPS / np.sqrt(3.0)
    assert uncertainty.max() < 0.02
    # Counts by half the difference of up and down: what least squares is in six positions, nearly.
    by_hand = np.array(
        [
            [
                0.5
                * (session.of(f"{own}_p") - session.of(f"{own}_a").mean(axis=0)).mean(axis=0)[3 + gyro]
                for own in AXES
            ]
            for gyro in range(3)
        ]
    )
    assert positions.sensitivity[3:] == pytest.approx(by_hand, abs=0.02)


def test_the_same_positions_give_the_accelerometers_scale_factors_and_biases(
    positions: Positions,
) -> None:
    found = [accelerometer_in_positions(positions, channel, channel) for channel in range(3)]
    assert [one.scale_factor for one in found] == pytest.approx([2045.7, 2039.9, 2106.4], abs=1.0)
    assert [one.bias_g for one in found] == pytest.approx([-0.0064, -0.025, -0.0124], abs=0.01)
    for one in found:
        # Put down by hand: within a degree and a half or so of the vertical.
        assert np.abs(one.cross_axis).max() < 0.05
        assert 0.0 < one.scale_factor_uncertainty < 0.02 * one.scale_factor
