"""Material laid along straight pieces onto a field of heights: it fills the lowest cells about each first."""

from math import floor, hypot, inf

import numpy as np

from cablewright.kernels import jit

WIDER = 1.5  # growth factor of a window that is too small


@jit(allocates=True)
def lay(heights, low, cell, start, end, volumes, steep, half, reach, slide):
    """Lay *volumes* (k,), m^3, along k straight pieces in the field, from *start* to *end*, (k, 2) m.

    *heights* (nx, ny), m: of cells of a side *cell*, m, from the corner *low* (2,), m, on; in place. A cell counts as
    higher by *steep* times its distance from the piece; if *half* is over 0, m, as no cell beyond that distance. Each
    piece spreads over *reach* (k,), m, and farther by *slide* times the height below it.
    """
    for k in range(volumes.shape[0]):
        if not volumes[k] > 0.0:
            continue
        under = 0.0
        for place in (start[k], end[k]):
            under = max(under, heights[_cell(place[0], low[0], cell), _cell(place[1], low[1], cell)])
        far, amount = reach[k] + slide * under, volumes[k] / cell**2
        while not _fill(heights, low, cell, start[k], end[k], amount, steep, half, far):
            far *= WIDER


@jit
def _cell(place, low, cell):
    """Return the index of the cell at a *place* along an axis, m."""
    return floor((place - low) / cell)


@jit(allocates=True)
def _fill(heights, low, cell, start, end, amount, steep, half, far):
    """Fill a window about a piece with an *amount*, m of height of all cells together.

    Returns False, and changes nothing, if that comes to a rim of the window that is no edge of the field.
    """
    nx, ny = heights.shape
    i0 = max(_cell(min(start[0], end[0]) - far, low[0], cell) - 1, 0)
    j0 = max(_cell(min(start[1], end[1]) - far, low[1], cell) - 1, 0)
    i1 = min(_cell(max(start[0], end[0]) + far, low[0], cell) + 2, nx)
    j1 = min(_cell(max(start[1], end[1]) + far, low[1], cell) + 2, ny)
    counts = np.empty((i1 - i0, j1 - j0))
    along, across = end[0] - start[0], end[1] - start[1]
    square = along * along + across * across
    for i in range(i0, i1):
        x = low[0] + cell * (i + 0.5) - start[0]
        for j in range(j0, j1):
            y = low[1] + cell * (j + 0.5) - start[1]
            share = min(max((x * along + y * across) / square, 0.0), 1.0) if square > 0.0 else 0.0
            away = hypot(x - share * along, y - share * across)
            higher = steep * away if half <= 0.0 else (0.0 if away <= half else inf)
            counts[i - i0, j - j0] = heights[i, j] + higher
    level = _level(counts, amount)
    for i in range(i0, i1):
        for j in range(j0, j1):
            rim = (i == i0 > 0) or (j == j0 > 0) or (i == i1 - 1 < nx - 1) or (j == j1 - 1 < ny - 1)
            if rim and level > counts[i - i0, j - j0]:
                return False
    for i in range(i0, i1):
        for j in range(j0, j1):
            heights[i, j] += max(0.0, level - counts[i - i0, j - j0])
    return True


@jit
def _level(counts, amount):
    """Return the level to which an *amount* fills cells of heights *counts*, m; those of infinite height stay empty.

    Cells over the level that all together would have are left out, until none is: the level only falls.
    """
    level = inf
    while True:
        total, covered = amount, 0
        for i in range(counts.shape[0]):
            for j in range(counts.shape[1]):
                if counts[i, j] < level:
                    total += counts[i, j]
                    covered += 1
        if covered == 0 or not total / covered < level:
            return level
        level = total / covered
