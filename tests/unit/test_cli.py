"""The command line in this process: what it says, what it returns, and that it never falls over."""

import json
import shutil
from pathlib import Path

import pytest

from gyrotest.cli import main
from gyrotest.specification.lookup import shipped_specs
from tests.system.short import SPEC, short_run

STATION = shipped_specs() / "stations" / "simulated.yaml"
Capture = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run's folder with its certificate; not to be changed."""
    folder = tmp_path_factory.mktemp("run")
    record = short_run(folder, "34401A", "tcp")
    assert not record.missing
    (run,) = (folder / "out" / "1234").iterdir()
    assert main(["report", str(run)]) == 0
    return run


@pytest.fixture
def run(measured: Path, tmp_path: Path) -> Path:
    """The same, to be changed."""
    return Path(shutil.copytree(measured, tmp_path / "1234" / measured.name))


def _certificate(run: Path) -> Path:
    (path,) = run.glob("*.pdf")
    return path


class TestUsage:
    @pytest.mark.parametrize(
        "arguments",
        [
            [],
            ["chek"],
            ["check"],
            ["schema"],
            ["schema", "bench"],
            ["simulate", "meter", "--port", "many"],
            ["simulate", "meter", "--model", "3458A"],
            ["simulate", "encoder"],
            ["report"],
            ["verify"],
            ["judge", "run"],
            ["recordings"],
            ["recordings", "mend", "x"],
        ],
        ids=" ".join,
    )
    def test_wrong_usage_shows_how_it_is_meant(self, arguments: list[str], capsys: Capture) -> None:
        with pytest.raises(SystemExit) as ended:
            main(arguments)
        assert ended.value.code == 2
        assert "usage: gyrotest" in capsys.readouterr().err

    def test_the_version_is_told(self, capsys: Capture) -> None:
        with pytest.raises(SystemExit) as ended:
            main(["--version"])
        assert ended.value.code == 0
        assert capsys.readouterr().out.startswith("gyrotest 0.")


class TestCheck:
    def test_good_files_are_called_good(self, capsys: Capture) -> None:
        assert main(["check", str(shipped_specs() / "mems50.yaml"), str(STATION)]) == 0
        first, second = capsys.readouterr().out.splitlines()
        assert first.endswith("mems50.yaml: a good spec of MEMS50 (1 case)")
        assert second.endswith("simulated.yaml: a good station, 'Simulated bench' (11 instruments)")

    def test_one_bad_file_does_not_hide_the_others(self, tmp_path: Path, capsys: Capture) -> None:
        assert main(["check", str(tmp_path / "none.yaml"), str(STATION)]) == 1
        said = capsys.readouterr()
        assert said.err.strip() == f"{tmp_path / 'none.yaml'}: no such file"
        assert "a good station" in said.out

    @pytest.mark.parametrize(
        ("found", "written", "message"),
        [
            ("scenario: nominal", "scenario: nominl", "scenario: 'nominl' is no scenario"),
            ("turn_on_bias:", "turn_on_bais:", "gyro.turn_on_bais: unknown key; did you mean"),
            ("0.15 deg/s", "0.15 deg", "gyro.turn_on_bias: '0.15 deg' is not an angular rate"),
            ("8 deg/h", "-8 deg/h", "bias_instability_coefficient: '-8 deg/h' must be zero or more"),
            (
                "seed: 1 ",
                "instruments: {meter: {niose: 3 uV}} ",
                "instruments.meter.niose: unknown key; did you mean 'noise'?",
            ),
            (
                "seed: 1 ",
                "instruments: {meter: {model: 3458A}} ",
                "instruments.meter.model: '3458A' cannot be simulated",
            ),
        ],
    )
    def test_a_fault_of_the_simulation_names_file_line_and_key(
        self, tmp_path: Path, capsys: Capture, found: str, written: str, message: str
    ) -> None:
        text = STATION.read_text(encoding="utf-8").replace(found, written, 1)
        path = tmp_path / "bench.yaml"
        path.write_text(text, encoding="utf-8")
        line = next(n for n, one in enumerate(text.splitlines(), 1) if written in one)
        assert main(["check", str(path)]) == 1
        (said,) = capsys.readouterr().err.splitlines()
        assert said.startswith(f"{path}:{line}: simulation.")
        assert message in said


