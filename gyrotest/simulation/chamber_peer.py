"""A temperature chamber on the simulated bench: the units stand in it."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import StationError
from gyrotest.records.station import Station
from gyrotest.simulation.chamber import ChamberFigures, SimulatedChamber, speaker_of
from gyrotest.simulation.dialogue import Dialogue, LineDialogue, Speaker
from gyrotest.simulation.figures import Figure, Figures, figures_of, given_figures
from gyrotest.simulation.meter_state import Interface
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.peer import Making
from gyrotest.simulation.scenarios import Misbehaviour
from gyrotest.simulation.streams import generator
from gyrotest.units import Dimension

_ERROR = "0.3 degC"


class ChamberPeer:
    """A chamber that is warmer than it shows, by an error drawn within its accuracy for each unit."""

    def __init__(self, making: Making) -> None:
        found = _figures(making.station, making.name)
        if found.faults:
            raise StationError(found.faults)
        self._making = making
        self._error_c = found.values["offset_error"]
        self._chamber = SimulatedChamber(
            clock=making.clock,
            figures=ChamberFigures(
                lag_s=found.values["lag"], stuck=making.scenario.has(Misbehaviour.CHAMBER_STUCK)
            ),
            identity=f"Example,TC-1,{making.serial_number},1.0",
        )
        self.speaker: Speaker = speaker_of(self._chamber, making.clock)

    @staticmethod
    def check(station: Station, name: str) -> None:
        """Raise `StationError` with all complaints about this chamber's figures."""
        if faults := _figures(station, name).faults:
            raise StationError(faults)

    def dialogue(self, interface: Interface) -> Dialogue:
        """One connection's side of the conversation."""
        return LineDialogue(self.speaker, interface)

    def temperature_degc(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """The true temperature at these times, (n,)."""
        return self._chamber.temperature_degc(times_s)

    def begin(self, occasion: Occasion) -> None:
        """Draw the error that this chamber has when this unit is tested."""
        stream = generator(self._making.seed, "chamber error", occasion.serial_number, self._making.name)
        self._chamber.error_c = self._error_c * stream.uniform(-1.0, 1.0)

    def truth(self) -> Mapping[str, float]:
        """How much warmer it is than it shows."""
        return {"chamber_offset_c": self._chamber.error_c}


def _figures(station: Station, name: str) -> Figures:
    accuracy = station.instruments[name].accuracy
    stated = accuracy.of_setting if accuracy is not None else None
    keys = {
        "lag": Figure(Dimension.TIME, "4 min", positive=True),
        "offset_error": Figure(Dimension.TEMPERATURE, _ERROR if stated is None else str(stated)),
    }
    given = given_figures(station, name)
    return figures_of(given, keys, f"simulation.instruments.{name}", also=("model",))
