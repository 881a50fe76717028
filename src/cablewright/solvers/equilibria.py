"""All equilibria for given lengths that many starts find: slack or taut, stable or not, with levers upside down too."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import product
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import AnswerError, InputError, Status
from cablewright.foundation.results import Figure, Result
from cablewright.kernels import batches
from cablewright.kernels.layout import Code
from cablewright.kernels.statics.line.catenary import span
from cablewright.models.fidelity import CableLaw, SheaveLaw
from cablewright.models.packed_views import LineNumbers, LineStates, blank_states
from cablewright.models.plane import within
from cablewright.models.rotation import angle_between, rotations
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.solvers.arguments import as_rows
from cablewright.solvers.certify import Certificate, certify
from cablewright.solvers.forward import solve_forward, solve_from
from cablewright.solvers.uniqueness import unique_among

ALL_PATTERNS = 6  # largest number of levers for which every pattern of upside-down levers is tried
PULLS = (1.0, 30.0)  # tensions, times a line's share of the load, at which levers are placed
STARTS = {3: 12, 6: 400}
"""Default number of random start poses for each pattern of levers, by degrees of freedom."""
SAME_POSE = 1e-6  # m, rad; largest difference of equal poses
SAME_SHAPE = 1e-5  # of log tension, rad, m; largest difference of equal line states
OUTSIDE = 0.25  # of the frame: margin of the default box around it
FOUND = tuple(
    list(Status).index(status)
    for status in (Status.OK, Status.OVERSTRETCHED, Status.LEVER_UNSTABLE, Status.UNSTABLE, Status.SINGULAR)
)


class FoundEquilibrium(NamedTuple):
    """One of the equilibria that were found, with stability, tensions and slack lines."""

    equilibrium: Equilibrium
    stable: bool
    slack: Mask  # (m,)
    certificate: Certificate

    @property
    def slack_lines(self) -> list[str]:
        """Names of the slack lines."""
        lines = self.equilibrium.model.robot.lines
        return [line.name for line, slack in zip(lines, self.slack, strict=True) if slack]


class UndecidedBox(NamedTuple):
    """A box in which an exhaustive search proved nothing, and why."""

    box: Array  # (6,) m: x, y, z, min and max of each
    why: str


ONE = (
    Figure("status", "", "Status of the solve: ok, overstretched, lever-unstable, unstable or singular.",
           "equilibrium.status.word"),
    Figure("stable", "", "Whether the equilibrium is stable.", detail=True),
    Figure("pose", "m, rad", "Position and, of a rigid platform, rotation vector of its origin.", "equilibrium.pose",
           digits=6),
    Figure("tensions", "N", "Tension of each line at its sheave.", "equilibrium.tensions", detail=True),
    Figure("slack", "", "Whether each line is slack: its free span is longer than the chord.", detail=True),
    Figure("slack_lines", "", "Names of the slack lines."),
    Figure("certified", "", "Whether exactly one equilibrium is proved to be near.", "certificate.certified"),
    Figure("bound", "m, rad", "Proved error of the pose; null where nothing is proved.", "certificate.bound",
           detail=True),
)  # fmt: skip
UNDECIDED = (
    Figure("box", "m", "Box: min and max of x, y and z.", shown="m"),
    Figure("why", "", "Why nothing is proved of the box."),
)


@dataclass(frozen=True, eq=False, repr=False)
class Equilibria(Result):
    """K equilibria for the same lengths, stable ones first, then by rising height.

    `len()` is K, and iteration yields each `Equilibrium`.
    """

    FIGURES: ClassVar = (
        Figure("status", "", "ok, unfinished, overstretched: a line is over its breaking load in every stable one, or "
               "out-of-limits: the lines lift the platform off its plane in these."),
        Figure("robot", "", "Name of the robot.", "solutions.model.robot.name"),
        Figure("lengths", "m", "Unstrained length of each line.", lambda found: found.solutions.lengths[0], digits=8,
               shown="m"),
        Figure("found", "1", "Number of equilibria found in the box.", len, "equilibria"),
        Figure("stable", "1", "Number of stable ones among them.", lambda found: int(found.stable.sum())),
        Figure("outside", "1", "Number of equilibria found outside the box, which are left out; --box widens it."),
        Figure("starts", "1", "Number of solves from which they were found."),
        Figure("complete_for", "", "Equilibria among which it is proved that there are no others; null where nothing "
               "is proved."),
        Figure("why", "", "What proves it, or why nothing does."),
        Figure("solutions", "", "Each equilibrium.", "rows", "equilibria", parts=ONE),
        Figure("undecided_boxes", "", "Boxes in which an exhaustive search proved nothing.", "undecided_boxes",
               parts=UNDECIDED),
    )  # fmt: skip

    solutions: Equilibrium
    certificates: Certificate
    slack: Mask  # (K, m) lines whose unstrained free span is longer than its chord
    starts: int  # number of solves
    outside: int  # number of equilibria that were left out because they are outside the box
    complete_for: str | None  # equilibria among which it is proved that there are no others; None: nothing is proved
    why: str  # what proves it, or why nothing does
    undecided: Array = field(default_factory=lambda: np.empty((0, 6)))  # boxes that an exhaustive search left, m
    undecided_why: tuple[str, ...] = ()  # of each
    finished: bool = True  # whether an exhaustive search, where one was begun, has judged the whole box

    @property
    def status(self) -> str:
        """Status of the search: "ok", "unfinished", "overstretched" or "out-of-limits"."""
        if not self.finished:
            return "unfinished"
        return "overstretched" if self._is_overstretched else "out-of-limits" if self._is_lifted else "ok"

    @property
    def refusal(self) -> str:
        """Sentence that explains why the command's answer is no (exit code 1); empty if the answer is yes."""
        if self._is_overstretched:
            return "the lengths cannot meet: in every stable equilibrium a line is over its breaking load"
        if self._is_lifted:
            return "in every stable equilibrium the lines lift the platform off its plane, which only pushes"
        return "" if self.finished else self.why

    @property
    def _is_overstretched(self) -> bool:
        """Whether there are stable equilibria, and cables would break in all of them."""
        return set(self[self.stable].status) == {Status.OVERSTRETCHED}

    @property
    def _is_lifted(self) -> bool:
        """Whether there are stable equilibria, and none of them is held by a plane that only pushes."""
        stable = self[self.stable]
        return bool((stable.code == Code.OK).any()) and not stable.holds.any()

    @property
    def rows(self) -> tuple[FoundEquilibrium, ...]:
        """Each equilibrium with its properties, as a row of a table."""
        each = zip(self, self.stable, self.slack, self.certificates, strict=True)
        return tuple(FoundEquilibrium(*row) for row in each)

    @property
    def undecided_boxes(self) -> tuple[UndecidedBox, ...]:
        """Boxes in which an exhaustive search proved nothing."""
        return tuple(map(UndecidedBox, self.undecided, self.undecided_why))

    @property
    def stable(self) -> Mask:
        """Mask (K,) of stable equilibria: their status is ok or overstretched."""
        return np.isin(self.solutions.code, [Code.OK, Code.OVERSTRETCHED])

    def __len__(self) -> int:
        """K."""
        return len(self.solutions)

    def __iter__(self) -> Iterator[Equilibrium]:
        """Each equilibrium."""
        return iter(self.solutions)

    def __getitem__(self, index: Any) -> Equilibrium:
        """One equilibrium, or some as a batch."""
        return self.solutions[index]

    def __repr__(self) -> str:
        """Robot and counts in one line."""
        proved = "not proved complete" if self.complete_for is None else "complete for a stated set"
        counts = f"{len(self)} found, {int(self.stable.sum())} stable, {proved}"
        return f"Equilibria({self.solutions.model.robot.name!r}, {counts})"


