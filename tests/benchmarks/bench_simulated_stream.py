"""Seconds of processor time that the simulated bench takes for a digital gyro's frames, in virtual time."""

import contextlib
import socket
import sys
import threading
import time

from gyrotest.records.spec import Output, OutputKind, Spec
from gyrotest.records.station import Instrument, Simulation, Slot, Station
from gyrotest.simulation.bench import SimulatedBench
from gyrotest.units import Quantity

_HOURS = 20.0
_BLOCK_S = 1.0


def main() -> None:
    """Print the processor time of 20 h of 125 Hz frames with three axes; the reader's is left out."""
    with SimulatedBench(_station(), _spec()) as bench:
        bench.insert(slot="a", serial_number="1234")
        port = int(bench.address("gyro").split("::")[2])
        with socket.create_connection(("127.0.0.1", port)) as connection:
            received: list[int] = []
            reader = threading.Thread(target=_read, args=(connection, received), daemon=True)
            reader.start()
            bench.clock.sleep_until(0.0)
            bench.begin(
                slot="a",
                serial_number="1234",
                case="bench",
                power_cycle=1,
                repeat=1,
                elapsed_s=600.0,
                duration_s=_HOURS * 3600.0,
            )
            began_s = time.thread_time()
            for block in range(round(_HOURS * 3600.0 / _BLOCK_S)):
                bench.clock.sleep_until((block + 1) * _BLOCK_S)
            took_s = time.thread_time() - began_s
    frames = _HOURS * 3600.0 * 125.0
    sys.stdout.write(
        f"{frames:.0f} frames of three axes in blocks of {_BLOCK_S:g} s: {took_s:.1f} s of processor time"
        f" (at most 25 s), {1e6 * took_s / frames:.2f} us a frame\n"
    )


def _read(connection: socket.socket, received: list[int]) -> None:
    buffer = bytearray(1 << 20)
    with contextlib.suppress(OSError):
        while count := connection.recv_into(buffer):
            received.append(count)


def _station() -> Station:
    return Station(
        name="stream",
        instruments={
            "gyro": Instrument(
                driver="stim210",
                resource="simulated:tcp",
                settings={"frame": "rate_temperature_counter", "sample_rate": "125 Hz"},
            )
        },
        slots={"a": Slot(source="gyro")},
        simulation=Simulation(),
    )


def _spec() -> Spec:
    output = Output(
        kind=OutputKind.RATE,
        axes=("x", "y", "z"),
        full_scale=Quantity(400.0, "deg/s"),
        bandwidth=Quantity(33.0, "Hz"),
    )
    return Spec(model="STIM210", output=output, cases={})


if __name__ == "__main__":
    main()
