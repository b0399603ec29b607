"""Headers and blocks for the tests of recordings."""

from collections.abc import Callable
from datetime import UTC, datetime

import numpy as np
import pytest

from gyrotest.records.recording import Block, Identity, RecordingHeader, Sampling


@pytest.fixture
def header() -> RecordingHeader:
    return RecordingHeader(
        run_id="20260101T000000Z",
        item="static-1234-r1",
        attempt=1,
        serial_number="1234",
        model="MEMS50",
        spec_sha256="0" * 64,
        started_utc=datetime(2026, 1, 1, tzinfo=UTC),
        planned_samples=100,
        sampling=Sampling(interval_s=0.5, aperture_s=0.1, readings=2, noise=1e-6),
        source=Identity(manufacturer="HP", model="34401A", serial_number="0", firmware="11-5-2"),
        meta={"order": "Ä-17"},
    )


@pytest.fixture
def block() -> Callable[[int, int], Block]:
    def make(first: int, count: int) -> Block:
        index = np.arange(first, first + count)
        return Block(
            first=first,
            time_s=index * 0.5 + 0.001,
            values=np.sin(index)[:, None],
            flags=(index % 7 == 0).astype(np.uint8),
        )

    return make


@pytest.fixture
def ticking() -> Callable[[], float]:
    """A clock that goes on by a second whenever it is read: every block is written at once."""
    ticks = iter(range(10_000_000))
    return lambda: float(next(ticks))
