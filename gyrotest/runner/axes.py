"""A gyro of several axes, axis by axis: its samples, its results, its judgement."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gyrotest.conformity import judge
from gyrotest.records.figure import Figure
from gyrotest.records.plan import Reduction
from gyrotest.records.recording import Samples
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


def axis_samples(samples: Samples, axis: str) -> Samples:
    """An axis's samples, what was recorded beside behind them; without a copy where there is nothing."""
    sampling = samples.sampling
    if not axis and len(sampling.channels) == 1:
        return samples
    column = sampling.channels.index(axis)
    beside = range(len(sampling.channels), len(sampling.columns))
    offsets = sampling.offsets_s
    values = samples.values[:, column : column + 1]
    if beside:
        values = np.asfortranarray(samples.values[:, [column, *beside]])
        values.flags.writeable = False
    return replace(
        samples,
        values=values,
        sampling=replace(
            sampling,
            channels=(axis,),
            offsets_s=tuple(offsets[one] for one in (column, *beside)) if offsets else (),
        ),
    )


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
        condition=judged.condition,
        budget=judged.budget,
        not_included=judged.not_included,
    )
