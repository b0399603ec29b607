"""The multimeters that are simulated: HP/Agilent 34401A and Keysight 34465A."""

import functools
import math
from collections.abc import Mapping, Sequence

from gyrotest.simulation.meter import Meter
from gyrotest.simulation.meter_actions import ascii_readings, getter, limits_query, setter
from gyrotest.simulation.meter_commands import MEASURING, formatted, set_autozero, set_impedance
from gyrotest.simulation.meter_state import Model
from gyrotest.simulation.meter_system import SYSTEM
from gyrotest.simulation.scpi import Action, Answer, ScpiError, Table, block, keyword, none, number, one

_LONGEST_TIMER_S = 3600.0
_MEASURING, _WAITING = 1 << 4, 1 << 5

AGILENT_34401A = Model(
    name="34401A",
    manufacturer="HEWLETT-PACKARD",
    firmware="11-5-2",
    scpi_version="1991.0",
    nplc=(0.02, 0.2, 1.0, 10.0, 100.0),
    memory=512,
    keeps_newest=False,
    most_samples=50_000,
    delay_each_sample=True,
    serial_needs_remote=True,
)

KEYSIGHT_34465A = Model(
    name="34465A",
    manufacturer="Keysight Technologies",
    firmware="A.03.03-03.15-03.03-00.52-05-02",
    scpi_version="1994.0",
    nplc=(0.02, 0.06, 0.2, 1.0, 10.0, 100.0),
    memory=50_000,
    keeps_newest=True,
    most_samples=1_000_000_000,
    delay_each_sample=False,
    serial_needs_remote=False,
)

MODELS: Mapping[str, Model] = {model.name: model for model in (AGILENT_34401A, KEYSIGHT_34465A)}


def _autozero(meter: Meter) -> str:
    return str(int(meter.settings.autozero))


def _impedance(meter: Meter) -> str:
    return str(int(meter.settings.high_impedance))


_ONLY_34401A: Mapping[str, Action[Meter]] = {
    "[SENSe:]ZERO:AUTO": setter(set_autozero),
    "[SENSe:]ZERO:AUTO?": getter(_autozero),
    "INPut:IMPedance:AUTO": setter(set_impedance),
    "INPut:IMPedance:AUTO?": getter(_impedance),
}


def _set_sample_source(meter: Meter, text: str) -> None:
    meter.settings.timed = keyword(text, "IMMediate", "TIMer") == "TIM"


def _set_timer(meter: Meter, text: str) -> None:
    # An interval too short to be kept is not refused; the meter then runs as fast as it can.
    wanted = number(text, least=1e-6, most=_LONGEST_TIMER_S, default=1.0)
    if text.upper() in {"MIN", "MINIMUM"}:
        wanted = meter.shortest_timer_s
    meter.settings.timer_s = meter.quantised_timer(wanted)


def _set_format(meter: Meter, parameters: Sequence[str]) -> None:
    if not parameters:
        raise ScpiError(-109)
    binary = keyword(parameters[0], "ASCii", "REAL") == "REAL"
    if binary and parameters[1:] not in ((), ("64",)):
        raise ScpiError(-224)
    meter.settings.binary = binary


def _format(meter: Meter) -> str:
    return "REAL,64" if meter.settings.binary else "ASC,9"


def _set_border(meter: Meter, parameters: Sequence[str]) -> None:
    meter.settings.swapped = keyword(one(parameters), "NORMal", "SWAPped") == "SWAP"


def _take(meter: Meter, most: int) -> Answer:
    values = [meter.memory.popleft() for _ in range(min(most, len(meter.memory)))]
    answer = formatted(meter, values)
    return answer if meter.settings.binary else block(ascii_readings(values))


def _read_and_erase(meter: Meter, parameters: Sequence[str]) -> Answer:
    meter.asked_for_readings()
    meter.catch_up()
    most = number(one(parameters), least=1, most=2_000_000) if parameters else math.inf
    return _take(meter, int(min(most, len(meter.memory))))


def _remove(meter: Meter, parameters: Sequence[str]) -> Answer:
    if not parameters:
        raise ScpiError(-109)
    wanted = int(number(parameters[0], least=1, most=2_000_000))
    meter.asked_for_readings()
    if len(parameters) > 1:
        keyword(parameters[1], "WAIT")
        meter.wait_for(wanted)
    meter.catch_up()
    if len(meter.memory) < wanted:
        raise ScpiError(-222)
    values = [meter.memory.popleft() for _ in range(wanted)]
    return formatted(meter, values)


def _last(meter: Meter) -> str:
    meter.asked_for_readings()
    meter.catch_up()
    value = meter.memory[-1] if meter.memory else 9.91e37
    return f"{value:+.8E} VDC"


def _questionable_condition(meter: Meter) -> str:
    meter.catch_up()
    return f"{meter.memory_overflowed << 14:+d}"


def _operation_condition(meter: Meter) -> str:
    meter.catch_up()
    measuring = _MEASURING if meter.acquisition is not None else 0
    return f"{measuring | (_WAITING if meter.waiting_for_trigger else 0):+d}"


def _preset(meter: Meter, parameters: Sequence[str]) -> None:
    none(parameters)
    meter.status.questionable_enable = 0


_ONLY_34465A: Mapping[str, Action[Meter]] = {
    "[SENSe:]VOLTage[:DC]:ZERO:AUTO": setter(set_autozero),
    "[SENSe:]VOLTage[:DC]:ZERO:AUTO?": getter(_autozero),
    "[SENSe:]VOLTage[:DC]:IMPedance:AUTO": setter(set_impedance),
    "[SENSe:]VOLTage[:DC]:IMPedance:AUTO?": getter(_impedance),
    "SAMPle:SOURce": setter(_set_sample_source),
    "SAMPle:SOURce?": getter(lambda meter: "TIM" if meter.settings.timed else "IMM"),
    "SAMPle:TIMer": setter(_set_timer),
    "SAMPle:TIMer?": limits_query(
        lambda meter: meter.settings.timer_s,
        lambda meter: meter.shortest_timer_s,
        lambda _: _LONGEST_TIMER_S,
    ),
    "FORMat[:DATA]": _set_format,
    "FORMat[:DATA]?": getter(_format),
    "FORMat:BORDer": _set_border,
    "FORMat:BORDer?": getter(lambda meter: "SWAP" if meter.settings.swapped else "NORM"),
    "R?": _read_and_erase,
    "DATA:REMove?": _remove,
    "DATA:LAST?": getter(_last),
    "STATus:QUEStionable:CONDition?": getter(_questionable_condition),
    "STATus:OPERation:CONDition?": getter(_operation_condition),
    "STATus:PRESet": _preset,
    "SYSTem:LFRequency?": getter(lambda meter: f"{meter.line_frequency_hz:+.0f}"),
}


@functools.cache
def command_table(name: str) -> Table[Meter]:
    """The command table of a model."""
    own = {AGILENT_34401A.name: _ONLY_34401A, KEYSIGHT_34465A.name: _ONLY_34465A}
    return Table({**SYSTEM, **MEASURING, **own[name]})
