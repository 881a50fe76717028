"""Creep of cables: Voigt elements and logarithmic creep, with memory of the load.

A constant load T from time 0 on makes a strain of T times the sum of compliances c_j times r_j(t), and several loads
the sum of their strains (Boltzmann). Each response r_j is 1 after an hour: r = (1 - exp(-t / tau)) / (1 - exp(-1 h /
tau)) of a Voigt element, r = log(1 + t / t0) / log(1 + 1 h / t0) of logarithmic creep. Spring and two Voigt elements:
Piao et al. 2017, doi 10.1177/1687814017737199; that creep goes on for hours: Choi and Park 2018, doi
10.1007/s00542-018-3820-7.

The logarithm is itself a sum of Voigt elements, ``log(1 + a) = integral of (1 - exp(-a exp(v))) exp(-exp(v)) dv``, by
the trapezium rule: within 0.1 % from a hundredth of a second to eleven days. So all of the memory is the strain of each
element, which is advanced exactly for a load that changes linearly. Where the pace of creep depends on the climate
(`models.climate_and_creep`) these times are those that creep counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.linalg import solve_banded

from cablewright.foundation.arrays import Array
from cablewright.models.climate_and_creep import Air, CreepPace
from cablewright.robot.cable import Creep

HOUR: Final = 3600.0  # s
RETARDATIONS: Final = (60.0, 1200.0)  # s, assumed
LOG_BEGIN: Final = 1.0  # s, assumed: t0
VOIGT_SHARES: Final = (0.2, 0.2)  # assumed: of the strain after an hour, by the elements of `RETARDATIONS`
LOG_SHARE: Final = 0.6
_GRID: Final = np.arange(-19.0, 3.5, 1.0)  # of v
_SMALL: Final = 1e-4  # steps per retardation time, below which series are more exact


def voigt_response(times: Array, retardation: float) -> Array:
    """Return a Voigt element's response at *times* (k,), s, after loading, relative to that after an hour."""
    return np.asarray(np.expm1(-times / retardation) / np.expm1(-HOUR / retardation))


def log_response(times: Array) -> Array:
    """Return the response of logarithmic creep at *times* (k,), s, after loading, relative to that after an hour."""
    return np.asarray(np.log1p(times / LOG_BEGIN) / np.log1p(HOUR / LOG_BEGIN))


def log_elements() -> tuple[Array, Array]:
    """Return retardation times (k,), s, of logarithmic creep, and final strains relative to those after an hour."""
    spread = np.exp(-np.exp(_GRID)) / np.log1p(HOUR / LOG_BEGIN) * (_GRID[1] - _GRID[0])
    return LOG_BEGIN * np.exp(-_GRID), spread


def voigt_size(retardation: float) -> float:
    """Return the final strain of a Voigt element relative to that after an hour."""
    return float(1.0 / -np.expm1(-HOUR / retardation))


def usual_creep(compliance: float) -> Creep:
    """Return the assumed creep law of a cable, scaled to a given strain per tension after an hour, 1/N."""
    return Creep.model_construct(
        retardations=RETARDATIONS,
        compliances=tuple(share * compliance for share in VOIGT_SHARES),
        logarithmic=LOG_SHARE * compliance,
    )


def scaled_creep(law: Creep, factor: float) -> Creep:
    """Return a creep *law* scaled by a factor, even beyond the range of a robot file."""
    sizes = {"compliances": tuple(factor * each for each in law.compliances), "logarithmic": factor * law.logarithmic}
    return law.model_copy(update=sizes)


def hour_compliance(law: Creep | None) -> float:
    """Return the creep strain per tension, 1/N, after an hour of load; 0 without a *law*."""
    return 0.0 if law is None else sum(law.compliances) + law.logarithmic


def gains(steps: Array) -> tuple[Array, Array]:
    """Return the strain of an element after *steps* (k,) retardation times, under a constant and under a rising load.

    1 - exp(-x) for a load of 1, and 1 - (1 - exp(-x)) / x, by a load from 0 to 1.
    """
    gone = -np.expm1(-steps)
    series = steps * (0.5 - steps * (1.0 / 6.0 - steps / 24.0))
    return gone, np.where(steps < _SMALL, series, 1.0 - gone / np.maximum(steps, _SMALL))


