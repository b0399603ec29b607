"""Serial gyros: frames decoded a second, what a live line costs, and whether one loses frames beside a busy core.

`python -m tests.benchmarks.bench_decoding [SECONDS]`: SECONDS is how long the live line runs, 600 by default.
"""

import contextlib
import multiprocessing
import os
import pty
import statistics
import sys
import time
import tty
from multiprocessing.synchronize import Event

import numpy as np
from numpy.typing import NDArray

from gyrotest.clock import RealClock
from gyrotest.instruments.stim.crc import Crc
from gyrotest.instruments.stim.decoding import FrameDecoder
from gyrotest.instruments.stim.models import STIM210, STIM300, Model
from gyrotest.instruments.stim.settings import Stim300Settings
from gyrotest.instruments.stim300 import Stim300
from gyrotest.units import Quantity

_FRAMES = 9_000_000
# What is decoded at once of a file.
_PART = 1_000_000
_ROUNDS = 3
_RATE_HZ = 2000
_TICK_S = 0.002
_LIVE_S = 600.0
_KINDS = (
    (STIM210, "rate"),
    (STIM210, "rate_temperature_counter"),
    (STIM300, "rate"),
    (STIM300, "rate_temperature"),
)


def main(live_s: float | None = None) -> None:
    """Print all figures; the live line only for as long as is asked for."""
    for model, kind in _KINDS:
        rate = _decoded_per_second(model, kind)
        sys.stdout.write(
            f"{model.name} {kind}: {_FRAMES:,} frames decoded at {rate / 1e6:.1f} million a second"
            " (at least 2.0)\n"
        )
    if live_s is None:
        live_s = float(sys.argv[1]) if len(sys.argv) > 1 else _LIVE_S
    _live(live_s)


def frames_of(model: Model, kind: str, count: int) -> NDArray[np.uint8]:
    """Good frames with all sorts of values, (count, size)."""
    frame = model.frame(kind)
    rows = np.random.default_rng(1).integers(0, 256, (count, frame.size), dtype=np.uint8)
    rows[:, 0] = frame.identifier
    rows[:, frame.statuses] = 0
    if frame.counter is not None:
        rows[:, frame.counter] = np.arange(count) % 256
    return np.hstack((rows, _checksums(model.crc, rows)))


def _decoded_per_second(model: Model, kind: str) -> float:
    decoder = FrameDecoder(model, model.frame(kind))
    part = frames_of(model, kind, _PART)
    took_s = []
    for _ in range(_ROUNDS):
        began_s = time.process_time()
        for _ in range(_FRAMES // _PART):
            if not decoder.decode(part).whole.all():
                raise RuntimeError(f"{model.name} {kind}: frames that are whole were refused")
        took_s.append(time.process_time() - began_s)
    return _FRAMES / statistics.median(took_s)


def _live(live_s: float) -> None:
    """A STIM300 at 2000 Hz on a pseudo-terminal in real time, while every other core is kept busy."""
    # Forked, so that the unit has the terminal's other end.
    context = multiprocessing.get_context("fork")
    stop = context.Event()
    master, slave = pty.openpty()
    tty.setraw(master)
    tty.setraw(slave)
    others = [
        context.Process(target=_burn, args=(stop,)) for _ in range(max(1, (os.cpu_count() or 2) - 1))
    ]
    unit = context.Process(target=_send, args=(master, stop))
    for process in (*others, unit):
        process.start()
    try:
        _acquire(f"ASRL{os.ttyname(slave)}::INSTR", live_s)
    finally:
        stop.set()
        for process in (*others, unit):
            process.join()
        os.close(master)
        os.close(slave)


def _acquire(resource: str, live_s: float) -> None:
    settings = Stim300Settings(frame="rate", sample_rate=Quantity(float(_RATE_HZ), "Hz"), ask=False)
    source = Stim300(resource, settings, clock=RealClock())
    source.open()
    source.configure(1.0 / _RATE_HZ)
    wanted = round(live_s * _RATE_HZ)
    source.start(0, wanted)
    began_s, cpu_s = time.perf_counter(), time.process_time()
    got = 0
    while (block := source.fetch()) is not None:
        got += len(block.flags)
    cpu_s, took_s = time.process_time() - cpu_s, time.perf_counter() - began_s
    source.close()
    sys.stdout.write(
        f"live for {took_s:.0f} s at {_RATE_HZ} Hz × 3 axes, the other cores busy: {got} of {wanted} samples;"
        f" {'; '.join(source.remarks())}; {100 * cpu_s / took_s:.1f} % of a core (below 8)\n"
    )


def _send(master: int, stop: Event) -> None:
    """The unit, in a process of its own: frames when they are due, as many as the terminal takes."""
    # What the terminal cannot hold is lost, as in a receiver that nobody reads.
    os.set_blocking(master, False)
    frames = frames_of(STIM300, "rate", 256)
    began_s, sent = time.monotonic(), 0
    while not stop.is_set():
        time.sleep(_TICK_S)
        due = int((time.monotonic() - began_s) * _RATE_HZ)
        if due > sent:
            data = frames[np.arange(sent, due) % 256].tobytes()
            with contextlib.suppress(BlockingIOError):
                while data:
                    data = data[os.write(master, data) :]
        sent = due


def _burn(stop: Event) -> None:
    while not stop.is_set():
        sum(range(100_000))


def _checksums(crc: Crc, rows: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The checksums, (n, bytes), bit by bit over all rows at once."""
    filled = np.pad(rows, ((0, 0), (0, -rows.shape[1] % crc.align)))
    register = np.full(len(rows), crc.seed, dtype=np.uint64)
    top, mask = np.uint64(1 << (crc.width - 1)), np.uint64((1 << crc.width) - 1)
    for column in filled.T:
        register ^= column.astype(np.uint64) << np.uint64(crc.width - 8)
        for _ in range(8):
            high = (register & top) > 0
            register = register << np.uint64(1) & mask
            register[high] ^= np.uint64(crc.polynomial)
    sent = register.astype(f">u{crc.size}")
    return np.frombuffer(sent.tobytes(), dtype=np.uint8).reshape(-1, crc.size)


if __name__ == "__main__":
    main()
