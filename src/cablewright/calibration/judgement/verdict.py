"""The verdict on a calibration: good, doubtful or bad, and each reason as a sentence with subject, value and limit.

The status comes first: whether the fit converged, is plausible, determined and consistent, and what to do if not.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Final, NamedTuple

import numpy as np
from scipy import special

from cablewright.calibration.judgement.consistency import others_of, predicted_halves, together
from cablewright.calibration.judgement.permuted_lines import better_arrangement, motion, stray
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.judgement.score_tests import LEVEL
from cablewright.calibration.judgement.sigmas import estimates_encoders, kind_fits, leverages
from cablewright.calibration.judgement.two_frames import two_frames
from cablewright.calibration.judgement.unmodelled_effects import OF_A_LINE
from cablewright.calibration.measurement_rows.load_cells import unseen_lines
from cablewright.calibration.measurement_rows.measurement_kinds import KINDS, SIGMA_OF
from cablewright.calibration.measurement_rows.without_pose import across_rows
from cablewright.calibration.measurements import SENSORS
from cablewright.calibration.poses.fit import PoseFit, yaw_between
from cablewright.calibration.poses.observability import Information, beyond_frames, combination, remedy
from cablewright.calibration.poses.problem import CalibrationProblem
from cablewright.calibration.poses.ranges_of_unknowns import at_bound
from cablewright.calibration.unknowns import exit_rows, of_unknown_exits
from cablewright.foundation.arrays import Array
from cablewright.kernels.fitting.calibration_residuals import COORDINATE
from cablewright.robot.parameter_values import AXES

_NO_FIT: Final = 0.01  # max rms over the frame's diagonal; above, the equations are not those of the machine
_TOO_LARGE: Final = 10.0  # max rms over the given sigma
_ACROSS: Final = 1.0 / 3.0  # max sigma of an exit point's distance from the plane, over that distance
_LARGE: Final = 0.05  # part of an unknown in a direction of length 1 that counts
NEED: Final = 2e-3
"""Default requirement of printing: max sigma of a coordinate of an exit point, m."""

_BEYOND: Final = 5.0  # sigmas by which the error of an exit point may exceed its stated one
_PRIOR: Final = (4.0, 10.0)  # deviations of its prior by which an unknown moves: doubtful, bad
_LEFT_OUT: Final = (0.1, 0.25)  # share of poses that do not fit: doubtful, bad
_OVERSTATED: Final = 1.0 / 3.0  # residuals of positions over their sigma: below, it is not theirs
_FEW: Final = 12  # poses of which a share that is left out may be chance
_RATIO: Final = (1.5, 10.0)  # residuals over what their sigmas explain: doubtful, bad
_ROUNDING: Final = 1e-6  # of the frame's diagonal, of exit points
_STRAY: Final = 0.05  # m: poses nearer to their start values are where they were stated to be
_LEVEL: Final = 1e-4  # probability of such residuals by chance
_WORTH: Final = 0.2  # of the need: smaller shifts of exit points by such a number are no reason


def status_of(
    problem: CalibrationProblem, found: PoseFit, posterior: Information, rms: float, chi: float
) -> tuple[str, str]:
    """Return the status of a fit, and, if there is no answer, a sentence that explains why.

    *posterior*: information of the data together with datum and priors.
    """
    lost = _undetermined_across(problem, posterior, chi)
    if lost:
        return "degenerate", lost
    if found.code != 0 or not (math.isfinite(found.cost) and math.isfinite(rms)):
        return "not-converged", f"no start of {found.starts} converged: are lines in the order of the file?"
    off = _inconsistent(problem, rms, chi)
    if off:
        return "inconsistent", off
    lost = _at_bound(problem, found) or _undetermined(posterior)
    return ("degenerate", lost) if lost else ("ok", "")


def _undetermined_across(problem: CalibrationProblem, posterior: Information, chi: float) -> str:
    """Return which exit points have an unknown distance from the platform's plane; empty for none, or without a plane.

    Lengths depend on the square of that distance. Known to no better than a third of it from them alone, it is not
    known at all: its sign is open, and fits creep to where lengths no longer depend on it.
    """
    robot, plane = problem.robot, problem.robot.platform.plane
    if plane is None or not problem.named("exit_point").any():
        return ""
    rows = across_rows(robot, posterior.unknowns)
    told = np.any(problem.rows.linear @ rows.T != 0.0, axis=0)  # by the plan
    off = (posterior.exits - posterior.ties) @ np.array(plane.across) - plane.distance
    sigma = np.sqrt(np.sum((rows @ posterior.covariance) * rows, axis=1)) * max(float(np.nan_to_num(chi)), 1e-9)
    sigma[np.linalg.norm(rows @ posterior.null, axis=1) > _LARGE * np.linalg.norm(rows, axis=1)] = np.inf
    lost = np.flatnonzero(~told & rows.any(axis=1) & (sigma > _ACROSS * np.abs(off)))
    if not len(lost):
        return ""
    names = ", ".join(robot.lines[at].name for at in lost)
    return (
        f"lengths hardly determine the distances of exit points from the plane {plane} ({names}): give in the plan the "
        'accuracy of the robot file across it, as in across = "2 mm"'
    )


def _inconsistent(problem: CalibrationProblem, rms: float, chi: float) -> str:
    diagonal = math.dist(problem.robot.scene.frame_min, problem.robot.scene.frame_max)
    given = problem.plan.sigma.encoder
    limit = _NO_FIT * diagonal if given is None else max(_TOO_LARGE * given, 1e-6)
    if problem.elastic and chi > _TOO_LARGE:
        return (
            f"residuals are {chi:.3g} times what the sigmas predict: are sigma.tension and sigma.encoder those of the "
            f"sensors, lines in order?{zeros(problem)}"
        )
    if rms > limit:
        return (
            f"lengths fit to {rms * 1e3:.3g} mm only, over the limit of {limit * 1e3:.3g} mm: check the order of the "
            f"lines, wrap sides, signs and units{zeros(problem)}"
        )
    return ""


def zeros(problem: CalibrationProblem, of: Iterable[str] = SENSORS) -> str:
    """Return advice on the zeros of the named sensors, which may be wrong; empty if no zero counts as right."""
    unsure = [each for each in of if problem.measured.has(each) and f"{each}_offset" not in problem.plan.unknowns]
    names = " and ".join(f"{each}_offset" for each in unsure)
    return f"; if their zero is not sure, add {names} to the unknowns" if names else ""


def _at_bound(problem: CalibrationProblem, found: PoseFit) -> str:
    """Return which unknowns ended at the edge of their range; empty for none."""
    limits = problem.limits
    in_file = np.where([each.in_file for each in problem.free_unknowns], problem.free, np.nan)
    in_file[problem.named("exit_compliance")] = 0.0  # a mount that does not give is an answer, whatever the file has
    where = np.flatnonzero(np.logical_or(*at_bound(found.theta, limits, in_file)))
    if not len(where):
        return ""
    first, more = problem.free_unknowns[where[0]], len(where) - 1
    value, (low, high) = found.theta[where[0]] * first.size, limits[:, where[0]] * first.size
    unit = "" if first.unit == "1" else f" {first.unit}"
    others = f", and {more} more unknowns at theirs" if more else ""
    return (
        f"{first.label} ends at {value:.4g}{unit}, the edge of its range from {low:.4g} to {high:.4g}{unit}{others}: "
        "the data do not determine it, or are of another machine; measure positions or a distance, leave it out of the "
        f"unknowns, or give its range in the plan's bounds{zeros(problem)}"
    )


def _undetermined(posterior: Information) -> str:
    """Return a sentence on unknowns that the data do not determine, beside the frames; empty: there are none."""
    beyond = beyond_frames(posterior)
    if not beyond.shape[1]:
        return ""
    large = np.flatnonzero(np.abs(beyond).max(axis=1) > _LARGE)
    names = ", ".join(dict.fromkeys(posterior.unknowns[at].name for at in large))
    more = remedy(posterior)
    measure = f"measure {more}, or " if more else ""
    return (
        f"the data do not determine {combination(posterior.unknowns, beyond[:, 0])}: {measure}leave one of {names} out "
        "of the unknowns or give it a prior"
    )


class _Reason(NamedTuple):
    sentence: str
    fatal: bool


def judged(found: Calibration, need: float, rough: float) -> tuple[str, tuple[str, ...]]:
    """Return the verdict on a calibration and its reasons.

    *need*: max sigma of exit points; *rough*: max error of the file's, m.
    """
    if found.status != "ok":
        frames = two_frames(found.problem, rough)
        other = "" if frames else better_arrangement(found.problem, found.fit, rough)
        return "bad", tuple(each for each in (frames, other, found.reason) if each)
    doubts = [*_moved(found, rough), *_turned(found, rough), *_left_out(found), *_sigma_of_positions(found)]
    doubts += [*_together(found), *_unexplained(found, need), *_halves(found), *_denied(found, need)]
    doubts += [*_along_axes(found), *_of_lines(found, need)]
    if doubts or found.rejected or _elsewhere(found, rough):
        other = two_frames(found.problem, rough) or better_arrangement(found.problem, found.fit, rough)
        doubts = [_Reason(other, True)] * bool(other) + doubts
    doubts = sorted([*doubts, *_unknown(found, need)], key=lambda each: not each.fatal)
    verdict = "good" if not doubts else "bad" if doubts[0].fatal else "doubtful"
    return verdict, tuple(each.sentence for each in doubts)


def _elsewhere(found: Calibration, rough: float) -> bool:
    """Whether poses, or else exit points, have such large errors that lines may be in another order."""
    if found.problem.measured.guess is not None:
        return stray(found.problem, found.fit) > max(rough, _STRAY)
    moved = float(np.abs(motion(found.problem, found.fit.theta)).max())
    return moved > max(_STRAY, _BEYOND * float(np.nan_to_num(found.exit_sigma or 0.0)))


def _unknown(found: Calibration, need: float) -> Iterator[_Reason]:
    """Exit points, or else what other lengths are unknown, that are known less well than printing needs."""
    problem, exits = found.problem, {each.line for each in found.unknowns if each.name == "exit_point"}
    blind = unseen_lines(problem.robot, problem.measured, problem.elastic)
    if unseen := ", ".join(each for each in blind if each not in exits):
        yield _Reason(
            f"nothing measured depends on the exit point of {unseen}: a counterweight has no encoder; its numbers stay "
            "those of the file; measure tensions f_1 .., which the weight balances, or survey the point",
            False,
        )
    if found.posterior.redundancy < 1:
        yield _Reason("no measurement is left over, so nothing tests the answer: measure more poses", False)
    labels, sigma = _of_exits(found)
    if not np.isfinite(sigma).all():
        return
    if not len(sigma):
        names = ", ".join(found.problem.plan.unknowns)
        yield _Reason(f"no length is among the unknowns ({names}), so how well they are known is not judged", False)
        return
    worst = int(np.argmax(sigma))
    if sigma[worst] > need:
        more = found.suggestions[0].words if found.suggestions else "more poses"
        yield _Reason(
            f"{labels[worst]} is known to {_mm(sigma[worst])} (one sigma), where {_mm(need)} is needed; what would "
            f"help most: {more}",
            False,
        )


def _of_exits(found: Calibration) -> tuple[list[str], Array]:
    """Return what is judged, in words, and its sigmas, m: exit points, or else what other lengths are unknown."""
    robot, unknowns = found.problem.robot, found.unknowns
    if robot.platform.plane is not None and "exit_point" in found.problem.plan.unknowns:
        rows, line_of = exit_rows(robot, unknowns)
        return [f"exit point of {robot.lines[at].name}, in the plane," for at in line_of], found.exit_sigmas(rows)
    exits = np.array([each.name == "exit_point" for each in unknowns], dtype=bool)
    if not exits.any():
        exits = np.array([each.unit == "m" for each in unknowns], dtype=bool)
    return [unknowns[at].label for at in np.flatnonzero(exits)], found.sigma[exits]


def _moved(found: Calibration, rough: float) -> Iterator[_Reason]:
    """Unknowns that are further from the file than was said."""
    problem, exits = found.problem, [each.name == "exit_point" for each in found.unknowns]
    if any(exits) and sum(exits) == 3 * of_unknown_exits(problem.robot, problem.unknowns).sum():
        away = np.abs(motion(problem, found.fit.theta)).ravel()
        over = away - rough - _BEYOND * np.nan_to_num(found.sigma[exits])
        worst = int(np.argmax(over))
        scene = problem.robot.scene
        if over[worst] > _ROUNDING * math.dist(scene.frame_min, scene.frame_max):
            label = [each.label for each in found.unknowns if each.name == "exit_point"][worst]
            yield _Reason(
                f"{label} moves by {away[worst]:.3g} m from the file, but its stated tolerance is {rough:.3g} m "
                "(--rough): are the data of this robot?",
                True,
            )
    for prior in problem.plan.priors:
        for unknown, change, value in zip(found.unknowns, found.changes, found.values, strict=True):
            off = abs(change if prior.value is None else value - prior.value)
            if prior.is_of(unknown) and not (prior.alike or prior.tilted) and off > _PRIOR[0] * prior.deviation:
                times = off / prior.deviation
                moved = f"{unknown.label} moves by {times:.3g} times the {prior.deviation:g} of its prior"
                yield _Reason(f"{moved}, limit {_PRIOR[0]:g}", times > _PRIOR[1])


def _turned(found: Calibration, rough: float) -> Iterator[_Reason]:
    """A frame that azimuths alone place, and rotate by more than the stated error of exit points."""
    problem = found.problem
    of = [each for each in ("swivel", "yaw") if problem.measured.has(each)]
    of = [each for each in of if f"{each}_offset" not in problem.plan.unknowns]
    if not of or problem.measured.positioned or problem.plan.points or problem.held.any():
        return
    file = np.array([line.exit_point for line in problem.robot.lines])
    points = problem.points(found.fit.theta)
    arms = file - file.mean(axis=0)
    angle = yaw_between(arms, points - points.mean(axis=0))
    reach = float(np.sqrt(np.mean(np.sum(arms[:, :2] ** 2, axis=1))))
    if abs(angle) * reach > rough + _BEYOND * float(np.nan_to_num(found.exit_sigma or 0.0)):
        yield _Reason(
            f"readings of {' and '.join(of)} turn the whole frame by {math.degrees(angle):.3g} deg from the file's, "
            f"more than {rough:.3g} m at exit points (--rough): where such a sensor was set to zero anywhere else "
            f"than along world +x, add {' and '.join(f'{each}_offset' for each in of)} to the unknowns",
            False,
        )


def _left_out(found: Calibration) -> Iterator[_Reason]:
    """Too many poses that do not fit the others."""
    count, poses = len({each.pose for each in found.rejected}), found.problem.poses
    if count > _LEFT_OUT[0] * poses:
        share = f"{count} of {poses} poses do not fit the others, {100 * count / poses:.0f} %"
        fatal = count >= _LEFT_OUT[1] * poses and poses >= _FEW and not _overstated(found)
        yield _Reason(f"{share}, where at most {100 * _LEFT_OUT[0]:.0f} % is usual", fatal)


def _overstated(found: Calibration) -> float | None:
    """Return the residuals of positions over their sigma, where that is much too large; None where it is not."""
    for kind in kind_fits(found.problem, found.fit):
        if kind.name == "positions" and kind.redundancy >= 1.0 and kind.ratio < _OVERSTATED:
            return kind.ratio if special.chdtr(kind.redundancy, kind.ratio**2 * kind.redundancy) < _LEVEL else None
    return None


def _sigma_of_positions(found: Calibration) -> Iterator[_Reason]:
    """Positions whose sigma is overstated: rows that always fit test nothing."""
    ratio = _overstated(found)
    if ratio is not None:
        yield _Reason(
            f"residuals of the positions are {ratio:.3g} times what their sigma explains, limit {_OVERSTATED:.2g}: it "
            "is too large, so they count for less than they could",
            False,
        )


def _together(found: Calibration) -> Iterator[_Reason]:
    """Other rows that lengths alone deny: the encoders' sigma, where it is estimated, grows until all fits."""
    problem = found.problem
    if not estimates_encoders(problem):
        return
    if problem.found_encoder is None:
        yield _Reason(
            "no sigma.encoder is given and too few lengths are left over to estimate it: "
            f"{_mm(problem.encoder_sigma)} is assumed; give it in the plan, or measure more poses",
            False,
        )
        return
    test = together(problem, found.fit)
    others = others_of(problem)
    if test is None:
        yield _Reason(
            f"sigma of the encoders is estimated together with {others}, and too few lengths are left over to test "
            f"it: give sigma.encoder in the plan{'' if problem.elastic else ', or measure more poses'}",
            False,
        )
    elif test.growth > _RATIO[0] and test.probability < _LEVEL:
        yield _Reason(
            f"lengths alone fit to {_mm(test.alone)}, together with {others} to {_mm(test.joint)}: they contradict "
            "each other, or their sigma is too small",
            test.ratio > _RATIO[1],
        )


