"""`gyrotest analyse` as a user runs it: what it says, what it writes, what it refuses, what it returns."""

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gyrotest.analysis.noise import identify_noise
from gyrotest.cli import main
from gyrotest.cli.analyse_progress import Spinner
from tests.system.short import short_run
from tests.unit.offline.records import RATE_HZ, rates

Capture = pytest.CaptureFixture[str]
AT_10_HZ = ["--rate", "10 Hz"]
RATE = ["--unit", "deg/s", *AT_10_HZ]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same three axes in every format; not to be changed."""
    import h5py
    import pyarrow as pa
    import pyarrow.parquet as pq
    from scipy.io import savemat

    made = tmp_path_factory.mktemp("analyse")
    axes = np.column_stack([rates(seed=seed) for seed in (1, 2, 3)])
    time_s = np.arange(axes.shape[0]) / RATE_HZ
    table = np.column_stack([time_s, axes])
    np.savetxt(made / "rest.csv", table, delimiter=",", header="time,gx,gy,gz", comments="", fmt="%.17g")
    np.save(made / "rest.npy", axes[:, 0])
    np.savez(made / "rest.npz", gyro=axes, lsb=1.0)
    savemat(made / "rest.mat", {"gyro": axes})
    with h5py.File(made / "rest.h5", "w") as file:
        file["imu/gyro"] = axes
    named = dict(zip(("time", "gx", "gy", "gz"), table.T, strict=True))
    pq.write_table(pa.table(named), made / "rest.parquet")
    return made


def _said(capsys: Capture, *arguments: str | Path, expected: int = 0) -> tuple[str, str]:
    """Run the command; return what it wrote on both streams."""
    assert main(["analyse", *map(str, arguments)]) == expected
    captured = capsys.readouterr()
    return captured.out, captured.err


def _records(capsys: Capture, *arguments: str | Path) -> list[dict[str, Any]]:
    out, _ = _said(capsys, *arguments, "--json")
    found: list[dict[str, Any]] = json.loads(out)["records"]
    return found


class TestFiles:
    @pytest.mark.parametrize("name", ["rest.csv", "rest.npz", "rest.mat", "rest.h5", "rest.parquet"])
    def test_every_format_gives_the_same_values_of_three_axes(
        self, folder: Path, capsys: Capture, name: str
    ) -> None:
        expected = identify_noise(rates(seed=3), sample_rate_hz=RATE_HZ).angle_random_walk
        records = _records(capsys, folder / name, *RATE)
        assert len(records) == 3
        walk = records[2]["angle_random_walk_deg_per_sqrt_s"]
        assert walk["value"] == pytest.approx(expected.value, rel=1e-9)
        assert walk["upper_95"] == pytest.approx(expected.upper_95, rel=1e-9)

    def test_a_table_names_each_column_and_its_values(self, folder: Path, capsys: Capture) -> None:
        out, err = _said(capsys, folder / "rest.csv", *RATE, "--column", "gz", "--column", "gx")
        assert err == ""
        assert re.findall(r"^\S*rest\.csv: (\w+)$", out, re.MULTILINE) == ["gz", "gx"]
        assert out.count("Angle random walk N") == 2
        assert out.count("Bias instability coefficient B") == out.count("Allan deviation, minimum") == 2
        assert "6000 samples at 10 Hz, 10.00 min" in out

    def test_columns_are_numbered_from_1(self, folder: Path, capsys: Capture) -> None:
        (by_name,) = _records(capsys, folder / "rest.csv", *RATE, "--column", "gy")
        (by_number,) = _records(capsys, folder / "rest.csv", *RATE, "--column", "3")
        assert by_name["curve"] == by_number["curve"]

    def test_time_stamps_give_the_rate(self, folder: Path, capsys: Capture) -> None:
        arguments = ("--unit", "deg/s", "--time-column", "time", "--column", "gx")
        (found,) = _records(capsys, folder / "rest.csv", *arguments)
        assert found["sample_rate_hz"] == pytest.approx(RATE_HZ)

    @pytest.mark.parametrize("name", ["dated.csv", "dated.parquet"])
    @pytest.mark.parametrize("unit", [(), ("--time-unit", "ms")])
    def test_dates_give_the_rate_whatever_unit_is_stated(
        self, tmp_path: Path, capsys: Capture, name: str, unit: tuple[str, ...]
    ) -> None:
        import pyarrow as pa
        import pyarrow.csv
        import pyarrow.parquet as pq

        stamps = np.datetime64("2026-03-01T12:00:00.000", "ms") + 100 * np.arange(600)
        table = pa.table({"when": pa.array(stamps, pa.timestamp("ms")), "gx": rates(600)})
        write = pyarrow.csv.write_csv if name.endswith("csv") else pq.write_table
        write(table, tmp_path / name)
        options = ("--unit", "deg/s", "--time-column", "when", *unit)
        (found,) = _records(capsys, tmp_path / name, *options)
        assert found["sample_rate_hz"] == pytest.approx(RATE_HZ)

    def test_a_count_of_nanoseconds_needs_its_unit(self, tmp_path: Path, capsys: Capture) -> None:
        import pyarrow as pa
        import pyarrow.parquet as pq

        ticks = 1_700_000_000_000_000_000 + 100_000_000 * np.arange(600)
        pq.write_table(pa.table({"t_ns": ticks, "gx": rates(600)}), tmp_path / "rest.parquet")
        options = ("--unit", "deg/s", "--time-column", "t_ns")
        _, err = _said(capsys, tmp_path / "rest.parquet", *options, expected=1)
        assert "give --time-unit ns" in err
        (found,) = _records(capsys, tmp_path / "rest.parquet", *options, "--time-unit", "ns")
        assert found["sample_rate_hz"] == pytest.approx(RATE_HZ)

    def test_a_column_of_dates_is_offered(self, tmp_path: Path, capsys: Capture) -> None:
        import pyarrow as pa
        import pyarrow.parquet as pq

        stamps = np.datetime64("2026-03-01T12:00:00.000", "ms") + 100 * np.arange(600)
        pq.write_table(pa.table({"when": stamps, "gx": rates(600)}), tmp_path / "rest.parquet")
        _, err = _said(capsys, tmp_path / "rest.parquet", "--unit", "deg/s", expected=1)
        assert "or --time-column when" in err

    def test_a_window_is_analysed_alone(self, folder: Path, capsys: Capture) -> None:
        (found,) = _records(capsys, folder / "rest.npy", *RATE, "--window", "1 min", "5 min")
        assert (found["begin_s"], found["samples"]) == (60.0, 2400)
        assert found["mean_dps"] == pytest.approx(float(rates(seed=1)[600:3000].mean()))

    def test_rows_of_one_content_are_analysed_alone(self, tmp_path: Path, capsys: Capture) -> None:
        path = tmp_path / "parts.csv"
        values = rates(400)
        lines = [f"{'up' if n < 200 else 'down'},{value!r}" for n, value in enumerate(values.tolist())]
        path.write_text("\n".join(["part,gx", *lines]), encoding="utf-8")
        (found,) = _records(capsys, path, *RATE, "--where", "part=down")
        assert found["samples"] == 200
        assert found["mean_dps"] == pytest.approx(float(values[200:].mean()))

    def test_a_recording_of_a_run_brings_its_own_rate_and_unit(
        self, tmp_path: Path, capsys: Capture
    ) -> None:
        short_run(tmp_path, "34401A", "tcp")
        (recording,) = tmp_path.glob("out/1234/*/recordings/*.parquet")
        (found,) = _records(capsys, recording, "--spec", str(tmp_path / "spec.yaml"))
        assert (found["samples"], found["interval_s"]) == (180, 1.0)
        assert found["duty"] == pytest.approx(0.4)
        assert abs(found["mean_dps"]) < 1.0
        run = recording.parent.parent
        (of_run,) = _records(capsys, run, "--spec", str(tmp_path / "spec.yaml"))
        assert (of_run["file"], of_run["curve"]) == (str(recording), found["curve"])

    def test_what_is_asked_for_twice_is_analysed_once(self, folder: Path, capsys: Capture) -> None:
        path = folder / "rest.csv"
        found = _records(capsys, path, path, *RATE, "--column", "gx", "--column", "gz", "--column", "gx")
        assert [one["column"] for one in found] == ["gx", "gz"]


class TestMeaning:
    def test_a_spec_says_what_a_voltage_means(
        self, folder: Path, tmp_path: Path, capsys: Capture
    ) -> None:
        np.save(tmp_path / "volts.npy", 2.5 + 0.05 * rates(seed=1))
        (volts,) = _records(capsys, tmp_path / "volts.npy", "--spec", "mems50", *AT_10_HZ)
        (rate,) = _records(capsys, folder / "rest.npy", *RATE)
        assert volts["mean_dps"] == pytest.approx(rate["mean_dps"], rel=1e-9)
        walk = volts["angle_random_walk_deg_per_sqrt_s"]
        assert walk["value"] == pytest.approx(rate["angle_random_walk_deg_per_sqrt_s"]["value"])
        assert walk["datasheet"] == pytest.approx(0.5 / 60.0)
        assert walk["ratio_to_datasheet"] == pytest.approx(walk["value"] / walk["datasheet"])

    def test_options_go_before_the_spec(self, folder: Path, capsys: Capture) -> None:
        (found,) = _records(capsys, folder / "rest.npy", "--spec", "mems50", *RATE)
        assert found["mean_dps"] == pytest.approx(float(rates(seed=1).mean()))
        assert found["allan_minimum"]["datasheet"] is not None

    def test_counts_become_rates(self, folder: Path, tmp_path: Path, capsys: Capture) -> None:
        np.save(tmp_path / "counts.npy", np.rint(rates(seed=1) / 1e-4).astype(np.int32))
        counts = ("--unit", "count", "--scale-factor", "10000 count/(deg/s)")
        scaled = ("--unit", "deg/s", "--scale", "1e-4")
        results = [
            _records(capsys, tmp_path / "counts.npy", *meaning, *AT_10_HZ)[0]
            for meaning in (counts, scaled)
        ]
        assert results[0]["mean_dps"] == pytest.approx(results[1]["mean_dps"])
        assert results[0]["mean_dps"] == pytest.approx(float(rates(seed=1).mean()), abs=1e-5)

    def test_dead_time_is_said_and_corrected(self, folder: Path, capsys: Capture) -> None:
        out, _ = _said(
            capsys, folder / "rest.npy", *RATE, "--aperture", "40 ms", "--bandwidth", "100 Hz"
        )
        assert "Angle random walk N, as read" in out
        assert "a sample covers 40 % of its interval" in out


class TestOutputs:
    def test_json_and_csv_and_plot_are_written_beside_the_tables(
        self, folder: Path, tmp_path: Path, capsys: Capture
    ) -> None:
        wanted = {name: tmp_path / f"a.{name}" for name in ("json", "csv", "plot")}
        wanted["plot"] = tmp_path / "a.PNG"
        options = [part for name, path in wanted.items() for part in (f"--{name}", str(path))]
        out, _ = _said(capsys, folder / "rest.csv", *RATE, *options)
        assert "Angle random walk N" in out
        assert len(json.loads(wanted["json"].read_text(encoding="utf-8"))["records"]) == 3
        assert wanted["csv"].read_bytes().startswith(b"file,array,column,averaging_factor,tau_s,")
        assert wanted["plot"].read_bytes().startswith(b"\x89PNG")

    @pytest.mark.parametrize(("suffix", "begin"), [("pdf", b"%PDF"), ("svg", b"<?xml")])
    def test_a_plot_has_the_format_of_its_name(
        self, folder: Path, tmp_path: Path, capsys: Capture, suffix: str, begin: bytes
    ) -> None:
        path = tmp_path / f"a.{suffix}"
        _said(capsys, folder / "rest.npy", *RATE, "--plot", path)
        assert path.read_bytes().startswith(begin)

    @pytest.mark.parametrize("form", ["--json", "--csv"])
    def test_standard_output_holds_nothing_else(self, folder: Path, capsys: Capture, form: str) -> None:
        out, err = _said(capsys, folder / "rest.npy", *RATE, form, "-")
        assert out.startswith(("{", "file,"))
        assert "Angle random walk N" not in out
        assert err == ""

    def test_a_plot_that_cannot_be_written_is_told(
        self, folder: Path, tmp_path: Path, capsys: Capture
    ) -> None:
        (tmp_path / "a.svg").mkdir()
        _, err = _said(capsys, folder / "rest.npy", *RATE, "--plot", tmp_path / "a.svg", expected=1)
        assert "a.svg: cannot be written" in err


class TestRefused:
    @pytest.mark.parametrize(
        ("values", "message"),
        [
            ([*[0.1, 0.2] * 50, float("nan")], "row 101 is missing or not a number (1 of 101"),
            ([float("inf"), *[0.1, 0.2] * 50], "row 1 is infinite (1 of 101"),
            ([0.25] * 100, "all 100 samples are 0.25 °/s: a constant carries no noise"),
            ([0.1, 0.2] * 10, "20 samples are too few: a noise model needs at least 36"),
            ([], "there are no samples"),
        ],
        ids=["nan", "inf", "constant", "few", "none"],
    )
    def test_what_no_analysis_can_use_is_named(
        self, tmp_path: Path, capsys: Capture, values: list[float], message: str
    ) -> None:
        np.save(tmp_path / "bad.npy", np.array(values))
        out, err = _said(capsys, tmp_path / "bad.npy", *RATE, expected=1)
        assert out == ""
        assert err.startswith(f"{tmp_path / 'bad.npy'}: ")
        assert message in err

    def test_one_bad_file_does_not_hide_the_others(
        self, folder: Path, tmp_path: Path, capsys: Capture
    ) -> None:
        out, err = _said(capsys, tmp_path / "none.npy", folder / "rest.npy", *RATE, "--json", expected=1)
        document = json.loads(out)
        assert len(document["records"]) == 1
        assert document["refused"] == [err.strip()]
        assert "none.npy: cannot be read" in err

    def test_the_nearest_column_is_offered(self, folder: Path, capsys: Capture) -> None:
        _, err = _said(capsys, folder / "rest.csv", *RATE, "--column", "g_z", expected=1)
        assert "has no column 'g_z'; its columns are time, gx, gy, gz; is 'gz' meant?" in err

    def test_a_missing_rate_or_unit_is_asked_for(self, folder: Path, capsys: Capture) -> None:
        _, err = _said(capsys, folder / "rest.csv", "--unit", "deg/s", "--column", "gx", expected=1)
        assert "give e.g. --rate '100 Hz', or --time-column time" in err
        _, err = _said(capsys, folder / "rest.npy", *AT_10_HZ, expected=1)
        assert "the unit of its values is not known" in err

    def test_what_hinders_every_column_is_told_once_and_all_of_it(
        self, folder: Path, capsys: Capture
    ) -> None:
        _, err = _said(capsys, folder / "rest.csv", expected=1)
        assert err.count("the unit of its values is not known") == 1
        assert err.count("its sampling rate is not known") == 1

    @pytest.mark.parametrize("column", ["t (ms)", "1"])
    def test_milliseconds_are_not_taken_for_seconds(
        self, tmp_path: Path, capsys: Capture, column: str
    ) -> None:
        path = tmp_path / "rest.csv"
        table = np.column_stack([np.arange(600) * 100.0, rates(600)])
        np.savetxt(path, table, delimiter=",", header="t (ms),gx", comments="")
        options = ("--unit", "deg/s", "--time-column", column)
        _, err = _said(capsys, path, *options, expected=1)
        assert "its time column is called 't (ms)'; give --time-unit ms" in err
        (found,) = _records(capsys, path, *options, "--time-unit", "ms")
        assert found["interval_s"] == pytest.approx(0.1)

    def test_two_columns_of_one_name_are_told_apart(self, tmp_path: Path, capsys: Capture) -> None:
        path = tmp_path / "rest.csv"
        table = np.column_stack([rates(600), 2.0 * rates(600, seed=2)])
        np.savetxt(path, table, delimiter=",", header="gx,gx", comments="")
        _, err = _said(capsys, path, *RATE, expected=1)
        assert "columns 1, 2 are all called 'gx'; choose one by its number" in err
        first, second = _records(capsys, path, *RATE, "--column", "1", "--column", "2")
        assert first["mean_dps"] != second["mean_dps"]

    def test_rows_that_no_filter_lets_pass_are_told(self, folder: Path, capsys: Capture) -> None:
        _, err = _said(
            capsys, folder / "rest.csv", *RATE, "--column", "gx", "--where", "gy=x", expected=1
        )
        assert "no row has gy=x; look at --where" in err

    def test_a_spike_is_told(self, tmp_path: Path, capsys: Capture) -> None:
        path, record = tmp_path / "rest.npy", rates(2000)
        record[1000] += 50.0
        np.save(path, record)
        (found,) = _records(capsys, path, *RATE)
        assert "At row 1001 the record leaps by 50 °/s" in " ".join(found["remarks"])

    def test_a_record_without_noise_is_named(self, tmp_path: Path, capsys: Capture) -> None:
        path = tmp_path / "rest.npy"
        np.save(path, rates(600))
        _, err = _said(capsys, path, *RATE, "--scale", "1e200", expected=1)
        assert err.startswith(f"{path}: the samples depart from the first by ")

    def test_gaps_are_refused_unless_allowed(self, tmp_path: Path, capsys: Capture) -> None:
        time_s = np.arange(1000) / RATE_HZ
        time_s[300:] += 2.0
        path = tmp_path / "gap.csv"
        np.savetxt(
            path, np.column_stack([time_s, rates(1000)]), delimiter=",", header="time,gx", comments=""
        )
        options = ("--unit", "deg/s", "--time-column", "time")
        _, err = _said(capsys, path, *options, expected=1)
        assert "the time stamp of row 301 comes 2.1 s after the one before (29.9 s), others 0.1 s" in err
        (found,) = _records(capsys, path, *options, "--gaps", "longest_stretch")
        assert found["samples"] == 700
        assert "1 gap in the record" in found["remarks"][0]

    def test_all_faults_of_the_options_are_told_at_once(self, folder: Path, capsys: Capture) -> None:
        options = shlex.split(
            "--unit dge/s --rate 100 --interval '1 s' --scale-factor 5 --zero-rate x --duty 2 --aperture '0 s'"
            " --window '2 s' '1 s' --where part --json - --csv - --plot a.gif --spec mmes50 --skip-rows -1"
            " --time-unit parsec --scale 0"
        )
        with pytest.raises(SystemExit) as ended:
            main(["analyse", str(folder / "rest.npy"), *options])
        assert ended.value.code == 2
        said = capsys.readouterr().err
        assert "is 'deg/s' meant?" in said
        assert "did you mean 'mems50'?" in said
        faulty = (
            "unit rate interval scale-factor zero-rate duty aperture window where csv plot spec skip-rows"
            " time-unit scale"
        )
        for option in faulty.split():
            assert f"\n  --{option}: " in said

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            ("--unit V", "--unit: values in 'V' need --scale-factor, e.g. '50 mV/(deg/s)'"),
            ("--unit deg/s --scale-factor '50 mV/(deg/s)'", "does not go with values in 'deg/s'"),
            ("--unit deg/s --zero-rate '2.5 V'", "'2.5 V' does not go with values in 'deg/s'"),
            (
                "--unit deg/s --rate '10 Hz' --aperture '1 s'",
                "'1 s' is longer than the interval of 0.1 s",
            ),
            ("--unit deg/s --rate '-10 Hz'", "--rate: '-10 Hz' must be more than 0"),
            ("--unit deg/s --time-unit sample", "'sample' needs --rate or --interval"),
            ("--unit deg/s --plot nowhere/a.pdf", "there is no folder nowhere"),
            ("--unit deg/s --json one.x --csv ./one.x", "--csv: 'one.x' is --json's already"),
            ("--unit deg/s --scale inf", "--scale: must be a finite number other than 0"),
            ("--unit deg/s --rate '1e-300 Hz'", "--rate: one sample in 1e+300 s is no gyro's"),
        ],
    )
    def test_options_that_do_not_fit_are_wrong_usage(
        self, folder: Path, capsys: Capture, options: str, message: str
    ) -> None:
        with pytest.raises(SystemExit) as ended:
            main(["analyse", str(folder / "rest.npy"), *_with_equals(shlex.split(options))])
        assert ended.value.code == 2
        assert message in capsys.readouterr().err

    def test_a_file_to_be_analysed_is_not_overwritten(self, tmp_path: Path, capsys: Capture) -> None:
        path = tmp_path / "rest.csv"
        path.write_text("gx\n1\n2\n", encoding="utf-8")
        with pytest.raises(SystemExit) as ended:
            main(["analyse", str(path), *RATE, "--csv", str(path)])
        assert ended.value.code == 2
        assert "would be overwritten" in capsys.readouterr().err
        assert path.read_text(encoding="utf-8") == "gx\n1\n2\n"


def _with_equals(options: list[str]) -> list[str]:
    """Join option and value: a value that begins with a minus is no option then."""
    return [f"{a}={b}" for a, b in zip(options[::2], options[1::2], strict=True)]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no full device")
@pytest.mark.parametrize("form", ["", "--json"])
@pytest.mark.parametrize("output", ["1>/dev/full", "1>&-"])
def test_standard_output_that_cannot_be_written_is_told(folder: Path, form: str, output: str) -> None:
    command = shlex.join([sys.executable, "-m", "gyrotest", "analyse", str(folder / "rest.npy"), *RATE])
    ended = subprocess.run(
        ["sh", "-c", f"{command} {form} {output}"], capture_output=True, text=True, check=False
    )
    assert ended.returncode == 1
    assert ended.stderr.startswith("standard output")
    assert len(ended.stderr.splitlines()) == 1


def test_a_reader_that_has_had_enough_is_no_fault(folder: Path) -> None:
    command = [sys.executable, "-m", "gyrotest", "analyse", str(folder / "rest.csv"), *RATE, "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as running:
        assert running.stdout is not None
        assert running.stderr is not None
        running.stdout.close()
        assert running.stderr.read() == b""
    assert running.returncode == 0


class TestProgress:
    def test_rows_are_counted_while_a_file_is_read(self) -> None:
        shown: list[str] = []
        spinner = Spinner(shown.append)
        spinner.reads("rest.csv")(65_536)
        spinner.analyses("rest.csv")
        assert shown == [
            "rest.csv …",
            "rest.csv: 65\N{THIN SPACE}536 rows read",
            "rest.csv: Allan deviation and noise model …",
        ]

    def test_nothing_is_loaded_that_the_tables_do_not_need(self, folder: Path) -> None:
        arguments = ["analyse", str(folder / "rest.npy"), *RATE]
        heavy = "matplotlib pyarrow pydantic h5py weasyprint pytest"
        source = (
            "import sys; from gyrotest.cli import main;"
            f" assert main({arguments!r}) == 0;"
            f" found = set({heavy!r}.split()) & set(sys.modules); assert not found, found"
        )
        done = subprocess.run(
            [sys.executable, "-c", source], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        assert done.stderr == ""


class TestRealRecordings:
    def test_all_axes_of_an_adis16405_are_analysed(self, real_data: Path, capsys: Capture) -> None:
        path = real_data / "adis16405-static" / "gyro_lsb.npz"
        records = _records(capsys, path, "--unit", "deg/s", "--scale", "0.05", "--rate", "100 Hz")
        assert [one["column"] for one in records] == [1, 2, 3]
        for record, mean_dps in zip(records, (0.351262, -0.427151, -0.285648), strict=True):
            assert record["mean_dps"] == pytest.approx(mean_dps, abs=1e-6)
            # Its own low-pass filter near 49 Hz rules the shortest averaging times.
            assert record["fit"]["first_tau_s"] > 0.01
            walk = record["angle_random_walk_deg_per_sqrt_s"]
            assert 60.0 * walk["value"] == pytest.approx(2.45, abs=0.2)
