"""How far off the nozzle is: with the lengths that a controller's model gives, on the machine as it may be.

Paty 2021, section 2.3: the error when cables are taken as rigid, and the uncertainty that their moduli leave.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.analyses.accuracy.spread import Method, Spread, SpreadProblem, Vertices
from cablewright.errors import AnswerError, InputError, Status, UnknownName
from cablewright.kernels.layout import Code
from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
from cablewright.models.rotation import angle_between
from cablewright.models.statics import Equilibrium, Model
from cablewright.progress import Progress, silent
from cablewright.robot import Robot
from cablewright.robot.uncertainty import Range, of_moduli
from cablewright.solvers.arguments import as_poses, of_rows
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse

__all__ = ["COMPENSATIONS", "Accuracy", "accuracy", "around", "commanded"]

Array = NDArray[np.float64]

COMPENSATIONS = {
    "none": Fidelity(CableLaw.RIGID),
    "elastic": Fidelity(CableLaw.ELASTIC),
    "eyelets": Fidelity(CableLaw.CATENARY, SheaveLaw.EYELET),
    "full": Fidelity(),
}
"""What a controller's lengths come from: rigid cables, no sag, no sheaves, the full model."""


@dataclass(frozen=True, eq=False)
class Accuracy:
    """How far off the nozzle is at N poses, over k uncertain numbers. SI; rows without an answer are NaN.

    `codes` tells for each pose whether the full model can hold it within the tension limits, and whether the lengths
    that the compensation gives lead anywhere.
    """

    robot: Robot
    ranges: tuple[Range, ...]
    compensation: str
    method: str  # the name of the one that found the spread
    wanted: Array  # (N, n) poses
    commanded: Array  # (N, m) lengths
    codes: NDArray[np.int64]  # (N,)
    nominal: Array  # (N, n) where the machine goes if all numbers are nominal
    spread: Spread

    @property
    def ok(self) -> NDArray[np.bool_]:
        """(N,) which poses have an answer."""
        return np.asarray(self.codes == 0)

    @property
    def wanted_nozzle(self) -> Array:
        """(N, 3) where the nozzle is wanted, m."""
        return Model(self.robot).nozzle(self.wanted)

    @property
    def nominal_offset(self) -> Array:
        """(N, 3) error of the nozzle if all numbers are nominal, m: Paty's delta p_n."""
        return Model(self.robot).nozzle(self.nominal) - self.wanted_nozzle

    @property
    def nominal_error(self) -> Array:
        """(N,) its size, m."""
        return np.asarray(np.linalg.norm(self.nominal_offset, axis=1))

    @property
    def nominal_turn(self) -> Array:
        """(N,) angle of the platform from the wanted rotation, rad; 0 for a point."""
        if self.robot.n == 3:
            return np.where(self.ok, 0.0, np.nan)
        return angle_between(self.wanted[:, 3:], self.nominal[:, 3:])

    @property
    def difference(self) -> Array:
        """(N,) largest error less the nominal one, m: the delta p of Paty's Table 1."""
        return self.spread.max_error - self.nominal_error

    @property
    def worst_offset(self) -> Array:
        """(N, 3) error of the nozzle where it is largest, m: Paty's delta p_max."""
        return self.spread.worst - self.wanted_nozzle


def accuracy(
    robot: Robot,
    poses: ArrayLike,
    ranges: Sequence[Range] | None = None,
    *,
    compensation: str = "none",
    method: Method | None = None,
    tension_limits: tuple[float, float] | None = None,
    retraction: ArrayLike | None = None,
    home: ArrayLike | None = None,
    progress: Progress | None = None,
) -> Accuracy:
    """How far off *robot* is at *poses*, (n,) or (N, n) m and rad, while numbers are uncertain by *ranges*.

    Without ranges every line's modulus lies between 0.7 and 1.3 of its nominal value. *compensation* names the model
    that gives the commanded lengths (see `COMPENSATIONS`); *method* finds the spread, `Vertices` when left out.
    *home* is a pose at which the machine was zeroed: there the commanded lengths are true. Poses that the tension
    limits (N, in place of the lines' own) do not allow have no answer. Raises `InputError` for what cannot be used,
    `AnswerError` where no pose has an answer.
    """
    model = Model(robot, Fidelity(), tension_limits)
    given, _ = as_poses(model, poses, "pose", free=True)
    held = solve_inverse(model, given, path=True, retraction=retraction)
    lengths = commanded(held, given, compensation, retraction=retraction, home=home)
    known = tuple(of_moduli(robot) if ranges is None else ranges)
    if not known:
        raise InputError("ranges: none are given; at least one number has to be uncertain")
    return around(held, lengths, known, compensation, method or Vertices(), retraction=retraction, progress=progress)


