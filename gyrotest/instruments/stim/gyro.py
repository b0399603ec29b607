"""The driver of serial gyros; a model is a table of frames and a record of settings."""

import contextlib
from typing import ClassVar

from gyrotest.errors import InstrumentError, InstrumentIdentityError
from gyrotest.instruments.stim import asking
from gyrotest.instruments.stim.asking import Configuration, Question
from gyrotest.instruments.stim.decoding import FrameDecoder
from gyrotest.instruments.stim.models import Model
from gyrotest.instruments.stim.settings import StimSettings
from gyrotest.instruments.stim.stream import FrameStream, counter_of
from gyrotest.instruments.streaming.flow import Flow, Rhythm
from gyrotest.instruments.streaming.samples import readings_in
from gyrotest.instruments.transport.byte_stream import OpenStream, open_stream
from gyrotest.instruments.transport.channel import SerialLine
from gyrotest.ports import Clock
from gyrotest.records.bench import Device
from gyrotest.records.recording import Auxiliary, Block, Identity, Sampling
from gyrotest.records.station import Accuracy

_AXES = ("x", "y", "z")
_OPEN_TIMEOUT_S = 3.0
_IO_TIMEOUT_S = 5.0
# An answer comes between two frames, a few milliseconds after the question.
_ANSWER_STEP_S = 0.05
_ANSWER_STEPS = 10


