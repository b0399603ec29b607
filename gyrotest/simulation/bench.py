"""The simulated bench: one physical world, one clock, a server for each simulated instrument."""

import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import TracebackType
from typing import Self

from gyrotest.clock import RealClock
from gyrotest.errors import Fault, StationError
from gyrotest.ports import Clock
from gyrotest.records.spec import Output
from gyrotest.records.station import Simulation, Station
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.converter import Converter, MeterErrors
from gyrotest.simulation.dialogue import Dialogue, LineDialogue
from gyrotest.simulation.faults import Faults
from gyrotest.simulation.gyro import GyroOutput, GyroParameters, RailedOutput, Signal, SteadyOutput, Unit
from gyrotest.simulation.meter import Meter
from gyrotest.simulation.meter_state import Interface
from gyrotest.simulation.noise import RateNoise
from gyrotest.simulation.personalities import MODELS, command_table
from gyrotest.simulation.prologix import PrologixDialogue
from gyrotest.simulation.scenarios import SCENARIOS, Misbehaviour, Scenario
from gyrotest.simulation.server import PtyServer, Server, TcpServer, has_pty
from gyrotest.simulation.settings import (
    MeterParameters,
    gyro_parameters,
    meter_parameters,
    unknown_instruments,
)
from gyrotest.simulation.streams import Normals, generator

_GPIB_ADDRESS = 22
_RAIL_V = 15.0
_LINE_FREQUENCY_HZ = 50.0
_SIMULATED = "simulated"


@dataclass(frozen=True, slots=True, kw_only=True)
class Occasion:
    """Which record of which unit is next: what the random streams depend on."""

    serial_number: str
    case: str
    power_cycle: int
    repeat: int
    elapsed_s: float
    duration_s: float


class Workplace:
    """One meter of the bench and the unit that it reads."""

    def __init__(
        self,
        name: str,
        meter: Meter,
        gyro: GyroParameters,
        errors: MeterParameters,
        *,
        seed: int,
        scenario: Scenario,
        clock: Clock,
    ) -> None:
        self.meter = meter
        self._name = name
        self._gyro = gyro
        self._errors = errors
        self._seed = seed
        self._scenario = scenario
        self._clock = clock
        self._unit: Unit | None = None
        self._elapsed_s = 0.0
        self._drawn_errors: MeterErrors | None = None

    def begin(self, occasion: Occasion) -> None:
        """Put a unit on the meter's input and restart the random streams for its next record."""
        now_s = self._clock.now_s()
        unit = self._draw_unit(occasion, now_s)
        errors = self._draw_errors(occasion.serial_number)
        stream = (occasion.serial_number, occasion.case, occasion.power_cycle, occasion.repeat)
        noise = RateNoise(
            self._gyro.noise,
            Normals(generator(self._seed, "gyro noise", *stream)),
            since_power_on_s=occasion.elapsed_s,
            start_s=now_s,
        )
        faults = Faults(self._scenario.strikes, start_s=now_s, duration_s=occasion.duration_s)
        normals = Normals(generator(self._seed, "meter noise", self._name, *stream))
        signal = self._signal(unit, noise, now_s, occasion.duration_s)
        self._unit, self._drawn_errors, self._elapsed_s = unit, errors, occasion.elapsed_s
        self.meter.connect(Converter(signal, errors, normals, faults))

    def _draw_unit(self, occasion: Occasion, now_s: float) -> Unit:
        gyro, serial = self._gyro, occasion.serial_number
        spread = generator(self._seed, "scale factor", serial).uniform(-1.0, 1.0)
        turn_on = generator(self._seed, "turn-on bias", serial, occasion.power_cycle).standard_normal()
        factor = gyro.scale_factor_v_per_dps * (1.0 + gyro.scale_factor_error * spread)
        return Unit(
            parameters=gyro,
            scale_factor_v_per_dps=-factor if self._scenario.inverted else factor,
            turn_on_bias_dps=gyro.turn_on_bias_dps * turn_on,
            power_on_s=now_s - occasion.elapsed_s,
        )

    def _draw_errors(self, serial_number: str) -> MeterErrors:
        stream = generator(self._seed, "meter errors", serial_number, self._name)
        return MeterErrors(
            gain=self._errors.gain_error * stream.uniform(-1.0, 1.0),
            offset_of_range=self._errors.offset_error_of_range * stream.uniform(-1.0, 1.0),
            noise_v=self._errors.noise_v,
        )

    def _signal(self, unit: Unit, noise: RateNoise, now_s: float, duration_s: float) -> Signal:
        if self._scenario.dead_output:
            return SteadyOutput(self._gyro.zero_rate_v)
        signal: Signal = GyroOutput(unit, noise)
        for strike in self._scenario.strikes:
            if strike.misbehaviour is Misbehaviour.RAIL:
                from_s, to_s = now_s + strike.at * duration_s, now_s + strike.until * duration_s
                signal = RailedOutput(signal, from_s=from_s, to_s=to_s, rail_v=_RAIL_V)
        return signal

    def truth(self, duration_s: float) -> dict[str, float]:
        """The true figures of the unit and the meter for the record begun last; empty before the first."""
        unit, errors = self._unit, self._drawn_errors
        if unit is None or errors is None:
            return {}
        drift = unit.drift_dps(unit.power_on_s + self._elapsed_s, duration_s)
        noise = self._gyro.noise
        return {
            "turn_on_bias_dps": unit.turn_on_bias_dps,
            "mean_drift_dps": drift,
            "bias_dps": unit.turn_on_bias_dps + drift,
            "input_rate_dps": self._gyro.input_rate_dps,
            "angle_random_walk_dps_sqrt_s": noise.angle_random_walk_dps_sqrt_s,
            "bias_instability_coefficient_dps": noise.bias_instability_dps,
            "rate_random_walk_dps_per_sqrt_s": noise.rate_random_walk_dps_per_sqrt_s,
            "bandwidth_hz": noise.bandwidth_hz,
            "scale_factor_v_per_dps": unit.scale_factor_v_per_dps,
            "zero_rate_v": self._gyro.zero_rate_v,
            "meter_gain_error": errors.gain,
            "meter_offset_of_range": errors.offset_of_range,
            "meter_noise_v": errors.noise_v,
        }


