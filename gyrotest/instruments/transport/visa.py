"""Opening VISA resources, and bytes through pyvisa for whatever is no plain socket."""

import contextlib
import functools
import os
import socket
import warnings
from collections.abc import Iterator
from typing import Any

from gyrotest.errors import InstrumentError
from gyrotest.instruments.transport.channel import Channel, FlowControl, Parity, SerialLine
from gyrotest.instruments.transport.tcp import SocketChannel, send_at_once

_PROLOGIX = "PRLGX-"
_CLEAR_OVER_RS232 = b"\x03"


@functools.cache
def resource_manager() -> Any:
    """The process's one resource manager: closing one would close the sessions of all."""
    import pyvisa

    with warnings.catch_warnings():
        # Said at every import where no GPIB library is installed, needed or not.
        warnings.filterwarnings("ignore", message="GPIB library not found")
        return pyvisa.ResourceManager(os.environ.get("PYVISA_LIBRARY", "@py"))


def open_channel(resource: str, line: SerialLine, timeout_s: float) -> Channel:
    """Open a resource; for a Prologix adapter `PRLGX-…::INTFC GPIBn::a::INSTR`. Raises `InstrumentError`.

    That something answers there is only known after the first query.
    """
    parts = resource.split()
    if len(parts) != (2 if resource.upper().startswith(_PROLOGIX) else 1):
        raise InstrumentError(
            f"{resource}: not understood; write one VISA resource, or for a Prologix adapter its interface"
            " and the instrument: 'PRLGX-TCPIP0::host::1234::INTFC GPIB0::22::INSTR'"
        )
    try:
        with os_errors():
            if len(parts) == 2:
                from gyrotest.instruments.transport.prologix import open_prologix

                return open_prologix(resource_manager(), parts[0], parts[1], timeout_s)
            return _open_plain(resource_manager(), resource, line, timeout_s)
    except InstrumentError:
        raise
    except Exception as error:  # PyVISA-py raises bare exceptions where a connection fails
        raise InstrumentError(
            f"{resource}: cannot be opened ({error}); is the instrument switched on and the address right?"
        ) from error


@contextlib.contextmanager
def os_errors() -> Iterator[None]:
    """Turn pyvisa's I/O errors into `TimeoutError` and `OSError`."""
    from pyvisa.constants import StatusCode
    from pyvisa.errors import InvalidSession, VisaIOError

    try:
        yield
    except VisaIOError as error:
        if error.error_code == StatusCode.error_timeout:
            raise TimeoutError from error
        raise OSError(str(error)) from error
    except InvalidSession as error:
        raise OSError("the session is closed") from error


def open_session(manager: Any, resource: str, timeout_s: float) -> Any:
    """Open one session, whose connection is made in the time given at most."""
    _refuse_unknown_host(resource)
    return manager.open_resource(resource, open_timeout=round(1000 * timeout_s))


def _refuse_unknown_host(resource: str) -> None:
    """Raise where a host has no address: PyVISA-py would leave a socket open then."""
    from pyvisa.rname import InvalidResourceName, parse_resource_name

    try:
        host = getattr(parse_resource_name(resource), "host_address", None)
    except InvalidResourceName as error:
        raise OSError(f"'{resource}' is no VISA resource") from error
    if host is not None:
        # Of a VXI-11 resource the port may follow the host, after a comma.
        socket.getaddrinfo(host.partition(",")[0], None, socket.AF_INET)


def socket_beneath(session: Any) -> socket.socket | None:
    """The TCP connection of a session of PyVISA-py; None for other sessions and libraries."""
    sessions = getattr(session.visalib, "sessions", {})
    interface = getattr(sessions.get(session.session), "interface", None)
    return interface if isinstance(interface, socket.socket) else None


def refuse_unconnected(connection: socket.socket) -> None:
    """Raise what became of the connection: an open to a refused port looks like a success."""
    error = connection.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
    if error:
        raise OSError(error, os.strerror(error))


def _open_plain(manager: Any, resource: str, line: SerialLine, timeout_s: float) -> Channel:
    session = open_session(manager, resource, timeout_s)
    try:
        return _channel_of(session, line)
    except BaseException:
        session.close()
        raise


