"""Questions to the operator, through pytest's capture."""

import shutil
import sys
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from gyrotest.errors import AcquisitionError

_REFUSALS = {"stop", "no", "n", "q"}


class Prompt:
    """Asks at the terminal; `--gyro-yes` answers everything; without a terminal it is refused."""

    def __init__(self, config: pytest.Config) -> None:
        self._capture = config.pluginmanager.getplugin("capturemanager")
        self._assume_yes = bool(config.option.gyro_yes)
        self._somebody = not _distributed(config) and self._at_terminal()

    @property
    def answered(self) -> bool:
        """Whether questions find an answer: somebody is there, or has answered them all before."""
        return self._assume_yes or self._somebody

    def confirm(self, text: str) -> None:
        """Return when the operator says that it is done; raises `AcquisitionError`."""
        if self._assume_yes:
            return
        if not self._somebody:
            raise AcquisitionError(
                f"{text}: nobody is there to do it (no terminal); say --gyro-yes if it is done"
            )
        with self._uncaptured():
            answer = _asked(f"\n{_wrapped(text)}.\nPress Enter when it is done (or type 'stop'): ")
        if answer.strip().lower() in _REFUSALS:
            raise AcquisitionError(f"{text}: stopped by the operator")

    def _at_terminal(self) -> bool:
        """Look at the real input; while pytest is configured, its capture holds nothing but that."""
        with self._uncaptured():
            found = sys.__stdin__ is not None and sys.__stdin__.isatty()
        if self._capture is not None:
            self._capture.suspend()
        return found

    @contextmanager
    def _uncaptured(self) -> Iterator[None]:
        if self._capture is None:
            yield
            return
        self._capture.suspend(in_=True)
        try:
            yield
        finally:
            self._capture.resume()


def _distributed(config: pytest.Config) -> bool:
    return hasattr(config, "workerinput") or bool(config.getoption("numprocesses", default=None))


def _wrapped(text: str) -> str:
    """Break lines between words: an instruction is read from some steps away."""
    width = shutil.get_terminal_size().columns - 1
    return textwrap.fill(text, width, break_long_words=False, break_on_hyphens=False)


def _asked(question: str) -> str:
    # Written here, not by `input`: a plain terminal's line editor scrolls a long question away.
    sys.stdout.write(question)
    sys.stdout.flush()
    try:
        return input()
    except EOFError:
        return "stop"
