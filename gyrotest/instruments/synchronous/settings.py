"""What stations say of all synchronous sources alike: when they start, and what lies between their channels."""

import math
from collections.abc import Mapping
from enum import StrEnum
from typing import Annotated

from gyrotest.records.described import Described
from gyrotest.units import Dimension, OfDimension, Quantity

TRIGGER_TIMEOUT = Quantity(10.0, "s")
TriggerTimeout = Annotated[
    Quantity,
    OfDimension(Dimension.TIME),
    Described("How long an external trigger is waited for.", "30 s"),
]
Skews = Annotated[
    Mapping[str, Annotated[Quantity, OfDimension(Dimension.TIME)]],
    Described(
        "How much later than the source's own instant a channel is sampled, in place of what it says.",
        "{ua: 28 us, ub: 56 us}",
    ),
]
SkewUncertainty = Annotated[
    Quantity | None,
    OfDimension(Dimension.TIME),
    Described("Half-width of the error of the times between the channels.", "0.1 us"),
]


class Trigger(StrEnum):
    """What makes a source begin."""

    IMMEDIATE = "immediate"
    EXTERNAL = "external"


def check_synchronous(
    *,
    trigger_timeout: Quantity,
    skew: Mapping[str, Quantity],
    skew_uncertainty: Quantity | None,
    filter_cut_off: Quantity | None,
) -> None:
    """Refuse figures that cannot be; raises `ValueError`."""
    for name, value in (("trigger_timeout", trigger_timeout), ("filter", filter_cut_off)):
        if value is not None and not value.value > 0.0:
            raise ValueError(f"{name} {value} is not more than zero")
    if skew_uncertainty is not None and skew_uncertainty.value < 0.0:
        raise ValueError(f"skew_uncertainty {skew_uncertainty} is a half-width and cannot be negative")
    for name, value in skew.items():
        if not math.isfinite(value.value):
            raise ValueError(f"skew of '{name}' is {value}; write e.g. '28 us'")


def seconds(skew: Mapping[str, Quantity]) -> dict[str, float]:
    """The skews in seconds."""
    return {name: one.to("s") for name, one in skew.items()}
