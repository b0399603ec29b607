"""Figures of the simulated bench as a station gives them: quantities under known keys."""

import difflib
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from gyrotest.errors import Fault, UnitError
from gyrotest.records.station import Station
from gyrotest.units import Dimension, parse_quantity


@dataclass(frozen=True, slots=True)
class Figure:
    """A quantity that may be given: its dimension (canonical unit), default and sign.

    `pure`: a ratio that everybody writes as a number, `0.7`.
    """

    dimension: Dimension
    default: str
    positive: bool = False
    signed: bool = False
    pure: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Figures:
    """The values in canonical units, and what is wrong with those that are missing."""

    values: dict[str, float]
    faults: list[Fault]


def figures_of(
    given: Mapping[str, Any], keys: Mapping[str, Figure], prefix: str, also: Collection[str] = ()
) -> Figures:
    """Read the figures that were given under a prefix; `also` names keys that somebody else reads."""
    faults = [
        fault(f"{prefix}.{name}", f"unknown key{nearest(str(name), (*keys, *also))}")
        for name in given
        if name not in keys and name not in also
    ]
    values: dict[str, float] = {}
    for name, key in keys.items():
        try:
            value = _value(given.get(name, key.default), key)
        except UnitError as error:
            faults.append(fault(f"{prefix}.{name}", str(error)))
            continue
        if (value < 0.0 and not key.signed) or (value == 0.0 and key.positive):
            least = "more than zero" if key.positive else "zero or more"
            faults.append(fault(f"{prefix}.{name}", f"'{given.get(name)}' must be {least}"))
        values[name] = value
    return Figures(values=values, faults=faults)


def _value(given: Any, key: Figure) -> float:
    if key.pure and isinstance(given, int | float) and not isinstance(given, bool):
        return float(given)
    return parse_quantity(given, key.dimension).to(key.dimension)


def given_figures(station: Station, name: str) -> dict[str, Any]:
    """What the station's `simulation.instruments` says of an instrument."""
    return dict(station.simulation.instruments.get(name, {})) if station.simulation else {}


def nearest(name: str, known: Collection[str]) -> str:
    """A hint at what may have been meant."""
    close = difflib.get_close_matches(name, list(known), n=1)
    return f"; did you mean '{close[0]}'?" if close else f" (known: {', '.join(known)})"


def fault(key: str, message: str) -> Fault:
    """A complaint about a key of the station."""
    return Fault("", None, key, message)