def equilibria(
    robot: Robot | Model,
    lengths: ArrayLike,
    *,
    box: ArrayLike | None = None,
    starts: int | None = None,
    seed: int = 0,
    cable: CableLaw | str | None = None,
    sheave: SheaveLaw | str | None = None,
) -> Equilibria:
    """Find equilibria for unstrained *lengths* (m,), m, from many starts.

    *box*: lowest and highest x, y and z of the platform, (6,) m; by default a quarter of the frame beyond it.
    *starts*: number of random start poses for each pattern of upside-down levers, drawn with *seed*. Impossible shapes,
    with a negative angle of contact on a sheave or over a full turn, are left out. Of cables without weight only stable
    ones are found, by descent. Raises `InputError` for invalid arguments and for rigid cables, `AnswerError` if nothing
    is found.

    Examples
    --------
    >>> import cablewright as cw
    >>> robot = cw.load("paty2021")  # its four levers can be upright or not: 2^4 equilibria
    >>> len(cw.equilibria(robot, cw.inverse(robot, [0.0, 0.0, 5.0]).lengths))
    16
    """
    model = Model.of(robot, cable=cable, sheave=sheave)
    model.refuse_rigid()
    given, single = as_rows(lengths, model.m, "lengths", "m")
    if not single or not (given > 0.0).all():
        raise InputError(f"lengths: {model.m} numbers over zero are expected, in m; got {given.tolist()}")
    low, high = box_of(model, box)
    poses, heads = _starts(model, low, high, STARTS[model.n] if starts is None else starts, seed)
    found = solve_starts(model, given[0], poses, heads)
    every = distinct(found[np.flatnonzero(np.isin(found.code, FOUND))])
    inside = ((every.pose[:, :3] >= low) & (every.pose[:, :3] <= high)).all(axis=1)
    kept, outside = every[np.flatnonzero(inside)], int((~inside).sum())
    if not len(kept):
        at = ", ".join(f"{x:.3f}" for x in every.pose[:1, :3].ravel())
        elsewhere = f"; {outside} outside the box, one at {at} m" if outside else ""
        raise AnswerError(f"no equilibrium was found for these lengths from {len(found)} starts{elsewhere}")
    proofs = certify(kept)
    complete_for, why = _completeness(model, kept[np.flatnonzero(proofs.certified)])
    return Equilibria(kept, proofs, slack_spans(kept), len(found), outside, complete_for, why)


