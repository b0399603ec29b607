"""Real gyros at rest, replayed from their files through the whole chain to records and certificates."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from pypdf import PdfReader

from gyrotest.certificate.pdf import write_certificate
from gyrotest.records.figure import Figure, Role
from gyrotest.records.result import JudgedResult, Verdict
from gyrotest.records.run import Attempt, Outcome, RunRecord
from gyrotest.specification.spec import load_spec
from gyrotest.specification.station import load_station

from .units import run_units

pytestmark = [pytest.mark.slow]

# Computed independently of this project, with numpy and allantools.
ADIS = {
    "x": ("0.351262", ["157.12", "63.89", "39.94"], ["0.0417836", "0.0137139", "0.00816336"]),
    "y": ("-0.427151", ["166.28", "74.86", "48.58"], ["0.0435577", "0.0151309", "0.00828626"]),
    "z": ("-0.285648", ["160.48", "86.60", "69.82"], ["0.0392371", "0.0133167", "0.00837470"]),
}
PARTS = ["x_a", "x_p", "y_a", "y_p", "z_a", "z_p"]
GAPPED = ["Auto_1", "Auto_2", "Auto_3", "Auto_4"]


@dataclass(frozen=True)
class Replayed:
    """A run of a replayed file and the folder that it is in."""

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
        pages = [
            page.extract_text() for page in PdfReader(write_certificate(self.record, self.folder)).pages
        ]
        assert len(pages) >= 2
        assert all("REPLAYED" in page for page in pages)
        return "\n".join(pages)


def replayed(
    tmp_path: Path, resource: Path, settings: dict[str, Any], case: dict[str, Any], **spec: Any
) -> Replayed:
    """Write a spec and a station as a user would, and run them."""
    tmp_path.mkdir(exist_ok=True)
    name = spec.pop("model", "REAL")
    document = {
        "model": name,
        "output": {"kind": "rate"},
        "cases": {"rest": {"procedure": "static", **case}},
    }
    (tmp_path / "spec.yaml").write_text(yaml.safe_dump({**document, **spec}), encoding="utf-8")
    station = {
        "name": "Replay",
        "instruments": {"file": {"driver": "replay", "resource": str(resource), "settings": settings}},
        "slots": {"a": {"source": "file"}},
    }
    (tmp_path / "station.yaml").write_text(yaml.safe_dump(station), encoding="utf-8")
    (record,) = run_units(
        tmp_path / "reports",
        ["1"],
        spec=load_spec(tmp_path / "spec.yaml"),
        station=load_station(tmp_path / "station.yaml"),
    )
    (run,) = (tmp_path / "reports").glob("**/run.json")
    assert record.replayed
    assert not record.simulated
    return Replayed(record=record, folder=run.parent)


def adis(data: Path, tmp_path: Path, axis: str, **case: Any) -> Replayed:
    settings = {
        "array": "gyro_lsb",
        "column": "xyz".index(axis) + 1,
        "scale": 0.05,
        "unit": "deg/s",
        "sample_rate": "100 Hz",
    }
    return replayed(
        tmp_path,
        data / "adis16405-static" / "gyro_lsb.npz",
        settings,
        {"duration": "10000 s", "interval": "10 ms", **case},
        model="ADIS16405",
        datasheet={"angle_random_walk": "2 deg/sqrt(h)", "allan_minimum": "25.2 deg/h"},
    )


def allan_curve(figures: tuple[Figure, ...]) -> dict[float, float]:
    """Return what the Allan plot draws: deviation in °/s by averaging time."""
    (panel,) = next(one for one in figures if one.name == "allan_deviation").panels
    (curve,) = [one for one in panel.curves if one.role is Role.DATA]
    to_dps = {"Allan deviation / (°/h)": 1 / 3600, "Allan deviation / (°/s)": 1.0}[panel.y_label]
    return {round(tau, 6): value * to_dps for tau, value in zip(curve.x, curve.y, strict=True)}


@pytest.mark.parametrize("axis", list(ADIS))
def test_an_adis16405_has_its_independent_values(real_data: Path, tmp_path: Path, axis: str) -> None:
    limits = {"bias": {"min": "-3 deg/s", "max": "3 deg/s"}, "allan_minimum": {"max": "40 deg/h"}}
    run = adis(real_data, tmp_path, axis, limits=limits)
    bias, stabilities, deviations = ADIS[axis]
    assert run.record.verdict is Verdict.PASS
    assert f"{run.result('bias').value:.6f}" == bias
    found = [f"{run.result(f'bias_stability_{name}').value:.2f}" for name in ("1s", "10s", "100s")]
    assert found == stabilities
    curve = allan_curve(run.attempt.figures)
    assert [f"{curve[tau]:#.6g}" for tau in (1.0, 10.0, 100.0)] == deviations
    assert run.attempt.recording is not None
    assert (run.attempt.recording.samples, run.attempt.recording.gaps) == (1_000_000, ())
    if axis == "x":
        text = run.certificate()
        assert "0.351" in text
        assert "d.o.f." in text
        assert not re.search(r"[0-9]e[+-][0-9]", text)


def test_a_window_of_a_real_recording_is_that_part_of_it(real_data: Path, tmp_path: Path) -> None:
    """From 2,000 s to 3,000 s by the case's window; the samples are the file's rows there."""
    run = adis(real_data, tmp_path, "x", duration="4000 s", parameters={"window": ["2000 s", "3000 s"]})
    rows = np.load(real_data / "adis16405-static" / "gyro_lsb.npz")["gyro_lsb"][200_000:300_000, 0]
    assert run.result("bias").value == pytest.approx(0.05 * rows.mean(), rel=1e-9)
    assert "mean over 1000 s" in run.result("bias").condition


@pytest.mark.parametrize("axis", ["gx", "gy", "gz"])
@pytest.mark.parametrize(("file", "rows"), [("static_449s", 44_900), ("static_100s", 9_980)])
def test_an_mpu6050_at_rest(real_data: Path, tmp_path: Path, file: str, rows: int, axis: str) -> None:
    path = real_data / "mpu6050-static" / f"{file}.csv"
    run = replayed(
        tmp_path,
        path,
        {"column": axis, "unit": "count", "scale_factor": "131 count/(deg/s)", "sample_rate": "100 Hz"},
        {
            "duration": f"{rows / 100:g} s",
            "interval": "10 ms",
            "parameters": {"smoothing": ["1 s", "10 s"]},
            "limits": {"bias": {"min": "-20 deg/s", "max": "20 deg/s"}},
        },
        model="MPU-6050",
    )
    counts = np.loadtxt(path, delimiter=",", skiprows=5)[:rows, 3 + ["gx", "gy", "gz"].index(axis)]
    assert run.record.verdict is Verdict.PASS
    assert run.result("bias").value == pytest.approx(counts.mean() / 131.0, rel=1e-9)
    averages = (counts[: rows - rows % 100] / 131.0).reshape(-1, 100).mean(axis=1)
    stability = run.result("bias_stability_1s").value
    assert stability == pytest.approx(3600.0 * np.std(averages, ddof=1), rel=1e-9)
    tenths = (counts / 131.0).reshape(-1, 10).mean(axis=1)
    walk = 60.0 * np.sqrt(0.1 * np.mean(np.diff(tenths) ** 2) / 2.0)
    assert run.result("angle_random_walk").value == pytest.approx(walk, rel=0.05)
    if (file, axis) == ("static_449s", "gx"):
        assert "MPU-6050" in run.certificate()


@pytest.mark.parametrize("axis", ["gyr_x", "gyr_y", "gyr_z"])
@pytest.mark.parametrize("part", PARTS)
def test_the_parts_at_rest_of_a_calibration_session(
    real_data: Path, tmp_path: Path, part: str, axis: str
) -> None:
    path = real_data / "imucal-ferraris" / "annotated_session.csv"
    rows = [line.split(",") for line in path.read_text().splitlines()]
    counts = np.array([float(row[rows[0].index(axis)]) for row in rows if row[0] == part])
    run = replayed(
        tmp_path,
        path,
        {
            "column": axis,
            "where": {"part": part},
            "unit": "count",
            "scale_factor": "16.4 count/(deg/s)",
            "sample_rate": "204.8 Hz",
        },
        {
            "duration": f"{700 * 4.8828125} ms",
            "interval": "4.8828125 ms",
            "parameters": {"smoothing": ["312.5 ms"]},
        },
    )
    assert run.attempt.outcome is Outcome.PASSED
    assert run.result("bias").value == pytest.approx(counts[:700].mean() / 16.4, rel=1e-9)
    assert (run.result("bias_stability_312.5ms").value or 0.0) > 0.0


def spin_table(data: Path, name: str) -> tuple[Path, np.ndarray]:
    """Return a file of the spin table and its rows at rest, without the first one of zeros."""
    path = data / "spin-table-2020" / f"Unit7_Gyro_{name}"
    table = np.loadtxt(path, comments="%", delimiter="\t", usecols=(0, 1, 2))[1:]
    return path, table[: int(np.flatnonzero(np.abs(table[:, 2]) > 0.5)[0])]


def spin(data: Path, tmp_path: Path, name: str, **case: Any) -> tuple[Replayed, np.ndarray]:
    path, rest = spin_table(data, name)
    samples = round((rest[-1, 0] - rest[0, 0]) / 0.01) + 1
    settings = {"column": 2, "time_column": 1, "unit": "rad/s", "first": 2}
    planned = {
        "duration": f"{samples * 10} ms",
        "interval": "10 ms",
        "parameters": {"smoothing": ["0.1 s"]},
    }
    return replayed(tmp_path, path, settings, {**planned, **case}), rest


@pytest.mark.parametrize("name", GAPPED)
def test_a_gap_at_the_spin_table_is_refused_unless_the_case_says_otherwise(
    real_data: Path, tmp_path: Path, name: str
) -> None:
    refused, rest = spin(real_data, tmp_path / "refuse", name)
    after = int(np.flatnonzero(np.diff(rest[:, 0]) > 0.015)[0])
    assert (refused.record.verdict, refused.attempt.outcome) == (Verdict.INCOMPLETE, Outcome.ERROR)
    assert f"1 gap in the record, after sample {after}" in refused.attempt.message
    taken, _ = spin(real_data, tmp_path / "take", name, gaps="longest_stretch")
    told = " ".join((*taken.attempt.events, *taken.attempt.remarks))
    assert f"used: samples 0 … {after}" in told
    assert "gaps (intervals above 1.5 × the median)" in told
    bias = taken.result("bias")
    assert bias.value == pytest.approx(np.degrees(rest[: after + 1, 1].mean()), rel=1e-9)
    assert f"longest gap-free stretch, {after + 1} of {len(rest)} samples" in bias.condition
    assert any(one.source.startswith("resolution, steps of 0.57 °/s") for one in bias.budget)
    # Its samples vary by less than their steps: a bias it is, and no noise.
    noise = taken.result("bias_stability_0.1s")
    assert noise.value is None
    assert "not distinguishable from rounding" in noise.reason


@pytest.mark.parametrize("name", ["Manual_1", "Manual_2"])
def test_a_begin_without_gaps_is_taken_whole(real_data: Path, tmp_path: Path, name: str) -> None:
    run, rest = spin(real_data, tmp_path, name)
    assert run.attempt.outcome is Outcome.PASSED
    assert run.result("bias").value == pytest.approx(np.degrees(rest[:, 1].mean()), rel=1e-9)
    assert (run.result("bias_stability_0.1s").value or 0.0) > 0.0
