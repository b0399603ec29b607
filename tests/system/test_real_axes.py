"""Three axes of one real gyro, replayed side by side in one acquisition, each judged by itself."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from gyrotest.records.result import Verdict
from gyrotest.specification.spec import load_spec
from gyrotest.specification.station import load_station

from .units import run_units

pytestmark = [pytest.mark.slow]

AXES = ("x", "y", "z")


def test_each_axis_of_an_mpu6050_has_the_bias_that_it_has_alone(real_data: Path, tmp_path: Path) -> None:
    path = real_data / "mpu6050-static" / "static_449s.csv"
    spec = {
        "model": "MPU-6050",
        "output": {
            "kind": "count",
            "axes": list(AXES),
            "scale_factor": "131 count/(deg/s)",
        },
        "cases": {
            "rest": {
                "procedure": "static",
                "duration": "449 s",
                "interval": "10 ms",
                "parameters": {"smoothing": ["1 s"]},
                "limits": {"bias": {"min": "-20 deg/s", "max": "20 deg/s"}},
            }
        },
    }
    settings = {
        "columns": {axis: f"g{axis}" for axis in AXES},
        "auxiliary": {"acceleration": {"column": "az", "unit": "count"}},
        "unit": "count",
        "sample_rate": "100 Hz",
    }
    station = {
        "name": "Replay",
        "instruments": {"file": {"driver": "replay", "resource": str(path), "settings": settings}},
        "slots": {"a": {"source": "file"}},
    }
    for name, document in (("spec", spec), ("station", station)):
        (tmp_path / f"{name}.yaml").write_text(yaml.safe_dump(document), encoding="utf-8")
    (record,) = run_units(
        tmp_path / "reports",
        ["1"],
        spec=load_spec(tmp_path / "spec.yaml"),
        station=load_station(tmp_path / "station.yaml"),
    )
    assert record.replayed
    assert record.verdict is Verdict.PASS
    counts = np.loadtxt(path, delimiter=",", skiprows=5)[:44_900]
    for at, axis in enumerate(AXES, start=3):
        (bias,) = [one for one in record.results if (one.name, one.axis) == ("bias", axis)]
        assert bias.value == pytest.approx(counts[:, at].mean() / 131.0, rel=1e-9)
    (item,) = record.items
    assert item.last is not None
    assert item.last.recording is not None
    assert item.last.recording.header.sampling.columns == (*AXES, "acceleration")
