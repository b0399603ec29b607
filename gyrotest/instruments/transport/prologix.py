"""A GPIB instrument behind a Prologix adapter, on the network or on a serial port."""

import contextlib
import select
import socket
from typing import Any

from gyrotest.instruments.transport.tcp import peer_has_gone, send_at_once
from gyrotest.instruments.transport.visa_session import (
    VisaChannel,
    open_session,
    os_errors,
    refuse_unconnected,
    socket_beneath,
)

# PyVISA-py sets 50 ms, too short for a precise reading; 3000 ms is the most that the adapter takes.
_READ_TIMEOUT_MS = 3000
_CHUNK = 65536


def open_prologix(
    manager: Any, interface_name: str, instrument_name: str, timeout_s: float
) -> "PrologixChannel":
    """Open the adapter, unless an instrument of this process has it open already, and the instrument."""
    interface = _open_already(manager, interface_name)
    if interface is None:
        interface = _open_interface(manager, interface_name, timeout_s)
        try:
            _set_up(interface)
        except BaseException:
            interface.close()
            raise
    return PrologixChannel(manager, open_session(manager, instrument_name, timeout_s), interface)


def _open_interface(manager: Any, interface_name: str, timeout_s: float) -> Any:
    from pyvisa_py import prologix

    known = set(prologix._PrologixIntfcSession.boards.values())
    try:
        return open_session(manager, interface_name, timeout_s)
    except BaseException:
        # PyVISA-py enters an adapter before it has spoken to it, and does not strike it out again.
        for half_open in set(prologix._PrologixIntfcSession.boards.values()) - known:
            half_open.close()
        raise


def _open_already(manager: Any, interface_name: str) -> Any:
    from pyvisa.rname import to_canonical_name

    wanted = to_canonical_name(interface_name)
    for session in manager.list_opened_resources():
        if to_canonical_name(session.resource_name) == wanted:
            connection = socket_beneath(session)
            if connection is None or not peer_has_gone(connection):
                return session
            session.close()
    return None


def _set_up(interface: Any) -> None:
    connection = socket_beneath(interface)
    if connection is not None:
        refuse_unconnected(connection)
        send_at_once(connection)
    interface.write_raw(b"++read_tmo_ms %d\n" % _READ_TIMEOUT_MS)


class PrologixChannel(VisaChannel):
    """The instrument's session, and the adapter's, whose time-out and connection are what counts."""

    longest_wait_s: float | None = _READ_TIMEOUT_MS / 1000

    def __init__(self, manager: Any, session: Any, interface: Any) -> None:
        from pyvisa.constants import StatusCode

        self._interface = interface
        self._all_read = StatusCode.success_max_count_read
        self._connection: socket.socket | None = socket_beneath(interface)
        self._manager = manager
        self._board = session.resource_name.split("::")[0] + "::"
        super().__init__(session, timed=interface)

    def unread(self) -> bytes:
        """Nothing: what is stale is dropped here; raises at once if the peer has gone.

        To be called before every write: PyVISA-py's own dropping never ends on a closed connection.
        """
        connection = self._connection
        if connection is not None and connection.fileno() < 0:
            raise ConnectionAbortedError("another instrument found the adapter gone")
        while connection is not None and select.select((connection,), (), (), 0)[0]:
            if not connection.recv(_CHUNK):
                raise ConnectionAbortedError("the adapter closed the connection")
        return b""

    def send(self, data: bytes) -> None:
        """Send all the bytes."""
        self.unread()
        super().send(data)

    def receive_line(self, timeout_s: float) -> bytes:
        """The bytes up to and including the next line feed."""
        self._await_reply(timeout_s)
        return super().receive_line(timeout_s)

    def receive_exactly(self, count: int, timeout_s: float) -> bytes:
        """That many bytes, whatever they are."""
        self._await_reply(timeout_s)
        return super().receive_exactly(count, timeout_s)

    def go_to_local(self) -> None:
        """Give the front panel back."""
        self.unread()
        with os_errors():
            self._interface.write_raw(b"++loc\n")

    def close(self) -> None:
        """Disconnect; the adapter too where no other instrument uses it."""
        super().close()
        with contextlib.suppress(OSError), os_errors():
            if not any(
                one.resource_name.startswith(self._board)
                for one in self._manager.list_opened_resources()
            ):
                self._interface.close()

    def _await_reply(self, timeout_s: float) -> None:
        """Let the adapter address the instrument to talk, then wait so that a closed peer is seen."""
        if self._connection is None or self._received():
            return
        with os_errors(), self._session.ignore_warning(self._all_read):
            self._session.visalib.read(self._session.session, 0)
        if not select.select((self._connection,), (), (), timeout_s)[0]:
            raise TimeoutError
        if peer_has_gone(self._connection):
            raise ConnectionAbortedError("the adapter closed the connection")

    def _received(self) -> bool:
        # The rest of a message whose beginning was read: there is no public way to ask for it.
        beneath = self._interface.visalib.sessions[self._interface.session]
        return bool(getattr(beneath, "_pending_buffer", b""))
