"""Tension, density and, where it sags enough, EA of a line from the natural frequency of its lateral vibration."""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import ClassVar, Final

import numpy as np
from numpy.typing import ArrayLike

from cablewright.analyses.swing_identification import identify_swing
from cablewright.foundation.arrays import Array
from cablewright.foundation.csv_input import cells_of, find_column, header_of, number_rows, separator_of, text_lines
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.foundation.results import Figure, Result
from cablewright.foundation.units import DURATION, Dimension
from cablewright.models.line_vibration import (
    KNOWN,
    observable_below,
    parameter_of,
    sag_parameter,
    sag_stiffening,
    string_density,
    string_frequency,
    string_tension,
)
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.taut import taut_at

SIGMA: Final = 5e-3
"""Assumed standard deviation of a frequency, as a share, where none is given."""

_MAX_BYTES: Final = 64 << 20
_MAX_ROWS: Final = 2_000_000
_NEAR: Final = (0.5, 1.9)  # of the expected frequency: between the platform's modes and the line's second
_PER_PERIOD: Final = 4.0  # periods of the expected frequency per that of the highest one of interest
_ANY: Final = Dimension("reading", {"1": Decimal(1)})


@dataclass(frozen=True, eq=False, repr=False)
class LineVibration(Result):
    """Tension, density and modulus of a line from its first frequencies, compared with the model at a pose."""

    FIGURES: ClassVar = (
        Figure("line", "", "Name of the line."),
        Figure("pose", "m, rad", "Pose of the platform."),
        Figure("span", "m", "Free cable from the sheave to the platform, which vibrates."),
        Figure("frequency", "Hz", "Measured frequency across the plane of the sag."),
        Figure("frequency_sigma", "Hz", "Its standard deviation.", digits=2),
        Figure("expected_frequency", "Hz", "That by the expected tension and the density in the robot file."),
        Figure("expected_tension", "N", "Tension by statics, or the given one."),
        Figure("tension", "N", "Tension by the frequency and the density in the robot file."),
        Figure("tension_sigma", "N", "Its standard deviation by that of the frequency.", digits=2),
        Figure("density", "kg/m", "Density by the frequency and the expected tension."),
        Figure("density_sigma", "kg/m", "Its standard deviation by that of the frequency.", digits=2),
        Figure("in_plane_frequency", "Hz", "Measured first frequency in the plane of the sag.",
               only=lambda of: of.in_plane_frequency is not None),
        Figure("expected_in_plane", "Hz", "That by the model.", name="expected in-plane frequency"),
        Figure("sag_parameter", "1", "Lambda squared of Irvine and Caughey by the tension of the frequency."),
        Figure("modulus_below", "N", "Tension below which two frequencies determine EA to 20 %; 0: none.",
               name="modulus observable below"),
        Figure("modulus", "", "observable or not observable, at this tension."),
        Figure("modulus_factor", "1", "EA by both frequencies, over that of the robot file.",
               only=lambda of: of.modulus_factor is not None),
        Figure("modulus_sigma", "1", "Its standard deviation.", digits=2,
               only=lambda of: of.modulus_factor is not None),
    )  # fmt: skip
    HEADLINES: ClassVar = ("line", "tension", "modulus")

    line: str
    pose: Array
    span: float
    frequency: float
    frequency_sigma: float
    expected_frequency: float
    expected_tension: float
    tension: float
    density: float
    in_plane_frequency: float | None
    expected_in_plane: float
    sag_parameter: float
    modulus_below: float
    modulus_factor: float | None
    modulus_sigma: float | None

    @property
    def tension_sigma(self) -> float:
        """Standard deviation of the tension by the frequency, N."""
        return 2.0 * self.tension * self.frequency_sigma / self.frequency

    @property
    def density_sigma(self) -> float:
        """Standard deviation of the cable's linear density, kg/m."""
        return 2.0 * self.density * self.frequency_sigma / self.frequency

    @property
    def modulus(self) -> str:
        """Whether both frequencies determine the cable's EA; with one frequency alone, whether a second would."""
        known = (
            self.tension < self.modulus_below if self.in_plane_frequency is None else self.modulus_factor is not None
        )
        return "observable" if known else "not observable"


