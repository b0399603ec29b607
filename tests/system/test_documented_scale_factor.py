"""The examples of the page on scale factors from recordings run, and give what the page says."""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from gyrotest.records.result import Verdict
from gyrotest.records.run import RunRecord
from gyrotest.specification.spec import load_spec
from gyrotest.specification.station import load_station

from .units import run_units

pytestmark = [pytest.mark.slow]

PAGE = Path(__file__).parents[2] / "docs" / "scale-factor-recorded.md"


def examples() -> list[dict[str, Any]]:
    """The page's specs and stations, by turns."""
    return [
        yaml.safe_load(block)
        for block in re.findall(r"```yaml\n(.*?)```", PAGE.read_text("utf-8"), re.S)
    ]


def run(tmp_path: Path, spec: dict[str, Any], station: dict[str, Any], resource: Path) -> RunRecord:
    station["instruments"]["file"]["resource"] = str(resource)
    for name, document in (("spec", spec), ("station", station)):
        (tmp_path / f"{name}.yaml").write_text(yaml.safe_dump(document), encoding="utf-8")
    (record,) = run_units(
        tmp_path / "reports",
        ["7"],
        spec=load_spec(tmp_path / "spec.yaml"),
        station=load_station(tmp_path / "station.yaml"),
    )
    return record


def test_the_example_beside_a_reference(real_data: Path, tmp_path: Path) -> None:
    spec, station = examples()[:2]
    record = run(tmp_path, spec, station, real_data / "spin-table-2020" / "Unit7_Gyro_Auto_1")
    assert record.verdict is Verdict.PASS
    scale_factor, bias, _ = record.results
    assert scale_factor.value == pytest.approx(-86.8, abs=0.1)
    assert scale_factor.not_included == bias.not_included == ()


def test_the_example_of_a_turn(real_data: Path, tmp_path: Path) -> None:
    spec, station = examples()[2:]
    record = run(tmp_path, spec, station, real_data / "imucal-ferraris" / "annotated_session.csv")
    assert record.verdict is Verdict.PASS
    scale_factor = record.results[0]
    assert scale_factor.value == pytest.approx(-16.677, abs=scale_factor.expanded_uncertainty)
    assert scale_factor.not_included == ()
