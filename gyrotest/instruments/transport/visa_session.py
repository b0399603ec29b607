"""Sessions of pyvisa, and bytes through them for whatever is no plain socket."""

import contextlib
import os
import socket
from collections.abc import Iterator
from typing import Any


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
