"""Steps that are no noise."""

import numpy as np
import pytest

from gyrotest.offline.leaps import largest_leap
from tests.unit.offline.records import rates


@pytest.mark.parametrize("at", [1, 700, 65_536, 65_537, 199_999])
def test_a_spike_is_found_where_it_is(at: int) -> None:
    record = rates(200_000)
    record[at] += 10.0
    found = largest_leap(record)
    assert found is not None
    assert found.at in (at, at + 1)
    assert found.size == pytest.approx(10.0, rel=0.01)
    assert found.times_usual > 500.0


def test_a_step_is_found() -> None:
    record = rates(5000)
    record[2000:] += 5.0
    found = largest_leap(record)
    assert found is not None
    assert found.at == 2000


@pytest.mark.parametrize("seed", range(5))
def test_noise_a_drift_and_rounding_do_not_leap(seed: int) -> None:
    record = rates(300_000, seed=seed)
    assert largest_leap(record) is None
    assert largest_leap(record + np.linspace(0.0, 50.0, record.size)) is None
    assert largest_leap(np.round(record, 2)) is None
    assert largest_leap(np.round(record, 0) + (np.arange(record.size) == 5)) is None


def test_the_shortest_record_has_a_usual_step() -> None:
    assert largest_leap(rates(36)) is None
