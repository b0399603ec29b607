"""A simulated acquisition system to be spoken to: the bench around it, and one end of the connection."""

import json
import socket
import struct
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrotest.ports import Clock
from gyrotest.records.spec import Output, OutputKind, Spec
from gyrotest.records.station import Accuracy, Encoder, Instrument, Motion, Simulation, Slot, Station
from gyrotest.simulation.bench import SimulatedBench
from gyrotest.simulation.peer import Peer
from gyrotest.simulation.vibration import SteadyDrive
from gyrotest.units import Quantity

HEADER = struct.Struct("<4sHHIIIQI")
CLIPPED = 2**31 - 1
OVERRUN, LAST = 1, 2
SPEC = Spec(
    model="FOG",
    output=Output(
        kind=OutputKind.VOLTAGE,
        scale_factor=Quantity(50.0, "mV/(deg/s)"),
        full_scale=Quantity(100.0, "deg/s"),
        bandwidth=Quantity(80.0, "Hz"),
    ),
    cases={},
)
NOISELESS = {
    "angle_random_walk": "0 deg/sqrt(h)",
    "bias_instability_coefficient": "0 deg/h",
    "rate_random_walk": "0 deg/h/sqrt(h)",
}
IDEAL = {
    "noise": "0 V",
    "encoder_noise": "0 deg",
    "grating_offset": "0 %",
    "grating_mismatch": "0 %",
    "grating_quadrature": "0 deg",
    "grating_harmonic": "0 %",
    "grating_ripple": "0 %",
    "grating_noise": "0 V",
}
GRATING = Encoder(sine="ua", cosine="ub", lines=9000)
THETA = Encoder(angle="theta")
SHAKEN = {"a": Slot(source="daq", channel="gyro", vibration="exciter", encoder=THETA)}


@dataclass
class Heard:
    """What came of an acquisition."""

    numbers: list[NDArray[np.int32]] = field(default_factory=list)
    indices: list[int] = field(default_factory=list)
    sequences: list[int] = field(default_factory=list)
    flags: list[int] = field(default_factory=list)
    damaged: int = 0

    @property
    def rows(self) -> NDArray[np.int32]:
        return np.concatenate(self.numbers)

    @property
    def position(self) -> NDArray[np.int64]:
        parts = zip(self.indices, self.numbers, strict=True)
        return np.concatenate([first + np.arange(len(rows)) for first, rows in parts])


class Caller:
    """One end of a connection, by the protocol's page alone."""

    def __init__(self, address: str, clock: Clock) -> None:
        _, host, port, _ = address.split("::")
        self._socket = socket.socket()
        # So little waits on the line that what is not taken stays with the instrument.
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 65_536)
        self._socket.settimeout(10.0)
        self._socket.connect((host, int(port)))
        self._file = self._socket.makefile("rb")
        self._clock = clock

    def ask(self, line: str) -> Any:
        self.say(line)
        return json.loads(self._file.readline())

    def say(self, line: str) -> None:
        self._socket.sendall(line.encode() + b"\n")

    def configure(self, *channels: str, rate_hz: float = 10_000.0, trigger: str = "immediate") -> Any:
        content = {"channels": channels, "rate_hz": rate_hz, "trigger": trigger}
        return self.ask(f"CONFIGURE {json.dumps(content)}")

    def block(self, heard: Heard) -> bool:
        """Take a block; whether there is another one."""
        head = self._file.read(HEADER.size)
        magic, version, channels, flags, sequence, count, index, total = HEADER.unpack(head)
        assert (magic, version) == (b"GBLK", 1)
        payload = self._file.read(4 * count * channels)
        if zlib.crc32(payload, zlib.crc32(head[:-4])) != total:
            heard.damaged += 1
        heard.numbers.append(np.frombuffer(payload, "<i4").reshape(count, channels))
        heard.indices.append(index)
        heard.sequences.append(sequence)
        heard.flags.append(flags)
        return not flags & LAST

    def record(self, samples: int, *, rate_hz: float = 10_000.0, step_s: float = 0.5) -> Heard:
        """A whole acquisition, as the time passes."""
        assert self.ask(f'START {{"samples": {samples}}}') == {"armed": True}
        begun_s = self._clock.now_s()
        for end_s in np.arange(step_s, samples / rate_hz + 2 * step_s, step_s):
            self._clock.sleep_until(begun_s + float(end_s))
        return self.rest(Heard())

    def rest(self, heard: Heard) -> Heard:
        """What comes to the last block."""
        while self.block(heard):
            pass
        return heard

    def close(self) -> None:
        self._file.close()
        self._socket.close()


def station(
    *,
    slots: Mapping[str, Slot] | None = None,
    gyro: Mapping[str, Any] | None = None,
    daq: Mapping[str, Any] | None = None,
    settings: Mapping[str, Any] | None = None,
    accuracy: Accuracy | None = None,
    scenario: str = "nominal",
) -> Station:
    return Station(
        name="daq",
        instruments={
            "daq": Instrument(
                driver="sync_stream", resource="simulated", settings=settings or {}, accuracy=accuracy
            ),
            "exciter": Instrument(
                driver="keysight33500b",
                resource="simulated",
                settings={"sensitivity": "20 deg/s/V", "max_voltage": "5 V", "max_rate": "40 deg/s"},
            ),
            "stage": Instrument(
                driver="acutrol3000",
                resource="simulated",
                motion=Motion(
                    max_rate=Quantity(20.0, "deg/s"),
                    max_acceleration=Quantity(50.0, "deg/s/s"),
                    slip_ring=True,
                ),
            ),
        },
        slots=slots or SHAKEN,
        simulation=Simulation(
            scenario=scenario,
            gyro=NOISELESS | {"turn_on_bias": "0 deg/s", "warm_up_drift": "0 deg/s"} | dict(gyro or {}),
            instruments={"daq": IDEAL | dict(daq or {})},
        ),
    )


@dataclass
class Bench:
    """A bench whose units are in their slots, and a connection to its acquisition system."""

    served: SimulatedBench
    caller: Caller

    def begin(self, serial_number: str = "1", *, duration_s: float = 10.0, case: str = "c") -> None:
        for slot in self.served._station.slots:
            self.served.begin(
                slot=slot,
                serial_number=serial_number,
                case=case,
                power_cycle=1,
                repeat=1,
                elapsed_s=100.0,
                duration_s=duration_s,
            )

    def truth(self) -> Mapping[str, float]:
        return self.served.truth("a", duration_s=1.0)

    def values(self, heard: Heard) -> NDArray[np.float64]:
        """In units, (n, channels) of all channels that there are."""
        scales = [one["scale"] for one in self.caller.ask("CHANNELS")]
        return heard.rows * np.array(scales)


@contextmanager
def bench(
    made: Station,
    *,
    drive: SteadyDrive | None = None,
    serial_number: str = "1",
    spec: Spec = SPEC,
    supply: Peer | None = None,
) -> Iterator[Bench]:
    with SimulatedBench(made, spec) as served:
        if drive is not None:
            served._peers["exciter"] = drive
        if supply is not None:
            served._peers["supply"] = supply
        for slot in made.slots:
            served.insert(slot=slot, serial_number=serial_number)
        caller = Caller(served.address("daq"), served.clock)
        try:
            yield Bench(served, caller)
        finally:
            caller.close()
