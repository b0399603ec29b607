"""The SCPI commands of a simulated scanner."""

import functools
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from gyrotest.ports import Clock
from gyrotest.simulation.interpreter import Interpreter, common_commands, doer, getter
from gyrotest.simulation.scanner import (
    MEMORY,
    NPLC,
    RANGES_V,
    Channel,
    ScannerSpeaker,
    SimulatedScanner,
)
from gyrotest.simulation.scpi import Action, ScpiError, Table, block, boolean, keyword, none, number, one

Scanner = SimulatedScanner

_LIST = re.compile(r"\(@([\d:,\s]*)\)")
_LONGEST_TIMER_S = 359_999.0
_MOST_TRIGGERS = 50_000
_TIMER_STEP_S = 1e-3
_PROBES = {
    "TC": ("B", "E", "J", "K", "N", "R", "S", "T"),
    "RTD": ("85", "91"),
    "FRTD": ("85", "91"),
    "THER": ("2252", "5000", "10000"),
}


def speaker_of(scanner: SimulatedScanner, clock: Clock, *, newer: bool = False) -> ScannerSpeaker:
    """The scanner's front end; `newer`: with the words of a DAQ970A."""
    return ScannerSpeaker(scanner, Interpreter(scanner, command_table(newer=newer), clock))


@dataclass(frozen=True, slots=True)
class _Meant:
    """The channels of a command, and its other parameters."""

    channels: tuple[int, ...]
    parameters: tuple[str, ...]


def _meant(scanner: Scanner, parameters: Sequence[str]) -> _Meant:
    """Take the channel list apart; without one the scan list is meant."""
    start = next((place for place, text in enumerate(parameters) if text.startswith("(@")), None)
    if start is None:
        return _Meant(scanner.settings.scan_list, tuple(parameters))
    found = _LIST.fullmatch(",".join(parameters[start:]))
    if found is None:
        raise ScpiError(-102)
    return _Meant(_listed(scanner, found[1]), tuple(parameters[:start]))


def _listed(scanner: Scanner, text: str) -> tuple[int, ...]:
    channels: list[int] = []
    for part in filter(None, map(str.strip, text.split(","))):
        first, _, last = part.partition(":")
        channels += range(int(first), int(last or first) + 1)
    for channel in channels:
        scanner.channel(channel)
    return tuple(channels)


def _changes(scanner: Scanner) -> None:
    """A change of the measurement ends the scan and clears its readings."""
    scanner.abort()
    scanner.memory.clear()


def _configure(scanner: Scanner, meant: _Meant, channel: Channel) -> None:
    """CONF: the channels from their resting state on, the scan list anew, nothing beside the readings."""
    _changes(scanner)
    for wanted in meant.channels:
        scanner.settings.channels[wanted] = Channel(
            range_v=channel.range_v, probe=channel.probe, kind=channel.kind
        )
    scanner.settings.scan_list = tuple(sorted(set(meant.channels)))
    form = scanner.settings.form
    form.time = form.channel = form.unit = form.alarm = False


def _configure_voltage(scanner: Scanner, parameters: Sequence[str]) -> None:
    meant = _meant(scanner, parameters)
    range_v = None
    if meant.parameters and meant.parameters[0].upper() not in {"AUTO", "DEF"}:
        wanted = number(meant.parameters[0], least=0.0, most=RANGES_V[-1])
        range_v = next(one for one in RANGES_V if wanted <= one)
    _configure(scanner, meant, Channel(range_v=range_v))


def _configure_temperature(scanner: Scanner, parameters: Sequence[str]) -> None:
    meant = _meant(scanner, parameters)
    if len(meant.parameters) < 2:
        raise ScpiError(-109)
    probe = keyword(meant.parameters[0], "TCouple", "RTD", "FRTD", "THERmistor")
    if meant.parameters[1].upper() not in _PROBES[probe]:
        raise ScpiError(-224)
    _configure(scanner, meant, Channel(probe=probe, kind=meant.parameters[1].upper()))


