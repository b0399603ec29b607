"""The door to NI's library: imported when it is needed, its errors told in our words."""

import contextlib
import importlib
from collections.abc import Iterator
from typing import Any

from gyrotest.errors import InstrumentError, InstrumentTimeoutError

# NI-DAQmx status codes: the program was too slow, or the bus; nothing came in time; and two at the beginning.
OVERRUNS = frozenset({-200279, -200222, -200361})
NOT_YET = -200284
_NO_DEVICE = -200220
_RESERVED = -50103
_HINTS = {
    -200279: "samples were overwritten before they were fetched: lessen the computer's load or the rate",
    -200222: "samples were about to be overwritten before they were fetched: lessen the computer's load",
    -200361: "the device's memory ran over: connect it directly, or sample more slowly",
    _NO_DEVICE: "is the device there under this name? look into NI MAX",
    _RESERVED: "another program uses the device: end that one",
    -200077: "a value is beyond what the device has: look at range, wiring and the case's interval",
    -200081: "the device cannot sample so fast: lengthen the case's interval or use fewer channels",
    -200170: "there is no such terminal: look at terminals",
}


class OverrunError(InstrumentError):
    """Samples were lost because they were not fetched in time; the device has stopped."""


class Library:
    """The modules of `nidaqmx` that are used; raises `InstrumentError` where it is not installed."""

    def __init__(self, who: str) -> None:
        try:
            self.nidaqmx: Any = importlib.import_module("nidaqmx")
            self.constants: Any = importlib.import_module("nidaqmx.constants")
            self.errors: Any = importlib.import_module("nidaqmx.errors")
            self.readers: Any = importlib.import_module("nidaqmx.stream_readers")
            self.system: Any = importlib.import_module("nidaqmx.system")
        except ImportError as error:
            raise InstrumentError(
                f"{who}: the Python package 'nidaqmx' cannot be imported ({error}); install it with"
                " pip install 'gyrotest[ni]'"
            ) from error

    @contextlib.contextmanager
    def told(self, who: str, doing: str) -> Iterator[None]:
        """Turn the library's errors into `InstrumentError`, or a subclass that fits."""
        try:
            yield
        except self.errors.DaqError as error:
            raise _failure(who, doing, str(error), int(error.error_code)) from error
        except (self.errors.DaqNotFoundError, self.errors.DaqNotSupportedError) as error:
            raise InstrumentError(
                f"{who}: NI's driver NI-DAQmx is not on this computer ({_first_line(str(error))}); install"
                " it from ni.com/downloads: the Python package alone does not speak to devices"
            ) from error
        except self.errors.Error as error:
            raise InstrumentError(f"{who}: {doing}: {_first_line(str(error))}") from error


def _failure(who: str, doing: str, text: str, code: int) -> InstrumentError:
    hint = f"; {_HINTS[code]}" if code in _HINTS else ""
    message = f"{who}: {doing}: {_first_line(text)} (NI-DAQmx {code}){hint}"
    if code in OVERRUNS:
        return OverrunError(message)
    return InstrumentTimeoutError(message) if code == NOT_YET else InstrumentError(message)


def _first_line(text: str) -> str:
    return text.strip().split("\n")[0].rstrip(". ")
