"""Young's modulus of a cable from a tensile test: the recording is cut into branches, and each of them is judged.

Nominal is the secant modulus of Paty et al. 2021, section 2.2.3, Eq. 22.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.arrays import Array, Mask
from cablewright.calibration.tensile.recording import MIN_POINTS, TensileTest, read_test
from cablewright.calibration.tensile.result import Branch, TensileResult
from cablewright.errors import InputError

# A turn back of the force by this share of the band ends a branch, a smaller one is noise. As no two neighbours of a
# branch may be farther apart, one false sample cannot pass for the end of a branch.
_TURN: Final = 0.1
_WINDOWS: Final = 9  # tangents per branch; each looks at a fifth of its stretch, half of it its neighbour's too
_MIN_IN_WINDOW: Final = 4
_SETTLED: Final = 0.02  # by how much the last two loadings may differ without a note

# What no cable test exceeds. A column or an option in the wrong unit does.
_SENSIBLE: Final = {
    "initial length": (1e-3, 1e5, "m"),
    "section": (1e-10, 0.1, "m^2"),
    "breaking load": (1e-2, 1e9, "N"),
    "modulus": (1e6, 2e12, "Pa"),
}


def modulus(
    test: str | Path | TensileTest,
    *,
    initial_length: float,
    section: float,
    breaking_load: float,
    band: tuple[float, float] = (0.05, 0.5),
) -> TensileResult:
    """Young's modulus of a cable from a tensile *test* or the CSV that has it, its spread, and its hysteresis.

    ``initial_length`` (m) is the specimen's length, between the points whose distance the elongation is the growth of,
    where the elongation column is zero. Eq. 22 wants the length at the lower load; the elongation there is added.
    ``section`` (m^2), ``breaking_load`` (N). ``band``: shares of the breaking load that the modulus spans.

    The paper does not say which branch. Nominal is the **last** full loading: the first ones also settle the strands,
    which a cable in service has behind it. The elongation at a load is the mean over the places where the branch
    crosses it: one, or some where noise goes back and forth.

    Raises `InputError` where an argument is out of all bounds, no loading spans the band with samples close enough, or
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
    test = test if isinstance(test, TensileTest) else read_test(test)
    given = {"initial length": initial_length, "section": section, "breaking load": breaking_load}
    for name, value in given.items():
        _require(name, value)
    if not (0 < low < high <= 1 and high - low >= 0.01):
        raise InputError(f"band = {low:g},{high:g}: 0 < low < high <= 1, at least 0.01 apart, is wanted")
    if not test.force.max() <= 2 * breaking_load:
        highest = f"the highest load is {test.force.max():.6g} N, over twice the breaking load, {breaking_load:.6g} N"
        raise InputError(f"{test.origin}: {highest}: check the units of both")
    search = _BranchSearch(test, initial_length, section, breaking_load, (low, high))
    branches = search.run()
    nominal = next((branch for branch in reversed(branches) if branch.rising), None)
    if nominal is None:
        raise InputError(f"{test.origin}: {search.why_none(any_unloading=bool(branches))}")
    _require("modulus", nominal.modulus, f"{test.origin}: ")
    return TensileResult(
        test=test,
        modulus=nominal.modulus,
        length=initial_length + nominal.ends[0],
        stretch=nominal.ends[1] - nominal.ends[0],
        r_squared=_r_squared(nominal, search.loads),
        branches=tuple(branches),
        hysteresis=tuple(_hysteresis(up, down, search.loads) for up, down in search.cycles),
        permanent_set=_permanent_set(branches),
        partial=search.partial,
        notes=(*search.left_out, *_notes(branches, nominal, initial_length)),
        initial_length=initial_length,
        section=section,
        breaking_load=breaking_load,
        band=band,
    )


def _require(name: str, value: float, origin: str = "") -> None:
    """Raise `InputError` unless ``value`` is within what a cable can have; most often a unit is wrong."""
    low, high, unit = _SENSIBLE[name]
    if not low <= value <= high:
        hint = f"must be over 0, from {low:g} to {high:g} {unit}; check the units"
        raise InputError(f"{origin}{name} = {value:g} {unit}: {hint}")


