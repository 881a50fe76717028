"""Jacobian and structure matrix of straight cables at poses: how lengths, speeds and forces depend on the pose.

With v the velocity of the platform's origin and its angular velocity, world: the lengths change by J v, and tensions t
act on the platform with the wrench A t. Virtual work relates both: A = -J^T diag(c), with c the cables of each line.
"""

from __future__ import annotations

from typing import TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import AnswerError
from cablewright.models.fidelity import CableLaw, SheaveLaw
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.tension import structures


class StraightOptions(TypedDict, total=False):
    """Options of functions of straight cables: *retraction* in m, laws by name or member."""

    retraction: ArrayLike | None
    cable: CableLaw | str | None
    sheave: SheaveLaw | str | None


def straight_model(
    robot: Robot | Model, options: StraightOptions, tension_limits: tuple[float, float] | None = None
) -> Model:
    """Return the model of *robot* with the laws of *options*; cables are rigid by default. Raises `InputError`."""
    cable, sheave = options.get("cable"), options.get("sheave")
    return Model.of(robot, cable=cable, sheave=sheave, tension_limits=tension_limits, default=CableLaw.RIGID)


def structure_matrix(robot: Robot | Model, poses: ArrayLike, **options: Unpack[StraightOptions]) -> Array:
    """Return the structure matrix A (n, m) at *poses* (n,), m and rad, or (N, n, m) at poses (N, n).

    Column i is the wrench on the platform, about its origin, world, per newton of the tension of line i: 1 and m. What
    a plane carries is left out. *retraction*: m, of a platform that retracts. A cable over a sheave leaves along its
    tangent. Rows of a batch without a direction are NaN; a single pose raises `AnswerError`. Raises `InputError`.

    Examples
    --------
    >>> import cablewright as cw
    >>> cw.structure_matrix(cw.load("cogiro"), [0.0, 0.0, 1.0]).shape
    (6, 8)
    """
    model = straight_model(robot, options)
    found, _ = structures(model, poses, retraction=options.get("retraction"))
    single = np.ndim(poses) == 1
    if single and np.isnan(found).any():
        raise AnswerError(
            "no structure matrix at this pose: a platform point is at an exit point or inside a "
            "sheave; choose another pose"
        )
    return found[0] if single else found


def jacobian(robot: Robot | Model, poses: ArrayLike, **options: Unpack[StraightOptions]) -> Array:
    """Return the Jacobian J (m, n) of the lengths at *poses* (n,), m and rad, or (N, m, n) at poses (N, n).

    J times the velocity of the platform's origin and its angular velocity, m/s and rad/s, world, is the speed at which
    the lengths of straight, inextensible cables grow, m/s. Options, NaN and errors as `structure_matrix`. How the pose
    follows lengths of cables that stretch and sag is `linearise(hold).per_length`.

    Source: A. Pott, Cable-Driven Parallel Robots, 2018, chapter 3.

    Examples
    --------
    >>> import cablewright as cw
    >>> speeds = cw.jacobian(cw.load("cogiro"), [0.0, 0.0, 1.0]) @ [0.1, 0.0, 0.0, 0.0, 0.0, 0.0]
    >>> speeds.shape
    (8,)
    """
    model = straight_model(robot, options)
    cables = np.array([line.cables for line in model.robot.lines], dtype=np.float64)
    back = np.swapaxes(structure_matrix(model, poses, retraction=options.get("retraction")), -1, -2)
    return np.asarray(-back / cables[:, None])
