"""Tension distribution: tensions of straight, massless lines that balance a load at a pose, with a margin.

These functions take poses alone: lengths, sag and stretch have no influence. Workspaces are computed with them. Lines
over sheaves leave along the tangent that the model's sheaves give them; `inverse` has the full physics.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.results import Figure, Result
from cablewright.kernels.layout import Code, Packed
from cablewright.kernels.wrench_feasibility import capacity_margin, distribution
from cablewright.models.batch_rows import Rows
from cablewright.models.fidelity import CableLaw, SheaveLaw
from cablewright.models.packed_views import LineNumbers, PlatformNumbers
from cablewright.models.statics import Equilibrium, Model
from cablewright.models.stiffness import along_chords
from cablewright.robot import Robot
from cablewright.solvers.arguments import as_poses, as_rows, given_numbers, given_rows, require_a_load
from cablewright.solvers.preferred_tensions import preferred_tensions
from cablewright.solvers.row_threads import run
from cablewright.solvers.winched_tensions import (
    Choice,
    CoupledProgram,
    Found,
    WinchedLines,
    capacity_on_drums,
    closure,
    distributed,
    pressed,
    reduced_columns,
    require_both_ways,
    structures_at,
    with_board,
)

METHODS = {
    "closed-form": distribution.CLOSED,
    "improved-closed-form": distribution.IMPROVED,
    "least-norm": distribution.LEAST,
    "exact": distribution.WIDEST,
}
ACCURACY = 1e-12  # of the objective's own size: tolerance of the search for a general one
SEARCH_STEPS = 300


class Objective(Protocol):
    """A convex function of the tensions (m,), N, to be minimised."""

    def value(self, tensions: Array) -> float:
        """Return the value of the objective at tensions (m,), N."""

    def gradient(self, tensions: Array) -> Array:
        """Return the gradient (m,) of the objective at tensions (m,), N."""


@dataclass(frozen=True, eq=False)
class Quadratic:
    """Quadratic objective 1/2 t'Ht + g't of the tensions t.

    *hessian* H is (m, m), positive semidefinite, or (m,), a positive diagonal, which is compiled. *linear* is g (m,),
    zero if None.
    """

    hessian: Array
    linear: Array | None = None

    def value(self, tensions: Array) -> float:
        """Return the objective 1/2 t'Ht + g't of the tensions t."""
        linear = 0.0 if self.linear is None else float(self.linear @ tensions)
        return 0.5 * float(tensions @ self._times(tensions)) + linear

    def gradient(self, tensions: Array) -> Array:
        """Return the objective's gradient H t + g at the tensions t."""
        return self._times(tensions) + (0.0 if self.linear is None else self.linear)

    def checked(self, m: int) -> Quadratic:
        """Return the objective in arrays for *m* lines. Raises `InputError` if it does not fit or is not convex."""
        H = _finite(self.hessian, "hessian")
        g = np.zeros(m) if self.linear is None else _finite(self.linear, "linear")
        if H.shape not in ((m,), (m, m)) or g.shape != (m,):
            raise InputError(f"objective: hessian ({m},) or ({m}, {m}) and linear ({m},) are expected for {m} lines")
        if H.ndim == 1 and not (H > 0.0).all():
            raise InputError(f"objective: a diagonal hessian must be positive; got {H.min():g}")
        if H.ndim == 2:
            H = 0.5 * (H + H.T)
            smallest, largest = np.linalg.eigvalsh(H)[[0, -1]]
            if smallest < -1e-12 * max(largest, 0.0) or largest < 0.0:
                raise InputError(f"objective: the hessian must have no negative eigenvalue; it has {smallest:g}")
        return Quadratic(H, g)

    def _times(self, tensions: Array) -> Array:
        return np.asarray(self.hessian * tensions if self.hessian.ndim == 1 else self.hessian @ tensions)


@dataclass(frozen=True, eq=False)
class _OfWinches:
    """An objective of all tensions as one of those that winches decide."""

    objective: Objective
    own: WinchedLines

    def value(self, tensions: Array) -> float:
        """Return the value of the objective."""
        return self.objective.value(self._all(tensions))

    def gradient(self, tensions: Array) -> Array:
        """Return the gradient (m,) of the objective."""
        return self.objective.gradient(self._all(tensions))[self.own.winched]

    def _all(self, tensions: Array) -> Array:
        every = self.own.given.copy()
        every[self.own.winched] = tensions
        return every


