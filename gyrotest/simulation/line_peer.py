"""Any board that prints lines, on the simulated bench: the unit under test itself, on a serial line."""

import string
from collections.abc import Mapping

from gyrotest.errors import StationError, UnitError
from gyrotest.records.spec import OutputKind
from gyrotest.records.station import Station
from gyrotest.simulation.emitter import Emitter
from gyrotest.simulation.figures import Figure, fault, figures_of, given_figures
from gyrotest.simulation.housed import Housed
from gyrotest.simulation.line_voice import Board, LineVoice
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.outlet import Outlet
from gyrotest.simulation.peer import Making
from gyrotest.units import Dimension, parse_quantity

_FIGURES = {"sample_rate": Figure(Dimension.FREQUENCY, "100 Hz", positive=True)}
_TEXTS = ("format", "reply")
_REPLY = "SN {serial_number}"
_MODULUS = 65_536


class LinePeer:
    """A board that prints a line for each sample, as its driver expects them.

    `simulation.instruments` may say with `format` what a line is (`{counter},{x:.5f},{temperature:.2f}`)
    and with `reply` what is said to the question for the serial number (`SN {serial_number}`).
    """

    kinds = frozenset(OutputKind)

    def __init__(self, making: Making) -> None:
        self._emitter = Emitter(making, LineVoice(_board(making.station, making.name)))

    @staticmethod
    def check(station: Station, name: str) -> None:
        """Raise `StationError` with all complaints about this board's figures."""
        _board(station, name)

    def begin(self, occasion: Occasion) -> None:
        """Nothing: what a unit is, its slot tells."""

    def truth(self) -> Mapping[str, float]:
        """Nothing beside the unit's own figures."""
        return {}

    def house(self, housed: Housed) -> None:
        """Be this unit from now on, for its next record."""
        self._emitter.house(housed)

    def transmit(self, now_s: float, outlet: Outlet) -> None:
        """Send all that is due by now."""
        self._emitter.transmit(now_s, outlet)


def _board(station: Station, name: str) -> Board:
    """What the board prints and how often; raises `StationError` with all complaints at once."""
    key = f"simulation.instruments.{name}"
    simulated = given_figures(station, name)
    settings = station.instruments[name].settings
    known = {one: settings[one] for one in _FIGURES if one in settings}
    figures = figures_of({**known, **simulated}, _FIGURES, key, also=_TEXTS)
    faults = figures.faults
    for text in _TEXTS:
        try:
            list(string.Formatter().parse(str(simulated.get(text, ""))))
        except ValueError as error:
            faults.append(fault(f"{key}.{text}", f"'{simulated[text]}': {error}"))
    if faults:
        raise StationError(faults)
    given = simulated.get("format")
    return Board(
        key=key,
        rate_hz=figures.values["sample_rate"],
        form=None if given is None else str(given),
        columns=tuple(str(one) for one in settings.get("columns", ())),
        separator=str(settings.get("separator", ",")) or " ",
        units=_units(settings.get("channels", {})) | _units(settings.get("auxiliary", {})),
        counter=str(settings.get("counter", "")),
        modulus=int(settings.get("counter_modulus") or _MODULUS),
        step=int(settings.get("counter_step", 1)),
        start=str(settings.get("start", "")).encode(),
        stop=str(settings.get("stop", "")).encode(),
        question=str(settings.get("ask_serial_number", "")).encode(),
        reply=str(simulated.get("reply", _REPLY)),
    )


def _units(given: object) -> dict[str, float]:
    """What a number 1 stands for, by column, in canonical units; the driver refuses what is none."""
    found = {}
    for name, text in given.items() if isinstance(given, Mapping) else ():
        for dimension in (
            Dimension.RATE,
            Dimension.VOLTAGE,
            Dimension.COUNT,
            Dimension.TEMPERATURE,
        ):
            try:
                found[str(name)] = parse_quantity(text, dimension).to(dimension)
            except UnitError:
                continue
    return found