def _for_channels(change: Callable[[Channel, str], None]) -> Action[Scanner]:
    def action(scanner: Scanner, parameters: Sequence[str]) -> None:
        meant = _meant(scanner, parameters)
        text = one(meant.parameters)
        _changes(scanner)
        for channel in meant.channels:
            change(scanner.channel(channel), text)

    return action


def _of_channels(value: Callable[[Channel], str]) -> Action[Scanner]:
    def action(scanner: Scanner, parameters: Sequence[str]) -> str:
        meant = _meant(scanner, parameters)
        none(meant.parameters)
        return ",".join(value(scanner.channel(channel)) for channel in meant.channels)

    return action


def _set_nplc(channel: Channel, text: str) -> None:
    wanted = number(text, least=NPLC[0], most=NPLC[-1], default=1.0)
    channel.nplc = next(one for one in NPLC if wanted <= one * (1 + 1e-9))


def _set_autozero(channel: Channel, text: str) -> None:
    channel.autozero = boolean(text)


def _set_impedance(channel: Channel, text: str) -> None:
    channel.high_impedance = boolean(text)


def _set_delay(channel: Channel, text: str) -> None:
    channel.delay_s = number(text, least=0.0, most=60.0)


def _set_unit(channel: Channel, text: str) -> None:  # noqa: ARG001 - the same for all
    if text.upper() != "C":
        raise ScpiError(-224)  # this scanner knows degrees Celsius alone


def _set_scan_list(scanner: Scanner, parameters: Sequence[str]) -> None:
    meant = _meant(scanner, parameters)
    none(meant.parameters)
    _changes(scanner)
    scanner.settings.scan_list = tuple(sorted(set(meant.channels)))


def _scan_list(scanner: Scanner, parameters: Sequence[str]) -> bytes:
    none(parameters)
    return block(f"(@{','.join(map(str, scanner.settings.scan_list))})".encode())


def _set_source(scanner: Scanner, parameters: Sequence[str]) -> None:
    _changes(scanner)
    scanner.settings.trigger_source = keyword(one(parameters), "IMMediate", "TIMer")


def _set_count(scanner: Scanner, parameters: Sequence[str]) -> None:
    text = one(parameters)
    _changes(scanner)
    infinite = text.upper() in {"INF", "INFINITY"}
    scanner.settings.trigger_count = (
        math.inf if infinite else float(round(number(text, least=1, most=_MOST_TRIGGERS)))
    )


def _count(scanner: Scanner) -> str:
    count = scanner.settings.trigger_count
    return f"{9.9e37 if math.isinf(count) else count:+.8E}"


def _set_timer(scanner: Scanner, parameters: Sequence[str]) -> None:
    wanted_s = number(one(parameters), least=0.0, most=_LONGEST_TIMER_S)
    _changes(scanner)
    scanner.settings.timer_s = round(wanted_s / _TIMER_STEP_S) * _TIMER_STEP_S


def _set_form(name: str) -> Action[Scanner]:
    def action(scanner: Scanner, parameters: Sequence[str]) -> None:
        setattr(scanner.settings.form, name, boolean(one(parameters)))

    return action


def _form(name: str) -> Action[Scanner]:
    return getter(lambda scanner: str(int(getattr(scanner.settings.form, name))))


def _set_time_type(scanner: Scanner, parameters: Sequence[str]) -> None:  # noqa: ARG001 - the same for all
    if keyword(one(parameters), "ABSolute", "RELative") != "REL":
        raise ScpiError(-221)  # this scanner has no calendar


def _read(scanner: Scanner, parameters: Sequence[str]) -> bytes:
    most = number(one(parameters), least=1, most=MEMORY) if parameters else math.inf
    form = scanner.settings.form
    fields: list[str] = []
    for reading in scanner.take(most):
        unit = " C" if scanner.channel(reading.channel).probe else " VDC"
        fields.append(f"{reading.value:+.8E}{unit if form.unit else ''}")
        if form.time:
            fields.append(f"{reading.time_s:012.3f}")
        if form.channel:
            fields.append(str(reading.channel))
        if form.alarm:
            fields.append("0")
    return block(",".join(fields).encode())