class _BranchSearch:
    """The branches of a test that span a band, and why others do not count."""

    def __init__(
        self, test: TensileTest, initial_length: float, section: float, breaking_load: float, band: tuple[float, float]
    ) -> None:
        self.test, self.initial_length, self.section, self.breaking_load = test, initial_length, section, breaking_load
        self.loads = band[0] * breaking_load, band[1] * breaking_load
        self.width = self.loads[1] - self.loads[0]
        self.partial = 0
        self.left_out: list[str] = []
        self.cycles: list[tuple[Branch, Branch]] = []

    def run(self) -> list[Branch]:
        """Find the full branches in the order of time, and the cycles they form."""
        branches: list[Branch] = []
        before: Branch | None = None  # the branch that ends where this one begins, if it is full
        turns = _turning_points(self.test.force, _TURN * self.width)
        for begin, end in pairwise(turns):
            branch = self._branch(begin, end)
            if branch is not None:
                branches.append(branch)
                if before is not None and before.rising:
                    self.cycles.append((before, branch))
            before = branch
        return branches

    def why_none(self, any_unloading: bool) -> str:
        """Say why there is no loading to judge."""
        low, high = self.loads
        wanted = f"no loading goes from {low:.6g} N to {high:.6g} N, the band"
        if self.left_out:
            return f"{wanted}, with samples close enough: {self.left_out[0]}"
        force = self.test.force
        seen = f"the lowest load is {force.min():.6g} N, the highest {force.max():.6g} N"
        if force.max() > 0:
            seen += f", {100 * force.max() / self.breaking_load:.4g} % of the breaking load"
        if force.max() <= 0:
            return f"{wanted}: {seen}; tension must be positive"
        return f"{wanted}, there are only unloadings" if any_unloading else f"{wanted}: {seen}"

    def _branch(self, begin: int, end: int) -> Branch | None:
        """Judge the samples from ``begin`` to ``end``, two turning points; None if they do not count."""
        test, (low, high) = self.test, self.loads
        rising = bool(test.force[end] > test.force[begin])
        order = slice(begin, end + 1)
        force, elongation = test.force[order], test.elongation[order]
        if not rising:
            force, elongation = force[::-1], elongation[::-1]
        if force[0] > low or force[-1] < high:
            self.partial += 1
            return None
        word = "loading" if rising else "unloading"
        place = f"{test.place(begin)} to {test.place(end)}"
        ends = _crossing(force > low, force, elongation, low), _crossing(force >= high, force, elongation, high)
        first, last = int(np.argmax(force > low)), len(force) - int(np.argmax(force[::-1] < high))
        within = slice(first, last)
        reason = _uneven(force[first - 1 : last + 1], self.width, "force", "N", last - first)
        if reason is None and not ends[1] > ends[0]:
            found = f"{ends[0]:.6g} m at {low:.6g} N, {ends[1]:.6g} m at {high:.6g} N"
            raise InputError(f"{test.origin}, {word} from {place}: elongation does not rise with force: {found}")
        stretch = ends[1] - ends[0]
        reason = reason or _uneven(elongation[first - 1 : last + 1], stretch, "elongation", "m", last - first)
        if reason is not None:
            self.left_out.append(f"{word} from {place} is left out: {reason}")
            return None
        return self._measured(rising, place, force[within], elongation[within], ends)

    def _measured(
        self, rising: bool, place: str, force: Array, elongation: Array, ends: tuple[float, float]
    ) -> Branch | None:
        """Secant and tangents of a branch with close samples; None if a tangent has too few."""
        length, stretch = self.initial_length + ends[0], ends[1] - ends[0]
        if not length > stretch:
            hint = "check the units of elongation and initial length"
            raise InputError(f"{self.test.origin}, {place}: {length:.6g} m stretch by {stretch:.6g} m: {hint}")
        per_slope = length / self.section
        slopes, forces = _tangents(force, elongation, ends)
        if len(slopes) < _WINDOWS:
            kind = "loading" if rising else "unloading"
            self.left_out.append(f"{kind} from {place} is left out: its samples are too uneven for tangents")
            return None
        if not slopes.min() > 0:
            at = f"about {forces[slopes.argmin()]:.6g} N"
            raise InputError(f"{self.test.origin}, {place}: elongation does not rise with force {at}: has it slipped?")
        secant = per_slope * self.width / stretch
        return Branch(rising, place, force, elongation, ends, secant, _frozen(per_slope * slopes), _frozen(forces))


