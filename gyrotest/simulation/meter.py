"""A simulated digital multimeter: its settings, its trigger and timing, its memory."""

import math
from collections import deque
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from gyrotest.ports import Clock
from gyrotest.simulation.converter import Converter
from gyrotest.simulation.meter_state import (
    Acquisition,
    HangUp,
    Interface,
    Model,
    Reply,
    Settings,
    Status,
)
from gyrotest.simulation.scenarios import Misbehaviour
from gyrotest.simulation.scpi import ErrorQueue, ScpiError, Table

_AUTO_DELAY_S = 1.5e-3
_SHORTEST_READING_S = 1e-3
_TIMER_OVERHEAD_S = 20e-6
_TIMER_STEP_S = 1e-6
_BATCH = 512
_LIVE_BATCH_S = 0.1
_GARBAGE = b"\x15\x7f?+2.5#\x0b;0E"


class Meter:
    """A multimeter that reads a converter; `execute` takes one program message at a time.

    `live`: long replies are handed on in small parts. `hurried`: its clock is moved by nobody else.
    """

    def __init__(
        self,
        model: Model,
        table: "Table[Meter]",
        *,
        serial_number: str,
        line_frequency_hz: float,
        clock: Clock,
        converter: Converter,
        live: bool,
        hurried: bool = False,
    ) -> None:
        self.model = model
        self.serial_number = serial_number
        self.line_frequency_hz = line_frequency_hz
        self.converter = converter
        self.settings = Settings()
        self.status = Status()
        self.errors = ErrorQueue()
        self.memory_overflowed = False
        self.memory: deque[float] = deque(maxlen=model.memory)
        self.acquisition: Acquisition | None = None
        self.waiting_for_trigger = False
        self.remote = False
        self.interface = Interface.SOCKET
        self.now_s = clock.now_s()
        self._table = table
        self._clock = clock
        self._live = live
        self._hurried = hurried
        self._dead = False
        self._reading_asked = False

    # The dialogue

    def execute(self, message: str, interface: Interface) -> Reply | None:
        """Carry out a program message; the reply, if there is one. May raise `HangUp`."""
        if self._dead:
            return None
        self.interface = interface
        self.now_s = max(self.now_s, self._clock.now_s())
        self._reading_asked = False
        answers: list[str | bytes | Iterator[bytes]] = []
        for call in self._table.compile(message):
            try:
                if call.action is None:
                    raise ScpiError(call.refusal)
                answer = call.action(self, call.parameters)
            except ScpiError as error:
                self.refuse(error.code)
                continue
            if answer is not None:
                answers.append(answer)
        reply = self._reply(answers) if answers else None
        return self._struck(reply) if self._reading_asked else reply

    def refuse(self, code: int) -> None:
        """Put an error into the queue and into the event register."""
        self.errors.push(code)
        self.status.event |= _event_bit(code)

    def _reply(self, answers: list[str | bytes | Iterator[bytes]]) -> Reply:
        end = b"\r\n" if self.interface is Interface.SERIAL else b"\n"
        if len(answers) == 1:
            answer = answers[0]
            if isinstance(answer, str):
                return Reply(parts=((self.now_s, answer.encode() + end),))
            if not isinstance(answer, bytes):
                return Reply(parts=self._stream(answer, end))
        return Reply(parts=((self.now_s, b";".join(map(_joined, answers)) + end),))

    def _stream(self, answer: Iterator[bytes], end: bytes) -> Iterator[tuple[float, bytes]]:
        for part in answer:
            yield self.now_s, part
        yield self.now_s, end

    def _struck(self, reply: Reply | None) -> Reply | None:
        strike = self.converter.faults.strike(self.now_s)
        if strike is None:
            return reply
        if strike is Misbehaviour.GARBLE:
            return Reply(parts=((self.now_s, _GARBAGE + b"\n"),))
        self._dead = strike is Misbehaviour.DEAD
        if strike is Misbehaviour.HANG_UP and self.interface is not Interface.SERIAL:
            raise HangUp
        return None

    def connect(self, converter: Converter) -> None:
        """Put another signal on the input; what was under way on the old one is dropped."""
        self.acquisition = None
        self.waiting_for_trigger = False
        self.converter = converter

    def clear(self) -> None:
        """Device clear: stop what is under way; settings and errors stay."""
        self.abort()

    # Timing

    @property
    def aperture_s(self) -> float:
        """Integration time of one reading, s."""
        return self.settings.nplc / self.line_frequency_hz

    @property
    def reading_s(self) -> float:
        """Time that one reading takes, without delay: doubled by autozero, s."""
        return max(self.aperture_s, _SHORTEST_READING_S) * (2 if self.settings.autozero else 1)

    @property
    def delay_s(self) -> float:
        """The trigger delay, s."""
        delay = self.settings.trigger_delay_s
        return _AUTO_DELAY_S if delay is None else delay

    @property
    def shortest_timer_s(self) -> float:
        """The shortest sample interval that can be kept, s."""
        return math.ceil((self.reading_s + _TIMER_OVERHEAD_S) / _TIMER_STEP_S - 1e-6) * _TIMER_STEP_S

    def quantised_timer(self, wanted_s: float) -> float:
        """The sample interval that is really set, s."""
        return round(wanted_s / _TIMER_STEP_S) * _TIMER_STEP_S

    @property
    def spacing_s(self) -> float:
        """From the start of one reading to the start of the next, s."""
        if self.settings.timed:
            return max(self.settings.timer_s, self.shortest_timer_s)
        return self.reading_s + (self.delay_s if self.model.delay_each_sample else 0.0)

    # Readings

    @property
    def wanted(self) -> float:
        """Samples times triggers."""
        return self.settings.samples * self.settings.trigger_count

    def initiate(self) -> None:
        """`INIT`: clear the memory and begin, or wait for the trigger; raises `ScpiError`."""
        if self.busy():
            raise ScpiError(-213)
        if not self.model.keeps_newest and self.wanted > self.model.memory:
            raise ScpiError(531)
        self.memory.clear()
        self.memory_overflowed = False
        self.acquisition = None
        if self.settings.trigger_source == "IMM":
            self.trigger()
        else:
            self.waiting_for_trigger = True

    def trigger(self) -> None:
        """Begin the readings."""
        self.waiting_for_trigger = False
        self.acquisition = self._begin()

    def _begin(self) -> Acquisition:
        return Acquisition(
            start_s=self.now_s + self.delay_s,
            aperture_s=self.aperture_s,
            spacing_s=self.spacing_s,
            busy_s=self.reading_s,
            count=self.wanted,
        )

    def abort(self) -> None:
        """Back to idle; what is in the memory stays."""
        self.catch_up()
        self.acquisition = None
        self.waiting_for_trigger = False

    def busy(self) -> bool:
        """Whether readings are under way (or waited for) at this moment."""
        self.catch_up()
        return self.waiting_for_trigger or self.acquisition is not None

    def catch_up(self) -> None:
        """Take the readings that the time since has made due."""
        under_way = self.acquisition
        if under_way is None:
            return
        while (due := under_way.ready(self.now_s) - under_way.done) > 0:
            first = under_way.done
            values = self._read(under_way, first, min(due, _BATCH))
            if len(self.memory) + len(values) > self.model.memory:
                self.memory_overflowed = True
                self.status.questionable_event |= 1 << 14
            self.memory.extend(values)
            under_way.done = first + len(values)
        if under_way.done >= under_way.count:
            self.acquisition = None

    def finish(self) -> None:
        """Wait until the readings under way are all there; raises `ScpiError` where they never will be."""
        if self.waiting_for_trigger or (self.acquisition and math.isinf(self.acquisition.count)):
            raise ScpiError(-214)
        if self.acquisition is not None:
            self.now_s = max(self.now_s, self.acquisition.end_s)
        self.catch_up()

    def wait_for(self, count: int) -> None:
        """Wait until the memory holds that many readings; raises `ScpiError` where it never will."""
        self.catch_up()
        missing = count - len(self.memory)
        under_way = self.acquisition
        if missing <= 0:
            return
        if under_way is None or under_way.done + missing > under_way.count or count > self.model.memory:
            raise ScpiError(-222)
        last = under_way.done + missing - 1
        self.now_s = max(self.now_s, under_way.start_s + last * under_way.spacing_s + under_way.busy_s)
        self.catch_up()

    def asked_for_readings(self) -> None:
        """Note that this message asks for readings: what strikes, strikes its reply.

        Where nobody but the meter moves its time, the readings under way are then awaited.
        """
        self._reading_asked = True
        if self._hurried and self.acquisition is not None and not self.memory:
            self.wait_for(int(min(_BATCH, self.acquisition.count - self.acquisition.done)))

    def may_measure(self) -> None:
        """Refuse a measurement over RS-232 before `SYST:REM`; raises `ScpiError`."""
        if self.interface is Interface.SERIAL and self.model.serial_needs_remote and not self.remote:
            raise ScpiError(550)

    def status_byte(self) -> int:
        """The status byte (IEEE 488.2): questionable data, standard event, request for service."""
        summary = bool(self.status.questionable_event & self.status.questionable_enable) << 3
        summary |= bool(self.status.event & self.status.event_enable) << 5
        return summary | bool(summary & self.status.service_enable) << 6

    def read_one(self) -> float:
        """One reading now, as `READ?` takes it with one sample and one trigger."""
        settings = self.settings
        start_s = self.now_s + self.delay_s
        value = self.converter.reading(
            start_s, self.aperture_s, range_v=settings.range_v, nplc=settings.nplc
        )
        self.now_s = start_s + self.reading_s
        return value

    def read_through(self, form: Callable[[list[float]], bytes]) -> Iterator[bytes]:
        """All readings, handed on as they come and not kept, as `READ?` of many does."""
        under_way = self._begin()
        batch = max(1, min(_BATCH, int(_LIVE_BATCH_S / under_way.spacing_s))) if self._live else _BATCH
        while under_way.done < under_way.count:
            first = under_way.done
            values = self._read(under_way, first, int(min(batch, under_way.count - first)))
            under_way.done = first + len(values)
            self.now_s = (
                under_way.start_s + (under_way.done - 1) * under_way.spacing_s + under_way.busy_s
            )
            yield (b"," if first else b"") + form(values)

    def _read(self, under_way: Acquisition, first: int, count: int) -> list[float]:
        values: NDArray[np.float64] = self.converter.readings(
            under_way.start_s + first * under_way.spacing_s,
            under_way.aperture_s,
            under_way.spacing_s,
            count,
            range_v=self.settings.range_v,
            nplc=self.settings.nplc,
        )
        readings: list[float] = values.tolist()
        return readings


def _joined(answer: str | bytes | Iterator[bytes]) -> bytes:
    if isinstance(answer, str):
        return answer.encode()
    return answer if isinstance(answer, bytes) else b"".join(answer)


def _event_bit(code: int) -> int:
    """The bit of the standard event register for an error (IEEE 488.2): command 5, execution 4, query 2."""
    classes = {-1: 1 << 5, -2: 1 << 4, -4: 1 << 2}
    return classes.get(-(-code // 100), 1 << 3) if code < 0 else 1 << 3
