"""A power supply on the simulated bench: its outputs feed the units."""

import functools
from collections.abc import Mapping

from gyrotest.errors import StationError
from gyrotest.records.station import Station
from gyrotest.simulation.dialogue import Dialogue, LineDialogue, Speaker
from gyrotest.simulation.figures import Figure, Figures, figures_of, given_figures
from gyrotest.simulation.meter_state import Interface
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.peer import Making
from gyrotest.simulation.scenarios import Misbehaviour, Scenario
from gyrotest.simulation.streams import generator
from gyrotest.simulation.supply import OutputFault, OutputFigures, SimulatedOutput, SimulatedSupply
from gyrotest.simulation.supply_commands import speaker_of
from gyrotest.units import Dimension

_FIGURES = {
    "load_current": Figure(Dimension.CURRENT, "40 mA"),
    "rise_time": Figure(Dimension.TIME, "20 ms", positive=True),
    "fall_time": Figure(Dimension.TIME, "0.4 s", positive=True),
    "gain_error": Figure(Dimension.NUMBER, "0.05 %"),
}


class SupplyPeer:
    """A supply whose outputs have errors of their own, the same in all runs of a seed."""

    def __init__(self, making: Making) -> None:
        found = _figures(making.station, making.name)
        if found.faults:
            raise StationError(found.faults)
        outputs = [
            _output(making, found.values, number)
            for number in range(1, _outputs(making.station, making.name) + 1)
        ]
        self._supply = SimulatedSupply(
            outputs=outputs,
            clock=making.clock,
            identity=f"Example,PS-{len(outputs)},{making.serial_number},1.0",
        )
        self.speaker: Speaker = speaker_of(self._supply, making.clock)

    @staticmethod
    def check(station: Station, name: str) -> None:
        """Raise `StationError` with all complaints about this supply's figures."""
        if faults := _figures(station, name).faults:
            raise StationError(faults)

    def dialogue(self, interface: Interface) -> Dialogue:
        """One connection's side of the conversation."""
        return LineDialogue(self.speaker, interface)

    def output(self, number: int) -> SimulatedOutput:
        """One of its outputs, counted from 1."""
        return self._supply.output(number)

    def begin(self, occasion: Occasion) -> None:
        """Nothing: a supply does not depend on the unit."""

    def truth(self) -> Mapping[str, float]:
        """Nothing that a measurement of the gyro could be held against."""
        return {}


def _figures(station: Station, name: str) -> Figures:
    given = given_figures(station, name)
    return figures_of(given, _FIGURES, f"simulation.instruments.{name}", also=("model",))


def _outputs(station: Station, name: str) -> int:
    """As many as the driver's settings say, or as the slots use."""
    used = [slot.supply_output for slot in station.slots.values() if slot.supply == name]
    stated = station.instruments[name].settings.get("outputs", 1)
    return max(1, stated if isinstance(stated, int) else 1, *used)


def _output(making: Making, values: Mapping[str, float], number: int) -> OutputFigures:
    draw = functools.partial(
        generator(making.seed, "supply errors", making.name, number).uniform, -1.0, 1.0
    )
    return OutputFigures(
        load_a=values["load_current"],
        rise_s=values["rise_time"],
        fall_s=values["fall_time"],
        gain=values["gain_error"] * draw(),
        reading_gain=values["gain_error"] * draw(),
        fault=_fault(making.scenario),
    )


def _fault(scenario: Scenario) -> OutputFault | None:
    if scenario.has(Misbehaviour.SUPPLY_NO_VOLTAGE):
        return OutputFault.NO_VOLTAGE
    return OutputFault.SHORTED if scenario.has(Misbehaviour.SUPPLY_CURRENT_LIMIT) else None
