"""The simulated chamber: its lag, its history, its own error, its commands."""

import math

import numpy as np
import pytest

from gyrotest.simulation.chamber import ChamberFigures, SimulatedChamber, speaker_of
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.meter_state import Interface


class Desk:
    """A chamber and its clock."""

    def __init__(self, figures: ChamberFigures | None = None, *, error_c: float = 0.0) -> None:
        self.clock = VirtualClock(1000.0)
        self.chamber = SimulatedChamber(clock=self.clock, figures=figures, error_c=error_c)
        self._speaker = speaker_of(self.chamber, self.clock)

    def ask(self, message: str) -> str | None:
        reply = self._speaker.execute(message, Interface.SOCKET)
        return None if reply is None else b"".join(part for _, part in reply.parts).decode().strip()


def test_the_identity_says_that_it_is_simulated() -> None:
    assert (Desk().ask("*IDN?") or "").split(",")[2].startswith("SIM")


def test_a_first_order_lag_leads_to_the_setting_and_past_times_stay_as_they_were() -> None:
    desk = Desk(ChamberFigures(lag_s=100.0))
    desk.ask("SOUR:TEMP 63;:OUTP ON")
    times_s = np.array([900.0, 1000.0, 1100.0, 1200.0])
    wanted = [23.0, 23.0, 63.0 - 40.0 * math.exp(-1), 63.0 - 40.0 * math.exp(-2)]
    assert desk.chamber.temperature_degc(times_s) == pytest.approx(wanted, abs=2e-3)
    before = desk.chamber.temperature_degc(times_s)
    desk.clock.sleep_until(1200.0)
    desk.ask("SOUR:TEMP 0")
    assert desk.chamber.temperature_degc(times_s).tolist() == before.tolist()
    assert desk.chamber.temperature_degc(np.array([5000.0])) == pytest.approx([0.0], abs=1e-6)


def test_what_it_shows_lacks_its_own_error() -> None:
    desk = Desk(error_c=0.3)
    assert desk.ask("MEAS:TEMP?") == "23.00"
    assert desk.chamber.temperature_degc(np.array([1000.0])).tolist() == [23.3]


def test_at_rest_it_drifts_back_to_the_room() -> None:
    desk = Desk(ChamberFigures(lag_s=10.0, idle_lag_s=100.0))
    desk.ask("SOUR:TEMP 63;:OUTP ON")
    desk.clock.advance(500.0)
    desk.ask("OUTP OFF")
    times_s = np.array([desk.clock.now_s() + 100.0])
    assert desk.chamber.temperature_degc(times_s) == pytest.approx([23.0 + 40.0 / math.e], abs=0.01)
    assert desk.ask("OUTP?;:SOUR:TEMP?") == "0;63.00"


def test_a_stuck_chamber_stays_where_it_is() -> None:
    desk = Desk(ChamberFigures(stuck=True))
    desk.ask("SOUR:TEMP 63;:OUTP ON")
    desk.clock.advance(1e4)
    assert desk.ask("MEAS:TEMP?") == "23.00"


@pytest.mark.parametrize(
    ("message", "code"), [("SOUR:TEMP 999", -222), ("TEMP", -109), ("HEAT 1", -113)]
)
def test_what_is_wrong_goes_into_the_error_queue(message: str, code: int) -> None:
    desk = Desk()
    desk.ask(message)
    assert (desk.ask("SYST:ERR?") or "").startswith(f"{code},")
