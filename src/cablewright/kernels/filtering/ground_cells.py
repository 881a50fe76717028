"""Cells of the ground: heights that the vertical lidar has seen, the nozzle's path near each, what is expected there.

All numbers of the cells are 0 at first, so that the system provides memory only where ground is seen.
"""

from math import floor, isnan, nan

import numpy as np

from cablewright.kernels import jit
from cablewright.kernels.fitting.scan_lines import median

CELL = 0.025  # m
SIDE = 1024  # cells; places that are 25.6 m apart share one, which knows whose it is
TILE = 16  # cells: squares whose cells are one after another, so that what lies together is in few pages of memory

# Columns of a cell's integers: which of the squares that share it has it now, 0: none yet; its number during `write`.
OWNER, NUMBER, MARKS = 0, 1, 2
# Columns of a cell's numbers: height over the floor as last seen, m, NaN: never; m by which it rises for each metre of
# path, NaN: as all; m of the nozzle's path so near that it lays there, and so near that the foot of its material comes
# there; the latter, and m that the nozzle had gone, when the cell was last seen.
HEIGHT, GROWTH, LAID, PATH, PATH_SEEN, SEEN_AT, KEPT = 0, 1, 2, 3, 4, 5, 6

FLOOR = 5e-3  # m, of ground that nothing was laid on
FOOT_PATH = 2.0  # m of path since the floor was seen, whose foot may have come as far
RECENT = 0.5  # m that the nozzle has gone since ground was seen, in which it is as it was
GROWS = 3e-4  # m for each metre of path, from which something is laid
MAX_GROWTH = 0.02  # m by which ground may have grown, to be known
MAX_RISE = 0.03  # m, of ground that was seen again, and not of who stands on it or of a wall
MIN_PATH = 0.5  # m of path, of ground that shows how fast it grows ...
MIN_POINTS = 16  # ... and so many points of it
GAIN = 0.05  # of each time it was seen, in how fast the ground grows on average
OWN_PATH = 6.0  # m of path near a cell, over which its own growth is averaged


@jit
def _cell(x, y):
    """Cell of a position, m, and which of the squares that share the cell it belongs to: an odd number."""
    row, column = floor(x / CELL), floor(y / CELL)
    square = (row // SIDE) * 40_009 + column // SIDE
    tile = (row % SIDE // TILE) * (SIDE // TILE) + column % SIDE // TILE
    return (tile * TILE + row % TILE) * TILE + column % TILE, (2 * square + 1) & 0x7FFFFFFF


@jit
def _own(marks, kept, x, y):
    """Return the cell of a position, which from now on is that of no other places."""
    cell, owner = _cell(x, y)
    if marks[cell, OWNER] != owner:
        marks[cell, OWNER] = owner
        kept[cell], kept[cell, HEIGHT], kept[cell, GROWTH] = 0.0, nan, nan
    return cell


@jit
def look_up(marks, kept, places, growth, gone, heights, grown, known, may_be_floor, was_floor):
    """Write what is expected at *places* (k, 2), m, world: heights, and by how much they may have grown, (k,), m.

    *known*, *may_be_floor*, *was_floor* (k,): see `KnownGround`. *growth*: m by which ground rises on average for each
    metre of path; *gone*: m, by the nozzle. *marks*, *kept*: cells, see MARKS and KEPT.
    """
    for i in range(places.shape[0]):
        cell, owner = _cell(places[i, 0], places[i, 1])
        ours, height, own = marks[cell, OWNER] == owner, float(kept[cell, HEIGHT]), float(kept[cell, GROWTH])
        path = float(kept[cell, PATH]) - float(kept[cell, PATH_SEEN]) if ours else 0.0
        rate = growth if isnan(own) or not ours else own
        heights[i], grown[i] = height + rate * path if ours else nan, max(rate, growth) * path
        known[i] = ours and not isnan(height) and grown[i] <= MAX_GROWTH
        as_it_was = kept[cell, LAID] == 0.0 and path <= FOOT_PATH
        may_be_floor[i] = not ours or ((as_it_was or growth < GROWS) and not height > FLOOR)  # NaN: never seen
        was_floor[i] = ours and height < FLOOR and gone - kept[cell, SEEN_AT] < RECENT


@jit
def go(marks, kept, before, x, y, steps, length, near, column):
    """Add the nozzle's straight path, *steps* of a *length*, m, from *before* (2) to (x, y), m, world, to a *column*.

    Of the cells at offsets *near* (d, 2), m, from each step.
    """
    for i in range(steps):
        share = 1.0 - i * (1.0 / steps)
        there_x, there_y = before[0] + share * (x - before[0]), before[1] + share * (y - before[1])
        for j in range(near.shape[0]):
            kept[_own(marks, kept, there_x + near[j, 0], there_y + near[j, 1]), column] += length


@jit(allocates=True)
def write(marks, kept, places, heights, growth, gone):
    """Store the *heights* (k,), m, of the ground at *places* (k, 2), m, world: in each cell the mean of its points.

    Returns how fast ground grows on average, learnt from points on ground that was seen before; see `look_up`.
    """
    k = places.shape[0]
    rates, scratch, cells, sums, counts = np.empty(k), np.empty(k), np.empty(k, np.int64), np.zeros(k), np.zeros(k)
    old, found = 0, 0
    for i in range(k):
        cell = _own(marks, kept, places[i, 0], places[i, 1])
        rise, path = heights[i] - kept[cell, HEIGHT], kept[cell, PATH] - kept[cell, PATH_SEEN]
        if path > MIN_PATH and abs(rise) < MAX_RISE:
            rates[old] = rise / path
            old += 1
        if marks[cell, NUMBER] == 0:
            cells[found] = cell
            found += 1
            marks[cell, NUMBER] = found
        sums[marks[cell, NUMBER] - 1] += heights[i]
        counts[marks[cell, NUMBER] - 1] += 1.0
    if old >= MIN_POINTS:
        growth = max(0.0, growth + GAIN * (median(rates, old, scratch) - growth))
    for j in range(found):
        cell, seen = cells[j], sums[j] / counts[j]
        rise, path, own = seen - kept[cell, HEIGHT], kept[cell, PATH] - kept[cell, PATH_SEEN], kept[cell, GROWTH]
        if path > 0.0 and abs(rise) < MAX_RISE:
            kept[cell, GROWTH] = (rise + OWN_PATH * (growth if isnan(own) else own)) / (path + OWN_PATH)
        kept[cell, HEIGHT], kept[cell, PATH_SEEN], kept[cell, SEEN_AT] = seen, kept[cell, PATH], gone
        marks[cell, NUMBER] = 0
    return growth
