"""A simulated multimeter alone, for any VISA program: `gyrotest simulate meter`."""

import threading
from collections.abc import Callable
from types import TracebackType
from typing import Self

from gyrotest.clock import RealClock
from gyrotest.errors import RefusedError
from gyrotest.ports import Clock
from gyrotest.records.spec import Output, OutputKind, Spec
from gyrotest.records.station import Instrument, Simulation, Slot, Station
from gyrotest.simulation.bench import find_scenario
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.dialogue import Dialogue
from gyrotest.simulation.gyro_settings import gyro_parameters
from gyrotest.simulation.meter_peer import MeterPeer
from gyrotest.simulation.meter_state import Interface
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.peer import Making
from gyrotest.simulation.server import PtyServer, Server, TcpServer, has_pty
from gyrotest.simulation.workplace import Workplace
from gyrotest.units import Quantity

# What a scenario takes for the record's duration where no record is planned.
_RECORD_S = 60.0
# So that Ctrl-C is seen where a wait cannot be interrupted.
_PATIENCE_S = 0.5
_NAME = "meter"
_LAST_PORT = 65_535
_SPEC = Spec(
    model="50 mV/(deg/s)",
    cases={},
    output=Output(
        kind=OutputKind.VOLTAGE,
        scale_factor=Quantity(50.0, "mV/(deg/s)"),
        zero_rate=Quantity(2.5, "V"),
        bandwidth=Quantity(50.0, "Hz"),
    ),
)


class StandaloneMeter:
    """A meter that reads a nominal 50 mV/(°/s) gyro, served until it is closed.

    In real time; `fast` lets no time pass but the meter's own, and that at once. A scenario strikes
    within the first minute. Raises `RefusedError` and `StationError`.
    """

    def __init__(
        self,
        *,
        model: str = "34401A",
        port: int = 0,
        pty: bool = False,
        fast: bool = False,
        serial_number: str = "1234",
        scenario: str = "nominal",
        seed: int = 1,
    ) -> None:
        station = Station(
            name="stand-alone meter",
            instruments={
                _NAME: Instrument(
                    driver=model, resource="simulated", serial_number=f"SIM{seed % 100_000:05d}"
                )
            },
            slots={"a": Slot(source=_NAME)},
        )
        chosen = find_scenario(scenario)
        clock: Clock = VirtualClock() if fast else RealClock()
        peer = MeterPeer(
            Making(
                station=station,
                name=_NAME,
                clock=clock,
                seed=seed,
                scenario=chosen,
                live=not fast,
                hurried=fast,
            )
        )
        gyro = gyro_parameters(Simulation(), _SPEC, chosen.factors)
        workplace = Workplace(
            station,
            station.slots["a"],
            gyro,
            peers={},
            powered=False,
            seed=seed,
            scenario=chosen,
            clock=clock,
        )
        workplace.begin(
            Occasion(
                serial_number=serial_number,
                case="stand-alone",
                power_cycle=0,
                repeat=1,
                elapsed_s=0.0,
                duration_s=_RECORD_S,
            ),
            peer,
        )
        self._server: Server
        if pty:
            if not has_pty():
                raise RefusedError("this platform has no pseudo-terminals; serve a TCP port instead")
            terminal = PtyServer(lambda: peer.dialogue(Interface.SERIAL), clock)
            self._server, self.address = terminal, f"ASRL{terminal.path}::INSTR"
        else:
            server = _listen(lambda: peer.dialogue(Interface.SOCKET), clock, port)
            self._server, self.address = server, f"TCPIP::127.0.0.1::{server.port}::SOCKET"

    def close(self) -> None:
        """Stop serving; idempotent."""
        self._server.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def serve_meter(
    *,
    model: str,
    port: int,
    pty: bool,
    fast: bool,
    serial_number: str,
    scenario: str,
    seed: int,
    announce: Callable[[str], None],
    stop: threading.Event | None = None,
) -> None:
    """Serve a meter until Ctrl-C (or until `stop` is set); `announce` gets its VISA address first."""
    stop = threading.Event() if stop is None else stop
    with StandaloneMeter(
        model=model,
        port=port,
        pty=pty,
        fast=fast,
        serial_number=serial_number,
        scenario=scenario,
        seed=seed,
    ) as meter:
        announce(meter.address)
        try:
            while not stop.wait(_PATIENCE_S):
                pass
        except KeyboardInterrupt:
            announce("stopped")


def _listen(dialogue: Callable[[], Dialogue], clock: Clock, port: int) -> TcpServer:
    if not 0 <= port <= _LAST_PORT:
        raise RefusedError(f"127.0.0.1:{port}: ports are 0 (any free one) to {_LAST_PORT}")
    try:
        return TcpServer(dialogue, clock, port=port)
    except OSError as error:
        raise RefusedError(f"127.0.0.1:{port}: cannot listen there ({error}); try --port 0") from error
