"""Calibration of a robot from measurements at poses: values, standard deviations, and undetermined combinations.

Self-calibration from encoders alone: Wang, Caro 2021. Plain least squares first, then gross errors are rejected.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Final, Literal

import numpy as np

from cablewright.calibration.judgement.gross_errors import Rejected, without_outliers
from cablewright.calibration.judgement.model_doubt import creep_share, stretch_of
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.judgement.sigmas import ENOUGH, kind_fits, kind_of, resisting, roughly_weighed, weighed
from cablewright.calibration.judgement.unmodelled_effects import UNKNOWNS, Effect, applied, effects_of
from cablewright.calibration.judgement.verdict import NEED, judged, status_of
from cablewright.calibration.measurement_rows.load_cells import check_counterweights
from cablewright.calibration.measurement_rows.pictures import with_pictures
from cablewright.calibration.measurement_rows.vibrations import AT_START, with_vibrations
from cablewright.calibration.measurements import Measured, read_measured
from cablewright.calibration.plan import CalibrationPlan, plan_of
from cablewright.calibration.poses.elastic import ElasticProblem, problem_of
from cablewright.calibration.poses.fit import PoseFit, fitted_poses, framed, to_file_frame
from cablewright.calibration.poses.observability import Information, information
from cablewright.calibration.poses.problem import SURVEY, CalibrationProblem
from cablewright.calibration.poses.start_values import best_fit, elastic_fit, first_start, near_poses
from cablewright.calibration.poses.sufficient_data import check, check_lengths
from cablewright.foundation.arrays import Mask
from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress, silent
from cablewright.models.fidelity import CableLaw, SheaveLaw
from cablewright.models.statics import Model
from cablewright.robot import Robot

ROUGH: Final = 0.5
"""Default max error of the file's exit points, m, in each coordinate."""

MAX_ROUGH: Final = 100.0  # m
_CONTRADICTS: Final = 3.0  # max ratio of the rms with a datum to that without
_SETTLED: Final = 0.02  # relative change of an effect's number that ends them
_ROUNDS: Final = 6  # of looking for effects that the model lacks
_BY_FORCE: Final = ("stretch", "sag", "deflection")  # effects that grow as the tensions of a pose
_FAR: Final = 2.0  # times the median stretch, from which on a pose is left out where effects are looked for first ...
_CALM: Final = 2.0 / 3.0  # ... if so large a share of the poses is left
_AT_POSES: Final = 3  # rounds of correcting counts at poses by corrected counts
_SHOWN: Final = 0.1  # relative change of a sigma that is worth a sentence
_FEW: Final = 10  # redundant measurements, which give sigma to a quarter


def calibrate(
    robot: Robot | Model,
    data: str | Path | Measured,
    plan: str | Path | CalibrationPlan | None = None,
    *,
    cable: CableLaw | str | None = None,
    sheave: SheaveLaw | str | None = None,
    rough: float = ROUGH,
    outliers: bool = True,
    need: float = NEED,
    models: Literal["file", "auto"] = "file",
    seed: int = 0,
    progress: Progress = silent,
) -> Calibration:
    """Calibrate *robot*, whose numbers are the start values, from *data* measured at poses, or the CSV that has them.

    *plan*: unknowns, sigmas of the sensors and datum, or a TOML file; by default exit points and home lengths are
    unknown. Lines are rigid unless a *cable* law or a model says otherwise; elastic ones require tensions or measured
    poses. *rough*: max error of the file's exit points in each coordinate, m; starts are drawn within it with *seed*.
    *outliers*: whether gross errors are rejected. *need*: max standard deviation of exit points for a good verdict, m.
    *models*: ``file`` or ``auto``; with ``auto`` the effects of `Calibration.effects` that cross-validation asks for
    are added to the model.

    Raises `InputError` for data or a plan that cannot be used: too few poses, other units, a contradictory datum;
    `AnswerError` if elastic lines have no equilibrium near any pose. Source: Wang, Caro 2021.

    Examples
    --------
    >>> import cablewright as cw
    >>> robot = cw.load("wang2021")
    >>> found = cw.calibrate(robot, cw.simulate_calibration(robot, 20, 1e-4, seed=1).measured)
    >>> found.status, found.alone.rank
    ('ok', 72)
    """
    if not 0.0 <= rough <= MAX_ROUGH:
        raise InputError(f"rough = {rough:g}: must be from 0 to {MAX_ROUGH:g} m")
    if not 0.0 < need < math.inf:
        raise InputError(f"need = {need:g}: the required standard deviation of exit points must be over 0 m")
    if seed < 0:
        raise InputError(f"seed = {seed}: must not be negative")
    model = Model.of(robot, cable=cable, sheave=sheave, default=CableLaw.RIGID)
    plan, robot = plan_of(plan), model.robot
    measured = data if isinstance(data, Measured) else read_measured(data, robot)
    check_lengths(robot, measured)
    check_counterweights(model, measured)
    model, measured = with_pictures(model, measured)
    robot = model.robot
    measured = with_vibrations(robot, measured, plan, measured.guess, AT_START)
    measured = near_poses(model, measured, plan, seed, rough, progress)
    given: tuple[float, bool, int, Progress] = rough, outliers, seed, progress
    found = _fitted(model, measured, plan, *given)
    if measured.frequencies is not None and found.status == "ok":  # their spans are better known now
        measured = with_vibrations(found.robot, measured, plan, found.poses)
        found = _fitted(model, measured, plan, *given)
    if models == "auto" and found.status in ("ok", "inconsistent"):
        found = _with_effects(found, *given)
    verdict, reasons = judged(found, need, rough)
    return replace(found, verdict=verdict, reasons=reasons)


