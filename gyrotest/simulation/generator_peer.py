"""A waveform generator on the simulated bench: it drives the vibration table's amplifier."""

import math
import re
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gyrotest.errors import StationError
from gyrotest.records.station import Instrument, Station
from gyrotest.simulation.dialogue import Dialogue, LineDialogue, Parts, Speaker
from gyrotest.simulation.figures import Figure, Figures, figures_of, given_figures
from gyrotest.simulation.generator import SimulatedGenerator, SimulatedWaveform
from gyrotest.simulation.generator_commands import speaker_of
from gyrotest.simulation.meter_state import HangUp, Interface
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.peer import Making
from gyrotest.simulation.scenarios import Misbehaviour
from gyrotest.simulation.streams import generator
from gyrotest.simulation.vibration import TABLE_FIGURES
from gyrotest.units import Dimension

_FIGURES = {"gain_error": Figure(Dimension.NUMBER, "1 %")}
_OHM = re.compile(r"(\d+(?:\.\d+)?) *(?:ohm|Ω)", re.IGNORECASE)


class GeneratorPeer:
    """A generator whose levels have an error of their own, the same in all runs of a seed."""

    def __init__(self, making: Making) -> None:
        found = _figures(making.station, making.name)
        if found.faults:
            raise StationError(found.faults)
        self._making = making
        self._driving = 2 if making.instrument.settings.get("output") == 2 else 1
        error = generator(making.seed, "exciter errors", making.name).uniform(-1.0, 1.0)
        self.generator = SimulatedGenerator(
            {
                number: SimulatedWaveform(
                    load_ohm=_load_ohm(making.instrument),
                    gain=found.values["gain_error"] * error,
                )
                for number in (1, 2)
            },
            identity=f"Agilent Technologies,33522B,{making.serial_number},4.00-1.19-2.00-58-00",
        )
        self._lost_s = math.inf
        self.speaker: Speaker = speaker_of(self.generator, making.clock)

    @staticmethod
    def check(station: Station, name: str) -> None:
        """Raise `StationError` with all complaints about this generator's figures."""
        if faults := _figures(station, name).faults:
            raise StationError(faults)

    def dialogue(self, interface: Interface) -> Dialogue:
        """One connection's side of the conversation."""
        return _Dialogue(self, LineDialogue(self.speaker, interface))

    @property
    def lost(self) -> bool:
        """Whether it answers no more."""
        return self._making.clock.now_s() >= self._lost_s

    def begin(self, occasion: Occasion) -> None:
        """Restart the noise for the next record, and see what goes wrong in it, and when."""
        making = self._making
        for number, output in self.generator.outputs.items():
            output.begin(making.seed, (*occasion.stream, making.name, number))
            output.off_from_s = self._strikes_s(Misbehaviour.EXCITER_SILENT, occasion)
        self._lost_s = self._strikes_s(Misbehaviour.EXCITER_LOST, occasion)

    def drive_v(
        self, first: int, count: int, *, origin_s: float, interval_s: float
    ) -> NDArray[np.float64]:
        """The voltage at the amplifier at `origin_s + (first … first + count - 1) · interval_s`, (count,), V."""
        driving = self.generator.outputs[self._driving]
        return driving.drive_v(first, count, origin_s=origin_s, interval_s=interval_s)

    def truth(self) -> Mapping[str, float]:
        """Nothing that a measurement of the gyro could be held against: the table's motion is measured."""
        return {}

    def _strikes_s(self, misbehaviour: Misbehaviour, occasion: Occasion) -> float:
        """When something strikes in a record that begins now; infinity where it does not."""
        if occasion.duration_s <= 0.0:
            return math.inf
        now_s = self._making.clock.now_s()
        return min(
            (
                now_s + strike.at * occasion.duration_s
                for strike in self._making.scenario.strikes
                if strike.misbehaviour is misbehaviour
            ),
            default=math.inf,
        )


class _Dialogue:
    """One connection, which may break; nobody gets through then any more."""

    def __init__(self, peer: GeneratorPeer, dialogue: Dialogue) -> None:
        self._peer = peer
        self._dialogue = dialogue

    def receive(self, data: bytes) -> Parts:
        """Carry out every complete message; may raise `HangUp`."""
        if self._peer.lost:
            raise HangUp
        return self._dialogue.receive(data)


def _figures(station: Station, name: str) -> Figures:
    given = given_figures(station, name)
    return figures_of(given, _FIGURES, f"simulation.instruments.{name}", also=("model", *TABLE_FIGURES))


def _load_ohm(instrument: Instrument) -> float:
    """The amplifier has the input that the driver's settings say."""
    found = _OHM.fullmatch(str(instrument.settings.get("load", "")).strip())
    return float(found[1]) if found else math.inf
