"""Allan variances of a stream in a state that does not grow: an angle at ever wider strides.

Averaging factors up to 50 take differences that end at every sample. Above, 32, 40 and 50 times 2^l
take one that ends at every 2^l-th sample, so at least 32 an averaging time. For these, stage l keeps its
points of age 50 … 99, counted in its strides; the younger ones are those of stage l − 1 below it. Noise
types are read off the averages of 2^l samples.

A state is one array of numbers, worked on in blocks of 128 samples wherever a push begins or ends.
"""

import numpy as np

from gyrotest.analysis.compiled import (
    FloatRows,
    FloatRowsOut,
    Floats,
    FloatsOut,
    compiled,
    compiled_sums,
)
from gyrotest.analysis.kernels import lag
from gyrotest.analysis.kernels.lag import add_run

SHORT = (1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 25, 32, 40, 50)
LONG = (32, 40, 50)

STAGES = 24
"""The longest averaging factor is 50 · 2^24, a ninth of 87 days at 1 kHz."""

OCTAVES = 28
"""Averages are of 2^0 … 2^27 samples."""

BLOCK = 128
RING = 50
_BACK = 100  # samples, and strides of a stage, that differences reach back
_NOW = _BACK - 1  # where the point before a block is
_CARRIED, _COLUMNS, _FIRST = lag.CARRIED, lag.COLUMNS, lag.FIRST

# Where a state keeps what: samples in whole blocks; samples begun in a block; what is taken off each
# sample; the angle before the block, and in it; the points; sums of squares for SHORT, and for LONG a row a
# stage; a ring a stage; the angle where the last average of an octave ended; lag sums a row an octave.
DONE, BEGUN, _OFFSET, _ANGLE, _INSIDE = range(5)
_POINTS = 5
SUMS = _POINTS + _BACK + BLOCK
_LONG_SUMS = SUMS + len(SHORT)
_RINGS = _LONG_SUMS + len(LONG) * STAGES
_LAST = _RINGS + RING * STAGES
AVERAGES = _LAST + OCTAVES
SIZE = AVERAGES + lag.COLUMNS * OCTAVES


@compiled
def push(blocks: FloatRows, states: FloatRowsOut) -> int:
    """Take in a block for each state; returns the place of a sample that is not finite, else −1.

    Where there is one, in any of the rows, nothing is taken in.
    """
    for row in range(blocks.shape[0]):
        if not np.isfinite(_poison(blocks[row])):
            for place in range(blocks.shape[1]):
                if not np.isfinite(blocks[row, place]):
                    return int(row * blocks.shape[1] + place)
    for row in range(blocks.shape[0]):
        _push_row(blocks[row], states[row])
    return -1


@compiled_sums
def _poison(samples: Floats) -> float:
    total = 0.0
    for k in range(samples.size):
        total += samples[k] * 0.0
    return total


@compiled
def _push_row(block: Floats, state: FloatsOut) -> None:
    if block.size and state[DONE] == 0.0 and state[BEGUN] == 0.0:
        state[_OFFSET] = block[0]
    place = 0
    while place < block.size:
        begun = int(state[BEGUN])
        taken = min(block.size - place, BLOCK - begun)
        first = _POINTS + _BACK + begun
        _sum_up(block[place : place + taken], state, state[first : first + taken])
        place += taken
        state[BEGUN] += taken
        if begun + taken == BLOCK:
            work(state, BLOCK)
            _next_block(state)


@compiled
def _sum_up(samples: Floats, state: FloatsOut, points: FloatsOut) -> None:
    """Sum up inside the block first: so the angle's rounding is not added up sample by sample."""
    inside, offset, before = state[_INSIDE], state[_OFFSET], state[_ANGLE]
    for k in range(samples.size):
        inside += samples[k] - offset
        points[k] = before + inside
    state[_INSIDE] = inside


