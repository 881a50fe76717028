"""Physical effects missing in a calibration's model: which ones the data support, by cross-validation.

Each effect of a declared family is a column beside the unknowns, to first order about a fit, so no fold of the poses is
fitted again. The one that lowers the held-out error most is added first, and so on while the fall is beyond chance.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np

from cablewright.calibration.judgement.model_doubt import Alternative, loads_of, stretch_of, with_more
from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.poses.fit import PoseFit
from cablewright.calibration.poses.observability import projected
from cablewright.calibration.poses.problem import CalibrationProblem
from cablewright.calibration.poses.sufficient_data import line_with_counted_build_up
from cablewright.foundation.arrays import Array
from cablewright.kernels.fitting import line_over_sheave
from cablewright.models.winch_lines import WinchLines
from cablewright.robot.parameters import KINDS_OF, why_not

UNKNOWNS: Final = ("build_up", "sheave_radius", "length_scale", "exit_compliance", "modulus")
"""Effects that are unknowns of a calibration, one number for all lines."""

WORDS: Final = {
    "stretch": ("stretch of the lines, over that by the file", "1"),
    "sag": ("sag of the lines, over that by the file", "1"),
    "deflection": ("deflection of all exit points per force, along it", "m/N"),
    "hysteresis": ("hysteresis, by the direction of the last motion", "m"),
}
"""Effects on lengths that are no unknowns: counts are corrected by them."""

USUAL: Final = {"stretch": 1.0, "sag": 1.0, "deflection": 1e-5, "hysteresis": 1e-3, "build_up": 2e-3,
                "sheave_radius": 3e-3, "length_scale": 1e-3, "exit_compliance": 1e-5, "modulus": 0.2}  # fmt: skip
"""How large an effect of the family may be on a machine of which nothing is known, SI."""

OF_A_LINE: Final = "length_scale."
"""Begin of the names of effects on one line alone, whose drum or gear is not that of its file: then the line's name."""

_SIGNED: Final = ("hysteresis", "length_scale", "sheave_radius", "modulus")  # the others have no meaning below 0
_LARGEST: Final = 0.1  # of the drum of a line, as of the unknown `length_scale`: more is no drum of another size
_FOLDS: Final = 8
_BEYOND: Final = 2.5  # standard errors of the fall of the held-out error, by pose
_PLAIN: Final = 5.0  # sigmas of its number with which an effect is beyond chance too ...
_ANOTHER: Final = 2.8  # ... and with which another is, on a machine that has shown one
_LEAST: Final = 0.02  # fall of the held-out error that is worth an effect
_SAME: Final = 1e-3  # m: a smaller change of a length says no direction


@dataclass(frozen=True)
class Effect:
    """A physical effect that may be missing: its value, and the held-out error without and with it, m of lengths."""

    name: str
    words: str
    unit: str
    value: float
    sigma: float
    before: float
    after: float
    chosen: bool

    @property
    def fall(self) -> float:
        """Share by which the error on held-out data falls when the effect is fitted."""
        return 1.0 - self.after / self.before if self.before > 0.0 else 0.0


def words_of(name: str) -> tuple[str, str]:
    """Return the words and the unit of an effect on lengths that is no unknown."""
    if not name.startswith(OF_A_LINE):
        return WORDS[name]
    return f"share by which the drum of {name.removeprefix(OF_A_LINE)} pays out more than counted", "1"


class _Candidate(NamedTuple):
    name: str
    words: str
    unit: str
    column: Array  # (N, e) derivative of the weighted residuals


