"""Sizes of creep, softness and mounts: averaged over machines of any severity where the owner states none.

Each of these laws has the size that the filter assumes, or is several times as large, with chances before any
measurement. The filter runs with the assumed sizes. What its data show of the laws follows from its covariance and the
prior, and from that its estimate with other sizes and their probability (Bayes; multiple models, Magill 1965). The
covariance of the laws is an average over all sizes: wide until data show which size it is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from typing import Final, NamedTuple

import numpy as np

from cablewright.estimation.body.settings import BodySettings
from cablewright.foundation.arrays import Array
from cablewright.models.creep import hour_compliance

_LARGEST: Final = (5.0, 2.5, 10.0)  # of creep, softness, mounts: the severity `rough` over the assumed `typical`
_CHANCES: Final = (0.2, 0.2, 0.6)  # of the assumed size, one between, the largest. **Tuned** on seeds 90010 to 90015
_STATED: Final = 4.0  # largest factor on a size that is stated ...
_RIGHT: Final = (0.998, 0.001, 0.001)  # ... and chances of it: assumed
_SAME_ESTIMATE: Final = 0.1  # sigmas, of a change of the estimate for which the average ...
_SAME_VARIANCE: Final = 0.03  # ... and a share of a variance for which it is taken as before
_LEAST: Final = 1e-12  # of a variance, over that before any measurement


@dataclass(frozen=True)
class LawSize:
    """Possible sizes of a law, as factors on the assumed size, with the prior probability of each."""

    factors: tuple[float, ...]
    chances: tuple[float, ...]


def law_sizes(settings: BodySettings) -> tuple[LawSize, LawSize, LawSize]:
    """Return the possible sizes of creep, softness and mounts.

    A law that neither the owner's standard deviations nor the robot file describe is more likely large than not.
    """
    told, robot = settings.deviations, settings.model.robot
    creeps = all(line.cable.creep is not None and hour_compliance(line.cable.creep) > 0.0 for line in robot.lines)
    gives = bool((settings.model.lines.mount[:, 0] > 0.0).all())
    known = told.creep is not None or creeps, told.hysteresis is not None, told.exit_compliance is not None or gives
    found = [
        _size(_STATED, _RIGHT) if each else _size(most, _CHANCES) for each, most in zip(known, _LARGEST, strict=True)
    ]
    return found[0], found[1], found[2]


def _size(most: float, chances: tuple[float, ...]) -> LawSize:
    return LawSize((1.0, math.sqrt(most), most), chances)


class Averaged(NamedTuple):
    """The k unknowns of the laws, averaged over sizes."""

    shown: Array  # (k, k) covariance before any measurement, less that which is left
    squares: Array  # (3,) mean of the squared factors of the laws
    wider: Array  # (k, k) moment about the estimate less covariance, between two inverses of the covariance


class AveragedAt(NamedTuple):
    """An average, with the estimate (k,) and the variances (k,) for which it was computed."""

    estimate: Array
    variances: Array
    found: Averaged

    def holds(self, estimate: Array, variances: Array) -> bool:
        """Return whether the average may be used for another estimate: little has changed."""
        near = np.square(estimate - self.estimate) <= _SAME_ESTIMATE**2 * self.variances
        return bool((near & (np.abs(variances - self.variances) <= _SAME_VARIANCE * self.variances)).all())


def averaged(estimate: Array, covariance: Array, untold: Array, sizes: tuple[LawSize, ...]) -> Averaged:
    """Return the average over all *sizes* of the laws, of equally many unknowns each.

    *estimate* (k,), *covariance* (k, k): by the filter from its prior *untold* (k, k), without correlations of laws.
    """
    k, count = len(estimate), len(sizes)
    root = np.linalg.cholesky(untold)
    inverse = np.linalg.inv(root)  # in units of the prior from here on
    values, ways = np.linalg.eigh(inverse @ covariance @ inverse.T)
    values = values.clip(_LEAST, 1.0)
    own, precise = inverse @ estimate, (ways / values) @ ways.T
    chosen = list(product(*(zip(size.factors, size.chances, strict=True) for size in sizes)))
    factors = np.array([np.repeat([factor for factor, _ in each], k // count) for each in chosen])
    chances = [math.prod(chance for _, chance in each) for each in chosen]
    inner = np.eye(k) + factors[:, :, None] * (precise - np.eye(k)) * factors[:, None, :]
    spreads = factors[:, :, None] * np.linalg.inv(inner) * factors[:, None, :]
    pull = precise @ own
    found = spreads @ pull
    logs = np.log(chances) + 0.5 * (found @ pull - np.linalg.slogdet(inner)[1])
    weights = np.exp(logs - logs.max())
    weights /= weights.sum()
    left, off = np.einsum("s,sij->ij", weights, spreads), found - own
    moment = left + (weights * off.T) @ off
    wider = inverse.T @ precise @ (moment - (ways * values) @ ways.T) @ precise @ inverse
    squares = weights @ np.square(factors)
    shown = (root * squares) @ root.T - root @ left @ root.T
    return Averaged(shown, squares[:: k // count], wider)
