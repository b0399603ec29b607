"""JSON, CSV, tables and plots of analyses."""

import csv
import io
import json
import math
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from gyrotest.analysis.noise_model import NoiseTerm
from gyrotest.offline.analysis import Analysis
from gyrotest.offline.figure import allan_plot
from gyrotest.offline.readings import readings
from gyrotest.offline.table import tables
from gyrotest.offline.titles import titles
from gyrotest.offline.to_csv import COLUMNS, csv_text
from gyrotest.offline.to_json import json_text
from gyrotest.records.figure import Role
from gyrotest.units import Quantity
from tests.unit.offline.records import analysis

DATASHEET = {
    "angle_random_walk": Quantity(0.1, "deg/sqrt(h)"),
    "allan_minimum": Quantity(2.0, "deg/h"),
    "rate_random_walk": Quantity(20.0, "deg/h/sqrt(h)"),
    "bias": Quantity(0.5, "deg/s"),
}


@pytest.fixture(scope="module")
def plain() -> Analysis:
    return analysis()


@pytest.fixture(scope="module")
def compared() -> Analysis:
    return analysis(column="gx", datasheet=DATASHEET)


@pytest.fixture(scope="module")
def document(plain: Analysis, compared: Analysis) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(json_text([plain, compared], ["x.npy: is empty"], None))
    return found


class TestReadings:
    def test_terms_stand_in_customary_units(self, plain: Analysis) -> None:
        named = {one.name: one for one in readings(plain)}
        walk = named["angle_random_walk"]
        assert walk.unit == "deg/sqrt(h)"
        assert walk.value == pytest.approx(60.0 * plain.model.angle_random_walk.value)
        assert walk.value == pytest.approx(10.0 / 60.0, rel=0.03)
        assert plain.minimum is not None
        assert named["allan_minimum"].value == pytest.approx(3600.0 * plain.minimum.deviation_dps)

    def test_what_is_not_resolved_is_its_upper_limit(self, plain: Analysis) -> None:
        quantization = readings(plain)[0]
        term: NoiseTerm = plain.model.quantization_noise
        assert not term.resolved
        assert quantization.at_most
        assert quantization.value == pytest.approx(3600.0 * term.upper_95)

    def test_the_datasheet_is_compared_with(self, compared: Analysis) -> None:
        named = {one.name: one for one in readings(compared)}
        walk = named["angle_random_walk"]
        assert walk.datasheet == pytest.approx(0.1)
        assert walk.ratio == pytest.approx((walk.value or 0.0) / 0.1)
        assert named["rate_ramp"].ratio is None

    def test_dead_time_is_taken_out_where_the_gyro_passes_the_noise(self) -> None:
        found = analysis(reading_s=0.04, bandwidth_hz=1000.0)
        named = {one.name: one for one in readings(found)}
        true, apparent = named["angle_random_walk"], named["angle_random_walk_apparent"]
        assert true.value == pytest.approx((apparent.value or 0.0) * math.sqrt(0.4), rel=0.01)
        assert any("corrected" in remark for remark in found.remarks)

    def test_dead_time_that_cannot_be_taken_out_leaves_no_value(self) -> None:
        found = analysis(reading_s=0.04)
        named = {one.name: one for one in readings(found)}
        assert named["angle_random_walk"].value is None
        assert named["angle_random_walk_apparent"].value is not None
        assert any("bandwidth must exceed 12.5 Hz and is not known" in one for one in found.remarks)
        record = json.loads(json_text([found], [], None))["records"][0]
        assert record["angle_random_walk_deg_per_sqrt_s"]["value"] is None
        assert record["angle_random_walk_apparent_deg_per_sqrt_s"]["value"] > 0.0


class TestRegularity:
    def test_noise_whose_spectrum_is_too_even_is_doubted(self) -> None:
        spectrum = np.fft.rfft(np.random.default_rng(5).standard_normal(20_000))
        even = np.fft.irfft(spectrum / np.abs(spectrum))
        remarks = " ".join(analysis(rate_dps=even).remarks)
        assert "more regular than noise can be (χ²/ν = 0.027)" in remarks
        assert "has it been smoothed, resampled or made up?" in remarks

    def test_noise_is_not_doubted(self, plain: Analysis) -> None:
        assert not any("regular" in remark for remark in plain.remarks)


