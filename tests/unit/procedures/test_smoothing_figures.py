"""The smoothed record side by side: one scale, one figure a smoothing time, nothing of too few averages."""

import numpy as np
import pytest
from numpy.typing import NDArray

from gyrotest.procedures.static import Static
from gyrotest.procedures.static.parameters import StaticParameters
from gyrotest.records.figure import Figure, Width
from gyrotest.records.plan import Context
from gyrotest.records.recording import Auxiliary, Samples, Sampling
from gyrotest.records.spec import Case, Output, OutputKind
from gyrotest.units import Quantity

RATE = np.random.default_rng(5).normal(0.2, 0.01, 3000)


def figures(*smoothing: str, beside: NDArray[np.float64] | None = None) -> list[Figure]:
    parameters = StaticParameters(smoothing=tuple(Quantity(float(one), "s") for one in smoothing))
    context = Context(
        case_name="rest",
        case=Case(procedure="static", duration=Quantity(3000.0, "s"), interval=Quantity(1.0, "s")),
        parameters=parameters,
        output=Output(kind=OutputKind.RATE),
        datasheet={},
        accuracy=None,
        site=None,
    )
    samples = Samples(
        sampling=Sampling(
            interval_s=1.0,
            aperture_s=1.0,
            unit="deg/s",
            auxiliary=() if beside is None else (Auxiliary(name="temperature", unit="degC"),),
        ),
        values=np.column_stack([RATE] if beside is None else [RATE, beside]),
        flags=np.zeros(RATE.size, dtype=np.uint8),
    )
    return list(Static().reduce(samples, context).figures)


def smoothed(*smoothing: str) -> list[Figure]:
    return [one for one in figures(*smoothing) if one.name.startswith("smoothed_")]


def test_three_smoothing_times_stand_abreast_on_one_scale() -> None:
    found = smoothed("1", "10", "100")
    assert [one.name for one in found] == ["smoothed_1s", "smoothed_10s", "smoothed_100s"]
    assert {one.width for one in found} == {Width.NARROW}
    (ends,) = {one.panels[0].y_range for one in found}
    assert ends is not None
    assert ends[0] < RATE.min() * 3600.0 < RATE.max() * 3600.0 < ends[1]


def test_the_averages_are_those_of_the_record() -> None:
    (last,) = [one for one in smoothed("1", "10", "100") if one.name == "smoothed_100s"]
    curve = last.panels[0].curves[0]
    np.testing.assert_allclose(curve.y, RATE.reshape(30, 100).mean(axis=1) * 3600.0)
    assert curve.x[0] == pytest.approx(50.0 / 60.0)


def test_each_says_its_standard_deviation() -> None:
    sigma = RATE.reshape(300, 10).mean(axis=1).std(ddof=1) * 3600.0
    assert f"σ = {sigma:.4g}" in smoothed("1", "10")[1].caption


def test_one_smoothing_time_has_nothing_to_stand_beside() -> None:
    assert smoothed("10") == []


def test_a_temperature_recorded_beside_stands_below_the_record() -> None:
    temperature = np.linspace(23.0, 29.0, RATE.size)
    temperature[100:110] = np.nan  # readings of a sensor may be missing
    (record,) = [one for one in figures("1", "10", beside=temperature) if one.name == "record"]
    panel = record.panels[-1]
    assert panel.y_label == "Temp. / °C"
    assert panel.curves[0].y[0] == pytest.approx(23.0, abs=0.02)
    assert panel.curves[0].y[-1] == pytest.approx(29.0, abs=0.02)
    assert "temperature, recorded beside" in record.caption
