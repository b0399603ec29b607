"""The static procedure's figures hide no sample and draw what the case asks for."""

import dataclasses

import numpy as np
import pytest

from gyrotest.analysis.noise_model import Drift, DriftKind, SpectralLine
from gyrotest.procedures.rest.record import rest_record
from gyrotest.procedures.static import Static
from gyrotest.procedures.static.noise_results import analyse_noise
from gyrotest.procedures.static.terms_table import terms_table
from gyrotest.records.figure import Figure, Panel, Role
from gyrotest.records.spec import Limit, Output, OutputKind
from gyrotest.records.table import Cell, Table
from gyrotest.units import Quantity
from tests.unit.procedures.bench import (
    by_name,
    meter_sampling,
    rates,
    samples_of,
    static_case,
    static_context,
    voltages,
)


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


def allan_panel(rate: np.ndarray, **changes: object) -> Panel:
    (panel,) = figures(rate, **changes)["allan_deviation"].panels
    return panel


def test_the_allan_plot_draws_limits_datasheet_floor_and_read_offs() -> None:
    limits = {
        "allan_minimum": Limit(max=Quantity(12.0, "deg/h")),
        "bias_instability_coefficient": Limit(max=Quantity(16.0, "deg/h")),
        "angle_random_walk": Limit(max=Quantity(0.6, "deg/sqrt(h)")),
        "rate_random_walk": Limit(max=Quantity(60.0, "deg/h/sqrt(h)")),
    }
    datasheet = {"angle_random_walk": Quantity(0.5, "deg/sqrt(h)")}
    samples = samples_of(2.5 + 0.05 * rates(), sampling=meter_sampling(noise=1e-4))
    context = static_context(case=static_case(limits=limits), datasheet=datasheet)
    found = {one.name: one for one in Static().reduce(samples, context).figures}["allan_deviation"]
    panel = found.panels[0]
    labels = {curve.label: curve for curve in panel.curves}
    assert {
        "limit ARW 0.6 °/√h",
        "limit minimum 12 °/h",
        "limit K 60 °/h/√h",
        "datasheet ARW 0.5 °/√h",
    } <= set(labels)
    walk = labels["limit ARW 0.6 °/√h"]
    assert walk.y[0] == pytest.approx(0.6 / 60.0 * 3600.0)
    assert labels["limit minimum 12 °/h"].y == pytest.approx((12.0, 12.0))
    assert labels["limit B 16 °/h"].y == pytest.approx((16.0 * 0.6643,) * 2, rel=1e-4)
    rising = labels["limit K 60 °/h/√h"]
    assert rising.y[-1] == pytest.approx(60.0 / 60.0 * np.sqrt(rising.x[-1] / 3.0))
    assert Role.FLOOR in {curve.role for curve in panel.curves}
    assert len(panel.marks) == 2
    assert found.alt


def test_the_allan_plot_draws_the_fit_and_only_its_resolved_terms() -> None:
    """Half an hour in white noise shows no random walk; 0.5 °/√h and 8 °/h it does show."""
    panel = allan_panel(rates())
    letters = [curve.label for curve in panel.curves if curve.role is Role.COMPONENT]
    assert letters == ["N", "B"]
    (fit,) = [curve for curve in panel.curves if curve.role is Role.MODEL]
    (data,) = [curve for curve in panel.curves if curve.role is Role.DATA]
    assert np.interp(1.0, fit.x, fit.y) == pytest.approx(data.y[0], rel=0.05)


def test_a_floor_far_below_the_curve_is_told_and_does_not_stretch_the_axis() -> None:
    found = figures(rates())["allan_deviation"]
    assert Role.FLOOR not in {curve.role for curve in found.panels[0].curves}
    assert "meter's own noise is far below: 0.22 °/h at 1 s" in found.caption


def rows_of(table: Table | None) -> dict[str, dict[str, Cell]]:
    assert table is not None
    headings = [column.heading for column in table.columns]
    return {row[0].text: dict(zip(headings, row, strict=True)) for row in table.rows}


