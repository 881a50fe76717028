"""Which possible change explains a vector of numbers with a known covariance, and whether any is needed.

Every suspect is a change with an effect that is linear in a few amounts. Two tests share the level: all numbers
together (chi-square), and the best suspect alone (Bonferroni over the suspects). Suspects are then named one after the
other, by how much of the squares they explain less the share that as many amounts explain by chance (Schwarz 1978),
until the rest is noise; of one line the simplest that explains as much.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import special

from cablewright.foundation.arrays import Array
from cablewright.foundation.results import Figure
from cablewright.robot.parameters import KINDS_OF

READING: Final = "reading of the "
"""What begins the name of a reading that is wrong."""

SCALE: Final = "scale of all lengths"

_UNITS: Final = {
    **{name.replace("_", " "): kinds[0].unit for name, kinds in KINDS_OF.items()},
    SCALE: "1",
    f"{READING}tensions": "N",
    **{f"{READING}{angles}": "rad" for angles in ("swivel angles", "tilts", "yaw angles")},
}
_MAX_NAMED: Final = 4
_MORE: Final = 1e-3  # probability of the gain of more amounts by chance, under which they are required
_ALIKE: Final = 6.0  # difference of two scores under which a suspect is 20 times as likely as another, at most
_NULL: Final = 1e-6  # relative size of an effect that counts as none
_ZERO: Final = 1e-9  # relative size of a singular value that counts as zero
_POWER: Final = 0.9  # probability with which a change of the reported size is found


@dataclass(frozen=True, eq=False)
class Suspect:
    """A possible change: its kind, its line or row, and the effect (d, r) of its r amounts.

    ``among``: how many changes of its kind are possible.
    """

    what: str
    line: str | None
    effect: Array
    among: int = 1
    pose: int | None = None  # from 0
    of_alarm: bool = True  # whether it is tested by itself


@dataclass(frozen=True)
class DriftChange:
    """A detected change: its size (``amount`` is the length of ``vector``), and equally good explanations."""

    what: str
    line: str | None
    pose: int | None
    amount: float
    sigma: float
    vector: tuple[float, ...]
    instead: tuple[str, ...]

    @property
    def unit(self) -> str:
        """The SI unit of the change's amount."""
        return _UNITS.get(self.what, "m")

    @property
    def sentence(self) -> str:
        """The change with its alternatives in words."""
        whose = "" if self.line is None else f" of {self.line}"
        where = "" if self.pose is None else f" at pose {self.pose + 1}"
        size, unit = (1e3, "mm") if self.unit == "m" else (1.0, self.unit.removeprefix("1"))
        amount = f"{size * self.amount:+.3g} +- {size * self.sigma:.2g} {unit}".rstrip()
        instead = f" (or: {', '.join(self.instead)})" if self.instead else ""
        return f"{self.what}{whose}{where} by {amount}{instead}"


CHANGE_PARTS: Final = (
    Figure("what", "", "The change."),
    Figure("line", "", "Its line; null where it is of all."),
    Figure("pose", "1", "Pose of a wrong reading, from 1.", lambda of: None if of.pose is None else of.pose + 1),
    Figure("amount", "SI", "Its size: longer is positive; of an exit point the distance.", name="by", digits=3),
    Figure("sigma", "SI", "Standard deviation of that.", digits=2),
    Figure("unit", "", "Unit of both."),
    Figure("vector", "m", "Along x, y, z, for a point; then the length, if that changed too.",
           lambda of: of.vector if len(of.vector) > 1 else None, digits=3),
    Figure("instead", "", "Other changes that would explain it nearly as well, the best of each line.", name="or"),
)  # fmt: skip
"""The figures of a change."""


@dataclass(frozen=True)
class Explanation:
    """Probability of the numbers without a change, and the changes where it is below the level."""

    probability: float
    changes: tuple[DriftChange, ...]
    rest: float  # probability of the residual besides the changes, if they are all


