"""Sigmas of the kinds of measurement, estimated from residuals, and smaller weights for rows with large residuals.

The sigma of a kind is such that its squared residuals sum to its redundancy (Foerstner 1979): at the end of the rounds
that is the variance component of restricted maximum likelihood. A row's leverage is the share of it that the fit
absorbs: rows of redundancy 1 - leverage test the fit.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import special

from cablewright.calibration.measurement_rows.measurement_kinds import KINDS, ON_ONE_DRUM, SIGMA_OF
from cablewright.calibration.poses.fit import PoseFit, refit
from cablewright.calibration.poses.observability import information
from cablewright.calibration.poses.problem import SURVEY, CalibrationProblem
from cablewright.foundation.arrays import Array, Mask

_CARRIES: Final = 1e-3  # min leverage of a measured coordinate: below, others know it 30 times better
_ROUNDS: Final = 8
_EVENING: Final = 15  # rounds: a sigma given 1000 times too large falls by a few times in each
_SAME: Final = 0.02  # relative change of a sigma, or of weights, that ends the rounds
_ROUGHLY: Final = 0.2  # such a change where gross errors may still be in
ENOUGH: Final = 5.0  # redundancy of a kind with which its sigma can be estimated
_LEAST: Final = 1.0  # redundancy with which a given sigma may grow
_DENIED: Final = 0.05  # probability of residuals, by the given sigma, under which it grows where few test it
_FACTORS: Final = np.linspace(0.0, 2.0 * np.log(30.0), 300)  # logarithms of factors on a given variance
_PLAINLY: Final = 10.0  # ratio of residuals to their sigma beyond which it is too small
_USUAL: Final = 2.0 * np.log(3.0)  # of such factors on machines, where the given sigma is too small
_TESTED: Final = 0.05  # redundancy of a row whose residual shows its sigma
_EXACT: Final = 1e-6  # m: min estimated sigma of the encoders
_SMALLEST: Final = 1e-4  # min estimated sigma of another kind over the given one
_MEDIAN: Final = 0.6745  # median of the size of a standard normal number
_HUBER: Final = 1.5  # sigmas beyond which a row of these pulls no harder: 96 % efficient where nothing is wrong


@dataclass(frozen=True)
class KindFit:
    """Goodness of fit of one kind of measurement: rms residual over the given sigma, with its redundancy."""

    name: str
    ratio: float
    redundancy: float
    count: int


def kind_of(problem: CalibrationProblem) -> NDArray[np.str_]:
    """Return the name of the kind of measurement of each row (e,) of a pose."""
    return np.array([KINDS[int(code)].words for code in problem.rows.kind[: problem.per_pose]])


def leverages(problem: CalibrationProblem, found: PoseFit) -> Array:
    """Return the leverage (N, e) of each equation of each pose; 0 for equations without a value."""
    rows = problem.derivatives(found.theta, found.poses, found.weights)
    rows = rows.blank(np.logical_not(rows.whole))
    covariance = information(problem, found.theta, found.poses, found.weights, priors=True).covariance
    left, values, _ = np.linalg.svd(rows.by_pose, full_matrices=False)
    kept = left * (values > 1e-9 * np.maximum(values.max(axis=1, initial=0.0, keepdims=True), 1e-300))[:, None]
    rest = rows.by_unknown - kept @ (np.swapaxes(kept, 1, 2) @ rows.by_unknown)
    own, shared = np.sum(kept**2, axis=2), np.sum((rest @ covariance) * rest, axis=2)
    return np.asarray((own + shared).clip(0.0, 1.0))


def kind_fits(problem: CalibrationProblem, found: PoseFit) -> tuple[KindFit, ...]:
    """Return how well each kind of measurement fits, at its full weight; rejected rows do not count."""
    used, names = problem.of_poses(found.weights) > 0.0, kind_of(problem)
    residual = problem.derivatives(found.theta, found.poses).residual
    free = np.where(used, 1.0 - leverages(problem, found), 0.0)
    made = []
    for name in dict.fromkeys(names.tolist()):
        of = used & (names == name)
        total = float(free[of].sum())
        ratio = float(np.sqrt(np.sum(residual[of] ** 2) / total)) if total > 0.0 else np.nan
        made.append(KindFit(name, ratio * problem.factors.get(name, 1.0), total, int(of.sum())))
    return (*made, *_of_no_pose(problem, found))


def _of_no_pose(problem: CalibrationProblem, found: PoseFit) -> Iterator[KindFit]:
    """Yield how well what was measured of exit points fits: points, distances and their level."""
    measured = np.logical_not(problem.is_prior)
    if not measured.any():
        return
    rows = problem.derivatives(found.theta, found.poses, found.weights)
    covariance = information(problem, found.theta, found.poses, found.weights, priors=True).covariance
    taken = np.sum((rows.others_by_unknown @ covariance) * rows.others_by_unknown, axis=1)
    total = float((1.0 - taken[measured].clip(0.0, 1.0)).sum())
    if total > 0.0:
        ratio = float(np.sqrt(np.sum(rows.others[measured] ** 2) / total))
        yield KindFit(SURVEY, ratio * problem.factors.get(SURVEY, 1.0), total, int(measured.sum()))


def idle(problem: CalibrationProblem, found: PoseFit) -> Mask:
    """Return which rows (N, e) are measured coordinates that all other rows determine far better.

    None are if a degree of freedom would be undetermined without them.
    """
    vague = (kind_of(problem) == "positions") & (leverages(problem, found) < _CARRIES)
    vague &= problem.of_poses(problem.weights) > 0.0
    if vague.any():
        weights = found.weights.copy()
        problem.of_poses(weights)[vague] = 0.0
        before, after = (
            information(problem, found.theta, found.poses, each, priors=True) for each in (found.weights, weights)
        )
        if after.null.shape[1] > before.null.shape[1]:
            return np.zeros_like(vague)
    return np.asarray(vague)


def estimates_encoders(problem: CalibrationProblem) -> bool:
    """Return whether the encoders' sigma, which weights them against other rows, must be estimated from residuals."""
    return problem.plan.sigma.encoder is None and problem.has_other_sensors