def line_vibration(
    robot: Robot | Model,
    pose: ArrayLike,
    line: str,
    frequency: float | str | Path,
    *,
    sigma: float | None = None,
    in_plane: float | None = None,
    tension: float | None = None,
) -> LineVibration:
    """Compute tension and density of a *line* from its first natural *frequency*, Hz, at a *pose* (n,), m and rad.

    *frequency*: across the plane of the sag, or a CSV of a vibration: ``t`` and readings of an accelerometer or a load
    cell. *sigma*: its standard deviation, Hz; by default that of the record, or 0.5 %. *in_plane*: first frequency in
    the plane of the sag, Hz, for EA where sag matters. *tension*: tension that a load cell measured, N; None: it
    follows from statics. Raises `InputError` for an unknown line, a cable without weight, numbers out of range and
    records without a vibration near the expected one; `AnswerError` where no tensions hold the pose.
    """
    model = Model.of(robot)
    names = [each.name for each in model.robot.lines]
    if line not in names:
        raise UnknownName("line", line, names)
    given = {"sigma": sigma, "in_plane": in_plane, "tension": tension}
    for name, value in given.items():
        if value is not None and not 0.0 < value < math.inf:
            raise InputError(f"{name} = {value:g}: must be over 0")
    at, described = names.index(line), model.robot.lines[names.index(line)]
    density = described.cable.linear_density or 0.0
    if density <= 0.0:
        raise InputError(f"line {line!r}: its cable has no linear_density, which a vibration needs")
    held = solve_inverse(model, np.asarray(pose, dtype=float)).checked()
    taut = taut_at(model, held.pose)
    span, level = float(taut.free[at]), float(taut.free[at] * math.cos(taut.angles[at]))
    expected = float(held.tensions[at]) if tension is None else tension
    wanted = string_frequency(expected, span, density)
    if isinstance(frequency, str | Path):
        frequency, spread = _recorded(Path(frequency), wanted)
        sigma = spread if sigma is None else sigma
    if not 0.0 < frequency < math.inf:
        raise InputError(f"frequency = {frequency:g}: must be over 0 Hz")
    sigma = SIGMA * frequency if sigma is None else sigma
    found, weight = string_tension(frequency, span, density), density * model.robot.scene.gravity
    stiffness = described.cable.stiffness
    sag = sag_parameter(weight, level, found, stiffness)
    factor = spread_of_factor = None
    if in_plane is not None:
        factor, spread_of_factor = _factor(in_plane / frequency, sag, math.sqrt(2.0) * sigma / frequency)
    at_expected = sag_parameter(weight, level, expected, stiffness)
    return LineVibration(
        line,
        held.pose,
        span,
        frequency,
        sigma,
        wanted,
        expected,
        found,
        string_density(frequency, span, expected),
        in_plane,
        wanted * sag_stiffening(at_expected)[0],
        sag,
        observable_below(weight, level, stiffness, sigma / frequency),
        factor,
        spread_of_factor,
    )


def _factor(ratio: float, sag: float, sigma: float) -> tuple[float | None, float | None]:
    """Return EA over the file's and its sigma, by the *ratio* of frequencies known to *sigma*; None: not observable.

    *sag*: parameter of sag with the file's EA; whether it is observable depends on the one found.
    """
    found = parameter_of(ratio)
    if found is None or (slope := sag_stiffening(found)[1]) * KNOWN < sigma:
        return None, None
    return found / sag, found / sag * sigma / slope


def _recorded(path: Path, wanted: float) -> tuple[float, float]:
    """Return the frequency nearest to that *wanted*, Hz, and its sigma, in a record. Raises `InputError`."""
    number, header, rows = header_of(text_lines(path, _MAX_BYTES, "record of a vibration"))
    if not number:
        raise InputError(f"{path}: empty; expected a header with t and readings, then rows of numbers")
    cells, place = cells_of(header, separator_of(header)), f"{path}, line {number}"
    names = [cell.partition("(")[0].strip().casefold() for cell in cells]
    columns = {
        name: column
        for name in names
        if (column := find_column((name,), cells, place, DURATION if name == "t" else _ANY)) is not None
    }
    if "t" not in columns or len(columns) < 2:
        raise InputError(f"{place}: expected a column t, s, and one or more of readings, without units")
    found = number_rows(path, rows, header, columns, _MAX_ROWS, "rows")
    table = np.array([numbers for _, _, numbers in found]).reshape(-1, len(columns))
    times = table[:, list(columns).index("t")]
    swung = identify_swing(times, np.delete(table, list(columns).index("t"), axis=1), highest=_PER_PERIOD * wanted)
    low, high = (share * wanted for share in _NEAR)
    near = np.flatnonzero((swung.frequencies > low) & (swung.frequencies < high))
    if not len(near):
        others = ", ".join(f"{each:.3g}" for each in swung.frequencies)
        raise InputError(
            f"{path}: vibrates at {others} Hz, and a line's first mode is expected at {low:.3g} to {high:.3g} Hz; give "
            "the tension if it is another one"
        )
    best = near[np.argmax(swung.shares[near])]
    return float(swung.frequencies[best]), float(swung.frequency_sigmas[best])
