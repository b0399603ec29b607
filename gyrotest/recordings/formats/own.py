"""Our own recordings: a channel of them, each sample at its place on the grid."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from gyrotest.errors import RecordingError
from gyrotest.recordings.formats.selection import Part, Selection, find_column
from gyrotest.recordings.reader import iterate, read_header


def read_own(path: Path, selection: Selection) -> Iterator[Part]:
    """Yield samples of channels; the rows' numbers are positions on the grid, so that gaps show."""
    if selection.where or selection.array or selection.time_column is not None:
        raise RecordingError(f"{path}: is a recording of gyrotest; only 'column' chooses in it")
    names = read_header(path).sampling.columns
    channel = find_column(selection.column, names, path)
    beside = [find_column(one, names, path) for one in selection.beside]
    for rows in iterate(path):
        # A flagged sample is not a measured value, whatever number stands there.
        good = rows.flags == 0
        yield Part(
            row=rows.index,
            values=np.where(good, rows.values[:, channel], np.nan),
            beside=tuple(np.where(good, rows.values[:, one], np.nan) for one in beside),
        )
