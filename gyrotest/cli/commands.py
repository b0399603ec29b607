"""The commands, each with its options; what they need is loaded when they run."""

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from gyrotest import __version__
from gyrotest.cli.analyse import add_analyse
from gyrotest.cli.simulate import add_simulate
from gyrotest.errors import GyrotestError

Command = Callable[[argparse.Namespace], int]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit code: 0 all is well, 1 it is not, 2 wrong usage."""
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="replace")
    parsed = _parser().parse_args(arguments)
    command: Command = parsed.command
    try:
        return command(parsed)
    except GyrotestError as error:
        sys.stderr.write(f"{error}\n")
        return 1
    except KeyboardInterrupt:
        return 130


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="gyrotest",
        description="Production tests of gyroscopes. A test run itself is: pytest --gyro-spec SPEC --serial SN",
    )
    parser.add_argument("--version", action="version", version=f"gyrotest {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    add_analyse(commands)
    _add_check(commands.add_parser("check", help="check spec and station files"))
    _add_schema(commands.add_parser("schema", help="print the JSON Schema of specs or stations"))
    add_simulate(commands.add_parser("simulate", help="run a simulated instrument alone"))
    _add_report(commands.add_parser("report", help="make a run's certificate again"))
    _add_verify(
        commands.add_parser("verify", help="check a run's folder or a certificate for alterations")
    )
    _add_judge(
        commands.add_parser("judge", help="judge a run's recordings by another spec, as an amendment")
    )
    _add_recordings(commands.add_parser("recordings", help="look after recordings"))
    return parser


def _say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def _add_check(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE")
    parser.set_defaults(command=_check)


def _check(parsed: argparse.Namespace) -> int:
    from gyrotest.simulation.complaints import simulation_faults
    from gyrotest.specification.check import check_file

    faults = 0
    for path in parsed.files:
        try:
            _say(f"{path}: {check_file(path, simulation=simulation_faults)}")
        except GyrotestError as error:
            faults += 1
            sys.stderr.write(f"{error}\n")
    return int(faults > 0)


def _add_schema(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("what", choices=("spec", "station", "reference"))
    parser.set_defaults(command=_schema)


def _schema(parsed: argparse.Namespace) -> int:
    from gyrotest.specification.schema import json_schema, reference_markdown

    if parsed.what == "reference":
        sys.stdout.write(reference_markdown())
    else:
        _say(json.dumps(json_schema(parsed.what), indent=2, ensure_ascii=False))
    return 0


def _add_report(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", type=Path, metavar="RUN", help="the run's folder")
    parser.set_defaults(command=_report)


def _report(parsed: argparse.Namespace) -> int:
    from gyrotest.runner.again import report

    _say(f"{report(parsed.run)}")
    return 0


def _add_verify(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("paths", nargs="+", type=Path, metavar="RUN|PDF")
    parser.set_defaults(command=_verify)


def _verify(parsed: argparse.Namespace) -> int:
    from gyrotest.certificate.verify import verify_pdf, verify_run

    complaints = 0
    for path in parsed.paths:
        found = verify_run(path) if path.is_dir() else verify_pdf(path)
        complaints += len(found)
        _say(f"{path}: {'sound' if not found else 'NOT SOUND'}")
        for complaint in found:
            _say(f"  {complaint}")
    return int(complaints > 0)


def _add_judge(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", type=Path, metavar="RUN", help="the run's folder")
    parser.add_argument("--spec", required=True, type=Path, help="the spec to judge by")
    parser.set_defaults(command=_judge)


def _judge(parsed: argparse.Namespace) -> int:
    from gyrotest.records.result import Verdict
    from gyrotest.runner.again import judge_again
    from gyrotest.specification.spec import load_spec

    record, certificate = judge_again(parsed.run, load_spec(parsed.spec))
    _say(f"{record.serial_number}: {record.verdict.value.replace('_', ' ')}")
    _say(f"{certificate}")
    return int(record.verdict is not Verdict.PASS)


def _add_recordings(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(required=True, metavar="ACTION")
    verify = actions.add_parser("verify", help="say of each recording whether it is complete and sound")
    verify.add_argument("folder", type=Path, metavar="DIR", help="a run's folder, or one above several")
    verify.set_defaults(command=_recordings_verify)


def _recordings_verify(parsed: argparse.Namespace) -> int:
    from gyrotest.recordings.verify import verify_folder

    findings = verify_folder(parsed.folder)
    for finding in findings:
        _say(f"{finding}")
    if not findings:
        _say(f"{parsed.folder}: no recordings here")
    return int(not findings or not all(finding.good for finding in findings))
