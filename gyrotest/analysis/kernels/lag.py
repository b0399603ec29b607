"""Sums over averages, their differences and their neighbours, from which a noise type is read.

For each averaging factor one row of sums is kept while a record goes by, in pieces of 65,536 averages
of which each has its own straight line. An average enters less the first one of its piece.
"""

import numpy as np

from gyrotest.analysis.compiled import FloatRowsOut, Floats, FloatsOut, Integers, compiled, compiled_sums

SHORTEST = 30
"""Averages that a piece needs."""

CARRIED = 2
"""Averages before a run that its differences reach back to."""

_PIECE = 65536
_RUN = 1024
_BLOCK = 32768
_WORTH_VECTORS = 8

# Columns of a row, for a piece: how many averages, the first one, Σu, Σk·u, Σu² and Σu·u₁, the same two of
# the differences v, the last two u, the first v.
_COUNT, FIRST, _SUM, _MOMENT, _UU, _UU1, _VV, _VV1, _LAST, _LAST_1, _V = range(11)
# For all pieces that are closed: Σ of products of neighbours and of squares, then these of the differences.
_CLOSED = 11
COLUMNS = 15


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
    """Take in run[2 : 2 + count], averages times their factor; the run is used up."""
    begin = CARRIED
    while count > 0:
        taken = min(count, _PIECE - int(row[_COUNT]))
        if row[_COUNT] == 0.0:
            row[FIRST] = run[begin]
        _add_part(run[begin - CARRIED : begin + taken], row)
        if row[_COUNT] == _PIECE:
            _close(row)
        begin += taken
        count -= taken


@compiled
def _add_part(part: FloatsOut, row: FloatsOut) -> None:
    """Take in what belongs to one piece; its first two averages lack a difference before them."""
    part[0], part[1] = row[_LAST_1], row[_LAST]
    first = row[FIRST]
    for k in range(CARRIED, part.size):
        part[k] -= first
    begin = CARRIED
    while begin < part.size and row[_COUNT] < CARRIED:
        _add_early(part[begin], part[begin - 1], row)
        begin += 1
    if part.size - begin >= _WORTH_VECTORS:
        _add_sums(part[begin - CARRIED :], row)
    else:
        for k in range(begin, part.size):
            _add_one(part[k], part[k - 1], part[k - 2], row)
    row[_LAST_1], row[_LAST] = part[-2], part[-1]


@compiled
def _add_early(u: float, before: float, row: FloatsOut) -> None:
    number = row[_COUNT]
    row[_SUM] += u
    row[_MOMENT] += number * u
    row[_UU] += u * u
    if number > 0.0:
        row[_UU1] += u * before
        row[_V] = u - before
        row[_VV] += row[_V] ** 2
    row[_COUNT] += 1.0


@compiled
def _add_one(u: float, u1: float, u2: float, row: FloatsOut) -> None:
    row[_SUM] += u
    row[_MOMENT] += row[_COUNT] * u
    row[_UU] += u * u
    row[_UU1] += u * u1
    row[_VV] += (u - u1) ** 2
    row[_VV1] += (u - u1) * (u1 - u2)
    row[_COUNT] += 1.0


@compiled_sums
def _add_sums(part: Floats, row: FloatsOut) -> None:
    count = part.size - CARRIED
    u0, u1, u2 = part[2:], part[1:-1], part[:-2]
    total = moment = uu = uu1 = vv = vv1 = 0.0
    for k in range(count):
        v, v1 = u0[k] - u1[k], u1[k] - u2[k]
        total += u0[k]
        moment += k * u0[k]
        uu += u0[k] * u0[k]
        uu1 += u0[k] * u1[k]
        vv += v * v
        vv1 += v * v1
    row[_SUM] += total
    row[_MOMENT] += moment + row[_COUNT] * total
    row[_UU] += uu
    row[_UU1] += uu1
    row[_VV] += vv
    row[_VV1] += vv1
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
        mean = last / (n - 1.0)
        products = row[_VV1] - mean * (2.0 * last - row[_V] - (last - row[_LAST_1]))
        row[_CLOSED + 2] += products + (n - 2.0) * mean * mean
        row[_CLOSED + 3] += row[_VV] - (n - 1.0) * mean * mean
    row[:_CLOSED] = 0.0


@compiled
def identify(rows: FloatRowsOut, exponents: FloatsOut) -> None:
    """Close each row and read its noise's exponent off it: p = −2(ρ + d), ρ = r1/(1 + r1) < 1/4.

    Averages that even their differences (d = 1) do not bring below 1/4 are a rate random walk's or
    worse, −2.
    """
    for place in range(rows.shape[0]):
        row = rows[place]
        _close(row)
        exponents[place] = -2.0
        for differences in range(2):
            products, squares = row[_CLOSED + 2 * differences], row[_CLOSED + 1 + 2 * differences]
            lag_1 = products / squares if squares > 0.0 else 0.0
            rho = lag_1 / (1.0 + lag_1)
            if rho < 0.25:
                exponents[place] = min(max(np.round(-2.0 * (rho + differences)), -2.0), 2.0)
                break
