"""Random closed curves in the plane: smooth, self-intersecting, of a given length within a given area.

Merlet and Papegay (2023, section I) drew 200 such curves, from which an artist chose, by a method that they do not
report. Here the tangent's direction is a random trigonometric sum of the arc length, with the smallest change that
closes the curve: length and curvature are then known exactly. Curves that do not meet the requirements are dropped, so
that curve number k of a seed does not depend on how many are drawn.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress, silent
from cablewright.foundation.results import Figure, Pictured, Result

MAX_CURVES: Final = 1000
_HARMONICS: Final = 6
_AMPLITUDE: Final = 1.5  # rad, of the first harmonic; that of harmonic k is smaller by sqrt(k)
_MAX_TURNS: Final = 2
_TRIES: Final = 5_000
_PIECES: Final = 1024
_COARSE: Final = 2  # pieces per segment in the search for crossings
_HEADINGS: Final = 90  # rotations tried to fit the curve into the area
_GRAIN: Final = 0.02  # spacing of the points that measure the cover, as a share of the area's longer side


MAX_LENGTH: Final = 10_000.0  # m


@dataclass(frozen=True)
class CurveRequirements:
    """Requirements of a random curve: length, area, crossings, radius."""

    length: float  # m
    area: tuple[float, float]  # m, sides of the enclosing rectangle along x and y
    crossings: int = 2  # minimum number of self-intersections
    min_radius: float = 0.3  # m, of curvature
    min_angle: float = np.pi / 9  # rad, between the two branches of a crossing

    def __post_init__(self) -> None:
        """Raise `InputError` for requirements that no curve meets."""
        sides = np.array(self.area)
        if not (np.isfinite(sides).all() and (sides > 0.0).all()):
            raise InputError(f"area = {self.area}: must be two sides over 0 m")
        if not 0.0 < self.length < MAX_LENGTH:
            raise InputError(f"length = {self.length:g} m: must be more than 0 and less than {MAX_LENGTH:g} m")
        if not 0 <= self.crossings <= 50:
            raise InputError(f"crossings = {self.crossings}: must be from 0 to 50")
        if not 0.0 <= self.min_radius < 0.5 * float(sides.min()):
            raise InputError(
                f"minimum radius = {self.min_radius:g} m: must be less than half of the area's shorter side"
            )
        if not 0.0 <= self.min_angle < 0.5 * np.pi:
            raise InputError(f"min_angle = {self.min_angle:g} rad: must be from 0 to a quarter turn")


@dataclass(frozen=True, eq=False)
class Curve:
    """A closed curve with the centre of its extent at the origin, described by the direction of its tangent.

    At the arc parameter s, 2 pi times the share of its length, the direction is ``heading`` + ``turns`` s + the sum
    over k of ``cosine[k-1]`` cos ks + ``sine[k-1]`` sin ks, rad.
    """

    length: float  # m
    turns: int
    heading: float  # rad
    cosine: Array  # (H,) rad
    sine: Array  # (H,) rad

    def direction(self, s: Array, derivative: int = 0) -> Array:
        """Direction (n,), rad, of the curve at the arc parameters *s* (n,); with *derivative* = 1 its derivative."""
        k = np.arange(1, len(self.cosine) + 1)
        turned = np.multiply.outer(s, k)
        if derivative:
            return np.asarray(self.turns + np.cos(turned) @ (k * self.sine) - np.sin(turned) @ (k * self.cosine))
        return np.asarray(self.heading + self.turns * s + np.cos(turned) @ self.cosine + np.sin(turned) @ self.sine)

    def even(self, pieces: int) -> Array:
        """Return points (pieces + 1, 2), m, at equal distances along the curve; the last is the first.

        The unit tangent is integrated by its Fourier series, exact to rounding for a few hundred *pieces*.
        """
        tangent = np.fft.fft(np.exp(1j * self.direction(_parameters(pieces))))
        wave = np.fft.fftfreq(pieces, 1.0 / pieces)
        tangent[0], wave[0] = 0.0, 1.0  # the curve is closed: the rest of the mean is rounding
        z = np.fft.ifft(tangent / (1j * wave)) * (self.length / (2.0 * np.pi))
        z -= 0.5 * (z.real.max() + z.real.min()) + 0.5j * (z.imag.max() + z.imag.min())
        return np.stack([np.append(z.real, z.real[0]), np.append(z.imag, z.imag[0])], axis=1)

    @cached_property
    def min_radius(self) -> float:
        """Minimum radius of curvature, m."""
        return self.length / (2.0 * np.pi) / float(np.abs(self.direction(_parameters(_PIECES), 1)).max())

    @cached_property
    def crossings(self) -> Array:
        """Self-intersections (c, 4): x, y (m), the angle between the branches (rad), and the arc parameter."""
        return _crossings(self.even(_PIECES)[::_COARSE])

    @property
    def least_angle(self) -> float | None:
        """Minimum angle between the branches of a crossing, rad; None without crossings."""
        return float(self.crossings[:, 2].min()) if len(self.crossings) else None

    def remoteness(self, area: tuple[float, float]) -> float:
        """Mean distance of the points of *area* (sides, m) from the curve, m: the smaller, the better the cover."""
        sides = np.array(area)
        x, y = (np.arange(-0.5 * side, 0.5 * side, _GRAIN * sides.max()) for side in sides)
        places = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        curve = self.even(_PIECES // 4)
        squared = (places**2).sum(axis=1)[:, None] + (curve**2).sum(axis=1) - 2.0 * places @ curve.T
        return float(np.sqrt(np.maximum(0.0, squared.min(axis=1))).mean())


def draw(required: CurveRequirements, seed: int, number: int) -> Curve:
    """Draw curve *number* of *seed* as *required*. Raises `InputError` after too many attempts."""
    rng = np.random.default_rng([seed, number])
    for _ in range(_TRIES):
        curve = _random(rng, required.length)
        if curve is None or curve.min_radius < required.min_radius:
            continue
        curve = _fitted(curve, required.area)
        if curve and len(curve.crossings) >= required.crossings and (curve.crossings[:, 2] >= required.min_angle).all():
            return curve
    x, y = required.area
    raise InputError(
        f"none of {_TRIES} random curves of {required.length:g} m fits into {x:g} x {y:g} m "
        f"with {required.crossings} crossings and radii over {required.min_radius:g} m; relax the requirements"
    )


@dataclass(frozen=True, eq=False, repr=False)
class RankedCurve(Result):
    """A drawn curve, its number, and the mean distance of the area's points from it, m."""

    FIGURES: ClassVar = (
        Figure("number", "1", "Number of the curve, by which a job names it together with the seed."),
        Figure("length", "m", "Length of the closed curve.", "curve.length", detail=True),
        Figure("crossings", "1", "Number of self-intersections.", lambda one: len(one.curve.crossings)),
        Figure("min_radius", "m", "Minimum radius of curvature.", "curve.min_radius", shown="m"),
        Figure("min_angle", "rad", "Minimum angle between the branches of a crossing; null without crossings.",
               "curve.least_angle", digits=3),
        Figure("mean_distance", "m", "Mean distance of the area's points from the curve; the smaller, the better it "
               "covers the area.", shown="m"),
    )  # fmt: skip
    HEADLINES: ClassVar = ("number", "crossings", "min_radius", "mean_distance")

    number: int
    curve: Curve
    mean_distance: float


