"""A simulated rate table on the bench: made from the station's entry, behind its driver's protocol."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import StationError
from gyrotest.records.station import Instrument, Station
from gyrotest.simulation.acutrol import AcutrolController, AcutrolDialogue, AcutrolInterface
from gyrotest.simulation.aerosmith import AerosmithController, AerosmithDialogue
from gyrotest.simulation.dialogue import Dialogue
from gyrotest.simulation.figures import Figure, fault, figures_of, given_figures
from gyrotest.simulation.meter_state import Interface
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.peer import Making
from gyrotest.simulation.scenarios import Misbehaviour, Scenario
from gyrotest.simulation.table import SimulatedTable, TableFaults, TableParameters
from gyrotest.units import Dimension

# Where the station states no accuracy: a good single-axis table.
_FIGURES = {
    "gain_error": Figure(Dimension.NUMBER, "50 ppm"),
    "setting_error": Figure(Dimension.RATE, "0.0002 deg/s"),
    "ripple": Figure(Dimension.NUMBER, "100 ppm"),
    "settling_time_constant": Figure(Dimension.TIME, "50 ms", positive=True),
    "max_rate": Figure(Dimension.RATE, "1000 deg/s", positive=True),
    "max_acceleration": Figure(Dimension.RATE_RAMP, "1000 deg/s/s", positive=True),
}
_SHARE_REACHED = 0.6


class TablePeer:
    """The table and its controller."""

    def __init__(self, making: Making) -> None:
        self._instrument = making.instrument
        self._scenario = making.scenario
        self._clock = making.clock
        self.table = SimulatedTable(
            making.name,
            table_parameters(making.station, making.name),
            seed=making.seed,
            clock=making.clock,
        )
        self._acutrol = AcutrolController(self.table, serial_number=making.serial_number)
        self._aerosmith = AerosmithController(self.table, serial_number=making.serial_number)

    @staticmethod
    def check(station: Station, name: str) -> None:
        """Raise `StationError` with all complaints about the table's figures."""
        table_parameters(station, name)

    def begin(self, occasion: Occasion) -> None:
        """Draw the table's errors for the next record."""
        faults = table_faults(
            self._scenario, start_s=self._clock.now_s(), duration_s=occasion.duration_s
        )
        self.table.begin(occasion, faults)

    def truth(self) -> Mapping[str, float]:
        """The table's drawn errors."""
        return self.table.truth()

    def dialogue(self, interface: Interface) -> Dialogue:  # noqa: ARG002 - the same over every one
        """One connection's side of the conversation."""
        now_s = self._clock.now_s
        if "aerosmith" in self._instrument.driver.lower():
            return AerosmithDialogue(self._aerosmith, now_s)
        return AcutrolDialogue(self._acutrol, now_s, acutrol_interface(self._instrument))

    def angle_deg(self, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """The true angle at these times."""
        return self.table.angle_deg(times_s)


def acutrol_interface(instrument: Instrument) -> AcutrolInterface:
    """The interface as the station sets its driver; what is no interface the driver's settings refuse."""
    given = str(instrument.settings.get("dialect", ""))
    known = {one.value for one in AcutrolInterface}
    return AcutrolInterface(given) if given in known else AcutrolInterface.PLAIN


def table_parameters(station: Station, name: str) -> TableParameters:
    """A table's figures from `simulation.instruments` and the station's accuracy.

    Raises `StationError` with all complaints at once.
    """
    instrument = station.instruments[name]
    given = given_figures(station, name)
    found = figures_of(_stated_accuracy(instrument) | given, _FIGURES, f"simulation.instruments.{name}")
    faults = [*found.faults]
    if instrument.motion is None:
        message = (
            "a rate table needs it: write e.g. {max_rate: 200 deg/s, max_acceleration: 100 deg/s/s}"
        )
        faults.append(fault(f"instruments.{name}.motion", message))
    if faults:
        raise StationError(faults)
    values = found.values
    return TableParameters(
        gain_error=values["gain_error"],
        setting_error_dps=values["setting_error"],
        ripple=values["ripple"],
        settling_time_constant_s=values["settling_time_constant"],
        max_rate_dps=values["max_rate"],
        max_acceleration_dps2=values["max_acceleration"],
    )


def _stated_accuracy(instrument: Instrument) -> dict[str, str]:
    accuracy = instrument.accuracy
    if accuracy is None:
        return {}
    stated = {"gain_error": str(accuracy.of_reading)}
    if accuracy.of_setting is not None:
        stated["setting_error"] = str(accuracy.of_setting)
    return stated


def table_faults(scenario: Scenario, *, start_s: float, duration_s: float) -> TableFaults:
    """What a scenario does to the table during a record (of no duration: nothing that has a time)."""
    opens_s = None
    for strike in scenario.strikes:
        if strike.misbehaviour is Misbehaviour.TABLE_INTERLOCK and duration_s > 0.0:
            opens_s = start_s + strike.at * duration_s
    return TableFaults(
        reaches=_SHARE_REACHED if scenario.has(Misbehaviour.TABLE_SLOW) else 1.0,
        interlock_opens_s=opens_s,
        refuses=scenario.has(Misbehaviour.TABLE_REFUSES),
    )
