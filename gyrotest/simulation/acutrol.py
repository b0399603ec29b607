"""A simulated ACUTROL3000: its command language (ACL) in front of a simulated table."""

import re
from collections.abc import Callable, Iterator
from enum import Enum

from gyrotest.simulation.table import SimulatedTable

_AXIS = "1"
_SUMMARY = 65
_STATUS = b"\x00" * 8
_LONGEST_LINE = 4096
# Commands by the names of their path; each may be shortened to a beginning that is its alone.
_TREE = {
    "UTILITY": ("LOCKOUT",),
    "INTERLOCK": ("RESET", "OPEN", "CLOSE"),
    "MODE": ("OFF", "RATE", "POSITION"),
    "LIMIT": ("RATE", "ACCELERATION"),
    "DEMAND": ("RATE", "POSITION"),
    "READ": ("RATE", "POSITION"),
}


class AcutrolInterface(Enum):
    """How the interface answers: queries only, or every command with status bytes in front."""

    PLAIN = "plain"
    STATUS = "status"


class Refusal(Exception):  # noqa: N818 - what the controller does, not a fault of the program
    """A command that the controller does not take."""


class AcutrolController:
    """The controller's state: one for a table, whatever connections there are."""

    def __init__(self, table: SimulatedTable, *, serial_number: str) -> None:
        self.table = table
        self.serial_number = serial_number
        self._mode = "OFF"
        self._loaded: dict[str, float | None] = {"RATE": 0.0, "POSITION": None}
        self._closed = False
        self._refused = False
        self._limits = {
            (of, mode): limit
            for mode in ("RATE", "POSITION")
            for of, limit in (
                ("RATE", table.parameters.max_rate_dps),
                ("ACCELERATION", table.parameters.max_acceleration_dps2),
            )
        }

    def execute(self, unit: str, path: list[str]) -> str | None:
        """Carry out one command; its answer, None where it is no query. Raises `Refusal`.

        `path` is where the command before left off, and is changed.
        """
        try:
            return self._execute(unit, path)
        except Refusal:
            self._refused = True
            raise

    def _execute(self, unit: str, path: list[str]) -> str | None:
        head, _, rest = unit.strip().partition(" ")
        parameters = [one.strip() for one in rest.split(",")] if rest.strip() else []
        if head.startswith("*"):
            return self._common(head.upper())
        names, query = _names(head.rstrip("?"), path), head.endswith("?")
        if self.table.faults.refuses and names[0] not in {"INTERLOCK", "READ"}:
            raise Refusal
        if names[0] == "READ" or query:
            return self._answer(names, parameters)
        self._act(names, parameters)
        return None

    def _common(self, head: str) -> str | None:
        if head == "*IDN?":
            return f"ACUTRONIC,ACUTROL3000,{self.serial_number},1.0"
        if head == "*STB?":
            return str(_SUMMARY if self._refused or self._fault() else 0)
        if head == "*CLS":
            self._refused = False
            return None
        raise Refusal

    def _fault(self) -> bool:
        return self.table.interlock_open()

    def _answer(self, names: tuple[str, ...], parameters: list[str]) -> str:
        if names[0] == "LIMIT" and len(names) == 2 and len(parameters) == 2:
            _axis(parameters[1])
            return f"{self._limits[names[1], _mode(parameters[0])]:.6f}"
        if len(parameters) != 1:
            raise Refusal
        _axis(parameters[0])
        answers: dict[tuple[str, ...], Callable[[], str]] = {
            ("READ", "RATE"): lambda: f"{self.table.read_rate_dps():.6f}",
            ("READ", "POSITION"): lambda: f"{self.table.read_angle_deg():.6f}",
            ("MODE",): self._mode.capitalize,
            ("INTERLOCK",): self._interlock,
        }
        if names not in answers:
            raise Refusal
        return answers[names]()

    def _interlock(self) -> str:
        if self._fault():
            return "Fault"
        return "Closed" if self._closed else "Open"

    def _act(self, names: tuple[str, ...], parameters: list[str]) -> None:
        if names == ("INTERLOCK", "RESET"):
            self._refused = False
            return
        if names[0] == "UTILITY":
            return
        if names[0] == "LIMIT":
            self._set_limit(names, parameters)
            return
        if not parameters:
            raise Refusal
        _axis(parameters[0])
        if names[0] == "INTERLOCK":
            self._set_interlock(closed=names[1:] == ("CLOSE",))
        elif names[0] == "MODE" and len(names) == 2:
            self._set_mode(names[1])
        elif names[0] == "DEMAND" and len(names) == 2 and len(parameters) == 2:
            self._demand(names[1], _number(parameters[1]))
        else:
            raise Refusal

    def _set_interlock(self, *, closed: bool) -> None:
        if closed and self._fault():
            raise Refusal
        if not closed:
            self.table.set_rate(0.0)
            self._mode = "OFF"
        self._closed = closed

    def _set_mode(self, mode: str) -> None:
        if mode != "OFF" and (self._fault() or not self._closed):
            raise Refusal
        if mode != self._mode:
            self._mode = mode
            self._follow(mode)

    def _follow(self, mode: str) -> None:
        """Do what is demanded in the mode; a demand of before comes to life with it."""
        demand = self._loaded.get(mode)
        if mode == "POSITION" and demand is not None:
            self.table.move_to(demand)
        else:
            self.table.set_rate(demand or 0.0)

    def _demand(self, of: str, value: float) -> None:
        if self._fault():
            raise Refusal
        if of == "RATE" and abs(value) > self._limits["RATE", "RATE"]:
            raise Refusal
        self._loaded[of] = value
        if self._mode == of:
            self._follow(of)

    def _set_limit(self, names: tuple[str, ...], parameters: list[str]) -> None:
        if len(names) != 2 or len(parameters) != 3:
            raise Refusal
        mode, limit = _mode(parameters[0]), _number(parameters[2])
        _axis(parameters[1])
        rate = names[1] == "RATE"
        own = self.table.parameters
        if not 0.0 < limit <= (own.max_rate_dps if rate else own.max_acceleration_dps2):
            raise Refusal
        self._limits[names[1], mode] = limit
        if rate:
            self.table.rate_limit_dps = limit
        else:
            self.table.acceleration_limit_dps2 = limit


