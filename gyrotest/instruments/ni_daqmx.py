"""NI data-acquisition devices, through NI's own driver NI-DAQmx and its Python package.

Written and tested against the package's documented interface; not tried on a device.
"""

import contextlib
import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import InstrumentError, InstrumentIdentityError, InstrumentTimeoutError
from gyrotest.instruments.daqmx.library import Library, OverrunError
from gyrotest.instruments.daqmx.task import InputTask
from gyrotest.instruments.ni_daqmx_settings import NiDaqmxSettings
from gyrotest.instruments.pacing import Grid
from gyrotest.instruments.streaming.flow import many
from gyrotest.instruments.synchronous.agreement import filter_hz, noise_of, refuse_other_rate
from gyrotest.instruments.synchronous.choice import Choice, choose
from gyrotest.instruments.synchronous.clipping import Clipping
from gyrotest.instruments.synchronous.settings import Trigger, seconds
from gyrotest.ports import Clock
from gyrotest.records.bench import DaqChannel
from gyrotest.records.recording import Block, Identity, Sampling
from gyrotest.records.station import Accuracy

_IO_TIMEOUT_S = 5.0
_READ_S = 1.0
# An external trigger is looked for in slices, so that Ctrl-C is seen in between.
_TRIGGER_SLICE_S = 0.5
_FIRST_S = 0.1


@dataclass(slots=True, kw_only=True)
class _Acquiring:
    """What is acquired since `configure`, and what went wrong in it."""

    choice: Choice
    task: InputTask
    grid: Grid
    clipping: Clipping
    position: int = 0
    end: int = 0
    triggered: bool = False
    running: bool = False
    overruns: int = 0
    recovered: int = 0


