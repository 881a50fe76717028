"""Rows of numbers by rising time, between which a straight line is taken."""

from cablewright.kernels import jit


@jit
def interpolate(known, rows, times, found):
    """Write the rows *found* (k, width) at *times* (k,), s, between the *rows* (n, width) at *known* (n,), s, n > 0.

    They are those at both ends for times beyond these.
    """
    last = known.shape[0] - 1
    for k in range(times.shape[0]):
        low, high = 0, last  # the first time that is not earlier lies between, or is the last one
        while low < high:
            middle = (low + high) // 2
            if known[middle] < times[k]:
                low = middle + 1
            else:
                high = middle
        before = max(low - 1, 0)
        span = known[low] - known[before]
        share = min(max((times[k] - known[before]) / (span if span > 0.0 else 1.0), 0.0), 1.0)
        for j in range(rows.shape[1]):
            found[k, j] = rows[before, j] + share * (rows[low, j] - rows[before, j])
