"""Opening VISA resources: each by the channel that suits it."""

import functools
import os
import warnings
from typing import Any

from gyrotest.errors import InstrumentError
from gyrotest.instruments.transport.asrl import SerialChannel
from gyrotest.instruments.transport.channel import Channel, SerialLine
from gyrotest.instruments.transport.prologix import open_prologix
from gyrotest.instruments.transport.tcp import SocketChannel, send_at_once
from gyrotest.instruments.transport.visa_session import (
    VisaChannel,
    open_session,
    os_errors,
    refuse_unconnected,
    socket_beneath,
)

_PROLOGIX = "PRLGX-"


def resource_manager() -> Any:
    """The process's one resource manager, made anew where somebody else in the process closed it."""
    from pyvisa.errors import InvalidSession

    manager = _resource_manager()
    try:
        _ = manager.session
    except InvalidSession:
        _resource_manager.cache_clear()
        return _resource_manager()
    return manager


@functools.cache
def _resource_manager() -> Any:
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
                return open_prologix(resource_manager(), parts[0], parts[1], timeout_s)
            return _open_plain(resource_manager(), resource, line, timeout_s)
    except InstrumentError:
        raise
    except Exception as error:  # PyVISA-py raises bare exceptions where a connection fails
        raise InstrumentError(
            f"{resource}: cannot be opened ({error}); is the instrument switched on and the address right?"
        ) from error


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
