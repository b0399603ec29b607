"""Progress as the operator sees it: on terminals, in logs, and where its own drawing fails."""

import re
from collections.abc import Iterator
from datetime import UTC, datetime
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gyrotest.acquisition.progress import Coming, Progress, Silence
from gyrotest.analysis.allan import overlapping_allan_deviation
from gyrotest.plugin import line_progress, running_allan
from gyrotest.plugin.line_progress import LineProgress
from gyrotest.plugin.live_progress import LiveProgress
from gyrotest.plugin.progress import Harmless, progress_for
from gyrotest.plugin.reading import Reading
from gyrotest.recordings.reader import read_samples
from gyrotest.records.recording import Block, Identity, RecordingHeader, Sampling
from gyrotest.records.spec import Output, OutputKind
from gyrotest.units import Quantity

from .project import TINY, Project
from .terminal import Terminal, frames

VOLTAGE = Output(
    kind=OutputKind.VOLTAGE,
    scale_factor=Quantity(50.0, "mV/(deg/s)"),
    zero_rate=Quantity(2.5, "V"),
)


def header(*, samples: int = 900, unit: str = "V", source: str = "MY1234") -> RecordingHeader:
    return RecordingHeader(
        run_id="run",
        item="rest-1234-r1",
        attempt=1,
        serial_number="1234",
        model="M",
        spec_sha256="",
        started_utc=datetime(2026, 1, 1, tzinfo=UTC),
        planned_samples=samples,
        sampling=Sampling(interval_s=1.0, aperture_s=1.0, unit=unit),
        source=Identity(manufacturer="m", model="meter", serial_number=source),
    )


def blocks(samples: int = 900, *, missing_after: int | None = None) -> Iterator[Block]:
    volts = 2.5 + np.random.default_rng(3).normal(scale=2e-4, size=(samples, 1))
    for begin in range(0, samples, 10):
        first = begin + (5 if missing_after is not None and begin > missing_after else 0)
        values = volts[begin : begin + 10]
        yield Block(
            first=first, time_s=np.arange(10.0), values=values, flags=np.zeros(10, dtype=np.uint8)
        )


@pytest.fixture
def terminal(request: pytest.FixtureRequest) -> Iterator[Terminal]:
    columns, lines = getattr(request, "param", (80, 24))
    opened = Terminal(columns=columns, lines=lines)
    yield opened
    opened.close()


def coming(of: RecordingHeader) -> Coming:
    return Coming(sampling=of.sampling, source=of.source, samples=of.planned_samples)


def begin(progress: Progress, of: RecordingHeader) -> None:
    progress.prepare(coming(of))
    progress.begin(of)


def shown(
    terminal: Terminal, record: list[Block], *, output: Output = VOLTAGE, unit: str = "V"
) -> list[str]:
    live = LiveProgress(terminal.stream, Reading(output))
    begin(live, header(unit=unit))
    for one in record:
        live.push(one)
    live.end()
    return frames(terminal.close())


def last_drawn(found: list[str]) -> str:
    return [one for one in found if "rest-1234-r1  " in one][-1]


def test_the_last_frame_holds_every_sample(terminal: Terminal) -> None:
    record = list(blocks())
    last = last_drawn(shown(terminal, record))
    rate_dps = np.concatenate([one.values[:, 0] for one in record]) / 0.05
    whole = overlapping_allan_deviation(rate_dps, sample_rate_hz=1.0)
    assert "900 of 900  0:15:00 elapsed, 0:00:00 to go" in last
    assert f"angle random walk {whole.deviation_dps[0] * 60:.2f} °/√h at τ = 1 s" in last
    assert "Allan deviation so far, °/h" in last


def test_the_first_frame_shows_the_axes_before_a_sample_came(terminal: Terminal) -> None:
    first = next(one for one in shown(terminal, []) if "elapsed" in one)
    assert "0 of 900" in first
    assert "too few samples yet" in first


def test_nothing_is_left_on_the_screen(terminal: Terminal) -> None:
    assert shown(terminal, list(blocks()))[-1].strip() == ""


