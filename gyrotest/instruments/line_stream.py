"""Any board that prints its readings line by line, over a serial port or TCP."""

import contextlib
import math
import re
from typing import ClassVar

from gyrotest.errors import InstrumentError, InstrumentIdentityError
from gyrotest.instruments.line_stream_settings import LineStreamSettings
from gyrotest.instruments.streaming.flow import Flow, Rhythm
from gyrotest.instruments.streaming.lines import Layout, LineDecoder, by_columns, by_pattern
from gyrotest.instruments.streaming.readings import Counter
from gyrotest.instruments.streaming.samples import readings_in
from gyrotest.instruments.transport.byte_stream import OpenStream, open_stream
from gyrotest.instruments.transport.channel import SerialLine
from gyrotest.ports import Clock
from gyrotest.records.bench import Device
from gyrotest.records.recording import Auxiliary, Block, Identity, Sampling
from gyrotest.records.station import Accuracy
from gyrotest.units import same_dimension

_OPEN_TIMEOUT_S = 3.0
_IO_TIMEOUT_S = 5.0
_ANSWER_STEP_S = 0.1
_ANSWER_STEPS = 10


class LineStream:
    """A gyro whose samples are numbers in lines of text, or means of a whole number of them.

    Without a counter in the line, losses shorter than 0.1 s are not found unless a line arrives broken.
    """

    settings: ClassVar[type] = LineStreamSettings

    def __init__(
        self,
        resource: str,
        settings: LineStreamSettings,
        *,
        clock: Clock,
        line_frequency_hz: float | None = None,  # noqa: ARG002 - the constructor is the same for all sources
        accuracy: Accuracy | None = None,
        io_timeout_s: float | None = None,
        serial_number: str | None = None,
        connect: OpenStream = open_stream,
    ) -> None:
        self._resource, self._settings, self._connect = resource, settings, connect
        self._accuracy, self._serial_number = accuracy, serial_number
        self._open_timeout_s = _OPEN_TIMEOUT_S if io_timeout_s is None else io_timeout_s
        self._period_s = 1.0 / settings.sample_rate.to("Hz")
        counter = None
        if settings.counter_modulus is not None:
            counter = Counter(modulus=settings.counter_modulus, step=settings.counter_step)
        self._flow = Flow(
            f"{resource} (line stream)",
            LineDecoder(layout_of(settings)),
            Rhythm(period_s=self._period_s, counter=counter),
            clock=clock,
            io_timeout_s=_IO_TIMEOUT_S if io_timeout_s is None else io_timeout_s,
        )
        self._device = Device()

    def open(self) -> Identity:
        """Connect, ask for the serial number where the station says how, and make the board send."""
        line = SerialLine(baud_rate=self._settings.baud_rate, parity=self._settings.parity)
        self._flow.intake.attach(self._connect(self._resource, line, self._open_timeout_s))
        self._device = Device(serial_number=self._asked())
        self._check_serial_number()
        if self._settings.start:
            self._flow.intake.send(self._settings.start.encode())
        return Identity(
            manufacturer="",
            model="line stream",
            serial_number=self._device.serial_number or self._serial_number or "",
        )

    def device(self) -> Device:
        """What the board says of itself: the serial number at most."""
        return self._device

    def configure(self, interval_s: float) -> Sampling:
        """See that lines come as often as the station says, and how many make a sample."""
        size = readings_in(interval_s, self._period_s)
        if not size:
            raise InstrumentError(
                f"{self._flow.who}: sends a line every {self._period_s:g} s, of which an interval of"
                f" {interval_s:g} s is no whole multiple; the shortest is {self._period_s:g} s"
            )
        self._flow.listen()
        self._flow.configure(size, interval_s)
        settings, unit = self._settings, self._settings.unit
        return Sampling(
            interval_s=interval_s,
            aperture_s=self._period_s,
            readings=size,
            unit=unit,
            channels=tuple(settings.channels),
            auxiliary=tuple(
                Auxiliary(name=name, unit=one.unit) for name, one in settings.auxiliary.items()
            ),
            noise=self._noise(unit, size),
            range=None if settings.range is None else settings.range.to(unit),
        )

    def start(self, first: int, count: int) -> None:
        """Begin: the first line is sample 0; later starts keep that grid."""
        self._flow.start(first, count)

    def fetch(self) -> Block | None:
        """Wait for the next samples, about a second of them; None after the last."""
        return self._flow.fetch()

    def recover(self) -> int:
        """Connect anew; returns the position on the grid at which sampling can go on."""
        self._flow.intake.detach()
        before = self._device.serial_number
        self.open()
        if before is not None and self._device.serial_number != before:
            raise InstrumentIdentityError(
                f"{self._flow.who}: found serial number {self._device.serial_number}, expected {before}"
                " as before; connect that unit again"
            )
        return self._flow.position_to_go_on()

    def remarks(self) -> tuple[str, ...]:
        """What was lost, and the lines that did not fit."""
        return tuple(f"line stream: {text}" for text in self._flow.remarks())

    def close(self) -> None:
        """Make the board stop, and disconnect; never raises."""
        with contextlib.suppress(InstrumentError):
            if self._settings.stop:
                self._flow.intake.send(self._settings.stop.encode())
        self._flow.intake.detach()

    def _asked(self) -> str | None:
        """The serial number; None where the station does not say how to ask, or no answer fits."""
        pattern = self._settings.serial_number_pattern
        if pattern is None:
            return None
        self._flow.intake.send(self._settings.ask_serial_number.encode())
        said = b""
        for _ in range(_ANSWER_STEPS):
            said += self._flow.intake.raw(_ANSWER_STEP_S)
            for line in said.decode("ascii", errors="replace").split("\n")[:-1]:
                if found := re.search(pattern, line):
                    return found[1].strip()
        return None

    def _check_serial_number(self) -> None:
        found, expected = self._device.serial_number, self._serial_number
        if None not in (found, expected) and found != expected:
            raise InstrumentIdentityError(
                f"{self._flow.who}: found serial number {found}, expected {expected};"
                " correct the station's serial_number or connect that unit"
            )

    def _noise(self, unit: str, size: int) -> float | None:
        """The board's own noise, of one sample; None where not known."""
        noise = self._accuracy.noise if self._accuracy else None
        if noise is None or not same_dimension(noise.unit, unit):
            return None
        return noise.to(unit) / math.sqrt(size)


def layout_of(settings: LineStreamSettings) -> Layout:
    """How the settings' lines are read."""
    if settings.pattern is None:
        split, names = by_columns(settings.columns, settings.separator), settings.columns
    else:
        split, names = by_pattern(settings.pattern)
    scales = [one.to(settings.unit) for one in settings.channels.values()]
    return Layout(
        split=split,
        places=tuple(names.index(name) for name in (*settings.channels, *settings.auxiliary)),
        scales=(*scales, *(one.value for one in settings.auxiliary.values())),
        outputs=len(settings.channels),
        full_scale=math.inf if settings.range is None else abs(settings.range.to(settings.unit)),
        counter=None if settings.counter is None else names.index(settings.counter),
    )