class SerialGyro:
    """A gyro that sends frames on its own. Each model inherits, for drivers are told apart by their class.

    A sample is one frame, or the mean of a whole number of them. All output modes are turned into deg/s.
    With the mode `rate` the gyro's own filter, not the sample's interval, limits the bandwidth: noise
    above half the sample rate is folded into the samples, as it is in the unit's use.
    """

    settings: ClassVar[type]
    model: ClassVar[Model]

    def __init__(
        self,
        resource: str,
        settings: StimSettings,
        *,
        clock: Clock,
        line_frequency_hz: float | None = None,  # noqa: ARG002 - the constructor is the same for all sources
        accuracy: Accuracy | None = None,  # noqa: ARG002 - as above
        io_timeout_s: float | None = None,
        serial_number: str | None = None,
        connect: OpenStream = open_stream,
    ) -> None:
        self._resource, self._settings, self._connect = resource, settings, connect
        self._serial_number = serial_number
        self._io_timeout_s = _IO_TIMEOUT_S if io_timeout_s is None else io_timeout_s
        self._open_timeout_s = _OPEN_TIMEOUT_S if io_timeout_s is None else io_timeout_s
        self._period_s = 1.0 / settings.sample_rate.to("Hz")
        self._decoder = FrameDecoder(
            self.model,
            self.model.frame(settings.frame),
            mode=settings.mode,
            period_s=self._period_s,
            crlf=settings.crlf,
        )
        counter = counter_of(self._decoder, settings.sample_rate.to("Hz"))
        self._flow = Flow(
            f"{resource} ({self.model.name})",
            FrameStream(self.model, self._decoder),
            Rhythm(period_s=self._period_s, counter=counter),
            clock=clock,
            io_timeout_s=self._io_timeout_s,
        )
        self._device = Device(mode=settings.mode, range_dps=settings.range.to("deg/s"))
        self._configuration: Configuration | None = None
        self._fresh = False

    def open(self) -> Identity:
        """Connect, and ask the unit who it is and how it is set; raises `InstrumentError`."""
        line = SerialLine(baud_rate=self._settings.baud_rate)
        self._flow.intake.attach(self._connect(self._resource, line, self._open_timeout_s))
        self._ask()
        self._fresh = True
        configuration = self._configuration
        return Identity(
            manufacturer="Sensonor",
            model=self.model.name,
            serial_number=self._device.serial_number or self._serial_number or "",
            firmware=configuration.firmware if configuration else "",
        )

    def device(self) -> Device:
        """What the unit says of itself, and where it does not answer what the station says of its setting."""
        return self._device

    def configure(self, interval_s: float) -> Sampling:
        """See that the unit sends what the station says, and how many frames make a sample."""
        size = readings_in(interval_s, self._period_s)
        if not size:
            raise InstrumentError(
                f"{self._flow.who}: sends a frame every {self._period_s:g} s, of which an interval of"
                f" {interval_s:g} s is no whole multiple; the shortest is {self._period_s:g} s"
            )
        fresh, self._fresh = self._fresh, False
        if not fresh:
            self._ask()
        self._check_configuration()
        self._flow.listen()
        if fresh and self._device.serial_number is None:
            # It may have been starting when it was asked.
            self._ask()
            self._check_configuration()
        self._flow.configure(size, interval_s)
        names = ("temperature_x", "temperature_y", "temperature_z")
        warm = self._decoder.frame.temperatures is not None
        return Sampling(
            interval_s=interval_s,
            aperture_s=self._period_s,
            readings=size,
            unit="deg/s",
            channels=_AXES,
            auxiliary=tuple(Auxiliary(name=name, unit="degC") for name in names) if warm else (),
            range=self._settings.range.to("deg/s"),
        )

    def start(self, first: int, count: int) -> None:
        """Begin: the first frame that is no start-up is sample 0; later starts keep that grid."""
        self._flow.start(first, count)

    def fetch(self) -> Block | None:
        """Wait for the next samples, about a second of them; None after the last."""
        return self._flow.fetch()

    def recover(self) -> int:
        """Connect anew; returns the position on the grid at which sampling can go on."""
        self._flow.intake.detach()
        before = self._device
        self.open()
        self._fresh = False
        found = self._device.serial_number
        if found is None:
            self._device = before
        elif before.serial_number not in (found, None):
            raise InstrumentIdentityError(
                f"{self._flow.who}: found serial number {found}, expected {before.serial_number}"
                " as before; connect that unit again"
            )
        return self._flow.position_to_go_on()

    def remarks(self) -> tuple[str, ...]:
        """What was lost, and what was wrong with the frames."""
        return tuple(f"{self.model.name}: {text}" for text in self._flow.remarks())

    def close(self) -> None:
        """Disconnect; the unit goes on sending."""
        with contextlib.suppress(InstrumentError):
            self._flow.intake.detach()

    def _ask(self) -> None:
        """Who it is and how it is set, now: units and their settings may be changed between two records."""
        if not self._settings.ask:
            return
        serial = self._answer(asking.SERIAL_NUMBER)
        set_up = self._answer(asking.CONFIGURATION)
        part = self._answer(asking.PART_NUMBER) if serial else None
        self._configuration = found = asking.configuration(set_up) if set_up else None
        self._device = Device(
            serial_number=asking.serial_number(serial) if serial else None,
            part_number=asking.part_number(part) if part else None,
            mode=found.mode if found else self._settings.mode,
            range_dps=found.range_dps if found else self._settings.range.to("deg/s"),
            bandwidth_hz=found.bandwidth_hz if found else None,
            sample_rate_hz=found.sample_rate_hz if found else None,
        )
        self._check_serial_number()

    def _answer(self, question: Question) -> bytes | None:
        self._flow.intake.send(question.command)
        data = b""
        for _ in range(_ANSWER_STEPS):
            data += self._flow.intake.raw(_ANSWER_STEP_S)
            found = asking.answer(question, data, self.model)
            if found is not None:
                return found
        return None

    def _check_serial_number(self) -> None:
        found, expected = self._device.serial_number, self._serial_number
        if None not in (found, expected) and found != str(expected).lstrip("0"):
            raise InstrumentIdentityError(
                f"{self._flow.who}: found serial number {found}, expected {expected};"
                " correct the station's serial_number or connect that unit"
            )

    def _check_configuration(self) -> None:
        """Hold how the unit is set, where it says so, against the station; raises `InstrumentError`."""
        found = self._configuration
        if found is None:
            return
        ranges = (found.range_dps, self._settings.range.to("deg/s"))
        pairs = (
            ("sample_rate", found.sample_rate_hz, self._settings.sample_rate.to("Hz"), " Hz"),
            ("mode", found.mode_as_set, self._settings.mode.value, ""),
            ("range", *ranges, " deg/s"),
            ("crlf", found.crlf, self._settings.crlf, ""),
        )
        wrong = [
            f"its {name} is {_told(is_set)}{unit}, the station says {_told(said)}{unit}"
            for name, is_set, said, unit in pairs
            if is_set is not None and is_set != said
        ]
        if wrong:
            raise InstrumentError(
                f"{self._flow.who}: {'; '.join(wrong)}; correct the station's settings or set the unit"
            )


def _told(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
