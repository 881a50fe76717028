"""Layout of the kernels' arrays: columns of a line, entries of the platform, unknowns of a line; status codes."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.kernels import jit


class Code(IntEnum):
    """Status code of one solve. `cablewright.foundation.errors.Status` has the sentences shown to users."""

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
GUIDE = 24  # how a line out of the plane is guided at the frame; 0 for one in a vertical plane
AXIS_X, AXIS_Y, AXIS_Z = 25, 26, 27  # axis that the swivel turns about, or on which the pulley turns, world
ARRIVAL_X, ARRIVAL_Y, ARRIVAL_Z = 28, 29, 30  # where the cable arrives: see GUIDE
DEAD_SPAN = 31  # distance that the dead span of a line out of the plane covers, ASIDE without its last stretch; or 0
WINCH_RISE = 32  # height of its winch over its sheave, per length of the dead span
MEAN_RISE = 33  # twice the mean height of its dead span over its sheave, per length
LOW_RISE, HIGH_RISE = 34, 35  # lowest and highest of sheave, guides and winch over the sheave, per length
END_RADIUS = 36  # sheave on the platform; 0 where the line ends at its platform point
END_AXIS_X, END_AXIS_Y, END_AXIS_Z = 37, 38, 39  # axis through the platform point that it turns about, platform frame
MOUNT = 40  # 40..45: compliance of the exit mount (m/N, world): xx, yy, zz, xy, xz, yz; of an UPRIGHT line xx = yy = zz
END_SPRING = 46  # m/N: by how much a spring at the winch end stretches per tension of one cable
COUNTERWEIGHT = 47  # tension of one cable at the winch end that a counterweight holds, N; 0 for a winch
END_ARRIVAL_X, END_ARRIVAL_Y, END_ARRIVAL_Z = 48, 49, 50  # see GUIDE: a sheave on the platform that does not turn
COLUMNS = 51

# Values of GUIDE: a swivel may have its winch ASIDE of its axis. ARRIVAL is then, and of an eyelet, the vector (m) from
# the exit point to where the cable comes from, and of a pulley the unit vector from its centre to where it meets it;
# END_ARRIVAL that of a pulley on the platform to where the cable leaves it to its anchor, in its frame, else zero.
UPRIGHT, EYELET, SWIVEL, PULLEY, ASIDE = 0, 1, 2, 3, 4

# Unknowns of one line, ordered so that a simpler sheave kind uses the first few of them.
# In the line's plane, x points towards B and z up; angles are of the tangent where the cable leaves the sheave.
PHI = 0  # direction of the free span where it leaves the sheave, rad
TAU = 1  # log of the tension at the sheave, N
FREE = 2  # unstrained length of the free span, m
DEAD = 3  # unstrained length of the dead span, m
PSI = 4  # direction of the dead span from the sheave towards the winch, rad
BETA = 5  # lever angle from the horizontal, rad
STATE = 6

# A line out of the plane has two other meanings: PHI is then the span's direction above the horizontal.
AZIMUTH = 4  # of the free span where it leaves the frame, rad
CONTACT = 5  # length of cable on the sheaves, m

# Parameters of a line in a linearisation: unstrained length, relative modulus, exit point x, y, z, sheave's radius,
# relative weight of the cable, and platform point x, y, z in the platform's frame.
LENGTH, MODULUS, EXIT, SHEAVE, WEIGHT_FACTOR, POINT = 0, 1, 2, 5, 6, 7
PARAMETERS = 10

# Entries of `Packed.platform`.
MASS_X, MASS_Y, MASS_Z = 0, 1, 2  # centre of mass, platform frame
PLATFORM_WEIGHT = 3  # N
WRENCH = 4  # 4..9: external force (N) and moment about the platform's origin (N m), world
MASSLESS = 10  # 1 if any line is weightless and can therefore be slack at zero tension
HELD = 11  # 1 if a plane carries the platform across it, else 0 and so are the next four
NORMAL = 12  # 12..14: unit vector across the plane, world
PLANE_DISTANCE = 15  # distance of the plane from the world's origin along its normal, m
PLATFORM = 16

CHUNK = 64  # rows of a batch, from a multiple of it on, that may depend on each other


class Packed(NamedTuple):
    """A robot with its chosen physics as arrays: the first argument of most kernels.

    In batches *lines* and *platform* have a leading axis: one row for all problems, or one for each. *general* is None
    for a robot whose lines all hang in vertical planes and have no counterweights: Numba then compiles kernels without
    the branches for other lines (docs/decisions/0014-plain-robots-apart.md).
    """

    freedoms: int  # n: 3 or 6
    lines: NDArray[np.float64]  # (m, COLUMNS)
    platform: NDArray[np.float64]  # (PLATFORM,)
    general: bool | None  # True if a line is out of the plane or the platform has a plane; else None


@jit(allocates=True)
def robot_of(packed, j):
    """Return the packed robot of problem *j* of a batch."""
    row = j if packed.lines.shape[0] > 1 else 0
    return Packed(packed.freedoms, packed.lines[row], packed.platform[row], packed.general)