def test_the_table_of_terms_has_their_values_beside_the_datasheets() -> None:
    datasheet = {
        "angle_random_walk": Quantity(0.25, "deg/sqrt(h)"),
        "allan_minimum": Quantity(0.1, "deg/min"),
    }
    reduction = Static().reduce(voltages(rates()), static_context(datasheet=datasheet))
    (figure,) = [one for one in reduction.figures if one.name == "allan_deviation"]
    rows = rows_of(figure.table)
    assert [name[0] for name in rows] == ["Q", "N", "B", "K", "R", "M"]
    results = by_name(reduction.results)
    walk = rows["N – angle random walk"]
    assert walk["Value"].value == results["angle_random_walk"].value
    assert walk["Ratio"].value == pytest.approx((results["angle_random_walk"].value or 0.0) / 0.25)
    assert (walk["Datasheet"].text, walk["Unit"].text) == ("0.25", "°/√h")
    assert walk["Carries τ"].text.startswith("1 … ")
    assert 0.0 < (walk["u"].value or 0.0) < 0.1 * (walk["Value"].value or 0.0)
    ramp = rows["R – rate ramp"]
    assert ramp["Value"].at_most
    assert ramp["95 % interval"].text == "not resolved"
    lowest = rows["Minimum of the curve (no term)"]
    assert lowest["Unit"].text == "°/min"
    assert lowest["Value"].value == pytest.approx((results["allan_minimum"].value or 0.0) / 60.0)


@pytest.mark.parametrize(("better", "told"), [(1e-5, 0), (1e-7, 1)])
def test_the_table_asks_whether_noise_that_is_too_regular_is_noise(better: float, told: int) -> None:
    context = static_context()
    noise = analyse_noise(rest_record(voltages(rates()), context))
    named = by_name(Static().reduce(voltages(rates()), context).results)
    model = dataclasses.replace(noise.model, misfit=0.0267, fit_probability=1.0 - better)
    sentences = terms_table(dataclasses.replace(noise, model=model), named, context).sentences
    asked = [one for one in sentences if "more regular than noise can be (χ²/ν = 0.027)" in one]
    assert len(asked) == told


def test_the_table_says_how_well_the_model_fits_and_what_was_kept_out_of_it() -> None:
    context = static_context()
    record = rest_record(voltages(rates()), context)
    noise = analyse_noise(record)
    named = by_name(Static().reduce(voltages(rates()), context).results)
    plain = terms_table(noise, named, context)
    assert plain.note.startswith("fit over τ = 1 … 1800 s, χ²/ν = ")
    model = dataclasses.replace(
        noise.model,
        lines=(SpectralLine(frequency_hz=0.2, amplitude_dps=0.002, standard_uncertainty_dps=0.0001),),
        drift=Drift(
            kind=DriftKind.EXPONENTIAL,
            change_dps=-0.01,
            standard_uncertainty_dps=0.001,
            time_constant_s=240.0,
        ),
        misfit=4.0,
        fit_probability=1e-9,
    )
    told = terms_table(dataclasses.replace(noise, model=model), named, context)
    text = " ".join(told.sentences)
    assert "200 mHz, amplitude (7.20 ± 0.36) °/h" in text
    assert (
        "exponential, time constant 240 s, (−36.0 ± 3.6) °/h (± standard uncertainty) over the record"
        in text
    )
    assert "widened by √(χ²/ν) = 2" in text
    assert told.note.endswith("probability < 0.001")


def test_a_record_that_rounding_hides_has_no_table_of_terms() -> None:
    values = np.full(3600, 0.35)
    values[::37] += 0.05
    context = static_context(output=Output(kind=OutputKind.RATE), accuracy=None)
    samples = samples_of(values, sampling=meter_sampling(unit="deg/s", noise=None))
    found = {one.name: one for one in Static().reduce(samples, context).figures}["allan_deviation"]
    assert found.table is None
    assert not {Role.MODEL, Role.COMPONENT} & {curve.role for curve in found.panels[0].curves}


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
