"""A multimeter scanner on the simulated bench: it reads several units and what is beside them."""

from collections.abc import Mapping

from gyrotest.errors import StationError
from gyrotest.records.station import Station
from gyrotest.simulation.converter import Converter, MeterErrors
from gyrotest.simulation.dialogue import Dialogue, LineDialogue, Speaker
from gyrotest.simulation.faults import Faults
from gyrotest.simulation.figures import Figure, Figures, fault, figures_of, given_figures
from gyrotest.simulation.meter_state import Interface
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.peer import Making
from gyrotest.simulation.scanner import SimulatedScanner
from gyrotest.simulation.scanner_commands import speaker_of
from gyrotest.simulation.settings import line_frequency_hz, stated_meter_accuracy
from gyrotest.simulation.signal import Signal
from gyrotest.simulation.streams import Normals, generator
from gyrotest.units import Dimension

_MODELS = {
    "34970A": "HEWLETT-PACKARD,34970A,{serial},13-2-2",
    "34972A": "Agilent Technologies,34972A,{serial},1.17-1.12-02-02",
    "DAQ970A": "Keysight Technologies,DAQ970A,{serial},A.03.01-01.00-03.00-0001-01",
    "DAQ973A": "Keysight Technologies,DAQ973A,{serial},A.03.01-01.00-03.00-0001-01",
}
_FIGURES = {
    "noise": Figure(Dimension.VOLTAGE, "6e-6 V"),
    "gain_error": Figure(Dimension.NUMBER, "0.0035 %"),
    "offset_error": Figure(Dimension.NUMBER, "0.0005 %"),
}


class ScannerPeer:
    """A scanner whose one converter reads all channels: its errors are the same for all of them."""

    def __init__(self, making: Making) -> None:
        found = _figures(making.station, making.name)
        if found.faults:
            raise StationError(found.faults)
        self._making = making
        self._figures = found.values
        self._errors: MeterErrors | None = None
        model = _model(making.station, making.name)
        self._scanner = SimulatedScanner(
            clock=making.clock,
            line_frequency_hz=line_frequency_hz(making.station),
            identity=_MODELS[model].format(serial=making.serial_number),
            hurried=making.hurried,
        )
        self.speaker: Speaker = speaker_of(self._scanner, making.clock, newer=model.startswith("DAQ"))

    @staticmethod
    def check(station: Station, name: str) -> None:
        """Raise `StationError` with all complaints about this scanner's figures."""
        if faults := _figures(station, name).faults:
            raise StationError(faults)

    def dialogue(self, interface: Interface) -> Dialogue:
        """One connection's side of the conversation."""
        return LineDialogue(self.speaker, interface)

    def begin(self, occasion: Occasion) -> None:
        """Draw the errors that this scanner has when this unit is tested."""
        self._errors = self._drawn(occasion)

    def connect(self, occasion: Occasion, signals: Mapping[str, Signal], faults: Faults) -> None:
        """Put a slot's voltages on its channels; the other slots' stay where they are."""
        making, errors = self._making, self._drawn(occasion)
        converters = {}
        for name, signal in signals.items():
            stream = generator(making.seed, "scanner noise", making.name, *occasion.stream, name)
            converters[self._number(name)] = Converter(signal, errors, Normals(stream), faults)
        self._scanner.connect(converters, faults)

    def truth(self) -> Mapping[str, float]:
        """The errors drawn last; empty before the first unit."""
        if self._errors is None:
            return {}
        return {
            "meter_gain_error": self._errors.gain,
            "meter_offset_of_range": self._errors.offset_of_range,
            "meter_noise_v": self._errors.noise_v,
        }

    def _drawn(self, occasion: Occasion) -> MeterErrors:
        stream = generator(self._making.seed, "meter errors", occasion.serial_number, self._making.name)
        return MeterErrors(
            gain=self._figures["gain_error"] * stream.uniform(-1.0, 1.0),
            offset_of_range=self._figures["offset_error"] * stream.uniform(-1.0, 1.0),
            noise_v=self._figures["noise"],
        )

    def _number(self, name: str) -> int:
        if not name.isdecimal():
            message = (
                f"it reads channels by number, and a slot names '{name}'; write e.g. channel: '101'"
            )
            raise StationError([fault(f"instruments.{self._making.name}", message)])
        return int(name)


def _model(station: Station, name: str) -> str:
    return str(given_figures(station, name).get("model", "34970A"))


def _figures(station: Station, name: str) -> Figures:
    key = f"simulation.instruments.{name}"
    given = stated_meter_accuracy(station.instruments[name]) | given_figures(station, name)
    found = figures_of(given, _FIGURES, key, also=("model",))
    model = _model(station, name)
    if model not in _MODELS:
        found.faults.append(
            fault(f"{key}.model", f"'{model}' cannot be simulated; write {' or '.join(_MODELS)}")
        )
    return found
