"""The measuring commands that all simulated multimeters understand, as functions of a meter."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from gyrotest.simulation.converter import RANGES_V, resolution
from gyrotest.simulation.meter import Meter
from gyrotest.simulation.meter_actions import ascii_reading, ascii_readings, getter, limits_query, setter
from gyrotest.simulation.meter_state import Settings
from gyrotest.simulation.scpi import (
    Action,
    Answer,
    ScpiError,
    block,
    boolean,
    keyword,
    none,
    number,
    one,
)

_LONGEST_DELAY_S = 3600.0
_MOST_TRIGGERS = 50_000


# Measurement function, range, integration time


def _configure(meter: Meter, parameters: Sequence[str]) -> None:
    if len(parameters) > 2:
        raise ScpiError(-108)
    kept = meter.settings
    settings = Settings(high_impedance=kept.high_impedance, binary=kept.binary, swapped=kept.swapped)
    if parameters and parameters[0].upper() not in {"AUTO", "DEF", "DEFAULT"}:
        settings.range_v = _range_for(parameters[0])
    if len(parameters) > 1 and parameters[1].upper() not in {"DEF", "DEFAULT"}:
        settings.nplc = _nplc_for_resolution(meter, parameters[1], settings.range_v or RANGES_V[2])
    meter.abort()
    meter.memory.clear()
    meter.settings = settings


def _range_for(text: str) -> float:
    wanted = number(text, least=0.0, most=RANGES_V[-1])
    # A range is chosen by the largest voltage expected; MIN and a tiny number give the lowest.
    return next(one for one in RANGES_V if wanted <= one)


def _nplc_for_resolution(meter: Meter, text: str, range_v: float) -> float:
    fine, coarse = (resolution(nplc) * range_v for nplc in (meter.model.nplc[-1], meter.model.nplc[0]))
    word = text.upper()
    if word in {"MIN", "MINIMUM"}:
        return meter.model.nplc[-1]
    if word in {"MAX", "MAXIMUM"}:
        return meter.model.nplc[0]
    wanted = number(text, least=-math.inf, most=math.inf)
    if wanted < fine * (1 - 1e-6):
        raise ScpiError(532)
    wanted = min(wanted, coarse)
    return next(nplc for nplc in meter.model.nplc if resolution(nplc) * range_v <= wanted * (1 + 1e-6))


def _set_range(meter: Meter, text: str) -> None:
    meter.settings.range_v = _range_for(text)


def _set_auto_range(meter: Meter, text: str) -> None:
    if text.upper() == "ONCE" or not boolean(text):
        meter.settings.range_v = meter.settings.range_v or RANGES_V[2]
    else:
        meter.settings.range_v = None


def _set_nplc(meter: Meter, text: str) -> None:
    choices = meter.model.nplc
    wanted = number(text, least=choices[0], most=choices[-1], default=10.0)
    meter.settings.nplc = next(choice for choice in choices if wanted <= choice * (1 + 1e-9))


def _set_resolution(meter: Meter, text: str) -> None:
    meter.settings.nplc = _nplc_for_resolution(meter, text, meter.settings.range_v or RANGES_V[2])


def set_autozero(meter: Meter, text: str) -> None:
    """`ZERO:AUTO OFF|ONCE|ON`; ONCE takes one zero measurement and switches off."""
    if text.upper() == "ONCE":
        meter.settings.autozero = False
        meter.now_s += meter.aperture_s
    else:
        meter.settings.autozero = boolean(text)


def set_impedance(meter: Meter, text: str) -> None:
    """Input impedance above 10 GΩ on the low ranges, or 10 MΩ."""
    meter.settings.high_impedance = boolean(text)


def _function(meter: Meter, parameters: Sequence[str]) -> None:
    if one(parameters).strip("\"'").upper() not in {"VOLT", "VOLT:DC", "VOLTAGE", "VOLTAGE:DC"}:
        raise ScpiError(-224)
    meter.abort()


def _configuration(meter: Meter) -> str:
    range_v = meter.settings.range_v or RANGES_V[2]
    return f'"VOLT {range_v:+.6E},{resolution(meter.settings.nplc) * range_v:+.6E}"'


# Trigger and samples


def _set_samples(meter: Meter, text: str) -> None:
    meter.settings.samples = round(number(text, least=1, most=meter.model.most_samples, default=1))


def _set_triggers(meter: Meter, text: str) -> None:
    infinite = text.upper() in {"INF", "INFINITY"}
    meter.settings.trigger_count = (
        math.inf if infinite else float(round(number(text, least=1, most=_MOST_TRIGGERS, default=1)))
    )


def _set_delay(meter: Meter, text: str) -> None:
    meter.settings.trigger_delay_s = number(text, least=0.0, most=_LONGEST_DELAY_S)


def _set_auto_delay(meter: Meter, text: str) -> None:
    meter.settings.trigger_delay_s = None if boolean(text) else meter.delay_s


def _set_trigger_source(meter: Meter, text: str) -> None:
    meter.settings.trigger_source = keyword(text, "IMMediate", "EXTernal", "BUS")


def _initiate(meter: Meter, parameters: Sequence[str]) -> None:
    none(parameters)
    meter.initiate()


def _trigger(meter: Meter, parameters: Sequence[str]) -> None:
    none(parameters)
    if not meter.waiting_for_trigger or meter.settings.trigger_source != "BUS":
        raise ScpiError(-211)
    meter.trigger()


def _abort(meter: Meter, parameters: Sequence[str]) -> None:
    none(parameters)
    meter.abort()


# Readings


def formatted(meter: Meter, values: Sequence[float]) -> Answer:
    """Readings in the format that is set."""
    if meter.settings.binary:
        return block(np.asarray(values, dtype="<f8" if meter.settings.swapped else ">f8").tobytes())
    return ascii_readings(values)


def _read(meter: Meter, parameters: Sequence[str]) -> Answer:
    none(parameters)
    meter.may_measure()
    meter.asked_for_readings()
    if meter.acquisition is not None and meter.busy():
        raise ScpiError(-213)
    if meter.settings.trigger_source != "IMM":
        raise ScpiError(-214)
    if meter.wanted == 1 and not meter.settings.binary:
        return ascii_reading(meter.read_one())
    if meter.model.keeps_newest:
        meter.initiate()
        meter.finish()
        return formatted(meter, meter.memory)
    return meter.read_through(ascii_readings)


def _measure(meter: Meter, parameters: Sequence[str]) -> Answer:
    _configure(meter, parameters)
    return _read(meter, ())


def _fetch(meter: Meter, parameters: Sequence[str]) -> Answer:
    none(parameters)
    meter.asked_for_readings()
    meter.finish()
    if not meter.memory:
        raise ScpiError(-230)
    return formatted(meter, meter.memory)


def _points(meter: Meter) -> str:
    meter.asked_for_readings()
    meter.catch_up()
    return f"{len(meter.memory):+d}"


def _most_voltage(meter: Meter) -> float:  # noqa: ARG001 - the same for all
    return RANGES_V[-1]


MEASURING: Mapping[str, Action[Meter]] = {
    "CONFigure[:VOLTage][:DC]": _configure,
    "CONFigure?": getter(_configuration),
    "MEASure[:VOLTage][:DC]?": _measure,
    "[SENSe:]FUNCtion[:ON]": _function,
    "[SENSe:]FUNCtion[:ON]?": getter(lambda _: '"VOLT"'),
    "[SENSe:]VOLTage[:DC]:RANGe[:UPPer]": setter(_set_range),
    "[SENSe:]VOLTage[:DC]:RANGe[:UPPer]?": limits_query(
        lambda meter: meter.settings.range_v or RANGES_V[2], lambda _: RANGES_V[0], _most_voltage
    ),
    "[SENSe:]VOLTage[:DC]:RANGe:AUTO": setter(_set_auto_range),
    "[SENSe:]VOLTage[:DC]:RANGe:AUTO?": getter(lambda meter: str(int(meter.settings.range_v is None))),
    "[SENSe:]VOLTage[:DC]:NPLCycles": setter(_set_nplc),
    "[SENSe:]VOLTage[:DC]:NPLCycles?": limits_query(
        lambda meter: meter.settings.nplc,
        lambda meter: meter.model.nplc[0],
        lambda meter: meter.model.nplc[-1],
    ),
    "[SENSe:]VOLTage[:DC]:RESolution": setter(_set_resolution),
    "[SENSe:]VOLTage[:DC]:RESolution?": limits_query(
        lambda meter: resolution(meter.settings.nplc) * (meter.settings.range_v or RANGES_V[2]),
        lambda meter: resolution(meter.model.nplc[-1]) * (meter.settings.range_v or RANGES_V[2]),
        lambda meter: resolution(meter.model.nplc[0]) * (meter.settings.range_v or RANGES_V[2]),
    ),
    "SAMPle:COUNt": setter(_set_samples),
    "SAMPle:COUNt?": limits_query(
        lambda meter: meter.settings.samples, lambda _: 1, lambda meter: meter.model.most_samples
    ),
    "TRIGger:COUNt": setter(_set_triggers),
    "TRIGger:COUNt?": limits_query(
        lambda meter: meter.settings.trigger_count, lambda _: 1, lambda _: _MOST_TRIGGERS
    ),
    "TRIGger:DELay": setter(_set_delay),
    "TRIGger:DELay?": limits_query(
        lambda meter: meter.delay_s, lambda _: 0.0, lambda _: _LONGEST_DELAY_S
    ),
    "TRIGger:DELay:AUTO": setter(_set_auto_delay),
    "TRIGger:DELay:AUTO?": getter(lambda meter: str(int(meter.settings.trigger_delay_s is None))),
    "TRIGger:SOURce": setter(_set_trigger_source),
    "TRIGger:SOURce?": getter(lambda meter: meter.settings.trigger_source),
    "INITiate[:IMMediate]": _initiate,
    "*TRG": _trigger,
    "ABORt": _abort,
    "READ?": _read,
    "FETCh?": _fetch,
    "DATA:POINts?": getter(_points),
}
