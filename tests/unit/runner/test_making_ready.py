"""What takes long before a record begins: it passes during the warm-up, and the stamps are right."""

from contextlib import closing
from pathlib import Path

import pytest

from gyrotest.acquisition.progress import Coming, Silence
from gyrotest.runner.bench import Bench, SimulationChoice
from gyrotest.runner.door import Order, open_run
from gyrotest.runner.flow import UnitRun
from gyrotest.specification.lookup import shipped_specs
from gyrotest.specification.spec import load_spec
from gyrotest.specification.station import load_station
from tests.plugin.project import TINY


class Slow(Silence):
    """Progress that takes a while until it is ready."""

    def __init__(self, bench: Bench, takes_s: float) -> None:
        self._clock, self._takes_s = bench.clock, takes_s
        self.coming: list[Coming] = []
        self.notes: list[str] = []

    def prepare(self, coming: Coming) -> None:
        self._clock.sleep_until(self._clock.now_s() + self._takes_s)
        self.coming.append(coming)

    def note(self, text: str) -> None:
        self.notes.append(text)


@pytest.mark.parametrize(
    ("takes_s", "begins_s", "waits"), [(24.0, 60.0, True), (90.0, 90.0, False)], ids=["less", "more"]
)
def test_progress_is_made_ready_during_the_warm_up(
    tmp_path: Path, takes_s: float, begins_s: float, waits: bool
) -> None:
    spec = tmp_path / "tiny.yaml"
    spec.write_text(
        TINY.replace("duration: 40 s", "duration: 40 s\n    warm_up: 1 min"), encoding="utf-8"
    )
    order = Order(
        spec=load_spec(spec),
        station=load_station(shipped_specs() / "stations" / "simulated.yaml"),
        serial_numbers=("1234",),
        out=tmp_path / "reports",
    )
    folder, header = open_run(order, "1234", next(iter(order.station.station.slots)))
    with closing(Bench(order.station.station, order.spec.spec, SimulationChoice())) as bench:
        on_utc = bench.clock.utc()
        slow = Slow(bench, takes_s)
        run = UnitRun(folder=folder, header=header, bench=lambda: bench, progress=slow, confirm=print)
        recording = run.acquire(header.plan[0]).attempt.recording
    assert recording is not None
    after_s = (recording.header.started_utc - on_utc).total_seconds()
    assert after_s == pytest.approx(begins_s, abs=2.0)  # and what the instruments' replies take
    assert bool(slow.notes) is waits
    (coming,) = slow.coming
    assert coming == Coming(
        sampling=recording.header.sampling, source=recording.header.source, samples=40
    )