def effects_of(
    problem: CalibrationProblem, found: PoseFit, already: Collection[str] = (), scale: float = 1.0
) -> tuple[Effect, ...]:
    """Return the effects that this machine can have, those already in the model first.

    *already*: names of those that the counts are corrected by; their values are the errors of these corrections.
    *scale*: sigma of a row over that of its weight, by which a drum of a single line is judged.
    """
    left = _candidates(problem, found, already)
    data = _data(problem, found, left)
    if data is None or not left:
        return ()
    k = len(found.theta)
    chosen = [at for at, each in enumerate(left) if each.name in already]
    made: dict[int, Effect] = {}
    while True:
        base = data.held_out([*range(k), *(k + at for at in chosen)])
        best, fall = -1, 0.0
        for at in (at for at in range(len(left)) if at not in chosen):
            used = [*range(k), *(k + each for each in (*chosen, at))]
            there = data.held_out(used)
            value, sigma = (float(each[-1]) for each in data.numbers(used))
            gain = np.sqrt(base) - np.sqrt(there)
            error = float(gain.std()) * np.sqrt(len(gain))
            sizes = _size(problem, base), _size(problem, there)
            made[at] = Effect(*left[at][:3], value, sigma, sizes[0], sizes[1], False)
            if of_a_line := left[at].name.startswith(OF_A_LINE):
                beyond = _PLAIN * scale * sigma < abs(value) < _LARGEST
            else:
                beyond = gain.sum() > _BEYOND * error or abs(value) > (_ANOTHER if chosen else _PLAIN) * sigma
            asked = beyond and made[at].fall > _LEAST
            if asked and (value > 0.0 or of_a_line or made[at].name in _SIGNED) and made[at].fall > fall:
                best, fall = at, made[at].fall
        if best < 0:
            break
        chosen.append(best)
    values, sigmas = data.numbers([*range(k), *(k + at for at in chosen)])
    for place, at in enumerate(chosen, k):
        one = made.get(at) or Effect(*left[at][:3], 0.0, 0.0, 0.0, 0.0, True)
        sigma = float(sigmas[place]) * (scale if one.name.startswith(OF_A_LINE) else 1.0)
        made[at] = replace(one, value=float(values[place]), sigma=sigma, chosen=True)
    rest = (at for at, each in made.items() if at not in chosen and not each.name.startswith(OF_A_LINE))
    return tuple(made[at] for at in (*chosen, *rest))


def _data(problem: CalibrationProblem, found: PoseFit, more: Sequence[_Candidate]) -> _Data | None:
    """Return the rows at a fit with those of *more* effects after the unknowns; None where a pose has no value."""
    rows = problem.derivatives(found.theta, found.poses, found.weights)
    if not rows.whole.all():
        return None
    columns = [each.column[..., None] for each in more]
    off, reduced, _ = projected(replace(rows, by_unknown=np.concatenate([rows.by_unknown, *columns], axis=2)))
    others = np.concatenate([rows.others_by_unknown, np.zeros((len(rows.others), len(more)))], axis=1)
    return _Data(off, reduced, others, rows.others)


def _size(problem: CalibrationProblem, squares: Array) -> float:
    """Return the held-out error per redundant length of a pose, m, from its *squares* (N,)."""
    return float(np.sqrt(squares.mean() / max(problem.per_pose - problem.unknowns_per_pose, 1)) * problem.encoder_sigma)


class _Data(NamedTuple):
    """Rows of poses without what each explains itself, and rows without a pose."""

    off: Array  # (N, r)
    rows: Array  # (N, r, k + q)
    others: Array  # (g, k + q)
    rest: Array  # (g,)

    def held_out(self, used: Sequence[int]) -> Array:
        """Return the squared errors (N,) of poses, predicted from the other folds with the columns *used*."""
        fold, found = np.arange(len(self.off)) % _FOLDS, np.zeros(len(self.off))
        for each in range(_FOLDS):
            own = fold == each
            change = self._change(np.logical_not(own), used)[0]
            found[own] = np.sum((self.off[own] + self.rows[own][..., used] @ change) ** 2, axis=1)
        return found

    def numbers(self, used: Sequence[int]) -> tuple[Array, Array]:
        """Return the fitted values of the columns *used*, from all poses, and their standard deviations."""
        change, rows = self._change(np.ones(len(self.off), dtype=bool), used)
        spread = np.linalg.pinv(rows.T @ rows, rcond=1e-12, hermitian=True)
        return change, np.sqrt(np.diag(spread).clip(min=0.0))

    def _change(self, poses: Array, used: Sequence[int]) -> tuple[Array, Array]:
        """Return the change of the columns *used* that some *poses* (N,) and the other rows ask for, and these rows."""
        rows = np.concatenate([self.rows[poses][..., used].reshape(-1, len(used)), self.others[:, used]])
        size = np.maximum(np.linalg.norm(rows, axis=0), 1e-300)
        rest = np.append(self.off[poses].ravel(), self.rest)
        return np.linalg.lstsq(rows / size, -rest, rcond=1e-9)[0] / size, rows