def box_of(model: Model, given: ArrayLike | None) -> tuple[Array, Array]:
    """Return the lowest and the highest corner (3,), m, of a *given* box (6,); None: the frame and a quarter of it."""
    scene = model.robot.scene
    if given is None:
        low, high = np.array(scene.frame_min), np.array(scene.frame_max)
        beyond = OUTSIDE * (high - low)
        return low - beyond, high + beyond
    numbers, single = as_rows(given, 6, "box", "m")
    low, high = numbers[0, ::2], numbers[0, 1::2]
    if not single or not (low < high).all():
        raise InputError(f"box = {np.ravel(given).tolist()}: X0 < X1, Y0 < Y1 and Z0 < Z1 are expected, m")
    return low, high


def _starts(model: Model, low: Array, high: Array, count: int, seed: int) -> tuple[Array, Mask]:
    """Start poses (S, n), and which levers are upside down (S, m)."""
    if not 1 <= count <= 100_000:
        raise InputError(f"starts = {count}: from 1 to 100 000 are allowed")
    if seed < 0:
        raise InputError(f"seed = {seed}: at least 0 is expected")
    rng = np.random.default_rng(seed)
    patterns = lever_patterns(model, rng)
    rows = count * len(patterns)
    poses = rng.uniform(low, high, (rows, 3))
    if model.n == 6:
        axes = rng.standard_normal((rows, 3))
        turns = rng.uniform(0.0, np.pi, (rows, 1)) * rng.uniform(0.0, 1.0, (rows, 1))  # small rotations are more likely
        poses = np.concatenate([poses, turns * axes / np.linalg.norm(axes, axis=1, keepdims=True)], axis=1)
    return within(model.robot.platform.plane, poses), np.tile(patterns, (count, 1))


def lever_patterns(model: Model, rng: np.random.Generator) -> Mask:
    """Return patterns (P, m) of levers to start upside down: every pattern of few levers, some of many."""
    levers = np.flatnonzero(model.lines.has_lever)
    if len(levers) <= ALL_PATTERNS:
        signs = np.array(list(product((False, True), repeat=len(levers))), dtype=bool)
    else:
        signs = rng.random((2**ALL_PATTERNS, len(levers))) < 0.5
        signs[0] = False
    heads = np.zeros((len(signs), model.m), dtype=bool)
    heads[:, levers] = signs
    return heads


