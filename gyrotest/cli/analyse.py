"""`gyrotest analyse`: the static procedure's analysis of recorded files, without a test run."""

import argparse
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrotest.cli.analyse_arguments import DESCRIPTION, EPILOG, add_arguments
from gyrotest.errors import GyrotestError

if TYPE_CHECKING:
    from gyrotest.cli.analyse_options import Wanted
    from gyrotest.cli.analyse_progress import Silence
    from gyrotest.offline.analysis import Analysis
    from gyrotest.offline.sources import Source

_WIDTH = 110  # of the tables, where no terminal says how wide it is


def add_analyse(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command and its options."""
    parser = commands.add_parser(
        "analyse",
        help="Allan deviation and noise of recorded files",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        usage="gyrotest analyse FILE… [options]",
    )
    add_arguments(parser)
    parser.set_defaults(command=lambda parsed: _analyse(parser, parsed))


def _analyse(parser: argparse.ArgumentParser, parsed: argparse.Namespace) -> int:
    from gyrotest.cli.analyse_options import FaultyOptionsError, wanted

    try:
        asked = wanted(parsed)
    except FaultyOptionsError as faults:
        parser.error("\n  ".join(("", *faults.faults)))
    analyses, refused = _analyses(parsed.files, asked)
    _write(analyses, refused, asked)
    return int(bool(refused))


def _analyses(files: Sequence[Path], asked: "Wanted") -> tuple[list["Analysis"], list[str]]:
    """Analyse one column after another: what is refused does not keep the others from it."""
    from gyrotest.cli.analyse_progress import watched
    from gyrotest.offline.record import check_known
    from gyrotest.offline.sources import sources_of

    analyses: list[Analysis] = []
    refused: list[str] = []
    with watched() as progress:
        for path in _named(files, refused):
            try:
                sources = sources_of(path, asked.request)
                check_known(path, asked.request)
            except GyrotestError as error:
                _refuse(refused, error)
                continue
            for source in sources:
                try:
                    analyses.append(_one(source, asked, progress))
                except GyrotestError as error:
                    _refuse(refused, error)
    return analyses, refused


def _named(files: Sequence[Path], refused: list[str]) -> Iterator[Path]:
    """Yield the files, and those of runs' folders, each once."""
    from gyrotest.offline.files import files_of

    seen: set[Path] = set()
    for name in files:
        try:
            found = files_of(name)
        except GyrotestError as error:
            _refuse(refused, error)
            continue
        yield from (path for path in found if path not in seen)
        seen.update(found)


def _one(source: "Source", asked: "Wanted", progress: "Silence") -> "Analysis":
    from gyrotest.offline.analysis import analysed
    from gyrotest.offline.record import placed, rate_record

    request = asked.request
    record = rate_record(source, request, progress.reads(source.path.name))
    progress.analyses(source.path.name)
    try:
        return analysed(record, bandwidth_hz=request.bandwidth_hz, datasheet=request.datasheet)
    except GyrotestError as error:
        raise placed(error, source) from error


def _refuse(refused: list[str], error: GyrotestError) -> None:
    if str(error) in refused:
        return  # what hinders every column of a file
    refused.append(str(error))
    sys.stderr.write(f"{error}\n")


def _write(analyses: list["Analysis"], refused: list[str], asked: "Wanted") -> None:
    if asked.plot is not None and analyses:
        from gyrotest.certificate.figures import image
        from gyrotest.offline.figure import allan_plot

        _save(asked.plot, image(allan_plot(analyses), asked.plot_format))
    if asked.json is not None:
        from gyrotest.offline.to_json import json_text

        _put(json_text(analyses, refused, asked.spec), asked.json)
    if asked.csv is not None:
        from gyrotest.offline.to_csv import csv_text

        _put(csv_text(analyses), asked.csv)
    if "-" not in (asked.json, asked.csv):
        from gyrotest.offline.table import tables

        with _standard_output():
            sys.stdout.write(tables(_console(), analyses))


def _put(text: str, target: str) -> None:
    if target == "-":
        with _standard_output():
            getattr(sys.stdout, "reconfigure", _ignored)(encoding="utf-8")  # as in a file
            sys.stdout.write(text)
    else:
        _save(Path(target), text.encode())


@contextmanager
def _standard_output() -> Iterator[None]:
    """Write to standard output: no fault where a reader has had enough, `GyrotestError` for any other."""
    if sys.stdout is None:
        raise GyrotestError("standard output is closed; give --json, --csv or --plot a file")
    try:
        yield
        sys.stdout.flush()
    except OSError as error:
        # What is left in the buffer would be written, and fail, at the end of the process once more.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            raise GyrotestError(f"standard output: cannot be written: {error.strerror}") from error


def _ignored(*, encoding: str) -> None:
    del encoding


def _save(path: Path, content: bytes) -> None:
    try:
        path.write_bytes(content)
    except OSError as error:
        raise GyrotestError(f"{path}: cannot be written: {error.strerror}") from error


def _console() -> Any:
    from rich.console import Console

    console = Console(file=sys.stdout, highlight=False)
    return console if console.is_terminal else Console(file=sys.stdout, highlight=False, width=_WIDTH)
