"""A simulated Ideal Aerosmith controller: its table language (ATL) in front of a simulated table."""

import re
from collections.abc import Callable, Iterator

from gyrotest.simulation.table import SimulatedTable

_END = b"\r"
_LONGEST_LINE = 4096
_TAKEN = b"\r\n>\r\n"
_REFUSED = b"?\r\n>\r\n"
_COMMAND = re.compile(r"(?P<name>[A-Z]+)(?P<value>[+-]?[\d.]*)")
_AT_REST_DPS = 1e-3
_MOTION_DONE = 5


class Refused(Exception):  # noqa: N818 - what the controller does, not a fault of the program
    """A command that the controller does not take."""


class AerosmithController:
    """The controller's state: one for a table, whatever connections there are.

    A real one has no identity query; this one answers it, so that a simulated table is known as such.
    """

    def __init__(self, table: SimulatedTable, *, serial_number: str) -> None:
        self.table = table
        self.serial_number = serial_number
        self._servo = False

    def execute(self, line: str) -> str:
        """Carry out one command; what is printed before the prompt. Raises `Refused`."""
        if line == "*IDN?":
            return f"IDEAL AEROSMITH,SIMULATED RATE TABLE,{self.serial_number},1.0"
        found = _COMMAND.fullmatch(line)
        if found is None:
            raise Refused
        queries: dict[str, Callable[[], str]] = {
            "PPO": lambda: f"{self.table.read_angle_deg():.5f}",
            "MCO": lambda: self._motion_done(found["value"]),
        }
        if found["name"] in queries:
            return queries[found["name"]]()
        self._act(found["name"], found["value"])
        return ""

    def _motion_done(self, value: str) -> str:
        if value != str(_MOTION_DONE):
            raise Refused
        return str(int(abs(self.table.read_rate_dps()) > _AT_REST_DPS))

    def _act(self, name: str, value: str) -> None:
        if name == "STO":
            self.table.set_rate(0.0)
        elif self.table.interlock_open() or self.table.faults.refuses:
            raise Refused
        elif name == "SRV" and value in {"0", "1"}:
            self._servo = value == "1"
            self.table.set_rate(0.0)
        elif name == "ACL":
            self._set_acceleration(_number(value))
        else:
            self._turn(name, value)

    def _turn(self, name: str, value: str) -> None:
        if not self._servo:
            raise Refused
        if name == "JOG":
            rate_dps = _number(value)
            if abs(rate_dps) > self.table.parameters.max_rate_dps:
                raise Refused
            self.table.set_rate(rate_dps)
        elif name == "P":
            self.table.move_to(_number(value))
        elif name == "HOM" and not value:
            self.table.move_to(0.0)
        else:
            raise Refused

    def _set_acceleration(self, value: float) -> None:
        if not 0.0 < value <= self.table.parameters.max_acceleration_dps2:
            raise Refused
        self.table.acceleration_limit_dps2 = value


class AerosmithDialogue:
    """One connection to the controller."""

    def __init__(self, controller: AerosmithController, now_s: Callable[[], float]) -> None:
        self._controller = controller
        self._now_s = now_s
        self._rest = b""

    def receive(self, data: bytes) -> Iterator[tuple[float, bytes]]:
        """Carry out every complete line; an empty one is answered by the prompt."""
        *lines, self._rest = (self._rest + data).replace(b"\n", b"").split(_END)
        self._rest = self._rest[:_LONGEST_LINE]
        for line in lines:
            yield self._now_s(), self._reply(line.decode("latin-1").strip())

    def _reply(self, line: str) -> bytes:
        if not line:
            return _TAKEN
        try:
            return self._controller.execute(line).encode() + _TAKEN
        except Refused:
            return _REFUSED


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise Refused from None
