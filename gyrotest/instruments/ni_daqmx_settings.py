"""What a station says of an NI data-acquisition device."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
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

_RANGE = Quantity(10.0, "V")
_TERMINAL = re.compile(r"[A-Za-z0-9_]+")
_Voltage = Annotated[Quantity, OfDimension(Dimension.VOLTAGE)]


class Wiring(StrEnum):
    """How a channel's signal is connected."""

    DEFAULT = "default"
    DIFFERENTIAL = "differential"
    PSEUDODIFFERENTIAL = "pseudodifferential"
    RSE = "rse"
    NRSE = "nrse"


class Coupling(StrEnum):
    """Whether a channel's mean is measured too."""

    AC = "ac"
    DC = "dc"


@dataclass(frozen=True, slots=True, kw_only=True)
class NiDaqmxSettings:
    """Its channels, how they are wired, and when it starts."""

    __pydantic_config__: ClassVar[Mapping[str, Any]] = {"extra": "forbid", "strict": True}

    terminals: Annotated[
        Mapping[str, str],
        Described("The analogue input of each channel.", "{gyro: ai0, ua: ai1, ub: ai2}"),
    ]
    range: Annotated[
        Quantity,
        OfDimension(Dimension.VOLTAGE),
        Described("Greatest voltage of either sign; the device takes its next wider range.", "10 V"),
    ] = _RANGE
    ranges: Annotated[
        Mapping[str, _Voltage],
        Described("The same of single channels, where it is another.", "{ua: 1 V, ub: 1 V}"),
    ] = field(default_factory=dict)
    wiring: Annotated[Wiring, Described("How the signals are connected.", "differential")] = (
        Wiring.DEFAULT
    )
    coupling: Annotated[Coupling | None, Described("`dc` or `ac`, of a device that has both.", "dc")] = (
        None
    )
    trigger: Annotated[
        Trigger,
        Described("What starts an acquisition: `immediate`, or `external`: a rising edge.", "external"),
    ] = Trigger.IMMEDIATE
    trigger_terminal: Annotated[str, Described("Where that edge comes in.", "PFI1")] = "PFI0"
    trigger_timeout: TriggerTimeout = TRIGGER_TIMEOUT
    skew: Skews = field(default_factory=dict)
    skew_uncertainty: SkewUncertainty = None
    filter: Annotated[
        Quantity | None,
        OfDimension(Dimension.FREQUENCY),
        Described("Cut-off of the analogue low-pass in front of the converter.", "4 kHz"),
    ] = None

    def __post_init__(self) -> None:
        check_synchronous(
            trigger_timeout=self.trigger_timeout,
            skew=self.skew,
            skew_uncertainty=self.skew_uncertainty,
            filter_cut_off=self.filter,
        )
        self._check_terminals()
        for name, value in (("range", self.range), *self.ranges.items()):
            if not value.value > 0.0:
                raise ValueError(f"range {value} of '{name}' is not more than zero; write e.g. '10 V'")

    def range_v(self, channel: str) -> float:
        """A channel's greatest voltage."""
        return self.ranges.get(channel, self.range).to("V")

    def _check_terminals(self) -> None:
        if not self.terminals:
            raise ValueError("terminals is empty: name the channels, e.g. {gyro: ai0, ua: ai1, ub: ai2}")
        for terminal in (*self.terminals.values(), self.trigger_terminal):
            if not _TERMINAL.fullmatch(terminal):
                raise ValueError(f"'{terminal}' is no terminal; write it without the device, e.g. ai0")
        if len(set(self.terminals.values())) < len(self.terminals):
            raise ValueError("terminals names one of them twice")
        for name in (*self.ranges, *self.skew):
            if name not in self.terminals:
                raise ValueError(
                    f"'{name}' is none of the terminals' names: {', '.join(self.terminals)}"
                )