class CreepMemory:
    """Strains of the creep elements of m lines, each with its own history of loads."""

    SAVED = ("stretched",)

    def __init__(self, times: Array, sizes: Array, pace: CreepPace | None = None) -> None:
        """*times* (k,), s, of retardation; *sizes* (m, k), 1/N, at the end of all time; none has crept yet.

        *pace*: pace of the lines' creep, if it depends on the climate; until `feel` is called it is that at the laws'
        reference climate.
        """
        self._times, self._sizes = times, sizes
        self.stretched = np.zeros_like(sizes)  # strain of each element
        self._law, self._pace = pace, np.ones(1)
        self._step = (0.0, np.zeros(0), np.zeros(0))

    @property
    def strain(self) -> Array:
        """Strain of each line by creep until now, (m,)."""
        return np.asarray(self.stretched.sum(axis=1))

    def feel(self, air: Air) -> None:
        """Continue the creep of cables in another climate (*air*)."""
        if self._law is not None:
            self._pace = self._law.at(air)
            self._step = (0.0, np.zeros(0), np.zeros(0))

    def advance(self, before: Array, after: Array, period: float) -> None:
        """Advance creep by a *period*, s, in which loads change linearly from *before* to *after* (m,), N."""
        if period != self._step[0]:
            self._step = (period, *gains(self._steps(period)))
        _, gone, late = self._step
        load = gone * before[:, None] + late * (after - before)[:, None]
        self.stretched += self._sizes * load - gone * self.stretched

    def gain(self, loads: Array, period: float) -> Array:
        """Return the strain (m,) that creep adds in a *period*, s, under constant *loads* (m,), N."""
        gone = -np.expm1(-self._steps(period))
        return np.asarray((gone * (self._sizes * loads[:, None] - self.stretched)).sum(axis=1))

    def _steps(self, period: float) -> Array:
        """Retardation times (m or 1, k) that creep counts in a *period*, s."""
        return np.asarray(period * self._pace[:, None] / self._times)


def memory_of(laws: Sequence[Creep | None]) -> CreepMemory | None:
    """Return the creep memory of lines whose cables follow these *laws*; None where none creeps."""
    if not any(law is not None for law in laws):
        return None
    taus = sorted({tau for law in laws if law is not None for tau in law.retardations})
    log_times, log_sizes = log_elements()
    sizes = np.zeros((len(laws), len(taus) + len(log_times)))
    for row, law in zip(sizes, laws, strict=True):
        if law is not None:
            for tau, compliance in zip(law.retardations, law.compliances, strict=True):
                row[taus.index(tau)] = compliance * voigt_size(tau)
            row[len(taus) :] = law.logarithmic * log_sizes
    pace = CreepPace(laws)
    return CreepMemory(np.concatenate([taus, log_times]), sizes, pace if pace.varies else None)


def histories(times: Array, loads: Array, retardations: Sequence[float], paces: Array | None = None) -> Array:
    """Return creep strains (k, j + 1), per compliance, at *times* (k,), s, under varying *loads* (k,), N.

    A column for each of the j *retardations*, s, the last one for logarithmic creep. Loads change linearly between the
    times, which rise; before the first there is none, and it is full from the first on. *paces* (k,): at the times,
    in between their means; None: 1.
    """
    log_times, log_sizes = log_elements()
    passed = np.diff(times) if paces is None else np.diff(times) * 0.5 * (paces[1:] + paces[:-1])
    driven, out = np.zeros(len(times)), np.empty((len(times), len(retardations) + 1))
    logarithm = np.zeros(len(times))
    bands = np.ones((2, len(times)))
    for j, tau in enumerate([*retardations, *log_times.tolist()]):
        gone, late = gains(passed / tau)
        driven[1:] = gone * loads[:-1] + late * np.diff(loads)
        bands[1, :-1] = gone - 1.0  # remainder of a strain, a step later
        strain = solve_banded((1, 0), bands, driven)
        if j < len(retardations):
            out[:, j] = strain * voigt_size(tau)
        else:
            logarithm += strain * log_sizes[j - len(retardations)]
    out[:, -1] = logarithm
    return out
