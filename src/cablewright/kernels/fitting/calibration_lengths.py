"""Cable lengths and wrenches of a calibration's lines at poses, and the compliance of their ends."""

from cablewright.kernels import jit
from cablewright.kernels.dense_systems import copy
from cablewright.kernels.fitting.calibration_residuals import place_unknowns, reading, reading_of
from cablewright.kernels.fitting.guided_path import place_guided
from cablewright.kernels.fitting.line_over_sheave import SPANS, per_tension
from cablewright.kernels.fitting.line_rows import draw
from cablewright.kernels.rotation import cross
from cablewright.kernels.statics.platform import place_platform


@jit(allocates=True)
def lengths_at(rows, theta, poses, lengths):
    """Write *lengths* (N, m) of cable beyond the exit point, m, at *poses* (N, n); NaN inside a sheave."""
    work = reading(rows)
    place_unknowns(rows, theta, work)
    for j in range(poses.shape[0]):
        place_platform(poses[j], work.rotation)
        for i in range(lengths.shape[1]):
            draw(rows.guided, work, i, poses[j])
            lengths[j, i] = work.lines[i, SPANS] * work.free[0]


@jit(allocates=True)
def given_at(rows, theta, poses, given):
    """Write the compliance of the ends (mount and spring) of each line, m of cable per tension, (N, m), m/N.

    *poses* (N, n).
    """
    work = reading(rows)
    place_unknowns(rows, theta, work)
    for j in range(poses.shape[0]):
        place_platform(poses[j], work.rotation)
        for i in range(given.shape[1]):
            draw(rows.guided, work, i, poses[j])
            given[j, i] = per_tension(work.lines[i], work.free)


@jit(allocates=True)
def wrenches_at(guided, lines, poses, wrenches):
    """Write the directions of the straight cables and their moments about the platform's origin to *wrenches*.

    *wrenches* (N, m, 6): minus the wrench of a unit tension; NaN inside a sheave. *lines* (m, COLUMNS) and *guided*:
    see `MeasurementRows`; *poses* (N, n).
    """
    work = reading_of(lines.shape[0], 0)
    for i in range(lines.shape[0]):
        copy(lines[i], work.lines[i])
    place_guided(guided, work.lines, work.path)
    for j in range(poses.shape[0]):
        place_platform(poses[j], work.rotation)
        for i in range(lines.shape[0]):
            ax, ay, az = draw(guided, work, i, poses[j])
            x, y, z = work.free[1], work.free[2], work.free[3]
            found = wrenches[j, i]
            found[0], found[1], found[2] = x, y, z
            found[3], found[4], found[5] = cross(ax, ay, az, x, y, z)
