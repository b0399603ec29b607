"""Signals while a spec is active: a polite end is asked for once, and held while the record is written."""

import signal
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from types import FrameType
from typing import Any

import pytest

_ENDING = tuple(
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
    if hasattr(signal, name)
)
_SAME_REQUEST_S = 2.0


class EndRequest:
    """Handles a signal as Ctrl-C; one that follows at once is the same request and disturbs nothing."""

    def __init__(self) -> None:
        self._last_s = float("-inf")

    def __call__(self, number: int, _frame: FrameType | None) -> None:
        """Raise `KeyboardInterrupt` naming the signal."""
        now_s = time.monotonic()
        if now_s - self._last_s < _SAME_REQUEST_S:
            return
        self._last_s = now_s
        raise KeyboardInterrupt(signal.Signals(number).name)


def install_signals(config: pytest.Config) -> None:
    """Let SIGTERM, SIGHUP and SIGBREAK act as Ctrl-C does, until pytest is unconfigured."""
    before = _handlers()
    if _set(dict.fromkeys(_ENDING, EndRequest())):
        config.add_cleanup(partial(_restore, before))


def _restore(before: Mapping[signal.Signals, Any]) -> None:
    _set(before)


def hold_for_good() -> None:
    """Ignore further requests until pytest is unconfigured: it is ending already."""
    _set(dict.fromkeys(_ENDING, signal.SIG_IGN))


@contextmanager
def hold_signals() -> Iterator[None]:
    """Ignore further requests to end while the block runs."""
    before = _handlers()
    hold_for_good()
    try:
        yield
    finally:
        _set(before)


def _handlers() -> dict[signal.Signals, Any]:
    """The handlers by signal; those that were not set from Python cannot be set again."""
    found = {one: signal.getsignal(one) for one in _ENDING}
    return {one: handler for one, handler in found.items() if handler is not None}


def _set(handlers: Mapping[signal.Signals, Any]) -> bool:
    """Set handlers; outside the main thread whoever embeds pytest there has the signals."""
    try:
        for one, handler in handlers.items():
            signal.signal(one, handler)
    except ValueError:
        return False
    return True