def commanded(
    held: Equilibrium,
    poses: Array,
    compensation: str,
    *,
    retraction: ArrayLike | None = None,
    home: ArrayLike | None = None,
) -> Array:
    """Lengths (N, m), m, that the model named *compensation* gives for *poses* (N, n), as the full model has *held*.

    Raises `UnknownName`, or `InputError` for a *home* pose at which the machine cannot be.
    """
    if compensation not in COMPENSATIONS:
        raise UnknownName("compensation", compensation, COMPENSATIONS)
    if compensation == "full":
        return held.lengths
    full = held.model
    model = Model(full.robot, COMPENSATIONS[compensation], full.tension_limits)
    lengths = np.full_like(held.lengths, np.nan)
    drawn = of_rows(retraction, len(poses), "retraction", "m")
    some = None if drawn is None else drawn[held.ok]
    lengths[held.ok] = solve_inverse(model, poses[held.ok], path=True, retraction=some).lengths
    return lengths if home is None else lengths + _zeroing(full, model, home)


def _zeroing(full: Model, model: Model, home: ArrayLike) -> Array:
    """What a machine that was zeroed at *home* adds to the lengths of its *model*, (m,), m."""
    true = solve_inverse(full, as_poses(full, home, "home")[0][0])
    if not true.ok:
        raise InputError(f"home: {true.sentence()}")
    return np.asarray(true.lengths - solve_inverse(model, true.pose).checked().lengths)


def around(
    held: Equilibrium,
    lengths: Array,
    ranges: tuple[Range, ...],
    compensation: str,
    method: Method,
    *,
    retraction: ArrayLike | None = None,
    progress: Progress | None = None,
) -> Accuracy:
    """`accuracy` of poses *held* by the full model, with *lengths* (N, m) commanded there; see `commanded`.

    Raises `AnswerError` where none of them has an answer.
    """
    robot = held.model.robot
    codes = held.code.copy()
    usable = held.ok & (lengths > 0.0).all(axis=1)  # false for NaN
    codes[held.ok & ~usable] = Code.NOT_FINITE
    nominal = np.full_like(held.pose, np.nan)
    some = held[usable]
    drawn = of_rows(retraction, len(held.pose), "retraction", "m")
    solved = solve_forward(
        some.model, lengths[usable], guess=some.pose, retraction=None if drawn is None else drawn[usable]
    )
    codes[usable] = solved.code
    ok = codes == 0
    nominal[ok] = solved.pose[solved.ok]
    if not ok.any():
        raise AnswerError(_refusal(held, codes))
    problem = SpreadProblem(solved[solved.ok], lengths[ok], held.pose[ok], ranges, progress or silent)
    spread = _scattered(method(problem), ok)
    return Accuracy(robot, ranges, compensation, method.name, held.pose, lengths, codes, nominal, spread)


def _refusal(held: Equilibrium, codes: NDArray[np.int64]) -> str:
    """Why none of the poses has an answer: the commonest reason, by the first pose that has it."""
    commonest = int(np.bincount(codes).argmax())
    first = int(np.argmax(codes == commonest))
    why = held[first].sentence() if held.code[first] else f"with these lengths, {Status.of(commonest).value}"
    return why if len(codes) == 1 else f"none of the {len(codes)} poses has an answer: {why}"


def _scattered(spread: Spread, ok: NDArray[np.bool_]) -> Spread:
    """The spread of the places that are *ok*, as rows among all; the others are NaN."""
    values = {}
    for name, known in spread.__dict__.items():
        wide = np.full((len(ok), *known.shape[1:]), 0 if known.dtype == np.int64 else np.nan, dtype=known.dtype)
        wide[ok] = known
        values[name] = wide
    return Spread(**values)
