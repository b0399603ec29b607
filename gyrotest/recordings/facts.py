"""What is known of a closed recording beside its samples."""

from dataclasses import dataclass

from gyrotest.records.recording import Dwell, Gap, RecordingHeader


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """Its header, how many rows it has, where samples are missing, and its steps."""

    header: RecordingHeader
    rows: int
    gaps: tuple[Gap, ...] = ()
    dwells: tuple[Dwell, ...] = ()
