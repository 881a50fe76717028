"""Stiffness, natural frequencies and dexterity of the platform: how evenly lines hold all directions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal, TypedDict, Unpack, get_args, overload

import numpy as np
from numpy.typing import ArrayLike

from cablewright.analyses.jacobian import StraightOptions, jacobian
from cablewright.analyses.modes import modes
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError, UnknownName, require_positive
from cablewright.foundation.results import Figure, Result
from cablewright.models import stiffness as parts
from cablewright.models.batch_rows import Rows
from cablewright.models.fidelity import CableLaw, SheaveLaw
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.solvers.arguments import as_poses
from cablewright.solvers.inverse import inverse

Of = Literal["jacobian", "stiffness"]
CONDITION = 1e12
"""Condition number from which a matrix counts as singular."""


class HoldOptions(TypedDict, total=False):
    """Options of functions that hold the platform at poses: as those of `inverse`."""

    retraction: ArrayLike | None
    preferred: ArrayLike | None
    cable: CableLaw | str | None
    sheave: SheaveLaw | str | None
    tension_limits: tuple[float, float] | None


@overload
def stiffness(robot: Equilibrium, poses: None = None) -> parts.Stiffness: ...


@overload
def stiffness(robot: Robot | Model, poses: ArrayLike, **options: Unpack[HoldOptions]) -> parts.Stiffness: ...


def stiffness(
    robot: Robot | Model | Equilibrium, poses: ArrayLike | None = None, **options: Unpack[HoldOptions]
) -> parts.Stiffness:
    """Compute the stiffness of the platform at *poses*, (n,) or (N, n) m and rad, or at an `Equilibrium`.

    ``total`` (n, n), N/m and N m/rad, is the restoring wrench per motion of the origin and rotation, world, with the
    winches held; it is what NumPy reads, ``np.linalg.eigvalsh(cw.stiffness(robot, pose))``. ``elastic`` and
    ``geometric`` are its parts. *options*: options of `inverse`, which finds the tensions. Rows of a batch that do not
    balance are NaN; a single pose raises `AnswerError`. Raises `InputError`.

    Source: Behzadipour and Khajepour 2006; see `docs/modes.md`.

    Examples
    --------
    >>> import cablewright as cw
    >>> cw.stiffness(cw.load("house-printer"), [1.0, 2.0, 1.5]).total.shape
    (3, 3)
    """
    return parts.stiffness(robot if isinstance(robot, Equilibrium) else held(robot, poses, options))


def natural_frequencies(
    robot: Robot | Model | Equilibrium, poses: ArrayLike | None = None, **options: Unpack[HoldOptions]
) -> Array:
    """Compute natural frequencies (f,), Hz, ascending, at *poses*, (n,) m and rad, or (N, f) at poses (N, n).

    f is the number of degrees of freedom: n, or fewer in a plane. Those of `modes`, which has the shapes too, and whose
    options, signs and errors hold here.

    Examples
    --------
    >>> import cablewright as cw
    >>> cw.natural_frequencies(cw.load("jung2020"), [[0.2, 0.1, 0.9], [0.0, 0.0, 0.8]]).shape
    (2, 6)
    """
    return modes(robot, poses, **options).frequencies


def held(robot: Robot | Model, poses: ArrayLike | None, options: HoldOptions) -> Equilibrium:
    """Return the equilibrium at *poses* with the tensions of `inverse`. Raises `InputError` if there is none."""
    if poses is None:
        raise InputError("poses: a pose, or rows of poses, is expected")
    return inverse(robot, poses, **options)


@dataclass(frozen=True, eq=False, repr=False)
class Dexterity(Result, Rows):
    """How evenly lines move, or hold, the platform in all its degrees of freedom.

    A batch has a leading axis, see `Rows`.

    ``values`` (f,): singular values of the matrix, in the order of their size, with rotations counted as motions on the
    arm ``length``, m: of the Jacobian in 1, of the stiffness in N/m; the last are 0 where lines leave degrees of
    freedom open.
    """

    SINGLE: ClassVar = ("values", 1)
    FIGURES: ClassVar = (
        Figure("of", "", "Matrix: jacobian or stiffness."),
        Figure("length", "m", "Arm on which a rotation counts as a motion."),
        Figure("condition_number", "1", "Largest over smallest singular value; null where singular."),
        Figure("dexterity", "1", "Smallest over largest: 1 for equal directions, 0 for a singular pose."),
        Figure("manipulability", "SI", "Product of the singular values."),
        Figure("values", "SI", "Singular values, the largest first.", name="singular values"),
    )
    HEADLINES: ClassVar = ("of", "condition_number", "dexterity")

    of: str
    length: float
    poses: Array
    values: Array

    @property
    def dexterity(self) -> Array:
        """Smallest over largest singular value, from 0 to 1: the inverse of the condition number. Shape ()."""
        share = self.values[..., -1] / np.where(self.values[..., 0] > 0.0, self.values[..., 0], 1.0)
        return np.where(share * CONDITION < 1.0, 0.0, share)

    @property
    def condition_number(self) -> Array:
        """Largest over smallest singular value; inf where the matrix is singular. Shape ()."""
        with np.errstate(divide="ignore"):
            return np.asarray(1.0 / self.dexterity)

    @property
    def manipulability(self) -> Array:
        """Product of the singular values (Yoshikawa 1985). Shape ()."""
        return np.asarray(self.values.prod(axis=-1))


def dexterity(
    robot: Robot | Model,
    poses: ArrayLike,
    *,
    of: Of = "jacobian",
    length: float = 1.0,
    **options: Unpack[HoldOptions],
) -> Dexterity:
    """Compute condition number, dexterity and manipulability at *poses*, (n,) or (N, n) in m and rad.

    *of*: the ``jacobian`` of straight cables, or the ``stiffness``. Rotations count as motions of a point at *length*,
    m, from the origin, so that one number can be compared with another: the answer depends on it. *options*: options of
    `jacobian` or `stiffness`. Rows without an answer are NaN. Raises `InputError`, and `AnswerError` for a single pose.

    Source: Salisbury and Craig 1982; Yoshikawa 1985.

    Examples
    --------
    >>> import cablewright as cw
    >>> round(float(cw.dexterity(cw.load("cogiro"), [0.0, 0.0, 2.0], length=0.5).condition_number), 1)
    4.1
    """
    if of not in get_args(Of):
        raise UnknownName("matrix", of, get_args(Of))
    require_positive(length=length)
    model = robot if isinstance(robot, Model) else Model(robot)
    given, single = as_poses(model, poses, "pose")
    arms = np.array([1.0, 1.0, 1.0] + [1.0 / length] * 3)[: model.n]
    at = given[0] if single else given
    if of == "jacobian":
        laws: StraightOptions = {"cable": options.get("cable"), "sheave": options.get("sheave")}
        laws["retraction"] = options.get("retraction")
        matrix = jacobian(robot, at, **laws) * arms
    else:
        matrix = stiffness(robot, at, **options).total * arms * arms[:, None]
    if model.free_directions is not None:
        matrix = matrix @ model.free_directions
    good = np.isfinite(matrix).all(axis=(-2, -1))
    values = np.linalg.svd(np.where(good[..., None, None], matrix, 0.0), compute_uv=False)
    missing = model.freedoms - values.shape[-1]
    values = np.pad(values, [(0, 0)] * (values.ndim - 1) + [(0, max(missing, 0))])[..., : model.freedoms]
    return Dexterity(of, float(length), at, np.where(good[..., None], values, np.nan))
