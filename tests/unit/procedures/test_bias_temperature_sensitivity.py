"""Temperature sensitivity of the bias: the plan, the definition, the chamber's share, honest uncertainties."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.errors import InsufficientDataError
from gyrotest.procedures.bias_temperature_sensitivity import (
    BiasTemperatureSensitivity,
    TemperatureParameters,
)
from gyrotest.records.figure import Role
from gyrotest.records.plan import Context, Reduction, Soaking
from gyrotest.records.recording import Auxiliary, Dwell, Samples, Sampling
from gyrotest.records.result import Result
from gyrotest.records.spec import Case, Limit
from gyrotest.records.station import Accuracy
from gyrotest.specification.spec import case_parameters
from gyrotest.units import Quantity
from tests.unit.analysis.generator import DPH, gyro_noise
from tests.unit.procedures.bench import by_name, static_case, static_context

SET_POINTS = (23.0, -40.0, 0.0, 60.0, 85.0)
RECORD, SOAK_S = 300, 1800.0
QUIET = {"angle_random_walk": 1e-3 * DPH}
NOISY = {"angle_random_walk": 30 * DPH, "bias_instability": 4 * DPH, "rate_random_walk": 0.05 * DPH}


def degc(*values: float) -> tuple[Quantity, ...]:
    return tuple(Quantity(one, "degC") for one in values)


def soaking_case(**changes: Any) -> Case:
    plain: dict[str, Any] = {
        "procedure": "bias_temperature_sensitivity",
        "duration": Quantity(5.0, "min"),
        "repeats": 1,
    }
    return static_case(**{**plain, **changes})


def soaking_context(set_points: tuple[float, ...] = SET_POINTS, **changes: Any) -> Context:
    plain: dict[str, Any] = {
        "case": soaking_case(),
        "case_name": "temperature",
        "parameters": TemperatureParameters(temperatures=degc(*set_points)),
        "chamber": Accuracy(of_reading=Quantity(0.0, "%"), of_setting=Quantity(0.6, "degC")),
        "dwells": dwells(set_points),
    }
    return static_context(**{**plain, **changes})


def dwells(set_points: tuple[float, ...], read: tuple[float, ...] | None = None) -> tuple[Dwell, ...]:
    return tuple(
        Dwell(
            name=f"{one:g} °C",
            first=place * RECORD,
            samples=RECORD,
            began_s=place * (RECORD + SOAK_S),
            settling_s=SOAK_S,
            temperature_degc=one,
            measured_temperature_degc=(read or set_points)[place],
        )
        for place, one in enumerate(set_points)
    )


def recorded(bias_dps: NDArray[np.float64], seed: int = 1, **noise: float) -> Samples:
    """Volts of a 50 mV/(°/s) gyro, a record after another; the rate random walk walks on between them."""
    random = np.random.default_rng(seed)
    parts, walked = [], 0.0
    for place, bias in enumerate(bias_dps):
        part = gyro_noise(RECORD, seed=1000 * seed + place, **(noise or QUIET))
        parts.append(2.5 + 0.05 * (part + bias + walked))
        walk = noise.get("rate_random_walk", 0.0)
        walked += walk * math.sqrt(RECORD + SOAK_S) * random.standard_normal()
    values = np.concatenate(parts)
    return Samples(
        sampling=Sampling(interval_s=1.0, aperture_s=1.0, noise=1e-9, range=10.0),
        values=values[:, None],
        flags=np.zeros(values.size, dtype=np.uint8),
    )


def bias_at(temperature_degc: NDArray[np.float64], slope_dph: float = 2.0) -> NDArray[np.float64]:
    """A slope, and more beyond 80 °C, so that the highest temperature is the worst one."""
    away = temperature_degc - 23.0
    found: NDArray[np.float64] = DPH * (100.0 + slope_dph * away + 1.0 * away * (away > 57.0))
    return found


def reduced(samples: Samples, **changes: Any) -> Reduction:
    return BiasTemperatureSensitivity().reduce(samples, soaking_context(**changes))


def test_the_sensitivity_is_the_worst_change_over_its_distance() -> None:
    found = by_name(reduced(recorded(bias_at(np.array(SET_POINTS)))).results)
    worst = found["bias_temperature_sensitivity"]
    assert worst.value == pytest.approx(3.0, abs=1e-3)
    assert worst.unit == "deg/h/degC"
    assert worst.condition.startswith("at 85 °C the bias is +186 °/h from that at 23 °C")
    slope = np.polyfit(SET_POINTS, bias_at(np.array(SET_POINTS)) / DPH, 1)[0]
    assert found["bias_temperature_slope"].value == pytest.approx(slope, abs=1e-3)


def test_an_inverted_gyro_has_the_same_sensitivity() -> None:
    output = static_context().output
    inverted = dataclasses.replace(output, scale_factor=Quantity(-50.0, "mV/(deg/s)"))
    samples = recorded(-bias_at(np.array(SET_POINTS)))
    found = by_name(reduced(samples, output=inverted).results)
    assert found["bias_temperature_sensitivity"].value == pytest.approx(3.0, abs=1e-3)


def test_the_chambers_reading_counts_and_not_the_set_point() -> None:
    read = (24.0, -39.0, 1.0, 61.0, 86.0)
    samples = recorded(bias_at(np.array(read) - 1.0))
    found = by_name(reduced(samples, dwells=dwells(SET_POINTS, read)).results)
    assert found["bias_temperature_sensitivity"].value == pytest.approx(3.0, abs=1e-3)


def with_sensor(samples: Samples, temperature: NDArray[np.float64], unit: str = "degC") -> Samples:
    column = np.repeat(temperature, RECORD)
    sampling = dataclasses.replace(
        samples.sampling, auxiliary=(Auxiliary(name="temperature", unit=unit),)
    )
    values = np.column_stack((samples.values[:, 0], column))
    return dataclasses.replace(samples, sampling=sampling, values=values)


def test_a_recorded_sensor_goes_before_the_chamber() -> None:
    inside = np.array(SET_POINTS) * 0.9 + 8.0
    samples = with_sensor(recorded(bias_at(np.array(SET_POINTS))), inside)
    found = by_name(reduced(samples).results)["bias_temperature_sensitivity"]
    assert found.value == pytest.approx(3.0 / 0.9, abs=1e-3)
    assert "accuracy of the temperature sensor" in found.not_included
    assert "recorded sensor" in found.condition
    assert not [one for one in found.budget if "chamber" in one.source]


def test_a_sensor_in_volts_is_no_temperature() -> None:
    samples = with_sensor(recorded(bias_at(np.array(SET_POINTS))), np.array(SET_POINTS), unit="V")
    found = by_name(reduced(samples).results)["bias_temperature_sensitivity"]
    assert "chamber's reading" in found.condition


def test_the_budget_has_noise_chamber_scale_factor_and_meter() -> None:
    samples = recorded(bias_at(np.array(SET_POINTS)))
    found = by_name(reduced(samples).results)["bias_temperature_sensitivity"]
    by_source = {one.source: one for one in found.budget}
    assert list(by_source) == [
        "noise and wander of the biases",
        "chamber, error of each setting",
        "scale factor",
        "meter, of reading",
    ]
    chamber = by_source["chamber, error of each setting"]
    assert chamber.standard_uncertainty == pytest.approx(3.0 / 62.0 * 0.6 * math.sqrt(2 / 3), rel=1e-3)
    assert by_source["scale factor"].standard_uncertainty == pytest.approx(0.005 * 3.0 / math.sqrt(3))
    assert found.not_included == ()


def test_what_is_not_known_is_not_included() -> None:
    samples = recorded(bias_at(np.array(SET_POINTS)))
    found = by_name(reduced(samples, chamber=None, accuracy=None).results)
    for one in found.values():
        assert one.not_included == ("accuracy of the chamber", "accuracy of the meter")


def test_truth_is_recovered_as_the_uncertainties_say() -> None:
    """Thirty units, each with its own slope, noise, walk and errors of each of the chamber's settings."""
    held, slope_z = 0, []
    set_points = (*SET_POINTS, 23.0)
    for unit in range(30):
        random = np.random.default_rng(unit)
        slope_dph = random.uniform(1.0, 3.0)
        true = np.array(set_points) + random.uniform(-0.6, 0.6, len(set_points))
        samples = recorded(bias_at(true, slope_dph), seed=unit + 1, **NOISY)
        found = by_name(reduced(samples, set_points=set_points).results)
        worst = found["bias_temperature_sensitivity"]
        held += (worst.lower_95 or 0.0) <= slope_dph + 1.0 <= (worst.upper_95 or 0.0)
        aimed = bias_at(np.array(SET_POINTS), slope_dph) / DPH
        slope_z.append(z(found["bias_temperature_slope"], np.polyfit(SET_POINTS, aimed, 1)[0]))
    assert held >= 26
    assert abs(np.mean(slope_z)) <= 0.55
    assert 0.65 <= np.std(slope_z, ddof=1) <= 1.4


