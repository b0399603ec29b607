"""A terminal of a stated size, and what was drawn on it, frame by frame."""

import os
import re
import subprocess
import sys
import termios
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import IO

_ERASED = re.compile(r"(?:\r|\x1b\[\?25[lh]|\x1b\[[12]?[AJKH])*\x1b\[2K(?:\r|\x1b\[1A|\x1b\[2K)*")
_STYLE = re.compile(r"\x1b\[[0-9;?]*[a-zA-Z]")


class Terminal:
    """A pty whose other end is read all the time."""

    def __init__(self, *, columns: int, lines: int) -> None:
        self._ours, theirs = os.openpty()
        termios.tcsetwinsize(theirs, (lines, columns))
        self.stream: IO[str] = os.fdopen(theirs, "w", encoding="utf-8")
        self._written = bytearray()
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def resize(self, *, columns: int, lines: int) -> None:
        termios.tcsetwinsize(self.stream.fileno(), (lines, columns))

    def close(self) -> str:
        """Hang up; returns all that was written."""
        if not self.stream.closed:
            self.stream.close()
        self._reader.join()
        return self._written.decode("utf-8")

    def run(self, command: Sequence[str], folder: Path) -> str:
        """Run a program on it, to the end; returns all that it wrote."""
        foreign = ("PYTEST_", "GYRO_", "COV_", "COLUMNS", "LINES", "NO_COLOR")
        environment = {key: value for key, value in os.environ.items() if not key.startswith(foreign)}
        subprocess.run(
            command,
            cwd=folder,
            env={**environment, "TERM": "xterm-256color"},
            stdin=subprocess.DEVNULL,
            stdout=self.stream,
            stderr=self.stream,
            check=False,
            timeout=120,
        )
        return self.close()

    def pytest(self, folder: Path, *arguments: str) -> str:
        command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *arguments]
        return self.run(command, folder)

    def _read(self) -> None:
        while True:
            try:
                some = os.read(self._ours, 65536)
            except OSError:  # the other end is closed
                break
            if not some:
                break
            self._written += some
        os.close(self._ours)


def frames(written: str) -> list[str]:
    """Split what was written where a frame is erased; styles left out."""
    return [_STYLE.sub("", one).replace("\r\n", "\n") for one in _ERASED.split(written)]
