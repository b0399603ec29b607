"""A serial line through pyvisa: its settings, and bytes that arrive without being asked for."""

from typing import Any

from gyrotest.instruments.transport.channel import FlowControl, Parity, SerialLine
from gyrotest.instruments.transport.visa_session import VisaChannel, os_errors

_CLEAR_OVER_RS232 = b"\x03"


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
