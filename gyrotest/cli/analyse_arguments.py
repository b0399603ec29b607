"""The options of `gyrotest analyse`, as its `--help` shows them."""

import argparse
from pathlib import Path
from typing import Any

DESCRIPTION = """\
Allan deviation and noise identification of recorded files: text, CSV, npy, npz, MATLAB, HDF5, Parquet,
Arrow, or a recording of gyrotest. Each column gets a table with quantization noise Q, angle random walk N,
bias instability coefficient B, rate random walk K and rate ramp R, each with its 95 % interval, and the
Allan minimum. What a record does not resolve is an upper limit (≤)."""

EPILOG = """\
examples:
  gyrotest analyse rest.csv --column gz --unit deg/s --rate '100 Hz'
  gyrotest analyse rest.npy --unit V --scale-factor '50 mV/(deg/s)' --zero-rate '2.5 V' --rate '10 Hz'
  gyrotest analyse unit1.csv unit2.csv --spec mems50 --rate '1 Hz' --plot allan.pdf --json allan.json

Exit code: 0 all were analysed, 1 one could not be, 2 wrong usage."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the files and the options."""
    parser.add_argument(
        "files",
        nargs="+",
        type=Path,
        metavar="FILE",
        help="recorded files; a run's folder stands for its recordings",
    )
    _add_what(parser.add_argument_group("what is read of each file"))
    _add_meaning(parser.add_argument_group("what its numbers mean"))
    _add_output(parser.add_argument_group("what comes out, beside the tables"))


def _add_what(group: Any) -> None:
    group.add_argument(
        "--column",
        action="append",
        metavar="NAME|NUMBER",
        help="column to analyse, by name or by number from 1; more than once for several. "
        "Default: the columns that are called rates (gyro_x, gz, omega, rate …), or the only one",
    )
    group.add_argument(
        "--array", metavar="NAME", help="array, variable or data set that holds the columns"
    )
    group.add_argument(
        "--rate", metavar="'125 Hz'", help="samples a second, evenly spaced; or --interval"
    )
    group.add_argument("--interval", metavar="'8 ms'", help="time from sample to sample; or --rate")
    group.add_argument(
        "--time-column",
        metavar="NAME|NUMBER",
        help="column (or array) of time stamps, instead of --rate",
    )
    group.add_argument(
        "--time-unit",
        metavar="UNIT",
        help="its unit, e.g. ms (default: s); 'sample' where it numbers the samples",
    )
    group.add_argument(
        "--window",
        nargs=2,
        metavar=("BEGIN", "END"),
        help="only this part, counted from the first sample: --window '10 min' '2 h'",
    )
    group.add_argument(
        "--gaps",
        choices=("refuse", "longest_stretch"),
        default="refuse",
        help="where samples are missing: refuse (default), or use the longest part without a gap",
    )
    group.add_argument(
        "--where",
        action="append",
        metavar="COLUMN=CONTENT",
        help="of a table only the rows with this content",
    )
    group.add_argument(
        "--skip-rows",
        type=int,
        default=0,
        metavar="N",
        help="leave out N lines at the top of a text file",
    )


def _add_meaning(group: Any) -> None:
    group.add_argument(
        "--unit",
        metavar="UNIT",
        help="unit of the values: deg/s, rad/s, deg/h, V, mV, count … (default: what --spec or the file says)",
    )
    group.add_argument(
        "--scale",
        type=float,
        default=1.0,
        metavar="NUMBER",
        help="factor on the values, before the unit",
    )
    group.add_argument(
        "--scale-factor",
        metavar="'50 mV/(deg/s)'",
        help="output per rate, for a unit of volts or counts ('20 count/(deg/s)')",
    )
    group.add_argument("--zero-rate", metavar="'2.5 V'", help="output at rest, subtracted")
    group.add_argument(
        "--aperture",
        metavar="'16.7 ms'",
        help="time over which one sample is averaged, if shorter than the interval (dead time); or --duty",
    )
    group.add_argument(
        "--duty", type=float, metavar="0…1", help="part of each interval that is averaged; or --aperture"
    )
    group.add_argument(
        "--bandwidth", metavar="'50 Hz'", help="the gyro's, for the correction of dead time"
    )
    group.add_argument(
        "--spec",
        metavar="SPEC",
        help="a gyro model's spec (a path, a name in specs/, or a shipped one): its output gives unit, scale "
        "factor, zero rate and bandwidth, unless an option does; its datasheet stands beside the values",
    )


def _add_output(group: Any) -> None:
    for form in ("json", "csv"):
        group.add_argument(
            f"--{form}",
            nargs="?",
            const="-",
            metavar="FILE",
            help=f"all of it as {form.upper()} into a file; - or nothing: to standard output, instead of tables",
        )
    group.add_argument(
        "--plot",
        type=Path,
        metavar="FILE",
        help="the curves with their confidence bands, fit and datasheet: .pdf, .png or .svg",
    )
