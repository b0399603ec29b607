"""The simulated bench: one physical world, one clock, a server for each simulated instrument."""

import zlib
from collections.abc import Callable, Mapping
from types import TracebackType
from typing import Self

from gyrotest.clock import RealClock
from gyrotest.errors import Fault, StationError
from gyrotest.ports import Clock
from gyrotest.records.spec import Output
from gyrotest.records.station import Simulation, Station
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.dialogue import Dialogue, LineDialogue
from gyrotest.simulation.meter import Meter
from gyrotest.simulation.meter_state import Interface
from gyrotest.simulation.prologix import PrologixDialogue
from gyrotest.simulation.scenarios import SCENARIOS, Scenario
from gyrotest.simulation.server import PtyServer, Server, TcpServer, has_pty
from gyrotest.simulation.settings import gyro_parameters, meter_parameters, unknown_instruments
from gyrotest.simulation.workplace import Occasion, Workplace, new_meter

_GPIB_ADDRESS = 22
_LINE_FREQUENCY_HZ = 50.0
_SIMULATED = "simulated"


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
        served = [name for name, one in station.instruments.items() if is_simulated(one.resource)]
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
        way = resource.removeprefix(_SIMULATED)
        if way in {"", ":tcp"}:
            return (
                f"TCPIP::127.0.0.1::{self._tcp(lambda: LineDialogue(meter, Interface.SOCKET))}::SOCKET"
            )
        if way == ":prologix":
            port = self._tcp(lambda: PrologixDialogue({_GPIB_ADDRESS: meter}, self.clock))
            return self._gpib(f"PRLGX-TCPIP{self._boards}::127.0.0.1::{port}::INTFC")
        if way not in {":pty", ":prologix-pty"}:
            message = f"'{resource}' is no simulated resource; write simulated[:tcp|:pty|:prologix|:prologix-pty]"
            raise StationError([Fault("", None, f"instruments.{name}.resource", message)])
        if not has_pty():
            message = "this platform has no pseudo-terminals; write simulated:tcp"
            raise StationError([Fault("", None, f"instruments.{name}.resource", message)])
        if way == ":pty":
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


def line_frequency_hz(station: Station) -> float:
    """The station's line frequency, Hz; 50 where it states none."""
    return station.line_frequency.to("Hz") if station.line_frequency else _LINE_FREQUENCY_HZ


def find_scenario(name: str) -> Scenario:
    """The scenario of that name; raises `StationError`."""
    if name not in SCENARIOS:
        message = f"'{name}' is no scenario; write one of {', '.join(SCENARIOS)}"
        raise StationError([Fault("", None, "simulation.scenario", message)])
    return SCENARIOS[name]


def is_simulated(resource: str) -> bool:
    """Whether the simulated bench serves an instrument with this resource."""
    return resource == _SIMULATED or resource.startswith(f"{_SIMULATED}:")


def _meter_serial(station: Station, name: str) -> str:
    """What `*IDN?` answers: begins with SIM, so that nobody takes it for a real instrument."""
    stated = station.instruments[name].serial_number
    if stated is not None and stated.upper().startswith("SIM"):
        return stated
    return f"SIM{zlib.crc32(name.encode()) % 100_000:05d}"
