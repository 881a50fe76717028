"""Young's modulus of a cable from a tensile test: the recording is split into branches, each with its own modulus.

The nominal modulus is the secant modulus of Paty et al. 2021, section 2.2.3, Eq. 22.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import ClassVar, Final

import numpy as np

from cablewright.calibration.tensile.recording import MIN_POINTS, TensileTest, read_test
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.foundation.results import Figure, Pictured
from cablewright.foundation.units import AREA, FORCE

PAPER_SPREAD: Final = 0.3
"""By how much a modulus varies about the nominal one in Paty et al. 2021, Eq. 23."""

FIGURES = (
    Figure("status", "", "ok.", lambda _: "ok"),
    Figure("modulus", "Pa", "Nominal Young's modulus: secant of the last full loading over the band.", shown="GPa"),
    Figure("axial_stiffness", "N", "EA; the section cancels out of it.", name="axial stiffness EA", shown="kN"),
    Figure("modulus_range", "1", "Min and max modulus found anywhere, over the nominal one."),
    Figure("branch_factors", "1", "Min and max secant of all full branches, over the nominal one."),
    Figure("tangent_factors", "1", "Min and max tangent of all full branches, over the nominal one."),
    Figure("loading", "Pa", "Secant modulus of each full loading.", name="loadings", shown="GPa"),
    Figure("unloading", "Pa", "Secant modulus of each full unloading.", name="unloadings", shown="GPa"),
    Figure("cycles", "1", "Number of loadings that an unloading follows, both across the band."),
    Figure("partial", "1", "Number of branches that do not span the band.", name="partial branches"),
    Figure(
        "hysteresis", "1", "Loop of each full cycle over the work of its loading, within the band.", digits=3, shown="%"
    ),
    Figure(
        "permanent_set", "m", "Elongation from each full loading to the next, at the band's lower load.", shown="mm"
    ),
    Figure("r_squared", "1", "R^2 of the secant, over the nominal branch's forces.", name="R^2"),
    Figure("initial_length", "m", "Length of the specimen at elongation zero.", digits=6, shown="m"),
    Figure("length", "m", "Length of the specimen at the band's lower load.", digits=6, shown="m"),
    Figure("stretch", "m", "Elongation over the band, on the nominal branch.", shown="mm"),
    Figure("section", "m^2", "Section of the cable.", shown="mm^2"),
    Figure("breaking_load", "N", "Breaking load of the cable.", shown="kN"),
    Figure("band", "1", "Shares of the breaking load that the modulus spans.", shown="%", digits=3),
    Figure("robot_file", "", "What a robot file has of this cable.", "robot_file_text", "for the robot file"),
    Figure("against_paper", "", "The range of the modulus beside that of Paty 2021.", name="range of the modulus"),
    Figure("notes", "", "What a careful person would ask.", detail=True),
)
# A turn back of the force by this share of the band ends a branch, a smaller one is noise. As no two neighbours of a
# branch may differ by more, one false sample cannot pass for the end of a branch.
_TURN: Final = 0.1
_WINDOWS: Final = 9  # tangents per branch, each over a fifth of its stretch; neighbours overlap by half
_MIN_IN_WINDOW: Final = 4
_SETTLED: Final = 0.02  # max relative difference of the last two loadings without a note

# Bounds of any cable test. A column or an option in the wrong unit exceeds them.
_BOUNDS: Final = {
    "initial length": (1e-3, 1e5, "m"),
    "section": (1e-10, 0.1, "m^2"),
    "breaking load": (1e-2, 1e9, "N"),
    "modulus": (1e6, 2e12, "Pa"),
}


@dataclass(frozen=True, eq=False)
class Branch:
    """One loading or unloading of a tensile test across the whole band, in order of rising force; read-only arrays."""

    rising: bool  # whether it is a loading
    place: str  # in the test: ``line 7 to line 120``
    force: Array  # (k,) N, the samples within the band
    elongation: Array  # (k,) m
    ends: tuple[float, float]  # m, elongation at the band's lower and upper load
    modulus: float  # Pa, secant over the band
    tangents: Array  # (w,) Pa, least-squares slopes, each over a fifth of the stretch
    tangent_forces: Array  # (w,) N, mean force of each

    @property
    def word(self) -> str:
        """``loading`` or ``unloading``."""
        return "loading" if self.rising else "unloading"


@dataclass(frozen=True, eq=False, repr=False)
class TensileResult(Pictured):
    """The result of `modulus`: a cable's modulus, its spread and hysteresis."""

    FIGURES: ClassVar = FIGURES
    HEADLINES: ClassVar = ("modulus", "modulus_range", "cycles", "r_squared")
    PASTED: ClassVar = ("for the robot file",)  # labels of lines that people copy

    test: TensileTest
    modulus: float  # Pa, nominal: secant of the last full loading
    length: float  # m, of the cable at the band's lower load, on the nominal branch: l_init of Eq. 22
    stretch: float  # m, over the band, on the nominal branch: delta l of Eq. 22
    r_squared: float  # of the secant line, over the nominal branch's forces
    branches: tuple[Branch, ...]  # those that span the band, in order of time
    hysteresis: tuple[float, ...]  # of each full cycle: area of the loop over that under the loading, within the band
    permanent_set: tuple[float, ...]  # m, from each full loading to the next, at the band's lower load
    partial: int  # branches that do not span the band
    notes: tuple[str, ...]  # sentences on the limits of the result
    initial_length: float  # m
    section: float  # m^2
    breaking_load: float  # N
    band: tuple[float, float]  # shares of the breaking load

    @property
    def axial_stiffness(self) -> float:
        """EA, N, from which the section cancels out."""
        return self.modulus * self.section

    @property
    def loads(self) -> tuple[float, float]:
        """The lower and upper load of the band in which the modulus is fitted, N."""
        return self.band[0] * self.breaking_load, self.band[1] * self.breaking_load

    @property
    def cycles(self) -> int:
        """Number of loadings that are followed by an unloading, both across the band."""
        return len(self.hysteresis)

    @property
    def loading(self) -> tuple[float, ...]:
        """Secant modulus of each full loading, Pa."""
        return tuple(branch.modulus for branch in self.branches if branch.rising)

    @property
    def unloading(self) -> tuple[float, ...]:
        """Secant modulus of each full unloading, Pa."""
        return tuple(branch.modulus for branch in self.branches if not branch.rising)

    @property
    def branch_factors(self) -> tuple[float, float]:
        """Lowest and highest secant modulus of all full branches, over the nominal one."""
        secants = self.loading + self.unloading
        return min(secants) / self.modulus, max(secants) / self.modulus

    @property
    def tangent_factors(self) -> tuple[float, float]:
        """Lowest and highest tangent modulus of all full branches, over the nominal one."""
        tangents = np.concatenate([branch.tangents for branch in self.branches])
        return float(tangents.min()) / self.modulus, float(tangents.max()) / self.modulus

    @property
    def modulus_range(self) -> tuple[float, float]:
        """Lowest and highest modulus of all secants and tangents, over the nominal one, rounded outwards to 0.01."""
        low = min(self.branch_factors[0], self.tangent_factors[0])
        high = max(self.branch_factors[1], self.tangent_factors[1])
        return math.floor(low * 100 + 1e-6) / 100, math.ceil(high * 100 - 1e-6) / 100

    @property
    def robot_file_text(self) -> str:
        """The `[cable]` of a robot file."""
        section, load = AREA.write(self.section, "mm^2"), FORCE.write(self.breaking_load, "kN")
        return (
            f'[cable]\nyoung_modulus = "{self.modulus / 1e9:.4g} GPa"\nsection = "{section}"\nbreaking_load = "{load}"'
        )

    @property
    def against_paper(self) -> str:
        """Comparison of the range with that of Paty 2021, and the option of `accuracy` for it."""
        low, high = 1 - PAPER_SPREAD, 1 + PAPER_SPREAD
        kind = "within" if low <= self.modulus_range[0] and self.modulus_range[1] <= high else "wider than"
        return (
            f"{self.modulus_range[0]:.2f},{self.modulus_range[1]:.2f}, {kind} the paper's {low:g} to {high:g}: "
            "--modulus-range of accuracy"
        )


