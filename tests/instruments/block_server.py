"""A server of the block protocol for tests: over a real socket, it sends at once what it is told to."""

import contextlib
import json
import socket
import struct
import threading
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

HEADER = struct.Struct("<4sHHIIIQ")
CHANNELS = [
    {"name": "gyro", "unit": "mV", "scale": 0.001, "skew_s": 0.0},
    {"name": "ua", "unit": "V", "scale": 1e-6, "skew_s": 10e-6},
    {"name": "ub", "unit": "V", "scale": 1e-6, "skew_s": 20e-6},
]


def packet(
    raw: Any, *, index: int, sequence: int, flags: int = 0, version: int = 1, spoilt: bool = False
) -> bytes:
    """A block as it goes over the line."""
    rows = np.asarray(raw, dtype="<i4")
    head = HEADER.pack(b"GBLK", version, rows.shape[1], flags, sequence, len(rows), index)
    crc = zlib.crc32(head + rows.tobytes()) ^ spoilt
    return head + struct.pack("<I", crc) + rows.tobytes()


def ramp(first: int, count: int, channels: int = 3) -> Any:
    """Rows that say which ones they are: 1000·k + column."""
    return 1000 * np.arange(first, first + count)[:, None] + np.arange(channels)


def plain(samples: int, channels: int = 3, size: int = 100) -> bytes:
    """All samples of an acquisition, in blocks of a size."""
    said = b""
    for number, first in enumerate(range(0, samples, size)):
        count = min(size, samples - first)
        flags = 2 * (first + count == samples)
        said += packet(ramp(first, count, channels), index=first, sequence=number, flags=flags)
    return said


@dataclass
class BlockServer:
    """Answers commands; what it sends at each START is the next of `acquisitions`, the last one again and again.

    None: it hangs up. `answers` go before its own, by command.
    """

    acquisitions: list[Callable[[int], bytes | None]] = field(default_factory=lambda: [plain])
    answers: dict[str, Any] = field(default_factory=dict)
    asked: list[str] = field(default_factory=list)
    serials: list[str] = field(default_factory=lambda: ["1234"])
    starts: int = 0
    connections: int = 0

    def __enter__(self) -> "BlockServer":
        self._listener = socket.create_server(("127.0.0.1", 0))
        port = self._listener.getsockname()[1]
        self._connection: socket.socket | None = None
        self.resource = f"TCPIP::127.0.0.1::{port}::SOCKET"
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *exception: object) -> None:
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        if self._connection is not None:
            with contextlib.suppress(OSError):
                self._connection.shutdown(socket.SHUT_RDWR)
        self._thread.join(2.0)

    def _serve(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                connection, _ = self._listener.accept()
                self.connections += 1
                self._connection = connection
                with connection, contextlib.suppress(OSError):
                    self._converse(connection)

    def _converse(self, connection: socket.socket) -> None:
        for line in connection.makefile("rb"):
            word, _, content = line.decode().strip().partition(" ")
            self.asked.append(line.decode().strip())
            said = self._answer(word, json.loads(content) if content else {})
            if said is None:
                return
            connection.sendall(said)

    def _answer(self, word: str, content: dict[str, Any]) -> bytes | None:
        told = self.answers.get(word, self._told(word, content))
        said = told if isinstance(told, bytes) else json.dumps(told).encode() + b"\n"
        if word != "START" or b"error" in said:
            return said
        act = self.acquisitions[min(self.starts, len(self.acquisitions) - 1)]
        self.starts += 1
        blocks = act(content["samples"])
        return None if blocks is None else said + blocks

    def _told(self, word: str, content: dict[str, Any]) -> Any:
        serial = self.serials[min(self.connections, len(self.serials)) - 1]
        identity = {"manufacturer": "Example", "model": "DAQ-4", "firmware": "1"}
        known = {
            "IDENTIFY": identity | {"serial_number": serial},
            "CHANNELS": CHANNELS,
            "CONFIGURE": {
                "rate_hz": content.get("rate_hz"),
                "filter_hz": 4000.0,
                "full_scale": 10_000.0,
            },
            "START": {"armed": True},
            "STOP": {"stopped": True},
        }
        return known.get(word, {"error": f"unknown command {word}"})
