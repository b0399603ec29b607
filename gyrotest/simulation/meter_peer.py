"""A multimeter on the simulated bench: it reads one unit."""

from collections.abc import Mapping

from gyrotest.errors import StationError
from gyrotest.ports import Clock
from gyrotest.records.station import Station
from gyrotest.simulation.converter import Converter, MeterErrors
from gyrotest.simulation.dialogue import Dialogue, LineDialogue, Speaker
from gyrotest.simulation.faults import Faults
from gyrotest.simulation.figures import fault
from gyrotest.simulation.gyro import SteadyOutput
from gyrotest.simulation.meter import Meter
from gyrotest.simulation.meter_state import Interface
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.peer import Making
from gyrotest.simulation.personalities import MODELS, command_table
from gyrotest.simulation.settings import line_frequency_hz, meter_parameters
from gyrotest.simulation.signal import Signal
from gyrotest.simulation.streams import Normals, generator


class MeterPeer:
    """A meter with errors of its own, drawn within the station's accuracy for each unit."""

    def __init__(self, making: Making) -> None:
        self._making = making
        self._parameters = meter_parameters(making.station, making.name)
        self._errors: MeterErrors | None = None
        self.meter = new_meter(
            self._parameters.model,
            serial_number=making.serial_number,
            line_frequency_hz=line_frequency_hz(making.station),
            clock=making.clock,
            live=making.live,
            hurried=making.hurried,
        )
        self.speaker: Speaker = self.meter

    @staticmethod
    def check(station: Station, name: str) -> None:
        """Raise `StationError` with all complaints about this meter's figures."""
        meter_parameters(station, name)

    def dialogue(self, interface: Interface) -> Dialogue:
        """One connection's side of the conversation."""
        return LineDialogue(self.meter, interface)

    def begin(self, occasion: Occasion) -> None:
        """Draw the errors that this meter has when this unit is tested."""
        self._errors = self._drawn(occasion)

    def connect(self, occasion: Occasion, signals: Mapping[str, Signal], faults: Faults) -> None:
        """Put a unit's voltage on the input."""
        if len(signals) != 1:
            message = f"this meter reads one voltage; the slot gives {len(signals)}"
            raise StationError([fault(f"instruments.{self._making.name}", message)])
        making = self._making
        normals = Normals(generator(making.seed, "meter noise", making.name, *occasion.stream))
        signal = next(iter(signals.values()))
        self.meter.connect(Converter(signal, self._drawn(occasion), normals, faults))

    def _drawn(self, occasion: Occasion) -> MeterErrors:
        stream = generator(self._making.seed, "meter errors", occasion.serial_number, self._making.name)
        return MeterErrors(
            gain=self._parameters.gain_error * stream.uniform(-1.0, 1.0),
            offset_of_range=self._parameters.offset_error_of_range * stream.uniform(-1.0, 1.0),
            noise_v=self._parameters.noise_v,
        )

    def truth(self) -> Mapping[str, float]:
        """The errors drawn last; empty before the first unit."""
        if self._errors is None:
            return {}
        return {
            "meter_gain_error": self._errors.gain,
            "meter_offset_of_range": self._errors.offset_of_range,
            "meter_noise_v": self._errors.noise_v,
        }


def new_meter(
    model: str,
    *,
    serial_number: str,
    line_frequency_hz: float,
    clock: Clock,
    live: bool,
    hurried: bool = False,
) -> Meter:
    """A meter with nothing connected."""
    idle = Converter(
        SteadyOutput(0.0),
        MeterErrors(gain=0.0, offset_of_range=0.0, noise_v=0.0),
        Normals(generator(0, "nothing connected")),
        Faults((), start_s=0.0, duration_s=0.0),
    )
    return Meter(
        MODELS[model],
        command_table(model),
        serial_number=serial_number,
        line_frequency_hz=line_frequency_hz,
        clock=clock,
        converter=idle,
        live=live,
        hurried=hurried,
    )
