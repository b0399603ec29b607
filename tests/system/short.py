"""Short whole runs on a simulated bench: a record of three minutes, any meter, any way to it."""

from pathlib import Path

from gyrotest.records.run import Attempt, RunRecord
from gyrotest.specification.spec import load_spec
from gyrotest.specification.station import load_station

from .units import run_units

DRIVERS = {"34401A": "agilent34401a", "34465A": "keysight34465a"}

# Half a minute of warm-up and short records, so that a run takes a fraction of a second.
SPEC = """
model: SHORT50
output:
  kind: voltage
  scale_factor: 50 mV/(deg/s)
  scale_factor_uncertainty: 0.5 %
  zero_rate: 2.5 V
  full_scale: 100 deg/s
  bandwidth: 50 Hz
cases:
  rest:
    procedure: static
    warm_up: 30 s
    duration: 3 min
    interval: 1 s
    gaps: {gaps}
    parameters: {{smoothing: [1 s, 10 s]}}
    limits:
      bias: {{min: -2 deg/s, max: 2 deg/s}}
      bias_stability_1s: {{max: 100 deg/h}}
      angle_random_walk: {{max: 1 deg/sqrt(h)}}
"""
# The time-out is in real seconds: the tests of lost replies wait for it.
STATION = """
name: bench
line_frequency: 50 Hz
instruments:
  meter:
    driver: {driver}
    resource: simulated:{way}
    io_timeout: 0.4 s
    accuracy: {{of_reading: 35 ppm, of_range: 5 ppm, noise: 3 uV}}
slots:
  a: {{source: meter}}
simulation:
  seed: 5
"""


def short_run(
    folder: Path, model: str, way: str, *, scenario: str = "nominal", gaps: str = "refuse"
) -> RunRecord:
    """Run one unit on a meter behind a way to it (`tcp`, `pty`, `prologix` or `prologix-pty`)."""
    spec, station = folder / "spec.yaml", folder / "station.yaml"
    spec.write_text(SPEC.format(gaps=gaps), encoding="utf-8")
    station.write_text(STATION.format(driver=DRIVERS[model], way=way), encoding="utf-8")
    (record,) = run_units(
        folder / "out",
        ["1234"],
        scenario=scenario,
        spec=load_spec(spec),
        station=load_station(station),
    )
    return record


def only_attempt(record: RunRecord) -> Attempt:
    """The one attempt at the one item."""
    (item,) = record.items
    (attempt,) = item.attempts
    return attempt
