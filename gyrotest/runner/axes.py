"""A gyro of several axes, axis by axis: its samples, its results, its judgement."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from gyrotest.conformity import judge
from gyrotest.errors import GyrotestError
from gyrotest.ports import Reducing, StreamReducing
from gyrotest.recordings.reader import read_samples, stream_samples
from gyrotest.records.figure import Figure
from gyrotest.records.plan import Context, Plan, Reduction
from gyrotest.records.recording import Recording, Samples, SampleStream, Sampling
from gyrotest.records.result import JudgedResult, Result
from gyrotest.records.run import Attempt
from gyrotest.records.spec import Case, Output, Over
from gyrotest.runner.items import PlannedCase


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisReduction:
    """What a procedure made of one axis (no name: the only one)."""

    axis: str
    reduction: Reduction

    @property
    def figures(self) -> tuple[Figure, ...]:
        """The figures, which then say whose they are."""
        return tuple(replace(one, axis=self.axis) for one in self.reduction.figures)

    @property
    def remarks(self) -> tuple[str, ...]:
        """The remarks, which then say whose they are."""
        if not self.axis:
            return self.reduction.remarks
        return tuple(f"Axis {self.axis}: {text}" for text in self.reduction.remarks)


def axes_of(output: Output, case: Case) -> tuple[str, ...]:
    """The axes that a case judges; one without a name where the gyro has only one."""
    return case.axes or output.axes or ("",)


def axis_case(case: Case, axis: str) -> Case:
    """The case as it is for one axis: with its own mounting."""
    return replace(case, mounting=case.mountings.get(axis)) if case.mountings else case


def reduced(planned: PlannedCase, recording: Recording, path: Path, context: Context) -> Reduction:
    """Have a procedure reduce an axis's part of a recording: in one piece, or block by block."""
    procedure, sampling = planned.procedure, recording.header.sampling
    if isinstance(procedure, StreamReducing):
        return procedure.reduce_stream(axis_stream(path, sampling, context.axis, planned.plan), context)
    if not isinstance(procedure, Reducing):
        raise GyrotestError(
            f"procedure '{planned.case.procedure}': has neither 'reduce' nor 'reduce_stream'; give it one"
        )
    return procedure.reduce(axis_samples(path, sampling, context.axis, planned.plan), context)


def axis_samples(recording: Path, sampling: Sampling, axis: str, plan: Plan) -> Samples:
    """Read an axis's samples of a recording, and what the plan's reduction looks at beside it."""
    read = _axis_columns(sampling, axis, plan)
    return read_samples(recording, columns=read.columns, sampling=read.sampling)


def axis_stream(recording: Path, sampling: Sampling, axis: str, plan: Plan) -> SampleStream:
    """The same block by block."""
    read = _axis_columns(sampling, axis, plan)
    return stream_samples(recording, columns=read.columns, sampling=read.sampling)


@dataclass(frozen=True, slots=True, kw_only=True)
class _AxisColumns:
    """The places of the columns that are read, and how these are sampled."""

    columns: tuple[int, ...]
    sampling: Sampling


def _axis_columns(sampling: Sampling, axis: str, plan: Plan) -> _AxisColumns:
    """Choose an axis's column, and what the plan's reduction looks at beside it."""
    column = sampling.channels.index(axis) if axis else 0
    beside = {
        place: one
        for place, one in enumerate(sampling.auxiliary, start=len(sampling.channels))
        if one.name.startswith(plan.auxiliary) and not _of_another(one.name, axis, sampling)
    }
    columns, offsets = (column, *beside), sampling.offsets_s
    return _AxisColumns(
        columns=columns,
        sampling=replace(
            sampling,
            channels=(sampling.channels[column],),
            auxiliary=tuple(beside.values()),
            offsets_s=tuple(offsets[place] for place in columns) if offsets else (),
        ),
    )


def _of_another(name: str, axis: str, sampling: Sampling) -> bool:
    """Whether a channel beside the outputs belongs to another axis: `temperature_x` to x."""
    return any(name.endswith(f"_{other}") for other in sampling.channels if other != axis)


def axis_results(attempt: Attempt, axis: str) -> tuple[Result, ...]:
    """An axis's results of a judged attempt."""
    return tuple(_as_result(one) for one in attempt.results if one.axis == axis)


def judge_axes(
    planned: PlannedCase, repeat: int | None, over: Over | None, reductions: Sequence[AxisReduction]
) -> tuple[JudgedResult, ...]:
    """Judge each measurand of each axis: one that was not measured is judged as missing, never left out."""
    return tuple(judged for one in reductions for judged in _judge_axis(planned, repeat, over, one))


def _judge_axis(
    planned: PlannedCase, repeat: int | None, over: Over | None, axis: AxisReduction
) -> tuple[JudgedResult, ...]:
    measured: Mapping[str, Result] = {one.name: one for one in axis.reduction.results}
    limits = planned.case.limits
    return tuple(
        judge(
            one,
            measured.get(one.name),
            limits.get(one.name),
            case=planned.name,
            repeat=repeat,
            axis=axis.axis,
        )
        for one in planned.measured(over)
        if one.name in measured or one.name in limits
    )


def _as_result(judged: JudgedResult) -> Result:
    return Result(
        name=judged.name,
        label=judged.label,
        value=judged.value,
        unit=judged.unit,
        expanded_uncertainty=judged.expanded_uncertainty,
        coverage_factor=judged.coverage_factor,
        lower_95=judged.lower_95,
        upper_95=judged.upper_95,
        at_most=judged.at_most,
        at_least=judged.at_least,
        condition=judged.condition,
        budget=judged.budget,
        not_included=judged.not_included,
    )
