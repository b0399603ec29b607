"""A slot of the simulated bench: which unit is in it, and what goes to the instrument that reads it."""

from collections.abc import Mapping

from gyrotest.ports import Clock
from gyrotest.records.station import Slot, Station
from gyrotest.simulation.carriage import Carriage, carriages
from gyrotest.simulation.faults import Faults
from gyrotest.simulation.gyro import GyroOutput, RailedOutput, SteadyOutput, TemperatureOutput
from gyrotest.simulation.housed import Housed
from gyrotest.simulation.noise import RateNoise
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.peer import Peer, Reading
from gyrotest.simulation.scenarios import Misbehaviour, Scenario
from gyrotest.simulation.settings import table_axis
from gyrotest.simulation.signal import Signal
from gyrotest.simulation.stage import ShaftErrors, shaft_errors, stage_axes, stage_carriages
from gyrotest.simulation.streaming import Digitizing, Streaming
from gyrotest.simulation.streams import Normals, generator
from gyrotest.simulation.surroundings import Surroundings
from gyrotest.simulation.unit import Dice, GyroParameters, misalignment_deg

_RAIL_V = 15.0


class Workplace:
    """A slot, and the unit in it. `peers` are the bench's instruments that are in use."""

    def __init__(
        self,
        station: Station,
        slot: Slot,
        gyro: GyroParameters,
        *,
        peers: Mapping[str, Peer],
        powered: bool,
        seed: int,
        scenario: Scenario,
        clock: Clock,
    ) -> None:
        self._station = station
        self._slot = slot
        self._gyro = gyro
        self._surroundings = Surroundings(slot, peers, powered=powered)
        self._seed = seed
        self._scenario = scenario
        self._clock = clock
        self._housed: Housed | None = None
        self._shaft: ShaftErrors | None = None

    @property
    def occasion(self) -> Occasion | None:
        """The record begun last."""
        return self._housed.occasion if self._housed else None

    def begin(self, occasion: Occasion, source: Peer) -> None:
        """Put a unit into the slot and restart the random streams for its next record."""
        now_s = self._clock.now_s()
        housed = self._housed = Housed(
            self._gyro,
            self._carriages(occasion),
            self._surroundings,
            occasion,
            seed=self._seed,
            inverted=self._scenario.inverted,
            now_s=now_s,
        )
        if isinstance(source, Reading):
            strikes = self._scenario.strikes if occasion.duration_s > 0.0 else ()
            faults = Faults(strikes, start_s=now_s, duration_s=occasion.duration_s)
            source.connect(occasion, self._signals(housed), faults)
        elif isinstance(source, Streaming):
            source.house(housed)
        elif isinstance(source, Digitizing):
            source.seat(self._slot, housed)

    def _carriages(self, occasion: Occasion) -> tuple[Carriage, ...]:
        """How the unit's axes sit on what turns it, for a record."""
        station, slot = self._station, self._slot
        stage = station.instruments[slot.table] if slot.table is not None else None
        if stage is None or stage.shaft is None or slot.table is None:
            self._shaft = None
            return carriages(
                self._gyro.axes,
                occasion.mountings,
                table_axis=table_axis(station, slot.table),
                site=station.site,
            )
        dice = Dice(seed=self._seed, serial_number=occasion.serial_number)
        self._shaft = shaft_errors(
            stage.shaft, seed=self._seed, serial_number=occasion.serial_number, stage=slot.table
        )
        lies = stage_axes(stage.shaft, self._shaft, station.site)
        if occasion.placement is None and occasion.mountings:
            shaft = float(lies[1, 0]), float(lies[1, 1]), float(lies[1, 2])
            return carriages(self._gyro.axes, occasion.mountings, table_axis=shaft, site=station.site)
        return stage_carriages(
            self._gyro.axes,
            lies,
            frame=slot.frame,
            placement=occasion.placement,
            site=station.site,
            misalignment_deg=lambda name: misalignment_deg(name, self._gyro, dice),
        )

    def _signals(self, housed: Housed) -> dict[str, Signal]:
        """The voltages by the instrument's channel."""
        channels = self._slot.channels
        outputs = {
            channels.get(element.axis.name, self._slot.channel or ""): self._signal(housed, index)
            for index, element in enumerate(housed.elements)
        }
        beside = {
            channel: TemperatureOutput(self._surroundings) for channel in self._slot.auxiliary.values()
        }
        return {**outputs, **beside}

    def _signal(self, housed: Housed, index: int) -> Signal:
        if self._scenario.dead_output:
            return SteadyOutput(self._gyro.zero_rate)
        element, occasion, begun_s = housed.elements[index], housed.occasion, housed.begun_s
        names = (*occasion.stream, element.axis.name) if element.axis.name else occasion.stream
        noise = RateNoise(
            self._gyro.noise,
            Normals(generator(self._seed, "gyro noise", *names)),
            since_power_on_s=occasion.elapsed_s,
            start_s=begun_s,
        )
        signal: Signal = GyroOutput(housed, element, noise)
        for strike in self._scenario.strikes if occasion.duration_s > 0.0 else ():
            if strike.misbehaviour is Misbehaviour.RAIL:
                from_s = begun_s + strike.at * occasion.duration_s
                to_s = begun_s + strike.until * occasion.duration_s
                signal = RailedOutput(signal, from_s=from_s, to_s=to_s, rail_v=_RAIL_V)
        return signal

    def truth(self, duration_s: float) -> dict[str, float]:
        """The true figures of the unit and of how its stage lies, for the record begun last; empty before it."""
        if self._housed is None:
            return {}
        lies = self._shaft.truth() if self._shaft is not None else {}
        return self._housed.truth(duration_s) | lies