def _unexplained(found: Calibration, need: float) -> Iterator[_Reason]:
    """Residuals that the sensors' noise does not explain, by kind."""
    problem = found.problem
    given = problem.plan.sigma.encoder is not None
    if not given and found.encoder_sigma > need:
        yield _Reason(
            f"lengths scatter by {_mm(found.encoder_sigma)} about the model, more than the {_mm(need)} that is needed",
            False,
        )
    if not given and problem.found_encoder is None:
        return  # nothing says by how much: they scatter alone, or their sigma is assumed
    for kind in kind_fits(problem, found.fit):
        if kind.name == "lengths" and estimates_encoders(problem):
            continue
        if kind.redundancy < 1.0 or not kind.ratio > _RATIO[0]:
            continue
        if special.chdtrc(kind.redundancy, kind.ratio**2 * kind.redundancy) < _LEVEL:
            of = [SIGMA_OF[kind.name]] if kind.name in SIGMA_OF else []
            yield _Reason(
                f"residuals of the {kind.name} are {kind.ratio:.3g} times what their sigma explains, limit "
                f"{_RATIO[0]:g}: they contradict the model or the other measurements{zeros(problem, of)}",
                kind.ratio > _RATIO[1],
            )


def _along_axes(found: Calibration) -> Iterator[_Reason]:
    """Measured positions that are further off along one axis than along the others: a sigma of all hides it."""
    problem, rows = found.problem, found.problem.rows
    kind, axis = (each[: problem.per_pose] for each in (rows.kind, rows.other))
    if not (kind == COORDINATE).any():
        return
    used = problem.of_poses(found.fit.weights) > 0.0
    free = np.where(used, 1.0 - leverages(problem, found.fit), 0.0)
    squares = problem.derivatives(found.fit.theta, found.fit.poses).residual ** 2
    told = problem.factors.get(KINDS[COORDINATE].words, 1.0)
    ratios = dict[str, float]()  # of the axes that redundant positions test
    wrong = list[str]()
    for at, name in enumerate(AXES):
        own = (kind == COORDINATE) & (axis == at)
        total = float(free[:, own].sum())
        if total < 1.0:
            continue
        square = told**2 * float(squares[:, own][used[:, own]].sum())
        ratios[name] = math.sqrt(square / total)
        if ratios[name] > _RATIO[0] and special.chdtrc(total, square) < _LEVEL:
            wrong.append(name)
    for name in wrong if len(wrong) < len(ratios) else ():  # else it is not the axis
        yield _Reason(
            f"errors of positions along {name} are {ratios[name]:.3g} times as large as their sigma explains, "
            f"limit {_RATIO[0]:g}: the model has an error along {name}; --models auto looks for it",
            False,
        )


