"""Calibration: numbers of a robot from what was measured at poses, how well they are known, and what stays open.

Self-calibration from encoders alone: Wang, Caro 2021. Plain least squares first, then gross errors are taken out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.calibration.checks import check, check_lengths
from cablewright.calibration.elastic_lines import Hanging
from cablewright.calibration.elastic_start import hanging_fit
from cablewright.calibration.observability import (
    Direction,
    Information,
    Suggestion,
    information,
    open_freedoms,
    projected,
    suggestions,
    weakest,
)
from cablewright.calibration.outliers import Rejected, without_outliers
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.pose_fit import PoseFit, best_fit, first_start, fit, to_file_frame
from cablewright.calibration.problem import CalibrationProblem, Measured
from cablewright.calibration.unknowns import Unknown, with_values
from cablewright.errors import InputError
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.progress import Progress, silent
from cablewright.robot import Robot

__all__ = ["ROUGH", "Calibration", "calibrate"]

Array = NDArray[np.float64]

ROUGH: Final = 0.5
"""How far starts are from the file's exit points, m, where nobody says."""

_CONTRADICTS: Final = 3.0  # times the rms without it: a datum that fits this badly says what the data deny
_NO_FIT: Final = 0.01  # rms over the frame's diagonal from which the equations are not those of the machine
_TOO_LARGE: Final = 10.0  # rms over the given sigma
_FEW: Final = 10  # measurements left over that tell sigma to a quarter
_MIN_SIGMA: Final = 1e-6  # m: encoders that seem better than this are taken to be as good


@dataclass(frozen=True, eq=False)
class Calibration:
    """What data say of a robot. `status` is "ok", or else `reason` says what went wrong and `robot` is the old one.

    `values` and `sigma` are of `unknowns`, in their SI units; sigma is NaN where nothing tells it, 0 where the datum
    holds the value. `alone` is what the data say by themselves, before datum and priors.
    """

    status: str
    reason: str
    problem: CalibrationProblem
    fit: PoseFit
    alone: Information
    posterior: Information
    rejected: tuple[Rejected, ...]
    scale: float  # sigma of the encoders over that of the weights
    rms: float  # m
    iterations: int
    notes: tuple[str, ...]

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        """What was looked for."""
        return self.problem.unknowns

    @property
    def poses(self) -> Array:
        """The poses (N, n), m and rad."""
        return self.problem.poses_of(self.fit.poses)

    @property
    def _sizes(self) -> Array:
        return np.array([each.size for each in self.unknowns])

    @cached_property
    def values(self) -> Array:
        """The unknowns (k,)."""
        return np.asarray(self.problem.whole(self.fit.theta) * self._sizes)

    @cached_property
    def covariance(self) -> Array:
        """Of the unknowns (k, k), datum and priors counted."""
        free = ~self.problem.held
        found = np.zeros((len(free), len(free)))
        found[np.ix_(free, free)] = self.posterior.covariance * self.scale**2
        return found * np.outer(self._sizes, self._sizes)

    @property
    def sigma(self) -> Array:
        """Standard deviations of the unknowns (k,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance).clip(min=0.0)))

    @property
    def encoder_sigma(self) -> float:
        """Standard deviation of the encoders, m: the given one, or that which the residuals tell."""
        return self.scale * self.problem.encoder_sigma

    @cached_property
    def residuals(self) -> Array:
        """What is left of each length (N, m), m, those left out too."""
        found = self.problem.derivatives(self.fit.theta, self.fit.poses)
        return found.residual[:, : self.problem.robot.m] * self.problem.encoder_sigma

    @property
    def used(self) -> NDArray[np.bool_]:
        """Which lengths (N, m) count."""
        return self.problem.of_poses(self.fit.weights)[:, : self.problem.robot.m] > 0.0

    @cached_property
    def gauge(self) -> tuple[str, ...]:
        """The freedoms that the data alone leave open, in words."""
        return open_freedoms(self.alone)

    @cached_property
    def weakest(self) -> tuple[Direction, ...]:
        """The least known combinations that are not open, sigma as the data tell it."""
        found = weakest(self.alone)
        return tuple(replace(each, sigma=each.sigma * self.scale) for each in found)

    @cached_property
    def suggestions(self) -> tuple[Suggestion, ...]:
        """What one more measurement would bring, the most helpful first."""
        if not math.isfinite(self.scale) or self.scale <= 0.0:
            return ()
        counted = information(
            self.problem.freed(),
            self.problem.whole(self.fit.theta),
            self.fit.poses,
            self.fit.weights,
            priors=True,
        )
        return suggestions(counted, max(self.scale, _MIN_SIGMA / self.problem.encoder_sigma))

    @cached_property
    def robot(self) -> Robot:
        """The calibrated robot; the old one unless `status` is "ok"."""
        if self.status != "ok":
            return self.problem.robot
        return with_values(self.problem.robot, self.unknowns, self.values, raised=self.problem.hangs)


def calibrate(
    robot: Robot,
    measured: Measured,
    plan: CalibrationPlan | None = None,
    *,
    seed: int = 0,
    rough: float = ROUGH,
    outliers: bool = True,
    cable: str = "rigid",
    progress: Progress = silent,
) -> Calibration:
    """Calibrate *robot*, whose numbers are the first guess; exit points may be *rough* (m) off in each coordinate.

    *cable* is "rigid", or "elastic" or "catenary": lines that stretch, or sag too. Raises `InputError` for data or a
    plan that cannot be used: too few poses, other units, a contradictory datum; `AnswerError` where lines that hang do
    not hold the platform near any pose.
    """
    plan, law = plan or CalibrationPlan(), Fidelity.of(cable)
    check_lengths(robot, measured)
    held: CalibrationProblem
    if law.cable is CableLaw.RIGID:
        held = CalibrationProblem.of(robot, measured, plan)
    else:
        held = Hanging.under(Model(robot, law), measured, plan)
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
