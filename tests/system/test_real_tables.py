"""Real gyros turned, replayed from their files: scale factors against an encoder and by turns of 360°."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from pypdf import PdfReader

from gyrotest.certificate.pdf import write_certificate
from gyrotest.records.result import JudgedResult, Verdict
from gyrotest.records.run import Attempt, Outcome, RunRecord
from gyrotest.specification.spec import load_spec
from gyrotest.specification.station import load_station

from .units import run_units

pytestmark = [pytest.mark.slow]

# Computed independently of this project, by least squares over all samples but the first.
SPIN_TABLE = {
    "Auto_1": -0.868,
    "Auto_2": -0.870,
    "Auto_3": -0.870,
    "Auto_4": -0.866,
    "Manual_1": -0.866,
    "Manual_2": -0.866,
}
# Counts per °/s, from turns of −360°.
TURNS = {"x": -16.677, "y": -16.177, "z": -16.240}
PARTS_AT_REST = ("x_a", "x_p", "y_a", "y_p", "z_a", "z_p")
TOLERANCE = 0.001


@dataclass(frozen=True)
class Run:
    """A run of one case, and the folder that it is in."""

    record: RunRecord
    folder: Path

    @property
    def attempt(self) -> Attempt:
        """The only acquisition."""
        (item,) = self.record.items
        assert item.last is not None
        return item.last

    def result(self, name: str) -> JudgedResult:
        """One of its results."""
        (found,) = [one for one in self.record.results if one.name == name]
        return found

    def certificate(self) -> str:
        """The text of its certificate, every page of which says that it is a replay."""
        reader = PdfReader(write_certificate(self.record, self.folder))
        pages = [page.extract_text() for page in reader.pages]
        assert all("REPLAYED" in page for page in pages)
        return " ".join(" ".join(pages).split())


def run(
    tmp_path: Path,
    resource: Path,
    settings: dict[str, Any],
    output: dict[str, Any],
    case: dict[str, Any],
) -> Run:
    """Write a spec and a station as a user would, and run them."""
    tmp_path.mkdir(exist_ok=True)
    spec = {"model": "REAL", "output": output, "cases": {"table": case}}
    station = {
        "name": "Replay",
        "instruments": {"file": {"driver": "replay", "resource": str(resource), "settings": settings}},
        "slots": {"a": {"source": "file"}},
    }
    for name, document in (("spec", spec), ("station", station)):
        (tmp_path / f"{name}.yaml").write_text(yaml.safe_dump(document), encoding="utf-8")
    (record,) = run_units(
        tmp_path / "reports",
        ["7"],
        spec=load_spec(tmp_path / "spec.yaml"),
        station=load_station(tmp_path / "station.yaml"),
    )
    (found,) = (tmp_path / "reports").glob("**/run.json")
    assert record.replayed
    assert not record.simulated
    return Run(record=record, folder=found.parent)


def spin_table(data: Path, tmp_path: Path, name: str, **case: Any) -> Run:
    """The gyro in rad/s, the encoder in RPM though the header says otherwise, the first row left out."""
    path = data / "spin-table-2020" / f"Unit7_Gyro_{name}"
    times = np.loadtxt(path, comments="%", delimiter="\t", usecols=0)[1:]
    samples = round((times[-1] - times[0]) / 0.01) + 1
    settings = {
        "column": 2,
        "unit": "rad/s",
        "auxiliary": {"encoder": {"column": 3, "unit": "rpm"}},
        "time_column": 1,
        "first": 2,
    }
    planned = {
        "procedure": "scale_factor_reference",
        "duration": f"{samples * 10} ms",
        "interval": "10 ms",
        "parameters": {"reference": "encoder"},
    }
    return run(tmp_path, path, settings, {"kind": "rate"}, {**planned, **case})


@pytest.mark.parametrize("name", list(SPIN_TABLE))
def test_a_gyro_against_the_encoder_of_a_spin_table(real_data: Path, tmp_path: Path, name: str) -> None:
    found = spin_table(
        real_data,
        tmp_path,
        name,
        limits={"scale_factor": {"min": "-90 %", "max": "-84 %"}, "residual_rms": {"max": "10 deg/s"}},
    )
    assert found.record.verdict is Verdict.PASS
    scale_factor = found.result("scale_factor")
    assert scale_factor.value == pytest.approx(100.0 * SPIN_TABLE[name], abs=100.0 * TOLERANCE)
    assert 0.1 < (scale_factor.expanded_uncertainty or 0.0) < 1.0
    assert scale_factor.not_included == ("accuracy of the reference",)
    told = " ".join(found.attempt.remarks)
    assert "The output's sign is opposite to that of 'encoder': the scale factor is negative." in told
    assert "leads 'encoder' by about" in told
    recording = found.attempt.recording
    assert recording is not None
    assert [one.name for one in recording.header.sampling.auxiliary] == ["encoder"]
    gapped = name.startswith("Auto")
    assert bool(recording.gaps) == gapped
    assert ("The record has 1 gap with room for" in told) == gapped
    assert ("gaps (intervals above 1.5 × the median): 1" in told) == gapped
    if name == "Auto_1":
        text = found.certificate()
        assert "the scale factor is negative" in text
        assert "The record has 1 gap with room for 258 samples" in text


def test_a_reference_in_a_wrong_unit_gives_another_scale_factor(real_data: Path, tmp_path: Path) -> None:
    """As the file's header has it: the numbers would be taken as °/s."""
    path = real_data / "spin-table-2020" / "Unit7_Gyro_Manual_1"
    settings = {
        "column": 2,
        "unit": "rad/s",
        "auxiliary": {"encoder": {"column": 3, "unit": "rad/s"}},
        "sample_rate": "100 Hz",
        "first": 2,
    }
    case = {
        "procedure": "scale_factor_reference",
        "duration": "15 s",
        "interval": "10 ms",
        "parameters": {"reference": "encoder"},
    }
    found = run(tmp_path, path, settings, {"kind": "rate"}, case)
    assert found.result("scale_factor").value == pytest.approx(-0.866 * 2 * np.pi / 60, rel=2e-2)


