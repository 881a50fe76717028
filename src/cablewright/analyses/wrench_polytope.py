"""Available wrenches: the set of all that tensions within their limits can apply to the platform at a pose.

The wrenches A t are a zonotope. Each facet is parallel to f - 1 columns of A, with f degrees of freedom; with c normal
to these, the facets are c . w <= sum max(c . a low, c . a high). `capacity` has the distance of a wrench from the
nearest of them alone, in a kernel, for batches of any size; here are the facets themselves.

S. Bouchard, C. Gosselin, B. Moore, On the ability of a cable-driven robot to generate a prescribed set of wrenches,
2010.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from math import comb
from typing import ClassVar, Final

import numpy as np
from numpy.typing import ArrayLike

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import AnswerError, InputError, require_positive
from cablewright.foundation.results import Figure, Pictured
from cablewright.models.batch_rows import Rows
from cablewright.models.fidelity import CableLaw, SheaveLaw
from cablewright.models.plane import directions
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.arguments import as_poses, as_rows
from cablewright.solvers.tension import drum_structures, structures

MAX_FACETS: Final = 100_000
"""Largest number of choices of f - 1 columns: 16 lines of a body have 4368."""

_PARALLEL: Final = 1e-9  # share of the largest singular value under which columns count as dependent
_SAME: Final = 1e-7  # difference of unit normals under which two facets count as one
_FAR: Final = 1e30
_NUMBERS: Final = 4_000_000  # of matrices that are taken apart at a time
_ROWS: Final = 128  # normals that are compared with all others at a time


@dataclass(frozen=True, eq=False, repr=False)
class WrenchPolytope(Pictured, Rows):
    """The wrenches w that lines can apply at a pose: ``normals @ w <= offsets``; a leading axis for a batch.

    ``normals`` (k, n): 1 and 1/m, so that ``offsets`` (k,) and distances are in N, with moments divided by ``length``,
    m; rows that are no facet are NaN. ``structure`` (n, m): the structure matrix. ``limits`` (m, 2): tensions, N.
    ``required`` (n,): the wrench that balances weight and loads, N and N m, world. ``basis`` (n, f): the directions
    that a plane leaves. A counterweight has one tension. Elastic lines on one drum count as one: columns and limits are
    those of the host's tension. The set is flat where lines with a winch do not reach all f
    degrees of freedom: it has no facets. Neither has it any where a counterweight exceeds a limit.
    """

    SINGLE: ClassVar = ("required", 1)
    FIGURES: ClassVar = (
        Figure("robot", "", "Name of the robot.", "robot_name"),
        Figure("pose", "m, rad", "Position and, of a rigid platform, rotation vector.", "poses"),
        Figure("length", "m", "Arm on which a moment counts as a force.", shown="m"),
        Figure("facets", "1", "Number of facets."),
        Figure("required", "SI", "Wrench that balances weight and loads."),
        Figure("margin", "N", "Distance of that wrench from the nearest facet; negative outside."),
        Figure("volume", "SI", "Volume of the set, moments divided by the arm."),
    )
    HEADLINES: ClassVar = ("robot", "facets", "margin")

    robot_name: str
    length: float
    basis: Array
    limits: Array
    poses: Array
    structure: Array
    normals: Array
    offsets: Array
    required: Array

    @property
    def facets(self) -> Array:
        """Number of facets of the polytope of available wrenches."""
        return np.asarray(np.isfinite(self.offsets).sum(axis=-1))

    def distances(self, wrench: ArrayLike) -> Array:
        """Return the distances (k,) of a *wrench* (n,), N and N m, from all facets, N; negative is outside."""
        given, _ = as_rows(wrench, self.normals.shape[-1], "wrench", "N and N m")
        return np.asarray(self.offsets - self.normals @ given[0])

    def contains(self, wrench: ArrayLike) -> Mask:
        """Return whether lines can apply a *wrench* (n,), N and N m, world: () or of a batch (N,)."""
        return np.asarray((np.nan_to_num(self.distances(wrench), nan=_FAR) >= 0.0).all(axis=-1) & (self.facets > 0))

    @property
    def margin(self) -> Array:
        """Distance of the required wrench from the nearest facet, N: that of `capacity`; NaN of a flat set."""
        distances = self.offsets - np.einsum("...kn,...n->...k", self.normals, self.required)
        least = np.nan_to_num(distances, nan=np.inf).min(axis=-1)
        return np.where(self.facets > 0, least, np.nan)

    @property
    def volume(self) -> Array:
        """Volume of the set with moments divided by the arm: the sum over all choices of f lines of |det|."""
        columns = _scaled(self.structure, self.basis, self.length) * np.diff(self.limits, axis=-1)[..., None, :, 0]
        chosen = np.array(list(combinations(range(columns.shape[-1]), columns.shape[-2])), dtype=np.int64)
        if not len(chosen):
            return np.zeros(columns.shape[:-2])
        return np.asarray(np.abs(np.linalg.det(np.moveaxis(columns[..., chosen], -2, -3))).sum(axis=-1))

    def vertices(self, moment: ArrayLike | None = None) -> Array:
        """Return the corners (p, 3) of the forces, N, world, that lines can apply together with a *moment* (3,), N m.

        By default the moment that the required wrench has. Of a single pose; in a plane the corners are in it. Raises
        `AnswerError` where no force can be applied beside it.
        """
        if not self.single:
            raise InputError("vertices: computed for one pose only; take a row of the batch, polytopes[0]")
        fixed = self.required.copy()
        if moment is not None and len(fixed) == 6:
            fixed[3:] = as_rows(moment, 3, "moment", "N m")[0][0]
        return _slice(self, fixed)


def available_wrenches(
    robot: Robot | Model,
    poses: ArrayLike,
    *,
    length: float = 1.0,
    retraction: ArrayLike | None = None,
    cable: CableLaw | str | None = None,
    sheave: SheaveLaw | str | None = None,
    tension_limits: tuple[float, float] | None = None,
) -> WrenchPolytope:
    """Compute the available wrenches at *poses*, (n,) or (N, n) in m and rad, with the facets of their set.

    Cables are straight, as in `tension_distribution`, and a plane holds both ways. Moments are divided by *length*, m,
    where they are compared with forces. Raises `InputError`, and `AnswerError` for a single pose without a structure
    matrix.

    Examples
    --------
    >>> import cablewright as cw
    >>> cw.available_wrenches(cw.load("cogiro"), [0.0, 0.0, 2.0])
    WrenchPolytope(robot='cogiro', facets=112, margin=351.4 N)
    """
    require_positive(length=length)
    model = Model.of(robot, cable=cable, sheave=sheave, tension_limits=tension_limits, default=CableLaw.RIGID)
    weights = model.lines.counterweight
    winched = weights == 0.0
    count = comb(min(int(winched.sum()), model.winches), model.freedoms - 1)
    if count > MAX_FACETS:
        asked = f"{model.freedoms - 1} of {winched.sum()} lines"
        raise InputError(
            f"{count} choices of {asked}: at most {MAX_FACETS} are computed; `capacity` computes the margin without "
            f"facets"
        )
    given, single = as_poses(model, poses, "pose")
    found, loads = structures(model, given, retraction=retraction)
    if single and np.isnan(found).any():
        raise AnswerError(
            "no structure matrix at this pose: a platform point is at an exit point or inside a "
            "sheave; choose another pose"
        )
    free = directions(model.robot.platform.plane, model.n)
    limits = np.array([line.tension_limits for line in model.robot.lines], dtype=np.float64)
    limits[:] = limits if model.tension_limits is None else model.tension_limits
    allowed = ((limits[:, 0] <= weights) & (weights <= limits[:, 1]))[~winched].all()
    limits[~winched] = weights[~winched, None]
    good, fixed, bounds = np.full(len(given), allowed), np.zeros_like(loads), np.tile(limits, (len(given), 1, 1))
    if model.robot.sharing:
        found, moved, bounds, codes = drum_structures(model, given, retraction=retraction)
        good, fixed = codes == 0, moved - loads
        if found.shape[-1] < model.m:
            winched = winched[[line.shared_winch is None for line in model.robot.lines]]
    normals, offsets = _facets_of_batch(_scaled(found, free, length), bounds, winched)
    offsets = np.where(good[:, None], offsets, np.nan)
    normals = normals @ free.T * _arms(model.n, length)
    offsets = offsets + np.einsum("nkf,nf->nk", normals, fixed)
    every = np.broadcast_to(free, (len(given), *free.shape))
    batch = WrenchPolytope(model.robot.name, float(length), every, bounds, given, found, normals, offsets, -loads)
    return batch[0] if single else batch


def _scaled(structure: Array, free: Array, length: float) -> Array:
    """Return structure matrices (..., f, m) in the *free* directions (..., n, f), moments divided by *length*."""
    arms = _arms(structure.shape[-2], length)
    return np.asarray(np.swapaxes(free, -1, -2) @ (arms[:, None] * structure))


def _arms(n: int, length: float) -> Array:
    """Return what makes forces of wrenches (n,): 1, and of moments one over *length*."""
    return np.array([1.0, 1.0, 1.0] + [1.0 / length] * 3)[:n]


def _facets_of_batch(columns: Array, limits: Array, winched: Mask) -> tuple[Array, Array]:
    """Return `_facets` of the lines with a winch, moved by the wrench of the others, in blocks of bounded memory."""
    f, own = columns.shape[1], limits[:, winched]
    block = max(1, _NUMBERS // (f * f * max(1, comb(own.shape[1], f - 1))))
    blocks = [slice(k, k + block) for k in range(0, max(len(columns), 1), block)]
    found = [_facets(columns[rows][:, :, winched], own[rows]) for rows in blocks]
    normals, offsets = (np.concatenate(each) for each in zip(*found, strict=True))
    given = np.einsum("nfk,nk->nf", np.nan_to_num(columns[:, :, ~winched]), limits[:, ~winched, 0])
    return normals, offsets + np.einsum("nkf,nf->nk", normals, given)


def _facets(columns: Array, limits: Array) -> tuple[Array, Array]:
    """Return unit normals (N, k, f) and offsets (N, k) of the facets of *columns* (N, f, m); NaN: no facet."""
    f, m = columns.shape[1:]
    chosen = np.array(list(combinations(range(m), f - 1)), dtype=np.int64)
    if m < f:
        return np.full((len(columns), 1, f), np.nan), np.full((len(columns), 1), np.nan)
    beside = np.moveaxis(np.nan_to_num(columns)[:, :, chosen], 1, 3)  # (N, C, f - 1, f)
    _, sizes, rows = np.linalg.svd(beside)
    normals = rows[..., -1, :]
    along = normals @ np.nan_to_num(columns)  # (N, C, m)
    spread = np.abs(along).max(axis=-1)
    bad = (sizes[..., -1] <= _PARALLEL * sizes[..., 0]) | (spread <= _PARALLEL * sizes[..., 0])
    bad |= np.reshape(np.isnan(columns).any(axis=(1, 2)), (-1, 1))
    for row in range(len(bad)):
        bad[row] |= _repeated(np.where(bad[row, :, None], 0.0, normals[row]))
    low, high = limits[:, None, :, 0], limits[:, None, :, 1]
    upper = np.where(along > 0.0, along * high, along * low).sum(axis=-1)
    lower = np.where(along > 0.0, along * low, along * high).sum(axis=-1)
    both = np.concatenate([normals, -normals], axis=1)
    offsets = np.concatenate([upper, -lower], axis=1)
    none = np.concatenate([bad, bad], axis=1)
    ranks = np.asarray(np.linalg.matrix_rank(np.nan_to_num(columns)))
    none |= (ranks < f)[:, None]
    return np.where(none[..., None], np.nan, both), np.where(none, np.nan, offsets)


def _repeated(normals: Array) -> Mask:
    """Return which unit *normals* (C, f) have been there before, in the same or the opposite direction."""
    found = np.zeros(len(normals), np.bool_)
    for first in range(0, len(normals), _ROWS):
        rows = normals[first : first + _ROWS]
        alike = np.abs(np.abs(rows @ normals[: first + len(rows)].T) - 1.0) < _SAME**2 + 1e-13
        found[first : first + len(rows)] = np.tril(alike, first - 1).any(axis=1)
    return found


def _slice(found: WrenchPolytope, fixed: Array) -> Array:
    """Return the corners (p, 3) of the forces beside the moment of *fixed* (n,)."""
    from scipy.optimize import linprog
    from scipy.spatial import HalfspaceIntersection, QhullError

    real = np.isfinite(found.offsets)
    forces = found.basis[:3, np.abs(found.basis[:3]).any(axis=0)]  # (3, 2 or 3)
    rows = found.normals[real]
    matrix, bound = rows[:, :3] @ forces, found.offsets[real] - rows[:, 3:] @ fixed[3:]
    across = np.linalg.norm(matrix, axis=1)
    size = forces.shape[1]
    if not len(rows):
        raise AnswerError(
            "the available wrenches are flat: the lines do not reach all degrees of freedom, so there are no facets"
        )
    bounds = [(None, None)] * size + [(0.0, None)]
    program = linprog([0.0] * size + [-1.0], A_ub=np.column_stack([matrix, across]), b_ub=bound, bounds=bounds)
    if program.status != 0 or not program.x[-1] > 0.0:
        raise AnswerError("the lines cannot apply any force together with this moment; give a smaller moment")
    try:
        corners = HalfspaceIntersection(np.column_stack([matrix, -bound]), program.x[:-1]).intersections
    except QhullError:
        raise AnswerError(
            "the forces that the lines can apply together with this moment lie nearly in a plane, so "
            "the corners are not defined"
        ) from None
    return np.asarray(corners @ forces.T)