class SimulatedBench:
    """Serves every instrument of a station whose resource begins with `simulated`.

    Raises `StationError` for a complaint about the station's `simulation`.
    """

    def __init__(
        self,
        station: Station,
        output: Output,
        *,
        seed: int | None = None,
        scenario: str | None = None,
        real_time: bool = False,
    ) -> None:
        simulation = station.simulation or Simulation()
        chosen = find_scenario(scenario or simulation.scenario)
        served = [name for name, one in station.instruments.items() if _is_simulated(one.resource)]
        gyro = gyro_parameters(simulation.gyro, output, chosen.factors)
        if faults := unknown_instruments(station):
            raise StationError(faults)
        self.clock: Clock = RealClock() if real_time else VirtualClock()
        self._workplaces: dict[str, Workplace] = {}
        self._servers: list[Server] = []
        self._boards = 0
        addresses: dict[str, str] = {}
        try:
            for name in served:
                parameters = meter_parameters(station, name)
                meter = new_meter(
                    parameters.model,
                    serial_number=_meter_serial(station, name),
                    line_frequency_hz=line_frequency_hz(station),
                    clock=self.clock,
                    live=real_time,
                )
                self._workplaces[name] = Workplace(
                    name,
                    meter,
                    gyro,
                    parameters,
                    seed=simulation.seed if seed is None else seed,
                    scenario=chosen,
                    clock=self.clock,
                )
                addresses[name] = self._serve(name, station.instruments[name].resource, meter)
        except BaseException:
            self.close()
            raise
        self.addresses: Mapping[str, str] = addresses

    def _serve(self, name: str, resource: str, meter: Meter) -> str:
        """Start the server for a resource; the VISA address of what it serves."""
        _, _, way = resource.partition(":")
        if way in {"", "tcp"}:
            return (
                f"TCPIP::127.0.0.1::{self._tcp(lambda: LineDialogue(meter, Interface.SOCKET))}::SOCKET"
            )
        if way == "prologix":
            port = self._tcp(lambda: PrologixDialogue({_GPIB_ADDRESS: meter}, self.clock))
            return self._gpib(f"PRLGX-TCPIP{self._boards}::127.0.0.1::{port}::INTFC")
        if way not in {"pty", "prologix-pty"}:
            message = f"'{resource}' is no simulated resource; write simulated[:tcp|:pty|:prologix|:prologix-pty]"
            raise StationError([Fault("", None, f"instruments.{name}.resource", message)])
        if not has_pty():
            message = "this platform has no pseudo-terminals; write simulated:tcp"
            raise StationError([Fault("", None, f"instruments.{name}.resource", message)])
        if way == "pty":
            return f"ASRL{self._pty(lambda: LineDialogue(meter, Interface.SERIAL))}::INSTR"
        path = self._pty(lambda: PrologixDialogue({_GPIB_ADDRESS: meter}, self.clock))
        return self._gpib(f"PRLGX-ASRL{self._boards}::{path}::INTFC")

    def _gpib(self, interface: str) -> str:
        """The interface and the instrument behind it, separated by a blank."""
        address = f"{interface} GPIB{self._boards}::{_GPIB_ADDRESS}::INSTR"
        self._boards += 1
        return address

    def _tcp(self, dialogue: Callable[[], Dialogue]) -> int:
        server = TcpServer(dialogue, self.clock)
        self._servers.append(server)
        return server.port

    def _pty(self, dialogue: Callable[[], Dialogue]) -> str:
        server = PtyServer(dialogue, self.clock)
        self._servers.append(server)
        return server.path

    def begin(
        self,
        *,
        units: Mapping[str, str],
        case: str,
        power_cycle: int,
        repeat: int,
        elapsed_s: float,
        duration_s: float,
    ) -> None:
        """Prepare the next record: which serial number each instrument reads, and its streams.

        `elapsed_s` is the time since power-on at the record's start, which is now.
        """
        for instrument, serial_number in units.items():
            if instrument in self._workplaces:
                self._workplaces[instrument].begin(
                    Occasion(
                        serial_number=serial_number,
                        case=case,
                        power_cycle=power_cycle,
                        repeat=repeat,
                        elapsed_s=elapsed_s,
                        duration_s=duration_s,
                    )
                )

    def truth(self, instrument: str, *, duration_s: float) -> Mapping[str, float]:
        """The true figures behind an instrument for the record begun last; empty where nothing is simulated."""
        workplace = self._workplaces.get(instrument)
        return workplace.truth(duration_s) if workplace else {}

    def close(self) -> None:
        """Stop all servers; idempotent."""
        while self._servers:
            self._servers.pop().close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def new_meter(
    model: str, *, serial_number: str, line_frequency_hz: float, clock: Clock, live: bool
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
    )


def line_frequency_hz(station: Station) -> float:
    """The station's line frequency, Hz; 50 where it states none."""
    return station.line_frequency.to("Hz") if station.line_frequency else _LINE_FREQUENCY_HZ


def find_scenario(name: str) -> Scenario:
    """The scenario of that name; raises `StationError`."""
    if name not in SCENARIOS:
        message = f"'{name}' is no scenario; write one of {', '.join(SCENARIOS)}"
        raise StationError([Fault("", None, "simulation.scenario", message)])
    return SCENARIOS[name]


def _is_simulated(resource: str) -> bool:
    return resource == _SIMULATED or resource.startswith(f"{_SIMULATED}:")


def _meter_serial(station: Station, name: str) -> str:
    """What `*IDN?` answers: begins with SIM, so that nobody takes it for a real instrument."""
    stated = station.instruments[name].serial_number
    if stated is not None and stated.upper().startswith("SIM"):
        return stated
    return f"SIM{zlib.crc32(name.encode()) % 100_000:05d}"
