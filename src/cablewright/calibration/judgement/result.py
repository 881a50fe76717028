"""The result of a calibration: values, covariance, undetermined combinations, useful further measurements."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, ClassVar, Final

import numpy as np
from scipy import special

from cablewright.calibration.judgement.gross_errors import Rejected
from cablewright.calibration.judgement.likely_changes import CHANGE_PARTS, Explanation
from cablewright.calibration.judgement.model_doubt import ModelDoubt, model_doubt
from cablewright.calibration.judgement.score_tests import Score, scores
from cablewright.calibration.judgement.sigmas import kind_fits
from cablewright.calibration.judgement.unmodelled_effects import Effect, alternatives
from cablewright.calibration.poses.fit import PoseFit
from cablewright.calibration.poses.observability import (
    Direction,
    Information,
    Suggestion,
    information,
    open_freedoms,
    suggestions,
    weakest,
)
from cablewright.calibration.poses.problem import CalibrationProblem
from cablewright.calibration.sightings.placing import words_of
from cablewright.calibration.unknowns import Unknown, exit_rows, with_offsets, with_values
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.results import Figure, Pictured
from cablewright.robot import Robot

_MATTERS: Final = 0.1  # share of a variance from which on it is worth a measurement
_MIN_SIGMA: Final = 1e-6  # m, of the encoders in suggestions


def _by_label(name: str, found: Calibration) -> dict[str, float]:
    return dict(zip((each.label for each in found.unknowns), getattr(found, name).tolist(), strict=True))


def _rejected(found: Calibration) -> list[dict[str, Any]]:
    places = found.problem.measured.places
    return [
        {"pose": each.pose + 1, "row": places[each.pose] if len(places) else None}
        | {name: getattr(each, name) for name in ("line", "sensor", "size", "unit", "measured", "expected")}
        for each in found.rejected
    ]


FIGURES = (
    Figure("verdict", "", "good, doubtful (to be accepted or not) or bad (there is no robot)."),
    Figure("reasons", "", "Why it is not good: sentences with subject, value and limit.", sentences=True),
    Figure("exit_sigma", "m", "Largest standard deviation of a coordinate of an exit point, in the plane of a platform "
           "that has one; null if none is unknown.", name="exit points known to", digits=3, shown="mm"),
    Figure("status", "", "ok, or why there is no answer: not-converged, inconsistent, degenerate."),
    Figure("reason", "", "Why there is no answer, in a sentence; null where there is one.",
           lambda of: of.reason or None,
           detail=True),
    Figure("cable", "", "Cable law of the lines: rigid, elastic or catenary.", "problem.cable"),
    Figure("rms", "m", "Root mean square of the residuals of the lengths that are used.", name="residual, rms"),
    Figure("encoder_sigma", "m", "Standard deviation of the encoders, given or estimated from the residuals.",
           name="encoder sigma"),
    Figure("iterations", "1", "Iterations of the fit.", detail=True),
    Figure("poses", "1", "Number of poses measured.", "problem.poses"),
    Figure("unknowns", "1", "Number of unknowns, those of the poses included.", "alone.total"),
    Figure("rank", "1", "Number of unknowns that the data alone determine.", "alone.rank", "determined by the data"),
    Figure("gauge", "", "Combinations that the data alone do not determine.", name="left open"),
    Figure("datum", "", "What fixes the frame: exit points held, or inner: on average as in the robot file.",
           lambda found: found.problem.plan.datum or ("inner",)),
    Figure("weakest", "", "Least known combinations of unknowns that are not open.", name="least known combinations",
           parts=(
        Figure("direction", "", "The combination.", "words"),
        Figure("sigma", "SI", "Its standard deviation.", digits=3),
        Figure("unit", "", "Unit of the standard deviation."),
    )),
    Figure("labels", "", "Names of the unknowns of the robot.", lambda of: [each.label for each in of.unknowns],
           "unknown",
           along="unknown"),
    Figure("values", "SI", "Value of each unknown, by its name.", partial(_by_label, "values"), "value", 8,
           along="unknown"),
    Figure("sigma", "SI", "Standard deviation of each unknown, by its name.", partial(_by_label, "sigma"), "", 3,
           along="unknown"),
    Figure("noise_sigma", "SI", "Standard deviation by the noise of the measurements alone, by its name.",
           partial(_by_label, "noise_sigma"), along="unknown", detail=True),
    Figure("model_sigma", "SI", "Standard deviation if every number that is considered were as wrong as assumed.",
           partial(_by_label, "model_sigma"), along="unknown", detail=True),
    Figure("three_sigmas", "", "The least known coordinate: its standard deviation by noise, that to use, and that if "
           "every number that is considered were as wrong as assumed.", name="standard deviations",
           only=lambda of: of.three_sigmas != ""),
    Figure("sigma_advice", "", "Which standard deviation to use; its largest source.", name="advice",
           only=lambda of: of.status == "ok"),
    Figure("considered", "", "Numbers of the robot file that count as known, with their possible errors.",
           lambda of: of.doubt.considered, detail=True, parts=(
        Figure("words", "", "The number."),
        Figure("value", "SI", "Error by the data, weighted by its credibility."),
        Figure("sigma", "SI", "Standard deviation of that."),
        Figure("unit", "", "Unit of both."),
        Figure("shift", "m", "What that moves a coordinate of an exit point by, at most."),
        Figure("probability", "1", "Probability by the data that its kind of number is in error, 0.5 before them."),
        Figure("share", "1", "Share of the variance of the least known coordinate of an exit point."),
    )),
    Figure("unseen", "", "For each kind of known number of a single line: how large an error the data could hide.",
           sentences=True, only=lambda of: bool(of.unseen), detail=True),
    Figure("effects", "", "Effects that the model may lack: which the data ask for, by the held-out error of lengths.",
           only=lambda of: bool(of.effects), parts=(
        Figure("name", "", "Name of the effect.", name="effect"),
        Figure("words", "", "Description of the number.", name="number"),
        Figure("value", "SI", "The number by the data; of an unknown its change from the file.", digits=3),
        Figure("sigma", "SI", "Standard deviation of it.", digits=2),
        Figure("unit", "", "Unit of both."),
        Figure("before", "m", "Held-out error without it.", name="held-out error without", digits=3, shown="mm"),
        Figure("after", "m", "Held-out error with it.", name="with", digits=3, shown="mm"),
        Figure("fall", "1", "Fall of the held-out error.", digits=2, shown="%"),
        Figure("chosen", "", "Whether it is in the model."),
    )),
    Figure("changes", "SI", "Change from the robot file; null for what is not in it.", name="change", digits=3,
           along="unknown"),
    Figure("units", "", "SI units of the unknowns.", lambda of: [each.unit for each in of.unknowns], "unit",
           along="unknown"),
    Figure("covariance", "SI", "Covariance of the unknowns, in their order.", detail=True),
    Figure("rejected", "", "Poses or single readings that are left out.", _rejected, "left out", parts=(
        Figure("pose", "1", "Number of the pose, from 1."),
        Figure("row", "1", "Row of the file."),
        Figure("line", "", "Line of the reading; null where the whole pose is left out."),
        Figure("sensor", "", "Sensor of the reading."),
        Figure("size", "SI", "Error of the reading.", name="error", digits=3),
        Figure("unit", "", "Unit of the error."),
        Figure("measured", "SI", "The reading; of a whole pose those of all encoders.", digits=6),
        Figure("expected", "SI", "What all others predict it to be.", digits=6),
    )),
    Figure("pictures", "", "Sightings that are left out, and tags that are not where the layout has them.",
           lambda of: list(words_of(of.problem.measured.sightings)), sentences=True,
           only=lambda of: of.problem.measured.sightings is not None),
    Figure("suggestions", "", "What one more measurement would bring, the most helpful first.",
           name="one more measurement",
           parts=(
        Figure("measurement", "", "The measurement.", "words"),
        Figure("sigma_before", "m", "Standard deviation of the exit points without it, root mean square.", "before",
               "sigma before", 3, shown="mm"),
        Figure("sigma_after", "m", "That with it.", "after", "sigma after", 3, shown="mm"),
        Figure("open_before", "1", "Number of undetermined combinations without it.", name="open before"),
        Figure("open_after", "1", "Number of undetermined combinations with it.", name="open after"),
    )),
    Figure("last", "", "Date and data of the calibration before, which this one is compared with.",
           name="last calibration",
           only=lambda of: of.moved is not None),
    Figure("moved_probability", "1", "Probability of the difference from that if nothing moved.", "moved.probability",
           "probability if nothing moved", 2, lambda of: of.moved is not None),
    Figure("moved", "", "What moved since, after the best translation and yaw.", "moved.changes", "moved since",
           only=lambda of: of.moved is not None, parts=CHANGE_PARTS),
    Figure("pose", "m, rad", "The poses.", "poses", detail=True),
    Figure("starts", "1", "Number of starts that were tried.", "fit.starts", detail=True),
    Figure("notes", "", "What a careful person would ask.", detail=True),
    Figure("robot", "", "The calibrated robot; the old one if the verdict is bad.",
           lambda found: found.robot.model_dump(mode="json"), detail=True),
)  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Calibration(Pictured):
    """The result of a calibration.

    `status` is "ok", or `reason` says why there is no answer. The `verdict` is "good", "doubtful" or "bad", for the
    `reasons`; if it is bad, `robot` is the given one. `values` and `sigma` are of `unknowns`, in SI units; sigma is NaN
    where it is unknown, 0 where the datum holds the value. `alone` is the information from the data alone, without
    datum and priors.
    """

    FIGURES: ClassVar = FIGURES
    HEADLINES: ClassVar = ("verdict", "exit_sigma", "poses", "rms", "unknowns", "rank")

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
    verdict: str = "good"
    reasons: tuple[str, ...] = ()
    effects: tuple[Effect, ...] = ()  # with models = "auto"
    accepted: bool = False  # a doubtful one is taken as it is
    last: str = ""  # the calibration before
    moved: Explanation | None = None  # what is different from it

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        """The unknowns of the robot."""
        return self.problem.unknowns

    @property
    def poses(self) -> Array:
        """The poses (N, n), m and rad."""
        return self.problem.poses_of(self.fit.poses)

    @property
    def ok(self) -> bool:
        """Whether the answer may be used: it is good, or doubtful and accepted."""
        return self.verdict == "good" or (self.verdict == "doubtful" and self.accepted)

    @property
    def refusal(self) -> str:
        """Sentence that explains why the calibration may not be used; empty if it may."""
        if self.ok:
            return ""
        if self.verdict == "doubtful":
            return f"doubtful: {self.reasons[0]} (--accept takes it as it is)"
        return f"not calibrated: {self.reasons[0]}"

    @property
    def _sizes(self) -> Array:
        return np.array([each.size for each in self.unknowns])

    @cached_property
    def values(self) -> Array:
        """Values of the unknowns (k,)."""
        return np.asarray(self.problem.whole(self.fit.theta) * self._sizes)

    @property
    def changes(self) -> Array:
        """Differences of the values from the robot file (k,); NaN for lengths at home, which it does not have."""
        new = np.array([each.name == "length_offset" for each in self.unknowns])
        return np.where(new, np.nan, self.values - np.asarray(self.problem.start) * self._sizes)

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the unknowns (k, k), with datum and priors: of noise and of possible errors of the model."""
        return self._of_all(self.doubt.covariance)

    @cached_property
    def joint_covariance(self) -> Array:
        """Covariance (k + q, k + q) of the unknowns and of the q numbers that are considered."""
        every = np.append(
            np.flatnonzero(~self.problem.held), len(self.unknowns) + np.arange(len(self.doubt.considered))
        )
        found = np.zeros((len(self.unknowns) + len(self.doubt.considered),) * 2)
        found[np.ix_(every, every)] = self.doubt.joint
        sizes = np.append(self._sizes, np.ones(len(self.doubt.considered)))
        return found * np.outer(sizes, sizes)

    @cached_property
    def noise_sigma(self) -> Array:
        """Standard deviations of the unknowns (k,) by the noise of the measurements alone."""
        return np.asarray(np.sqrt(np.diag(self._of_all(self.posterior.covariance * self.scale**2)).clip(min=0.0)))

    @property
    def model_sigma(self) -> Array:
        """Standard deviations of the unknowns (k,) if every number that is considered were as wrong as assumed."""
        return np.asarray(np.sqrt(np.diag(self._of_all(np.diag(self.doubt.largest))).clip(min=0.0)))

    @property
    def three_sigmas(self) -> str:
        """Sentence with three standard deviations of the worst length: by noise, to use, and the largest assumed."""
        lengths = [at for at, each in enumerate(self.unknowns) if each.unit == "m" and np.isfinite(self.sigma[at])]
        which = [at for at in lengths if self.unknowns[at].name == "exit_point"] or lengths
        if self.status != "ok" or not which:
            return ""
        worst = max(which, key=lambda at: self.sigma[at])
        noise, use, model = (1e3 * each[worst] for each in (self.noise_sigma, self.sigma, self.model_sigma))
        return (
            f"{self.unknowns[worst].label}: {noise:.3g} mm by noise, {use:.3g} mm to use, {model:.3g} mm if every "
            "number that is considered were as wrong as assumed"
        )

    @property
    def sigma_advice(self) -> str:
        """Advice in a sentence: the standard deviation to use, and the known number that dominates it."""
        worst = max(self.doubt.considered, key=lambda each: each.share, default=None)
        if worst is None or worst.share < _MATTERS:
            return "use sigma: noise makes nearly all of it"
        return (
            f"use sigma: the {worst.words} makes {100.0 * worst.share:.2g} % of the variance of the least known "
            f"coordinate; measure it (known) or find it (unknowns)"
        )

    @cached_property
    def doubt(self) -> ModelDoubt:
        """Contribution to sigmas of known numbers of the robot file, and of scatter of the poses."""
        effects = alternatives(self.problem, self.fit, self.effects)
        return model_doubt(self.problem, self.fit, self.posterior, self.scale, effects)

    @cached_property
    def scores(self) -> tuple[Score, ...]:
        """Tests of numbers of single lines that count as known, the most significant first."""
        effects = alternatives(self.problem, self.fit, self.effects)
        return scores(self.problem, self.fit, self.posterior, self.scale, effects)

    @property
    def unseen(self) -> tuple[str, ...]:
        """Sentences, one for each kind of number in `scores`: the smallest error of it that shows in the data."""
        worst = dict[str, Score]()
        for each in self.scores:
            worst[each.kind] = max(each, worst.get(each.kind, each), key=lambda one: one.sigma)
        return tuple(
            f"an error of the {each.words} shows only from {each.shows:.2g}"
            f"{'' if each.unit == '1' else ' ' + each.unit}, in four of five cases"
            for each in worst.values()
        )

    def _of_all(self, covariance: Array) -> Array:
        """Return the covariance of all unknowns (k, k), SI, from that of the free ones."""
        free = ~self.problem.held
        found = np.zeros((len(free), len(free)))
        found[np.ix_(free, free)] = covariance
        return found * np.outer(self._sizes, self._sizes)

    @property
    def sigma(self) -> Array:
        """Standard deviations of the unknowns (k,), of noise and model together."""
        return np.asarray(np.sqrt(np.diag(self.covariance).clip(min=0.0)))

    @property
    def exit_sigma(self) -> float | None:
        """The largest standard deviation of a coordinate of an exit point, m; None if none is unknown.

        Of a platform in a plane it is that along one of the plane's axes.
        """
        rows, _ = exit_rows(self.problem.robot, self.unknowns)
        return float(self.exit_sigmas(rows).max()) if len(rows) else None

    def joint_limit(self, count: int, share: float = 0.95) -> float:
        """Return the sum of squares, by `covariance`, within which *count* values together lie with a probability.

        It is a quantile of chi-squared where the sigma of the encoders is given, else, with the redundancy of the
        lengths that estimate it, of the F distribution.
        """
        if self.problem.plan.sigma.encoder is not None:
            return float(special.chdtri(count, 1.0 - share))
        redundancy = max(kind_fits(self.problem, self.fit)[0].redundancy, 1.0)
        return count * float(special.fdtri(count, redundancy, share))

    def exit_sigmas(self, rows: Array) -> Array:
        """Return the standard deviations (a,) of combinations of unknowns, *rows* (a, k)."""
        return np.asarray(np.sqrt(np.sum((rows @ self.covariance) * rows, axis=1).clip(min=0.0)))

    @property
    def encoder_sigma(self) -> float:
        """Standard deviation of the encoders, m: the given one, or that estimated from the residuals."""
        return self.scale * self.problem.encoder_sigma

    @cached_property
    def residuals(self) -> Array:
        """Residual of each length (N, m), m, rejected ones included."""
        found = self.problem.derivatives(self.fit.theta, self.fit.poses)
        return found.residual[:, : self.problem.robot.m] * self.problem.encoder_sigma

    @property
    def used(self) -> Mask:
        """Mask (N, m) of the measured lengths that the fit uses: all but outliers."""
        return self.problem.of_poses(self.fit.weights)[:, : self.problem.robot.m] > 0.0

    @cached_property
    def gauge(self) -> tuple[str, ...]:
        """The combinations of unknowns that the data alone leave open, in words."""
        return open_freedoms(self.alone)

    @cached_property
    def weakest(self) -> tuple[Direction, ...]:
        """The combinations of unknowns with the largest standard deviations among those that are determined."""
        return tuple(replace(each, sigma=each.sigma * self.scale) for each in weakest(self.alone))

    @cached_property
    def suggestions(self) -> tuple[Suggestion, ...]:
        """Further measurements, each with its effect on the sigmas, the most helpful first."""
        if not math.isfinite(self.scale) or self.scale <= 0.0:
            return ()
        free, theta = self.problem.without_datum().weighed_as(self.problem), self.problem.whole(self.fit.theta)
        counted = information(free, theta, self.fit.poses, self.fit.weights, priors=True)
        return suggestions(counted, max(self.scale, _MIN_SIGMA / self.problem.encoder_sigma))

    @cached_property
    def robot(self) -> Robot:
        """The calibrated robot; the given one if the verdict is bad. Raises `InputError` for values no robot has."""
        robot, seen = self.problem.robot, self.problem.measured.sightings
        if seen is not None and seen.platform is not None:  # pictures show a body, the file has a point
            robot = robot.model_copy(update={"platform": seen.platform})
        if self.verdict == "bad":
            return robot
        elastic = self.problem.elastic
        found = with_values(robot, self.unknowns, self.values, raised=elastic)
        return with_offsets(found, self.unknowns, self.values, elastic) if robot.sharing else found
