"""A GPIB controller of the Prologix kind: `++` commands for itself, all else for the instrument."""

from collections.abc import Callable, Iterator, Mapping

from gyrotest.ports import Clock
from gyrotest.simulation.dialogue import Parts, Speaker
from gyrotest.simulation.meter_state import Interface, Reply

_ESCAPE = 27
_ENDS = (10, 13)
_VERSION = b"Prologix GPIB-ETHERNET Controller version 01.06.06.00 (simulated)\r\n"
_UNKNOWN = b"Unrecognized command\r\n"
_SETTINGS = {
    "auto": (0, 1, 0),
    "eoi": (0, 1, 1),
    "eos": (0, 3, 0),
    "eot_char": (0, 255, 0),
    "eot_enable": (0, 1, 0),
    "lon": (0, 1, 0),
    "mode": (0, 1, 1),
    "read_tmo_ms": (1, 3000, 500),
    "savecfg": (0, 1, 1),
}


class PrologixDialogue:
    """One connection to the controller; meters by GPIB address.

    Like the real one it waits for a reply no longer than `++read_tmo_ms`: a slower reading gives
    nothing, and is there for a later `++read`.
    """

    def __init__(self, meters: Mapping[int, Speaker], clock: Clock) -> None:
        self._meters = meters
        self._clock = clock
        self._address = next(iter(meters))
        self._settings = {name: default for name, (_, _, default) in _SETTINGS.items()}
        self._pending: dict[int, Iterator[tuple[float, bytes]]] = {}
        self._held: dict[int, tuple[float, bytes]] = {}
        self._line = bytearray()
        self._escaped = False
        self._literal = False

    def receive(self, data: bytes) -> Parts:
        """Carry out every complete line; may raise `HangUp`."""
        for byte in data:
            if self._escaped:
                self._escaped = False
                self._literal = self._literal or not self._line
                self._line.append(byte)
            elif byte == _ESCAPE:
                self._escaped = True
            elif byte not in _ENDS:
                self._line.append(byte)
            elif self._line:
                line, literal = bytes(self._line), self._literal
                self._line.clear()
                self._literal = False
                yield from self._take(line, literal=literal)

    def _take(self, line: bytes, *, literal: bool) -> Iterator[tuple[float, bytes]]:
        if line.startswith(b"++") and not literal:
            yield from self._command(line[2:].decode("latin-1"))
            return
        self._to_instrument(line)
        if self._settings["auto"]:
            yield from self._read()

    def _to_instrument(self, line: bytes) -> None:
        meter = self._meters.get(self._address)
        if meter is None:
            return
        if self._pending.pop(self._address, None) is not None:
            self._held.pop(self._address, None)
            meter.refuse(-410)
        reply: Reply | None = meter.execute(line.decode("latin-1").strip(), Interface.GPIB)
        if reply is not None:
            self._pending[self._address] = iter(reply.parts)

    def _read(self) -> Iterator[tuple[float, bytes]]:
        """Hand on what the instrument says, as long as it comes within the time-out."""
        timeout_s = self._settings["read_tmo_ms"] / 1000.0
        address = self._address
        pending = self._pending.get(address)
        if pending is None:
            yield self._clock.now_s() + timeout_s, b""
            return
        while True:
            part = self._held.pop(address, None) or next(pending, None)
            if part is None:
                del self._pending[address]
                return
            deadline_s = self._clock.now_s() + timeout_s
            if part[0] > deadline_s:
                self._held[address] = part
                yield deadline_s, b""
                return
            yield part

    def _command(self, text: str) -> Iterator[tuple[float, bytes]]:
        name, *parameters = text.lower().split()
        now_s = self._clock.now_s()
        if name == "read":
            yield from self._read()
        elif name == "addr":
            yield from self._set_address(parameters, now_s)
        elif name == "ver":
            yield now_s, _VERSION
        elif name == "spoll":
            meter = self._meters.get(self._address)
            yield now_s, f"{meter.status_byte() if meter else 0}\r\n".encode()
        elif name == "srq":
            yield now_s, b"0\r\n"
        elif name in _SETTINGS:
            yield from self._setting(name, parameters, now_s)
        elif (action := self._actions().get(name)) is not None:
            action()
        else:
            yield now_s, _UNKNOWN

    def _actions(self) -> Mapping[str, Callable[[], None]]:
        return {
            "clr": self._clear,
            "trg": lambda: self._to_instrument(b"*TRG"),
            "rst": self._reset,
            "ifc": self._pending.clear,
            "loc": _nothing,
            "llo": _nothing,
        }

    def _set_address(self, parameters: list[str], now_s: float) -> Iterator[tuple[float, bytes]]:
        if not parameters:
            yield now_s, f"{self._address}\r\n".encode()
        elif parameters[0].isdecimal() and int(parameters[0]) <= 30:
            self._address = int(parameters[0])
        else:
            yield now_s, _UNKNOWN

    def _setting(self, name: str, parameters: list[str], now_s: float) -> Iterator[tuple[float, bytes]]:
        least, most, _ = _SETTINGS[name]
        if not parameters:
            yield now_s, f"{self._settings[name]}\r\n".encode()
        elif parameters[0].isdecimal() and least <= int(parameters[0]) <= most:
            self._settings[name] = int(parameters[0])
        else:
            yield now_s, _UNKNOWN

    def _clear(self) -> None:
        self._pending.pop(self._address, None)
        self._held.pop(self._address, None)
        if (meter := self._meters.get(self._address)) is not None:
            meter.clear()

    def _reset(self) -> None:
        self._pending.clear()
        self._held.clear()
        self._settings = {name: default for name, (_, _, default) in _SETTINGS.items()}


def _nothing() -> None:
    """Accept what changes nothing here."""
