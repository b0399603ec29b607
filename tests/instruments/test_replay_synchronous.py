"""A file with several columns stands in for a synchronous source."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gyrotest.clock import RealClock
from gyrotest.errors import InstrumentError
from gyrotest.instruments.replay import Replay
from gyrotest.instruments.replay_settings import AuxiliaryColumn, ReplaySettings
from gyrotest.ports import SyncDaq
from gyrotest.records.bench import DaqChannel
from gyrotest.records.recording import Auxiliary, Sampling
from gyrotest.units import Quantity

KHZ = Quantity(1.0, "kHz")
GRATING = {
    "columns": {"gyro": "gz"},
    "auxiliary": {
        "ua": AuxiliaryColumn(column="a", unit="mV"),
        "ub": AuxiliaryColumn(column="b", unit="mV"),
    },
    "unit": "deg/s",
    "sample_rate": KHZ,
}


def _csv(path: Path, names: str = "t,gz,a,b", time_s: Any = None) -> Path:
    stamps = np.arange(100) * 1e-3 if time_s is None else time_s
    rows = np.column_stack((stamps, np.arange(300.0).reshape(100, 3)))
    np.savetxt(path, rows, delimiter=",", header=names, comments="", fmt="%.9f")
    return path


def _opened(path: Path, **settings: Any) -> Replay:
    source = Replay(str(path), ReplaySettings(**settings), clock=RealClock())
    source.open()
    return source


def _sampling(path: Path, **settings: Any) -> Sampling:
    source = _opened(path, **settings)
    source.select(("gyro",), ("ua", "ub"))
    return source.configure(1e-3)


def test_its_rows_are_one_instant_each(tmp_path: Path) -> None:
    sampling = _sampling(
        _csv(tmp_path / "a.csv"),
        **GRATING,
        skew={"ua": Quantity(28.0, "us"), "ub": Quantity(56.0, "us")},
        skew_uncertainty=Quantity(0.1, "us"),
        filter=Quantity(4.0, "kHz"),
    )
    assert sampling.synchronous
    assert sampling.offsets_s == pytest.approx((0.0, 28e-6, 56e-6))
    assert sampling.skew_uncertainty_s == pytest.approx(1e-7)
    assert sampling.filter_hz == pytest.approx(4000.0)
    assert sampling.auxiliary == (Auxiliary(name="ua", unit="V"), Auxiliary(name="ub", unit="V"))


def test_without_skews_there_are_none_and_their_error_is_not_known(tmp_path: Path) -> None:
    sampling = _sampling(_csv(tmp_path / "a.csv"), **GRATING)
    assert sampling.synchronous
    assert (sampling.offsets_s, sampling.skew_uncertainty_s, sampling.filter_hz) == ((), None, None)


def test_it_tells_its_channels(tmp_path: Path) -> None:
    source = _opened(_csv(tmp_path / "a.csv"), **GRATING, skew={"ub": Quantity(4.0, "us")})
    assert isinstance(source, SyncDaq)
    assert source.channels() == (
        DaqChannel(name="gyro", unit="deg/s"),
        DaqChannel(name="ua", unit="V", scale=1e-3),
        DaqChannel(name="ub", unit="V", scale=1e-3, skew_s=Quantity(4.0, "us").to("s")),
    )


@pytest.mark.parametrize(("jitter", "uniform"), [(0.0, True), (0.02, True), (0.2, False)])
def test_rows_whose_stamps_scatter_are_not_synchronous(
    tmp_path: Path, jitter: float, uniform: bool
) -> None:
    rng = np.random.default_rng(3)
    time_s = (np.arange(100) + jitter * rng.uniform(-1.0, 1.0, 100)) * 1e-3
    settings = GRATING | {"time_column": "t"}
    assert _sampling(_csv(tmp_path / "a.csv", time_s=time_s), **settings).synchronous is uniform


def test_one_column_alone_is_no_synchronous_source(tmp_path: Path) -> None:
    source = _opened(_csv(tmp_path / "a.csv"), column="gz", unit="deg/s", sample_rate=KHZ)
    assert not source.configure(1e-3).synchronous


def test_a_name_that_nothing_plays_under_is_told_with_those_that_do(tmp_path: Path) -> None:
    source = _opened(_csv(tmp_path / "a.csv"), **GRATING)
    source.select(("gyro",), ("ua", "ubb"))
    with pytest.raises(
        InstrumentError, match=r"no column under the name 'ubb'.*gyro, ua, ub; did you mean 'ub'"
    ):
        source.configure(1e-3)
    with pytest.raises(InstrumentError, match="no column under the name 'theta'"):
        _sampling(_csv(tmp_path / "b.csv"), **GRATING, skew={"theta": Quantity(1.0, "us")})


def test_rows_of_an_angle_are_never_averaged(tmp_path: Path) -> None:
    settings = GRATING | {"auxiliary": {"angle": AuxiliaryColumn(column="a", unit="rad")}}
    source = _opened(_csv(tmp_path / "a.csv"), **settings)
    assert source.configure(1e-3).auxiliary == (Auxiliary(name="angle", unit="deg"),)
    with pytest.raises(
        InstrumentError, match=r"'angle' is an angle.*set the case's interval to 0\.001 s"
    ):
        source.configure(2e-3)


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"skew_uncertainty": Quantity(-1.0, "us")}, "skew_uncertainty -1 us is a half-width"),
        ({"filter": Quantity(0.0, "Hz")}, "filter 0 Hz is not more than zero"),
    ],
)
def test_figures_that_cannot_be_are_refused(settings: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        ReplaySettings(**GRATING, **settings)
