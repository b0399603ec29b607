"""What a server of the block protocol answers to each command."""

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field, TypeAdapter

from gyrotest.records.bench import DaqChannel
from gyrotest.records.recording import Identity

_Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Configured:
    """To CONFIGURE: the rate that is had, the first channel's full scale, the analogue filter's cut-off."""

    rate_hz: _Positive
    full_scale: _Positive
    filter_hz: _Positive | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class _Armed:
    armed: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class _Stopped:
    stopped: bool


IDENTITY = TypeAdapter(Identity)
CHANNELS = TypeAdapter(tuple[DaqChannel, ...])
CONFIGURED = TypeAdapter(Configured)
ARMED = TypeAdapter(_Armed)
STOPPED = TypeAdapter(_Stopped)
