"""Sweeps of a scanner turned into samples, and what may be wrong with one."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InstrumentError, InstrumentProtocolError, OverloadError
from gyrotest.instruments import scpi
from gyrotest.instruments.scanner_commands import Scan
from gyrotest.instruments.scanner_readings import Sweeps

# A sweep further than this from its place on the timer's grid is another sweep.
_OFF_GRID = 0.25


@dataclass(frozen=True, slots=True, kw_only=True)
class Trouble:
    """What is wrong with the sample at a place in a block."""

    at: int
    error: InstrumentError


@dataclass(frozen=True, slots=True, kw_only=True)
class ScanSamples:
    """Samples (n, columns) with the flags of each column, and the times (n,) of the first column, s."""

    values: NDArray[np.float64]
    flags: NDArray[np.uint8]
    times_s: NDArray[np.float64]


def samples_of(sweeps: Sweeps, scan: Scan) -> ScanSamples:
    """The columns in the order in which they were chosen, voltages beside the output scaled."""
    pairs = [scpi.samples_of(sweeps.values[:, place], 1) for place in scan.places]
    values = np.column_stack([values for values, _ in pairs])
    for column, channel in enumerate(scan.auxiliary, start=len(scan.outputs)):
        beside = scan.settings.at(channel)
        if not beside.is_temperature:
            values[:, column] = beside.at_zero_volt + beside.per_volt * values[:, column]
    return ScanSamples(
        values=values,
        flags=np.column_stack([flags for _, flags in pairs]),
        times_s=sweeps.times_s[:, scan.places[0]],
    )


def first_trouble(
    samples: ScanSamples, scan: Scan, *, due_s: NDArray[np.float64], interval_s: float, who: str
) -> Trouble | None:
    """The first sample that was not taken when it was due (n,), or that lacks what stands beside."""
    found = (_off_grid(samples.times_s, due_s, interval_s, who), _open_probe(samples.flags, scan, who))
    return min((one for one in found if one is not None), key=lambda one: one.at, default=None)


def _off_grid(
    times_s: NDArray[np.float64], due_s: NDArray[np.float64], interval_s: float, who: str
) -> Trouble | None:
    late_s = times_s - due_s
    off = np.flatnonzero(np.abs(late_s) > _OFF_GRID * interval_s)
    if not off.size:
        return None
    at = int(off[0])
    error = InstrumentProtocolError(
        f"{who}: a sample was taken {late_s[at]:.3g} s from when it was due; sweeps are missing, or longer"
        f" than the interval of {interval_s:g} s"
    )
    return Trouble(at=at, error=error)


def _open_probe(flags: NDArray[np.uint8], scan: Scan, who: str) -> Trouble | None:
    bad = np.argwhere(flags[:, len(scan.outputs) :])
    if not len(bad):
        return None
    channel = scan.auxiliary[int(bad[0, 1])]
    error = OverloadError(
        f"{who}: overload on channel {channel} ({scan.settings.at(channel).function});"
        " is the probe connected, or broken?"
    )
    return Trouble(at=int(bad[0, 0]), error=error)
