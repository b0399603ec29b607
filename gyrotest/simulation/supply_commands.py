"""The SCPI commands of a simulated power supply, its outputs named by INST:NSEL or by a channel list."""

import functools
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from gyrotest.ports import Clock
from gyrotest.simulation.interpreter import Interpreter, common_commands
from gyrotest.simulation.scpi import Action, ScpiError, Table, boolean, none, number, one
from gyrotest.simulation.supply import (
    MOST_A,
    MOST_PROTECTION_V,
    MOST_V,
    SimulatedOutput,
    SimulatedSupply,
)

_CHANNEL = re.compile(r"\(@(\d+)\)")
_MEASURING_S = 0.02
_CONSTANT_CURRENT, _OVER_VOLTAGE = 1 << 0, 1 << 9
_STEP_V, _STEP_A = 1e-3, 1e-4

Supply = SimulatedSupply
Set = Callable[[SimulatedOutput, float, float], None]
Get = Callable[[SimulatedOutput, float], float]


def speaker_of(supply: SimulatedSupply, clock: Clock) -> Interpreter[SimulatedSupply]:
    """The supply's front end."""
    return Interpreter(supply, command_table(), clock)


@dataclass(frozen=True, slots=True)
class _Meant:
    """The output that a command is for, and its parameters but the channel list."""

    output: SimulatedOutput
    parameters: tuple[str, ...]


def _meant(supply: Supply, parameters: Sequence[str]) -> _Meant:
    if parameters and (named := _CHANNEL.fullmatch(parameters[-1])):
        return _Meant(_output(supply, int(named[1])), tuple(parameters[:-1]))
    return _Meant(_output(supply, supply.chosen), tuple(parameters))


def _output(supply: Supply, chosen: int) -> SimulatedOutput:
    if chosen not in supply.outputs:
        raise ScpiError(-222)
    return supply.outputs[chosen]


def _level(change: Set, most: float) -> Action[Supply]:
    def action(supply: Supply, parameters: Sequence[str]) -> None:
        meant = _meant(supply, parameters)
        change(meant.output, supply.now_s, number(one(meant.parameters), least=0.0, most=most))

    return action


def _value(get: Get, most: float) -> Action[Supply]:
    def action(supply: Supply, parameters: Sequence[str]) -> str:
        meant = _meant(supply, parameters)
        if meant.parameters:
            return f"{number(one(meant.parameters), least=0.0, most=most):+.8E}"
        return f"{get(meant.output, supply.now_s):+.8E}"

    return action


def _flag(get: Callable[[SimulatedOutput, float], int]) -> Action[Supply]:
    def action(supply: Supply, parameters: Sequence[str]) -> str:
        meant = _meant(supply, parameters)
        none(meant.parameters)
        return str(int(get(meant.output, supply.now_s)))

    return action


def _measured(get: Get, step: float) -> Action[Supply]:
    def action(supply: Supply, parameters: Sequence[str]) -> str:
        meant = _meant(supply, parameters)
        none(meant.parameters)
        supply.now_s += _MEASURING_S
        return f"{round(get(meant.output, supply.now_s) / step) * step:+.8E}"

    return action


def _switch(supply: Supply, parameters: Sequence[str]) -> None:
    meant = _meant(supply, parameters)
    meant.output.switch(supply.now_s, on=boolean(one(meant.parameters)))


def _choose(supply: Supply, parameters: Sequence[str]) -> None:
    chosen = int(number(one(parameters), least=1, most=len(supply.outputs)))
    _output(supply, chosen)
    supply.chosen = chosen


def _chosen(supply: Supply, parameters: Sequence[str]) -> str:
    none(parameters)
    return str(supply.chosen)


def _arm(supply: Supply, parameters: Sequence[str]) -> None:
    meant = _meant(supply, parameters)
    if not boolean(one(meant.parameters)):
        raise ScpiError(-221)  # this supply's protection is always on


def _clear(supply: Supply, parameters: Sequence[str]) -> None:
    meant = _meant(supply, parameters)
    none(meant.parameters)
    meant.output.clear_protection()


def _tripped(output: SimulatedOutput, now_s: float) -> int:
    output.voltage_v(now_s)
    return output.tripped


def _is_on(output: SimulatedOutput, now_s: float) -> int:
    output.voltage_v(now_s)
    return output.on


def _condition(output: SimulatedOutput, now_s: float) -> int:
    held = _CONSTANT_CURRENT if output.limiting(now_s) else 0
    return held | (_OVER_VOLTAGE if _tripped(output, now_s) else 0)


def _read_voltage(output: SimulatedOutput, now_s: float) -> float:
    return output.voltage_v(now_s) * (1.0 + output.figures.reading_gain)


def _read_current(output: SimulatedOutput, now_s: float) -> float:
    return output.current_a(now_s)


@functools.cache
def command_table() -> Table[SimulatedSupply]:
    """The commands of the supply."""
    voltage = "[SOURce:]VOLTage[:LEVel][:IMMediate][:AMPLitude]"
    current = "[SOURce:]CURRent[:LEVel][:IMMediate][:AMPLitude]"
    protection = "[SOURce:]VOLTage:PROTection"
    return Table(
        {
            **common_commands(),
            "INSTrument:NSELect": _choose,
            "INSTrument:NSELect?": _chosen,
            voltage: _level(SimulatedOutput.set_voltage, MOST_V),
            f"{voltage}?": _value(lambda output, _: output.voltage_set_v, MOST_V),
            current: _level(SimulatedOutput.set_limit, MOST_A),
            f"{current}?": _value(lambda output, _: output.limit_a, MOST_A),
            f"{protection}[:LEVel]": _level(SimulatedOutput.set_protection, MOST_PROTECTION_V),
            f"{protection}[:LEVel]?": _value(lambda output, _: output.protection_v, MOST_PROTECTION_V),
            f"{protection}:STATe": _arm,
            f"{protection}:STATe?": _flag(lambda *_: 1),
            f"{protection}:TRIPped?": _flag(_tripped),
            f"{protection}:CLEar": _clear,
            "OUTPut[:STATe]": _switch,
            "OUTPut[:STATe]?": _flag(_is_on),
            "MEASure[:SCALar][:VOLTage][:DC]?": _measured(_read_voltage, _STEP_V),
            "MEASure[:SCALar]:CURRent[:DC]?": _measured(_read_current, _STEP_A),
            "STATus:QUEStionable:CONDition?": _flag(_condition),
        }
    )
