"""What all digital gyros on the simulated bench have in common: power, grid, line."""

import threading
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gyrotest.simulation.housed import Housed
from gyrotest.simulation.line_faults import LineFaults
from gyrotest.simulation.outlet import Outlet
from gyrotest.simulation.peer import Making
from gyrotest.simulation.sampled import BOOT_S, Sampled, Sampler
from gyrotest.simulation.unit import PowerOn


class Voice(Protocol):
    """How a model says its samples."""

    rate_hz: float
    period: int
    largest: int
    sending: bool

    def house(self, housed: Housed) -> None:
        """Be this unit from now on."""

    def frames(self, sampled: Sampled, status: NDArray[np.uint8]) -> NDArray[np.uint8] | list[bytes]:
        """The samples as they are sent: rows of bytes, or one after the other; `status` adds bits to it."""

    def hello(self) -> bytes:
        """What is sent once after power-on."""

    def answer(self, asked: bytes) -> bytes:
        """What is answered to bytes that came."""


class Emitter:
    """A unit on a line: sends what is due, and answers in between."""

    def __init__(self, making: Making, voice: Voice) -> None:
        self._making = making
        self._voice = voice
        self._sampler: Sampler | None = None
        self._faults: LineFaults | None = None
        self._power_on: PowerOn | None = None
        self._asked = b""
        # A record may begin while another thread sends.
        self._lock = threading.Lock()

    def house(self, housed: Housed) -> None:
        """Be this unit from now on, for its next record."""
        with self._lock:
            self._house(housed)

    def _house(self, housed: Housed) -> None:
        making = self._making
        self._voice.house(housed)
        self._sampler = Sampler(
            housed,
            seed=making.seed,
            rate_hz=self._voice.rate_hz,
            silent=making.scenario.dead_output,
        )
        self._faults = LineFaults(making.scenario, housed, seed=making.seed, period=self._voice.period)
        self._power_on = housed.planned

    def transmit(self, now_s: float, outlet: Outlet) -> None:
        """Answer what was asked, and send all that is due by now."""
        with self._lock:
            self._transmit(now_s, outlet)

    def _transmit(self, now_s: float, outlet: Outlet) -> None:
        sampler, faults = self._sampler, self._faults
        self._asked += outlet.receive()
        if sampler is None or faults is None:
            return
        if faults.unplugged(now_s):
            outlet.unplug()
            return
        power_on = sampler.housed.power_on
        due = sampler.due(now_s)
        if power_on is None or now_s < power_on.on_s + BOOT_S:
            # Without power nothing hears what is asked; while it boots the line keeps it.
            self._asked = self._asked if power_on is not None else b""
            sampler.skip(due)
            return
        booted = sampler.due(power_on.on_s + BOOT_S)
        sampler.skip(booted)
        due -= booted
        said = self._voice.hello() if power_on != self._power_on else b""
        self._power_on = power_on
        if self._asked:
            said += self._voice.answer(self._asked)
            self._asked = b""
        if due or said:
            self._send(outlet, said, due, power_on)

    def _send(self, outlet: Outlet, said: bytes, due: int, power_on: PowerOn) -> None:
        sampler, faults = self._sampler, self._faults
        if sampler is None or faults is None:
            return
        room = outlet.room - len(said) if self._voice.sending else 0
        fit = min(due, max(0, room) // self._voice.largest)
        sampler.skip(due - fit)
        data = said
        if fit:
            sampled = sampler.take(fit, power_on)
            frames = self._voice.frames(sampled, faults.status(sampled.time_s))
            if faults.touches(sampled.time_s):
                data += faults.strike([bytes(one) for one in frames], sampled.time_s)
            else:
                data += frames.tobytes() if isinstance(frames, np.ndarray) else b"".join(frames)
        outlet.send(faults.garbled(data))
