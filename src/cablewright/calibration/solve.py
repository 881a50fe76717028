"""Calibration: numbers of a robot from what was measured at poses, how well they are known, and what stays open.

Self-calibration from encoders alone: Wang, Caro 2021. Plain least squares first, then gross errors are taken out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.calibration.checks import check, check_lengths
from cablewright.calibration.data import read_measured
from cablewright.calibration.elastic_lines import Hanging
from cablewright.calibration.elastic_start import hanging_fit
from cablewright.calibration.observability import Information, information, projected
from cablewright.calibration.outliers import Rejected, without_outliers
from cablewright.calibration.plan import CalibrationPlan, plan_of
from cablewright.calibration.pose_fit import PoseFit, best_fit, first_start, fit, to_file_frame
from cablewright.calibration.problem import CalibrationProblem, Measured
from cablewright.calibration.result import Calibration
from cablewright.errors import InputError
from cablewright.models.fidelity import CableLaw, SheaveLaw
from cablewright.models.statics import Model
from cablewright.progress import Progress, silent
from cablewright.robot import Robot

ROUGH: Final = 0.5
"""How far starts are from the file's exit points, m, where nobody says."""

MOST_ROUGH: Final = 100.0  # m
_CONTRADICTS: Final = 3.0  # times the rms without it: a datum that fits this badly says what the data deny
_NO_FIT: Final = 0.01  # rms over the frame's diagonal from which the equations are not those of the machine
_TOO_LARGE: Final = 10.0  # rms over the given sigma
_FEW: Final = 10  # measurements left over that tell sigma to a quarter


def calibrate(
    robot: Robot | Model,
    data: str | Path | Measured,
    plan: str | Path | CalibrationPlan | None = None,
    *,
    cable: CableLaw | str | None = None,
    sheave: SheaveLaw | str | None = None,
    rough: float = ROUGH,
    outliers: bool = True,
    seed: int = 0,
    progress: Progress = silent,
) -> Calibration:
    """Calibrate *robot*, whose numbers are the first guess, from *data* measured at poses, or the CSV that has them.

    *plan* says what is unknown, how exact sensors are and what holds the frame, or names the TOML that does; by default
    exit points and home lengths are unknown. Lines are rigid unless a *cable* law or a model says that they give, which
    needs tensions or measured poses. Exit points may be *rough* (m) off in each coordinate: starts, drawn with *seed*,
    are so far apart. Gross errors are taken out unless *outliers* is false.

    Raises `InputError` for data or a plan that cannot be used: too few poses, other units, a contradictory datum;
    `AnswerError` where lines that hang do not hold the platform near any pose. Source: Wang, Caro 2021.

    Examples
    --------
    >>> import cablewright as cw
    >>> robot = cw.load("wang2021")
    >>> found = cw.calibrate(robot, cw.simulate_calibration(robot, 20, 1e-4, seed=1).measured)
    >>> found.status, found.alone.rank
    ('ok', 72)
    """
    if not 0.0 <= rough <= MOST_ROUGH:
        raise InputError(f"rough = {rough:g}: from 0 to {MOST_ROUGH:g} m is wanted")
    if seed < 0:
        raise InputError(f"seed = {seed}: must not be negative")
    model = Model.of(robot, cable=cable, sheave=sheave, default=CableLaw.RIGID)
    plan, robot = plan_of(plan), model.robot
    measured = data if isinstance(data, Measured) else read_measured(data, robot)
    check_lengths(robot, measured)
    held: CalibrationProblem
    if model.fidelity.cable is CableLaw.RIGID:
        held = CalibrationProblem.of(robot, measured, plan)
    else:
        held = Hanging.under(model, measured, plan)
    free = held.freed()
    if not free.unknowns:
        raise InputError("unknowns: there is nothing to be found")
    check(free)
    if isinstance(free, Hanging):
        plain = hanging_fit(free, seed, rough, progress)
    else:
        plain = best_fit(free, seed, rough, progress)
    found, rejected = plain, tuple[Rejected, ...]()
    if outliers and plain.code == 0:
        start = plain if measured.guess is None or free.hangs else first_start(free)
        found, rejected = without_outliers(free, plain, start, seed, progress)
    found = to_file_frame(free, found)
    alone = information(free, found.theta, found.poses, found.weights)
    steps = plain.steps
    if held.held.any():
        found = _to_datum(held, free, found)
    posterior = information(held, found.theta, found.poses, found.weights, priors=True)
    scale, chi = _scale(held, found, posterior)
    rms = _rms(held, found)
    status, reason = _verdict(held, plain, found, rms, chi)
    notes = tuple(_notes(free, alone, scale, chi, rejected))
    return Calibration(status, reason, held, found, alone, posterior, rejected, scale, rms, steps, notes)