class TestSchema:
    @pytest.mark.parametrize("what", ["spec", "station"])
    def test_a_schema_is_json(self, what: str, capsys: Capture) -> None:
        assert main(["schema", what]) == 0
        assert json.loads(capsys.readouterr().out)["type"] == "object"


class TestVerify:
    def test_a_run_and_its_certificate_are_sound(self, measured: Path, capsys: Capture) -> None:
        assert main(["verify", str(measured), str(_certificate(measured))]) == 0
        assert capsys.readouterr().out.count(": sound\n") == 2

    def test_a_changed_record_is_told(self, run: Path, capsys: Capture) -> None:
        record = run / "run.json"
        record.write_bytes(record.read_bytes().replace(b'"SHORT50"', b'"SHORT51"'))
        assert main(["verify", str(run)]) == 1
        assert "no certificate has this record attached" in capsys.readouterr().out

    def test_a_changed_byte_of_a_recording_is_told(self, run: Path, capsys: Capture) -> None:
        (recording,) = (run / "recordings").glob("*.parquet")
        content = bytearray(recording.read_bytes())
        content[len(content) // 2] ^= 1
        recording.write_bytes(content)
        assert main(["verify", str(run)]) == 1
        assert f"recordings/{recording.name}: its SHA-256 is" in capsys.readouterr().out
        assert main(["recordings", "verify", str(run)]) == 1
        assert f"recordings/{recording.name}: " in capsys.readouterr().out

    def test_a_recording_that_is_gone_is_told(self, run: Path, capsys: Capture) -> None:
        (recording,) = (run / "recordings").glob("*.parquet")
        recording.unlink()
        assert main(["verify", str(run)]) == 1
        assert "missing" in capsys.readouterr().out
        assert main(["recordings", "verify", str(run)]) == 1
        assert "missing" in capsys.readouterr().out

    @pytest.mark.parametrize(
        "content",
        [b"", b"no PDF", b"%PDF-1.7\n%%EOF\n", b"\x00" * 4096],
        ids=["0", "text", "stub", "nul"],
    )
    def test_what_is_no_certificate_is_not_sound(
        self, tmp_path: Path, capsys: Capture, content: bytes
    ) -> None:
        path = tmp_path / "some.pdf"
        path.write_bytes(content)
        assert main(["verify", str(path)]) == 1
        assert "some.pdf: cannot be read as a certificate" in capsys.readouterr().out

    def test_a_foreign_pdf_is_no_certificate(self, tmp_path: Path, capsys: Capture) -> None:
        from pypdf import PdfWriter

        writer = PdfWriter()
        writer.add_blank_page(100, 100)
        writer.write(tmp_path / "other.pdf")
        assert main(["verify", str(tmp_path / "other.pdf")]) == 1
        assert "no run.json is attached" in capsys.readouterr().out

    @pytest.mark.parametrize("cut", [0.1, 0.5, 0.9, 0.999])
    def test_a_certificate_cut_short_is_not_sound(self, run: Path, capsys: Capture, cut: float) -> None:
        path = _certificate(run)
        content = path.read_bytes()
        path.write_bytes(content[: int(cut * len(content))])
        assert main(["verify", str(path)]) == 1
        assert "NOT SOUND" in capsys.readouterr().out

    def test_what_is_not_there_is_not_sound(self, tmp_path: Path, capsys: Capture) -> None:
        assert main(["verify", str(tmp_path / "none"), str(tmp_path)]) == 1
        assert capsys.readouterr().out.count("NOT SOUND") == 2


class TestReport:
    def test_a_certificate_is_made_again_beside_the_first(self, run: Path, capsys: Capture) -> None:
        first = _certificate(run)
        assert main(["report", str(run)]) == 0
        again = Path(capsys.readouterr().out.strip())
        assert again != first
        assert again.read_bytes() == first.read_bytes()

    @pytest.mark.parametrize(
        "content", [b"", b"{", b"[]", b'{"schema_version": 1}', b"\xff\xfe", b"null"]
    )
    def test_a_damaged_record_is_refused(self, run: Path, capsys: Capture, content: bytes) -> None:
        (run / "run.json").write_bytes(content)
        before = sorted(run.iterdir())
        assert main(["report", str(run)]) == 1
        _is_short(capsys, "the run record")
        assert sorted(run.iterdir()) == before

    def test_a_folder_that_is_no_run_is_refused(self, tmp_path: Path, capsys: Capture) -> None:
        assert main(["report", str(tmp_path)]) == 1
        _is_short(capsys, "is", "a run's folder?")
        assert main(["report", str(tmp_path / "none")]) == 1
        _is_short(capsys, "none")


class TestJudge:
    def test_tighter_limits_fail_as_an_amendment(
        self, run: Path, tmp_path: Path, capsys: Capture
    ) -> None:
        record = (run / "run.json").read_bytes()
        spec = tmp_path / "tighter.yaml"
        spec.write_text(SPEC.format(gaps="refuse").replace("max: 100 deg/h", "max: 1 deg/h"))
        assert main(["judge", str(run), "--spec", str(spec)]) == 1
        verdict, certificate = capsys.readouterr().out.splitlines()
        assert verdict == "1234: FAIL"
        assert Path(certificate).is_file()
        assert (run / "run.json").read_bytes() == record

    def test_the_spec_of_another_model_is_refused(self, run: Path, capsys: Capture) -> None:
        assert main(["judge", str(run), "--spec", str(shipped_specs() / "mems50.yaml")]) == 1
        _is_short(capsys, "SHORT50", "MEMS50")
        assert not list(run.glob("amendment-*"))

    def test_a_missing_spec_is_refused(self, run: Path, tmp_path: Path, capsys: Capture) -> None:
        assert main(["judge", str(run), "--spec", str(tmp_path / "none.yaml")]) == 1
        _is_short(capsys, "none.yaml: no such file")

    def test_what_is_no_run_is_refused(self, tmp_path: Path, capsys: Capture) -> None:
        spec = shipped_specs() / "mems50.yaml"
        assert main(["judge", str(tmp_path), "--spec", str(spec)]) == 1
        _is_short(capsys, "a run's folder?")


class TestRecordingsVerify:
    def test_a_complete_recording_is_good(self, measured: Path, capsys: Capture) -> None:
        assert main(["recordings", "verify", str(measured)]) == 0
        (said,) = capsys.readouterr().out.splitlines()
        assert said == "recordings/rest-1234-r1-a1.parquet: complete, 180 samples: no gaps"

    def test_all_runs_of_a_serial_number_are_verified(self, measured: Path, capsys: Capture) -> None:
        assert main(["recordings", "verify", str(measured.parent)]) == 0
        assert f"{measured.name}/recordings/rest-1234-r1-a1.parquet: complete" in capsys.readouterr().out

    def test_a_folder_without_any_is_an_error(self, tmp_path: Path, capsys: Capture) -> None:
        assert main(["recordings", "verify", str(tmp_path)]) == 1
        _is_short(capsys, "holds no recordings")
        assert main(["recordings", "verify", str(tmp_path / "none")]) == 1
        _is_short(capsys, "does not exist")

    def test_a_foreign_file_is_damaged(self, tmp_path: Path, capsys: Capture) -> None:
        path = tmp_path / "notes.txt"
        path.write_text("no recording\n")
        assert main(["recordings", "verify", str(path)]) == 1
        assert "notes.txt: damaged" in capsys.readouterr().out


class TestSimulate:
    def test_a_port_in_use_is_told(self, capsys: Capture) -> None:
        import socket

        with socket.create_server(("127.0.0.1", 0)) as taken:
            port = taken.getsockname()[1]
            assert main(["simulate", "meter", "--port", str(port)]) == 1
        _is_short(capsys, f"127.0.0.1:{port}: cannot listen there")

    @pytest.mark.parametrize("port", ["-1", "65536"])
    def test_a_port_that_cannot_be_is_told(self, capsys: Capture, port: str) -> None:
        assert main(["simulate", "meter", "--port", port]) == 1
        _is_short(capsys, f"127.0.0.1:{port}: ports are 0 (any free one) to 65535")

    def test_an_unknown_scenario_is_told(self, capsys: Capture) -> None:
        assert main(["simulate", "meter", "--port", "0", "--scenario", "nominl"]) == 1
        _is_short(capsys, "'nominl' is no scenario", "nominal")


def _is_short(capsys: Capture, *texts: str) -> None:
    """One or two lines on the error stream that name what they are about."""
    said = capsys.readouterr().err
    assert 1 <= len(said.splitlines()) <= 2
    for text in texts:
        assert text in said
