"""Line lengths that hold a rigid platform at a pose with tensions that the full model chooses, and errors beside them.

With more lines than degrees of freedom a pose alone does not determine the lengths: the tensions that balance no load
are free. The model chooses them within its limits, near its preferred tensions: see `held_tensions`. Lengths that
follow are exact for sag, stretch and sheaves, so that a platform whose lengths are these has both the pose and the
tensions.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.kernels.layout import Packed
from cablewright.models.fidelity import CableLaw
from cablewright.models.free_coordinates import free_coordinates
from cablewright.models.inertia import inertia_wrenches
from cablewright.models.packed_views import LineNumbers
from cablewright.models.rotation import matrix_of, motion_between
from cablewright.models.statics import Equilibrium, Model
from cablewright.models.winch_lines import WinchLines
from cablewright.solvers.hanging_path import hung
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise_where_regular
from cablewright.solvers.taut import stretches, taut_of


class Held(NamedTuple):
    """Equilibria that hold a rigid platform at poses (k, 6), with tensions and lengths (k, m)."""

    poses: Array  # m and rad
    tensions: Array  # N, at the sheaves
    lengths: Array  # m, unstrained
    solved: Equilibrium


def held_at(
    model: Model,
    poses: Array,
    retraction: Array | None,
    accelerations: Array | None = None,
) -> Held | None:
    """Return the equilibria in which *model* holds *poses* (k, 6), at *retraction* lengths (k,), m; None if it cannot.

    With fewer winches than degrees of freedom the platform hangs as it does at rest, with its nozzle at these poses.
    *accelerations* (k, 3): m/s^2, of the platform, under whose forces it is held; None: at rest.
    """
    wrenches = None if accelerations is None else inertia_wrenches(model.robot, poses, accelerations)
    poses = hung(model, poses, retraction)
    solved = solve_inverse(model, poses, path=True, retraction=retraction, wrenches=wrenches)
    return Held(solved.pose, solved.tensions, solved.lengths, solved) if np.isfinite(solved.lengths).all() else None


def length_errors(model: Model, here: Array, held: Held, retraction: Array | None, tensions: Array | None) -> Array:
    """Return how much longer (w,), m, the winches' lines must become to move from *here* (6,) to the first *held* pose.

    The pose decides what moves the platform, *tensions* (m,), N, what does not: the changes of stretch that they show,
    less the motion by their wrench. With its compliance, tensions decide too where lengths hardly hold the platform,
    such as a beam that turns about its own axis. Both agree with lengths of the model as long as lines are as soft and
    the platform as heavy as it says; else lengths alone would be followed, and the pose that they no longer hold.
    Fewer winches than degrees of freedom correct as many coordinates of the pose, with the position that of the nozzle;
    the others follow, as the platform hangs.
    """
    hosts = list(model.robot.hosts)
    motion = motion_between(here, held.poses[0])
    if len(hosts) < model.freedoms and model.free_directions is None:
        kept = np.setdiff1d(np.arange(model.n), free_coordinates(model.robot))
        hanging, codes = linearise_where_regular(held.solved[:1])
        if codes.any():
            return np.full(len(hosts), np.nan)
        at_nozzle = np.column_stack([hanging.per_length[0] @ WinchLines.of(model.robot).senses.T, motion])
        at_nozzle[:3] += np.cross(at_nozzle[3:].T, matrix_of(here[3:]) @ model.robot.platform.nozzle).T
        return np.asarray(np.linalg.lstsq(at_nozzle[kept, :-1], at_nozzle[kept, -1])[0])
    packed: Packed = model.packed
    if retraction is not None:
        packed = packed._replace(lines=model.rows(retraction=retraction[:1]).lines[0])
    taut = taut_of(packed, here)
    by_motion = taut.per_motion[hosts]
    error = by_motion @ motion
    if tensions is None or len(hosts) <= model.freedoms or model.fidelity.cable is CableLaw.RIGID:
        return np.asarray(error)
    linear, codes = linearise_where_regular(held.solved[:1])
    if codes.any():
        return np.full(len(hosts), np.nan)
    change = tensions - held.tensions[0]
    wound = WinchLines.of(model.robot).sense != 0.0
    own = stretches(LineNumbers(packed.lines), taut) * change
    return np.asarray(error + own[hosts] - by_motion @ linear.per_wrench[0] @ (change[wound] @ taut.per_motion[wound]))
