"""Signals while a spec is active: a polite end is asked for once, and held while the record is written."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

import pytest

_ENDING = tuple(
    getattr(signal, name) for name in ("SIGTERM", "SIGHUP", "SIGBREAK") if hasattr(signal, name)
)


def install_signals(config: pytest.Config) -> None:
    """Let SIGTERM, SIGHUP and SIGBREAK act as Ctrl-C does, until pytest is unconfigured."""
    before = {one: signal.getsignal(one) for one in _ENDING}
    try:
        for one in _ENDING:
            signal.signal(one, _interrupt)
    except ValueError:  # not in the main thread: whoever embeds pytest there has the signals
        return

    def restore() -> None:
        for one, handler in before.items():
            signal.signal(one, handler)

    config.add_cleanup(restore)


def _interrupt(number: int, _frame: FrameType | None) -> None:
    raise KeyboardInterrupt(signal.Signals(number).name)


@contextmanager
def hold_signals() -> Iterator[None]:
    """Ignore further requests to end while the block runs."""
    held = (signal.SIGINT, *_ENDING)
    try:
        before = {one: signal.signal(one, signal.SIG_IGN) for one in held}
    except ValueError:  # not in the main thread
        yield
        return
    try:
        yield
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)