class _AtPoses(Result, Rows):
    """The result at one pose, or at each of a batch."""

    SINGLE: ClassVar = ("margin", 0)

    code: NDArray[np.int64]

    @property
    def feasible(self) -> Mask:
        """Whether tensions within the limits were found; the closed forms may miss existing ones."""
        return np.asarray(self.code == 0)


@dataclass(frozen=True, eq=False, repr=False)
class Distribution(_AtPoses):
    """Tensions at one pose, or at each of a batch, by one method.

    `margin` (N) is the smallest distance of the tensions from their limits, negative where the worst is outside; -inf
    where no tensions of any size balance the load, or a line has no direction: `code` distinguishes these. For
    ``exact`` it is the largest possible. For ``wrench-closure`` tensions and margin are shares of the mean tension.
    Tensions are NaN where there are none; so is the margin where a solve failed.
    """

    FIGURES: ClassVar = (
        Figure("method", "", "How the tensions are chosen."),
        Figure("feasible", "", "Whether they are within their limits, as the method finds them."),
        Figure("margin", "N", "How far within; of wrench-closure a share of the mean."),
        Figure("tensions", "N", "Of each line; of wrench-closure shares of the mean."),
    )
    HEADLINES: ClassVar = ("method", "feasible", "margin")

    method: str
    poses: Array
    tensions: Array
    margin: Array
    code: NDArray[np.int64]


@dataclass(frozen=True, eq=False, repr=False)
class Capacity(_AtPoses):
    """Distance of the required wrenches from the boundary of those that the lines can balance within their limits.

    `margin` (N, moments divided by `length`, m) is the smallest distance from the facets of that set, negative outside.
    Where `rank` is less than the pose's degrees of freedom the set is flat: the margin is that within its plane, or the
    negative distance of a wrench from the plane. -inf where a line has no direction, or a counterweight exceeds a
    limit.
    """

    FIGURES: ClassVar = (
        Figure("length", "m", "The arm on which a moment counts as a force."),
        Figure("feasible", "", "Whether every requested wrench can be balanced."),
        Figure("margin", "N", "Margin of the requested wrenches within the available ones."),
        Figure("rank", "1", "Directions of wrench that the lines have."),
    )
    HEADLINES: ClassVar = ("length", "feasible", "margin", "rank")

    length: float
    poses: Array
    margin: Array
    rank: NDArray[np.int64]
    code: NDArray[np.int64]


