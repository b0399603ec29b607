"""Sums over averages, their differences and their neighbours, from which a noise type is read.

For each averaging factor one row of sums is kept while a record goes by, in pieces of 65,536 averages
of which each has its own straight line. An average enters less the first one of its piece.
"""

import numpy as np

from gyrotest.analysis.compiled import FloatRowsOut, Floats, FloatsOut, Integers, compiled, compiled_sums

SHORTEST = 30
"""Averages that a piece needs."""

CARRIED = 3
"""Averages before a run that its differences reach back to."""

_PIECE = 65536
_RUN = 1024
_BLOCK = 32768
_TYPES = 2

# Columns of a row, for a piece: how many averages, the first one, Σu, Σk·u, Σu² and Σu·u₁, the same two of
# the differences v and of their differences w, the last three u, the first v and the first w.
_COUNT, _FIRST, _SUM, _MOMENT, _UU, _UU1, _VV, _VV1, _WW, _WW1 = range(10)
_LAST, _LAST_1, _LAST_2, _V, _W = range(10, 15)
# For all pieces that are closed: Σ of products of neighbours and of squares, differenced 0, 1, 2 times.
_CLOSED = 15
COLUMNS = 21


@compiled
def add_averages(
    angle: Floats, origin: int, begin: int, end: int, factors: Integers, rows: FloatRowsOut
) -> None:
    """Take in the averages that end after point `begin` and not after `end`; angle[0] is point `origin`.

    The angle reaches back from `begin` by the longest factor at least, or to the record's first point.
    """
    run = np.empty(CARRIED + _RUN)
    for start in range(begin, end, _BLOCK):
        stop = min(start + _BLOCK, end)
        for place in range(factors.size):
            factor = factors[place]
            _add_factor(
                angle[start // factor * factor - origin :], factor, start, stop, run, rows[place]
            )


@compiled
def _add_factor(
    corners: Floats, factor: int, start: int, stop: int, run: FloatsOut, row: FloatsOut
) -> None:
    averages = stop // factor - start // factor
    done = 0
    while done < averages:
        count = min(averages - done, run.size - CARRIED)
        begin = done * factor
        before = corners[begin]
        for k in range(count):
            after = corners[begin + (k + 1) * factor]
            run[CARRIED + k] = after - before
            before = after
        add_run(run, count, row)
        done += count


@compiled
def add_run(run: FloatsOut, count: int, row: FloatsOut) -> None:
    """Take in run[3 : 3 + count], averages times their factor; the run is used up."""
    begin = CARRIED
    while count > 0:
        taken = min(count, _PIECE - int(row[_COUNT]))
        if row[_COUNT] == 0.0:
            row[_FIRST] = run[begin]
        _add_part(run[begin - CARRIED : begin + taken], row)
        if row[_COUNT] == _PIECE:
            _close(row)
        begin += taken
        count -= taken


@compiled
def _add_part(part: FloatsOut, row: FloatsOut) -> None:
    """Take in what belongs to one piece; the first three averages of a piece lack differences."""
    part[0], part[1], part[2] = row[_LAST_2], row[_LAST_1], row[_LAST]
    for k in range(CARRIED, part.size):
        part[k] -= row[_FIRST]
    begin = CARRIED
    while begin < part.size and row[_COUNT] < CARRIED:
        _add_early(part[begin - CARRIED : begin + 1], row)
        begin += 1
    _add_sums(part[begin - CARRIED :], row)
    row[_LAST_2], row[_LAST_1], row[_LAST] = part[-3], part[-2], part[-1]


@compiled
def _add_early(part: Floats, row: FloatsOut) -> None:
    number = int(row[_COUNT])
    u, u1, u2 = part[3], part[2], part[1]
    v, v1 = u - u1, u1 - u2
    row[_SUM] += u
    row[_MOMENT] += number * u
    row[_UU] += u * u
    if number >= 1:
        row[_UU1] += u * u1
        row[_VV] += v * v
    if number == 1:
        row[_V] = v
    if number == 2:
        row[_W] = v - v1
        row[_VV1] += v * v1
        row[_WW] += (v - v1) ** 2
    row[_COUNT] += 1.0


@compiled_sums
def _add_sums(part: Floats, row: FloatsOut) -> None:
    count = part.size - CARRIED
    u0, u1, u2, u3 = part[3:], part[2:-1], part[1:-2], part[:-3]
    total = moment = uu = uu1 = vv = vv1 = ww = ww1 = 0.0
    for k in range(count):
        v, v1, v2 = u0[k] - u1[k], u1[k] - u2[k], u2[k] - u3[k]
        w, w1 = v - v1, v1 - v2
        total += u0[k]
        moment += k * u0[k]
        uu += u0[k] * u0[k]
        uu1 += u0[k] * u1[k]
        vv += v * v
        vv1 += v * v1
        ww += w * w
        ww1 += w * w1
    row[_SUM] += total
    row[_MOMENT] += moment + row[_COUNT] * total
    row[_UU] += uu
    row[_UU1] += uu1
    row[_VV] += vv
    row[_VV1] += vv1
    row[_WW] += ww
    row[_WW1] += ww1
    row[_COUNT] += count


@compiled
def _close(row: FloatsOut) -> None:
    """Add the piece's products and squares, its straight line or its mean taken out, and begin anew."""
    n, last = row[_COUNT], row[_LAST]
    if n >= SHORTEST:
        half, spread = (n - 1.0) / 2.0, n * (n * n - 1.0) / 12.0
        mean = row[_SUM] / n
        slope = (row[_MOMENT] - half * row[_SUM]) / spread
        squares = row[_UU] - n * mean * mean - slope * slope * spread
        if squares > 1e-13 * row[_UU]:  # else nothing but rounding is left
            products = row[_UU1] - mean * (2.0 * row[_SUM] - last) + (n - 1.0) * mean * mean
            products -= slope * (2.0 * slope * spread - (half + 1.0) * last)
            products += slope * slope * (spread - half * half - half)
            row[_CLOSED] += products
            row[_CLOSED + 1] += squares
        v = last - row[_LAST_1]
        _add_centred(row, 2, n - 1.0, last, row[_V], v)
        w = v - (row[_LAST_1] - row[_LAST_2])
        _add_centred(row, 4, n - 2.0, v - row[_V], row[_W], w)
    row[:_CLOSED] = 0.0


@compiled
def _add_centred(row: FloatsOut, offset: int, n: float, total: float, first: float, last: float) -> None:
    mean = total / n
    products = row[_UU1 + offset] - mean * (2.0 * total - first - last) + (n - 1.0) * mean * mean
    row[_CLOSED + offset] += products
    row[_CLOSED + 1 + offset] += row[_UU + offset] - n * mean * mean


@compiled
def identify(rows: FloatRowsOut, exponents: FloatsOut) -> None:
    """Close each row and read its noise's exponent off it: p = −2(ρ + d), ρ = r1/(1 + r1) < 1/4."""
    for place in range(rows.shape[0]):
        row = rows[place]
        _close(row)
        rho = 0.0
        for differences in range(_TYPES + 1):
            at = _CLOSED + 2 * differences
            lag_1 = row[at] / row[at + 1] if row[at + 1] > 0.0 else 0.0
            rho = lag_1 / (1.0 + lag_1)
            if rho < 0.25 or differences == _TYPES:
                exponents[place] = min(max(np.round(-2.0 * (rho + differences)), -2.0), 2.0)
                break