def _points(scanner: Scanner) -> str:
    scanner.catch_up()
    return f"{len(scanner.memory):+d}"


def _questionable(scanner: Scanner) -> str:
    scanner.catch_up()
    event, scanner.questionable = scanner.questionable, 0
    return f"{event:+d}"


def _condition(scanner: Scanner) -> str:
    scanner.catch_up()
    return f"{scanner.questionable:+d}"


def _with_queries(
    header: str, change: Callable[[Channel, str], None], value: Callable[[Channel], str]
) -> Mapping[str, Action[Scanner]]:
    return {header: _for_channels(change), f"{header}?": _of_channels(value)}


def _form_commands() -> Mapping[str, Action[Scanner]]:
    names = {"TIME": "time", "CHANnel": "channel", "UNIT": "unit", "ALARm": "alarm"}
    return {
        **{f"FORMat:READing:{header}": _set_form(name) for header, name in names.items()},
        **{f"FORMat:READing:{header}?": _form(name) for header, name in names.items()},
        "FORMat:READing:TIME:TYPE": _set_time_type,
        "FORMat:READing:TIME:TYPE?": getter(lambda _: "REL"),
    }


@functools.cache
def command_table(*, newer: bool) -> Table[SimulatedScanner]:
    """The commands of a 34970A, or of a DAQ970A."""
    volt = "[SENSe:]VOLTage[:DC]"
    zero, impedance = (
        (f"{volt}:ZERO:AUTO", f"{volt}:IMPedance:AUTO")
        if newer
        else ("[SENSe:]ZERO:AUTO", "INPut:IMPedance:AUTO")
    )
    return Table(
        {
            **common_commands(),
            "CONFigure:VOLTage[:DC]": _configure_voltage,
            "CONFigure:TEMPerature": _configure_temperature,
            f"{volt}:RANGe?": _of_channels(lambda channel: f"{channel.range_v or 10.0:+.8E}"),
            **_with_queries(f"{volt}:NPLCycles", _set_nplc, lambda channel: f"{channel.nplc:+.8E}"),
            **_with_queries(
                "[SENSe:]TEMPerature:NPLCycles", _set_nplc, lambda channel: f"{channel.nplc:+.8E}"
            ),
            **_with_queries(zero, _set_autozero, lambda channel: str(int(channel.autozero))),
            **_with_queries(impedance, _set_impedance, lambda channel: str(int(channel.high_impedance))),
            **_with_queries("UNIT:TEMPerature", _set_unit, lambda _: "C"),
            "[SENSe:]TEMPerature:TRANsducer:TYPE?": _of_channels(lambda channel: channel.probe or "TC"),
            "ROUTe:CHANnel:DELay": _for_channels(_set_delay),
            "ROUTe:SCAN": _set_scan_list,
            "ROUTe:SCAN?": _scan_list,
            "ROUTe:SCAN:SIZE?": getter(lambda scanner: f"{len(scanner.settings.scan_list):+d}"),
            "TRIGger:SOURce": _set_source,
            "TRIGger:SOURce?": getter(lambda scanner: scanner.settings.trigger_source),
            "TRIGger:COUNt": _set_count,
            "TRIGger:COUNt?": getter(_count),
            "TRIGger:TIMer": _set_timer,
            "TRIGger:TIMer?": getter(lambda scanner: f"{scanner.settings.timer_s:+.8E}"),
            **_form_commands(),
            "INITiate[:IMMediate]": doer(SimulatedScanner.initiate),
            "ABORt": doer(SimulatedScanner.abort),
            "R?": _read,
            "DATA:POINts?": getter(_points),
            "STATus:QUEStionable[:EVENt]?": getter(_questionable),
            "STATus:QUEStionable:CONDition?": getter(_condition),
        }
    )
