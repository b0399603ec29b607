"""Bytes of a gyro that talks unasked, read in step with the clock and decoded."""

from collections.abc import Callable
from typing import TypeVar

from gyrotest.errors import InstrumentError, InstrumentProtocolError, InstrumentTimeoutError
from gyrotest.instruments.streaming.readings import Decoder, Readings
from gyrotest.instruments.transport.byte_stream import ByteStream
from gyrotest.ports import Clock

# How long bytes that are due may be on their way, in real time, before they are taken for lost.
_ON_THE_WAY_S = 0.1
_LOOK_AGAIN_S = 0.05
# Bytes but no reading for so long, and for so many readings' time: these are not the bytes expected.
_GARBAGE_S = 2.0
_GARBAGE_READINGS = 4

_T = TypeVar("_T")


class Intake:
    """Reads one stream. Everything but `detach` raises `InstrumentError`, or a subclass that fits."""

    def __init__(
        self, who: str, decoder: Decoder, *, clock: Clock, io_timeout_s: float, period_s: float
    ) -> None:
        self._who, self._decoder, self._clock = who, decoder, clock
        self._io_timeout_s = io_timeout_s
        self._patience_s = max(_GARBAGE_S, _GARBAGE_READINGS * period_s)
        self._stream: ByteStream | None = None
        self._reading_s = 0.0
        self.read_s = 0.0

    def attach(self, stream: ByteStream) -> None:
        """Read from here on."""
        self._stream = stream

    def detach(self) -> None:
        """Disconnect; idempotent, never raises."""
        if self._stream is not None:
            self._stream.close()
            self._stream = None

    def send(self, data: bytes) -> None:
        """Send bytes to the gyro."""
        self._io(lambda stream: stream.write(data))

    def raw(self, duration_s: float) -> bytes:
        """What arrives in a while, undecoded."""
        self._clock.sleep_until(self._clock.now_s() + duration_s)
        return self._io(lambda stream: stream.read(1, _ON_THE_WAY_S))

    def restart(self) -> None:
        """Forget what has arrived."""
        self._io(lambda stream: stream.discard())
        self._decoder.restart()
        self.read_s = self._reading_s = self._clock.now_s()

    def some(self, step_s: float) -> Readings:
        """At least one reading."""
        while True:
            readings = self.by(self._clock.now_s() + step_s)
            if len(readings):
                return readings

    def by(self, deadline_s: float, outstanding: Callable[[float], int] | None = None) -> Readings:
        """What has arrived by the deadline; fails where nothing does, or nothing that makes sense.

        `outstanding` tells how many readings are due at a time: they are waited for a moment.
        """
        self._clock.sleep_until(deadline_s)
        due = outstanding(self._clock.now_s()) if outstanding else 0
        data = self._arrived(int(due * self._decoder.reading_bytes) - self._decoder.waiting())
        self.read_s = self._clock.now_s()
        readings = self._decoder.push(data)
        if len(readings):
            self._reading_s = self.read_s
        elif self.read_s - self._reading_s > self._patience_s:
            raise InstrumentProtocolError(f"{self._who}: {self._decoder.complaint()}")
        return readings

    def _arrived(self, least: int) -> bytes:
        """At least one byte."""
        until_s = self._clock.now_s() + self._io_timeout_s
        data = self._io(lambda stream: stream.read(least, _ON_THE_WAY_S))
        while not data:
            now_s = self._clock.now_s()
            if now_s >= until_s:
                raise InstrumentTimeoutError(
                    f"{self._who}: nothing has arrived for {self._io_timeout_s:g} s;"
                    " is the unit powered, and does it send on its own?"
                )
            self._clock.sleep_until(min(now_s + _LOOK_AGAIN_S, until_s))
            data = self._io(lambda stream: stream.read(1, _ON_THE_WAY_S))
        return data

    def _io(self, act: Callable[[ByteStream], _T]) -> _T:
        if self._stream is None:
            raise InstrumentError(f"{self._who}: not open; open the instrument first")
        try:
            return act(self._stream)
        except OSError as error:
            raise InstrumentError(
                f"{self._who}: connection lost: {error}; is the cable plugged in and the adapter there?"
            ) from error