def _with_effects(found: Calibration, rough: float, outliers: bool, seed: int, progress: Progress) -> Calibration:
    """Return the calibration with the effects that the data ask for.

    Each effect is tested again after each fit, since a fit changes the weights. Where some poses stretch lines far more
    than others, effects are fitted without these poses first: the stretch there is far from linear in the pose, so that
    a fit without effects would be far from the solution.
    """
    measured, plan, model = found.problem.measured, found.problem.plan, found.problem.model
    given: tuple[float, bool, int, Progress] = rough, outliers, seed, progress
    calm, chosen = _calm(found), dict[str, Effect]()
    first = effects_of(found.problem, found.fit) if calm is not None else ()
    if calm is not None and any(each.chosen and each.name in _BY_FORCE for each in first):
        part = _by_calm(found, calm, *given)
        chosen = {each.name: each for each in part.effects if each.chosen} if part is not None else {}
        if part is not None and chosen:
            data, wider = _applied_by(part, found, chosen.values())
            again = _fitted(model, data, wider, *given)
            found, chosen = (again, chosen) if again.status == "ok" else (found, {})
    tested, notes = dict[str, Effect](), list[str]()
    for _ in range(_ROUNDS):
        known = dict(chosen)
        for each in effects_of(found.problem, found.fit, known, found.scale):
            tested[each.name] = each
            if each.chosen:
                before = chosen.get(each.name, replace(each, value=0.0))
                chosen[each.name] = replace(before, value=before.value + each.value, sigma=each.sigma)
        if not chosen:
            break
        data, wider = applied(found.problem, found.fit, chosen.values(), measured, plan)
        again = _fitted(model, data, wider, *given)
        if again.status != "ok":
            more = ", ".join(name for name in chosen if name not in known)
            notes.append(f"{more or 'the last numbers of effects'}: left out, because the fit has no solution with it")
            chosen = known
            break
        found = again
        if all(
            name in known and abs(each.value - known[name].value) <= _SETTLED * abs(each.value)
            for name, each in chosen.items()
        ):
            break
    changed = {each.name: value for each, value in zip(found.unknowns, found.changes.tolist(), strict=True)}
    effects = [replace(each, value=changed.get(name, each.value)) for name, each in chosen.items()]
    effects += [replace(each, chosen=False) for name, each in tested.items() if name not in chosen]
    if corrected := ", ".join(name for name in chosen if name not in UNKNOWNS):
        notes.append(f"counts are corrected by {corrected}; --check does not correct later ones")
    return replace(found, effects=tuple(effects), notes=(*found.notes, *notes))


