"""The SCPI commands of a simulated waveform generator, as far as a drive needs them, and those beside."""

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from gyrotest.ports import Clock
from gyrotest.simulation.generator import (
    LEAST_HZ,
    LEAST_NOISE_HZ,
    MOST_HZ,
    NOISE,
    SINE,
    SimulatedGenerator,
    SimulatedWaveform,
    Wave,
    load_share,
)
from gyrotest.simulation.interpreter import Interpreter, common_commands
from gyrotest.simulation.scpi import Action, ScpiError, Table, boolean, keyword, none, number, one

Generator = SimulatedGenerator
Change = Callable[[Wave, str], Wave]
Show = Callable[[Wave], str]

_INFINITE = "+9.9000000000000000E+37"
_FUNCTIONS = ("SINusoid", "NOISe")
_LONGEST_SWEEP_S = 250_000.0


def speaker_of(generator: SimulatedGenerator, clock: Clock) -> Interpreter[SimulatedGenerator]:
    """The generator's front end."""
    return Interpreter(generator, command_table(), clock)


def _output(generator: Generator, which: int) -> SimulatedWaveform:
    if which not in generator.outputs:
        raise ScpiError(-114)
    return generator.outputs[which]


def _setter(which: int, change: Change) -> Action[Generator]:
    def action(generator: Generator, parameters: Sequence[str]) -> None:
        output = _output(generator, which)
        output.set(generator.now_s, change(output.wave, one(parameters)))

    return action


def _getter(which: int, show: Show) -> Action[Generator]:
    def action(generator: Generator, parameters: Sequence[str]) -> str:
        none(parameters)
        return show(_output(generator, which).wave)

    return action


def _is_on(which: int) -> Action[Generator]:
    def action(generator: Generator, parameters: Sequence[str]) -> str:
        none(parameters)
        return str(int(_output(generator, which).is_on(generator.now_s)))

    return action


def _trigger(which: int) -> Action[Generator]:
    def action(generator: Generator, parameters: Sequence[str]) -> None:
        none(parameters)
        if not _output(generator, which).trigger(generator.now_s):
            raise ScpiError(-211)

    return action


def _trigger_all(generator: Generator, parameters: Sequence[str]) -> None:
    none(parameters)
    triggered = [one.trigger(generator.now_s) for one in generator.outputs.values()]
    if not any(triggered):
        raise ScpiError(-211)


def _shown(value: float) -> str:
    return f"{value:+.15E}"


def _numeric(field: str, least: float, most: float) -> tuple[Change, Show]:
    def change(wave: Wave, text: str) -> Wave:
        given: dict[str, Any] = {field: number(text, least=least, most=most)}
        return replace(wave, **given)

    return change, lambda wave: _shown(getattr(wave, field))


def _chosen(field: str, *choices: str) -> tuple[Change, Show]:
    def change(wave: Wave, text: str) -> Wave:
        given: dict[str, Any] = {field: keyword(text, *choices)}
        return replace(wave, **given)

    return change, lambda wave: str(getattr(wave, field))


def _switch(wave: Wave, text: str) -> Wave:
    return replace(wave, on=boolean(text))


def _sweep(wave: Wave, text: str) -> Wave:
    return replace(wave, swept=boolean(text))


def _mode(wave: Wave, text: str) -> Wave:
    return replace(wave, swept=keyword(text, "CW", "FIXed", "SWEep") == "SWE")


def _unit(wave: Wave, text: str) -> Wave:
    return wave.in_unit(keyword(text, "VPP", "VRMS"))


def _load(wave: Wave, text: str) -> Wave:
    """Another load is taken for granted: what is given stays, what is shown for it changes."""
    infinite = text.upper() in ("INF", "INFINITY")
    load_ohm = math.inf if infinite else number(text, least=1.0, most=10e3)
    ratio = load_share(load_ohm) / load_share(wave.load_ohm)
    return replace(wave, load_ohm=load_ohm, level=wave.level * ratio, offset_v=wave.offset_v * ratio)


def _shown_load(wave: Wave) -> str:
    return _INFINITE if math.isinf(wave.load_ohm) else _shown(wave.load_ohm)


def _function(wave: Wave, text: str) -> Wave:
    return replace(wave, function={"SIN": SINE, "NOIS": NOISE}[keyword(text, *_FUNCTIONS)])


def _settings() -> Mapping[str, tuple[Change, Show]]:
    """By the header, `#` standing for the output's number."""
    source = "[SOURce#:]"
    return {
        "OUTPut#:LOAD": (_load, _shown_load),
        f"{source}FUNCtion[:SHAPe]": (_function, lambda wave: wave.function),
        f"{source}FUNCtion:NOISe:BANDwidth": _numeric("bandwidth_hz", LEAST_NOISE_HZ, MOST_HZ),
        f"{source}VOLTage[:LEVel][:IMMediate][:AMPLitude]": _numeric("level", 0.0, 20.0),
        f"{source}VOLTage[:LEVel][:IMMediate]:OFFSet": _numeric("offset_v", -10.0, 10.0),
        f"{source}VOLTage:UNIT": (_unit, lambda wave: wave.unit),
        f"{source}FREQuency[:CW]": _numeric("frequency_hz", LEAST_HZ, MOST_HZ),
        f"{source}FREQuency:MODE": (_mode, lambda wave: "SWE" if wave.swept else "CW"),
        f"{source}FREQuency:STARt": _numeric("start_hz", LEAST_HZ, MOST_HZ),
        f"{source}FREQuency:STOP": _numeric("stop_hz", LEAST_HZ, MOST_HZ),
        f"{source}SWEep:SPACing": _chosen("spacing", "LINear", "LOGarithmic"),
        f"{source}SWEep:TIME": _numeric("sweep_s", 1e-3, _LONGEST_SWEEP_S),
        f"{source}SWEep:STATe": (_sweep, lambda wave: str(int(wave.swept))),
        "TRIGger#:SOURce": _chosen("trigger", "IMMediate", "BUS"),
    }


@functools.cache
def command_table() -> Table[SimulatedGenerator]:
    """The commands of the generator; a header without a number is for output 1."""
    commands: dict[str, Action[Generator]] = {**common_commands(), "*TRG": _trigger_all}
    for mark, which in (("", 1), ("1", 1), ("2", 2)):
        for pattern, (change, show) in _settings().items():
            # "[SOURce2:]" may only be left out for the first output.
            header = pattern.replace("[SOURce#:]", "SOURce#:") if which > 1 else pattern
            header = header.replace("#", mark)
            commands[header] = _setter(which, change)
            commands[f"{header}?"] = _getter(which, show)
        commands[f"TRIGger{mark}[:IMMediate]"] = _trigger(which)
        commands[f"OUTPut{mark}[:STATe]"] = _setter(which, _switch)
        commands[f"OUTPut{mark}[:STATe]?"] = _is_on(which)
    return Table(commands)
