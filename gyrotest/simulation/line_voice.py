"""A digital gyro's samples as lines of text."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import StationError
from gyrotest.simulation.figures import fault
from gyrotest.simulation.housed import Housed
from gyrotest.simulation.sampled import Sampled

_END = "\r\n"
_NUMBER = -123_456.789
_TEMPERATURE = "temperature"
# What a line may hold beside the axes, by their names (`output` for a gyro of one axis).
_BESIDE = ("counter", "time_s", _TEMPERATURE, "status")
# Bits of the status, which is a number.
START_UP, OVERLOAD = 0x40, 0x10


@dataclass(frozen=True, slots=True, kw_only=True)
class Board:
    """What a board prints: by a format, or by columns; `units` is what a number 1 stands for there.

    `start` and `stop` make it send, empty: it always does. `question` is answered by `reply`.
    """

    key: str
    rate_hz: float
    form: str | None
    columns: tuple[str, ...]
    separator: str
    units: dict[str, float]
    counter: str
    modulus: int
    step: int
    start: bytes
    stop: bytes
    question: bytes
    reply: str


class LineVoice:
    """Prints a line for each sample."""

    def __init__(self, board: Board) -> None:
        self._board = board
        self._form = ""
        self._names: list[str] = []
        self._serial_number = ""
        self.sending = not board.start
        self.rate_hz = board.rate_hz
        self.period = max(1, board.modulus // board.step)
        self.largest = 1

    def house(self, housed: Housed) -> None:
        """Be this unit from now on; raises `StationError` for a format that does not fit."""
        board = self._board
        self._serial_number = housed.occasion.serial_number
        self._names = [element.axis.name or "output" for element in housed.elements]
        self._form = f"{board.form or self._by_columns()}{_END}"
        sample = dict.fromkeys((*self._names, *_BESIDE), _NUMBER)
        sample |= {"counter": board.modulus, "status": 255}
        try:
            self.largest = len(self._form.format(**sample)) + 2 * len(sample)
        except (KeyError, ValueError, IndexError) as error:
            known = ", ".join((*self._names, *_BESIDE))
            message = f"'{board.form}' cannot be filled in ({error}); it may hold {known}"
            raise StationError([fault(f"{board.key}.format", message)]) from error

    def _by_columns(self) -> str:
        """The format of the driver's columns; one that is nothing here holds a 0."""
        board = self._board
        if not board.columns:
            names = (f"{{{name}:.5f}}" for name in self._names)
            return ",".join(["{counter}", *names, f"{{{_TEMPERATURE}:.2f}}"])
        alone = self._names == ["output"]
        fields = {
            name: f"{{{'output' if alone else name}:.5f}}"
            for name in board.units
            if alone or name in self._names
        }
        fields |= {name: f"{{{_TEMPERATURE}:.2f}}" for name in board.columns if _TEMPERATURE in name}
        fields[board.counter] = "{counter}"
        return board.separator.join(fields.get(name, "0") for name in board.columns)

    def _units(self) -> list[float]:
        """What a number 1 stands for, of each axis; a single one is printed in whatever column."""
        units = self._board.units
        alone = next((value for name, value in units.items() if name != _TEMPERATURE), 1.0)
        return [alone if name == "output" else units.get(name, 1.0) for name in self._names]

    def frames(self, sampled: Sampled, status: NDArray[np.uint8]) -> list[bytes]:
        """The samples, a line each."""
        board = self._board
        columns = {
            name: (row / unit).tolist()
            for name, unit, row in zip(self._names, self._units(), sampled.outputs, strict=True)
        }
        columns |= {
            "counter": (sampled.number * board.step % board.modulus).tolist(),
            "time_s": sampled.time_s.tolist(),
            _TEMPERATURE: (sampled.temperature_degc / board.units.get(_TEMPERATURE, 1.0)).tolist(),
            "status": _status(sampled, status).tolist(),
        }
        form, names = self._form.format, tuple(columns)
        return [
            form(**dict(zip(names, line, strict=True))).encode("latin-1")
            for line in zip(*columns.values(), strict=True)
        ]

    def hello(self) -> bytes:
        """Nothing: after power-on it waits again to be started."""
        self.sending = not self._board.start
        return b""

    def answer(self, asked: bytes) -> bytes:
        """The serial number, if that is the question; starting and stopping are not answered."""
        board = self._board
        if board.stop and board.stop in asked:
            self.sending = False
        if board.start and asked.rfind(board.start) > asked.rfind(board.stop or b"\0"):
            self.sending = True
        if not board.question or board.question not in asked:
            return b""
        return f"{board.reply.format(serial_number=self._serial_number)}{_END}".encode("latin-1")


def _status(sampled: Sampled, status: NDArray[np.uint8]) -> NDArray[np.uint8]:
    status[sampled.starting] |= np.uint8(START_UP)
    status[sampled.over.any(axis=0)] |= np.uint8(OVERLOAD)
    return status