def test_the_largest_of_equal_ratios_has_an_interval_that_holds_the_truth() -> None:
    """Where the bias is a line, noise chooses the set point: S is too large, and its interval says so."""
    set_points, held, values = (*SET_POINTS, 23.0), 0, []
    for unit in range(30):
        random = np.random.default_rng(unit)
        true = np.array(set_points) + random.uniform(-0.6, 0.6, len(set_points))
        samples = recorded(DPH * 2.0 * (true - 23.0), seed=unit + 1, **NOISY)
        worst = by_name(reduced(samples, set_points=set_points).results)["bias_temperature_sensitivity"]
        held += (worst.lower_95 or 0.0) <= 2.0 <= (worst.upper_95 or 0.0)
        values.append(worst.value)
    assert held >= 26
    assert np.mean(values) > 2.05


def z(found: Result, truth: float) -> float:
    standard = (found.expanded_uncertainty or 0.0) / (found.coverage_factor or 1.0)
    return float(((found.value or 0.0) - truth) / standard)


def test_a_set_point_that_comes_again_is_taken_together_and_told() -> None:
    set_points = (23.0, -40.0, 85.0, 23.0)
    bias = bias_at(np.array(set_points))
    bias[-1] += 20.0 * DPH
    reduction = reduced(recorded(bias), set_points=set_points)
    found = by_name(reduction.results)["bias_temperature_sensitivity"]
    assert found.value == pytest.approx((186.0 - 10.0) / 62.0, abs=1e-2)
    (remark,) = reduction.remarks
    assert remark.startswith("23 °C again: the bias differs by 20 °/h")
    table = reduction.figures[0].table
    assert table is not None
    assert [row[2].text for row in table.rows] == ["2", "1", "1"]


