"""A gyro of several axes: each one's samples, case and results by themselves."""

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from gyrotest.errors import RecordingError
from gyrotest.recordings.writer import RecordingWriter
from gyrotest.records.figure import Figure
from gyrotest.records.plan import Plan, Reduction, Step
from gyrotest.records.recording import Auxiliary, Block, Identity, RecordingHeader, Sampling
from gyrotest.records.spec import Case, Output, OutputKind
from gyrotest.runner.axes import AxisReduction, axes_of, axis_case, axis_samples, axis_stream
from gyrotest.units import Quantity

CASE = Case(
    procedure="static",
    duration=Quantity(10.0, "s"),
    interval=Quantity(1.0, "s"),
    mountings={"x": (0.0, 1.0, 0.0), "z": (1.0, 0.0, 0.0)},
)


def _recorded(folder: Path, *, beside: tuple[Auxiliary, ...] = ()) -> tuple[Path, Sampling]:
    """A recording of 5 samples: column after column counts on."""
    sampling = Sampling(
        interval_s=1.0, aperture_s=1.0, unit="deg/s", channels=("x", "y", "z"), auxiliary=beside
    )
    header = RecordingHeader(
        run_id="run",
        item="rest-1-r1",
        attempt=1,
        serial_number="1",
        model="TRIAD",
        spec_sha256="0" * 64,
        started_utc=datetime(2026, 1, 1, tzinfo=UTC),
        planned_samples=5,
        sampling=sampling,
        source=Identity(manufacturer="Maker", model="M1", serial_number="1"),
    )
    columns = len(sampling.columns)
    with RecordingWriter(folder, header) as writer:
        writer.push(
            Block(
                first=0,
                time_s=np.arange(5.0),
                values=np.arange(5.0 * columns).reshape(columns, 5).T,
                flags=np.zeros(5, dtype=np.uint8),
            )
        )
        recording = writer.close(complete=True)
    return folder / recording.path, sampling


def _plan(*auxiliary: str) -> Plan:
    return Plan(warm_up_s=0.0, interval_s=1.0, steps=(Step(samples=5),), auxiliary=auxiliary)


def test_an_axis_is_read_by_itself_side_by_side_in_memory(tmp_path: Path) -> None:
    found = axis_samples(*_recorded(tmp_path), "y", _plan())
    assert found.sampling.channels == ("y",)
    assert found.values[:, 0].flags.c_contiguous
    np.testing.assert_array_equal(found.values, np.arange(5.0, 10.0).reshape(5, 1))


@pytest.mark.parametrize(
    ("wanted", "columns"), [((), (2,)), (("temperature",), (2, 5)), (("encoder",), (2, 4))]
)
def test_what_is_recorded_beside_is_read_where_the_plan_asks_for_it(
    tmp_path: Path, wanted: tuple[str, ...], columns: tuple[int, ...]
) -> None:
    beside = tuple(
        Auxiliary(name=name, unit="degC") for name in ("temperature_x", "encoder", "temperature_z")
    )
    path, sampling = _recorded(tmp_path, beside=beside)
    found = axis_samples(path, sampling, "z", _plan(*wanted))
    assert found.sampling.columns == tuple(sampling.columns[one] for one in columns)
    np.testing.assert_array_equal(found.values, np.arange(30.0).reshape(6, 5).T[:, list(columns)])


def test_a_record_read_block_by_block_is_the_same_each_time(tmp_path: Path) -> None:
    path, sampling = _recorded(tmp_path, beside=(Auxiliary(name="encoder_sine", unit="V"),))
    whole = axis_samples(path, sampling, "y", _plan("encoder_"))
    stream = axis_stream(path, sampling, "y", _plan("encoder_"))
    assert (stream.samples, stream.sampling) == (5, whole.sampling)
    for _ in range(2):
        blocks = list(stream.blocks())
        np.testing.assert_array_equal(np.concatenate([one.values for one in blocks]), whole.values)
        np.testing.assert_array_equal(
            np.concatenate([one.index for one in blocks if one.index is not None]), np.arange(5)
        )


def test_damage_of_a_record_read_block_by_block_is_found(tmp_path: Path) -> None:
    path, sampling = _recorded(tmp_path)
    stream = axis_stream(path, sampling, "x", _plan())
    content = path.read_bytes()
    path.write_bytes(content.replace(np.arange(5.0).tobytes(), np.arange(1.0, 6.0).tobytes()))
    if path.read_bytes() == content:
        path.write_bytes(content.replace(b'"rows": 5', b'"rows": 6'))
    with pytest.raises(RecordingError):
        list(stream.blocks())


def test_damage_of_a_part_that_is_read_is_found(tmp_path: Path) -> None:
    path, sampling = _recorded(tmp_path)
    damaged = path.read_bytes().replace(b'"rows": 5', b'"rows": 6')
    path.write_bytes(damaged)
    with pytest.raises(RecordingError):
        axis_samples(path, sampling, "x", _plan())


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