def tension_distribution(
    robot: Robot | Model,
    poses: ArrayLike,
    method: str | Objective = "least-norm",
    *,
    wrench: ArrayLike | None = None,
    retraction: ArrayLike | None = None,
    cable: CableLaw | str | None = None,
    sheave: SheaveLaw | str | None = None,
    tension_limits: tuple[float, float] | None = None,
) -> Distribution:
    """Compute tensions at *poses*, (n,) or (N, n) in m and rad, by *method*.

    ``closed-form`` is Jung 2020, Eq. 8: the tensions nearest to the middle of the limits, feasible if they happen to be
    within. ``improved-closed-form`` sets the line furthest outside to its limit and repeats. ``least-norm``, as
    `inverse`, minimises the sum of squares within the limits, or where these let redundant lines hang slack that of
    the distances from `preferred_tensions`. ``exact`` maximises the distance from the limits: its margin is the largest
    s for which tensions from min + s to max - s exist, negative where the limits would have to be relaxed. An objective
    is minimised within the limits: a `Quadratic`, compiled if its hessian is diagonal, or any convex `Objective`, which
    is slow. Elastic lines that share a winch have tensions that fit their drum; rigid ones have none where their
    lengths do not fit it. Their programs are not compiled. On a plane that only pushes ``exact`` seeks press.

    *wrench* (n,) or (N, n), N and N m, world, acts besides the weight and replaces the platform's own; *retraction* is
    the platform's retraction length, m. Raises `InputError` for an unknown method, numbers of the wrong count or not
    finite, or cables with weight. The default of *cable* is ``rigid``.

    Examples
    --------
    >>> import cablewright as cw
    >>> bool(cw.tension_distribution(cw.load("jung2020"), [0.7, 0.6, 0.9]).feasible)
    True
    """
    model = Model.of(robot, cable=cable, sheave=sheave, tension_limits=tension_limits, default=CableLaw.RIGID)
    if wrench is None:
        require_a_load(model)
    given, single = as_poses(model, poses, "pose")
    packed = _packed(model, len(given), wrench, retraction)
    curvature, bias, sought = np.ones(model.m), np.zeros(model.m), None
    if isinstance(method, str):
        if method not in METHODS:
            raise UnknownName("tension distribution", method, METHODS)
        name, chosen = method, METHODS[method]
        preferred = preferred_tensions(model)
        bias = bias if preferred is None else preferred[0]
    else:
        name, chosen = "objective", distribution.LEAST
        if not (hasattr(method, "value") and hasattr(method, "gradient")):
            raise InputError(f"method = {method!r:.60}: one of {', '.join(METHODS)} or an Objective is expected")
        sought = method.checked(model.m) if isinstance(method, Quadratic) else method
        if isinstance(sought, Quadratic) and sought.hessian.ndim == 1:
            assert sought.linear is not None
            curvature, bias, sought = sought.hessian, -sought.linear, None
    widest = chosen == distribution.WIDEST
    if model.robot.sharing:
        choose = partial(_chosen, method=chosen, curvature=curvature, bias=bias, objective=sought)
        found = Distribution(name, given, *distributed(model, packed, given, choose))
    elif widest and model.pushes_point:
        own, ones = with_board(model, packed, given), np.ones(model.m + 1)
        tensions, margins, codes = own.completed(_swept(own, given, chosen, ones, 0.0 * ones))
        found = Distribution(name, given, tensions[:, :-1], margins, codes)
    else:
        own = WinchedLines.at(model, packed, given)
        swept = _swept(own, given, chosen, curvature, bias) if sought is None else _searched(own, given, sought)
        found = Distribution(name, given, *pressed(model, packed, given, own.completed(swept), widest=widest))
    return found[0] if single else found


def _chosen(
    program: CoupledProgram, *, method: int, curvature: Array, bias: Array, objective: Objective | None
) -> Choice:
    """The tensions of lines on common drums by a method, or by an *objective*."""
    if objective is not None:
        widest, margin, code = program.widest()
        if code != Code.OK:
            return np.full_like(widest, np.nan), margin, code
        tensions = _search(objective, program.rows, widest, program.low, program.high)
        lost = np.full_like(widest, np.nan), np.nan, Code.NOT_CONVERGED
        return lost if tensions is None else program.judged(tensions)
    if method == distribution.LEAST:
        return program.least(curvature, bias)
    return {distribution.CLOSED: program.nearest, distribution.IMPROVED: program.improved}.get(method, program.widest)()


def wrench_closure(
    robot: Robot | Model,
    poses: ArrayLike,
    *,
    retraction: ArrayLike | None = None,
    cable: CableLaw | str | None = None,
    sheave: SheaveLaw | str | None = None,
) -> Distribution:
    """Test wrench closure at *poses*: lines without an upper tension limit can balance any wrench.

    This requires a structure matrix of full rank with a positive null vector, of the lines with a winch: a
    counterweight pulls with one tension, and its share is 0. Tensions of elastic lines on one drum grow together, as
    their drum lets them.

    Tensions are the null vector of mean 1 whose smallest entry is largest, and that entry is the margin: at most 1,
    feasible if positive; -inf where the rank is not full or no null vector has a positive sum.
    """
    model = Model.of(robot, cable=cable, sheave=sheave, default=CableLaw.RIGID)
    given, single = as_poses(require_both_ways(model, "wrench-closure"), poses, "pose")
    if model.robot.sharing:
        choose = partial(closure, winched=model.lines.counterweight == 0.0, freedoms=model.freedoms, balance=model.n)
        packed = _packed(model, len(given), None, retraction)
        found = Distribution("wrench-closure", given, *distributed(model, packed, given, choose, loaded=False))
        return found[0] if single else found
    own = WinchedLines.at(model, _packed(model, len(given), None, retraction), given)
    own = replace(own, given=np.zeros(model.m), room=np.inf)  # no tension that is given grows with the load
    swept = _swept(own, given, distribution.CLOSURE, np.ones(model.m), np.zeros(model.m))
    found = Distribution("wrench-closure", given, *own.completed(swept))
    return found[0] if single else found


