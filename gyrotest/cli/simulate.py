"""`gyrotest simulate`: a simulated instrument alone, for any program."""

import argparse
import sys
from typing import Any

_INSTRUMENTS = ("meter", "table", "supply", "chamber", "generator", "stim210", "stim300", "line", "daq")
_MODELS = ("34401A", "34465A", "acutrol3000", "aerosmith")


def add_simulate(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the command."""
    parser.add_argument(
        "instrument",
        choices=_INSTRUMENTS,
        help="what is served; stim210, stim300 and line (a board that prints lines) are gyros themselves, daq"
        " is a server of the block protocol",
    )
    parser.add_argument(
        "--port", type=int, help="TCP port (0: any free one; default 5025, for a table 9878, daq 5030)"
    )
    parser.add_argument(
        "--pty", action="store_true", help="serve a pseudo-terminal instead (not on Windows)"
    )
    parser.add_argument("--model", choices=_MODELS, help="of a meter or a table")
    parser.add_argument("--serial", default="1234", help="serial number of the gyro")
    parser.add_argument("--scenario", default="nominal")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--fast", action="store_true", help="do not let time pass: meters, gyros, daq")
    parser.add_argument("--frame", help="of a stim210 or stim300: the kind of frame that it sends")
    parser.add_argument("--rate", help="of a gyro that sends by itself: samples a second, e.g. '125 Hz'")
    parser.add_argument("--format", help="of a line: e.g. '{counter},{x:.5f},{y:.5f},{z:.5f}'")
    parser.set_defaults(command=_simulate)


def _simulate(parsed: argparse.Namespace) -> int:
    from gyrotest.simulation.serve import KINDS, serve

    serve(
        parsed.instrument,
        model=parsed.model,
        port=KINDS[parsed.instrument].port if parsed.port is None else parsed.port,
        pty=parsed.pty,
        fast=parsed.fast,
        serial_number=parsed.serial,
        scenario=parsed.scenario,
        seed=parsed.seed,
        figures=_figures(parsed),
        announce=_announce,
    )
    return 0


def _figures(parsed: argparse.Namespace) -> dict[str, Any]:
    given = {"frame": parsed.frame, "sample_rate": parsed.rate, "format": parsed.format}
    return {name: value for name, value in given.items() if value is not None}


def _announce(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()