def _channel_of(session: Any, line: SerialLine) -> Channel:
    from pyvisa.constants import InterfaceType

    if session.interface_type == InterfaceType.asrl:
        return SerialChannel(session, line)
    connection = socket_beneath(session)
    if connection is None or session.resource_class != "SOCKET":
        return VisaChannel(session)
    refuse_unconnected(connection)
    send_at_once(connection)
    return SocketChannel(connection, session.close)


class VisaChannel:
    """A pyvisa session whose messages have an end of their own (GPIB, USB, VXI-11, HiSLIP)."""

    seconds_per_byte = 0.0
    longest_wait_s: float | None = None
    remote_by_command = False

    def __init__(self, session: Any, timed: Any = None) -> None:
        self._session = session
        self._timed = session if timed is None else timed
        self._timeout_s = -1.0
        with contextlib.suppress(OSError):
            self.clear()

    def unread(self) -> bytes:
        """Nothing: these interfaces hold a reply back until it is read."""
        return b""

    def send(self, data: bytes) -> None:
        """Send all the bytes."""
        with os_errors():
            self._session.write_raw(data)

    def receive_line(self, timeout_s: float) -> bytes:
        """The bytes up to the message's end."""
        self._wait_at_most(timeout_s)
        with os_errors():
            return bytes(self._session.read_raw())

    def receive_exactly(self, count: int, timeout_s: float) -> bytes:
        """That many bytes, whatever they are."""
        if not count:
            return b""
        self._wait_at_most(timeout_s)
        with os_errors():
            return bytes(self._session.read_bytes(count))

    def clear(self) -> None:
        """Device clear."""
        with os_errors():
            self._session.clear()

    def go_to_local(self) -> None:
        """Give the front panel back."""
        from pyvisa.constants import RENLineOperation

        with os_errors():
            if hasattr(self._session, "control_ren"):
                self._session.control_ren(RENLineOperation.address_gtl)

    def close(self) -> None:
        """Disconnect."""
        with contextlib.suppress(OSError), os_errors():
            self._session.close()

    def _wait_at_most(self, timeout_s: float) -> None:
        if timeout_s != self._timeout_s:
            self._timed.timeout = 1000 * timeout_s
            self._timeout_s = timeout_s


class SerialChannel(VisaChannel):
    """A serial line; Ctrl-C is its device clear."""

    remote_by_command = True

    def __init__(self, session: Any, line: SerialLine) -> None:
        self.seconds_per_byte = line.seconds_per_byte
        set_line(session, line)
        super().__init__(session)

    def unread(self) -> bytes:
        """What has arrived without being asked for."""
        with os_errors():
            waiting = self._session.bytes_in_buffer
            return self.receive_exactly(waiting, 1.0) if waiting else b""

    def clear(self) -> None:
        """Device clear, and forget what has arrived."""
        with os_errors():
            self._session.write_raw(_CLEAR_OVER_RS232)
            self._session.flush(_discard_received())

    def go_to_local(self) -> None:
        """Nothing: over a serial line a command does it."""


def _discard_received() -> Any:
    from pyvisa.constants import BufferOperation

    return BufferOperation.discard_read_buffer


def set_line(session: Any, line: SerialLine) -> None:
    """Set a serial session up: line settings, and a line feed as the end of a message."""
    from pyvisa import constants

    session.baud_rate = line.baud_rate
    session.data_bits = line.data_bits
    session.parity = {
        Parity.NONE: constants.Parity.none,
        Parity.EVEN: constants.Parity.even,
        Parity.ODD: constants.Parity.odd,
    }[line.parity]
    session.stop_bits = {1: constants.StopBits.one, 2: constants.StopBits.two}[line.stop_bits]
    session.flow_control = {
        FlowControl.NONE: constants.ControlFlow.none,
        FlowControl.XON_XOFF: constants.ControlFlow.xon_xoff,
        FlowControl.RTS_CTS: constants.ControlFlow.rts_cts,
        FlowControl.DTR_DSR: constants.ControlFlow.dtr_dsr,
    }[line.flow_control]
    session.end_input = constants.SerialTermination.termination_char
    session.end_output = constants.SerialTermination.none