def capacity(
    robot: Robot | Model,
    poses: ArrayLike,
    *,
    wrench: ArrayLike | None = None,
    box: tuple[ArrayLike, ArrayLike] | None = None,
    length: float = 1.0,
    retraction: ArrayLike | None = None,
    cable: CableLaw | str | None = None,
    sheave: SheaveLaw | str | None = None,
    tension_limits: tuple[float, float] | None = None,
) -> Capacity:
    """Compute the capacity margin at *poses* of a *wrench*, or of the worst wrench of a *box*.

    *box* is the lowest and the highest wrench (n,), N and N m, world; *wrench* as in `tension_distribution`. Moments
    are divided by *length* (m) to compare them with forces. The time grows with the number of choices of n - 1 of the m
    lines. Elastic lines on one drum count as one, to the first order in strains. Raises `InputError`.
    """
    if not 0.0 < length < float("inf"):
        raise InputError(f"length {length:g} m: a positive number is expected, by which moments are divided")
    model = Model.of(robot, cable=cable, sheave=sheave, tension_limits=tension_limits, default=CableLaw.RIGID)
    given, single = as_poses(require_both_ways(model, "capacity"), poses, "pose")
    half = np.zeros(model.n)
    if box is None and wrench is None:
        require_a_load(model)
    if box is not None:
        if wrench is not None:
            raise InputError("wrench and box: give one of them")
        low, high = (as_rows(side, model.n, "box", "N and N m")[0][0] for side in box)
        if (low > high).any():
            worst = int(np.argmax(low - high))
            pair = f"number {worst + 1} is {low[worst]:g}, {high[worst]:g}"
            raise InputError(f"box: lowest <= highest is expected; {pair}")
        wrench, half = 0.5 * (low + high), 0.5 * (high - low)
        if model.robot.platform.in_tilted_plane:
            raise InputError("box: its sides are along the world's axes, and the plane of the platform is tilted")
    packed, rows = _packed(model, len(given), wrench, retraction), len(given)
    if model.robot.sharing:
        found = Capacity(float(length), given, *capacity_on_drums(model, packed, given, half, length))
        return found[0] if single else found
    own = WinchedLines.at(model, packed, given)
    margins, ranks, codes = np.zeros(rows), np.zeros(rows, np.int64), np.zeros(rows, np.int64)
    arrays = (own.packed, given, half, float(length), margins, ranks, codes)
    run(capacity_margin.capacity_rows, rows, *arrays)
    margins, codes = own.judged(np.where(own.room < 0.0, -np.inf, margins), codes)
    found = Capacity(float(length), given, margins, ranks, codes)
    return found[0] if single else found


def structures(
    model: Model, poses: ArrayLike, *, wrench: ArrayLike | None = None, retraction: ArrayLike | None = None
) -> tuple[Array, Array]:
    """Return structure matrices A (N, n, m) and wrenches w (N, n) of A t + w = 0 at *poses* (N, n); NaN if undefined.

    Column i is the wrench of line i about the platform's origin, per newton of its tension; NaN without a direction.
    The part that a plane carries is left out of both.
    """
    given, _ = as_poses(model, poses, "pose")
    return structures_at(_packed(model, len(given), wrench, retraction), given)


def drum_structures(
    model: Model, poses: ArrayLike, *, retraction: ArrayLike | None = None
) -> tuple[Array, Array, Array, NDArray[np.int64]]:
    """Return `reduced_columns` of a robot whose lines share winches, at *poses* (N, n)."""
    given, _ = as_poses(model, poses, "pose")
    return reduced_columns(model, _packed(model, len(given), None, retraction), given)