def solve_starts(model: Model, lengths: Array, poses: Array, heads: Mask) -> Equilibrium:
    """Solve from each of *poses* (S, n) with upside-down levers *heads* (S, m), and once without a guess."""
    packed = model.rows()
    rounds = [solve_forward(model, lengths[None])]
    for pull in PULLS if heads.any() else PULLS[:1]:
        begun = poses.copy()
        states = blank_states(len(poses), model.m)
        started = np.zeros(len(poses), dtype=bool)
        repeated = np.repeat(lengths[None], len(poses), axis=0)
        batches.start_rows(packed, repeated, begun, heads, pull, states, started)
        chosen = repeated[started], begun[started], states[started]
        rounds.append(solve_from(model, packed, *chosen, again=np.zeros(len(chosen[0]), dtype=bool)))
    return _joined(rounds)


def _joined(parts: list[Equilibrium]) -> Equilibrium:
    """Several batches of one model as one."""
    names = ("pose", "lengths", "states", "code", "violation", "iterations")
    arrays = (np.concatenate([getattr(part, name) for part in parts]) for name in names)
    return Equilibrium(parts[0].model, parts[0].packed, *arrays)


def distinct(found: Equilibrium, known: Equilibrium | None = None) -> Equilibrium:
    """Return one row of each distinct equilibrium: *known* ones, then new ones, stable first and by rising height."""
    stable = np.isin(found.code, [Code.OK, Code.OVERSTRETCHED])
    order = np.lexsort((found.pose[:, 2], ~stable))
    every, kept = found, []
    if known is not None:
        every, kept = _joined([known, found]), list(range(len(known)))
        order = order + len(known)
    for row in order:
        if not any(_same(every, row, other) for other in kept):
            kept.append(int(row))
    return every[kept]


def _same(found: Equilibrium, one: int, other: int) -> bool:
    """Whether two rows have the same pose and the same shape of every line."""
    pose, there = found.pose[one], found.pose[other]
    if np.abs(pose[:3] - there[:3]).max() > SAME_POSE:
        return False
    if angle_between(rotations(pose), rotations(there)) > SAME_POSE:
        return False
    if found.model.massless:  # the pose decides straight lines; a slack one has no shape
        return True
    apart = LineStates(found.states[one] - found.states[other])
    apart.angles = np.arctan2(np.sin(apart.angles), np.cos(apart.angles))
    return bool(np.abs(apart.array).max() < SAME_SHAPE)


def slack_spans(found: Equilibrium) -> Mask:
    """Return whether unstrained free spans are longer than the chord from sheave to platform, (K, m).

    A line without weight is slack where it carries nothing.
    """
    lines, states = found.lines, found.line_states
    away = found.platform_points - lines.exit_point
    x, z = np.hypot(away[..., 0], away[..., 1]), away[..., 2]
    phi, beta, turn, lever = states.free_angle, states.lever_angle, lines.side * lines.radius, lines.lever
    chord = np.hypot(x - lever * np.cos(beta) + turn * np.sin(phi), z - lever * np.sin(beta) - turn * np.cos(phi))
    for row, i in np.argwhere(np.broadcast_to(~lines.in_plane | lines.mount.any(axis=-1), chord.shape)):
        chord[row, i] = _chord(LineNumbers(lines.array[row if len(lines.array) > 1 else 0, i]), states.array[row, i])
    return np.where(lines.weight == 0.0, found.tensions == 0.0, states.free_length > chord)


def _chord(line: LineNumbers, state: Array) -> float:
    """Return the chord of the free span of a line out of the plane, m, from its force at the frame."""
    own = LineStates(state)
    h, v = own.tension * np.cos(own.free_angle), own.tension * np.sin(own.free_angle)
    x, z, *_ = span(float(h), float(v), float(own.free_length), float(line.weight), float(line.free_compliance))
    return math.hypot(x, z)


def _completeness(model: Model, found: Equilibrium) -> tuple[str | None, str]:
    """Among which equilibria a theorem says that those *found* and certified are all, or None; and why.

    See `docs/theory/uniqueness.md`.
    """
    among = next(filter(None, map(unique_among, found)), None)
    if among is not None:
        return among, "theorems: a point load on these lines has no more than one of them"
    if model.massless:
        return None, "cables without weight: only stable ones are found, and others of them may exist"
    if model.n == 6:
        return None, "a body may have more than were found: nothing bounds their number"
    if model.lines.has_lever.any():
        return None, "levers may stand upside down: nothing proves that these are all"
    return None, "no theorem covers these lines and lengths: others may exist"