def _calm(found: Calibration) -> Mask | None:
    """Return the poses (N,) that stretch lines by at most twice the median; None if all do, or too few."""
    problem, plan = found.problem, found.problem.plan
    stretch = None if problem.elastic else stretch_of(problem, found.fit.theta, found.fit.poses)
    if stretch is None or plan.planes or plan.ranges:
        return None
    most = stretch.max(axis=1)
    calm = np.asarray(most <= _FAR * np.median(most))
    return None if calm.all() or calm.mean() < _CALM else calm


def _by_calm(
    found: Calibration, calm: Mask, rough: float, outliers: bool, seed: int, progress: Progress
) -> Calibration | None:
    """Return the calibration by the *calm* poses (N,) alone; None where they cannot be used without the others."""
    problem = found.problem
    try:
        part = _fitted(problem.model, problem.measured.only(calm), problem.plan, rough, outliers, seed, progress)
        return _with_effects(part, rough, outliers, seed, progress) if part.status == "ok" else part
    except InputError:  # too few poses, or readings that only the others have
        return None


def _applied_by(part: Calibration, found: Calibration, effects: Collection[Effect]) -> tuple[Measured, CalibrationPlan]:
    """Return all data, those of *found*, and the plan with *effects*, at poses by the numbers of a *part* of them."""
    measured, plan, poses = found.problem.measured, found.problem.plan, found.fit.poses
    problem, given = part.problem.of(part.problem.model, measured, part.problem.plan), (measured, plan)
    for _ in range(_AT_POSES):
        fit = replace(part.fit, poses=poses, weights=problem.weights)
        given = applied(problem, fit, effects, measured, plan)
        problem = part.problem.of(part.problem.model, given[0], part.problem.plan)
        poses = fitted_poses(problem, part.fit.theta, poses)
    return given


def _fitted(
    model: Model,
    measured: Measured,
    plan: CalibrationPlan,
    rough: float,
    outliers: bool,
    seed: int,
    progress: Progress,
) -> Calibration:
    """Calibrate a model by one set of equations, without a verdict; see `calibrate`."""
    problem = problem_of(model, measured, plan)
    free = problem.without_datum()
    check(free)
    plain = (
        elastic_fit(free, seed, rough, progress)
        if isinstance(free, ElasticProblem)
        else best_fit(free, seed, rough, progress)
    )
    plain = to_file_frame(free, plain)
    found, rejected = plain, tuple[Rejected, ...]()
    if plain.code == 0:
        free, plain = roughly_weighed(framed(free, plain.theta, plain.poses), plain)
        found = plain
    if outliers and plain.code == 0:
        start = plain if measured.guess is None or free.elastic else first_start(free)
        found, rejected = without_outliers(free, plain, start, seed, progress)
    if plain.code == 0:
        free, found = weighed(free, found)
        found = resisting(free, found)
    found = to_file_frame(free, found)
    alone = information(free, found.theta, found.poses, found.weights)
    problem = problem.weighed_as(free)
    if problem.held.any():
        found = _to_datum(problem, free, found)
    posterior = information(problem, found.theta, found.poses, found.weights, priors=True)
    scale, chi = _scale(problem, found, posterior)
    rms = _rms(problem, found)
    status, reason = status_of(problem, found, posterior, rms, chi)
    notes = (*_notes(free, alone, scale, chi, rejected), *_of_kinds(problem, found), *_of_creep(problem, found))
    return Calibration(status, reason, problem, found, alone, posterior, rejected, scale, rms, plain.steps, notes)


def _to_datum(problem: CalibrationProblem, free: CalibrationProblem, found: PoseFit) -> PoseFit:
    """Return the fit with the datum's unknowns held. Raises `InputError` where the data contradict the datum."""
    moved = to_file_frame(problem, replace(found, theta=found.theta[~problem.held]))
    before, after = _rms(free, found), _rms(problem, moved)
    if after > _CONTRADICTS * before + 1e-7:
        names = ", ".join(problem.plan.datum)
        raise InputError(
            f"datum contradicts the data: with {names} as in the file, lengths fit to {after * 1e3:.3g} mm, otherwise "
            f"to {before * 1e3:.3g} mm; hold fewer points"
        )
    return replace(moved, code=max(found.code, moved.code))


