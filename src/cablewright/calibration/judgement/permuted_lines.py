"""Data whose lines are in another order or count in the other direction: which permutation fits them much better."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, permutations
from typing import Final

import numpy as np

from cablewright.calibration.measurements import Measured
from cablewright.calibration.poses.fit import PoseFit
from cablewright.calibration.poses.problem import CalibrationProblem, StraightProblem
from cablewright.calibration.poses.simulation import aligned
from cablewright.calibration.poses.start_values import quick_fit, typical_residual
from cablewright.calibration.unknowns import of_unknown_exits
from cablewright.foundation.arrays import Array

_ALL: Final = 4  # lines up to which every order is tried; with more: two exchanged, all shifted, all reversed
_BETTER: Final = 0.4  # max ratio of the residuals to those of the file's order
_NEARER: Final = 0.5  # max ratio of the motion of exit points and poses, where residuals are equal
_CLEARLY: Final = 0.05  # m: min difference of that motion
_AS_WELL: Final = 1.5  # max ratio of the residuals of nearer arrangements: noise explains it
_SENSIBLE: Final = 1e-3  # of the frame's diagonal: max residuals of nearer arrangements
_ALIKE: Final = 2.0
_NEAR: Final = 0.01  # m: arrangements as near as this count as equal; the one that moves the fewest lines is named
_EXACT: Final = 1e-9  # m: smaller residuals count as equal


@dataclass(frozen=True)
class _Trial:
    words: str
    rms: float  # m
    motion: float  # m, largest of a coordinate of an exit point
    stray: float  # m, median distance of poses from their start values

    @property
    def away(self) -> float:
        """Distance of the trial's values from the given ones, m."""
        return self.motion + self.stray


def better_arrangement(problem: CalibrationProblem, found: PoseFit, rough: float) -> str:
    """Return a sentence that names the order or directions of lines that fit the data much better; empty for none.

    Straight lines with a winch each only. *found*: the fit of the data as they are; *rough*: max error of the file's
    exit points, m.
    """
    if problem.elastic or problem.robot.winches < problem.robot.m:
        return ""
    given = min(_tried("", problem, problem.measured, rough), _told("", problem, found), key=lambda each: each.rms)
    sensible = _SENSIBLE * math.dist(problem.robot.scene.frame_min, problem.robot.scene.frame_max)
    good = []
    for words, moved, measured in _arrangements(problem.measured, problem.robot.m):
        trial = _tried(words, problem, measured, rough, given.rms)
        fits = trial.rms < _BETTER * given.rms - _EXACT and trial.motion <= max(rough, given.motion)
        as_well = trial.rms <= min(_AS_WELL * given.rms + _EXACT, sensible) and trial.motion <= rough
        nearer = as_well and trial.away < min(_NEARER * given.away, given.away - _CLEARLY)
        if fits or nearer:
            good.append((moved, trial))
    if not good:
        return ""
    smallest = min(trial.rms for _, trial in good)
    good = [each for each in good if each[1].rms <= _ALIKE * smallest + _EXACT]
    nearest = min(trial.away for _, trial in good)
    best = min((each for each in good if each[1].away <= _ALIKE * nearest + _NEAR), key=lambda each: each[0])[1]
    change = f"lengths fit to {1e3 * best.rms:.3g} mm instead of {1e3 * given.rms:.3g} mm"
    motion = f"exit points move by {best.motion:.3g} m instead of {given.motion:.3g} m"
    if best.rms >= _BETTER * given.rms - _EXACT:  # what decides stands first
        poses = f", poses are {best.stray:.3g} m from their start values instead of {given.stray:.3g} m"
        told = problem.measured.guess is not None
        return f"{best.words} would explain the data far better: {motion}{poses if told else ''}; {change}"
    return f"{best.words} would explain the data far better: {change}, {motion}"


def _tried(words: str, problem: CalibrationProblem, measured: Measured, rough: float, good: float = math.inf) -> _Trial:
    """Return how well *measured* fits from the file's numbers; residuals far beyond *good*, m, are not fitted on."""
    again = StraightProblem.of(problem.robot, measured, problem.plan, hold=False)
    return _told(words, again, quick_fit(again, rough, good))


def _told(words: str, problem: CalibrationProblem, found: PoseFit) -> _Trial:
    if not math.isfinite(found.cost) or not problem.is_finite(found.theta, found.poses):
        return _Trial(words, math.inf, math.inf, math.inf)
    moved = float(np.abs(motion(problem, found.theta)).max())
    return _Trial(words, typical_residual(problem, found), moved, stray(problem, found))


def stray(problem: CalibrationProblem, found: PoseFit) -> float:
    """Return the median distance of the fitted poses from their start values, m; 0 if there are no start values."""
    if problem.measured.guess is None:
        return 0.0
    off = problem.poses_of(found.poses)[:, :3] - problem.measured.guess[:, :3]
    return float(np.nanmedian(np.linalg.norm(off, axis=1)))


def motion(problem: CalibrationProblem, theta: Array) -> Array:
    """Return the distances, m, of exit points (k, 3) from those of the file, after the best translation and yaw.

    Of all lines, or of those whose exit points are unknowns if any are: the others keep the frame of the file.
    """
    seen = of_unknown_exits(problem.robot, problem.unknowns)
    seen |= not seen.any()
    file = np.array([line.exit_point for line in problem.robot.lines])[seen]
    points, _ = aligned(problem.points(theta)[seen], file)
    return np.asarray(points - file)


def _arrangements(measured: Measured, m: int) -> Iterator[tuple[str, int, Measured]]:
    """Yield other orders of the lines, and other signs of counts: words, how many lines are concerned, the data."""
    for order in _orders(m):
        moved = [at for at in range(m) if order[at] != at]
        if len(moved) == 2:
            words = f"columns {moved[0] + 1} and {moved[1] + 1} (dl, and others of lines) exchanged"
        else:
            words = f"columns of lines in the order {', '.join(str(at + 1) for at in order)}"
        yield words, len(moved), _ordered(measured, order)
    signs = np.eye(m) * -2.0 + 1.0
    for i in range(m):
        yield f"dl_{i + 1} with the other sign", 1, replace(measured, counted=measured.counted * signs[i])
    yield "all dl with the other sign", m, replace(measured, counted=-measured.counted)
    if measured.swivel is not None:
        yield "all swivel angles with the other sign", 1, replace(measured, swivel=-measured.swivel)
    if measured.guess is not None:
        for axis, name in enumerate("xyz"):
            mirrored = measured.guess.copy()
            mirrored[:, axis] = 2.0 * np.nanmean(mirrored[:, axis]) - mirrored[:, axis]
            yield f"{name} of the poses mirrored", m, replace(measured, guess=mirrored)


def _orders(m: int) -> Iterator[Sequence[int]]:
    same = tuple(range(m))
    if m <= _ALL:
        yield from (order for order in permutations(same) if order != same)
        return
    for a, b in combinations(same, 2):
        order = list(same)
        order[a], order[b] = b, a
        yield order
    shifted = [same[by:] + same[:by] for by in range(1, m)]
    yield from shifted
    yield from (each[::-1] for each in (same, *shifted))


def _ordered(measured: Measured, order: Sequence[int]) -> Measured:
    columns = list(order)
    parts = {name: getattr(measured, name) for name in ("counted", "tensions", "swivel")}
    return replace(measured, **{name: each[:, columns] for name, each in parts.items() if each is not None})