def _to_datum(held: CalibrationProblem, free: CalibrationProblem, found: PoseFit) -> PoseFit:
    """Move a fit to where the datum holds what it names. Raises `InputError` where the data deny the datum."""
    weights = found.weights
    moved = fit(held, found.theta[~held.held], found.poses, weights)
    moved = to_file_frame(held, PoseFit(moved.theta, moved.poses, weights, moved.cost, moved.code, moved.steps))
    before, after = _rms(free, found), _rms(held, moved)
    if after > _CONTRADICTS * before + 1e-7:
        names = ", ".join(held.plan.datum)
        told = f"with {names} where the file has them, lengths fit to {after * 1e3:.3g} mm, without to"
        raise InputError(f"datum contradicts the data: {told} {before * 1e3:.3g} mm; hold fewer points")
    return replace(found, theta=moved.theta, poses=moved.poses, cost=moved.cost, code=max(found.code, moved.code))


def _rms(problem: CalibrationProblem, found: PoseFit) -> float:
    """Root mean square of what is left of the lengths that count, m."""
    m = problem.robot.m
    residual = problem.derivatives(found.theta, found.poses).residual[:, :m] * problem.encoder_sigma
    used = problem.of_poses(found.weights)[:, :m] > 0.0
    return float(np.sqrt(np.mean(residual[used] ** 2))) if used.any() else math.nan


def _scale(problem: CalibrationProblem, found: PoseFit, posterior: Information) -> tuple[float, float]:
    """Sigma of the encoders over that of their weights, and the root of chi square over its freedom."""
    derivatives = problem.derivatives(found.theta, found.poses, found.weights)
    off, _, _ = projected(derivatives)
    square = float(np.sum(off * off) + np.sum(derivatives.others**2))
    surplus = posterior.redundancy
    chi = math.sqrt(square / surplus) if surplus > 0 else math.nan
    if problem.plan.sigma.encoder is not None or _other_sensors(problem):
        return 1.0, chi
    return chi, chi


def _other_sensors(problem: CalibrationProblem) -> bool:
    """Whether rows of known sigma stand beside the encoders'."""
    return problem.per_pose > problem.robot.m or len(problem.is_prior) > 0


def _verdict(problem: CalibrationProblem, plain: PoseFit, found: PoseFit, rms: float, chi: float) -> tuple[str, str]:
    """Status and reason."""
    if plain.code != 0 or found.code != 0 or not math.isfinite(found.cost):
        return "not-converged", f"no start of {plain.starts} led to a solution: are lines in the order of the file?"
    diagonal = math.dist(problem.robot.scene.frame_min, problem.robot.scene.frame_max)
    given = problem.plan.sigma.encoder
    limit = _NO_FIT * diagonal if given is None else max(_TOO_LARGE * given, 1e-6)
    if problem.hangs and chi > _TOO_LARGE:
        told = f"what is left is {chi:.3g} times what the sigmas let expect"
        return "inconsistent", f"{told}: are sigma.tension and sigma.encoder those of the sensors, lines in order?"
    if rms > limit:
        told = f"lengths fit to {rms * 1e3:.3g} mm only, {limit * 1e3:.3g} mm is the most that is believed"
        return "inconsistent", f"{told}: look at the order of the lines, wrap sides, signs and units"
    return "ok", ""


def _notes(
    problem: CalibrationProblem, alone: Information, scale: float, chi: float, rejected: tuple[Rejected, ...]
) -> Iterator[str]:
    """Yield what a careful person would ask."""
    given, robot = problem.plan.sigma.encoder, problem.robot
    if not problem.hangs and any(line.sheave.kind == "universal-joint" for line in robot.lines):
        yield "sheaves on universal joints are taken as if they swivelled about a vertical axis"
    if math.isnan(scale):
        yield "no measurement is left over: nothing tells how exact the encoders are, and so no sigma can be given"
    elif given is None and alone.redundancy < _FEW and not _other_sensors(problem):
        yield f"only {alone.redundancy} measurements are left over: the encoders' sigma, and so every sigma, is vague"
    elif given is None and _other_sensors(problem):
        yield f"no sigma.encoder is given: {problem.encoder_sigma * 1e3:g} mm is taken"
    if (given is not None or problem.hangs) and math.isfinite(chi) and not 0.5 < chi < 2.0 and alone.redundancy > 5:
        yield f"what is left is {chi:.3g} times what the given sigmas let expect"
    if rejected:
        yield f"{len(rejected)} of {problem.poses} poses do not fit the others: all or a line of each is left out"