def modulus(
    test: str | Path | TensileTest,
    *,
    initial_length: float,
    section: float,
    breaking_load: float,
    band: tuple[float, float] = (0.05, 0.5),
) -> TensileResult:
    """Return Young's modulus of a cable from a tensile *test* or its CSV, with its spread and hysteresis.

    *initial_length* (m): the distance of the two points between which the elongation is measured, at elongation zero.
    Eq. 22 has the length at the lower load: the elongation there is added. *section*: cross-section of the cable, m^2.
    *breaking_load*: N. *band*: lower and upper load over the breaking load, between which the modulus is the secant.

    The nominal branch, which the paper does not specify, is the **last** full loading: the first ones also settle the
    strands, which has happened in a cable in service. The elongation at a load is the mean over all crossings of that
    load by the branch, more than one where there is noise.

    Raises `InputError` if an argument is out of bounds, no loading spans the band with samples close enough, or
    elongation does not rise with force. Source: Paty et al. 2021, Eq. 22.

    Examples
    --------
    >>> import cablewright as cw
    >>> force, elongation = [50.0 * i for i in range(100)], [3e-5 * i for i in range(100)]
    >>> test = cw.TensileTest(force, elongation)
    >>> found = cw.modulus(test, initial_length=2.0, section=12.566e-6, breaking_load=9000.0)
    >>> round(found.modulus / 1e9)
    265
    """
    low, high = band
    test = test if isinstance(test, TensileTest) else read_test(test, gauge=initial_length)
    given = {"initial length": initial_length, "section": section, "breaking load": breaking_load}
    for name, value in given.items():
        require_cable(name, value)
    if not (0 < low < high <= 1 and high - low >= 0.01):
        raise InputError(f"band = {low:g},{high:g}: must be 0 < low < high <= 1, at least 0.01 apart")
    if not test.force.max() <= 2 * breaking_load:
        raise InputError(
            f"{test.origin}: the highest load is {test.force.max():.6g} N, over twice the breaking load, "
            f"{breaking_load:.6g} N: check the units of both"
        )
    search = _BranchSearch(test, initial_length, section, (low * breaking_load, high * breaking_load))
    loadings = [branch for branch in search.branches if branch.rising]
    if not loadings:
        raise InputError(f"{test.origin}: {search.why_no_loading(breaking_load)}")
    nominal = loadings[-1]
    require_cable("modulus", nominal.modulus, f"{test.origin}: ")
    return TensileResult(
        test=test,
        modulus=nominal.modulus,
        length=initial_length + nominal.ends[0],
        stretch=nominal.ends[1] - nominal.ends[0],
        r_squared=_r_squared(nominal, search.loads),
        branches=tuple(search.branches),
        hysteresis=tuple(_hysteresis(up, down, search.loads) for up, down in search.cycles),
        permanent_set=tuple(after.ends[0] - before.ends[0] for before, after in pairwise(loadings)),
        partial=search.partial,
        notes=(*test.notes, *search.left_out, *_notes(search.branches, nominal, initial_length)),
        initial_length=initial_length,
        section=section,
        breaking_load=breaking_load,
        band=band,
    )


