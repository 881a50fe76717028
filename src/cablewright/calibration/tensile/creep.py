"""Creep of a cable from a tensile test in which a load is held, or changes, over some decades of time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import ClassVar, Final, NamedTuple

import numpy as np

from cablewright.calibration.tensile.modulus import require_cable
from cablewright.calibration.tensile.pace_fit import ClimateOfTest, climate_of, derivatives, pace_notes, search
from cablewright.calibration.tensile.recording import TensileTest, read_test
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress, silent
from cablewright.foundation.results import Figure, Pictured
from cablewright.models.creep import HOUR, LOG_BEGIN, RETARDATIONS, histories, log_response, voigt_response
from cablewright.robot.cable import MAX_RETARDATIONS

_TIMES: Final = (60.0, 600.0, HOUR, 10.0 * HOUR, 24.0 * HOUR, 240.0 * HOUR)  # s, of the table as far as the test lasts
_COVERAGE: Final = 2.0  # sigmas to the upper end of a range

FIGURES = (
    Figure("status", "", "ok.", lambda _: "ok"),
    Figure("stiffness", "N", "EA by the quick part of the stretch.", name="axial stiffness EA", shown="kN"),
    Figure("stiffness_sigma", "N", "Standard deviation of EA.", name="its sigma", shown="kN", digits=2),
    Figure(
        "expansion", "1/K", "Thermal expansion; absent without a sufficient change of temperature.",
        only=lambda own: own.expansion is not None,
    ),
    Figure(
        "activation_energy", "J/mol", "Activation energy of the creep rate; absent if the test does not determine it.",
        only=lambda own: own.activation_energy is not None, shown="kJ/mol", digits=3,
    ),
    Figure(
        "activation_energy_sigma", "J/mol", "Standard deviation of the activation energy.", name="sigma of the energy",
        only=lambda own: own.activation_energy is not None, shown="kJ/mol", digits=2,
    ),
    Figure(
        "humidity_exponent", "1", "Logarithm of how much faster it creeps per relative humidity of 1; likewise.",
        only=lambda own: own.humidity_exponent is not None, digits=3,
    ),
    Figure(
        "humidity_exponent_sigma", "1", "Standard deviation of the humidity exponent.", name="sigma of the exponent",
        only=lambda own: own.humidity_exponent is not None, digits=2,
    ),
    Figure(
        "temperature", "°C", "Mean under load, reference of the creep law; absent if not recorded.",
        only=lambda own: own.temperature is not None, shown="°C", digits=3,
    ),
    Figure(
        "humidity", "1", "Likewise, relative.", only=lambda own: own.humidity is not None, shown="%", digits=2,
    ),
    Figure("loaded", "s", "How long the specimen was under load.", digits=3),
    Figure(
        "creep", "", "Creep after a time under a constant load.", lambda own: own.table,
        parts=(
            Figure("time", "s", "Since the load began.", digits=3, shown="min"),
            Figure("compliance", "1/N", "Strain per load, besides the elastic one.", shown="1/N"),
            Figure("sigma", "1/N", "Standard deviation of the compliance.", digits=2, shown="1/N"),
            Figure("over_elastic", "1", "Creep over the elastic stretch of the same load.", shown="%", digits=3),
        ),
    ),
    Figure(
        "parts", "", "What each part of the law creeps by in an hour.", lambda own: own.law, name="law of creep",
        parts=(
            Figure("part", "", "A Voigt element with its retardation time, or logarithmic creep."),
            Figure("compliance", "1/N", "Strain per load after an hour.", shown="1/N"),
            Figure("sigma", "1/N", "Standard deviation of the compliance.", digits=2, shown="1/N"),
        ),
    ),
    Figure("noise", "m", "Root mean square of the residual of the elongation.", digits=2),
    Figure("widened", "1", "By how much correlated residuals widen the variances.", digits=3),
    Figure("robot_file", "", "What a robot file has of this creep.", "robot_file_text", name="for the robot file"),
    Figure("uncertainty_file", "", "Creep from 0 to that at the end of the test, for an uncertainty file.",
           "uncertainty_text", name="for an uncertainty file"),
    Figure("notes", "", "What a careful person would ask.", detail=True),
)  # fmt: skip
MAX_SAMPLES: Final = 100_000
_LOADED: Final = 0.5  # of the largest change of force, from which on a specimen counts as under load
_PER_RETARDATION: Final = 3.0  # samples in a retardation time, at the beginning of the load
_DECADES: Final = 100.0  # times the start, for which logarithmic creep must be seen
_ALIKE: Final = 1e10  # condition number of the columns from which on they are indistinguishable
_VARIES: Final = 0.5  # K: smaller changes of temperature do not determine the expansion
_WANDERS: Final = 5.0  # widening of the variances, from which a note says that the law does not fit
_BELOW_ZERO: Final = -3.0  # sigmas


@dataclass(frozen=True, eq=False, repr=False)
class CreepResult(Pictured):
    """The result of `creep`: stiffness of a cable, and its creep by time, with standard deviations.

    ``compliances`` (j + 1,), 1/N: after an hour, of the Voigt elements with their ``retardations`` and of logarithmic
    creep, at the mean ``temperature`` (degrees Celsius) and ``humidity`` (relative) under load; None: not recorded.
    ``covariance``: covariance of 1 / EA (1/N), the compliances, the strain at the first sample, and those of expansion,
    activation energy and humidity exponent that are reported. ``residuals`` (k,): strains that the law leaves.
    """

    FIGURES: ClassVar = FIGURES
    HEADLINES: ClassVar = ("stiffness", "loaded", "noise")
    PASTED: ClassVar = ("for the robot file", "for an uncertainty file")

    test: TensileTest
    initial_length: float  # m
    retardations: tuple[float, ...]  # s
    elastic: float  # 1/N: 1 / EA
    compliances: Array
    expansion: float | None  # 1/K
    activation_energy: float | None  # J/mol
    humidity_exponent: float | None
    temperature: float | None
    humidity: float | None
    covariance: Array
    offset: float  # strain at the first sample
    residuals: Array
    widened: float
    loaded: float  # s
    notes: tuple[str, ...]

    @property
    def stiffness(self) -> float:
        """Axial stiffness EA, N."""
        return 1.0 / self.elastic

    @property
    def stiffness_sigma(self) -> float:
        """Standard deviation of EA, N."""
        return math.sqrt(self.covariance[0, 0]) / self.elastic**2

    @property
    def activation_energy_sigma(self) -> float | None:
        """Standard deviation of the activation energy, J/mol, where that is reported."""
        last = -1 if self.humidity_exponent is None else -2
        return None if self.activation_energy is None else math.sqrt(self.covariance.diagonal()[last])

    @property
    def humidity_exponent_sigma(self) -> float | None:
        """Standard deviation of the exponent by which humidity accelerates creep; None if it is not estimated."""
        return None if self.humidity_exponent is None else math.sqrt(self.covariance.diagonal()[-1])

    @property
    def noise(self) -> float:
        """Root mean square of the residuals, m of elongation."""
        return float(np.sqrt(np.mean(self.residuals**2))) * self.initial_length

    def compliance_at(self, time: float) -> tuple[float, float]:
        """Return the creep strain per load, 1/N, at *time* (s) after loading, and its standard deviation."""
        at = np.array([time])
        responses = np.concatenate([*(voigt_response(at, tau) for tau in self.retardations), log_response(at)])
        own = slice(1, 1 + len(responses))
        variance = float(responses @ self.covariance[own, own] @ responses)
        return float(responses @ self.compliances), math.sqrt(max(variance, 0.0))

    @property
    def after_hour(self) -> float:
        """Creep strain per load after an hour, 1/N; extrapolated for a shorter test."""
        return self.compliance_at(HOUR)[0]

    @property
    def table(self) -> list[dict[str, float]]:
        """Table of creep by time, up to the time that the specimen was under load."""
        rows = []
        for time in (*(each for each in _TIMES if each < self.loaded), self.loaded):
            size, sigma = self.compliance_at(time)
            rows.append({"time": time, "compliance": size, "sigma": sigma, "over_elastic": size / self.elastic})
        return rows

    @property
    def law(self) -> list[dict[str, float | str]]:
        """Table of the parts of the creep law, each with its compliance after an hour."""
        names = [*(f"element of {tau:g} s" for tau in self.retardations), "logarithmic"]
        sigmas = np.sqrt(np.diagonal(self.covariance))[1:]
        found = zip(names, self.compliances.tolist(), sigmas.tolist(), strict=False)
        return [{"part": name, "compliance": size, "sigma": sigma} for name, size, sigma in found]

    @property
    def robot_file_text(self) -> str:
        """The `[cable.creep]` of a robot file; non-physical negative values are set to 0."""
        sizes = [f"{max(each, 0.0):.4g}" for each in self.compliances.tolist()]
        times = ", ".join(f"{tau:g}" for tau in self.retardations)
        elements = f"retardations = [{times}]\ncompliances = [{', '.join(sizes[:-1])}]"
        text = f"[cable.creep]\n{elements}\nlogarithmic = {sizes[-1]}"
        if self.temperature is not None:
            text += f"\nreference_temperature = {self.temperature:.1f}"
        if self.activation_energy is not None:
            text += f"\nactivation_energy = {max(self.activation_energy, 0.0):.4g}"
        if self.humidity is not None:
            text += f"\nreference_humidity = {self.humidity:.2f}"
        if self.humidity_exponent is not None:
            text += f"\nhumidity_exponent = {self.humidity_exponent:.3g}"
        return text

    @property
    def uncertainty_text(self) -> str:
        """The entry of an uncertainty file for cables that creep as long as this one was tested, or less."""
        size, sigma = self.compliance_at(self.loaded)
        return f'[[parameters]]\nname = "creep_compliance"\nrange = [0.0, {max(size, 0.0) + _COVERAGE * sigma:.2g}]'

    def crept(self) -> Array:
        """Return the creep strain (k,) at the samples: the measured one without all other parts of the law."""
        strain = self.test.elongation / self.initial_length - self.offset - self.residuals
        strain = strain - self.elastic * (self.test.force - self.test.force[0])
        if self.expansion is not None and self.test.temperature is not None:
            strain = strain - self.expansion * (self.test.temperature - self.test.temperature[0])
        return np.asarray(strain)


def creep(
    test: str | Path | TensileTest,
    *,
    initial_length: float,
    retardations: Sequence[float] = RETARDATIONS,
    progress: Progress = silent,
) -> CreepResult:
    """Return stiffness and creep of a cable from a *test* with times, or its CSV: a held load, or cycles.

    *initial_length* (m): the distance of the two points between which the elongation is measured, at elongation zero.
    *retardations*: retardation times of the Voigt elements, s, up to four that rise; beside them creep is logarithmic
    from 1 s on.

    The strain is linear in all that is found: 1 / EA, the compliances of the elements and of the logarithmic part, the
    thermal expansion where the test has temperatures that change, and the strain at the first sample. So it is one
    linear least squares over the measured history of force, whatever that is. Where the climate changes under load, by
    2 K or by 0.05 of relative humidity, it is repeated for each guess of activation energy and humidity exponent.
    Sigmas are from the residuals, widened as these are correlated. What the first sample's force has done before counts
    as over.

    Raises `InputError` for a test without times, too short or too coarse for an element (it says which), without a
    change of force, or whose columns are indistinguishable. Source: `cablewright.models.creep`
    and `cablewright.models.climate_and_creep`.

    Examples
    --------
    >>> import numpy as np, cablewright as cw
    >>> time = np.concatenate([[0.0], np.geomspace(0.5, 7200.0, 300)])
    >>> force = np.where(time > 0.0, 1000.0, 0.0)
    >>> crept = 1e-9 * force * np.log1p(time) / np.log1p(3600.0)
    >>> found = cw.creep(cw.TensileTest(force, 2.0 * (force / 5e5 + crept), time=time), initial_length=2.0)
    >>> f"{found.stiffness / 1e3:.0f} kN, creep after an hour {found.after_hour:.0e} 1/N"
    '500 kN, creep after an hour 1e-09 1/N'
    """
    test = test if isinstance(test, TensileTest) else read_test(test, timed=True, gauge=initial_length)
    require_cable("initial length", initial_length)
    taus = _checked_retardations(retardations)
    times, loads = _require_loads(test)
    under = np.abs(loads) >= _LOADED * np.abs(loads).max()
    loaded = _require_time(test, times, under, taus)
    expands = test.temperature is not None and float(np.ptp(test.temperature)) >= _VARIES
    heat = [test.temperature - test.temperature[0]] if expands and test.temperature is not None else []

    def columns_of(paces: Array) -> Array:
        return np.column_stack([loads, histories(times, loads, taus, paces), np.ones_like(times), *heat])

    strain = test.elongation / initial_length
    whole = climate_of(test, under)
    climate, fit = _told(test, whole, columns_of, strain, progress)
    if not fit.found[0] > 0.0:
        raise InputError(f"{test.origin}: the elongation does not rise with the force: check signs and columns")
    parts = slice(1, 2 + len(taus))
    exponents = dict(zip((each.name for each in climate.unknowns), fit.of_pace[0].tolist(), strict=True))
    return CreepResult(
        test=test,
        initial_length=initial_length,
        retardations=taus,
        elastic=float(fit.found[0]),
        compliances=fit.found[parts],
        expansion=float(fit.found[fit.linear - 1]) if expands else None,
        activation_energy=exponents.get("activation_energy"),
        humidity_exponent=exponents.get("humidity_exponent"),
        temperature=climate.temperature,
        humidity=climate.humidity,
        covariance=fit.covariance,
        offset=float(fit.found[parts.stop]),
        residuals=fit.residuals,
        widened=fit.wider,
        loaded=loaded,
        notes=(*test.notes, *_notes(test, fit, taus, expands), *pace_notes(test, whole, climate, *fit.of_pace)),
    )


class _Fit(NamedTuple):
    """Numbers found, the ``linear`` ones first, then those of the pace; their covariance, and the residual."""

    found: Array
    linear: int
    covariance: Array
    residuals: Array  # (k,) strain
    wider: float  # by how much correlated residuals widen variances

    @property
    def of_pace(self) -> tuple[Array, Array]:
        """Unknowns of the creep rate by climate (p,), and their sigmas (p,)."""
        return self.found[self.linear :], np.sqrt(np.diagonal(self.covariance)[self.linear :])


def _told(
    test: TensileTest,
    climate: ClimateOfTest,
    columns_of: Callable[[Array], Array],
    strain: Array,
    progress: Progress,
) -> tuple[ClimateOfTest, _Fit]:
    """Fit the *strain* (k,) with as many unknowns of the pace as the test determines."""
    for choice in climate.choices():
        pace = search(choice, columns_of, strain, progress)
        if pace is None:
            continue
        fit = _fit(test, choice, pace, columns_of, strain)
        if (fit.of_pace[1] <= [each.sure for each in choice.unknowns]).all():
            break
    return choice, fit


def _fit(
    test: TensileTest, climate: ClimateOfTest, pace: Array, columns_of: Callable[[Array], Array], strain: Array
) -> _Fit:
    """Fit the *strain* (k,) by the columns of the *pace*, whose own derivatives share in the covariance."""
    columns = columns_of(climate.paces(pace))
    fit = _fitted(test, columns, strain)
    if not len(pace):
        return fit
    slopes = derivatives(climate, pace, lambda paces: columns_of(paces) @ fit.found)
    found = np.concatenate([fit.found, pace])
    return _fitted(test, np.column_stack([columns, slopes]), strain)._replace(found=found, linear=fit.linear)


def _checked_retardations(given: Sequence[float]) -> tuple[float, ...]:
    taus = tuple(float(each) for each in given)
    rising = all(b > a for a, b in pairwise(taus))
    if not (len(taus) <= MAX_RETARDATIONS and rising and all(1e-3 <= each <= 1e8 for each in taus)):
        raise InputError(
            f"retardations = {', '.join(f'{each:g}' for each in taus)} s: expected up to {MAX_RETARDATIONS} that rise, "
            "from 1 ms to 1e8 s"
        )
    return taus


def _require_loads(test: TensileTest) -> tuple[Array, Array]:
    """Times and changes of force since the first sample. Raises `InputError` where there are none, or too many."""
    if test.time is None:
        raise InputError(f"{test.origin}: no column 'time', which creep needs")
    if len(test.time) > MAX_SAMPLES:
        raise InputError(
            f"{test.origin}: {len(test.time)} samples; at most {MAX_SAMPLES} are taken: keep fewer of the later ones"
        )
    loads = test.force - test.force[0]
    if not np.abs(loads).max() > 0.0:
        raise InputError(f"{test.origin}: the force never changes: begin the record before the load is applied")
    return test.time - test.time[0], loads


def _require_time(test: TensileTest, times: Array, under: Mask, taus: tuple[float, ...]) -> float:
    """How long the specimen is *under* load (k,), s. Raises `InputError` for a part of the law that is not shown."""
    first = int(np.argmax(under))
    loaded = float(np.diff(times)[under[1:]].sum())
    if taus and loaded < taus[-1]:
        need, has = _spell(taus[-1]), _spell(loaded)
        why = f"the element of {need} needs a load for {need}, the test has {has}: hold longer, or leave it out"
        raise InputError(f"{test.origin}: {why}")
    begin = max(LOG_BEGIN, float(np.diff(times[first:][:2]).max(initial=0.0)))
    if loaded < _DECADES * begin:
        why = f"logarithmic creep needs two decades of time, from {_spell(begin)} to {_spell(_DECADES * begin)}"
        raise InputError(f"{test.origin}: {why}; this test is under load for {_spell(loaded)}")
    if taus:
        early = times[first:][times[first:] <= times[first] + taus[0]]
        if len(early) < _PER_RETARDATION:
            why = f"has {len(early)} samples within {_spell(taus[0])} of the load: {_PER_RETARDATION:g} determine it"
            raise InputError(f"{test.origin}: the element of {_spell(taus[0])} {why}")
    return loaded


def _fitted(test: TensileTest, columns: Array, strain: Array) -> _Fit:
    """Fit the *strain* (k,) by *columns* (k, j). Raises `InputError` where they are indistinguishable."""
    sizes = np.linalg.norm(columns, axis=0)
    if len(strain) <= columns.shape[1] or not (sizes > 0.0).all():
        raise InputError(f"{test.origin}: {len(strain)} samples are too few for {columns.shape[1]} numbers")
    scaled = columns / sizes
    u, s, vt = np.linalg.svd(scaled, full_matrices=False)
    if not s[-1] * _ALIKE > s[0]:
        raise InputError(f"{test.origin}: these forces and times do not separate stretch from creep")
    found = (vt.T @ ((u.T @ strain) / s)) / sizes
    residuals = strain - columns @ found
    wider = _widening(residuals)
    variance = wider * float(residuals @ residuals) / (len(strain) - columns.shape[1])
    root = vt.T / s / sizes[:, None]
    return _Fit(found, len(found), variance * root @ root.T, residuals, wider)


def _widening(residuals: Array) -> float:
    """By how much variances grow, as *residuals* are correlated: 1 plus twice the sum of their first correlations."""
    count = len(residuals)
    correlation = np.fft.irfft(np.abs(np.fft.rfft(residuals, 2 * count)) ** 2)[:count]
    if not correlation[0] > 0.0:
        return 1.0
    correlation /= correlation[0]
    chance = np.flatnonzero(correlation < 2.0 / np.sqrt(count))
    end = int(chance[0]) if len(chance) else count
    return max(1.0, 1.0 + 2.0 * float(correlation[1:end].sum()))


def _notes(test: TensileTest, fit: _Fit, taus: tuple[float, ...], expands: bool) -> Iterator[str]:
    if fit.wider > _WANDERS:
        yield (
            f"residuals wander: sigmas are {np.sqrt(fit.wider):.1f} times those of noise alone; "
            "hysteresis, settling strands or another law of creep"
        )
    names = [*(f"the element of {_spell(each)}" for each in taus), "logarithmic creep"]
    for name, size, sigma in zip(names, fit.found[1:], np.sqrt(np.diagonal(fit.covariance))[1:], strict=False):
        if size < _BELOW_ZERO * sigma:
            yield f"{name} is below 0: the cable does not creep by this law"
        elif sigma > abs(size):
            yield f"{name} is smaller than its sigma: this test does not separate it from the others"
    if test.temperature is None:
        yield "no column 'temperature': what its changes stretch counts as creep"
    elif not expands:
        yield f"the temperature changes by under {_VARIES:g} K: the expansion is unknown"


def _spell(seconds: float) -> str:
    if seconds >= 7200.0:
        return f"{seconds / 3600.0:.3g} h"
    return f"{seconds / 60.0:.3g} min" if seconds >= 120.0 else f"{seconds:.3g} s"
