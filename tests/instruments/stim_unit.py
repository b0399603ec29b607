"""A serial gyro by the documents, made apart from the driver: frames bit by bit, on a pseudo-terminal."""

import contextlib
import os
import pty
import threading
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from gyrotest.simulation.clock import VirtualClock


def crc(data: bytes, *, width: int, polynomial: int) -> bytes:
    """Long division over GF(2), one bit after the other; the seed is all ones."""
    register = (1 << width) - 1
    for bit in "".join(f"{byte:08b}" for byte in data):
        high = register >> (width - 1)
        register = register << 1 & (1 << width) - 1
        if high ^ int(bit):
            register ^= polynomial
    return register.to_bytes(width // 8, "big")


def crc8(data: bytes) -> bytes:
    return crc(data, width=8, polynomial=0x07)


def crc32(data: bytes) -> bytes:
    return crc(data + bytes(-len(data) % 4), width=32, polynomial=0x04C11DB7)


def signed(value: int, size: int) -> bytes:
    return value.to_bytes(size, "big", signed=True)


def stim210(
    identifier: int = 0x90,
    rates: tuple[int, int, int] = (0, 0, 0),
    *,
    status: int = 0,
    temperatures: tuple[int, int, int] | None = None,
    counter: int | None = None,
    latency: int | None = None,
    reserve: bytes = b"",
) -> bytes:
    """One frame of a STIM210."""
    frame = bytes([identifier]) + b"".join(signed(one, 3) for one in rates) + bytes([status]) + reserve
    for one in temperatures or ():
        frame += signed(one, 2)
    if counter is not None:
        frame += bytes([counter % 256])
    if latency is not None:
        frame += latency.to_bytes(2, "big")
    return frame + crc8(frame)


def stim300(
    identifier: int = 0x90,
    rates: tuple[int, int, int] = (0, 0, 0),
    *,
    status: int = 0,
    clusters: int = 0,
    temperatures: tuple[int, int, int] | None = None,
    temperature_status: int = 0,
    extra: bool = False,
    counter: int = 0,
    latency: int = 0,
) -> bytes:
    """One frame of a STIM300; `clusters` of acceleration and inclination, `extra` for AUX or PPS."""
    frame = bytes([identifier]) + b"".join(signed(one, 3) for one in rates) + bytes([status])
    frame += bytes(range(1, 11)) * clusters
    if temperatures is not None:
        frame += b"".join(signed(one, 2) for one in temperatures) + bytes([temperature_status])
        frame += bytes(range(7)) * clusters
    frame += bytes([9, 9, 9, 0]) * extra
    frame += bytes([counter % 256]) + latency.to_bytes(2, "big")
    return frame + crc32(frame)


def datagram(message: bytes, check: Callable[[bytes], bytes]) -> bytes:
    return message + check(message)


def serial_number(digits: str, *, crlf: bool = False) -> bytes:
    return bytes([0xB7 if crlf else 0xB5]) + b"N" + bytes.fromhex(digits) + bytes(7)


def configuration(*, rate_code: int = 0, mode: int = 0, filters: int = 4, crlf: bool = False) -> bytes:
    """The configuration datagram: 125 … 2000 Hz are 0 … 4, filters of 16 … 262 Hz are 0 … 4."""
    message = bytearray(22)
    message[0] = 0xBD if crlf else 0xBC
    message[1:3] = b"G\x0f"
    message[3] = rate_code << 5 | int(crlf)
    message[5] = 0x70 | mode
    message[6] = filters << 4 | filters
    message[7] = filters << 4
    return bytes(message)


class Unit:
    """Sends a frame each period of the virtual clock; answers commands; loses what it is told to lose.

    `frame(number)` makes the frame of a number; what `lost` holds is never sent, `spoilt` is sent wrong.
    """

    def __init__(
        self, clock: VirtualClock, frame: Callable[[int], bytes], *, period_s: float = 0.008
    ) -> None:
        self._frame, self._period_s = frame, period_s
        self._master, self._slave = pty.openpty()
        tty.setraw(self._master)
        tty.setraw(self._slave)
        self.resource = f"ASRL{os.ttyname(self._slave)}::INSTR"
        self.lost: set[int] = set()
        self.spoilt: dict[int, Callable[[bytes], bytes]] = {}
        self.answers: dict[bytes, bytes] = {}
        self.asked = bytearray()
        self.commands: list[bytes] = []
        self.silent = False
        self.sent = 0
        self._begun_s = clock.now_s()
        self._open = True
        self._lock = threading.Lock()
        os.set_blocking(self._master, False)
        clock.subscribe(self.send_until)

    def send_until(self, now_s: float) -> None:
        with self._lock:
            if not self._open:
                return
            self._answer()
            due = int((now_s - self._begun_s) / self._period_s + 1e-6)
            numbers = range(self.sent, due)
            self.sent = due
            if not self.silent:
                self._write(b"".join(self._on_the_wire(one) for one in numbers))

    def unplug(self) -> None:
        with self._lock:
            self._open = False
            os.close(self._slave)
            os.close(self._master)

    def close(self) -> None:
        if self._open:
            self.unplug()

    def _on_the_wire(self, number: int) -> bytes:
        if number in self.lost:
            return b""
        frame = self._frame(number)
        return self.spoilt[number](frame) if number in self.spoilt else frame

    def _answer(self) -> None:
        with contextlib.suppress(BlockingIOError):
            self.asked += os.read(self._master, 4096)
        while b"\r" in self.asked:
            command, _, rest = bytes(self.asked).partition(b"\r")
            self.asked = bytearray(rest)
            self.commands.append(command)
            self._write(self.answers.get(command, b""))

    def _write(self, data: bytes) -> None:
        """As much as fits: what a terminal cannot hold is lost, as in an UART."""
        while data:
            try:
                data = data[os.write(self._master, data) :]
            except BlockingIOError:
                return


@contextmanager
def unit(
    clock: VirtualClock, frame: Callable[[int], bytes], *, period_s: float = 0.008
) -> Iterator[Unit]:
    one = Unit(clock, frame, period_s=period_s)
    try:
        yield one
    finally:
        one.close()
