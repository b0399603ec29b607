"""Rates made for these tests, and their analyses."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gyrotest.offline.analysis import Analysis, analysed
from gyrotest.offline.record import RateRecord
from gyrotest.offline.sources import Source
from gyrotest.units import Quantity

DPH = 1.0 / 3600.0
RATE_HZ = 10.0


def rates(samples: int = 6000, *, walk_dph: float = 0.5, seed: int = 1) -> NDArray[np.float64]:
    """White noise of 10 °/h at 1 s about 0.02 °/s, and a walk."""
    generator = np.random.default_rng(seed)
    white = generator.standard_normal(samples) * 10.0 * DPH * np.sqrt(RATE_HZ)
    walk = np.cumsum(generator.standard_normal(samples)) * walk_dph * DPH / np.sqrt(RATE_HZ)
    return 0.02 + white + walk


def analysis(
    name: str = "rest.npy",
    column: str = "",
    *,
    reading_s: float = 0.1,
    bandwidth_hz: float | None = None,
    datasheet: dict[str, Quantity] | None = None,
    seed: int = 1,
    rate_dps: NDArray[np.float64] | None = None,
) -> Analysis:
    record = RateRecord(
        source=Source(path=Path(name), array=None, column=column or None, name=column),
        rate_dps=rates(seed=seed) if rate_dps is None else rate_dps,
        interval_s=1.0 / RATE_HZ,
        begin_s=0.0,
        reading_s=reading_s,
        readings=1,
        remarks=(),
    )
    return analysed(record, bandwidth_hz=bandwidth_hz, datasheet=datasheet or {})