def _rms(problem: CalibrationProblem, found: PoseFit) -> float:
    """Return the rms residual of the lengths that count, m."""
    m = problem.robot.m
    residual = problem.derivatives(found.theta, found.poses).residual[:, :m] * problem.encoder_sigma
    used = problem.of_poses(found.weights)[:, :m] > 0.0
    return float(np.sqrt(np.mean(residual[used] ** 2))) if used.any() else math.nan


def _scale(problem: CalibrationProblem, found: PoseFit, posterior: Information) -> tuple[float, float]:
    """Return sigma of the encoders over that of their weights, and the root of chi-squared per degree of freedom."""
    rows = problem.derivatives(found.theta, found.poses, found.weights)
    told = np.array([problem.factors.get(name, 1.0) for name in kind_of(problem).tolist()])
    survey = np.where(problem.is_prior, 1.0, problem.factors.get(SURVEY, 1.0))
    square = float(np.sum((rows.residual * told) ** 2) + np.sum((rows.others * survey) ** 2))
    surplus = posterior.redundancy
    chi = math.sqrt(square / surplus) if surplus > 0 else math.nan
    if problem.plan.sigma.encoder is not None or problem.has_other_sensors:
        return 1.0, chi
    return chi, chi


def _notes(
    problem: CalibrationProblem, alone: Information, scale: float, chi: float, rejected: tuple[Rejected, ...]
) -> Iterator[str]:
    """Yield sentences on the limits of the result."""
    given, robot = problem.plan.sigma.encoder, problem.robot
    if not problem.elastic and any(line.sheave.kind == "universal-joint" for line in robot.lines):
        yield "sheaves on universal joints count as swivelling about a vertical axis"
    if math.isnan(scale):
        yield "no measurement is left over: the sigma of the encoders is unknown, and so is every other sigma"
    elif given is None and alone.redundancy < _FEW and not problem.has_other_sensors:
        yield f"only {alone.redundancy} measurements are left over: sigma of the encoders, and so every sigma, is vague"
    elif given is None and problem.has_other_sensors and problem.found_encoder is None:
        yield f"no sigma.encoder is given: {problem.encoder_sigma * 1e3:g} mm is assumed"
    if (given is not None or problem.elastic) and math.isfinite(chi) and not 0.5 < chi < 2.0 and alone.redundancy > 5:
        yield f"residuals are {chi:.3g} times what the given sigmas predict"
    if robot.m < robot.freedoms and not problem.elastic:
        yield "the platform has more degrees of freedom than lines: with --cable elastic gravity determines the others"
    plan, measured = problem.plan, problem.measured
    tests_height = measured.positioned or plan.points or plan.planes or plan.ranges or plan.level is not None
    if problem.named("exit_point").any() and not tests_height:
        yield "nothing that was measured tests heights: an error of the model along z does not show in the sigmas"
    if rejected:
        yield f"{len(rejected)} of {problem.poses} poses do not fit the others: all or a line of each is left out"


def _of_creep(problem: CalibrationProblem, found: PoseFit) -> Iterator[str]:
    """Yield a sentence on creep that the robot file has and no row counts: data do not include the time under load."""
    shares = np.array([creep_share(line) for line in problem.robot.lines])
    if not shares.any():
        return
    stretch, size = stretch_of(problem, found.theta, found.poses) if found.code == 0 else None, ""
    if stretch is not None:
        longer = (stretch * shares).max(axis=0)
        worst = int(np.argmax(longer))
        line, most = problem.robot.lines[worst].name, 1e3 * longer[worst]
        size = f": an hour under its load makes line {line} longer by up to {most:.3g} mm"
    yield f"cable.creep of the robot file is not counted in lengths, because the data have no times{size}"


def _of_kinds(problem: CalibrationProblem, found: PoseFit) -> Iterator[str]:
    """Yield sentences on the sigma of each kind of measurement: what residuals make of it, or that they cannot."""
    if found.code != 0 or not problem.has_other_sensors:
        return
    for kind in kind_fits(problem, found):
        factor = problem.factors.get(kind.name, 1.0)
        if abs(factor - 1.0) > _SHOWN:
            yield f"residuals of the {kind.name} require {factor:.3g} times their sigma: this is assumed"
        elif kind.name != "lengths" and kind.redundancy < ENOUGH:
            yield f"the {kind.name} have a redundancy of {kind.redundancy:.2g} only: their sigma is as given"
