"""Steps on a rate table: what cases of several procedures may be told of them, and what they refuse."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from gyrotest.analysis.resolution import digital_step, mean_half_width
from gyrotest.analysis.step_noise import SHORTEST_STEP
from gyrotest.procedures.case_plan import step_samples
from gyrotest.procedures.dwells import DwellRecord
from gyrotest.procedures.outlier_rule import OutlierRule
from gyrotest.procedures.scaling import nominal_complaints
from gyrotest.records.described import Described
from gyrotest.records.plan import Context, Step, Turning
from gyrotest.records.spec import Case, Output
from gyrotest.units import Dimension, OfDimension, Quantity

_SETTLE = Quantity(2.0, "s")
_TOLERANCE = Quantity(0.05, "deg/s")
_FEWEST_MADS = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class TableParameters:
    """How every step on the table is settled, and which of its samples count.

    Procedures add their own: in a spec the keys stand side by side.
    """

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}

    settle: Annotated[
        Quantity,
        OfDimension(Dimension.TIME),
        Described("time for which the table has held its rate before the first sample", "2 s"),
    ] = _SETTLE
    tolerance: Annotated[
        Quantity,
        OfDimension(Dimension.RATE),
        Described("how far the table's read-back may be from the rate asked for", "0.05 deg/s"),
    ] = _TOLERANCE
    window: Annotated[
        Quantity | None,
        OfDimension(Dimension.NUMBER, Dimension.RATE),
        Described(
            "samples farther from the step's rate are outliers, in proportion to it or as a rate;"
            " without it those far from the median are",
            "10 %",
        ),
    ] = None
    outlier_mads: Annotated[
        float,
        Described("so many median absolute deviations from the median a sample is an outlier", "7.5"),
    ] = 7.5

    @property
    def rule(self) -> OutlierRule:
        """Which samples count."""
        return OutlierRule(window=self.window, mads=self.outlier_mads)

    def step(self, name: str, rate_dps: float, samples: int, *, may_saturate: bool = False) -> Step:
        """Return a step at a rate."""
        turning = Turning(
            rate_dps=rate_dps,
            settle_s=self.settle.to("s"),
            tolerance_dps=self.tolerance.to("deg/s"),
        )
        return Step(samples=samples, name=name, stimulus=turning, may_saturate=may_saturate)


def table_complaints(
    case: Case, parameters: TableParameters, output: Output
) -> Iterator[tuple[str, str]]:
    """Give what is wrong with a case on a rate table, whatever it measures: key and message."""
    yield from nominal_complaints(output)
    axes = case.axes or output.axes
    if len(axes) > 1:
        message = f"names {len(axes)} axes, and the table turns about one; name that, e.g. [{axes[-1]}]"
        yield "axes", message
    samples = step_samples(case)
    if samples < SHORTEST_STEP:
        shortest = SHORTEST_STEP * case.interval.to("s")
        message = (
            f"{samples} samples a step are too few for its mean's uncertainty; at least {shortest:g} s"
        )
        yield "duration", message
    if parameters.settle.value < 0:
        yield "parameters.settle", f"'{parameters.settle}' is less than zero"
    for name, value in (("tolerance", parameters.tolerance), ("window", parameters.window)):
        if value is not None and value.value <= 0:
            yield f"parameters.{name}", f"'{value}' is not more than zero"
    if not parameters.outlier_mads >= _FEWEST_MADS:
        message = (
            f"{parameters.outlier_mads:g} would drop samples of ordinary noise; at least 3, e.g. 7.5"
        )
        yield "parameters.outlier_mads", message


def missing_of_table(context: Context) -> tuple[str, ...]:
    """Give what could not be had of the rate table's accuracy."""
    if context.table is None:
        return ("accuracy of the rate table",)
    if context.table.of_setting is None:
        return ("own error of each setting of the rate table",)
    return ()


def rounding_covariance(means: tuple[DwellRecord, ...]) -> NDArray[np.float64]:
    """Return what the steps of a digitised output add to the covariance of the means."""
    return np.diag([_half_step(one) ** 2 / 3.0 for one in means])


def _half_step(record: DwellRecord) -> float:
    step = digital_step(record.output)
    return 0.0 if step is None else mean_half_width(step, float(record.output.std(ddof=1)))
