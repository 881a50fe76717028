"""Whether a fit has an answer at all: converged, within reason, determined, consistent; and what to do where not."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final

import numpy as np

from cablewright.calibration.measured import SENSORS
from cablewright.calibration.poses.bounds import at_bound
from cablewright.calibration.poses.fit import PoseFit
from cablewright.calibration.poses.observability import Information, beyond_frames, combination, remedy
from cablewright.calibration.poses.problem import CalibrationProblem
from cablewright.calibration.sensors.exit_points import across_rows

_NO_FIT: Final = 0.01  # max rms over the frame's diagonal; above, the equations are not those of the machine
_TOO_LARGE: Final = 10.0  # max rms over the given sigma
_ACROSS: Final = 1.0 / 3.0  # max sigma of an exit point's distance from the plane, over that distance
_LARGE: Final = 0.05  # part of an unknown in a direction of length 1 that counts


def status_of(
    problem: CalibrationProblem, found: PoseFit, posterior: Information, rms: float, chi: float
) -> tuple[str, str]:
    """Return the status of a fit, and why it is no answer in a sentence; *posterior*: with datum and priors."""
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
    """Return which exit points are off the platform's plane by an unknown amount; empty for none, or without a plane.

    Lengths depend on the square of that distance. Known to no better than a third of it from them alone, it is not
    known at all: its sign is open, and fits creep to where lengths no longer depend on it.
    """
    robot, plane = problem.robot, problem.robot.platform.plane
    if plane is None or not problem.named("exit_point").any():
        return ""
    rows = across_rows(robot, posterior.unknowns)
    told = np.any(problem.rows.linear @ rows.T != 0.0, axis=0)  # by the plan
    off = (posterior.exits - posterior.ties) @ np.array(plane.across) - plane.distance
    sigma = np.sqrt(np.einsum("ma,ab,mb->m", rows, posterior.covariance, rows)) * max(float(np.nan_to_num(chi)), 1e-9)
    sigma[np.linalg.norm(rows @ posterior.null, axis=1) > _LARGE * np.linalg.norm(rows, axis=1)] = np.inf
    lost = np.flatnonzero(~told & rows.any(axis=1) & (sigma > _ACROSS * np.abs(off)))
    if not len(lost):
        return ""
    names = ", ".join(robot.lines[at].name for at in lost)
    return (
        f"lengths hardly tell how far exit points are off the plane {plane} ({names}): say in the plan how well the "
        'robot file knows it, as in across = "2 mm"'
    )


def _inconsistent(problem: CalibrationProblem, rms: float, chi: float) -> str:
    diagonal = math.dist(problem.robot.scene.frame_min, problem.robot.scene.frame_max)
    given = problem.plan.sigma.encoder
    limit = _NO_FIT * diagonal if given is None else max(_TOO_LARGE * given, 1e-6)
    if problem.elastic and chi > _TOO_LARGE:
        size = f"residuals are {chi:.3g} times what the sigmas predict"
        return f"{size}: are sigma.tension and sigma.encoder those of the sensors, lines in order?{zeros(problem)}"
    if rms > limit:
        size = f"lengths fit to {rms * 1e3:.3g} mm only, over the limit of {limit * 1e3:.3g} mm"
        return f"{size}: check the order of the lines, wrap sides, signs and units{zeros(problem)}"
    return ""


def zeros(problem: CalibrationProblem, of: Iterable[str] = SENSORS) -> str:
    """Return what to try where zeros of the sensors *of* some names may be wrong; empty if none counts as right."""
    unsure = [each for each in of if problem.measured.has(each) and f"{each}_offset" not in problem.plan.unknowns]
    names = " and ".join(f"{each}_offset" for each in unsure)
    return f"; if their zero is not sure, add {names} to the unknowns" if names else ""


def _at_bound(problem: CalibrationProblem, found: PoseFit) -> str:
    """Return which unknowns ended at the edge of their range; empty for none."""
    limits = problem.limits
    in_file = np.where([each.in_file for each in problem.free_unknowns], problem.free, np.nan)
    in_file[problem.named("exit_compliance")] = 0.0  # a mount that does not give is an answer, whatever the file has
    ends = np.logical_or(*at_bound(found.theta, limits, in_file))
    where = np.flatnonzero(ends)
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
    """Return what the data leave open besides the place of frames; empty for nothing."""
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
