"""A rate table is never left turning: waiting until it rests, and the guard that outlives the run."""

import contextlib
import logging
import re
from collections.abc import Callable

from gyrotest.errors import InstrumentError
from gyrotest.instruments.exchange import Exchange
from gyrotest.instruments.guard import Guard, Orders
from gyrotest.instruments.motion import max_acceleration_dps2
from gyrotest.instruments.transport.channel import SerialLine
from gyrotest.instruments.transport.serial_port import serial_device
from gyrotest.ports import Clock
from gyrotest.records.station import Motion

AT_REST_DPS = 0.1
_GRACE_S = 3.0
_POLL_S = 0.1
_SOCKET = re.compile(r"TCPIP\d*::(?P<host>[^:]+)::(?P<port>\d+)::SOCKET", re.IGNORECASE)

_logger = logging.getLogger(__name__)


def guard_for(resource: str, line: SerialLine, commands: tuple[str, ...], *, who: str) -> Guard | None:
    """The guard of a table at this address; None, with a warning in the log, where there can be none."""
    found = _SOCKET.fullmatch(resource.strip())
    if found is not None:
        return Guard(Orders(commands=commands, host=found["host"], port=int(found["port"])))
    device = serial_device(resource)
    if device is not None:
        return Guard(Orders(commands=commands, device=device, baud_rate=line.baud_rate))
    _logger.warning(
        "%s: no guard over this interface: nothing stops the table when this process is killed;"
        " use the controller's TCP port or serial line",
        who,
    )
    return None


def start_guard(guard: Guard | None, who: str) -> None:
    """Let the guard watch; raises `InstrumentError`, before the table moves, where it cannot."""
    if guard is None:
        return
    try:
        guard.start()
    except OSError as error:
        raise InstrumentError(
            f"{who}: the process that would stop the table if this one were killed cannot be started ({error});"
            " the table is not switched on"
        ) from error


def comes_to_rest(clock: Clock, motion: Motion, rate_dps: Callable[[], float]) -> bool:
    """Wait, no longer than the run-down can take, until the table rests; whether it does.

    Raises `InstrumentError` where its rate cannot be read.
    """
    now_dps = abs(rate_dps())
    deadline_s = clock.now_s() + 2 * now_dps / max_acceleration_dps2(motion) + _GRACE_S
    while now_dps > AT_REST_DPS and clock.now_s() < deadline_s:
        clock.sleep_until(clock.now_s() + _POLL_S)
        now_dps = abs(rate_dps())
    return now_dps <= AT_REST_DPS


def stop_surely(exchange: Exchange, send_stop: Callable[[], None], guard: Guard | None) -> None:
    """Stop over the connection, over a new one, or by the guard, whichever can be done first. Never raises."""
    exchange.forget()
    with contextlib.suppress(InstrumentError):
        send_stop()
        return
    with contextlib.suppress(InstrumentError):
        exchange.open()
        send_stop()
        return
    if guard is not None:
        exchange.close()
        guard.call()


def seen_at_rest(clock: Clock, motion: Motion, rate_dps: Callable[[], float]) -> bool:
    """Wait until the table rests; whether it was seen to. Never raises."""
    with contextlib.suppress(InstrumentError):
        return comes_to_rest(clock, motion, rate_dps)
    return False


def dismiss(guard: Guard | None, *, at_rest: bool) -> None:
    """The connection is closed: the guard may go, or has to do what could not be done over it. Never raises."""
    if guard is None:
        return
    if at_rest:
        guard.release()
    else:
        guard.call()
