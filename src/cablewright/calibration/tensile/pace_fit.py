"""How much faster a cable creeps in warmer or damper air, from a creep test during which the climate changes.

Of given paces a test is linear in all else, so only activation energy and humidity exponent are searched, for the least
squares that the linear fit leaves (variable projection).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import count, product
from typing import Final

import numpy as np
from scipy.optimize import least_squares

from cablewright.calibration.tensile.recording import TensileTest
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.progress import Progress, silent
from cablewright.models.climate_and_creep import COLDEST, HOTTEST, ZERO_CELSIUS, by_temperature

_WARMER: Final = 2.0  # K, by which the temperature changes under load, at least
_DAMPER: Final = 0.05  # likewise, of relative humidity
_KELVIN: Final = 170.0  # from which temperatures are not in degrees Celsius
_LARGEST: Final = 30.0  # logarithm of a pace
_EVALUATIONS: Final = 100  # of a search at most; some 25 are usual
_ROUNDING: Final = 1e-9  # of the strain, below which residuals are noise
_STEP: Final = 1e-4  # of the size of an unknown, for derivatives


@dataclass(frozen=True)
class PaceUnknown:
    """An unknown of the effect of climate on creep: activation energy or humidity exponent.

    ``size``: its scale; in this scale ``starts``: start values of a search, and ``most``: largest absolute value.
    ``sure``: the largest sigma with which it is reported. Without creep, noise yields one with a larger sigma.
    """

    name: str
    size: float
    starts: tuple[float, ...]
    most: float
    sure: float


ENERGY: Final = PaceUnknown("activation_energy", 1e5, (0.0, 1.5), 6.0, 30e3)  # J/mol
EXPONENT: Final = PaceUnknown("humidity_exponent", 1.0, (-6.0, 0.0, 6.0), 20.0, 1.0)


@dataclass(frozen=True, eq=False)
class ClimateOfTest:
    """The climate of a test under load, and its p columns of the logarithm of the pace.

    ``temperature`` (degrees Celsius) and ``humidity``: means under load, at which the pace is 1; None: not known.
    """

    unknowns: tuple[PaceUnknown, ...]
    logarithms: Array  # (k, p)
    temperature: float | None
    humidity: float | None

    def paces(self, found: Array) -> Array:
        """Return the factors (k,) on the creep rate for unknowns *found* (p,)."""
        return np.asarray(np.exp(np.clip(self.logarithms @ found, -_LARGEST, _LARGEST)))

    def choices(self) -> Iterator[ClimateOfTest]:
        """Yield variants of the climate to fit: with all of its unknowns, with each of several alone, and with none."""
        yield self
        p = len(self.unknowns)
        for kept in ([j] for j in range(p) if p > 1):
            yield self._with(kept)
        if p:
            yield self._with([])

    def _with(self, kept: list[int]) -> ClimateOfTest:
        unknowns = tuple(self.unknowns[j] for j in kept)
        return ClimateOfTest(unknowns, self.logarithms[:, kept], self.temperature, self.humidity)


def climate_of(test: TensileTest, under: Mask) -> ClimateOfTest:
    """Return the climate of a *test* that is *under* load (k,) at some samples."""
    heat, damp = _celsius(test), test.humidity
    mild = None if heat is None else round(float(heat[under].mean()), 1)
    mean = None if damp is None else round(float(damp[under].mean()), 2)
    unknowns, columns = [], [np.zeros((len(test.force), 0))]
    if heat is not None and mild is not None and np.ptp(heat[under]) >= _WARMER:
        unknowns.append(ENERGY)
        columns.append(by_temperature(heat, mild)[:, None])
    if damp is not None and mean is not None and np.ptp(damp[under]) >= _DAMPER:
        unknowns.append(EXPONENT)
        columns.append((damp - mean)[:, None])
    return ClimateOfTest(tuple(unknowns), np.hstack(columns), mild, mean)


def _celsius(test: TensileTest) -> Array | None:
    """Temperatures (k,), degrees Celsius; None where there are none, or in neither of two scales."""
    if test.temperature is None:
        return None
    heat = test.temperature - (ZERO_CELSIUS if test.temperature.min() >= _KELVIN else 0.0)
    return heat if heat.min() >= COLDEST and heat.max() <= HOTTEST else None


def pace_notes(
    test: TensileTest, whole: ClimateOfTest, told: ClimateOfTest, found: Array, sigmas: Array
) -> Iterator[str]:
    """Yield notes on effects of climate that a *test* might determine, and on *found* values that may be noise.

    *whole*: all unknowns; *told*: those that are reported; *found* (p,), with *sigmas* (p,).
    """
    for each, size, sigma in zip(told.unknowns, found, sigmas, strict=True):
        if each is ENERGY and size < -3.0 * sigma:
            yield "the activation energy is below 0: no cable creeps more slowly when warmer; check the temperatures"
    for each in whole.unknowns:
        if each not in told.unknowns:
            yield (
                f"the climate changes, but the test does not determine the {each.name.replace('_', ' ')} to "
                f"{each.sure:g}"
            )
    if whole.temperature is None and test.temperature is not None:
        low, high = test.temperature.min(), test.temperature.max()
        yield f"temperatures from {low:g} to {high:g} are neither in K nor in degrees Celsius: no activation energy"


def search(
    climate: ClimateOfTest, columns_of: Callable[[Array], Array], strain: Array, progress: Progress = silent
) -> Array | None:
    """Return the climate unknowns (p,) by least squares of a *strain* (k,); None where the search fails.

    *columns_of* paces (k,): columns in which the strain is linear, (k, j).
    """
    asked, calls = climate.unknowns, count(1)
    if not asked:
        return np.zeros(0)
    sizes, most = np.array([each.size for each in asked]), np.array([each.most for each in asked])

    def left(scaled: Array) -> Array:
        progress("fits of the pace, max", next(calls), _EVALUATIONS)
        columns = columns_of(climate.paces(sizes * scaled))
        columns = columns / np.maximum(np.linalg.norm(columns, axis=0), np.finfo(np.float64).tiny)
        return np.asarray(strain - columns @ np.linalg.lstsq(columns, strain, rcond=None)[0])

    starts = [np.array(each) for each in product(*(each.starts for each in asked))]
    norms = [float(np.linalg.norm(left(start))) for start in starts]
    begin, known = starts[int(np.argmin(norms))], max(min(norms), _ROUNDING * float(np.linalg.norm(strain)))
    steps = (_EVALUATIONS - len(starts)) // (1 + 2 * len(asked)) - 1

    def residuals(scaled: Array) -> Array:
        return left(scaled) / known

    found = least_squares(
        residuals,
        begin,
        lambda scaled: _differences(residuals, scaled, np.ones(len(asked))),
        bounds=(-most, most),
        max_nfev=steps,
    )
    told = np.linalg.norm(found.jac, axis=0) * np.sqrt(len(strain)) * [each.sure / each.size for each in asked] > 1.0
    if found.status <= 0 or found.active_mask.any() or not told.all():
        return None
    return np.asarray(sizes * found.x)


def derivatives(climate: ClimateOfTest, found: Array, strain_of: Callable[[Array], Array]) -> Array:
    """Return the derivatives (k, p) of a strain of paces (k,) by the unknowns *found* (p,)."""
    sizes = np.array([each.size for each in climate.unknowns])
    return _differences(lambda unknowns: strain_of(climate.paces(unknowns)), found, sizes)


def _differences(function: Callable[[Array], Array], at: Array, sizes: Array) -> Array:
    """Derivatives (k, p) of a *function* of p numbers *at* (p,), by central differences: steps are as their *sizes*."""
    steps = np.diag(_STEP * sizes)
    return np.column_stack([(function(at + step) - function(at - step)) / (2.0 * step.max()) for step in steps])
