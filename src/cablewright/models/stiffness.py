"""The tangent stiffness at an equilibrium in two parts: elastic, along the lines, and geometric, the rest.

Each line acts on its platform point with a stiffness K_i (3, 3), N/m, at constant length paid out by its winch.
With c_i the unit vector along the chord of its free span, from where the cable leaves the sheave to the platform point:

* **elastic**: the sum of k_i w_i w_i^T, with k_i = c_i^T K_i c_i the line's stiffness along its chord and w_i the
  wrench of a unit force along it: tensions change at constant directions. For a straight cable k_i is EA over the
  unstrained length of all that stretches, and the sum is the well-known A^T diag(EA / l) A. A sagging cable also
  yields by straightening, and the lever of a universal joint by rotating: k_i is then that of all of these in series,
  below EA / l (Ernst 1965).
* **geometric**: the effect of tension and load when lines, arms and the centre of mass rotate: T / l across a
  straight line. It is computed as the tangent stiffness minus the elastic part.

Behzadipour and Khajepour 2006 for straight lines. Examples and limits: `docs/modes.md`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import DTypeLike, NDArray

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import AnswerError, Status
from cablewright.kernels.statics.stiffness import stiffness_rows
from cablewright.models.batch_rows import Rows
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.packed_views import LineNumbers, LineStates, PlatformNumbers
from cablewright.models.plane import projected
from cablewright.models.statics import Equilibrium, Model

UNBALANCED = 1e-6
"""Maximum unbalanced force of an equilibrium, as a share of weight plus tensions."""

MAX_RESIDUAL = 1e-6
"""Maximum residual of the geometric equations of an equilibrium, m."""


@dataclass(frozen=True, eq=False, repr=False)
class Stiffness(Rows):
    """The parts of the tangent stiffness at constant lengths; a leading axis for a batch (see `Rows`).

    `elastic` and `geometric` (n, n): restoring wrench per motion of the platform's origin and rotation, world, N/m and
    N m/rad; `elastic` is symmetric and positive semidefinite. Directions that a plane blocks have none. `axial` (m,):
    each line's stiffness along its chord, N/m. `chords` (m, 3): unit vectors, world; zero where a massless line is
    slack. `arms` (m, 3): from the platform's origin to where they end, world, m.
    """

    SINGLE: ClassVar = ("elastic", 2)

    elastic: Array
    geometric: Array
    axial: Array
    chords: Array
    arms: Array

    @property
    def total(self) -> Array:
        """(n, n) the tangent stiffness, the sum of both parts; equal to that of `linearise` for elastic cables."""
        return self.elastic + self.geometric

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        """Return `total`, which NumPy reads where it is given a stiffness."""
        return np.array(self.total, dtype=dtype)


def stiffness(equilibrium: Equilibrium) -> Stiffness:
    """Split the tangent stiffness of an equilibrium, or of each of a batch.

    Rigid cables count as elastic ones with the same tensions at the same pose, on stiff mounts. Rows of a batch that
    are not in balance are NaN; a single one raises `AnswerError`. Equilibria that are unstable or out of their tension
    limits have a stiffness, too.
    """
    single = equilibrium.single
    good = balanced(equilibrium)
    if single and not good:
        raise AnswerError(equilibrium.sentence())
    solved = as_elastic(equilibrium) if equilibrium.model.fidelity.cable is CableLaw.RIGID else equilibrium
    rows, m, n = equilibrium.code.size, equilibrium.model.m, equilibrium.model.n
    tangent, axial = np.zeros((rows, n, n)), np.zeros((rows, m))
    chords, arms = np.zeros((rows, m, 3)), np.zeros((rows, m, 3))
    codes = np.zeros(rows, dtype=np.int64)
    stiffness_rows(solved.packed, *solved.solved_arrays()[1:], tangent, chords, axial, arms, codes)
    if single and codes[0]:
        raise AnswerError(Status.of(int(codes[0])).value)
    bad = ~np.atleast_1d(good) | (codes != 0)
    for array in (tangent, chords, axial):
        array[bad] = np.nan
    if single:
        tangent, chords, axial, arms = tangent[0], chords[0], axial[0], arms[0]
    elastic = _elastic_part(equilibrium, chords, axial, arms)
    return Stiffness(elastic, tangent - elastic, axial, chords, arms)


def balanced(equilibrium: Equilibrium) -> Mask:
    """Return a mask of the rows in balance, stable or not, within tension limits or not; () for a single one."""
    finite = np.isfinite(equilibrium.states).all(axis=(-2, -1)) & np.isfinite(equilibrium.pose).all(axis=-1)
    forces = PlatformNumbers(equilibrium.packed.platform).weight + equilibrium.tensions.sum(axis=-1)
    if equilibrium.single:
        forces = forces[0]
    fits = (equilibrium.residual_norm() <= MAX_RESIDUAL) & (equilibrium.unbalanced_force() <= UNBALANCED * forces)
    return np.asarray(finite & fits)


def _elastic_part(equilibrium: Equilibrium, chords: Array, axial: Array, arms: Array) -> Array:
    """Return the sum of k w w^T (..., n, n) over the lines."""
    wrenches = along_chords(equilibrium.model.n, chords, arms)
    wrenches = projected(equilibrium.model.free_directions, wrenches)
    return np.asarray(np.einsum("...m,...mi,...mj->...ij", axial, wrenches, wrenches))


def along_chords(n: int, chords: Array, arms: Array) -> Array:
    """Return the wrenches (..., m, n) of unit forces along *chords* (..., m, 3) that act at *arms* (..., m, 3), m."""
    return chords if n == 3 else np.concatenate([chords, np.cross(arms, chords)], axis=-1)


def as_elastic(equilibrium: Equilibrium) -> Equilibrium:
    """Return equilibria of rigid lines as those of elastic lines with the same tensions and poses.

    Straight lines without weight have the same shape and balance whether they stretch or not. Codes stay as they are.
    """
    fidelity = Fidelity(CableLaw.ELASTIC, equilibrium.model.fidelity.sheave)
    model = Model(equilibrium.model.robot, fidelity, equilibrium.model.tension_limits)
    lines, states = LineNumbers(equilibrium.packed.lines.copy()), LineStates(equilibrium.states.copy())
    before = lines.spans * states.free_length + states.dead_length
    contact = equilibrium.lengths - before - np.where(lines.has_dead_span, 0.0, lines.dead_length)
    lines.compliances, lines.spring = model.lines.compliances, model.lines.spring
    states.free_length /= 1.0 + states.tension * model.lines.free_compliance
    states.dead_length /= 1.0 + states.tension * model.lines.dead_compliance
    arc = contact * (1.0 / (1.0 + states.tension * model.lines.arc_compliance) - 1.0)
    lengths = equilibrium.lengths + (lines.spans * states.free_length + states.dead_length - before) + arc
    lengths -= states.tension * model.lines.spring
    packed = equilibrium.packed._replace(lines=lines.array)
    return replace(equilibrium, model=model, packed=packed, states=states.array, lengths=lengths)