def roughly_weighed(problem: CalibrationProblem, found: PoseFit) -> tuple[CalibrationProblem, PoseFit]:
    """Return problem and fit with unknown sigmas taken from the median of residuals, which a few errors cannot move.

    They are those of the encoders beside other sensors, and of kinds that the plan leaves at their default.
    """
    names = kind_of(problem)
    kinds = [name for name in dict.fromkeys(names.tolist()) if _is_open(problem, name)]
    if not problem.has_other_sensors or not kinds:
        return problem, found
    group = np.array([kinds.index(name) if name in kinds else -1 for name in names.tolist()])
    for _ in range(_ROUNDS):
        wanted = {}
        for at, ratio in _medians(problem, found, group).items():
            wanted[kinds[at]] = _bounded(problem, kinds[at], ratio * problem.factors.get(kinds[at], 1.0))
        if not wanted:
            break
        change = max(abs(np.log(factor / problem.factors.get(name, 1.0))) for name, factor in wanted.items())
        problem, found = _with_factors(problem, found, wanted)
        if change < _ROUGHLY:
            break
    return problem, found


def _is_open(problem: CalibrationProblem, name: str) -> bool:
    """Whether the sigma of a kind was not given."""
    told = problem.plan.sigma.model_fields_set
    if name == "lengths":
        return problem.plan.sigma.encoder is None
    return name in SIGMA_OF and SIGMA_OF[name] not in told


def _bounded(problem: CalibrationProblem, name: str, factor: float) -> float:
    """Return a factor on a sigma that was not given, such that data without noise are not taken for exact."""
    return max(factor, _EXACT / problem.encoder_sigma if name == "lengths" else _SMALLEST)


def weighed(problem: CalibrationProblem, found: PoseFit) -> tuple[CalibrationProblem, PoseFit]:
    """Return problem and fit with the sigma of each kind of measurement that its residuals support.

    A given sigma never falls, since residuals do not show common errors; it grows where residuals deny it. That of the
    encoders, if it was not given, and those that the plan leaves at their default fall too. A kind with too little
    redundancy keeps its sigma. Lengths alone need no weight.
    """
    if not problem.has_other_sensors and problem.plan.sigma.encoder is None:
        return problem, found
    for _ in range(_ROUNDS):
        wanted = {each.name: _wanted(problem, each) for each in kind_fits(problem, found)}
        change = max(abs(np.log(wanted[name] / problem.factors.get(name, 1.0))) for name in wanted)
        if change < _SAME:
            break
        problem, found = _with_factors(problem, found, wanted)
    return problem, found


def _wanted(problem: CalibrationProblem, fit: KindFit) -> float:
    """Return the factor on the given sigma of a kind that its residuals require."""
    now = problem.factors.get(fit.name, 1.0)
    if _is_open(problem, fit.name):
        return _bounded(problem, fit.name, fit.ratio) if fit.redundancy >= ENOUGH else now
    if fit.redundancy < _LEAST or not fit.ratio > 1.0:
        return 1.0
    if fit.redundancy >= ENOUGH and fit.ratio < _PLAINLY:
        return _averaged(fit.ratio**2, fit.redundancy)
    denied = bool(special.chdtrc(fit.redundancy, fit.ratio**2 * fit.redundancy) < _DENIED)
    return fit.ratio if denied or now > 1.0 else 1.0


def _averaged(square: float, redundancy: float) -> float:
    """Return the factor on a given sigma by residuals of a mean *square* over it, averaged over its possible values.

    The given sigma is right or too small, with even chances before the data, and too small by any factor: where a test
    keeps a sigma that is 1.4 times too small, as it does for one in six sets of 20 residuals, sigmas of the results
    would be too small as well.
    """
    evidence = -0.5 * redundancy * (_FACTORS + square * np.exp(-_FACTORS))
    share = np.exp(evidence - evidence.max()) * (_FACTORS[1] / _USUAL)
    share[0] += np.exp(evidence[0] - evidence.max())
    return float(np.exp(0.5 * (share @ _FACTORS) / share.sum()))


