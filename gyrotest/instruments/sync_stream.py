"""A source with channels of one hardware clock, which speaks the block protocol over TCP."""

import contextlib
import math
from typing import ClassVar

from gyrotest.errors import (
    InstrumentError,
    InstrumentIdentityError,
    InstrumentProtocolError,
    InstrumentTimeoutError,
)
from gyrotest.instruments.block_stream.acquiring import Acquiring
from gyrotest.instruments.block_stream.answers import (
    ARMED,
    CHANNELS,
    CONFIGURED,
    IDENTITY,
    STOPPED,
    Configured,
)
from gyrotest.instruments.block_stream.assembly import Assembly
from gyrotest.instruments.block_stream.link import Link
from gyrotest.instruments.block_stream.messages import HEADER, Packet
from gyrotest.instruments.pacing import Grid
from gyrotest.instruments.sync_stream_settings import SyncStreamSettings
from gyrotest.instruments.synchronous.agreement import filter_hz, noise_of, refuse_other_rate
from gyrotest.instruments.synchronous.choice import Choice, choose, refuse_unknown
from gyrotest.instruments.synchronous.settings import Trigger, seconds
from gyrotest.instruments.transport.byte_stream import OpenStream, open_stream
from gyrotest.instruments.transport.channel import SerialLine
from gyrotest.ports import Clock
from gyrotest.records.bench import DaqChannel
from gyrotest.records.recording import Block, Identity, Sampling
from gyrotest.records.station import Accuracy

_OPEN_TIMEOUT_S = 3.0
_IO_TIMEOUT_S = 5.0
# What is read at once: about a second of it, but well below what a connection holds.
_READ_S = 1.0
_READ_BYTES = 131_072
_WORD = 4
# By the protocol no sample is held back for longer.
_HELD_BACK_S = 0.1
# How often it is looked for the first samples after an external trigger.
_TRIGGER_STEP_S = 0.1


