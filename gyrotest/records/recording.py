"""What an acquisition yields: sampling, blocks of samples, and the closed recording."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from datetime import datetime
from enum import IntFlag

import numpy as np
from numpy.typing import NDArray

ENCODER = "encoder_"
"""How the names of an encoder's columns begin: what a plan asks for beside the output."""
ENCODER_ANGLE, ENCODER_SINE, ENCODER_COSINE = "encoder_angle", "encoder_sine", "encoder_cosine"


class SampleFlag(IntFlag):
    """What is wrong with a sample; 0 is a good one."""

    GOOD = 0
    OVERLOAD = 1
    NOT_A_NUMBER = 2
    START_UP = 4
    FAULT = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class Identity:
    """Who answered at an address (the four fields of `*IDN?`, or what stands for them)."""

    manufacturer: str
    model: str
    serial_number: str
    firmware: str = ""

    @property
    def simulated(self) -> bool:
        """Whether this is a simulated instrument: its serial number says so."""
        return self.serial_number.upper().startswith("SIM")

    @property
    def replayed(self) -> bool:
        """Whether this is a recorded file that stands in for an instrument."""
        return self.serial_number.startswith("REPLAY-")


@dataclass(frozen=True, slots=True, kw_only=True)
class Auxiliary:
    """What is recorded beside the gyro's output: a temperature, a reference rate."""

    name: str
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Sampling:
    """How a source really samples, read back from it.

    `interval_s` between two samples; each sample is the mean of `readings` readings, every one of
    which integrates for `aperture_s`. `readings == 1` and `aperture_s == interval_s` is gap-free.
    `channels` are the outputs, all in `unit`; for a gyro of several axes they bear the axes' names.
    `auxiliary` follows them. `offsets_s` is how much later than the first column each one is sampled
    (empty: all at once). `noise` is the source's own rms noise of one sample and `range` its range,
    both in `unit`; None where not known. `synchronous`: one hardware clock takes all columns, and
    `offsets_s` are all there is between them, to within `skew_uncertainty_s` (a half-width; None: not
    stated). `filter_hz` is the cut-off of the analogue low-pass in front of it (None: not stated).
    """

    interval_s: float
    aperture_s: float
    readings: int = 1
    unit: str = "V"
    channels: tuple[str, ...] = ("output",)
    auxiliary: tuple[Auxiliary, ...] = ()
    offsets_s: tuple[float, ...] = ()
    noise: float | None = None
    range: float | None = None
    synchronous: bool = False
    skew_uncertainty_s: float | None = None
    filter_hz: float | None = None

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of all columns: outputs, then auxiliaries."""
        return (*self.channels, *(one.name for one in self.auxiliary))

    @property
    def effective_aperture_s(self) -> float:
        """Time in each interval during which the signal is integrated, s."""
        return min(self.readings * self.aperture_s, self.interval_s)

    @property
    def duty(self) -> float:
        """Effective aperture over interval, 0 … 1."""
        return self.effective_aperture_s / self.interval_s


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """Consecutive samples of a source.

    `first` is the position of the first sample on the acquisition's grid (0-based); a jump between
    blocks is a gap. `time_s` (n,) is the begin of each sample on the monotonic clock in seconds
    since the acquisition's start; `values` (n, columns) in `Sampling.unit`, auxiliaries in their own;
    `flags` (n,) `SampleFlag` as uint8.
    """

    first: int
    time_s: NDArray[np.float64]
    values: NDArray[np.float64]
    flags: NDArray[np.uint8]


@dataclass(frozen=True, slots=True, kw_only=True)
class Gap:
    """Samples that are missing from a recording: `missing` of them after sample `after`."""

    after: int
    missing: int
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Dwell:
    """A step of a plan as it was carried out.

    Its samples have the positions `first` … `first + samples - 1` and began `began_s` after the
    recording did, `settling_s` after the stimulus was asked for. `rate_dps` and `temperature_degc`
    are what was asked for, the measured ones means of what the instrument read back (None: no such
    stimulus, or nothing read back). `vibration_dps` is the root mean square of the rate that a vibration
    table was asked for, `frequency_hz` that of a sine, `band_hz` the lowest and the highest one of a
    random or swept vibration.
    """

    name: str
    first: int
    samples: int
    began_s: float
    settling_s: float = 0.0
    rate_dps: float | None = None
    measured_rate_dps: float | None = None
    temperature_degc: float | None = None
    measured_temperature_degc: float | None = None
    position_deg: float | None = None
    measured_position_deg: float | None = None
    vibration_dps: float | None = None
    frequency_hz: float | None = None
    band_hz: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingHeader:
    """What is known before the first sample, kept inside the recording.

    `since_power_on_s` is the time from power-on to the first sample; None where not known.
    """

    run_id: str
    item: str
    attempt: int
    serial_number: str
    model: str
    spec_sha256: str
    started_utc: datetime
    planned_samples: int
    sampling: Sampling
    source: Identity
    since_power_on_s: float | None = None
    meta: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """A recording on disk. `path` is relative to the run's folder, with forward slashes."""

    path: str
    sha256: str | None
    header: RecordingHeader
    samples: int
    complete: bool
    gaps: tuple[Gap, ...] = ()
    dwells: tuple[Dwell, ...] = ()
    flagged: int = 0
    largest_lateness_s: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Samples:
    """A recording's samples in memory, as a procedure's `reduce` gets them.

    `values` (n, columns), each column contiguous, `index` (n,) positions on the grid; both read-only.
    `time_s` (n,) only where the source's own time stamps count (a replayed file with a time column).
    """

    sampling: Sampling
    values: NDArray[np.float64]
    flags: NDArray[np.uint8]
    index: NDArray[np.int64] | None = None
    time_s: NDArray[np.float64] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class SampleStream:
    """A recording's samples block by block, where a procedure does not want them all in memory.

    `blocks()` begins anew each time it is called; every block is a `Samples` with its `index`.
    """

    sampling: Sampling
    samples: int
    blocks: Callable[[], Iterator[Samples]]
