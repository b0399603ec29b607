"""A SCPI instrument's session: open, know who is there, come back after a fault, close."""

import contextlib

from gyrotest.errors import InstrumentError, InstrumentIdentityError, InstrumentProtocolError
from gyrotest.instruments.identity import Expected, check_identity, parse_identity
from gyrotest.instruments.scpi import drain_errors
from gyrotest.instruments.transport.channel import Connect, SerialLine
from gyrotest.instruments.transport.conversation import Conversation, shown
from gyrotest.instruments.transport.visa import open_channel
from gyrotest.records.recording import Identity

_OPEN_TIMEOUT_S = 3.0
_REPLY_TIMEOUT_S = 5.0
_MOST_STALE_LINES = 5
_RESET = "*CLS;*RST"


class Session:
    """Opens and reopens the way to one instrument, whose identity it checks each time.

    `reset` is sent after each opening; an instrument whose state must not be lost has a milder one.
    """

    def __init__(
        self,
        resource: str,
        expected: Expected,
        *,
        line: SerialLine | None = None,
        serial_number: str | None = None,
        io_timeout_s: float | None = None,
        reset: str = _RESET,
        connect: Connect = open_channel,
    ) -> None:
        self._reset_command = reset
        self._resource = resource
        self._expected = expected
        self._line = SerialLine() if line is None else line
        self._serial_number = serial_number
        self._connect = connect
        self._talk: Conversation | None = None
        self.timeout_s = _REPLY_TIMEOUT_S if io_timeout_s is None else io_timeout_s
        self.open_timeout_s = _OPEN_TIMEOUT_S if io_timeout_s is None else io_timeout_s

    @property
    def talk(self) -> Conversation:
        """The conversation; raises `InstrumentError` where the instrument is not open."""
        if self._talk is None:
            raise InstrumentError(f"{self._resource}: not open; open the instrument first")
        return self._talk

    def open(self) -> Identity:
        """Connect and ask who is there, before anything is changed in an instrument that may be another."""
        self._talk = Conversation(
            self._resource, self._connect(self._resource, self._line, self.open_timeout_s)
        )
        try:
            identity = self._identify()
            self._reset()
        except InstrumentError:
            self.disconnect()
            raise
        # From now on only this very instrument will do.
        self._serial_number = identity.serial_number
        return identity

    def bring_back(self) -> None:
        """Clear, or connect anew; see that the same instrument answers; forget its errors and settings."""
        if not self._answers_after_clear():
            self.disconnect()
            self.open()
            return
        drain_errors(self.talk, self.timeout_s)
        self._reset()

    def leave(self, *commands: str) -> None:
        """Send last commands and disconnect; never raises."""
        if self._talk is None:
            return
        with contextlib.suppress(InstrumentError):
            for command in commands:
                self._talk.write(command)
            if self._talk.channel.remote_by_command:
                self._talk.write("SYST:LOC")
        self.disconnect()

    def disconnect(self) -> None:
        """Close the connection; never raises."""
        if self._talk is not None:
            self._talk.close()
            self._talk = None

    def _answers_after_clear(self) -> bool:
        if self._talk is None:
            return False
        self._talk.clear()
        try:
            self._identify()
        except InstrumentIdentityError:
            raise
        except InstrumentError:
            return False
        return True

    def _identify(self) -> Identity:
        """Ask `*IDN?`; late answers to earlier queries, which would shift all later ones, are dropped."""
        reply = self.talk.query("*IDN?", self.open_timeout_s)
        for _ in range(_MOST_STALE_LINES):
            identity = parse_identity(reply)
            if identity is not None:
                self.talk.name(identity.model)
                check_identity(
                    identity,
                    who=self._resource,
                    expected=self._expected,
                    serial_number=self._serial_number,
                )
                return identity
            reply = self.talk.read_line(self.open_timeout_s)
        raise InstrumentProtocolError(
            f"{self._resource}: *IDN? gives {shown(reply.encode())}, expected the four fields of an identity;"
            " is this a SCPI instrument?"
        )

    def _reset(self) -> None:
        if self.talk.channel.remote_by_command:
            self.talk.write("SYST:REM")
        self.talk.write(self._reset_command)