def self_stresses(equilibrium: Equilibrium) -> Array:
    """Return orthonormal directions (c, m) of tensions that balance each other, at a single *equilibrium*.

    c is max(k - degrees of freedom, 0). k: the number of lines without a counterweight, whose tension is given. For
    straight lines from exit point to platform point; along these directions the pose hardly changes.
    """
    n, points = equilibrium.model.freedoms, equilibrium.platform_points
    winched = equilibrium.lines.counterweight == 0.0
    free = equilibrium.model.free_directions
    chords = points - equilibrium.lines.exit_point
    units = equilibrium.lines.pulls[:, None] * chords / np.linalg.norm(chords, axis=1)[:, None]
    units = along_chords(equilibrium.model.n, units, points - equilibrium.pose[:3])
    if free is not None:
        units = units @ free
    found = np.zeros((max(int(winched.sum()) - n, 0), len(winched)))
    if len(found):
        found[:, winched] = np.linalg.svd(units[winched].T)[2][n:]
    return found


def _packed(model: Model, rows: int, wrench: ArrayLike | None, retraction: ArrayLike | None) -> Packed:
    """The arrays of the model, with a row of lines or of the platform for each pose where these differ."""
    if model.fidelity.cable is CableLaw.CATENARY:
        raise InputError("cable = catenary: tension distributions require straight lines; use rigid or elastic")
    packed = model.rows(retraction=given_numbers(retraction, rows, "retraction", "m"))
    if wrench is None:
        return packed
    given = given_rows(wrench, rows, model.n, "wrench", "N and N m")
    platform = PlatformNumbers(np.repeat(packed.platform[:1], rows, axis=0))
    platform.wrench[:, : model.n] = given
    return packed._replace(platform=platform.array)


def _swept(own: WinchedLines, poses: Array, method: int, curvature: Array, bias: Array) -> Found:
    rows, m = len(poses), own.packed.lines.shape[1]
    tensions, margins, codes = np.zeros((rows, m)), np.zeros(rows), np.zeros(rows, np.int64)
    diagonals = (np.ascontiguousarray(each[own.winched]) for each in (curvature, bias))
    arrays = (own.packed, poses, method, *diagonals, tensions, margins, codes)
    run(distribution.distribute_rows, rows, *arrays)
    return tensions, margins, codes


def _searched(own: WinchedLines, poses: Array, objective: Objective) -> Found:
    """Minimise a general objective in the null space of each pose, from the tensions furthest from the limits."""
    m = len(own.winched)
    tensions, margins, codes = _swept(own, poses, distribution.WIDEST, np.ones(m), np.zeros(m))
    limits = np.broadcast_to(LineNumbers(own.packed.lines).tension_limits, (*tensions.shape, 2))
    A, _ = structures_at(own.packed, poses)
    chosen = _OfWinches(objective, own)
    for row in np.flatnonzero(codes == 0):
        found = _search(chosen, A[row], tensions[row], *limits[row].T)
        if found is None:
            tensions[row], margins[row], codes[row] = np.nan, np.nan, Code.NOT_CONVERGED
        else:
            tensions[row] = found
            margins[row] = np.min([found - limits[row, :, 0], limits[row, :, 1] - found])
    return tensions, margins, codes


def _search(objective: Objective, A: Array, start: Array, low: Array, high: Array) -> Array | None:
    """Minimise over tensions within limits with the wrench of *start*; None if the search fails."""
    from scipy.linalg import null_space
    from scipy.optimize import minimize

    basis = null_space(A, rcond=1e-10)
    if basis.shape[1] == 0:
        return start
    size = float(np.max(high - low))  # tensions and values of about one
    first = float(np.abs(objective.gradient(start)).max()) * size or 1.0
    rows = size * np.concatenate([basis, -basis])
    room = np.concatenate([start - low, high - start])
    found = minimize(
        lambda y: objective.value(start + size * basis @ y) / first,
        np.zeros(basis.shape[1]),
        jac=lambda y: size * basis.T @ objective.gradient(start + size * basis @ y) / first,
        method="SLSQP",
        constraints={"type": "ineq", "fun": lambda y: rows @ y + room, "jac": lambda _: rows},
        options={"ftol": ACCURACY, "maxiter": SEARCH_STEPS},
    )
    return np.clip(start + size * basis @ found.x, low, high) if found.success else None


def _finite(values: ArrayLike, what: str) -> Array:
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"objective: {what} must be numbers") from None
    if not np.isfinite(array).all():
        raise InputError(f"objective: every number of {what} must be finite")
    return array
