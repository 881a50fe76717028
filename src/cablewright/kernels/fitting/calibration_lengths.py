"""Cable lengths of a calibration's lines at poses, and the compliance of their ends."""

from cablewright.kernels import jit
from cablewright.kernels.fitting.calibration_residuals import place_unknowns, platform_arm, reading
from cablewright.kernels.fitting.line_over_sheave import SPANS, over_sheave, per_tension
from cablewright.kernels.statics.platform import place_platform


@jit(allocates=True)
def lengths_at(rows, theta, poses, lengths):
    """Write *lengths* (N, m) of cable beyond the exit point, m, at *poses* (N, n); NaN inside a sheave."""
    work = reading(rows)
    place_unknowns(rows, theta, work)
    for j in range(poses.shape[0]):
        place_platform(poses[j], work.rotation)
        for i in range(lengths.shape[1]):
            ax, ay, az = platform_arm(work, i)
            over_sheave(work.lines[i], poses[j, 0] + ax, poses[j, 1] + ay, poses[j, 2] + az, work.free)
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
            ax, ay, az = platform_arm(work, i)
            over_sheave(work.lines[i], poses[j, 0] + ax, poses[j, 1] + ay, poses[j, 2] + az, work.free)
            given[j, i] = per_tension(work.lines[i], work.free)
