"""Tensions of straight lines beside counterweights, and of lines that share winches, coupled by their stretch.

Those of counterweights are given, and part of the load of the others. A line on another's drum has the length offset +
sense * L of that line. At a pose the length of a straight elastic line follows from its tension, so that the tension of
each such line is a function of that of its host. The functions are linearised at the tensions of the last round: a
linear program, or a quadratic one, in each round. Rigid cables leave tensions free where their lengths fit the drums;
elsewhere they have none.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import combinations, product
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.kernels.layout import OK, Code, Packed
from cablewright.kernels.shared_winches.quadratic_program import AGREE
from cablewright.kernels.statics.tension_distribution import SOFT, Program, distribute
from cablewright.kernels.wrench_feasibility.distribution import structure_rows
from cablewright.models.packed_views import LineNumbers, PlatformNumbers
from cablewright.models.shared_drum_tensions import Drums
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Line
from cablewright.robot.sheave import Eyelet

ROUNDS: Final = 4
"""Linearisations of the drums: strains are small, and the error of each is the square of that before."""
BALANCED: Final = 1e-9  # of the load: unbalanced part that is due to rounding
FLAT: Final = 1e-9  # of the largest singular value under which columns count as dependent
CLOSED_BY: Final = 1e-9  # of the mean tension: min entry of a null vector that counts as positive
UNBOUNDED: Final = 1e3  # of the mean tension: upper limit of a null vector's entries
_FAR: Final = 10.0  # times all forces together: upper limit of the press on a plane, which none reaches
_LP: Final = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}

Choice = tuple[Array, float, int]  # tensions (m,), N, margin, N, and code
_NONE_AT_ALL: Final = -np.inf
Found = tuple[Array, Array, NDArray[np.int64]]  # tensions (N, m), margins (N,) and codes (N,)


@dataclass(frozen=True, eq=False)
class WinchedLines:
    """The winch-driven lines of a robot at N poses; counterweights are part of the load."""

    packed: Packed  # of the lines with a winch
    winched: Mask  # (m,) which lines these are
    given: Array  # (m,) N: tensions that counterweights hold; 0 of a line with a winch
    room: float  # N: smallest distance of a given tension from the limits of its line
    codes: NDArray[np.int64]  # (N,) why a line has no direction at a pose

    @classmethod
    def at(cls, model: Model, packed: Packed, poses: Array) -> WinchedLines:
        """Return the winch-driven lines of *model*, whose arrays for *poses* (N, n) are *packed*."""
        given = model.lines.counterweight
        winched, codes = given == 0.0, np.zeros(len(poses), np.int64)
        if winched.all():
            return cls(packed, winched, given, np.inf, codes)
        limits = model.lines.tension_limits
        structures, _ = structures_at(packed, poses, codes)
        rows = np.repeat(packed.platform, len(poses), axis=0) if len(packed.platform) == 1 else packed.platform.copy()
        PlatformNumbers(rows).wrench[:, : model.n] += np.nan_to_num(structures) @ given
        room = float(np.minimum(given - limits[:, 0], limits[:, 1] - given)[~winched].min())
        lines = np.ascontiguousarray(packed.lines[:, winched])
        return cls(packed._replace(lines=lines, platform=rows), winched, given, room, codes)

    def completed(self, found: Found) -> Found:
        """Return tensions *found* for winch-driven lines, completed by counterweights, with margins to the limits."""
        if self.winched.all():
            return found
        tensions = np.tile(self.given, (len(found[0]), 1))
        tensions[:, self.winched] = found[0]
        lost = (self.codes != OK) | np.isnan(found[0]).any(axis=1)
        tensions[lost] = np.nan
        margins, codes = self.judged(np.minimum(found[1], self.room), found[2])
        return tensions, margins, codes

    def judged(self, margins: Array, codes: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64]]:
        """Return *margins* and *codes* (N,) where lines without a direction and given tensions out of limits count."""
        outside = (codes == OK) & (self.room < 0.0)
        codes = np.where(self.codes != OK, self.codes, np.where(outside, Code.INFEASIBLE, codes))
        return np.where(self.codes != OK, -np.inf, margins), codes


def structures_at(packed: Packed, poses: Array, codes: NDArray[np.int64] | None = None) -> tuple[Array, Array]:
    """Return structure matrices (N, n, m) and wrenches (N, n) at *poses* (N, n); NaN where *codes* (N,) are not OK."""
    rows, n, m = len(poses), packed.freedoms, packed.lines.shape[1]
    A, w = np.zeros((rows, n, m)), np.zeros((rows, n))
    structure_rows(packed, poses, A, w, np.zeros(rows, np.int64) if codes is None else codes)
    return A, w


class Press(NamedTuple):
    """Force of the platform on a plane that only pushes: by each line per newton of tension, and by the load."""

    lines: Array  # (m,), or (N, m) at N poses
    load: Array  # N: (), or (N,)

    @classmethod
    def at(cls, model: Model, packed: Packed, poses: Array) -> Press | None:
        """Return it at *poses* (N, n); None without such a plane. NaN where a line has no direction."""
        if not model.robot.platform.may_lift:
            return None
        free = PlatformNumbers(packed.platform.copy())
        free.held, normal = 0.0, free.normal[0]
        structures, wrenches = structures_at(packed._replace(platform=free.array), poses)
        return cls(-(normal @ structures[:, :3]), -(wrenches[:, :3] @ normal))

    def at_row(self, row: int) -> Press:
        """Return the force at one of the poses."""
        return Press(self.lines[row], self.load[row])

    def of(self, tensions: Array) -> Array:
        """Return the force (...), N, of *tensions* (..., m): negative where they lift the platform."""
        found = (self.lines * tensions).sum(axis=-1) + self.load
        return np.asarray(np.where(np.abs(found) <= BALANCED * np.abs(tensions).max(axis=-1), 0.0, found))


@dataclass(frozen=True, eq=False)
class CoupledProgram:
    """Search for tensions t (m,), N, at one pose: rows @ t = load, within limits from *low* to *high*.

    Off a plane that only pushes they do not lift the platform: its *press* is then at least 0.
    """

    rows: Array
    load: Array
    low: Array
    high: Array
    press: Press | None = None

    def nearest(self) -> Choice:
        """Return the tensions nearest to the middle of the limits (Jung 2020, Eq. 8)."""
        return self.judged(self._nearest(self.rows, self.load))

    def improved(self) -> Choice:
        """Return tensions by the improved closed form: the worst violating line is set to its limit, repeatedly."""
        rows, load = self.rows, self.load
        tensions = self._nearest(rows, load)
        for _ in self.low:
            beyond = np.maximum(self.low - tensions, tensions - self.high)
            worst = int(np.argmax(beyond))
            if not beyond[worst] > BALANCED * abs(tensions).max():
                break
            aim = np.clip(tensions[worst], self.low[worst], self.high[worst])
            more = np.vstack([rows, np.eye(len(tensions))[worst]])
            if np.linalg.matrix_rank(more, tol=FLAT) == np.linalg.matrix_rank(rows, tol=FLAT):
                break
            rows, load = more, np.append(load, aim)
            tensions = self._nearest(rows, load)
        return self.judged(tensions)

    def widest(self) -> Choice:
        """Return the tensions farthest from their limits: their margin is negative where no tensions are within."""
        from scipy.optimize import linprog

        m, one = len(self.low), np.ones((len(self.low), 1))
        sides, most = np.block([[-np.eye(m), one], [np.eye(m), one]]), np.concatenate([-self.low, self.high])
        if self.press is not None:
            sides, most = np.vstack([sides, [*-self.press.lines, 1.0]]), np.append(most, self.press.load)
        found = linprog(
            [0.0] * m + [-1.0],
            A_ub=sides,
            b_ub=most,
            A_eq=np.column_stack([self.rows, np.zeros(len(self.rows))]),
            b_eq=self.load,
            bounds=(None, None),
            options=_LP,
        )
        return self.judged(found.x[:m]) if found.status == 0 else (np.full(m, np.nan), np.nan, Code.NOT_CONVERGED)

    def least(self, curvature: Array, bias: Array) -> Choice:
        """Return tensions that minimise the sum of curvature t^2 / 2 - bias t, or else violate the limits least."""
        count, m = self.rows.shape
        tensions, first = np.zeros(m), 0
        for give in (0.0, SOFT):
            program = Program(np.ascontiguousarray(self.rows), self.load, self.low, self.high, curvature, bias)
            scratch = np.zeros(count), np.zeros((count, count)), np.zeros((count, 3))
            solved = int(distribute(program, give, tensions, *scratch))
            first = solved if give == 0.0 else first
            if solved == 1:
                code = {1: Code.OK, 0: Code.INFEASIBLE}.get(first, Code.NOT_CONVERGED)
                _, margin, judged = self.judged(tensions)
                return tensions, margin, judged if code == Code.OK and self.press is not None else code
        return np.full(m, np.nan), np.nan, Code.NOT_CONVERGED

    @property
    def balances(self) -> bool:
        """Return whether tensions of any size solve the equations."""
        tensions = np.linalg.lstsq(self.rows, self.load, rcond=FLAT)[0]
        return bool(np.abs(self.rows @ tensions - self.load).max() <= 10.0 * BALANCED * np.abs(self.load).max())

    def _nearest(self, rows: Array, load: Array) -> Array:
        middle = 0.5 * (self.low + self.high)
        return np.asarray(middle + np.linalg.lstsq(rows, load - rows @ middle, rcond=FLAT)[0])

    def judged(self, tensions: Array) -> Choice:
        """Return *tensions* with their margin, and whether they are within the limits."""
        margin = float(np.min([tensions - self.low, self.high - tensions]))
        margin = margin if self.press is None else min(margin, float(self.press.of(tensions)))
        least = -BALANCED * np.abs(tensions).max()
        return tensions, margin if not least < margin < 0.0 else 0.0, Code.OK if margin >= least else Code.INFEASIBLE


def drum_stresses(equilibrium: Equilibrium, stresses: Array) -> Array:
    """Return orthonormal combinations (c, m) of *stresses* (k, m) that keep the shared drums, of a batch of one row."""
    from scipy.linalg import null_space

    drums = Drums.at(equilibrium.model, equilibrium.packed, equilibrium.pose, equilibrium.tensions)
    kept = null_space(drums.rows(0, equilibrium.model.m)[0] @ stresses.T, rcond=FLAT)
    return np.asarray(kept.T @ stresses)


def distributed(
    model: Model, packed: Packed, poses: Array, choose: Callable[[CoupledProgram], Choice], *, loaded: bool = True
) -> Found:
    """Choose tensions at *poses* (N, n) of lines of which some share winches: tensions, margins and codes.

    Not *loaded*: the equations are homogeneous, as those of tensions without a limit.
    """
    codes, m = np.zeros(len(poses), np.int64), model.m
    structures, wrenches = structures_at(packed, poses, codes)
    limits = np.broadcast_to(LineNumbers(packed.lines).tension_limits, (len(poses), m, 2))
    weights, press = model.lines.counterweight, Press.at(model, packed, poses) if loaded else None
    tensions, margins = np.where(weights > 0.0, weights, limits.mean(axis=-1)), np.full(len(poses), _NONE_AT_ALL)
    around, outcome = tensions, codes
    for _ in range(ROUNDS if loaded else 1):
        drums = Drums.at(model, packed, poses, around)
        tensions, outcome = np.full((len(poses), m), np.nan), np.where(codes == 0, Code.INFEASIBLE, codes)
        margins[:] = _NONE_AT_ALL
        for row in np.flatnonzero((codes == 0) & (drums.misfit <= AGREE)).tolist():
            own = None if press is None else press.at_row(row)
            program = _program(structures[row], wrenches[row], drums.rows(row, m), weights, limits[row], own, loaded)
            if program.balances:
                tensions[row], margins[row], outcome[row] = choose(program)
        around = np.where(np.isnan(tensions), around, np.clip(tensions, 1e-3 * limits[..., 1], None))
    return tensions, margins, outcome


def _program(
    structure: Array, wrench: Array, drums: tuple[Array, Array], weights: Array, limits: Array,
    press: Press | None, loaded: bool,
) -> CoupledProgram:  # fmt: skip
    """The equations of balance, drums and counterweights."""
    held = np.flatnonzero(weights > 0.0)
    rows = np.vstack([structure, drums[0], np.eye(len(weights))[held]])
    load = np.concatenate([-wrench, drums[1], weights[held]])
    low, high = np.ascontiguousarray(limits.T)
    return CoupledProgram(rows, load if loaded else np.zeros(len(load)), low, high, press)


def pressed(model: Model, packed: Packed, poses: Array, found: Found, *, widest: bool) -> Found:
    """Return tensions *found* at *poses* (N, n), and margins that count the press on a plane that only pushes.

    Of the *widest*, those with it replace them where it is less than their margin; others that lift are infeasible.
    """
    (tensions, margins, codes), press = found, Press.at(model, packed, poses)
    if press is None:
        return found
    by_press = np.where(np.isnan(tensions).any(axis=1), np.inf, press.of(tensions))
    if not widest:
        codes = np.where((by_press < 0.0) & (codes == Code.OK), Code.INFEASIBLE, codes)
        return tensions, np.minimum(margins, by_press), codes
    tensions, margins, codes = tensions.copy(), margins.copy(), codes.copy()
    structures, wrenches = structures_at(packed, poses)
    limits = np.broadcast_to(LineNumbers(packed.lines).tension_limits, (len(poses), model.m, 2))
    none, weights = (np.empty((0, model.m)), np.empty(0)), model.lines.counterweight
    for row in np.flatnonzero(by_press < margins).tolist():
        program = _program(structures[row], wrenches[row], none, weights, limits[row], press.at_row(row), loaded=True)
        tensions[row], margins[row], codes[row] = program.widest()
    return tensions, margins, codes


def require_both_ways(model: Model, what: str) -> Model:
    """Return *model*; raise `InputError` for a plane that only pushes: *what* takes planes to hold both ways."""
    if model.robot.platform.may_lift:
        raise InputError(
            f"{what}: takes the plane of {model.robot.name!r} to hold both ways, and it only pushes: use exact or "
            "static, or give platform.plane one_sided = false"
        )
    return model


def with_board(model: Model, packed: Packed, poses: Array) -> WinchedLines:
    """Return the lines at *poses* (N, 3) of a point, and a plane that only pushes as the last one, with its press."""
    robot, plane = model.robot.with_platform(plane=None), model.robot.platform.plane
    assert plane is not None
    cable, limits = robot.lines[0].cable, robot.lines[0].tension_limits
    board = Line(name="plane", exit_point=plane.across, cable=cable, sheave=Eyelet(), tension_limits=limits)
    whole = replace(model, robot=robot.model_copy(update={"lines": (*robot.lines, board)}), preferred=None)
    free, lines = PlatformNumbers(packed.platform.copy()), LineNumbers(packed.lines)
    added = LineNumbers(np.repeat(whole.rows().lines[:, -1:], len(poses), axis=0))
    added.exit_point = (poses + free.normal[0])[:, None]
    most = (
        (lines.tension_max * lines.pulls).sum(axis=-1).max()
        + free.weight.max()
        + np.abs(free.wrench).sum(axis=-1).max()
    )
    free.held, added.tension_min, added.tension_max = 0.0, 0.0, _FAR * most
    own = np.broadcast_to(packed.lines, (len(poses), *packed.lines.shape[1:]))
    all_lines = np.ascontiguousarray(np.concatenate([own, added.array], axis=1))
    arrays = packed._replace(lines=all_lines, platform=free.array)
    return WinchedLines.at(whole, arrays, poses)


def closure(program: CoupledProgram, winched: Mask, freedoms: int, balance: int) -> Choice:
    """Test wrench closure: return the null vector of mean 1 whose smallest entry is largest, which is its margin.

    -inf where the lines with a winch (*winched*, (m,)), coupled by their drums, do not reach all *freedoms*. The first
    rows, *balance* of them, are those of the balance.
    """
    from scipy.linalg import null_space
    from scipy.optimize import linprog

    m, none = len(winched), np.full(len(winched), np.nan)
    coupled = null_space(program.rows[balance:], rcond=FLAT) if len(program.rows) > balance else np.eye(m)
    if np.linalg.matrix_rank(program.rows[:balance] @ coupled, tol=FLAT) < freedoms:
        return none, _NONE_AT_ALL, Code.SINGULAR
    own = winched.astype(float)
    found = linprog(
        [0.0] * m + [-1.0],
        A_ub=np.column_stack([-np.eye(m), own]),
        b_ub=np.zeros(m),
        A_eq=np.vstack([np.column_stack([program.rows, np.zeros(len(program.rows))]), [*own, 0.0]]),
        b_eq=[*np.zeros(len(program.rows)), own.sum()],
        bounds=[(None, UNBOUNDED)] * (m + 1),
        options=_LP,
    )
    if found.status != 0:
        return none, _NONE_AT_ALL, Code.INFEASIBLE
    margin = float(found.x[-1])
    return found.x[:m], margin, Code.OK if margin > CLOSED_BY else Code.INFEASIBLE


def reduced_columns(model: Model, packed: Packed, poses: Array) -> tuple[Array, Array, Array, NDArray[np.int64]]:
    """Return the wrenches that drums apply at *poses* (N, n): columns (N, n, k) per newton of a host's tension.

    Also wrenches (N, n), N and N m, that do not change with these, of the platform and of its lines; limits (N, k, 2),
    N, of the hosts' tensions; and codes (N,). To the first order in strains about the middle of the limits.
    """
    codes = np.zeros(len(poses), np.int64)
    structures, wrenches = structures_at(packed, poses, codes)
    limits = np.array(np.broadcast_to(LineNumbers(packed.lines).tension_limits, (len(poses), model.m, 2)))
    weights = model.lines.counterweight
    outside = ((limits[..., 0] > weights) | (weights > limits[..., 1])) & (weights > 0.0)
    limits[:, weights > 0.0] = weights[weights > 0.0, None]
    drums = Drums.at(model, packed, poses, limits.mean(axis=-1))
    columns, left = [], []
    for row in range(len(poses)):
        matrix, offsets, own = drums.reduced(row, limits[row])
        columns.append(structures[row] @ matrix)
        left.append(own)
        wrenches[row] += structures[row] @ offsets
    ends = np.array(left)
    none = outside.any(axis=1) | (drums.misfit > AGREE) | (ends[..., 0] > ends[..., 1]).any(axis=1)
    return np.array(columns), wrenches, ends, np.where((codes == 0) & none, Code.INFEASIBLE, codes)


def capacity_on_drums(
    model: Model, packed: Packed, poses: Array, half: Array, length: float
) -> tuple[Array, NDArray[np.int64], NDArray[np.int64]]:
    """Return capacity margins (N,), N, ranks and codes at *poses* (N, n) of a robot with shared drums.

    For the box of wrenches of sides 2 *half* (n,). Moments are divided by *length*, m.
    """
    columns, wrenches, limits, codes = reduced_columns(model, packed, poses)
    arms = np.array([1.0] * 3 + [1.0 / length] * 3)[: model.n]
    free = np.eye(model.n) if model.free_directions is None else model.free_directions
    margins, ranks = np.full(len(poses), -np.inf), np.zeros(len(poses), np.int64)
    for row in np.flatnonzero(np.isfinite(columns).all(axis=(1, 2))):
        loads, sides = free.T @ (-wrenches[row] * arms), np.abs(free.T) @ (half * arms)
        scaled = free.T @ (arms[:, None] * columns[row])
        margins[row], ranks[row] = _margin(scaled, loads, sides, limits[row])
    margins[codes != Code.OK] = -np.inf
    return margins, ranks, np.where((codes == Code.OK) & (margins < 0.0), Code.INFEASIBLE, codes)


def _margin(columns: Array, load: Array, half: Array, limits: Array) -> tuple[float, int]:
    """Return the margin, N, by which columns (f, k) within *limits* (k, 2), N, balance *load* (f,), and their rank.

    The load is anywhere within *half* (f,) of its middle. Each facet of the set of wrenches is parallel to rank - 1
    columns. As `kernels/wrench_feasibility/capacity_margin.py`.
    """
    axes, sizes, _ = np.linalg.svd(columns)
    rank = int((sizes > FLAT * sizes[0]).sum())
    corners = load + np.array(list(product((-1.0, 1.0), repeat=len(half)))) * half
    aside = np.linalg.norm(corners @ axes[:, rank:], axis=1).max() if rank < len(axes) else 0.0
    if aside > BALANCED * np.abs(corners).max():
        return -float(aside), rank
    basis = axes[:, :rank]
    inner = basis.T @ columns
    chosen = np.array(list(combinations(range(inner.shape[1]), rank - 1)), dtype=np.int64)
    beside = np.moveaxis(inner[:, chosen], 0, -1)
    _, parts, rows = np.linalg.svd(beside)
    normals = rows[..., -1, :] @ basis.T
    if rank > 1:
        normals = normals[parts[:, -1] > FLAT * parts[:, 0]]
    pulls = normals @ columns
    upper = np.maximum(pulls * limits[:, 0], pulls * limits[:, 1]).sum(axis=1)
    lower = np.minimum(pulls * limits[:, 0], pulls * limits[:, 1]).sum(axis=1)
    along = normals @ load
    spread = np.abs(normals) @ half
    return float((np.minimum(upper - along, along - lower) - spread).min()), rank
