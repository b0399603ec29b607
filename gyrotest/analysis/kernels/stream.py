"""The angle of streams, appended to the points that are still needed."""

import numpy as np

from gyrotest.analysis.compiled import FloatRows, FloatRowsOut, compiled

OFFSET, ANGLE, INSIDE, FIRST, UNLIKE = range(5)
"""Columns of a stream's end: what is taken off each sample, the angle before the last thousand samples
and in them, the first sample, how many samples are unlike it."""
COLUMNS = 5

_BLOCK = 1024


@compiled
def first_not_finite(rows: FloatRows) -> int:
    """Return the place, row after row, of the first value that is no finite number, or −1."""
    for row in range(rows.shape[0]):
        for place in range(rows.shape[1]):
            if not np.isfinite(rows[row, place]):
                return int(row * rows.shape[1] + place)
    return -1


@compiled
def append(
    rows: FloatRows,
    begin: int,
    end: int,
    count: int,
    points: FloatRowsOut,
    fill: int,
    ends: FloatRowsOut,
) -> None:
    """Sum samples begin … end of each row up into points[row, fill:]; `count` were there before."""
    for row in range(rows.shape[0]):
        offset, before, inside = ends[row, OFFSET], ends[row, ANGLE], ends[row, INSIDE]
        first, unlike = ends[row, FIRST], 0
        samples, target = rows[row, begin:end], points[row, fill : fill + end - begin]
        for place in range(samples.size):
            if (count + place) % _BLOCK == 0:
                before += inside
                inside = 0.0
            inside += samples[place] - offset
            target[place] = before + inside
            unlike += samples[place] != first
        ends[row, ANGLE], ends[row, INSIDE] = before, inside
        ends[row, UNLIKE] += unlike


@compiled
def level(
    points: FloatRowsOut, fill: int, origin: int, slopes: FloatRowsOut, ends: FloatRowsOut
) -> None:
    """Take the mean so far off each sample, past and to come: a small angle keeps its digits."""
    done = origin + fill - 1
    for row in range(points.shape[0]):
        angle = ends[row, ANGLE] + ends[row, INSIDE]
        offset = ends[row, OFFSET] + angle / done
        slope = offset - ends[row, OFFSET]  # what is taken off the past, to the last bit
        for place in range(fill):
            points[row, place] -= slope * (origin + place)
        ends[row, OFFSET], ends[row, ANGLE], ends[row, INSIDE] = offset, angle - slope * done, 0.0
        slopes[row, 0] = slope
