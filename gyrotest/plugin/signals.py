"""Signals while a spec is active: a polite end is asked for once, and held while the record is written."""

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

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
    before = {one: signal.getsignal(one) for one in _ENDING}
    request = EndRequest()
    try:
        for one in _ENDING:
            signal.signal(one, request)
    except ValueError:  # not in the main thread: whoever embeds pytest there has the signals
        return

    def restore() -> None:
        for one, handler in before.items():
            signal.signal(one, handler)

    config.add_cleanup(restore)


def hold_for_good() -> None:
    """Ignore further requests until pytest is unconfigured: it is ending already."""
    try:
        for one in _ENDING:
            signal.signal(one, signal.SIG_IGN)
    except ValueError:  # not in the main thread
        return


@contextmanager
def hold_signals() -> Iterator[None]:
    """Ignore further requests to end while the block runs."""
    before = {one: signal.getsignal(one) for one in _ENDING}
    hold_for_good()
    try:
        yield
    finally:
        for one, handler in before.items():
            if signal.getsignal(one) is not handler:
                signal.signal(one, handler)