def test_the_figure_has_a_point_a_record_and_the_lines_of_slope_sensitivity_and_limit() -> None:
    limits = {"bias_temperature_sensitivity": Limit(max=Quantity(4.0, "deg/h/degC"))}
    context = soaking_context(case=soaking_case(limits=limits))
    samples = recorded(bias_at(np.array(SET_POINTS)))
    (figure,) = BiasTemperatureSensitivity().reduce(samples, context).figures
    (panel,) = figure.panels
    assert panel.points[0].x == tuple(sorted(SET_POINTS))
    roles = [one.role for one in panel.curves]
    assert (roles.count(Role.MODEL), roles.count(Role.GUIDE), roles.count(Role.LIMIT)) == (1, 2, 2)
    upper = next(one for one in panel.curves if one.role is Role.LIMIT)
    # 4 °/h/°C over 62 °C above the bias at room temperature
    assert upper.y[-1] - upper.y[1] == pytest.approx(4.0 * 62.0)
    assert figure.table is not None
    assert [row[0].text for row in figure.table.rows] == ["23", "−40", "0", "60", "85"]


def test_the_plan_soaks_at_each_set_point_and_at_the_room_first_and_last_where_it_is_not_among_them() -> (
    None
):
    case = soaking_case(parameters={"temperatures": ["-40 degC", "85 degC"], "soak": "1 h"})
    procedure = BiasTemperatureSensitivity()
    parameters = case_parameters(case, procedure)
    assert not list(procedure.complaints(case, parameters, static_context().output))
    plan = procedure.plan(case, parameters)
    assert [one.name for one in plan.steps] == ["23 °C", "-40 °C", "85 °C", "23 °C"]
    assert plan.steps[1].stimulus == Soaking(temperature_degc=-40.0, soak_s=3600.0, tolerance_c=0.5)
    assert (plan.samples, plan.soaks, plan.turns) == (1200, True, False)
    measured = procedure.measurands(case, parameters, static_context().output)
    assert {one.unit for one in measured} == {"deg/h/degC"}


@pytest.mark.parametrize(
    ("parameters", "changes", "key", "message"),
    [
        ({"temperatures": ["23 degC"]}, {}, "parameters.temperatures", "no temperature beside"),
        (
            {"temperatures": ["85 degC", "23.8 degC"]},
            {},
            "parameters.temperatures[1]",
            "at least 1 °C",
        ),
        ({"temperatures": ["85 degC"], "soak": "-1 min"}, {}, "parameters.soak", "less than zero"),
        (
            {"temperatures": ["85 degC"], "tolerance": "0 degC"},
            {},
            "parameters.tolerance",
            "not more than zero",
        ),
        (
            {"temperatures": ["85 degC"]},
            {"duration": Quantity(10.0, "s")},
            "duration",
            "16 are needed",
        ),
    ],
)
def test_a_case_that_cannot_measure_it_is_refused(
    parameters: dict[str, Any], changes: dict[str, Any], key: str, message: str
) -> None:
    case = soaking_case(parameters=parameters, **changes)
    procedure = BiasTemperatureSensitivity()
    found = dict(procedure.complaints(case, case_parameters(case, procedure), static_context().output))
    assert message in found[key]


def test_a_recording_without_temperatures_is_refused() -> None:
    bare = tuple(
        dataclasses.replace(one, temperature_degc=None, measured_temperature_degc=None)
        for one in dwells(SET_POINTS)
    )
    with pytest.raises(InsufficientDataError, match="no temperature was asked for"):
        reduced(recorded(bias_at(np.array(SET_POINTS))), dwells=bare)


def test_without_a_reading_the_set_points_serve_and_that_is_said() -> None:
    unread = tuple(
        dataclasses.replace(one, measured_temperature_degc=None) for one in dwells(SET_POINTS)
    )
    found = by_name(reduced(recorded(bias_at(np.array(SET_POINTS))), dwells=unread).results)
    assert "set points, not read back" in found["bias_temperature_sensitivity"].condition
