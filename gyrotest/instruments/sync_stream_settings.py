"""What a station says of a source that speaks the block protocol."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar

from gyrotest.instruments.synchronous.settings import (
    TRIGGER_TIMEOUT,
    Skews,
    SkewUncertainty,
    Trigger,
    TriggerTimeout,
    check_synchronous,
)
from gyrotest.records.described import Described
from gyrotest.units import Dimension, OfDimension, Quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class SyncStreamSettings:
    """When it starts, and what is known of its channels beside what it says itself."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    trigger: Annotated[
        Trigger,
        Described("What starts an acquisition: `immediate`, or `external`: an edge.", "external"),
    ] = Trigger.IMMEDIATE
    trigger_timeout: TriggerTimeout = TRIGGER_TIMEOUT
    skew: Skews = field(default_factory=dict)
    skew_uncertainty: SkewUncertainty = None
    filter: Annotated[
        Quantity | None,
        OfDimension(Dimension.FREQUENCY),
        Described(
            "Cut-off of the analogue low-pass in front of the converter, where it does not say.", "4 kHz"
        ),
    ] = None

    def __post_init__(self) -> None:
        check_synchronous(
            trigger_timeout=self.trigger_timeout,
            skew=self.skew,
            skew_uncertainty=self.skew_uncertainty,
            filter_cut_off=self.filter,
        )
