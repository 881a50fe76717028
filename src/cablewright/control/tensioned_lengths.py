"""Line lengths that hold a rigid platform at a pose with tensions that the full model chooses.

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
from cablewright.models.inertia import inertia_wrenches
from cablewright.models.statics import Equilibrium, Model
from cablewright.solvers.hanging_path import hung
from cablewright.solvers.inverse import solve_inverse, solve_rows


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
    packed: Packed | None = None,
) -> Held | None:
    """Return the equilibria in which *model* holds *poses* (k, 6), at *retraction* lengths (k,), m; None if it cannot.

    With fewer winches than degrees of freedom the platform hangs as it does at rest, with its nozzle at these poses.
    *accelerations* (k, 3): m/s^2, of the platform, under whose forces it is held; None: at rest. *packed*: the model in
    k rows where its winches hold all coordinates, to save time.
    """
    wrenches = None if accelerations is None else inertia_wrenches(model.robot, poses, accelerations)
    if packed is not None and retraction is None:
        found = solve_rows(model, packed, poses, wrenches)
        if found is not None:
            return Held(found.pose, found.tensions, found.lengths, found)
    poses = hung(model, poses, retraction)
    solved = solve_inverse(model, poses, path=True, retraction=retraction, wrenches=wrenches)
    return Held(solved.pose, solved.tensions, solved.lengths, solved) if np.isfinite(solved.lengths).all() else None