class Evidence:
    """Numbers (d,) with a covariance (d, d), and the possible changes (suspects) that may explain them.

    *freedom*: degrees of freedom of the covariance's sigma; inf if sigma is known.
    """

    def __init__(self, numbers: Array, covariance: Array, suspects: Sequence[Suspect], freedom: float) -> None:
        whitening = np.linalg.inv(np.linalg.cholesky(covariance))
        self.suspects, self.freedom = tuple(suspects), freedom
        self.seen = whitening @ numbers
        self.effects = [whitening @ each.effect for each in suspects]

    def explained(self, level: float) -> Explanation:
        """Return the changes that explain the numbers, by tests whose rate of false alarms is *level*."""
        probability = self._probability([])
        named: list[int] = []
        rest = probability
        while rest < level and len(named) < _MAX_NAMED and self._left(named) > 0:
            best = self._scores(named)
            if not best:
                break
            named.append(self._simplest(named, max(best, key=best.__getitem__)))
            rest = self._probability(named)
        return Explanation(probability, tuple(self._changes(named)), rest)

    def alone(self, at: int) -> tuple[float, float]:
        """Return the change of one suspect number, if it alone changed, and its sigma; inf without evidence."""
        size = float(np.linalg.norm(self.effects[at]))
        if not size > 0.0:
            return 0.0, np.inf
        return float(self.effects[at][:, 0] @ self.seen) / size**2, 1.0 / size

    def detectable(self, at: int, level: float) -> float:
        """Return the amount of a suspect's change that the test detects in nine of ten cases."""
        tail = level / (4.0 * sum(each.of_alarm for each in self.suspects))
        limit = -special.stdtrit(self.freedom, tail) if np.isfinite(self.freedom) else -special.ndtri(tail)
        return float(limit + special.ndtri(_POWER)) * self.alone(at)[1]

    def _left(self, named: list[int]) -> int:
        return int(len(self.seen) - self._basis(named).shape[1])

    def _basis(self, named: list[int]) -> Array:
        """Return an orthonormal basis (d, r) of the space that the *named* suspects explain."""
        return _span(np.concatenate([np.zeros((len(self.seen), 0)), *(self.effects[at] for at in named)], axis=1))

    def _probability(self, named: list[int]) -> float:
        """Return the probability of the residual beside the *named* suspects by chance."""
        basis = self._basis(named)
        rest, free = self.seen - basis @ (basis.T @ self.seen), len(self.seen) - basis.shape[1]
        if free < 1:
            return 1.0
        least = self._chance(float(rest @ rest), free)
        tested = [each.of_alarm for each in self.suspects]
        for at, (square, rank) in self._explains(named).items():
            if tested[at]:
                least = min(least, sum(tested) * self._chance(square, rank))
        return min(1.0, 2.0 * least)

    def _chance(self, square: float, count: int) -> float:
        if not np.isfinite(self.freedom):
            return float(special.chdtrc(count, square))
        return float(special.fdtrc(count, self.freedom, square / count))

    def _explains(self, named: list[int]) -> dict[int, tuple[float, int]]:
        """Return the squares that each suspect explains beside the *named* ones, and by how many amounts."""
        basis, made = self._basis(named), {}
        for at, effect in enumerate(self.effects):
            size = np.linalg.norm(effect, axis=0).max(initial=0.0)
            own = _span(effect - basis @ (basis.T @ effect), _NULL * float(size))
            if at not in named and own.shape[1]:
                made[at] = (float(np.sum((own.T @ self.seen) ** 2)), own.shape[1])
        return made

    def _scores(self, named: list[int]) -> dict[int, float]:
        """Return the score of each suspect beside the *named* ones: twice the logarithm of how likely it is."""
        each_costs = np.log(max(self._left(named), 2))
        return {
            at: square - rank * each_costs - 2.0 * np.log(self.suspects[at].among)
            for at, (square, rank) in self._explains(named).items()
        }

    def _simplest(self, named: list[int], best: int) -> int:
        """Return what changed of the line that explains most: what has fewest amounts, unless more are significant."""
        explains = self._explains(named)
        square, rank = explains[best]
        own = [at for at in explains if (self.suspects[at].line, self.suspects[at].pose) == self._whose(best)]
        for at in sorted(own, key=lambda each: explains[each][1]):
            less, fewer = explains[at]
            if fewer < rank and square - less < special.chdtri(rank - fewer, _MORE):
                return at
        return best

    def _whose(self, at: int) -> tuple[str | None, int | None]:
        return self.suspects[at].line, self.suspects[at].pose

    def _changes(self, named: list[int]) -> Iterator[DriftChange]:
        if not named:
            return
        together = np.concatenate([self.effects[at] for at in named], axis=1)
        scale = np.linalg.norm(together, axis=0).clip(min=1e-300)
        inverse = np.linalg.pinv(together / scale, rcond=_NULL) / scale[:, None]
        amounts, covariance, place = inverse @ self.seen, inverse @ inverse.T, 0
        for count, at in enumerate(named):
            suspect, size = self.suspects[at], self.effects[at].shape[1]
            own = slice(place, place + size)
            place += size
            amount = float(np.linalg.norm(amounts[own]))
            along = amounts[own] / max(amount, 1e-300)
            sigma = float(np.sqrt(along @ covariance[own, own] @ along))
            others = tuple(self._instead(named[:count], at))
            signed = float(amounts[own][0]) if size == 1 else amount
            vector = tuple(float(each) for each in amounts[own])
            yield DriftChange(suspect.what, suspect.line, suspect.pose, signed, sigma, vector, others)

    def _instead(self, before: list[int], at: int) -> Iterator[str]:
        """Yield the other lines whose change would explain the numbers nearly as well."""
        scores, named = self._scores(before), set()
        for other, score in sorted(scores.items(), key=lambda each: -each[1]):
            whose = self._whose(other)
            wider = whose == self._whose(at) and self.suspects[at].what in self.suspects[other].what
            if wider or whose in named or score < scores[at] - _ALIKE:
                continue
            named.add(whose)
            yield _words(self.suspects[other])


def beside(columns: Array) -> Array:
    """Return an orthonormal basis (d, r) of the space orthogonal to all *columns* (d, c)."""
    left, values, _ = np.linalg.svd(columns, full_matrices=True)
    return np.asarray(left[:, int((values > _ZERO * values.max(initial=1e-300)).sum()) :])


def _words(suspect: Suspect) -> str:
    of_line = f"{suspect.what} of {suspect.line}" if suspect.line else suspect.what
    return of_line if suspect.pose is None else f"{of_line}, pose {suspect.pose + 1}"


def _span(columns: Array, floor: float = 0.0) -> Array:
    """Return an orthonormal basis (d, r) of *columns* (d, c); small singular values, and those under *floor*, are 0."""
    left, values, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(left[:, values > max(_NULL * values.max(initial=0.0), floor, 1e-300)])
