"""A serial line through pyserial, on which nothing is sent that the driver does not send.

Motion controllers get no device clear and no other byte that is not a command of theirs.
"""

import re
import time
from typing import Any

from gyrotest.errors import InstrumentError
from gyrotest.instruments.transport.channel import Channel, FlowControl, Parity, SerialLine
from gyrotest.instruments.transport.visa import open_channel

_ASRL = re.compile(r"ASRL(?P<port>.+?)(::INSTR)?", re.IGNORECASE)
_PARITY = {Parity.NONE: "N", Parity.EVEN: "E", Parity.ODD: "O"}


def serial_device(resource: str) -> str | None:
    """The device of a resource `ASRL…::INSTR` (`ASRL3` is COM3); None for another interface."""
    found = _ASRL.fullmatch(resource.strip())
    if found is None:
        return None
    port = found["port"]
    return f"COM{port}" if port.isdecimal() else port


def open_commands_only(resource: str, line: SerialLine, timeout_s: float) -> Channel:
    """Open a resource so that the instrument gets commands only; raises `InstrumentError`."""
    device = serial_device(resource)
    if device is None:
        return open_channel(resource, line, timeout_s)
    import serial

    try:
        port = serial.serial_for_url(
            device,
            baudrate=line.baud_rate,
            bytesize=line.data_bits,
            parity=_PARITY[line.parity],
            stopbits=line.stop_bits,
            xonxoff=line.flow_control is FlowControl.XON_XOFF,
            rtscts=line.flow_control is FlowControl.RTS_CTS,
            dsrdtr=line.flow_control is FlowControl.DTR_DSR,
            write_timeout=timeout_s,
        )
    except (OSError, ValueError) as error:
        raise InstrumentError(
            f"{resource}: cannot be opened ({error}); is the line plugged in and no other program using it?"
        ) from error
    return SerialPort(port, line)


class SerialPort:
    """An open serial port as a channel."""

    longest_wait_s: float | None = None
    remote_by_command = False

    def __init__(self, port: Any, line: SerialLine) -> None:
        self.seconds_per_byte = line.seconds_per_byte
        self._port = port
        self._buffer = bytearray()

    def unread(self) -> bytes:
        """What has arrived without being asked for; raises at once if the line has gone."""
        waiting = self._port.in_waiting
        if waiting:
            self._buffer += self._port.read(waiting)
        return bytes(self._buffer)

    def send(self, data: bytes) -> None:
        """Send all the bytes."""
        self._port.write(data)

    def receive_line(self, timeout_s: float) -> bytes:
        """The bytes up to and including the next line feed."""
        deadline_s = time.monotonic() + timeout_s
        while (end := self._buffer.find(b"\n") + 1) == 0:
            self._receive_some(deadline_s)
        return self._take(end)

    def receive_exactly(self, count: int, timeout_s: float) -> bytes:
        """That many bytes, whatever they are."""
        deadline_s = time.monotonic() + timeout_s
        while len(self._buffer) < count:
            self._receive_some(deadline_s)
        return self._take(count)

    def clear(self) -> None:
        """Forget what has arrived; nothing is sent."""
        self._port.reset_input_buffer()
        self._buffer.clear()

    def go_to_local(self) -> None:
        """Nothing: there is no command for it."""

    def close(self) -> None:
        """Disconnect."""
        self._port.close()

    def _receive_some(self, deadline_s: float) -> None:
        left_s = deadline_s - time.monotonic()
        if left_s <= 0:
            raise TimeoutError
        self._port.timeout = left_s
        self._buffer += self._port.read(max(1, self._port.in_waiting))

    def _take(self, count: int) -> bytes:
        data = bytes(self._buffer[:count])
        del self._buffer[:count]
        return data