def _turning_points(force: Array, low: float) -> list[int]:
    """Return where the force turns back by ``low`` or more, with where its first branch begins and its last ends."""
    values: list[float] = force.tolist()
    lowest = highest = best = sign = 0
    points: list[int] = []
    for i, value in enumerate(values):
        if sign == 0:  # not yet known which way it goes
            lowest = i if value < values[lowest] else lowest
            highest = i if value > values[highest] else highest
            if values[highest] - values[lowest] >= low:
                sign = 1 if highest > lowest else -1
                points.append(min(lowest, highest))
                best = i
        elif sign * (value - values[best]) > 0:
            best = i
        elif sign * (values[best] - value) >= low:
            points.append(best)
            sign, best = -sign, i
    return [*points, best] if points else []


def _crossing(above: Mask, force: Array, elongation: Array, load: float) -> float:
    """Return the elongation at ``load``: the mean over the places where the branch crosses it."""
    at = np.flatnonzero(above[1:] != above[:-1])
    share = (load - force[at]) / (force[at + 1] - force[at])
    return float(np.mean(elongation[at] + share * (elongation[at + 1] - elongation[at])))


def _uneven(values: Array, width: float, name: str, unit: str, count: int) -> str | None:
    """Say what is wrong with the samples of a branch, if they are too few or one is too far from the next."""
    if count < MIN_POINTS:
        return f"{count} samples within the band; at least {MIN_POINTS} are wanted"
    jump = float(np.abs(np.diff(values)).max())
    if jump > _TURN * width:
        return f"{name} jumps by {jump:.4g} {unit} between two samples; {_TURN * width:.4g} {unit} is allowed"
    return None


def _tangents(force: Array, elongation: Array, ends: tuple[float, float]) -> tuple[Array, Array]:
    """Return slopes dF/dl (N/m) and mean forces (N) of windows along the stretch, but those with too few samples.

    Windows are of elongation and the line is that of force on elongation, for it is the force that is noisy: a window
    of force would cut the noise off on one side and bend the slope.
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


def _area(branch: Branch, loads: tuple[float, float]) -> float:
    """Return the work (N m) that the branch takes in from the lower load to the upper one."""
    force = np.concatenate([loads[:1], branch.force, loads[1:]])
    elongation = np.concatenate([branch.ends[:1], branch.elongation, branch.ends[1:]])
    return float(np.sum((force[1:] + force[:-1]) / 2 * np.diff(elongation)))


def _hysteresis(up: Branch, down: Branch, loads: tuple[float, float]) -> float:
    """Return the area between both branches within the band over the area under the loading."""
    (low, high), work = loads, _area(up, loads)
    sides = high * (down.ends[1] - up.ends[1]) - low * (down.ends[0] - up.ends[0])
    return (work + sides - _area(down, loads)) / work


def _permanent_set(branches: Sequence[Branch]) -> tuple[float, ...]:
    starts = [branch.ends[0] for branch in branches if branch.rising]
    return tuple(after - before for before, after in pairwise(starts))


def _r_squared(branch: Branch, loads: tuple[float, float]) -> float:
    low, high = loads
    secant = low + (branch.elongation - branch.ends[0]) * (high - low) / (branch.ends[1] - branch.ends[0])
    off, spread = branch.force - secant, branch.force - branch.force.mean()
    return float(1.0 - off @ off / (spread @ spread))


def _notes(branches: Sequence[Branch], nominal: Branch, initial_length: float) -> Iterator[str]:
    """Yield what a careful person would ask."""
    loadings = [branch.modulus for branch in branches if branch.rising]
    if len(loadings) == 1:
        yield "one full loading only: a new cable still settles in it, and seems softer than it will be in service"
    elif abs(loadings[-1] / loadings[-2] - 1) > _SETTLED:
        change = f"{100 * (loadings[-1] / loadings[-2] - 1):+.1f} %"
        yield f"not settled: the last loading differs from the one before it by {change}; run more cycles"
    if len(loadings) == len(branches):
        yield "no full unloading: the spread and the hysteresis of unloading are not known"
    start, stretch = abs(nominal.ends[0]), nominal.ends[1] - nominal.ends[0]
    if start > 2 * stretch and start > 0.01 * initial_length:
        yield (
            f"the elongation is {nominal.ends[0]:.4g} m at the band's lower load, and counts into the length: "
            "is it zero where the initial length was measured?"
        )
