"""Layout of the kernels' arrays: columns of a line, entries of the platform, unknowns of a line; status codes."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit


class Code(IntEnum):
    """Status code of one solve. `cablewright.errors.Status` has the sentences shown to users."""

    OK = 0
    NOT_CONVERGED = 1
    SINGULAR = 2
    NOT_FINITE = 3
    UNDER_EXIT = 4
    INSIDE_SHEAVE = 5
    BAD_WRAP = 6
    INFEASIBLE = 7
    OVERSTRETCHED = 8
    LEVER_UNSTABLE = 9
    UNSTABLE = 10
    JUMPED = 11
    FOLD = 12
    UNCERTIFIED = 13


# The same as plain integers: compiled kernels return these.
OK, NOT_CONVERGED, SINGULAR, NOT_FINITE, UNDER_EXIT, INSIDE_SHEAVE, BAD_WRAP, INFEASIBLE = map(int, list(Code)[:8])
OVERSTRETCHED, LEVER_UNSTABLE, UNSTABLE, JUMPED, FOLD, UNCERTIFIED = map(int, list(Code)[8:])


# Columns of `Packed.lines`. Lengths in m, forces in N, weights in N/m, compliances 1/EA in 1/N.
EXIT_X, EXIT_Y, EXIT_Z = 0, 1, 2  # exit point A, world
POINT_X, POINT_Y, POINT_Z = 3, 4, 5  # platform point B, platform frame
RADIUS, LEVER, LEVER_MOMENT = 6, 7, 8  # lever moment: weight times its distance from A, N m
SIDE = 9  # +1 the cable passes over the sheave, -1 under it
WINCH_X, WINCH_Z = 10, 11  # winch exit C from A in the plane of the dead span: horizontal distance, height
DEAD_LENGTH = 12  # constant length added where the dead span is not modelled
WEIGHT = 13  # weight per unstrained length
FREE_COMPLIANCE, DEAD_COMPLIANCE, ARC_COMPLIANCE = 14, 15, 16
COMPLIANCES = (FREE_COMPLIANCE, DEAD_COMPLIANCE, ARC_COMPLIANCE)
TENSION_MIN, TENSION_MAX, BREAKING = 17, 18, 19
UNKNOWNS = 20  # number of the line's unknowns, 3 to 6: it identifies the sheave kind
PREFERRED = 21  # preferred pull (N): where tensions are redundant, the inverse problem minimises distances from it
SPANS = 22  # spans of the cable between exit and platform point: as often its free length counts
PULLS = 23  # tensions at the platform point: spans of all cables of the line
COLUMNS = 24

# Unknowns of one line, ordered so that a simpler sheave kind uses the first few of them.
# In the line's plane, x points towards B and z up; angles are of the tangent where the cable leaves the sheave.
PHI = 0  # direction of the free span where it leaves the sheave, rad
TAU = 1  # log of the tension at the sheave, N
FREE = 2  # unstrained length of the free span, m
DEAD = 3  # unstrained length of the dead span, m
PSI = 4  # direction of the dead span from the sheave towards the winch, rad
BETA = 5  # lever angle from the horizontal, rad
STATE = 6

# Entries of `Packed.platform`.
MASS_X, MASS_Y, MASS_Z = 0, 1, 2  # centre of mass, platform frame
PLATFORM_WEIGHT = 3  # N
WRENCH = 4  # 4..9: external force (N) and moment about the platform's origin (N m), world
MASSLESS = 10  # 1 if any line is weightless and can therefore be slack at zero tension
HELD = 11  # 1 if a plane carries the platform across it, else 0 and so are the next four
NORMAL = 12  # 12..14: unit vector across the plane, world
PLANE_DISTANCE = 15  # distance of the plane from the world's origin along its normal, m
PLATFORM = 16


class Packed(NamedTuple):
    """A robot under one fidelity, as arrays: the first argument of most kernels.

    In batches *lines* and *platform* have a leading axis: one row for all problems, or one for each.
    """

    freedoms: int  # n: 3 or 6
    lines: NDArray[np.float64]  # (m, COLUMNS)
    platform: NDArray[np.float64]  # (PLATFORM,)


@jit(allocates=True)
def robot_of(packed, j):
    """The robot of problem *j* of a batch."""
    row = j if packed.lines.shape[0] > 1 else 0
    return Packed(packed.freedoms, packed.lines[row], packed.platform[row])
