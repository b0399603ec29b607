"""Questions to the operator, through pytest's capture."""

import sys

import pytest

from gyrotest.errors import AcquisitionError


class Prompt:
    """Asks at the terminal; `--gyro-yes` answers everything; without a terminal it is refused."""

    def __init__(self, config: pytest.Config, *, assume_yes: bool) -> None:
        self._config = config
        self._assume_yes = assume_yes

    @staticmethod
    def possible(config: pytest.Config) -> bool:
        """Whether there is somebody to ask: a terminal, and no distribution over processes."""
        distributed = hasattr(config, "workerinput") or bool(
            config.getoption("numprocesses", default=None)
        )
        return sys.__stdin__ is not None and sys.__stdin__.isatty() and not distributed

    def confirm(self, text: str) -> None:
        """Return when the operator says that it is done; raises `AcquisitionError`."""
        if self._assume_yes:
            return
        if not self.possible(self._config):
            raise AcquisitionError(
                f"{text}: nobody is there to do it (no terminal); say --gyro-yes if it is done"
            )
        if self._answer(f"\n{text}; then press Enter (or type 'stop'): ").strip().lower() in {
            "stop",
            "no",
            "n",
            "q",
        }:
            raise AcquisitionError(f"{text}: stopped by the operator")

    def _answer(self, question: str) -> str:
        capture = self._config.pluginmanager.getplugin("capturemanager")
        if capture is None:
            return _asked(question)
        capture.suspend(in_=True)
        try:
            return _asked(question)
        finally:
            capture.resume()


def _asked(question: str) -> str:
    try:
        return input(question)
    except EOFError:
        return "stop"
