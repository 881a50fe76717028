"""Inverse problem: the unstrained lengths and tensions that hold the platform at a pose."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from cablewright.foundation.arrays import Array
from cablewright.kernels import batches
from cablewright.kernels.layout import Code, Packed
from cablewright.models.fidelity import CableLaw, SheaveLaw
from cablewright.models.packed_views import blank_states
from cablewright.models.shared_winches import shares
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.solvers.arguments import as_poses, given_numbers, given_rows, require_a_load
from cablewright.solvers.preferred_tensions import preferred_tensions
from cablewright.solvers.row_threads import run

BLOCK: Final = 128 * 64
"""Poses of a path that a study solves between two reports of progress: a multiple of the kernels' chunk."""


def inverse(
    robot: Robot | Model,
    poses: ArrayLike,
    *,
    cable: CableLaw | str | None = None,
    sheave: SheaveLaw | str | None = None,
    tension_limits: tuple[float, float] | None = None,
    retraction: ArrayLike | None = None,
    preferred: ArrayLike | None = None,
) -> Equilibrium:
    """Compute lengths and tensions at *poses*, (n,) or (N, n) in m and rad: the least-norm tensions within the limits.

    With *preferred* tensions, (m,) or one row for each pose, N, the tensions nearest to those are taken instead; so are
    those nearest to `preferred_tensions` where the limits let redundant lines hang slack.

    A rigid body's pose is its position and rotation vector, or its position alone: unrotated. A platform in a plane has
    its poses in that plane, which takes all force across it and decides a coordinate that is NaN. On a robot with fewer
    winches than degrees of freedom, as many degrees of freedom as winches are given and the others are NaN: gravity
    decides them, and the pose of the answer is complete. Lengths of lines that share a winch fit it; of a body on such
    lines the position alone may be given. *retraction* is the platform's retraction length, m, one for all or one for
    each pose.

    *cable* is ``rigid``, ``elastic`` or ``catenary`` (default); *sheave* simplifies the sheaves as built;
    *tension_limits* (min, max), N, replace the lines' own and hold along the whole line. An infeasible pose is an
    answer: its status states it, and its tensions violate the limits as little as possible. The tension of a line with
    a counterweight is given, and counts as its limits. Lengths of ``rigid`` lines without levers are geometry, and
    given at each complete pose that is not inside a sheave. Raises `InputError` for numbers of the wrong count or not
    finite.
    """
    model = Model.of(robot, cable=cable, sheave=sheave, tension_limits=tension_limits)
    return solve_inverse(model, poses, retraction=retraction, preferred=preferred)


def solve_inverse(
    model: Model,
    poses: ArrayLike,
    *,
    path: bool = False,
    retraction: ArrayLike | None = None,
    preferred: ArrayLike | None = None,
    exit_points: Array | None = None,
    wrenches: Array | None = None,
) -> Equilibrium:
    """Solve `inverse` for a model. *path* states that consecutive rows are neighbours on a path, which is faster.

    Where the limits allow a line so slack that it may hang in several shapes, a path keeps its neighbour's.
    *exit_points* (N, m, 3), m, replace the robot's; winch exit points move with them. *wrenches* (N, 6), N and N m,
    world, act on the platform beside its own, such as those of its inertia: see `inertia_wrenches`.
    """
    require_a_load(model)
    pose, single = as_poses(model, poses, "pose", free=True)
    rows = len(pose)
    by_default = preferred is None
    if preferred is None:
        preferred = preferred_tensions(model)
    else:
        preferred = given_rows(preferred, rows, model.m, "preferred tensions", "N")
    retracted = given_numbers(retraction, rows, "retraction", "m")
    packed = model.rows(retraction=retracted, preferred=preferred, exit_points=exit_points, wrenches=wrenches)
    states = blank_states(rows, model.m)
    lengths = np.zeros((rows, model.m))
    codes = np.zeros(rows, dtype=np.int64)
    violations = np.zeros(rows)
    arrays = (packed, pose, states, lengths, codes, violations)
    if model.robot.sharing or model.winches < min(model.m, model.freedoms):
        run(batches.shared_rows, rows, packed, shares(model.robot), *arrays[1:], path)
    elif model.m < model.freedoms:
        run(batches.hanging_rows, rows, *arrays)
    else:
        run(batches.inverse_rows, rows, *arrays, path)
    if by_default and preferred is not None and (lost := np.flatnonzero(codes == Code.NOT_CONVERGED)).size:
        # the preferred tensions may be far from any that the limits allow; the least ones are another start
        drawn = None if retracted is None else retracted[lost]
        exits = None if exit_points is None else exit_points[lost]
        load = None if wrenches is None else wrenches[lost]
        again = solve_inverse(
            model, pose[lost], retraction=drawn, preferred=np.zeros(model.m), exit_points=exits, wrenches=load
        )
        solved = (again.pose, again.states, again.lengths, again.code, again.violation)
        for into, found in zip(arrays[1:], solved, strict=True):
            into[lost] = found
    if model.fidelity.cable is CableLaw.RIGID:
        _draw_straight(model, packed, pose, lengths)
    batch = Equilibrium(model, packed, pose, lengths, states, codes, violations, np.zeros(rows, dtype=np.int64))
    return batch[0] if single else batch


def _draw_straight(model: Model, packed: Packed, poses: Array, lengths: Array) -> None:
    """Write the lengths of rigid lines where no tensions balance the platform; a lever's angle depends on them."""
    rows = np.flatnonzero(np.isnan(lengths).any(axis=1))
    if not len(rows):
        return
    drawn = np.empty((len(rows), model.m))
    own = (
        packed if len(packed.lines) == 1 else packed._replace(lines=packed.lines[rows], platform=packed.platform[rows])
    )
    batches.straight_rows(own, poses[rows], 1.0, drawn)
    lengths[rows] = np.where(model.lines.has_lever, np.nan, drawn)
