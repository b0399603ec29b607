"""A text table's column of dates and times, as seconds since the first one."""

from datetime import datetime

from gyrotest.recordings.formats.text_head import MISSING


class Dates:
    """Reads ISO 8601 stamps, to the microsecond, all with a time zone or all without."""

    def __init__(self) -> None:
        self._origin: datetime | None = None

    def seconds(self, cell: str) -> float:
        """Return the seconds since the first stamp, NaN for a missing one; raises `ValueError`."""
        text = cell.strip()
        if text.lower() in MISSING:
            return float("nan")
        stamp = parsed(text)
        if stamp is None:
            raise ValueError(f"'{text}' is no date and time, as others are")
        origin = self._origin = self._origin or stamp
        if (stamp.tzinfo is None) != (origin.tzinfo is None):
            told = (
                "no time zone and others have one"
                if origin.tzinfo
                else "a time zone and others have none"
            )
            raise ValueError(f"'{text}' has {told}; a time may be an hour off")
        return (stamp - origin).total_seconds()


def parsed(text: str) -> datetime | None:
    """Return a date and time by ISO 8601; None of anything else."""
    try:
        return datetime.fromisoformat(text.strip())
    except ValueError:
        return None
