"""A synchronous acquisition system on the simulated bench: a server of the block protocol."""

import threading
from collections.abc import Mapping, Sequence
from typing import Any

from gyrotest.records.station import Slot, Station
from gyrotest.simulation.daq_acquisition import Acquisition, Column
from gyrotest.simulation.daq_conversation import Conversation, Setup
from gyrotest.simulation.daq_converter import ChannelConverter, Converters, Wire
from gyrotest.simulation.daq_faults import DaqFaults
from gyrotest.simulation.daq_seat import Reader, Seat
from gyrotest.simulation.daq_settings import daq_parameters, output_channels
from gyrotest.simulation.grating import draw_angle_error, draw_grating
from gyrotest.simulation.housed import Housed
from gyrotest.simulation.motion import Carried, Motion, Resting
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.outlet import Outlet
from gyrotest.simulation.peer import Making
from gyrotest.simulation.scenarios import Misbehaviour
from gyrotest.simulation.streams import generator
from gyrotest.simulation.vibration import Shaken, vibration_table

# How soon after START an external trigger comes.
_TRIGGER_S = (0.05, 0.5)


class DaqPeer:
    """The system: its converters, the slots in front of it, and who is connected."""

    def __init__(self, making: Making) -> None:
        self._making = making
        self._parameters = daq_parameters(making.station, making.name)
        self._converters = Converters(name=making.name, parameters=self._parameters, seed=making.seed)
        self._seats: dict[str, Seat] = {}
        self._faults: DaqFaults | None = None
        self._starts = 0
        self._conversation = Conversation(self, hurried=making.hurried)
        # A record may begin while another thread sends.
        self._lock = threading.Lock()

    @staticmethod
    def check(station: Station, name: str) -> None:
        """Raise `StationError` with all complaints about this system's figures."""
        daq_parameters(station, name)
        for slot in station.slots.values():
            if slot.source == name and slot.vibration is not None:
                vibration_table(station, slot.vibration)

    def begin(self, occasion: Occasion) -> None:
        """Nothing: what is drawn depends on the slot."""

    def truth(self) -> Mapping[str, float]:
        """The drawn errors of each channel in use, and of the encoders."""
        found: dict[str, float] = {}
        # What several slots read is the first one's.
        for seat in reversed(tuple(self._seats.values())):
            for channel, converter in seat.converters.items():
                found[f"{channel}.gain_error"] = converter.wire.gain
                found[f"{channel}.skew_error_s"] = converter.wire.skew_error_s
            if seat.reader is not None:
                found |= seat.reader.truth()
        return found

    def seat(self, slot: Slot, housed: Housed) -> None:
        """Have this unit in a slot from now on, for its next record."""
        with self._lock:
            scenario = self._making.scenario
            self._faults = DaqFaults(scenario, housed)
            self._seats[output_channels(slot, housed.gyro.axes)[0]] = Seat(
                slot,
                housed,
                moved=lambda: self._moved(slot, housed),
                reader=self._reader(slot, housed.occasion),
                converters=self._wired(slot, housed),
                faults=self._faults,
                dead=scenario.dead_output,
                seed=self._making.seed,
            )

    def transmit(self, now_s: float, outlet: Outlet) -> None:
        """Answer what was asked, and send all that is due by now."""
        with self._lock:
            if self._faults is not None and self._faults.due(Misbehaviour.LOST_CONNECTION, now_s):
                outlet.hang_up()
                self._conversation.forget()
            self._conversation.transmit(now_s, outlet)

    def identity(self) -> Mapping[str, str]:
        """Who it is."""
        return {
            "manufacturer": "gyrotest",
            "model": "simulated DAQ",
            "serial_number": self._making.serial_number,
            "firmware": "1",
        }

    def channels(self) -> Sequence[Mapping[str, Any]]:
        """All its channels."""
        return [
            {
                "name": name,
                "unit": self._converters.unit(name),
                "scale": self._converters.scale(name),
                "skew_s": self._parameters.skew_of(name),
            }
            for name in self._parameters.channels
        ]

    def configured(self, setup: Setup) -> Mapping[str, Any]:
        """Its low-pass, and the first channel's full scale."""
        return {
            "filter_hz": self._parameters.filter_hz,
            "full_scale": self._converters.full_scale(setup.channels[0]),
        }

    def acquisition(self, setup: Setup, samples: int, now_s: float) -> Acquisition:
        """Begin one, now or when the trigger comes."""
        self._starts += 1
        making = self._making
        trigger = generator(making.seed, "daq trigger", making.name, self._starts)
        return Acquisition(
            [self._column(channel) for channel in setup.channels],
            origin_s=now_s + (float(trigger.uniform(*_TRIGGER_S)) if setup.external else 0.0),
            interval_s=1.0 / setup.rate_hz / (1.0 + self._parameters.clock_error),
            samples=samples,
            filter_hz=self._parameters.filter_hz,
            faults=self._faults,
        )

    def _column(self, channel: str) -> Column:
        """A channel, and the first slot that gives it something."""
        for seat in self._seats.values():
            if channel in seat.converters:
                return Column(channel=channel, seat=seat, converter=seat.converters[channel])
        noise = Wire(noise=self._parameters.noise_v)
        return Column(channel=channel, seat=None, converter=self._converters.make(channel, noise))

    def _wired(self, slot: Slot, housed: Housed) -> dict[str, ChannelConverter]:
        """The converters of a slot's channels, as they are when this unit is tested."""
        occasion, encoder = housed.occasion, slot.encoder
        outputs = output_channels(slot, housed.gyro.axes)
        waves = (encoder.sine, encoder.cosine) if encoder is not None else ()
        read = (*waves, encoder.angle) if encoder is not None else ()
        channels = (*outputs, *(one for one in read if one is not None), *slot.auxiliary.values())
        return {
            channel: self._converters.make(
                channel,
                self._converters.draw(
                    channel,
                    occasion.serial_number,
                    noise_v=self._parameters.grating.noise_v if channel in waves else 0.0,
                    # Times between channels are meant: those of the outputs are what the others' are held against.
                    skewed=channel not in outputs,
                ),
                *occasion.stream,
            )
            for channel in channels
        }

    def _reader(self, slot: Slot, occasion: Occasion) -> Reader | None:
        """A slot's encoder with what is drawn of it: its error for a unit, its signals for each record."""
        encoder, making = slot.encoder, self._making
        if encoder is None:
            return None
        half_width_deg = encoder.accuracy.to("deg") if encoder.accuracy is not None else 0.0
        name = encoder.angle or encoder.sine or ""
        error = generator(making.seed, "encoder error", making.name, name, occasion.serial_number)
        signals = generator(making.seed, "grating", making.name, name, *occasion.stream)
        return Reader(
            encoder=encoder,
            error=draw_angle_error(half_width_deg, error),
            grating=(
                None
                if encoder.lines is None
                else draw_grating(encoder.lines, self._parameters.grating, signals)
            ),
        )

    def _moved(self, slot: Slot, housed: Housed) -> Motion:
        """What moves a slot, of what is in use by now."""
        drive, table = housed.surroundings.drive, housed.surroundings.table
        if drive is not None and slot.vibration is not None:
            return Shaken(drive, vibration_table(self._making.station, slot.vibration))
        return Resting() if table is None else Carried(table)