def test_a_gap_is_told(terminal: Terminal) -> None:
    last = last_drawn(shown(terminal, list(blocks(missing_after=600))))
    assert "curve begun anew at sample 615 (0:10:15), after a gap" in last


@pytest.mark.parametrize(
    "terminal", [(120, 50), (80, 24), (60, 20), (50, 12), (40, 8), (20, 5)], indirect=True
)
def test_a_frame_is_never_larger_than_its_terminal(
    terminal: Terminal, request: pytest.FixtureRequest
) -> None:
    columns, lines = request.node.callspec.params["terminal"]
    for one in shown(terminal, list(blocks(missing_after=600))):
        if "rest-1234" in one:
            drawn = one.splitlines()
            assert len(drawn) <= lines
            assert max(map(len, drawn)) <= columns


@pytest.mark.parametrize(
    ("columns", "lines", "there"), [(60, 20, True), (60, 13, False), (30, 20, False)]
)
def test_the_plot_is_left_out_where_there_is_no_room(columns: int, lines: int, there: bool) -> None:
    opened = Terminal(columns=columns, lines=lines)
    last = last_drawn(shown(opened, list(blocks())))
    assert ("Allan deviation" in last) is there
    assert "lowest" in last


def test_a_resized_terminal_is_drawn_anew_in_its_size(terminal: Terminal) -> None:
    live = LiveProgress(terminal.stream, Reading(VOLTAGE))
    begin(live, header())
    record = list(blocks())
    for one in record[:50]:
        live.push(one)
    terminal.resize(columns=50, lines=16)
    for one in record[50:]:
        live.push(one)
    live.end()
    last = last_drawn(frames(terminal.close())).splitlines()
    assert len(last) <= 16
    assert max(map(len, last)) <= 50


def test_what_takes_long_is_prepared_above_the_warm_up(
    terminal: Terminal, monkeypatch: pytest.MonkeyPatch
) -> None:
    live, of = LiveProgress(terminal.stream, Reading(VOLTAGE)), header()
    live.prepare(coming(of))
    monkeypatch.setattr(running_allan, "RunningAllan", None)  # nothing more is made from here on
    live.note("warming up until 1 min after power-on")
    live.begin(of)
    for one in blocks():
        live.push(one)
    live.end()
    found = frames(terminal.close())
    assert found[0].startswith("\npreparing the running Allan deviation")
    assert found[1].startswith("warming up until 1 min after power-on\n")
    assert "Allan deviation so far" in last_drawn(found)


def test_an_output_that_is_no_rate_has_no_curve(terminal: Terminal) -> None:
    rate = Output(kind=OutputKind.RATE)
    last = last_drawn(shown(terminal, list(blocks()), output=rate, unit="V"))
    assert "900 of 900" in last
    assert "Allan" not in last


@pytest.mark.parametrize(
    ("output", "unit", "expected"),
    [
        (VOLTAGE, "V", 20.0),
        (VOLTAGE, "deg/s", None),
        (Output(kind=OutputKind.RATE), "deg/s", 1.0),
        (Output(kind=OutputKind.RATE, scale_factor=Quantity(2.0, "")), "deg/h", 1.0 / 7200.0),
        (Output(kind=OutputKind.VOLTAGE), "V", None),
    ],
)
def test_a_reading_knows_what_rate_its_unit_stands_for(
    output: Output, unit: str, expected: float | None
) -> None:
    found = Reading(output).dps_per(unit)
    assert found == (None if expected is None else pytest.approx(expected))


def logged(monkeypatch: pytest.MonkeyPatch, *, source: str = "MY1234", real_time: bool = False) -> str:
    monkeypatch.setattr(line_progress, "LINE_EVERY_S", 0.0)
    opened = Terminal(columns=80, lines=24)
    lines = LineProgress(opened.stream, Reading(VOLTAGE), real_time=real_time)
    begin(lines, header(source=source))
    for one in blocks():
        lines.push(one)
    lines.end()
    return opened.close().splitlines()[-1]


