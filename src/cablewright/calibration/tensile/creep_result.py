"""The result of a creep test of a cable: its stiffness, and what it creeps by after which time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np

from cablewright.arrays import Array
from cablewright.calibration.tensile.recording import TensileTest
from cablewright.models.creep import HOUR, log_response, voigt_response
from cablewright.results import Figure, Pictured

_TIMES: Final = (60.0, 600.0, HOUR, 10.0 * HOUR, 24.0 * HOUR, 240.0 * HOUR)  # s, of the table as far as the test lasts
_COVERAGE: Final = 2.0  # sigmas to the upper end of a range

FIGURES = (
    Figure("status", "", "ok.", lambda _: "ok"),
    Figure("stiffness", "N", "EA by the quick part of the stretch.", name="axial stiffness EA", shown="kN"),
    Figure("stiffness_sigma", "N", "Standard deviation of EA.", name="its sigma", shown="kN", digits=2),
    Figure(
        "expansion", "1/K", "Thermal expansion; absent where the temperature tells none.",
        only=lambda own: own.expansion is not None,
    ),
    Figure(
        "activation_energy", "J/mol", "By which it creeps faster when warmer; absent where the test tells none.",
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
        "temperature", "°C", "Mean under load, at which it creeps as told here; absent if not recorded.",
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
    Figure("noise", "m", "Root mean square of what the law leaves of the elongation.", digits=2),
    Figure("widened", "1", "By how much correlated residuals widen the variances.", digits=3),
    Figure("robot_file", "", "What a robot file has of this creep.", "robot_file_text", name="for the robot file"),
    Figure("uncertainty_file", "", "Creep from 0 to that at the end of the test, for an uncertainty file.",
           "uncertainty_text", name="for an uncertainty file"),
    Figure("notes", "", "What a careful person would ask.", detail=True),
)  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class CreepResult(Pictured):
    """The result of `creep`: stiffness of a cable, and its creep by time, with standard deviations.

    ``compliances`` (j + 1,), 1/N: after an hour, of the Voigt elements with their ``retardations`` and of logarithmic
    creep, at the mean ``temperature`` (degrees Celsius) and ``humidity`` (relative) under load; None: not recorded.
    ``covariance``: of 1 / EA (1/N), the compliances, the strain at the first sample, and those of expansion, activation
    energy and humidity exponent that are told.
    ``residuals`` (k,): strains that the law leaves.
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
        """EA, N."""
        return 1.0 / self.elastic

    @property
    def stiffness_sigma(self) -> float:
        """Standard deviation of EA, N."""
        return math.sqrt(self.covariance[0, 0]) / self.elastic**2

    @property
    def activation_energy_sigma(self) -> float | None:
        """Standard deviation of the activation energy, J/mol, where that is told."""
        last = -1 if self.humidity_exponent is None else -2
        return None if self.activation_energy is None else math.sqrt(self.covariance.diagonal()[last])

    @property
    def humidity_exponent_sigma(self) -> float | None:
        """Standard deviation of the humidity exponent, where that is told."""
        return None if self.humidity_exponent is None else math.sqrt(self.covariance.diagonal()[-1])

    @property
    def noise(self) -> float:
        """Root mean square of the residuals, m of elongation."""
        return float(np.sqrt(np.mean(self.residuals**2))) * self.initial_length

    def compliance_at(self, time: float) -> tuple[float, float]:
        """Return the creep per load *time* (s) after it began, 1/N, and its standard deviation."""
        at = np.array([time])
        responses = np.concatenate([*(voigt_response(at, tau) for tau in self.retardations), log_response(at)])
        own = slice(1, 1 + len(responses))
        variance = float(responses @ self.covariance[own, own] @ responses)
        return float(responses @ self.compliances), math.sqrt(max(variance, 0.0))

    @property
    def after_hour(self) -> float:
        """Creep per load after an hour, 1/N; of a shorter test it is extrapolated."""
        return self.compliance_at(HOUR)[0]

    @property
    def table(self) -> list[dict[str, float]]:
        """Creep by time, no longer than the specimen was under load."""
        rows = []
        for time in (*(each for each in _TIMES if each < self.loaded), self.loaded):
            size, sigma = self.compliance_at(time)
            rows.append({"time": time, "compliance": size, "sigma": sigma, "over_elastic": size / self.elastic})
        return rows

    @property
    def law(self) -> list[dict[str, float | str]]:
        """Each part of the law with its compliance after an hour."""
        names = [*(f"element of {tau:g} s" for tau in self.retardations), "logarithmic"]
        sigmas = np.sqrt(np.diagonal(self.covariance))[1:]
        found = zip(names, self.compliances.tolist(), sigmas.tolist(), strict=False)
        return [{"part": name, "compliance": size, "sigma": sigma} for name, size, sigma in found]

    @property
    def robot_file_text(self) -> str:
        """The `[cable.creep]` of a robot file; what is below 0 but may not be is left at 0."""
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
        """Return the strain (k,) by creep at the samples, by the law found: what all else leaves of the elongation."""
        strain = self.test.elongation / self.initial_length - self.offset - self.residuals
        strain = strain - self.elastic * (self.test.force - self.test.force[0])
        if self.expansion is not None and self.test.temperature is not None:
            strain = strain - self.expansion * (self.test.temperature - self.test.temperature[0])
        return np.asarray(strain)
