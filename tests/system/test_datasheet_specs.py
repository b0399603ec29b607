"""The specs of digital gyros, from a recorded file through the replay station to a certificate.

The records are as long as the specs say, and their samples further apart: what the angle random walk and
the floor look like is the same, and a test takes seconds.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import yaml
from pypdf import PdfReader

from gyrotest.certificate.pdf import write_certificate
from gyrotest.records.result import JudgedResult, Verdict
from gyrotest.records.run import RunRecord
from gyrotest.specification.check import check_file
from gyrotest.specification.lookup import shipped_specs
from gyrotest.specification.spec import load_spec
from gyrotest.specification.station import load_station
from tests.unit.analysis.generator import DPH, gyro_noise

from .units import run_units

pytestmark = [pytest.mark.slow]


@dataclass(frozen=True)
class Model:
    """A shipped spec with what its gyro is: °/h·√s, °/h, °/h/√s."""

    spec: str
    rate_hz: float
    interval: str
    coarser: str
    walk: float
    flicker: float
    rate_walk: float
    samples: int
    axes: tuple[str, ...] = ()


STIM210 = Model("stim210.yaml", 1.0, "8 ms", "1 s", 9.0, 0.5, 0.01, 9_000_000, ("x", "y", "z"))
ADIS16375 = Model("adis16375.yaml", 10.0, "10 ms", "100 ms", 60.0, 12.0, 0.3, 1_620_000)
SEEDS = (3, 4, 5)
MODELS = [pytest.param(one, id=one.spec.removesuffix(".yaml")) for one in (STIM210, ADIS16375)]


def replayed(model: Model, folder: Path, *, noise: float = 1.0) -> RunRecord:
    """Run a unit, whose noise is so many times the model's, from a file."""
    text = (shipped_specs() / model.spec).read_text(encoding="utf-8")
    (folder / model.spec).write_text(
        text.replace(f"interval: {model.interval}", f"interval: {model.coarser}"), encoding="utf-8"
    )
    spec = load_spec(folder / model.spec)
    duration_s = spec.spec.cases["noise"].duration.to("s")
    rates_dps = [
        gyro_noise(
            round(duration_s * model.rate_hz),
            interval_s=1.0 / model.rate_hz,
            angle_random_walk=noise * model.walk * DPH,
            bias_instability=noise * model.flicker * DPH,
            rate_random_walk=noise * model.rate_walk * DPH,
            seed=seed,
        )
        for seed in SEEDS[: max(len(model.axes), 1)]
    ]
    np.save(folder / "recorded.npy", np.column_stack(rates_dps) / DPH)
    settings: dict[str, object] = {"unit": "deg/h", "sample_rate": f"{model.rate_hz} Hz"}
    if model.axes:
        settings["columns"] = {axis: place for place, axis in enumerate(model.axes, start=1)}
    station = {
        "name": "Replay",
        "instruments": {"file": {"driver": "replay", "resource": "recorded.npy", "settings": settings}},
        "slots": {"a": {"source": "file"}},
    }
    (folder / "station.yaml").write_text(yaml.safe_dump(station), encoding="utf-8")
    (record,) = run_units(
        folder / "reports", ["1"], spec=spec, station=load_station(folder / "station.yaml")
    )
    return record


def results(record: RunRecord, name: str, model: Model) -> list[JudgedResult]:
    found = [one for one in record.results if one.name == name]
    assert [one.axis for one in found] == list(model.axes or ("",))
    return found


@pytest.mark.parametrize("model", MODELS)
def test_the_spec_asks_for_the_samples_of_its_case(model: Model) -> None:
    path = shipped_specs() / model.spec
    assert check_file(path).startswith("a good spec of ")
    case = load_spec(path).spec.cases["noise"]
    assert round(case.duration.to("s") / case.interval.to("s")) == model.samples


@pytest.mark.parametrize("model", MODELS)
def test_a_unit_of_the_datasheet_passes_with_its_true_coefficients(model: Model, tmp_path: Path) -> None:
    record = replayed(model, tmp_path)
    assert record.verdict is Verdict.PASS
    for walk in results(record, "angle_random_walk", model):
        assert walk.value == pytest.approx(model.walk / 60.0, rel=0.02)
    for flicker in results(record, "bias_instability_coefficient", model):
        assert 0.9 * (flicker.lower_95 or 0.0) < model.flicker < 1.1 * (flicker.upper_95 or 0.0)
    text = "\n".join(
        page.extract_text() for page in PdfReader(write_certificate(record, tmp_path)).pages
    )
    assert "REPLAYED" in text
    assert "Noise terms" in text
    assert "N – angle random walk" in text
    assert "datasheet ARW" in text
    assert "datasheet minimum" in text


@pytest.mark.parametrize("model", MODELS)
def test_a_unit_of_far_more_noise_fails_both_limits(model: Model, tmp_path: Path) -> None:
    record = replayed(model, tmp_path, noise=2.5)
    assert record.verdict is Verdict.FAIL
    judged = [one for one in record.results if one.limit is not None]
    assert {one.name for one in judged} == {"angle_random_walk", "allan_minimum"}
    assert {one.verdict for one in judged} == {Verdict.FAIL}
    assert len(judged) == 2 * max(len(model.axes), 1)
