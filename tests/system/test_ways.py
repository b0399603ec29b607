"""Every way to a meter ends in the same certificate: the wire is no part of the measurement."""

import os
from pathlib import Path

import pytest

from gyrotest.records.result import Verdict

from .short import only_attempt, short_run

PTY = pytest.mark.skipif(not hasattr(os, "openpty"), reason="no pseudo-terminals on this platform")
WAYS = [
    ("34401A", "tcp"),
    ("34401A", "prologix"),
    pytest.param("34401A", "pty", marks=PTY),
    pytest.param("34401A", "prologix-pty", marks=PTY),
    ("34465A", "tcp"),
    ("34465A", "prologix"),
]


@pytest.fixture(scope="module")
def by_tcp(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, float]]:
    return {
        model: _values(tmp_path_factory.mktemp("tcp"), model, "tcp") for model in ("34401A", "34465A")
    }


def _values(folder: Path, model: str, way: str) -> dict[str, float]:
    record = short_run(folder, model, way)
    assert record.verdict is Verdict.PASS
    assert record.simulated
    attempt = only_attempt(record)
    assert attempt.recording is not None
    assert attempt.recording.samples == 180
    assert attempt.recording.gaps == ()
    assert attempt.events == ()
    (use,) = attempt.instruments
    assert use.identity.model == model
    return {one.name: one.value for one in attempt.results if one.value is not None}


@pytest.mark.parametrize(("model", "way"), WAYS)
def test_a_run_passes_with_the_same_values_whatever_the_wire(
    tmp_path: Path, by_tcp: dict[str, dict[str, float]], model: str, way: str
) -> None:
    assert _values(tmp_path, model, way) == pytest.approx(by_tcp[model], rel=1e-9)


def test_both_meters_find_the_same_unit(by_tcp: dict[str, dict[str, float]]) -> None:
    """The same gyro noise, but other readings of it: another resolution and another spacing."""
    one, other = by_tcp["34401A"], by_tcp["34465A"]
    assert one.keys() == other.keys()
    assert one["bias"] == pytest.approx(other["bias"], abs=0.001)
    for name in ("bias_stability_1s", "angle_random_walk"):
        assert one[name] == pytest.approx(other[name], rel=0.1)
        assert one[name] != other[name]
