"""An Allan deviation, its band and its fit as what figures are made of."""

import numpy as np
import pytest

from gyrotest.analysis.allan import AllanDeviation, overlapping_allan_deviation
from gyrotest.analysis.noise import NoiseModel, identify_noise
from gyrotest.procedures.allan_curves import (
    TERM_LETTERS,
    component_curves,
    confidence_band,
    deviation_curve,
    fitted_curve,
)
from gyrotest.records.figure import Role
from tests.unit.offline.records import RATE_HZ, rates


@pytest.fixture(scope="module")
def curve() -> AllanDeviation:
    return overlapping_allan_deviation(rates(20_000, walk_dph=2.0), sample_rate_hz=RATE_HZ)


@pytest.fixture(scope="module")
def model(curve: AllanDeviation) -> NoiseModel:
    return identify_noise(rates(20_000, walk_dph=2.0), sample_rate_hz=RATE_HZ, deviation=curve)


def test_curve_and_band_are_drawn_in_the_unit_asked_for(curve: AllanDeviation) -> None:
    drawn, band = deviation_curve(curve, per_dps=3600.0), confidence_band(curve, per_dps=3600.0)
    assert drawn.x == band.x == tuple(curve.tau_s.tolist())
    assert drawn.y == pytest.approx((3600.0 * curve.deviation_dps).tolist())
    assert all(low < y < high for low, y, high in zip(band.lower, drawn.y, band.upper, strict=True))


def test_the_fit_is_drawn_where_it_was_fitted(curve: AllanDeviation, model: NoiseModel) -> None:
    fit = fitted_curve(curve, model, per_dps=1.0)
    assert fit.role is Role.MODEL
    assert fit.x[0] >= model.first_tau_s * (1 - 1e-9)
    assert fit.x[-1] <= min(model.last_tau_s, float(curve.tau_s[-1])) * (1 + 1e-9)
    measured = dict(zip(curve.tau_s.tolist(), curve.deviation_dps.tolist(), strict=True))
    nearest = [measured[min(measured, key=lambda tau, x=x: abs(tau - x))] for x in fit.x]
    assert np.allclose(fit.y, nearest, rtol=0.5)


def test_components_are_drawn_where_they_show_and_never_above_the_fit(
    curve: AllanDeviation, model: NoiseModel
) -> None:
    fit = fitted_curve(curve, model, per_dps=1.0)
    total = dict(zip(fit.x, fit.y, strict=True))
    drawn = list(component_curves(curve, model, per_dps=1.0))
    assert {"N", "K"} <= {one.label for one in drawn} <= set(TERM_LETTERS)
    for one in drawn:
        assert one.role is Role.COMPONENT
        assert all(
            0.1 * total[x] < y <= total[x] * (1 + 1e-9) for x, y in zip(one.x, one.y, strict=True)
        )
