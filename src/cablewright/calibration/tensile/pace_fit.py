"""How much faster a cable creeps in a warmer or damper climate, by a creep test in which the climate changes.

Of given paces a test is linear in all else, so only activation energy and humidity exponent are searched, for the least
squares that the linear fit leaves (variable projection).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import count
from typing import Final

import numpy as np
from scipy.optimize import least_squares

from cablewright.arrays import Array, Mask
from cablewright.calibration.tensile.recording import TensileTest
from cablewright.models.creep_pace import ZERO_CELSIUS, by_temperature
from cablewright.progress import Progress, silent

_WARMER: Final = 5.0  # K, by which the temperature changes under load, at least
_DAMPER: Final = 0.1  # likewise, of relative humidity
_KELVIN: Final = 170.0  # from which a temperature is not in degrees Celsius
_LARGEST: Final = 30.0  # logarithm of a pace
_TINY: Final = np.finfo(np.float64).tiny
_STEP: Final = 1e-4  # of the size of an unknown, for derivatives


@dataclass(frozen=True)
class _Unknown:
    """``size`` of its scale; over it, ``most`` on both sides of 0, and the ``largest`` sigma of one that is told.

    Of a cable that does not creep, noise tells one with a larger sigma.
    """

    name: str
    size: float
    most: float
    largest: float


_ENERGY: Final = _Unknown("activation_energy", 1e5, 6.0, 0.3)  # J/mol
_EXPONENT: Final = _Unknown("humidity_exponent", 1.0, 20.0, 1.0)
_STARTS: Final = (0.0, 0.5, 1.0, 1.5, 2.0)  # of the search, of the activation energy over its size
_EVALUATIONS: Final = 80  # of the search at most; some 20 are usual


@dataclass(frozen=True, eq=False)
class ClimateOfTest:
    """The climate of a test under load, and logarithms of the pace per activation energy and humidity exponent.

    Of these only what changed enough: ``has_energy``, ``has_exponent``. ``temperature`` (degrees Celsius) and
    ``humidity``: means under load, at which the pace is 1; None: not recorded.
    """

    logarithms: Array  # (k, 0 to 2)
    has_energy: bool
    has_exponent: bool
    temperature: float | None
    humidity: float | None
    told: bool = True  # False: the climate changes, but creep does not tell its pace

    @classmethod
    def of(cls, test: TensileTest, under: Mask) -> ClimateOfTest:
        """Of a *test* that is *under* load (k,) at some samples."""
        columns: list[Array] = []
        heat = mild = None
        if test.temperature is not None:
            heat = test.temperature - (ZERO_CELSIUS if test.temperature.min() >= _KELVIN else 0.0)
            mild = round(float(heat[under].mean()), 1)
        has_energy = heat is not None and float(np.ptp(heat[under])) >= _WARMER
        if heat is not None and mild is not None and has_energy:
            columns.append(by_temperature(heat, mild))
        damp = None if test.humidity is None else round(float(test.humidity[under].mean()), 2)
        has_exponent = test.humidity is not None and float(np.ptp(test.humidity[under])) >= _DAMPER
        if test.humidity is not None and damp is not None and has_exponent:
            columns.append(test.humidity - damp)
        logarithms = np.column_stack(columns) if columns else np.zeros((len(test.force), 0))
        return cls(logarithms, has_energy, has_exponent, mild, damp)

    def untold(self) -> ClimateOfTest:
        """Return it for a cable of whose pace nothing is to be known."""
        return replace(self, logarithms=self.logarithms[:, :0], has_energy=False, has_exponent=False, told=False)

    @property
    def unknowns(self) -> list[_Unknown]:
        """Activation energy and humidity exponent, or those of them that are asked."""
        return [_ENERGY] * self.has_energy + [_EXPONENT] * self.has_exponent

    def paces(self, found: Array) -> Array:
        """Return the paces (k,) for unknowns *found*."""
        return np.asarray(np.exp(np.clip(self.logarithms @ found, -_LARGEST, _LARGEST)))


def search(
    climate: ClimateOfTest, columns_of: Callable[[Array], Array], strain: Array, progress: Progress = silent
) -> tuple[ClimateOfTest, Array]:
    """Return the climate, untold where creep shows none of it, and its unknowns by least squares of a *strain* (k,).

    *columns_of* paces (k,): what the strain is linear in, (k, j).
    """
    asked = climate.unknowns
    if not asked:
        return climate, np.zeros(0)
    sizes, most = np.array([each.size for each in asked]), np.array([each.most for each in asked])

    calls = count(1)

    def left(scaled: Array) -> Array:
        progress("fits of the pace, max", next(calls), _EVALUATIONS)
        columns = columns_of(climate.paces(sizes * scaled))
        columns = columns / np.maximum(np.linalg.norm(columns, axis=0), _TINY)
        return np.asarray(strain - columns @ np.linalg.lstsq(columns, strain, rcond=None)[0])

    starts = [np.array([start, 0.0][: len(asked)]) for start in (_STARTS if climate.has_energy else (0.0,))]
    begin = min(starts, key=lambda start: float(np.sum(left(start) ** 2)))
    scale = 1.0 / max(float(np.linalg.norm(left(begin))), _TINY)  # tolerances are of numbers near 1
    most_calls = (_EVALUATIONS - len(starts)) // (1 + len(asked)) - 1
    found = least_squares(
        lambda scaled: scale * left(scaled), begin, bounds=(-most, most), diff_step=_STEP, max_nfev=most_calls
    )
    variance = 2.0 * found.cost / len(strain)
    information = found.jac.T @ found.jac - variance * np.diag([each.largest**-2 for each in asked])
    if found.active_mask.any() or not np.linalg.eigvalsh(information)[0] > 0.0:
        return climate.untold(), np.zeros(0)
    return climate, np.asarray(sizes * found.x)


def derivatives(climate: ClimateOfTest, found: Array, strain_of: Callable[[Array], Array]) -> Array:
    """Return the derivatives (k, p) of a strain of paces (k,) by the unknowns *found* (p,)."""
    steps = np.diag([_STEP * each.size for each in climate.unknowns])
    sides = [(strain_of(climate.paces(found + step)), strain_of(climate.paces(found - step))) for step in steps]
    return np.column_stack([(up - down) / (2.0 * step.max()) for (up, down), step in zip(sides, steps, strict=True)])
