"""What a simulated acquisition system is told and says over its connection: commands, replies and blocks."""

import json
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from gyrotest.simulation.daq_acquisition import Acquisition
from gyrotest.simulation.outlet import Outlet

# What it holds of what nobody takes; more is lost.
_HOLDS_BYTES = 4 << 20
# As much goes ahead where nobody but the system itself moves the time.
_HURRIED_BYTES = 1 << 18
_LONGEST_COMMAND = 1 << 16
# What divides its clock gives the rates that it has.
_CLOCK_HZ = 12.8e6
_LOWEST_HZ, _HIGHEST_HZ = 1.0, 100e3

_Answer = Mapping[str, Any] | Sequence[Mapping[str, Any]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """What was configured: channels in the order of the blocks' columns."""

    channels: tuple[str, ...]
    rate_hz: float
    external: bool


class System(Protocol):
    """What stands behind the connection."""

    def identity(self) -> Mapping[str, str]:
        """Who it is."""

    def channels(self) -> Sequence[Mapping[str, Any]]:
        """All its channels, as the protocol describes them."""

    def configured(self, setup: Setup) -> Mapping[str, Any]:
        """What a set-up comes to beside its rate."""

    def acquisition(self, setup: Setup, samples: int, now_s: float) -> Acquisition:
        """Begin one."""


class _RefusedError(Exception):
    """What cannot be done, in words."""


class Conversation:
    """One system's side, whoever is connected: a new caller ends what the one before had started.

    `hurried`: nobody else moves the time, so that nothing is lost however late it is taken.
    """

    def __init__(self, system: System, *, hurried: bool) -> None:
        self._system = system
        self._hurried = hurried
        self._caller = 0
        self._heard = b""
        self._waiting: deque[bytes] = deque()
        self._held = 0
        self._setup: Setup | None = None
        self._acquisition: Acquisition | None = None

    def transmit(self, now_s: float, outlet: Outlet) -> None:
        """Carry out what was asked, and send all that is due by now, as far as the line takes it."""
        heard = outlet.receive()
        if outlet.callers != self._caller:
            self.forget()
            self._caller = outlet.callers
        *commands, self._heard = (self._heard + heard).split(b"\n")
        self._heard = self._heard[:_LONGEST_COMMAND]
        for command in commands:
            self._say(json.dumps(self._answer(command, now_s, outlet)).encode() + b"\n")
        self._advance(now_s, outlet)
        self._send(outlet)

    def forget(self) -> None:
        """Nobody is connected any more: end what was started."""
        self._heard = b""
        self._waiting.clear()
        self._held = 0
        self._setup = self._acquisition = None

    def _advance(self, now_s: float, outlet: Outlet) -> None:
        """Acquire what is due by now."""
        while self._acquisition is not None:
            if self._hurried and self._held > _HURRIED_BYTES:
                return
            blocks = self._acquisition.blocks(now_s, full=self._held > _HOLDS_BYTES)
            if blocks is None:
                return
            self._say(*blocks)
            self._send(outlet)
            if self._acquisition.ended:
                self._acquisition = None

    def _say(self, *parts: bytes) -> None:
        self._waiting += parts
        self._held += sum(map(len, parts))

    def _send(self, outlet: Outlet) -> None:
        while self._waiting:
            part = self._waiting.popleft()
            sent = outlet.send(part)
            self._held -= sent
            if sent < len(part):
                self._waiting.appendleft(part[sent:])
                return

    def _answer(self, command: bytes, now_s: float, outlet: Outlet) -> _Answer:
        word, _, content = command.decode("latin-1").strip().partition(" ")
        try:
            if word == "STOP":
                return self._stop(now_s, outlet)
            if self._acquisition is not None:
                raise _RefusedError("it is sampling; send STOP first")
            return self._carried_out(word, content, now_s)
        except _RefusedError as refused:
            return {"error": str(refused)}

    def _carried_out(self, word: str, content: str, now_s: float) -> _Answer:
        if word == "IDENTIFY":
            return self._system.identity()
        if word == "CHANNELS":
            return self._system.channels()
        if word == "CONFIGURE":
            return self._configure(_content(content))
        if word == "START":
            return self._start(_content(content), now_s)
        raise _RefusedError(
            f"'{word}' is no command; known are IDENTIFY, CHANNELS, CONFIGURE, START and STOP"
        )

    def _configure(self, content: Mapping[str, Any]) -> _Answer:
        channels, rate_hz = content.get("channels"), content.get("rate_hz")
        trigger = content.get("trigger", "immediate")
        known = [str(one["name"]) for one in self._system.channels()]
        if not isinstance(channels, list) or not channels or not set(map(str, channels)) <= set(known):
            raise _RefusedError(f"'channels' {channels} are not among {', '.join(known)}")
        if not isinstance(rate_hz, int | float) or not _LOWEST_HZ <= rate_hz <= _HIGHEST_HZ:
            raise _RefusedError(f"'rate_hz' {rate_hz} is not {_LOWEST_HZ:g} to {_HIGHEST_HZ:g}")
        if trigger not in ("immediate", "external"):
            raise _RefusedError(f"'trigger' '{trigger}' is neither 'immediate' nor 'external'")
        setup = self._setup = Setup(
            channels=tuple(map(str, channels)),
            rate_hz=_CLOCK_HZ / round(_CLOCK_HZ / rate_hz),
            external=trigger == "external",
        )
        return {"rate_hz": setup.rate_hz, **self._system.configured(setup)}

    def _start(self, content: Mapping[str, Any], now_s: float) -> _Answer:
        samples = content.get("samples")
        if self._setup is None:
            raise _RefusedError("it is not configured; send CONFIGURE first")
        if not isinstance(samples, int) or samples < 0:
            raise _RefusedError(f"'samples' {samples} is no number of samples; 0 is until STOP")
        self._acquisition = self._system.acquisition(self._setup, samples, now_s)
        return {"armed": True}

    def _stop(self, now_s: float, outlet: Outlet) -> _Answer:
        self._advance(now_s, outlet)
        if self._acquisition is not None:
            self._say(self._acquisition.last_block())
            self._acquisition = None
        return {"stopped": True}


def _content(text: str) -> Mapping[str, Any]:
    try:
        found = json.loads(text)
    except ValueError:
        found = None
    if not isinstance(found, dict):
        raise _RefusedError(f"'{text}' is no JSON object")
    return found
