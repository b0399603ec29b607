"""Arrow's columns of dates and times, or of durations, as seconds since the first one."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

_A_SECOND = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}


def are_dates(of: Any) -> bool:
    """Whether an Arrow type counts time from somewhere."""
    import pyarrow as pa

    return bool(pa.types.is_timestamp(of) or pa.types.is_duration(of))


class Dates:
    """Turns one block after another into seconds; differences are taken before anything is rounded."""

    def __init__(self) -> None:
        self._origin: int | None = None

    def seconds(self, column: Any) -> NDArray[np.float64]:
        """Return the seconds since the first stamp of all blocks, NaN for missing ones."""
        import pyarrow as pa

        known = column.is_valid().to_numpy(zero_copy_only=False)
        ticks = column.cast(pa.int64()).fill_null(0).to_numpy(zero_copy_only=False)
        if self._origin is None and known.any():
            self._origin = int(ticks[known][0])
        seconds: NDArray[np.float64] = (ticks - (self._origin or 0)) / _A_SECOND[column.type.unit]
        seconds[~known] = np.nan
        return seconds