class NiDaqmx:
    """Samples as they come, in blocks of about a second.

    After an overrun the device has stopped: the acquisition goes on at the next position of the same grid,
    as the computer's clock tells it, and does not wait for another trigger then.
    """

    settings: ClassVar[type] = NiDaqmxSettings

    def __init__(
        self,
        resource: str,
        settings: NiDaqmxSettings,
        *,
        clock: Clock,
        line_frequency_hz: float | None = None,  # noqa: ARG002 - the constructor is the same for all sources
        accuracy: Accuracy | None = None,
        io_timeout_s: float | None = None,
        serial_number: str | None = None,
    ) -> None:
        self._resource, self._settings, self._who = resource, settings, resource
        self._clock, self._accuracy, self._serial_number = clock, accuracy, serial_number
        self._io_timeout_s = _IO_TIMEOUT_S if io_timeout_s is None else io_timeout_s
        self._library: Library | None = None
        self._simultaneous = True
        self._there = tuple(DaqChannel(name=name, unit="V") for name in settings.terminals)
        self._outputs: tuple[str, ...] = ()
        self._auxiliary: tuple[str, ...] = ()
        self._acquiring: _Acquiring | None = None

    def open(self) -> Identity:
        """Load the library, and ask the device who it is and which inputs it has."""
        self._library = library = Library(self._resource)
        with library.told(self._resource, "asking who is there"):
            device: Any = library.system.Device(self._resource)
            identity = Identity(
                manufacturer="National Instruments",
                model=str(device.product_type),
                serial_number=f"{'SIM' if device.is_simulated else ''}{int(device.serial_num):08X}",
            )
            inputs = {str(one.name).rpartition("/")[2] for one in device.ai_physical_chans}
            self._simultaneous = bool(device.ai_simultaneous_sampling_supported)
        self._who = f"{self._resource} ({identity.model})"
        self._check_identity(identity)
        for name, terminal in self._settings.terminals.items():
            if terminal not in inputs:
                raise InstrumentError(
                    f"{self._who}: has no input '{terminal}', which terminals names for '{name}'; it has"
                    f" {', '.join(sorted(inputs, key=lambda one: (len(one), one))) or 'none'}"
                )
        return identity

    def channels(self) -> tuple[DaqChannel, ...]:
        """Every channel that the station names; their skews as they were configured last."""
        return self._there

    def select(self, outputs: tuple[str, ...], auxiliary: tuple[str, ...]) -> None:
        """Say which channels are gyros' outputs, and which are recorded beside; none named: all."""
        self._outputs, self._auxiliary = outputs, auxiliary

    def configure(self, interval_s: float) -> Sampling:
        """Set the inputs and the clock up, and read back what is had."""
        self._free()
        settings = self._settings
        choice = choose(self._who, self._there, self._outputs, self._auxiliary)
        task = self._made(choice, 1.0 / interval_s, settings.trigger)
        self._acquiring = _Acquiring(
            choice=choice, task=task, grid=Grid(self._clock, interval_s), clipping=Clipping(choice)
        )
        refuse_other_rate(self._who, asked_hz=1.0 / interval_s, had_hz=task.rate_hz)
        choice = self._skewed(choice, task)
        self._there = tuple(
            next((one for one in choice.channels if one.name == known.name), known)
            for known in self._there
        )
        uncertainty = settings.skew_uncertainty
        return choice.sampling(
            interval_s,
            skew_s=seconds(settings.skew),
            skew_uncertainty_s=None if uncertainty is None else uncertainty.to("s"),
            filter_hz=filter_hz(self._who, said_hz=None, stated=settings.filter),
            full_scale=float(task.full_scales_v[0]),
            noise=noise_of(self._accuracy, choice.units[0]),
        )

    def start(self, first: int, count: int) -> None:
        """Begin; sample 0 is the first after the trigger, after an interruption the grid stays."""
        now = self._ready()
        self._halt(now)
        trigger = self._settings.trigger if first == 0 else Trigger.IMMEDIATE
        if trigger is not now.task.trigger:
            now.task.close()
            now.task = self._made(now.choice, 1.0 / now.grid.interval_s, trigger)
        if first:
            self._clock.sleep_until(now.grid.deadline_s(first))
        now.task.start()
        now.running = True
        now.position, now.end = first, count
        now.triggered = trigger is Trigger.IMMEDIATE
        if first == 0:
            now.grid.begin(0)

    def fetch(self) -> Block | None:
        """Wait for the next samples, about a second of them; None after the last."""
        now = self._ready()
        if now.position >= now.end:
            self._halt(now)
            return None
        try:
            values = self._next(now) if now.triggered else self._first(now)
        except OverrunError:
            now.overruns += 1
            raise
        position = np.arange(now.position, now.position + len(values), dtype=np.float64)
        block = Block(
            first=now.position,
            time_s=position * now.grid.interval_s,
            values=values,
            flags=now.clipping.flags(np.abs(values) >= now.task.full_scales_v),
        )
        now.position += len(values)
        return block

    def recover(self) -> int:
        """Set it up anew; returns the position on the grid at which sampling can go on."""
        now = self._ready()
        now.task.close()
        now.running = False
        self.open()
        trigger = Trigger.IMMEDIATE if now.triggered else self._settings.trigger
        now.task = self._made(now.choice, 1.0 / now.grid.interval_s, trigger)
        if not now.triggered:
            return 0
        now.recovered += 1
        return now.grid.position_to_go_on()

    def remarks(self) -> tuple[str, ...]:
        """What was lost and what was clipped since `configure`."""
        now = self._acquiring
        if now is None:
            return ()
        told = now.clipping.remarks()
        if now.overruns:
            told.append(f"{many(now.overruns, 'overrun')}")
        if now.recovered:
            told.append(
                f"started anew {many(now.recovered, 'time')}; what came after has its place by the computer's"
                " clock"
            )
        return tuple(f"{self._who}: {one}" for one in told)

    def close(self) -> None:
        """Stop it and free the device; never raises."""
        with contextlib.suppress(InstrumentError):
            self._free()

    def _made(self, choice: Choice, rate_hz: float, trigger: Trigger) -> InputTask:
        if self._library is None:
            raise InstrumentError(f"{self._who}: not open; open the instrument first")
        return InputTask(
            self._library,
            self._who,
            self._resource,
            channels=choice.names,
            settings=self._settings,
            rate_hz=rate_hz,
            trigger=trigger,
        )

    def _ready(self) -> _Acquiring:
        if self._acquiring is None:
            raise InstrumentError(f"{self._who}: not configured; configure the instrument first")
        return self._acquiring

    def _halt(self, now: _Acquiring) -> None:
        if now.running:
            now.running = False
            now.task.stop()

    def _free(self) -> None:
        if self._acquiring is not None:
            self._acquiring.task.close()
            self._acquiring = None

    def _next(self, now: _Acquiring) -> NDArray[np.float64]:
        most = max(1, round(_READ_S / now.grid.interval_s))
        end = min(now.position + most, now.end)
        self._clock.sleep_until(now.grid.deadline_s(end))
        values = now.task.read(end - now.position, self._io_timeout_s)
        if not len(values):
            raise InstrumentTimeoutError(
                f"{self._who}: no sample has arrived for {self._io_timeout_s:g} s; is its clock running, and"
                " the device connected?"
            )
        return values

    def _first(self, now: _Acquiring) -> NDArray[np.float64]:
        """The first samples after the trigger."""
        timeout_s, interval_s = self._settings.trigger_timeout.to("s"), now.grid.interval_s
        wanted = min(now.end, max(1, round(_FIRST_S / interval_s)))
        for _ in range(math.ceil(timeout_s / _TRIGGER_SLICE_S)):
            values = now.task.read(wanted, _TRIGGER_SLICE_S + wanted * interval_s)
            if len(values):
                now.triggered = True
                now.grid.start_s = self._clock.now_s() - len(values) * interval_s
                return values
        raise InstrumentTimeoutError(
            f"{self._who}: no trigger at {self._settings.trigger_terminal} within {timeout_s:g} s; is its cable"
            " plugged in, and does what gives it run? (trigger, trigger_terminal, trigger_timeout)"
        )

    def _skewed(self, choice: Choice, task: InputTask) -> Choice:
        """The channels with their skews: one converter takes them in turn, several at once."""
        stated = self._settings.skew
        if self._simultaneous or all(name in stated for name in choice.names):
            return choice
        apart_s = task.convert_interval_s() if len(choice.channels) > 1 else 0.0
        return replace(
            choice,
            channels=tuple(
                replace(one, skew_s=place * apart_s) for place, one in enumerate(choice.channels)
            ),
        )

    def _check_identity(self, identity: Identity) -> None:
        found, expected = identity.serial_number, self._serial_number
        if expected is not None and found != expected.upper():
            raise InstrumentIdentityError(
                f"{self._who}: found serial number {found}, expected {expected};"
                " correct the station's serial_number or connect that device"
            )
        # From now on only this very device will do.
        self._serial_number = found
