"""Program messages carried out on a simulated instrument, and the commands that all of them know."""

from collections.abc import Callable, Mapping, Sequence
from typing import Generic, Protocol, TypeVar

from gyrotest.ports import Clock
from gyrotest.simulation.meter_state import Interface, Reply
from gyrotest.simulation.scpi import Action, ErrorQueue, ScpiError, Table, none, number, one

_COMMAND_S = 1e-3


class Instrument(Protocol):
    """What an interpreter speaks for; an action that takes time moves `now_s` on."""

    identity: str
    errors: ErrorQueue
    now_s: float

    def reset(self) -> None:
        """`*RST`."""


InstrumentT = TypeVar("InstrumentT", bound=Instrument)


class Interpreter(Generic[InstrumentT]):
    """The front end of an instrument: takes messages, gives replies, keeps the errors."""

    def __init__(self, instrument: InstrumentT, table: Table[InstrumentT], clock: Clock) -> None:
        self._instrument = instrument
        self._table = table
        self._clock = clock

    def execute(self, message: str, interface: Interface) -> Reply | None:
        """Carry out a program message; the reply, if there is one."""
        instrument = self._instrument
        instrument.now_s = max(instrument.now_s, self._clock.now_s())
        answers: list[bytes] = []
        for call in self._table.compile(message):
            instrument.now_s += _COMMAND_S
            try:
                if call.action is None:
                    raise ScpiError(call.refusal)
                answer = call.action(instrument, call.parameters)
            except ScpiError as error:
                self.refuse(error.code)
                continue
            if answer is not None:
                answers.append(_bytes(answer))
        if not answers:
            return None
        end = b"\r\n" if interface is Interface.SERIAL else b"\n"
        return Reply(parts=((instrument.now_s, b";".join(answers) + end),))

    def clear(self) -> None:
        """Device clear: nothing is under way between two messages."""

    def refuse(self, code: int) -> None:
        """Put an error into the queue."""
        self._instrument.errors.push(code)

    def status_byte(self) -> int:
        """The status byte: whether the error queue holds anything (bit 2, as SCPI has it)."""
        return (len(self._instrument.errors) > 0) << 2


def getter(value: Callable[[InstrumentT], str]) -> Action[InstrumentT]:
    """A query without parameters."""

    def action(instrument: InstrumentT, parameters: Sequence[str]) -> str:
        none(parameters)
        return value(instrument)

    return action


def doer(change: Callable[[InstrumentT], None]) -> Action[InstrumentT]:
    """A command without parameters."""

    def action(instrument: InstrumentT, parameters: Sequence[str]) -> None:
        none(parameters)
        change(instrument)

    return action


def setter(
    change: Callable[[InstrumentT, float], None], *, least: float, most: float
) -> Action[InstrumentT]:
    """A command with one number."""

    def action(instrument: InstrumentT, parameters: Sequence[str]) -> None:
        change(instrument, number(one(parameters), least=least, most=most))

    return action


def common_commands() -> Mapping[str, Action[InstrumentT]]:
    """Identity, reset, status and error queue."""
    ignored: Action[InstrumentT] = doer(lambda _: None)
    return {
        "*IDN?": getter(lambda instrument: instrument.identity),
        "*RST": doer(lambda instrument: instrument.reset()),
        "*CLS": doer(lambda instrument: instrument.errors.clear()),
        "*OPC?": getter(lambda _: "1"),
        "*OPC": ignored,
        "*WAI": ignored,
        "*TST?": getter(lambda _: "0"),
        "SYSTem:ERRor[:NEXT]?": getter(lambda instrument: instrument.errors.pop()),
        "SYSTem:VERSion?": getter(lambda _: "1999.0"),
        "SYSTem:REMote": ignored,
        "SYSTem:RWLock": ignored,
        "SYSTem:LOCal": ignored,
    }


def _bytes(answer: object) -> bytes:
    if isinstance(answer, str):
        return answer.encode()
    if isinstance(answer, bytes):
        return answer
    raise TypeError(f"an answer in one piece was expected, not {type(answer).__name__}")