def require_cable(name: str, value: float, origin: str = "") -> None:
    """Raise `InputError` unless *value* is plausible for a cable."""
    low, high, unit = _BOUNDS[name]
    if not low <= value <= high:
        raise InputError(
            f"{origin}{name} = {value:g} {unit}: must be over 0, from {low:g} to {high:g} {unit}; check the units"
        )


class _BranchSearch:
    """The branches of a test that span the band, the cycles they form, and why others do not count."""

    def __init__(self, test: TensileTest, initial_length: float, section: float, loads: tuple[float, float]) -> None:
        self.test, self.initial_length, self.section, self.loads = test, initial_length, section, loads
        self.width = loads[1] - loads[0]
        self.branches: list[Branch] = []  # in order of time
        self.cycles: list[tuple[Branch, Branch]] = []
        self.partial = 0  # branches that do not span the band
        self.left_out: list[str] = []
        before: Branch | None = None  # the branch that ends where this one begins, if it is full
        for begin, end in pairwise(_turning_points(test.force, _TURN * self.width)):
            branch = self._branch(begin, end)
            if branch is not None:
                self.branches.append(branch)
                if before is not None and before.rising:
                    self.cycles.append((before, branch))
            before = branch

    def why_no_loading(self, breaking_load: float) -> str:
        """Return the reason why the test has no full loading."""
        low, high = self.loads
        missing = f"no loading goes from {low:.6g} N to {high:.6g} N, the band"
        if self.left_out:
            return f"{missing}, with samples close enough: {self.left_out[0]}"
        force = self.test.force
        range_ = f"the lowest load is {force.min():.6g} N, the highest {force.max():.6g} N"
        if force.max() <= 0:
            return f"{missing}: {range_}; tension must be positive"
        if self.branches:
            return f"{missing}, there are only unloadings"
        return f"{missing}: {range_}, {100 * force.max() / breaking_load:.4g} % of the breaking load"

    def _branch(self, begin: int, end: int) -> Branch | None:
        """Return the branch from sample *begin* to *end*, two turning points; None if it does not count."""
        test, (low, high) = self.test, self.loads
        rising = bool(test.force[end] > test.force[begin])
        force, elongation = test.force[begin : end + 1], test.elongation[begin : end + 1]
        if not rising:
            force, elongation = force[::-1], elongation[::-1]
        if force[0] > low or force[-1] < high:
            self.partial += 1
            return None
        place = f"{test.place(begin)} to {test.place(end)}"
        name = f"{'loading' if rising else 'unloading'} from {place}"
        ends = _crossing(force > low, force, elongation, low), _crossing(force >= high, force, elongation, high)
        length, stretch = self.initial_length + ends[0], ends[1] - ends[0]
        first, last = int(np.argmax(force > low)), len(force) - int(np.argmax(force[::-1] < high))
        reason = _uneven(force[first - 1 : last + 1], self.width, "force", "N", last - first)
        if reason is None:
            if not stretch > 0:
                raise InputError(
                    f"{test.origin}, {name}: elongation does not rise with force: {ends[0]:.6g} m at {low:.6g} N, "
                    f"{ends[1]:.6g} m at {high:.6g} N"
                )
            reason = _uneven(elongation[first - 1 : last + 1], stretch, "elongation", "m", last - first)
        if reason is None:
            if not length > stretch:
                raise InputError(
                    f"{test.origin}, {name}: {length:.6g} m stretch by {stretch:.6g} m: check the units of elongation "
                    "and initial length"
                )
            force, elongation = force[first:last], elongation[first:last]
            slopes, forces = _tangents(force, elongation, ends)
            if len(slopes) == _WINDOWS:
                if not slopes.min() > 0:
                    raise InputError(
                        f"{test.origin}, {name}: elongation does not rise with force about "
                        f"{forces[slopes.argmin()]:.6g} N: has it slipped?"
                    )
                per_slope = length / self.section
                tangents = _frozen(per_slope * slopes)
                secant = per_slope * self.width / stretch
                return Branch(rising, place, force, elongation, ends, secant, tangents, _frozen(forces))
            reason = "its samples are too uneven for tangents"
        self.left_out.append(f"{name} is left out: {reason}")
        return None