def _denied(found: Calibration, need: float) -> Iterator[_Reason]:
    """Numbers of the file that count as known, and that the data deny with a relevant shift of exit points."""
    wrong = [each for each in found.doubt.considered if abs(each.value) > _BEYOND * each.sigma and each.shift > need]
    if wrong:
        worst = max(wrong, key=lambda each: each.shift)
        unit = "" if worst.unit == "1" else f" {worst.unit}"
        times = abs(worst.value) / worst.sigma
        yield _Reason(
            f"the data ask for {worst.value:+.3g}{unit} of {worst.words}, {times:.3g} sigmas from the assumed "
            f"value, and this moves exit points by {_mm(worst.shift)}, limit {_mm(need)}: model it, or "
            "make it an unknown",
            False,
        )


def _of_lines(found: Calibration, need: float) -> Iterator[_Reason]:
    """Numbers of single lines that the data deny: those in the model by now, and the most significant of the others."""
    for each in found.effects:
        if each.chosen and each.name.startswith(OF_A_LINE):
            line, times = each.name.removeprefix(OF_A_LINE), abs(each.value) / max(each.sigma, 1e-300)
            size = f"{100.0 * abs(each.value):.2g} % {'more' if each.value > 0.0 else 'less'}"
            yield _Reason(
                f"the drum of {line} pays out {size} than its counts say ({times:.2g} sigmas): measure its "
                "radius for the robot file, or add drum_radius or length_scale to the unknowns",
                False,
            )
    exits = found.problem.named("exit_point")
    for score in found.scores:
        shift = float(np.abs(np.array(score.shift)[exits]).max(initial=0.0))
        if score.probability < LEVEL and shift > _WORTH * need:
            unit = "" if score.unit == "1" else f" {score.unit}"
            yield _Reason(
                f"the data ask for another {score.words}, by {score.value:+.2g}{unit} or "
                f"{abs(score.value) / score.sigma:.2g} sigmas, which moves exit points by {_mm(shift)}: measure it, or "
                f"add {score.name} to the unknowns",
                False,
            )
            return  # others may only be like it


def _halves(found: Calibration) -> Iterator[_Reason]:
    """Halves of the data that predict each other badly."""
    worst = max(predicted_halves(found.problem, found.fit), key=lambda each: each.ratio, default=None)
    if worst is not None and worst.ratio > _RATIO[0] and worst.probability < _LEVEL:
        first, last = worst.poses
        yield _Reason(
            f"poses {first + 1} to {last + 1} are {worst.ratio:.3g} times as far from the prediction of the others "
            f"as noise explains, limit {_RATIO[0]:g}: did something slip or change between?",
            worst.ratio > _RATIO[1],
        )


def _mm(length: float) -> str:
    return f"{1e3 * length:.3g} mm"