def test_every_axis_is_read_by_its_name() -> None:
    reading = Reading(Output(kind=OutputKind.RATE, axes=("x", "z")))
    sampling = Sampling(interval_s=1.0, aperture_s=1.0, unit="deg/s", channels=("x", "z"))
    block = Block(
        first=0,
        time_s=np.zeros(1),
        values=np.array([[0.5, -1.25, 23.0]]),  # and a temperature, which is no output
        flags=np.zeros(1, dtype=np.uint8),
    )
    assert reading.all_of(block, sampling) == "x +0.5000 °/s, z -1.2500 °/s"


def test_a_line_names_the_lowest_point_so_far(monkeypatch: pytest.MonkeyPatch) -> None:
    expected = r"rest-1234-r1: 900 of 900, .* °/s; Allan deviation so far: lowest \S+ °/h at τ = \S+ s"
    assert re.search(expected, logged(monkeypatch))
    assert re.search(expected, logged(monkeypatch, source="SIM1", real_time=True))


@pytest.mark.parametrize("source", ["SIM1", "REPLAY-12345678"])
def test_lines_of_what_is_over_at_once_load_no_analysis(
    monkeypatch: pytest.MonkeyPatch, source: str
) -> None:
    assert "Allan" not in logged(monkeypatch, source=source)


class Broken:
    """A display that fails at one of its steps."""

    def __init__(self, at: str) -> None:
        self._at = at
        self.ended = 0

    def _step(self, name: str) -> None:
        if name == self._at:
            raise OSError(5, "the terminal is gone")

    def prepare(self, coming: Coming) -> None:
        self._step("prepare")

    def begin(self, header: RecordingHeader) -> None:
        self._step("begin")

    def push(self, block: Block) -> None:
        self._step("push")

    def note(self, text: str) -> None:
        self._step("note")

    def end(self) -> None:
        self.ended += 1
        self._step("end")


@pytest.mark.parametrize("at", ["prepare", "begin", "push", "note", "end"])
def test_a_fault_of_the_display_reaches_nobody_and_is_logged_once(
    at: str, caplog: pytest.LogCaptureFixture
) -> None:
    broken = Broken(at)
    progress = Harmless(broken)
    for _ in range(2):
        begin(progress, header())
        for one in blocks(30):
            progress.push(one)
        progress.note("warming up")
        progress.end()
    assert [record.levelname for record in caplog.records].count("WARNING") == 1
    assert broken.ended >= 1


def test_an_interrupt_is_no_fault_of_the_display() -> None:
    class Interrupted(Broken):
        def push(self, block: Block) -> None:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        Harmless(Interrupted("")).push(next(blocks()))


def test_a_run_on_a_terminal_draws_its_own_recording(project: Project) -> None:
    project.write("specs/tiny.yaml", TINY.replace("duration: 40 s", "duration: 10 min"))
    written = Terminal(columns=100, lines=40).pytest(
        project.path, "--gyro-spec", "tiny.yaml", "--serial", "1234"
    )
    last = last_drawn(frames(written))
    assert "600 of 600" in last
    (recording,) = project.runs()[0].glob("recordings/*.parquet")
    rate_dps = read_samples(recording).values[:, 0] / 0.05
    walk = overlapping_allan_deviation(rate_dps, sample_rate_hz=1.0).deviation_dps[0] * 60.0
    assert f"angle random walk {walk:.2f} °/√h" in last
    assert "1 passed" in written


@pytest.mark.parametrize(
    "session",
    [
        SimpleNamespace(get_verbosity=lambda: -1),
        SimpleNamespace(get_verbosity=lambda: 0, workerinput={}),
    ],
    ids=["quiet", "worker"],
)
def test_quiet_sessions_and_workers_show_nothing(session: Any) -> None:
    assert isinstance(progress_for(session, VOLTAGE), Silence)


def test_nothing_heavy_is_loaded_before_an_acquisition_is_shown(project: Project) -> None:
    ended = project.python(
        """
        import sys
        import gyrotest.plugin.progress
        print([one for one in sys.modules if one.startswith(("numba", "scipy", "rich", "gyrotest.analysis"))])
        """
    )
    assert ended.out.strip() == "[]"