def _turning_points(force: Array, turn: float) -> list[int]:
    """Return the samples at which branches begin and end: the force reverses there by *turn* (N) or more."""
    values: list[float] = force.tolist()
    lowest = highest = best = sign = 0
    points: list[int] = []
    for i, value in enumerate(values):
        if sign == 0:  # the direction is not known yet
            lowest = i if value < values[lowest] else lowest
            highest = i if value > values[highest] else highest
            if values[highest] - values[lowest] >= turn:
                sign = 1 if highest > lowest else -1
                points.append(min(lowest, highest))
                best = i
        elif sign * (value - values[best]) > 0:
            best = i
        elif sign * (values[best] - value) >= turn:
            points.append(best)
            sign, best = -sign, i
    return [*points, best] if points else []


def _crossing(above: Mask, force: Array, elongation: Array, load: float) -> float:
    """Return the elongation at *load*, m: the mean over the samples between which the branch crosses it."""
    at = np.flatnonzero(above[1:] != above[:-1])
    share = (load - force[at]) / (force[at + 1] - force[at])
    return float(np.mean(elongation[at] + share * (elongation[at + 1] - elongation[at])))


def _uneven(values: Array, width: float, name: str, unit: str, count: int) -> str | None:
    """Return why the samples of a branch do not do: too few, or a jump between two of them; None if they do."""
    if count < MIN_POINTS:
        return f"{count} samples within the band; at least {MIN_POINTS} are required"
    jump = float(np.abs(np.diff(values)).max())
    if jump > _TURN * width:
        return f"{name} jumps by {jump:.4g} {unit} between two samples; the limit is {_TURN * width:.4g} {unit}"
    return None


