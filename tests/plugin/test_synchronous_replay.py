"""A vibration test from the simulated bench, and again from its samples in a plain file."""

from typing import Any

import numpy as np
import pyarrow.parquet as pq

from .project import Project

SPEC = """
model: FOG50
output: {kind: voltage, scale_factor: 50 mV/(deg/s)}
cases:
  response:
    procedure: random_vibration
    duration: 10 s
    interval: 200 us
    parameters: {level: 4 deg/s, runs: 2, rest: 5 s, settle: 1 s, low: 20 Hz, high: 60 Hz, segment: 1 s, degree: 3}
    limits: {bandwidth_3db: {min: 10 Hz}}
"""
LIVE = """
name: Vibration
instruments:
  daq:
    driver: sync_stream
    resource: simulated
    settings: {skew_uncertainty: 1 us, skew: {ua: 10 us, ub: 20 us}}
    accuracy: {of_reading: 100 ppm}
  exciter:
    driver: keysight33500b
    resource: simulated
    settings: {sensitivity: 20 deg/s/V, max_voltage: 5 V, max_rate: 40 deg/s}
slots:
  a: {source: daq, channel: gyro, encoder: {sine: ua, cosine: ub, lines: 900}, vibration: exciter}
simulation: {gyro: {bandwidth: 50 Hz, damping: 0.7}}
"""
TAPE = """
name: Tape
instruments:
  tape:
    driver: replay
    resource: samples.npy
    settings:
      columns: {gyro: 1}
      auxiliary: {ua: {column: 2, unit: mV}, ub: {column: 3, unit: mV}}
      unit: V
      sample_rate: 5 kHz
      skew: {ua: 10 us, ub: 20 us}
      skew_uncertainty: 1 us
    accuracy: {of_reading: 100 ppm}
slots:
  a: {source: tape, channel: gyro, encoder: {sine: ua, cosine: ub, lines: 900}}
"""


def results(record: dict[str, Any]) -> dict[str, float]:
    return {one["name"]: one["value"] for one in record["results"] if one["value"] is not None}


def test_a_recorded_vibration_gives_what_the_bench_gave(project: Project) -> None:
    project.write("specs/fog.yaml", SPEC)
    project.write("live.yaml", LIVE)
    project.write("tape.yaml", TAPE)
    ended = project.pytest("--gyro-station", "live.yaml", spec="fog.yaml", serial="7")
    assert "SIMULATED" in ended, ended.out
    live = results(project.record("7"))
    (recording,) = project.path.glob("reports/7/*/recordings/*.parquet")
    table = pq.read_table(recording, columns=["output", "encoder_sine", "encoder_cosine"])
    rows = np.column_stack([one.to_numpy() for one in table.columns]) * [1.0, 1e3, 1e3]
    np.save(project.path / "samples.npy", rows)
    ended = project.pytest("--gyro-station", "tape.yaml", spec="fog.yaml", serial="8")
    assert "REPLAYED" in ended, ended.out
    replayed = results(project.record("8"))
    assert replayed.keys() == live.keys()
    assert live["bandwidth_3db"] > 10.0
    for name, value in live.items():
        np.testing.assert_allclose(replayed[name], value, rtol=1e-6, err_msg=name)