@dataclass(frozen=True, eq=False, repr=False)
class Curves(Pictured):
    """Random closed curves, sorted by their cover of the area, the best first."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok: curves that do not exist are an error.", lambda _: "ok"),
        Figure("seed", "1", "Seed of the curves, by which a job names them."),
        Figure("curves", "", "The curves, the best cover of the area first.", "ranked", parts=RankedCurve.FIGURES,
               ranked=True),
    )  # fmt: skip
    HEADLINES: ClassVar = ("seed",)

    requirements: CurveRequirements
    seed: int
    ranked: tuple[RankedCurve, ...]

    def __len__(self) -> int:
        """The number of curves."""
        return len(self.ranked)

    def __getitem__(self, place: int) -> RankedCurve:
        """The curve at *place*, from 0, the best cover."""
        return self.ranked[place]


def curves(
    length: float = 28.0,
    area: tuple[float, float] = (3.6, 8.0),
    *,
    count: int = 200,
    seed: int = 0,
    crossings: int = 2,
    min_radius: float = 0.3,
    progress: Progress = silent,
) -> Curves:
    """Draw random closed curves of *length* (m) within *area* (sides, m), sorted by their cover, the best first.

    *count* curves of *seed* are drawn, from number 0; each has at least *crossings* self-intersections and a minimum
    radius of curvature of *min_radius*, m. Raises `InputError` for requirements that no curve meets or none of many
    attempts meets.

    Examples
    --------
    >>> import cablewright as cw
    >>> found = cw.curves(count=3, seed=2022)
    >>> len(found), found[0].mean_distance <= found[1].mean_distance
    (3, True)
    """
    if not 1 <= count <= MAX_CURVES:
        raise InputError(f"count = {count}: must be from 1 to {MAX_CURVES}")
    if seed < 0:
        raise InputError(f"seed = {seed}: must be 0 or more")
    required = CurveRequirements(length, area, crossings, min_radius)
    found = []
    for number in range(count):
        curve = draw(required, seed, number)
        found.append(RankedCurve(number, curve, curve.remoteness(area)))
        progress("drawing curves", number + 1, count)
    return Curves(required, seed, tuple(sorted(found, key=lambda each: each.mean_distance)))


def _parameters(count: int) -> Array:
    return np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)


def _random(rng: np.random.Generator, length: float) -> Curve | None:
    """Return a random closed curve, by Newton steps of minimum norm; None where they do not converge."""
    falling = _AMPLITUDE / np.sqrt(np.arange(1.0, _HARMONICS + 1.0))
    turns = int(rng.integers(0, _MAX_TURNS + 1))
    cosine, sine = falling * rng.standard_normal((2, _HARMONICS))
    curve = Curve(length, turns, 0.0, cosine, sine)
    s = _parameters(_PIECES)
    turned = np.multiply.outer(s, np.arange(1, _HARMONICS + 1))
    basis = np.concatenate([np.cos(turned), np.sin(turned)], axis=1)
    for _ in range(12):
        tangent = np.exp(1j * curve.direction(s))
        open_end = tangent.mean()
        if abs(open_end) < 1e-14:
            return curve
        slope = (1j * tangent[:, None] * basis).mean(axis=0)
        change, *_ = np.linalg.lstsq(np.stack([slope.real, slope.imag]), [-open_end.real, -open_end.imag], rcond=None)
        curve = Curve(length, turns, 0.0, curve.cosine + change[:_HARMONICS], curve.sine + change[_HARMONICS:])
    return None


def _fitted(curve: Curve, area: tuple[float, float]) -> Curve | None:
    """Return the curve turned so that it fits best into *area*; None where it does not fit."""
    places = curve.even(_PIECES // 4) @ [1.0, 1.0j]
    headings = np.linspace(0.0, np.pi, _HEADINGS, endpoint=False)
    turned = np.multiply.outer(np.exp(1j * headings), places)
    share = np.maximum(np.ptp(turned.real, axis=1) / area[0], np.ptp(turned.imag, axis=1) / area[1])
    best = int(share.argmin())
    return Curve(curve.length, curve.turns, headings[best], curve.cosine, curve.sine) if share[best] <= 1.0 else None


def _crossings(places: Array) -> Array:
    """Return the self-intersections of the closed polygon *places* (n + 1, 2), as `Curve.crossings`."""
    start, way = places[:-1], np.diff(places, axis=0)
    n = len(start)
    i, j = np.triu_indices(n, 2)
    between, across = start[j] - start[i], _cross(way[i], way[j])
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = _cross(between, way[j]) / across, _cross(between, way[i]) / across
    neighbours = (i == 0) & (j == n - 1)
    meets = np.flatnonzero((one >= 0.0) & (one < 1.0) & (other >= 0.0) & (other < 1.0) & ~neighbours)
    i, j, one = i[meets], j[meets], one[meets]
    angle = np.arctan2(np.abs(across[meets]), np.abs((way[i] * way[j]).sum(axis=1)))
    at = start[i] + one[:, None] * way[i]
    return np.column_stack([at, angle, 2.0 * np.pi * (i + one) / n])


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