def _with_factors(
    problem: CalibrationProblem, found: PoseFit, wanted: Mapping[str, float]
) -> tuple[CalibrationProblem, PoseFit]:
    """Return problem and fit with given sigmas times *wanted*, by kind."""
    share = {name: factor / problem.factors.get(name, 1.0) for name, factor in wanted.items()}
    share[ON_ONE_DRUM] = share.get(ON_ONE_DRUM, 1.0) * share.get("lengths", 1.0)  # it is a share of the encoders' sigma
    by_row = np.array([share.get(name, 1.0) for name in kind_of(problem).tolist()])
    survey = share.get(SURVEY, 1.0)
    again, weights = _divided(problem.with_survey_weighed(1.0 / survey), found, by_row)
    for each in (again.weights, weights):
        each[problem.poses * problem.per_pose :] /= survey
    encoder = share.get("lengths", 1.0)
    sigma = problem.found_encoder if encoder == 1.0 else encoder * problem.encoder_sigma
    told = dict(wanted)
    if problem.plan.sigma.encoder is None:  # there is no sigma that it would be a factor on
        told.pop("lengths", None)
    again = replace(again, found_encoder=sigma, factors={**problem.factors, **told})
    return again, refit(again, found, weights)


def _divided(problem: CalibrationProblem, found: PoseFit, factor: Array) -> tuple[CalibrationProblem, Array]:
    """Return the problem, and the weights (R,) of a fit, with weights over *factor* (e,) or (N, e)."""
    weights, every = found.weights.copy(), problem.weights.copy()
    for each in (weights, every):
        problem.of_poses(each)[:] /= factor
    return replace(problem, weights=every), weights


def _medians(problem: CalibrationProblem, found: PoseFit, group: NDArray[np.int64]) -> dict[int, float]:
    """Return by *group* (e,) or (N, e) its sigma over that of its weights, from the median of its residuals.

    Groups below 0 and those with too little redundancy have none.
    """
    free = np.where(problem.of_poses(found.weights) > 0.0, 1.0 - leverages(problem, found), 0.0)
    size = np.abs(problem.derivatives(found.theta, found.poses, found.weights).residual)
    group, made = np.broadcast_to(group, free.shape), {}
    for each in np.unique(group[group >= 0]).tolist():
        of = (group == each) & (free > _TESTED)
        if free[of].sum() >= ENOUGH:
            made[each] = float(np.median(size[of] / np.sqrt(free[of]))) / _MEDIAN
    return made


def evened(problem: CalibrationProblem, found: PoseFit) -> tuple[CalibrationProblem, PoseFit]:
    """Return problem and fit with every kind's sigma from the median of its residuals, to compare rows.

    Positions given to a millimetre and those given to a metre are two kinds. A kind with too little redundancy keeps
    its sigma.
    """
    group, factor = _groups(problem), np.ones(problem.of_poses(problem.weights).shape)
    lengths = np.broadcast_to(kind_of(problem) == "lengths", factor.shape)
    smallest = np.where(lengths, _EXACT / problem.encoder_sigma, _SMALLEST)
    even = problem
    for _ in range(_EVENING):
        ratio = np.ones(factor.shape)
        for each, size in _medians(even, found, group).items():
            ratio[group == each] = size
        wanted = np.maximum(factor * ratio, smallest)
        if np.abs(np.log(wanted / factor)).max() < _ROUGHLY:
            break
        even, weights = _divided(even, found, wanted / factor)
        even = replace(even, found_encoder=float(wanted[0, 0]) * problem.encoder_sigma)
        factor, found = wanted, refit(even, found, weights)
    return even, found


def _groups(problem: CalibrationProblem) -> NDArray[np.int64]:
    """Return the group of each row (N, e): its kind, and for positions the power of ten of the given sigma."""
    names, weights = kind_of(problem), problem.of_poses(problem.weights)
    _, kinds = np.unique(names, return_inverse=True)
    group = np.broadcast_to(100 * kinds, weights.shape).copy()
    placed = (weights > 0.0) & (names == "positions")
    group[placed] += 50 + np.round(np.log10(weights[placed])).astype(np.int64).clip(-49, 49)
    return group


def resisting(problem: CalibrationProblem, found: PoseFit) -> PoseFit:
    """Return the fit in which a measured position, plane or range with a large residual has a smaller weight.

    Beyond 1.5 sigma the weight falls.
    """
    soft = np.array([KINDS[int(code)].resists for code in problem.rows.kind[: problem.per_pose]])
    if not soft.any():
        return found
    full = found.weights
    share = np.ones(problem.of_poses(full).shape)
    for _ in range(_ROUNDS):
        free = np.maximum(1.0 - leverages(problem, found), 1e-3)
        size = np.abs(problem.derivatives(found.theta, found.poses, full).residual) / np.sqrt(free)
        wanted = np.where(soft, np.sqrt(_HUBER / np.maximum(size, _HUBER)), 1.0)
        if np.abs(wanted - share).max() < _SAME:
            break
        share, weights = wanted, full.copy()
        problem.of_poses(weights)[:] *= share
        found = refit(problem, found, weights)
    return found