def _candidates(problem: CalibrationProblem, found: PoseFit, kept: Collection[str] = ()) -> list[_Candidate]:
    """Return the effects that this machine can have.

    Left out: effects of parts that it lacks, of unknowns, and of numbers that the plan calls known. If the scale of
    lengths is an unknown, also the drums of single lines, but for those *kept*, which are in the model.
    """
    known = {each.name for each in problem.plan.known}
    scaled = bool({"length_scale", "drum_radius"} & {*problem.plan.unknowns})
    made = [
        _Candidate(name, *words_of(name), -problem.of_poses(found.weights) * problem.in_lengths(more))
        for name, more in corrections(problem, found).items()
        if name.partition(".")[0] not in known and not (scaled and name.startswith(OF_A_LINE) and name not in kept)
    ]
    for name in UNKNOWNS:
        twin = {"length_scale": "drum_radius"}.get(name, name)
        if {name, twin} & {*problem.plan.unknowns, *known} or (name == "modulus") is not problem.elastic:
            continue
        stiff = not all(line.may_give for line in problem.robot.lines)
        if name == "exit_compliance" and (stiff or problem.known_tensions(found.theta, found.poses) is None):
            continue
        if name == "build_up" and line_with_counted_build_up(problem) is not None:
            continue
        if why_not(problem.robot, KINDS_OF[name][0], None, True) is not None:
            continue
        _, rows, (unknown,) = with_more(problem, found, (name,), (name,))
        at = len(found.theta)
        made.append(_Candidate(name, unknown.label, unknown.unit, rows.by_unknown[..., at] / unknown.size))
    return [each for each in made if np.abs(each.column).max(initial=0.0) > 0.0]


def alternatives(problem: CalibrationProblem, found: PoseFit, effects: Iterable[Effect]) -> list[Alternative]:
    """Return the changes of the rows by the tested *effects*, at a fit that includes the chosen ones."""
    chosen = {each.name: each.chosen for each in effects}
    kept = [name for name, is_chosen in chosen.items() if is_chosen]
    named = (each for each in _candidates(problem, found, kept) if each.name in chosen) if chosen else ()
    return [Alternative(*each, USUAL[each.name.partition(".")[0]], chosen[each.name]) for each in named]


def corrections(problem: CalibrationProblem, found: PoseFit, counted: Array | None = None) -> dict[str, Array]:
    """Return by how much each line (N, m) is longer than counted, m, per unit of each effect that is no unknown.

    *counted* (N, m): lengths before any correction, m; None: those of the problem.
    """
    if problem.elastic:
        return {}
    robot, made = problem.robot, dict[str, Array]()
    tensions = loads_of(problem, found.theta, found.poses)
    stretch = stretch_of(problem, found.theta, found.poses)
    if tensions is not None and stretch is not None:
        points = problem.points(found.theta)
        away = problem.poses_of(found.poses)[:, None, :2] - points[:, :2]
        weight = np.array([line.cable.linear_density or 0.0 for line in robot.lines]) * robot.scene.gravity
        across = weight * np.linalg.norm(away, axis=2)
        longer = across**2 * problem.lengths(found.theta, found.poses) / (24.0 * np.maximum(tensions, 1e-3) ** 2)
        made = {"stretch": stretch, "sag": -np.minimum(longer, 0.1 * problem.lengths(found.theta, found.poses))}
    if tensions is not None and problem.measured.tensions is None:
        lines = problem.rows.lines.copy()
        lines[:, line_over_sheave.GIVING] = 0.0
        lines[:, line_over_sheave.COMPLIANCE] = 1.0 / line_over_sheave.PER_NEWTON
        compliant = replace(problem, rows=problem.rows._replace(lines=lines))
        made["deflection"] = compliant.given(found.theta, found.poses, tensions)
    moved = np.diff(problem.measured.counted, axis=0, prepend=problem.measured.counted[:1])
    made["hysteresis"] = np.where(np.abs(moved) > _SAME, np.sign(moved), 0.0)
    winches, counted = WinchLines.of(robot), problem.measured.counted if counted is None else counted
    for host in winches.hosts.tolist():  # all lines on its drum
        made[OF_A_LINE + robot.lines[host].name] = counted * (winches.host == host)
    return made


def applied(
    problem: CalibrationProblem, found: PoseFit, effects: Iterable[Effect], measured: Measured, plan: CalibrationPlan
) -> tuple[Measured, CalibrationPlan]:
    """Return data and plan with the chosen *effects*: unknowns for all lines, and corrected counts."""
    chosen = [each for each in effects if each.chosen]
    names = tuple(each.name for each in chosen if each.name in UNKNOWNS)
    more = corrections(problem, found, measured.counted)
    counted = measured.counted + sum(each.value * more[each.name] for each in chosen if each.name in more)
    wider = plan.model_copy(update={"unknowns": (*plan.unknowns, *names), "shared": (*plan.shared, *names)})
    return replace(measured, counted=counted), wider