def session(data: Path) -> tuple[Path, np.ndarray, dict[str, np.ndarray]]:
    path = data / "imucal-ferraris" / "annotated_session.csv"
    rows = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines()]
    parts = np.array([row[0] for row in rows[1:]])
    columns = {
        name: np.array([float(row[at]) for row in rows[1:]]) for at, name in enumerate(rows[0]) if at
    }
    return path, parts, columns


def turn(
    data: Path, tmp_path: Path, axis: str, parts: list[str], parameters: dict[str, Any], **case: Any
) -> Run:
    path, part, _ = session(data)
    places = np.flatnonzero(np.isin(part, parts))
    settings = {
        "column": f"gyr_{axis}",
        "where": {"part": parts},
        "unit": "count",
        "sample_rate": "204.8 Hz",
    }
    planned = {
        "procedure": "scale_factor_turn",
        "duration": f"{(places[-1] - places[0] + 1) * 4.8828125} ms",
        "interval": "4.8828125 ms",
        "parameters": {"angle": "-360 deg", **parameters},
    }
    return run(tmp_path, path, settings, {"kind": "count"}, {**planned, **case})


@pytest.mark.parametrize("axis", list(TURNS))
def test_a_turn_with_the_parts_at_rest_about_it(real_data: Path, tmp_path: Path, axis: str) -> None:
    """The rests are told by the case: all parts at rest that the session has before the turn, and after it."""
    _, part, _ = session(real_data)
    chosen = np.flatnonzero(np.isin(part, (*PARTS_AT_REST, f"{axis}_rot")))
    turning = np.flatnonzero(part == f"{axis}_rot")
    rests = {
        "rest_before": f"{float(turning[0] - chosen[0]) / 204.8!r} s",
        "rest_after": f"{float(chosen[-1] - turning[-1]) / 204.8!r} s",
    }
    found = turn(
        real_data,
        tmp_path,
        axis,
        [*PARTS_AT_REST, f"{axis}_rot"],
        rests,
        limits={"scale_factor": {"min": "-18 count/(deg/s)", "max": "-15 count/(deg/s)"}},
    )
    assert found.record.verdict is Verdict.PASS
    assert found.result("scale_factor").value == pytest.approx(TURNS[axis], abs=TOLERANCE)
    told = " ".join(found.attempt.remarks)
    assert "The output's sign is opposite to the sign given to the turn" in told
    assert f"; {turning.size} of the turn." in told
    assert "none of them in the turn" in told
    if axis == "x":
        text = found.certificate()
        assert "count/(°/s)" in text
        assert "Turn by a known angle" in text


@pytest.mark.parametrize("axis", list(TURNS))
def test_a_turn_alone_whose_rests_are_found_agrees_within_its_uncertainty(
    real_data: Path, tmp_path: Path, axis: str
) -> None:
    """It is turned by hand, and the hand is not quite still before and after: the angle is good to 1°."""
    found = turn(
        real_data,
        tmp_path,
        axis,
        [f"{axis}_rot"],
        {"angle_uncertainty": "1 deg", "time_uncertainty": "100 ppm"},
    )
    assert found.attempt.outcome is Outcome.PASSED
    scale_factor = found.result("scale_factor")
    assert scale_factor.expanded_uncertainty is not None
    assert abs((scale_factor.value or 0.0) - TURNS[axis]) < scale_factor.expanded_uncertainty
    assert scale_factor.expanded_uncertainty < 0.01 * abs(TURNS[axis])
    assert scale_factor.not_included == ()


def test_a_turn_told_the_other_way_round_has_the_other_sign(real_data: Path, tmp_path: Path) -> None:
    found = turn(real_data, tmp_path, "x", ["x_rot"], {"angle": "360 deg"})
    assert (found.result("scale_factor").value or 0.0) > 16.0
    assert not any("opposite" in one for one in found.attempt.remarks)