class TestJson:
    def test_the_schema_is_named(self, document: dict[str, Any]) -> None:
        assert document["schema"] == "gyrotest.analysis/1"
        assert document["refused"] == ["x.npy: is empty"]
        assert document["spec"] is None

    def test_a_record_says_all_that_was_found(self, document: dict[str, Any], plain: Analysis) -> None:
        record = document["records"][0]
        assert (record["file"], record["column"], record["samples"]) == ("rest.npy", None, 6000)
        assert record["sample_rate_hz"] == pytest.approx(10.0)
        assert record["duration_s"] == pytest.approx(600.0)
        walk, term = record["angle_random_walk_deg_per_sqrt_s"], plain.model.angle_random_walk
        assert {key: walk[key] for key in ("value", "lower_68", "upper_68", "lower_95", "upper_95")} == {
            key: getattr(term, key) for key in ("value", "lower_68", "upper_68", "lower_95", "upper_95")
        }
        assert walk["resolved"] is True
        assert record["allan_minimum"]["floor_reached"] == (plain.minimum and plain.minimum.reached)
        assert {
            "quantization_noise_deg",
            "bias_instability_coefficient_dps",
            "rate_random_walk_dps_per_sqrt_s",
            "rate_ramp_dps_per_s",
        } <= set(record)

    def test_the_curve_is_whole(self, document: dict[str, Any], plain: Analysis) -> None:
        curve, fit = document["records"][0]["curve"], document["records"][0]["fit"]
        assert curve["deviation_dps"] == plain.curve.deviation_dps.tolist()
        lengths = {len(values) for values in curve.values() if isinstance(values, list)}
        lengths |= {len(values) for values in fit["components_dps"].values()}
        assert lengths == {plain.curve.tau_s.size}
        squares = np.square(list(fit["components_dps"].values())).sum(axis=0)
        assert np.sqrt(squares) == pytest.approx(fit["deviation_dps"])

    def test_datasheet_figures_are_in_the_values_units(self, document: dict[str, Any]) -> None:
        record = document["records"][1]
        assert record["angle_random_walk_deg_per_sqrt_s"]["datasheet"] == pytest.approx(0.1 / 60.0)
        assert record["allan_minimum"]["datasheet"] == pytest.approx(2.0 / 3600.0)
        assert record["rate_ramp_dps_per_s"]["ratio_to_datasheet"] is None

    def test_nothing_is_infinite_or_no_number(self, plain: Analysis, compared: Analysis) -> None:
        def refuse(constant: str) -> None:
            raise AssertionError(constant)

        json.loads(json_text([plain, compared], [], None), parse_constant=refuse)


class TestCsv:
    def test_every_averaging_time_has_a_row(self, plain: Analysis, compared: Analysis) -> None:
        rows = list(csv.DictReader(io.StringIO(csv_text([plain, compared]))))
        assert tuple(rows[0]) == COLUMNS
        assert len(rows) == 2 * plain.curve.tau_s.size
        first, last = rows[0], rows[-1]
        assert (first["file"], first["column"], last["column"]) == ("rest.npy", "", "gx")
        assert float(first["deviation_dps"]) == plain.curve.deviation_dps[0]
        assert float(last["tau_s"]) == compared.curve.tau_s[-1]
        assert first["noise_type"] == "angle_random_walk"


class TestTables:
    def test_both_bias_instability_numbers_are_named(self, plain: Analysis) -> None:
        written = tables(Console(width=120, color_system=None), [plain])
        assert "Bias instability coefficient B" in written
        assert "Allan deviation, minimum" in written
        assert "6000 samples at 10 Hz, 10.00 min" in written
        assert "datasheet" not in written

    @pytest.mark.parametrize("width", [40, 80, 120])
    def test_no_number_is_cut(self, compared: Analysis, width: int) -> None:
        written = tables(Console(width=width, color_system=None), [compared])
        table = [line for line in written.splitlines() if "°/√h" in line]
        assert table
        assert "0.1" in table[0].split()
        assert not any(line.endswith("…") for line in table)

    def test_the_datasheet_stands_beside(self, compared: Analysis) -> None:
        written = tables(Console(width=120, color_system=None), [compared])
        assert "rest.npy: gx" in written
        assert "datasheet 0.5 °/s" in written
        assert "ratio" in written


class TestPlot:
    def test_one_record_has_its_fit_and_read_offs(self, compared: Analysis) -> None:
        (panel,) = allan_plot([compared]).panels
        roles = [curve.role for curve in panel.curves]
        assert roles.count(Role.DATA) == 1
        assert roles.count(Role.MODEL) == 1
        assert Role.COMPONENT in roles
        assert {curve.label for curve in panel.curves if curve.role is Role.DATASHEET} >= {
            "datasheet minimum 2 °/h",
            "datasheet ARW 0.1 °/√h",
        }
        assert [mark.label.split()[0] for mark in panel.marks] == ["ARW", "minimum"]
        assert not panel.legend

    def test_several_records_are_told_apart_by_a_legend(self, plain: Analysis) -> None:
        others = [plain, analysis("other.npy", seed=2)]
        (panel,) = allan_plot(others).panels
        assert panel.legend
        data = [curve for curve in panel.curves if curve.role is Role.DATA]
        assert [(one.series, one.label) for one in data] == [(0, "rest.npy"), (1, "other.npy")]
        assert [band.series for band in panel.bands] == [0, 1]
        assert not any(curve.role is Role.MODEL for curve in panel.curves)

    def test_names_say_no_more_than_tells_records_apart(self, plain: Analysis) -> None:
        def named(*records: tuple[str, str]) -> tuple[str, ...]:
            return titles([analysis(name, column) for name, column in records])

        assert titles([plain]) == ("rest.npy",)
        assert named(("a.csv", "gx"), ("a.csv", "gy")) == ("gx", "gy")
        assert named(("a.csv", "gx"), ("b.csv", "gx")) == ("a.csv", "b.csv")
        assert named(("1/a.csv", "gx"), ("2/a.csv", "gx")) == ("1/a.csv", "2/a.csv")
        assert named(("a.csv", "gx"), ("b.csv", "gy")) == ("a.csv: gx", "b.csv: gy")
