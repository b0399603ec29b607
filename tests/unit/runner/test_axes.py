"""A gyro of several axes: each one's samples, case and results by themselves."""

import numpy as np
import pytest

from gyrotest.records.figure import Figure
from gyrotest.records.plan import Reduction
from gyrotest.records.recording import Auxiliary, Samples, Sampling
from gyrotest.records.spec import Case, Output, OutputKind
from gyrotest.runner.axes import AxisReduction, axes_of, axis_case, axis_samples
from gyrotest.units import Quantity

CASE = Case(
    procedure="static",
    duration=Quantity(10.0, "s"),
    interval=Quantity(1.0, "s"),
    mountings={"x": (0.0, 1.0, 0.0), "z": (1.0, 0.0, 0.0)},
)


def _samples(*, beside: tuple[Auxiliary, ...] = ()) -> Samples:
    columns = 3 + len(beside)
    values = np.asfortranarray(np.arange(5.0 * columns).reshape(5, columns))
    sampling = Sampling(
        interval_s=1.0, aperture_s=1.0, unit="deg/s", channels=("x", "y", "z"), auxiliary=beside
    )
    return Samples(sampling=sampling, values=values, flags=np.zeros(5, dtype=np.uint8))


def test_an_axis_is_a_view_of_its_own_contiguous_column() -> None:
    samples = _samples()
    found = axis_samples(samples, "y")
    assert found.sampling.channels == ("y",)
    assert np.shares_memory(found.values, samples.values)
    assert found.values[:, 0].flags.c_contiguous
    np.testing.assert_array_equal(found.values[:, 0], samples.values[:, 1])


def test_what_is_recorded_beside_goes_with_every_axis() -> None:
    samples = _samples(beside=(Auxiliary(name="temperature", unit="degC"),))
    found = axis_samples(samples, "z")
    assert found.sampling.columns == ("z", "temperature")
    np.testing.assert_array_equal(found.values, samples.values[:, [2, 3]])


def test_a_single_axis_is_taken_as_it_is() -> None:
    samples = Samples(
        sampling=Sampling(interval_s=1.0, aperture_s=1.0),
        values=np.zeros((3, 1)),
        flags=np.zeros(3, dtype=np.uint8),
    )
    assert axis_samples(samples, "") is samples


@pytest.mark.parametrize(("axis", "mounting"), [("x", (0.0, 1.0, 0.0)), ("y", None)])
def test_an_axis_has_its_own_mounting(axis: str, mounting: tuple[float, float, float] | None) -> None:
    assert axis_case(CASE, axis).mounting == mounting


def test_a_case_judges_its_own_axes_or_all_of_the_output() -> None:
    output = Output(kind=OutputKind.RATE, axes=("x", "y", "z"))
    assert axes_of(output, CASE) == ("x", "y", "z")
    assert axes_of(Output(kind=OutputKind.RATE), CASE) == ("",)


def test_figures_and_remarks_say_whose_they_are() -> None:
    figure = Figure(name="record", title="Rate record", panels=())
    found = AxisReduction(
        axis="x", reduction=Reduction(results=(), figures=(figure,), remarks=("it drifts.",))
    )
    assert [one.axis for one in found.figures] == ["x"]
    assert found.remarks == ("Axis x: it drifts.",)