class AcutrolDialogue:
    """One connection to the controller."""

    def __init__(
        self,
        controller: AcutrolController,
        now_s: Callable[[], float],
        interface: AcutrolInterface = AcutrolInterface.PLAIN,
    ) -> None:
        self._controller = controller
        self._now_s = now_s
        self._interface = interface
        self._rest = b""

    def receive(self, data: bytes) -> Iterator[tuple[float, bytes]]:
        """Carry out every complete line."""
        *lines, self._rest = (self._rest + data).replace(b"\r", b"\n").split(b"\n")
        self._rest = self._rest[:_LONGEST_LINE]
        for line in lines:
            if line.strip():
                reply = self._line(line.decode("latin-1"))
                if reply is not None:
                    yield self._now_s(), reply

    def _line(self, line: str) -> bytes | None:
        path: list[str] = []
        answers: list[str] = []
        refused = False
        for unit in line.split(";"):
            try:
                answer = self._controller.execute(unit, path)
            except Refusal:
                refused = True
                break
            if answer is not None:
                answers.append(answer)
        if self._interface is AcutrolInterface.STATUS:
            text = "?" if refused else ";".join(answers) or "OK"
            return _STATUS + text.encode()
        if refused and "?" in line:
            return b"?\n"
        return (";".join(answers) + "\n").encode() if answers else None


def _names(head: str, path: list[str]) -> tuple[str, ...]:
    """The names of a command; without a colon in front it stands beside the command before."""
    given = [one for one in head.split(":") if one]
    if not head.startswith(":") and path:
        given = [path[0], *given]
    if not 1 <= len(given) <= 2:
        raise Refusal
    group = _full(given[0], tuple(_TREE))
    path[:] = [group]
    return (group,) if len(given) == 1 else (group, _full(given[1], _TREE[group]))


def _full(name: str, known: tuple[str, ...]) -> str:
    matching = [
        one for one in known if re.fullmatch(r"[A-Z]+", name.upper()) and one.startswith(name.upper())
    ]
    if not matching:
        raise Refusal
    return matching[0]


def _mode(name: str) -> str:
    return _full(name, ("RATE", "POSITION"))


def _axis(text: str) -> None:
    if text != _AXIS:
        raise Refusal


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise Refusal from None