@compiled
def _next_block(state: FloatsOut) -> None:
    for place in range(_POINTS, _POINTS + _BACK):
        state[place] = state[place + BLOCK]
    state[_ANGLE] += state[_INSIDE]
    state[_INSIDE] = state[BEGUN] = 0.0
    state[DONE] += BLOCK
    blocks = int(state[DONE]) // BLOCK
    if blocks & (blocks - 1) == 0:
        _level(state)


@compiled
def _level(state: FloatsOut) -> None:
    """Take the mean so far off each sample, past and to come: a small angle keeps its digits."""
    done = int(state[DONE])
    offset = state[_OFFSET] + state[_ANGLE] / done
    slope = offset - state[_OFFSET]  # what is taken off the past, to the last bit
    state[_OFFSET] = offset
    state[_ANGLE] -= slope * done
    for age in range(min(done, _NOW) + 1):
        state[_POINTS + _NOW - age] -= slope * (done - age)
    for stage in range(1, STAGES + 1):
        end = done >> stage
        for point in range(max(end - _BACK + 1, 1), end - RING + 1):
            state[_RINGS + RING * (stage - 1) + point % RING] -= slope * (point << stage)
    for octave in range(OCTAVES):
        state[_LAST + octave] -= slope * (done >> octave << octave)
        state[AVERAGES + _COLUMNS * octave + _FIRST] -= slope * (1 << octave)


@compiled
def work(state: FloatsOut, count: int) -> None:
    """Take in `count` points of a block as if none came after them."""
    _add_short(state, count)
    _climb(state, count)
    _average(state, count)


@compiled
def _add_short(state: FloatsOut, count: int) -> None:
    for place in range(len(SHORT)):
        m = SHORT[place]
        begin, end = _POINTS + _BACK, _POINTS + _BACK + count
        if state[DONE] == 0.0:
            begin += 2 * m - 1
        if begin < end:
            state[SUMS + place] += _squares(state[begin - 2 * m : end], m)


@compiled_sums
def _squares(points: Floats, m: int) -> float:
    early, middle, late = points[: -2 * m], points[m:-m], points[2 * m :]
    total = 0.0
    for k in range(late.size):
        total += ((late[k] - middle[k]) - (middle[k] - early[k])) ** 2
    return total


@compiled
def _climb(state: FloatsOut, count: int) -> None:
    """Hand every second point to the first stage, and there every second one to the next."""
    for number in range(2, count + 1, 2):
        end = int(state[DONE]) + number
        here = _POINTS + _NOW + number
        late, leaving = state[here], state[here - _BACK]
        young_32, young_40 = state[here - 64], state[here - 80]
        ring, sums = _RINGS, _LONG_SUMS
        while sums < _RINGS and end & 1 == 0 and end >= _BACK:
            end >>= 1
            slot = end % RING
            entering, leaving = leaving, state[ring + slot]
            slot_64 = slot + 36 if slot < 14 else slot - 14
            slot_80 = slot + 20 if slot < 30 else slot - 30
            if end >= 64:
                state[sums] += ((late - young_32) - (young_32 - state[ring + slot_64])) ** 2
            if end >= 80:
                state[sums + 1] += ((late - young_40) - (young_40 - state[ring + slot_80])) ** 2
            if end >= _BACK:
                state[sums + 2] += ((late - entering) - (entering - leaving)) ** 2
            state[ring + slot] = entering
            young_32, young_40 = state[ring + slot_64], state[ring + slot_80]
            ring += RING
            sums += 3


@compiled
def _average(state: FloatsOut, count: int) -> None:
    run = np.empty(_CARRIED + BLOCK)
    end = int(state[DONE]) + count
    for octave in range(OCTAVES):
        averages = (end >> octave) - (int(state[DONE]) >> octave)
        if averages == 0:
            break
        before = state[_LAST + octave]
        for k in range(averages):
            after = state[
                _POINTS + _NOW + count - (end & ((1 << octave) - 1)) - ((averages - 1 - k) << octave)
            ]
            run[_CARRIED + k] = after - before
            before = after
        state[_LAST + octave] = before
        row = AVERAGES + _COLUMNS * octave
        add_run(run, averages, state[row : row + _COLUMNS])
