"""The exception tree: everything that gyrotest raises on purpose is a `GyrotestError`.

A message says who, what, found, expected (with units) and the next step, in one or two lines.
"""

from collections.abc import Sequence
from dataclasses import dataclass


class GyrotestError(Exception):
    """Root of all errors raised on purpose; its text is meant for the person at the bench."""


@dataclass(frozen=True, slots=True)
class Fault:
    """One complaint about a file: `path:line: key: message`."""

    path: str
    line: int | None
    key: str
    message: str

    def __str__(self) -> str:
        place = self.path if self.line is None else f"{self.path}:{self.line}"
        return ": ".join(part for part in (place, self.key, self.message) if part)


class DocumentError(GyrotestError):
    """A YAML document is refused; carries all its faults at once."""

    def __init__(self, faults: Sequence[Fault]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(str(fault) for fault in self.faults))


class SpecError(DocumentError):
    """A gyro spec is refused."""


class StationError(DocumentError):
    """A station file is refused."""


class UnitError(GyrotestError):
    """A text is no quantity, or not of the dimension that is asked for."""


class RefusedError(GyrotestError):
    """A run is refused before it starts (serial number, calibration, output folder, Pango, …)."""


class InstrumentError(GyrotestError):
    """An instrument, or the way to it, misbehaves. The message begins with the resource."""


class InstrumentTimeoutError(InstrumentError):
    """No reply within the time-out."""


class InstrumentProtocolError(InstrumentError):
    """A reply that is not what the protocol promises, or an entry in the error queue."""


class InstrumentIdentityError(InstrumentError):
    """Another instrument than the station file names answers at the address."""


class OverloadError(InstrumentError):
    """The indication is an overload or not a number."""


class AcquisitionError(GyrotestError):
    """An acquisition could not be finished; what was recorded is kept."""


class RecordingError(GyrotestError):
    """A recorded file cannot be read, or cannot be written."""


class InsufficientDataError(GyrotestError):
    """Too little, or unsuitable, data for the analysis asked for."""


class CertificateError(GyrotestError):
    """The certificate or the run record cannot be made or checked."""
