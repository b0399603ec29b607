"""What stations say of all synchronous sources alike: when they start, and what lies between their channels."""

import math
from collections.abc import Mapping
from enum import StrEnum

from gyrotest.units import Quantity


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
