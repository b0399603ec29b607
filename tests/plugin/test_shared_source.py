"""Several units at once: one source for all of them, or a resource of its own for each."""

import json

import numpy as np

from .project import Project

SPEC = """
model: TWIN
output: {kind: rate}
cases:
  rest:
    procedure: static
    duration: 100 s
    interval: 1 s
    parameters: {smoothing: [1 s]}
    limits: {bias: {min: -9 deg/s, max: 9 deg/s}}
"""
STATION = """
name: Tape
instruments:
  tape:
    driver: replay
    resource: 'unit-{serial}.csv'
    settings: {columns: {a: 1, b: 2}, sample_rate: 1 Hz, unit: deg/s}
slots:
  a: {source: tape, channel: a}
  b: {source: tape, channel: b}
"""


def test_units_with_a_file_each_are_not_read_from_one_of_them(project: Project) -> None:
    project.write("specs/twin.yaml", SPEC)
    project.write("twins.yaml", STATION)
    noise = np.random.default_rng(1).normal(0.0, 0.01, (100, 2))
    for serial, means in (("11", (1.0, 2.0)), ("22", (3.0, 4.0))):
        rows = "\n".join(f"{a:.6f},{b:.6f}" for a, b in noise + means)
        project.write(f"unit-{serial}.csv", f"a,b\n{rows}\n")
    ended = project.pytest("--gyro-station", "twins.yaml", spec="twin.yaml", serial="11,22")
    assert ended.code == 0, ended.out
    found = {}
    for path in project.path.glob("reports/*/*/run.json"):
        record = json.loads(path.read_text(encoding="utf-8"))
        (bias,) = [one for one in record["results"] if one["name"] == "bias"]
        found[record["serial_number"]] = round(bias["value"])
    assert found == {"11": 1, "22": 4}