class SyncStream:
    """Samples as they come, in blocks of about a second.

    After a lost connection the acquisition goes on at the next position of the same grid, as the computer's
    clock tells it: to some milliseconds. It does not wait for another trigger then.
    """

    settings: ClassVar[type] = SyncStreamSettings

    def __init__(
        self,
        resource: str,
        settings: SyncStreamSettings,
        *,
        clock: Clock,
        line_frequency_hz: float | None = None,  # noqa: ARG002 - the constructor is the same for all sources
        accuracy: Accuracy | None = None,
        io_timeout_s: float | None = None,
        serial_number: str | None = None,
        connect: OpenStream = open_stream,
    ) -> None:
        self._resource, self._settings, self._connect = resource, settings, connect
        self._clock, self._accuracy, self._serial_number = clock, accuracy, serial_number
        self._open_timeout_s = _OPEN_TIMEOUT_S if io_timeout_s is None else io_timeout_s
        self._link = Link(
            resource, clock=clock, io_timeout_s=_IO_TIMEOUT_S if io_timeout_s is None else io_timeout_s
        )
        self._there: tuple[DaqChannel, ...] = ()
        self._outputs: tuple[str, ...] = ()
        self._auxiliary: tuple[str, ...] = ()
        self._acquiring: Acquiring | None = None
        self._armed_s = 0.0
        self._trigger: Trigger | None = None
        self._running = False

    def open(self) -> Identity:
        """Connect, ask who is there and which channels it has, stop what it does; raises `InstrumentError`."""
        link = self._link
        link.attach(self._connect(self._resource, SerialLine(), self._open_timeout_s))
        identity = link.ask("IDENTIFY", IDENTITY)
        link.name(identity.model)
        if self._serial_number not in (None, identity.serial_number):
            raise InstrumentIdentityError(
                f"{link.who}: found serial number {identity.serial_number}, expected {self._serial_number};"
                " correct the station's serial_number or connect that instrument"
            )
        # From now on only this very instrument will do.
        self._serial_number = identity.serial_number
        link.ask("STOP", STOPPED)
        self._running, self._trigger = False, None
        self._there = link.ask("CHANNELS", CHANNELS)
        self._check_channels()
        return identity

    def channels(self) -> tuple[DaqChannel, ...]:
        """Every channel that it has, after `open`."""
        return self._there

    def select(self, outputs: tuple[str, ...], auxiliary: tuple[str, ...]) -> None:
        """Say which channels are gyros' outputs, and which are recorded beside; none named: all."""
        self._outputs, self._auxiliary = outputs, auxiliary

    def configure(self, interval_s: float) -> Sampling:
        """Choose the channels and the rate, and hold what it answers against the station."""
        self._stop()
        who, settings = self._link.who, self._settings
        choice = choose(who, self._there, self._outputs, self._auxiliary)
        known = {one.name: one for one in self._there}
        refuse_unknown(who, "the station's 'skew'", tuple(settings.skew), known)
        configured = self._set_up(choice, 1.0 / interval_s, settings.trigger)
        self._acquiring = Acquiring(
            choice=choice,
            rate_hz=1.0 / interval_s,
            grid=Grid(self._clock, interval_s),
            assembly=Assembly(who, choice, interval_s),
        )
        self._link.messages.damaged = 0
        uncertainty = settings.skew_uncertainty
        return choice.sampling(
            interval_s,
            skew_s=seconds(settings.skew),
            skew_uncertainty_s=None if uncertainty is None else uncertainty.to("s"),
            filter_hz=filter_hz(who, said_hz=configured.filter_hz, stated=settings.filter),
            full_scale=configured.full_scale,
            noise=noise_of(self._accuracy, choice.units[0]),
        )

    def start(self, first: int, count: int) -> None:
        """Begin; sample 0 is the first after the trigger, after an interruption the grid stays."""
        now = self._ready()
        self._stop()
        trigger = self._settings.trigger if first == 0 else Trigger.IMMEDIATE
        if trigger is not self._trigger:
            self._set_up(now.choice, now.rate_hz, trigger)
        if first:
            self._clock.sleep_until(now.grid.deadline_s(first))
        self._running = True
        self._link.ask("START", ARMED, samples=count - first)
        now.assembly.begin(first, count)
        now.triggered = first > 0 or trigger is Trigger.IMMEDIATE
        if first == 0:
            now.grid.begin(0)
        self._armed_s = self._clock.now_s()

    def fetch(self) -> Block | None:
        """Wait for the next samples, about a second of them; None after the last."""
        now = self._ready()
        while True:
            block = now.assembly.block()
            if block is not None or now.assembly.ended:
                return block
            for packet in self._packets(now):
                now.assembly.take(packet)
            self._running = not now.assembly.ended

    def recover(self) -> int:
        """Connect anew; returns the position on the grid at which sampling can go on."""
        now = self._ready()
        self._link.close()
        before = self._there
        self.open()
        if self._there != before:
            raise InstrumentError(
                f"{self._link.who}: has other channels than before; begin the measurement anew"
            )
        if not now.triggered:
            return 0
        self._set_up(now.choice, now.rate_hz, Trigger.IMMEDIATE)
        now.recovered += 1
        return now.grid.position_to_go_on()

    def remarks(self) -> tuple[str, ...]:
        """What was lost and what was clipped since `configure`."""
        now = self._acquiring
        return (
            ()
            if now is None
            else tuple(f"{self._link.who}: {one}" for one in now.remarks(self._link.messages.damaged))
        )

    def close(self) -> None:
        """Stop it and disconnect; never raises."""
        with contextlib.suppress(InstrumentError):
            self._stop()
        self._link.close()

    def _ready(self) -> Acquiring:
        if self._acquiring is None:
            raise InstrumentError(f"{self._link.who}: not configured; configure the instrument first")
        return self._acquiring

    def _stop(self) -> None:
        """End what it does; what still comes is passed over."""
        if self._running:
            self._running = False
            self._link.ask("STOP", STOPPED)

    def _set_up(self, choice: Choice, rate_hz: float, trigger: Trigger) -> Configured:
        link = self._link
        configured = link.ask(
            "CONFIGURE", CONFIGURED, channels=choice.names, rate_hz=rate_hz, trigger=trigger.value
        )
        refuse_other_rate(link.who, asked_hz=rate_hz, had_hz=configured.rate_hz)
        link.messages.channels = len(choice.channels)
        self._trigger = trigger
        return configured

    def _packets(self, now: Acquiring) -> list[Packet]:
        """The next ones, after waiting for an external trigger where the first are still to come."""
        assembly, grid = now.assembly, now.grid
        if not now.triggered:
            return self._first_packets(now)
        row = len(now.choice.channels) * _WORD
        most = max(1, min(int(_READ_S * now.rate_hz), _READ_BYTES // row))
        end = min(assembly.position + most, assembly.end)
        due = end - assembly.position
        return self._link.packets(grid.deadline_s(end) + _HELD_BACK_S, HEADER.size + due * row)

    def _first_packets(self, now: Acquiring) -> list[Packet]:
        timeout_s = self._settings.trigger_timeout.to("s")
        while True:
            packets = self._link.poll(self._clock.now_s() + _TRIGGER_STEP_S)
            if packets:
                now.triggered_by(self._clock.now_s(), packets)
                return packets
            if self._clock.now_s() - self._armed_s > timeout_s:
                raise InstrumentTimeoutError(
                    f"{self._link.who}: no trigger within {timeout_s:g} s; is the trigger's cable plugged in, and"
                    " does what gives it run? (trigger, trigger_timeout)"
                )

    def _check_channels(self) -> None:
        names = [one.name for one in self._there]
        wrong = [
            one.name
            for one in self._there
            if not math.isfinite(one.scale) or one.scale == 0.0 or not math.isfinite(one.skew_s)
        ]
        if not names or len(set(names)) < len(names) or wrong:
            found = f"gives {wrong[0]} no scale or skew" if wrong else f"has the channels {names}"
            raise InstrumentProtocolError(
                f"{self._link.who}: {found}; each has a name of its own, a scale other than 0 and a skew"
            )
