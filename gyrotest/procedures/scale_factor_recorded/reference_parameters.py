"""What a case with a reference recorded beside the output may be told."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, ClassVar

from gyrotest.analysis.reference_fit import FEWEST_SAMPLES
from gyrotest.procedures.case_plan import step_samples
from gyrotest.records.described import Described
from gyrotest.records.spec import Case
from gyrotest.units import Dimension, OfDimension, Quantity

_FEWEST_MADS = 3.0


class Outliers(StrEnum):
    """What becomes of samples far from the line."""

    KEEP = "keep"
    LEAVE_OUT = "leave_out"


@dataclass(frozen=True, slots=True, kw_only=True)
class ReferenceParameters:
    """Parameters of a `scale_factor_reference` case."""

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}

    reference: Annotated[
        str,
        Described(
            "the auxiliary channel with the reference rate, by its name in the station", "encoder"
        ),
    ] = "reference"
    reference_uncertainty: Annotated[
        Quantity | None,
        OfDimension(Dimension.NUMBER),
        Described(
            "how far the reference's own scale may be off: the half-width of a rectangular distribution",
            "0.05 %",
        ),
    ] = None
    reference_offset: Annotated[
        Quantity | None,
        OfDimension(Dimension.RATE),
        Described("how far the reference may be from 0 at rest: a half-width too", "0.01 deg/s"),
    ] = None
    leave_out: Annotated[int, Described("samples at the begin that do not count", "1")] = 0
    low_speed: Annotated[
        Quantity | None,
        OfDimension(Dimension.RATE),
        Described("samples with a slower reference do not count", "1 deg/s"),
    ] = None
    outliers: Annotated[
        Outliers, Described("whether samples far from the line count; they are told in any case")
    ] = Outliers.KEEP
    outlier_mads: Annotated[
        float, Described("how far that is, in median absolute deviations of the residuals", "15")
    ] = 15.0


def reference_complaints(case: Case, parameters: ReferenceParameters) -> Iterator[tuple[str, str]]:
    """Give what is wrong with a case beyond its types: key and message."""
    samples = step_samples(case)
    if not 0 <= parameters.leave_out <= samples - FEWEST_SAMPLES:
        yield (
            "parameters.leave_out" if samples >= FEWEST_SAMPLES else "duration",
            f"{samples} samples less {parameters.leave_out} are too few for a line;"
            f" {FEWEST_SAMPLES} are needed",
        )
    for name in ("low_speed", "reference_offset"):
        value: Quantity | None = getattr(parameters, name)
        if value is not None and value.value < 0.0:
            yield f"parameters.{name}", f"'{value}' is less than zero"
    share = parameters.reference_uncertainty
    if share is not None and not 0.0 <= share.to("") < 1.0:
        yield "parameters.reference_uncertainty", f"'{share}' is not from 0 % to below 100 %"
    if not parameters.outlier_mads >= _FEWEST_MADS:
        yield (
            "parameters.outlier_mads",
            f"{parameters.outlier_mads:g} would make outliers of good samples; {_FEWEST_MADS:g} at least",
        )
