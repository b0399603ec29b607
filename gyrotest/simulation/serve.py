"""A simulated instrument alone, for any program: `gyrotest simulate meter`."""

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any, Self

from gyrotest.clock import RealClock
from gyrotest.errors import RefusedError
from gyrotest.ports import Clock
from gyrotest.records.spec import Output, OutputKind, Spec
from gyrotest.records.station import Encoder, Instrument, Motion, Simulation, Slot, Station
from gyrotest.simulation.bench import find_scenario
from gyrotest.simulation.clock import VirtualClock
from gyrotest.simulation.gyro_settings import gyro_parameters
from gyrotest.simulation.occasion import Occasion
from gyrotest.simulation.peer import Making, Peer, Reading
from gyrotest.simulation.peers import make_peer
from gyrotest.simulation.scenarios import Scenario
from gyrotest.simulation.server import has_pty
from gyrotest.simulation.streaming import Digitizing, Streaming
from gyrotest.simulation.vibration import SteadyDrive
from gyrotest.simulation.wires import Wires
from gyrotest.simulation.workplace import Workplace
from gyrotest.units import Quantity

# What a scenario takes for the record's duration where no record is planned.
_RECORD_S = 60.0
# So that Ctrl-C is seen where a wait cannot be interrupted.
_PATIENCE_S = 0.5
_SLOT = "a"
_LAST_PORT = 65_535
_MOTION = Motion(
    max_rate=Quantity(500.0, "deg/s"), max_acceleration=Quantity(200.0, "deg/s/s"), slip_ring=True
)
# A synchronous source reads a gyro and a grating on a vibration table that swings by itself.
_DRIVE = "exciter"
_SWING = SteadyDrive(peak_v=0.5, frequency_hz=20.0)
_SHAKEN = Slot(
    source="daq",
    channel="gyro",
    vibration=_DRIVE,
    encoder=Encoder(sine="ua", cosine="ub", lines=9000),
)
_ANALOGUE = Spec(
    model="50 mV/(deg/s)",
    cases={},
    output=Output(
        kind=OutputKind.VOLTAGE,
        scale_factor=Quantity(50.0, "mV/(deg/s)"),
        zero_rate=Quantity(2.5, "V"),
        bandwidth=Quantity(50.0, "Hz"),
    ),
)
_DIGITAL = Spec(
    model="digital gyro",
    cases={},
    output=Output(
        kind=OutputKind.RATE,
        axes=("x", "y", "z"),
        full_scale=Quantity(400.0, "deg/s"),
        bandwidth=Quantity(262.0, "Hz"),
    ),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """An instrument that can be served alone: its models (drivers), the first one by default, and TCP port.

    `moves_time`: whether it can run without time passing for anybody else.
    """

    models: tuple[str, ...]
    port: int = 5025
    moves_time: bool = False
    figures: Mapping[str, Any] = field(default_factory=dict)


_GYRO = {"sample_rate": "125 Hz"}
KINDS: Mapping[str, Kind] = {
    "meter": Kind(models=("34401A", "34465A"), moves_time=True),
    "table": Kind(models=("acutrol3000", "aerosmith"), port=9878),
    "supply": Kind(models=("scpi_supply",)),
    "chamber": Kind(models=("scpi_chamber",)),
    "generator": Kind(models=("keysight33500b",)),
    "stim210": Kind(models=("stim210",), moves_time=True, figures={"frame": "rate_counter", **_GYRO}),
    "stim300": Kind(models=("stim300",), moves_time=True, figures={"frame": "rate", **_GYRO}),
    "line": Kind(models=("line_stream",), moves_time=True, figures=_GYRO),
    "daq": Kind(models=("sync_stream",), port=5030, moves_time=True),
}


class Standalone:
    """An instrument served until it is closed; a meter reads a nominal 50 mV/(°/s) gyro.

    So does a synchronous source (`daq`, channel `gyro`), with a grating of 9000 lines (`ua`, `ub`), on a table
    that swings.

    In real time; `fast` lets no time pass but the instrument's own, and that at once. A scenario strikes
    within the first minute. `figures` are those of `simulation.instruments`. Raises `RefusedError` and
    `StationError`.
    """

    def __init__(
        self,
        instrument: str = "meter",
        *,
        model: str | None = None,
        port: int = 0,
        pty: bool = False,
        fast: bool = False,
        serial_number: str = "1234",
        scenario: str = "nominal",
        seed: int = 1,
        figures: Mapping[str, Any] | None = None,
    ) -> None:
        kind = KINDS[instrument]
        self._refuse(instrument, model=model, port=port, pty=pty, fast=fast)
        clock: Clock = VirtualClock() if fast else RealClock()
        making = Making(
            station=_station(
                instrument, model or kind.models[0], seed, {**kind.figures, **(figures or {})}
            ),
            name=instrument,
            clock=clock,
            seed=seed,
            scenario=find_scenario(scenario),
            live=not fast,
            hurried=fast,
        )
        peer = make_peer(making)
        _begin(peer, making, serial_number)
        self._wires = Wires(clock, port=port, hurried=fast)
        try:
            self.address = self._wires.serve(instrument, f"simulated:{'pty' if pty else 'tcp'}", peer)
        except OSError as error:
            message = f"127.0.0.1:{port}: cannot listen there ({error}); try --port 0"
            raise RefusedError(message) from error

    def _refuse(self, instrument: str, *, model: str | None, port: int, pty: bool, fast: bool) -> None:
        kind = KINDS[instrument]
        if model is not None and model not in kind.models:
            raise RefusedError(
                f"the simulated {instrument} is no '{model}'; write one of {', '.join(kind.models)}"
            )
        if fast and not kind.moves_time:
            raise RefusedError(f"a simulated {instrument} needs time to pass; leave --fast out")
        if pty and not has_pty():
            raise RefusedError("this platform has no pseudo-terminals; serve a TCP port instead")
        if not 0 <= port <= _LAST_PORT:
            raise RefusedError(f"127.0.0.1:{port}: ports are 0 (any free one) to {_LAST_PORT}")

    def close(self) -> None:
        """Stop serving; idempotent."""
        self._wires.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _station(name: str, driver: str, seed: int, figures: Mapping[str, Any]) -> Station:
    instrument = Instrument(
        driver=driver,
        resource="simulated",
        serial_number=f"SIM{seed % 100_000:05d}",
        motion=_MOTION if name == "table" else None,
    )
    beside = {_DRIVE: Instrument(driver="keysight33500b", resource="simulated")} if name == "daq" else {}
    return Station(
        name="stand-alone",
        instruments={name: instrument, **beside},
        slots={_SLOT: _SHAKEN if name == "daq" else Slot(source=name)},
        simulation=Simulation(instruments={name: figures} if figures else {}),
    )


def _begin(peer: Peer, making: Making, serial_number: str) -> None:
    """Put a unit before the instrument, or into it."""
    occasion = Occasion(
        serial_number=serial_number,
        case="stand-alone",
        power_cycle=0,
        repeat=1,
        elapsed_s=0.0,
        duration_s=_RECORD_S,
    )
    peer.begin(occasion)
    if not isinstance(peer, Reading | Streaming | Digitizing):
        return
    spec = _DIGITAL if isinstance(peer, Streaming) else _ANALOGUE
    scenario: Scenario = making.scenario
    workplace = Workplace(
        making.station,
        making.station.slots[_SLOT],
        gyro_parameters(Simulation(), spec, scenario.factors),
        peers={_DRIVE: _SWING},
        powered=False,
        seed=making.seed,
        scenario=scenario,
        clock=making.clock,
    )
    workplace.begin(occasion, peer)


def serve(
    instrument: str,
    *,
    announce: Callable[[str], None],
    stop: threading.Event | None = None,
    **options: Any,
) -> None:
    """Serve an instrument until Ctrl-C (or until `stop` is set); `announce` gets its VISA address first.

    `options` are those of `Standalone`.
    """
    stop = threading.Event() if stop is None else stop
    with Standalone(instrument, **options) as served:
        announce(served.address)
        try:
            while not stop.wait(_PATIENCE_S):
                pass
        except KeyboardInterrupt:
            announce("stopped")
