"""Bytes as they arrive, from a serial port or a TCP connection: for instruments that talk unasked.

Not through VISA, which reads a serial line byte by byte.
"""

import re
import select
import socket
import time
from collections.abc import Callable
from typing import Any, Protocol

from gyrotest.errors import InstrumentError
from gyrotest.instruments.transport.channel import Parity, SerialLine
from gyrotest.instruments.transport.tcp import send_at_once

_SERIAL = re.compile(r"ASRL(?P<port>.+?)(?:::INSTR)?", re.IGNORECASE)
_SOCKET = re.compile(r"TCPIP\d*::(?P<host>[^:]+)::(?P<port>\d+)::SOCKET", re.IGNORECASE)
_CHUNK = 65536
# No read brings more than this: a peer that sends faster than it is read must not hold us for ever.
_MOST = 1 << 20
_STEP_S = 0.02
_WRITE_TIMEOUT_S = 5.0


class ByteStream(Protocol):
    """A stream of bytes. Every method but `close` raises `OSError` as soon as the peer is gone."""

    def read(self, least: int = 0, timeout_s: float = 0.0) -> bytes:
        """All that has arrived, after waiting up to `timeout_s` (real seconds) for `least` bytes."""

    def write(self, data: bytes) -> None:
        """Send all the bytes."""

    def discard(self) -> None:
        """Forget what has arrived."""

    def close(self) -> None:
        """Disconnect; never raises."""


OpenStream = Callable[[str, SerialLine, float], ByteStream]


def open_stream(resource: str, line: SerialLine, timeout_s: float) -> ByteStream:
    """Open `ASRL/dev/ttyUSB0::INSTR` or `TCPIP::host::port::SOCKET`; raises `InstrumentError`."""
    serial_port, tcp = _SERIAL.fullmatch(resource), _SOCKET.fullmatch(resource)
    try:
        if serial_port:
            return SerialStream(serial_port["port"], line)
        if tcp:
            return SocketStream(socket.create_connection((tcp["host"], int(tcp["port"])), timeout_s))
    except (OSError, ValueError, OverflowError) as error:
        raise InstrumentError(
            f"{resource}: cannot be opened: {error}; is it connected, powered, and not in use elsewhere?"
        ) from error
    raise InstrumentError(
        f"{resource}: is no stream of bytes; write ASRL/dev/ttyUSB0::INSTR or TCPIP::host::port::SOCKET"
    )


class SerialStream:
    """A serial port, or a pseudo-terminal."""

    def __init__(self, port: str, line: SerialLine) -> None:
        from serial import PARITY_EVEN, PARITY_NONE, PARITY_ODD, Serial

        parities = {Parity.NONE: PARITY_NONE, Parity.EVEN: PARITY_EVEN, Parity.ODD: PARITY_ODD}
        self._port: Any = Serial(
            f"COM{port}" if port.isdecimal() else port,
            baudrate=line.baud_rate,
            bytesize=line.data_bits,
            parity=parities[line.parity],
            stopbits=line.stop_bits,
            timeout=_STEP_S,
            write_timeout=_WRITE_TIMEOUT_S,
            exclusive=True,
        )

    def read(self, least: int = 0, timeout_s: float = 0.0) -> bytes:
        """All that has arrived, after waiting for `least` bytes."""
        data = self._arrived()
        if len(data) >= least:
            return bytes(data)
        deadline_s = time.monotonic() + timeout_s
        while len(data) < least and time.monotonic() < deadline_s:
            data += self._port.read(least - len(data))
        return bytes(data + self._arrived())

    def write(self, data: bytes) -> None:
        """Send all the bytes."""
        self._port.write(data)

    def discard(self) -> None:
        """Forget what has arrived, here and in the operating system."""
        self._port.reset_input_buffer()
        self._arrived()

    def close(self) -> None:
        """Disconnect."""
        self._port.close()

    def _arrived(self) -> bytearray:
        # A pseudo-terminal hands out no more than 4095 bytes at once, whatever waits behind them.
        data = bytearray()
        while len(data) < _MOST and (waiting := self._port.in_waiting):
            data += self._port.read(waiting)
        return data


class SocketStream:
    """A TCP connection."""

    def __init__(self, connection: socket.socket) -> None:
        send_at_once(connection)
        connection.settimeout(_WRITE_TIMEOUT_S)
        self._socket = connection

    def read(self, least: int = 0, timeout_s: float = 0.0) -> bytes:
        """All that has arrived, after waiting for `least` bytes."""
        data = self._arrived()
        deadline_s = time.monotonic() + timeout_s
        while len(data) < least and (left_s := deadline_s - time.monotonic()) > 0:
            select.select((self._socket,), (), (), left_s)
            data += self._arrived()
        return bytes(data)

    def write(self, data: bytes) -> None:
        """Send all the bytes."""
        self._socket.sendall(data)

    def discard(self) -> None:
        """Forget what has arrived."""
        self._arrived()

    def close(self) -> None:
        """Disconnect."""
        self._socket.close()

    def _arrived(self) -> bytearray:
        data = bytearray()
        while len(data) < _MOST and select.select((self._socket,), (), (), 0)[0]:
            part = self._socket.recv(_CHUNK)
            if not part:
                raise ConnectionAbortedError("the peer closed the connection")
            data += part
        return data
