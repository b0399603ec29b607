"""A record's one pass before its analysis, and its running sum."""

from gyrotest.analysis.compiled import Floats, FloatsOut, compiled, compiled_sums

STREAMS = 4
"""Parts of a record that are summed up side by side: one sum alone waits for each addition."""

_BLOCK = 1024


@compiled_sums
def scan(rate: Floats, found: FloatsOut) -> None:
    """Look at a record once: `found` becomes the size of all samples less the first, and each part's sum.

    The size, the sum of magnitudes, is 0 for a constant and not finite where a sample is not.
    """
    first, size = rate[0], 0.0
    for part in range(STREAMS):
        begin, end = part * (rate.size // STREAMS), (part + 1) * (rate.size // STREAMS)
        if part == STREAMS - 1:
            end = rate.size
        total = 0.0
        for start in range(begin, end, _BLOCK):
            block = rate[start : min(start + _BLOCK, end)]
            above, magnitude = 0.0, 0.0
            for k in range(block.size):
                above += block[k] - first
                magnitude += abs(block[k] - first)
            total += above
            size += magnitude
        found[1 + part] = total
    found[0] = size


@compiled_sums
def difference_powers(rate: Floats, every: int, found: FloatsOut) -> None:
    """Sum up powers of a record's first differences, of one block out of `every` few.

    `found` becomes the number of differences and the sums of their second and fourth powers.
    """
    found[:] = 0.0
    early, late = rate[:-1], rate[1:]
    for start in range(0, late.size, every * _BLOCK):
        stop = min(start + _BLOCK, late.size)
        second, fourth = 0.0, 0.0
        for k in range(start, stop):
            square = (late[k] - early[k]) ** 2
            second += square
            fourth += square * square
        found[0] += stop - start
        found[1] += second
        found[2] += fourth


@compiled
def running_sum(rate: Floats, sums: Floats, mean: float, angle: FloatsOut) -> None:
    """Fill in the angle, shape (n + 1,): of the rate less its mean; `sums` are each part's."""
    part = rate.size // STREAMS
    x0, x1, x2, x3 = rate[:part], rate[part:], rate[2 * part :], rate[3 * part :]
    y0, y1, y2, y3 = angle[1:], angle[1 + part :], angle[1 + 2 * part :], angle[1 + 3 * part :]
    offset, share = mean - rate[0], float(part)
    angle[0] = s0 = 0.0
    s1 = sums[0] - share * offset
    s2 = s1 + (sums[1] - share * offset)
    s3 = s2 + (sums[2] - share * offset)
    for start in range(0, part, _BLOCK):
        # Inside a block first: so the angle's rounding is not added up sample by sample.
        i0 = i1 = i2 = i3 = 0.0
        for k in range(start, min(start + _BLOCK, part)):
            i0 += x0[k] - mean
            i1 += x1[k] - mean
            i2 += x2[k] - mean
            i3 += x3[k] - mean
            y0[k] = s0 + i0
            y1[k] = s1 + i1
            y2[k] = s2 + i2
            y3[k] = s3 + i3
        s0 += i0
        s1 += i1
        s2 += i2
        s3 += i3
    for k in range(part, x3.size):
        s3 += x3[k] - mean
        y3[k] = s3
