"""Progress for the operator: on a terminal redrawn in place, elsewhere a line a minute.

It goes to a duplicate of the real standard output: pytest's capture holds whatever an item writes.
"""

import logging
import os
import sys
from collections.abc import Callable
from typing import IO

import pytest

from gyrotest.acquisition.progress import Coming, Progress, Silence
from gyrotest.plugin.line_progress import LineProgress
from gyrotest.plugin.live_progress import LiveProgress
from gyrotest.plugin.reading import Reading
from gyrotest.records.recording import Block, RecordingHeader
from gyrotest.records.spec import Output

_LOG = logging.getLogger(__name__)


def progress_for(config: pytest.Config, output: Output) -> Progress:
    """The progress that fits the session: none for workers and `-q`, lines where there is no terminal."""
    if hasattr(config, "workerinput") or config.get_verbosity() < 0:
        return Silence()
    if sys.__stdout__ is None:
        return Silence()
    stream = os.fdopen(os.dup(sys.__stdout__.fileno()), "w", encoding="utf-8", errors="replace")
    config.add_cleanup(stream.close)
    reading = Reading(output)
    if _redraws(stream):
        return Harmless(LiveProgress(stream, reading))
    return Harmless(LineProgress(stream, reading, real_time=config.option.gyro_real_time))


def _redraws(stream: IO[str]) -> bool:
    return stream.isatty() and os.environ.get("TERM", "").lower() not in {"dumb", "unknown"}


class Harmless:
    """Progress whose own fault ends the showing, and never the acquisition."""

    def __init__(self, shown: Progress) -> None:
        self._shown = shown

    def prepare(self, coming: Coming) -> None:
        """Make ready for an acquisition."""
        self._try(lambda: self._shown.prepare(coming))

    def begin(self, header: RecordingHeader) -> None:
        """An acquisition begins."""
        self._try(lambda: self._shown.begin(header))

    def push(self, block: Block) -> None:
        """Samples arrived."""
        self._try(lambda: self._shown.push(block))

    def note(self, text: str) -> None:
        """Something that the operator should see."""
        self._try(lambda: self._shown.note(text))

    def end(self) -> None:
        """The acquisition is over."""
        self._try(self._shown.end)

    def _try(self, step: Callable[[], None]) -> None:
        try:
            step()
        except Exception as fault:
            _LOG.warning("progress is shown no longer: %r", fault, exc_info=True)
            failed, self._shown = self._shown, Silence()
            try:
                failed.end()  # gives the cursor back
            except Exception as again:
                _LOG.debug("nor could it be ended: %r", again)