def _tangents(force: Array, elongation: Array, ends: tuple[float, float]) -> tuple[Array, Array]:
    """Return slopes dF/dl (N/m) and mean forces (N) of windows along the stretch, except those with too few samples.

    Windows are intervals of elongation and force is regressed on it, because the force has the noise: windows of force
    would cut the noise off on one side and bias the slope.
    """
    half = (ends[1] - ends[0]) / (_WINDOWS + 1)
    slopes, forces = [], []
    for centre in ends[0] + half * np.arange(1, _WINDOWS + 1):
        inside = np.abs(elongation - centre) <= half * (1 + 1e-9)
        x, y = elongation[inside] - centre, force[inside]
        if len(x) < _MIN_IN_WINDOW or np.ptp(x) < half:
            continue
        x = x - x.mean()
        slopes.append(x @ (y - y.mean()) / (x @ x))
        forces.append(y.mean())
    return np.array(slopes), np.array(forces)


def _frozen(values: Array) -> Array:
    values.flags.writeable = False
    return values


def _hysteresis(up: Branch, down: Branch, loads: tuple[float, float]) -> float:
    """Return the area between both branches within the band, over the area under the loading."""

    def work(branch: Branch) -> float:
        """Return the work, N m, from the lower load to the upper one."""
        force = np.concatenate([loads[:1], branch.force, loads[1:]])
        elongation = np.concatenate([branch.ends[:1], branch.elongation, branch.ends[1:]])
        return float(np.trapezoid(force, elongation))

    sides = loads[1] * (down.ends[1] - up.ends[1]) - loads[0] * (down.ends[0] - up.ends[0])
    return (work(up) + sides - work(down)) / work(up)


def _r_squared(branch: Branch, loads: tuple[float, float]) -> float:
    low, high = loads
    secant = low + (branch.elongation - branch.ends[0]) * (high - low) / (branch.ends[1] - branch.ends[0])
    off, spread = branch.force - secant, branch.force - branch.force.mean()
    return float(1.0 - off @ off / (spread @ spread))


def _notes(branches: Sequence[Branch], nominal: Branch, initial_length: float) -> Iterator[str]:
    """Yield sentences on the limits of the result."""
    loadings = [branch.modulus for branch in branches if branch.rising]
    if len(loadings) == 1:
        yield "one full loading only: a new cable still settles in it, and appears softer than it will be in service"
    elif abs(loadings[-1] / loadings[-2] - 1) > _SETTLED:
        yield (
            "not settled: the last loading differs from the one before it by "
            f"{100 * (loadings[-1] / loadings[-2] - 1):+.1f} %; run more cycles"
        )
    if len(loadings) == len(branches):
        yield "no full unloading: the modulus and the hysteresis of unloading are not known"
    start, stretch = abs(nominal.ends[0]), nominal.ends[1] - nominal.ends[0]
    if start > 2 * stretch and start > 0.01 * initial_length:
        yield (
            f"the elongation is {nominal.ends[0]:.4g} m at the band's lower load, and is added to the length: "
            "is it zero where the initial length was measured?"
        )
