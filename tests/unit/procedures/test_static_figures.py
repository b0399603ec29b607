"""The static procedure's figures hide no sample and draw what the case asks for."""

import numpy as np
import pytest

from gyrotest.procedures.static import Static
from gyrotest.records.figure import Figure, Role
from gyrotest.records.spec import Limit
from gyrotest.units import Quantity
from tests.unit.procedures.bench import rates, static_case, static_context, voltages


def figures(rate: np.ndarray, **changes: object) -> dict[str, Figure]:
    found = Static().reduce(voltages(rate), static_context(**changes)).figures
    return {one.name: one for one in found}


def test_the_band_keeps_a_single_spike_and_the_bins_fit_a_page() -> None:
    rate = rates(samples=20_011)
    rate[20_010] += 5.0
    panel = figures(rate)["record"].panels[0]
    band = panel.bands[0]
    assert len(band.x) <= 900
    assert max(band.upper) == pytest.approx(rate.max())
    assert panel.y_label == "Rate / (°/s)"


def test_small_rates_are_drawn_in_degrees_per_hour_with_60_s_means() -> None:
    record = figures(rates())["record"]
    assert record.panels[0].y_label == "Rate / (°/h)"
    assert record.panels[1].y_label == "60 s mean / (°/h)"
    assert len(record.panels[1].curves[0].x) == 60
    assert "0 missing" in record.note


def test_a_short_record_has_no_panel_of_means() -> None:
    assert len(figures(rates(samples=100))["record"].panels) == 1


def test_the_allan_plot_draws_limits_datasheet_floor_and_read_offs() -> None:
    limits = {
        "allan_minimum": Limit(max=Quantity(12.0, "deg/h")),
        "angle_random_walk": Limit(max=Quantity(0.6, "deg/sqrt(h)")),
    }
    datasheet = {"angle_random_walk": Quantity(0.5, "deg/sqrt(h)")}
    found = figures(rates(), case=static_case(limits=limits), datasheet=datasheet)["allan_deviation"]
    panel = found.panels[0]
    labels = {curve.label: curve for curve in panel.curves}
    assert {"limit ARW 0.6 °/√h", "limit minimum 12 °/h", "datasheet ARW 0.5 °/√h"} <= set(labels)
    walk = labels["limit ARW 0.6 °/√h"]
    assert walk.y[0] == pytest.approx(0.6 / 60.0 * 3600.0)
    assert labels["limit minimum 12 °/h"].y == pytest.approx((12.0, 12.0))
    assert Role.FLOOR in {curve.role for curve in panel.curves}
    assert len(panel.marks) == 2
    assert found.alt


def test_nothing_is_drawn_that_the_case_does_not_have() -> None:
    roles = {curve.role for curve in figures(rates())["allan_deviation"].panels[0].curves}
    assert not roles & {Role.LIMIT, Role.DATASHEET}


def test_the_histogram_has_the_area_one() -> None:
    bars = figures(rates())["residuals"].panels[0].bars
    assert bars is not None
    assert np.sum(np.diff(bars.edges) * bars.heights) == pytest.approx(1.0)


def test_the_histogram_of_counts_is_no_comb() -> None:
    """Each bin of a digitised record holds as many of its steps, whatever their number."""
    rate = np.rint(np.random.default_rng(1).standard_normal(100_000) * 7.0) * 0.05
    bars = figures(rate)["residuals"].panels[0].bars
    assert bars is not None
    assert np.sum(np.diff(bars.edges) * bars.heights) == pytest.approx(1.0)
    middle = np.array(bars.heights)[np.abs(np.array(bars.edges[1:]) + np.array(bars.edges[:-1])) < 0.4]
    assert middle.min() > 0.8 * middle.max()
