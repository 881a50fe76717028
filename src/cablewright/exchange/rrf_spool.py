"""Spool parameters Q and R of RepRapFirmware (M666) for one job: the build-up law, computed in float32.

The firmware turns a motor by k0 (sqrt(R^2 + l k2) - R), with l the change of the distance to the anchor since the
origin, k2 = -U O Q and k0 proportional to U / k2: versions 3.3 to 3.6 divide by Q. A small Q loses digits to rounding,
a large one bends a drum that has no build-up. Lengths are mm, as there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.models.drum import WinchDrum
from cablewright.robot import Line, Robot

LARGEST: Final = 0.2
"""Largest error of the nozzle by the law, mm, with which a configuration is written."""

KEPT: Final = 0.02
"""The robot's own build-up is written unless another law brings the nozzle nearer by more than this, mm."""

CANDIDATES: Final = np.logspace(-5.0, 0.5, 89)  # mm, of Q
_POINTS: Final = 10_000  # along the job, at which the law is tried
_ROUNDS: Final = 50  # of the search for R, each a third narrower

_Single = NDArray[np.float32]


@dataclass(frozen=True)
class SpoolLaw:
    """M666 Q and R, mm, and the largest error of the nozzle with them along the job, mm.

    ``own``: whether they are those of the robot's drums.
    """

    growth: float
    radii: tuple[float, ...]
    error: float
    own: bool


def dead_length(line: Line) -> float:
    """Return the length of cable, m, between the winch and the exit point, which no pose changes."""
    return line.dead_length if line.winch_exit is None else line.dead_span().length


def lengths_at_origin(robot: Robot) -> list[float]:
    """Return the straight length (m) of each line, all spans and the dead one, with the nozzle at the origin."""
    return [float(np.hypot.reduce(line.exit_point)) * line.advantage + dead_length(line) for line in robot.lines]


def spool_law(
    robot: Robot, drums: Sequence[WinchDrum], positions: Array, growth: float | None, *, may_be_zero: bool = False
) -> SpoolLaw:
    """Return the law of the smallest error along a job.

    *positions* (k, 3): of the nozzle, m; *growth*: Q of the robot's own drums, None or 0 for drums without build-up;
    *may_be_zero*: whether the firmware has drums without build-up, as from 3.7 on.
    The error is that of the law against the drums with straight lines, in the arithmetic of the firmware, at points all
    along the job, and brought to the nozzle by the pseudo-inverse of the lines' directions.
    Raises `InputError` for one over `LARGEST`, and for a length that a drum does not hold.
    """
    along = np.linspace(0.0, len(positions) - 1.0, _POINTS)
    at = 1e3 * np.column_stack([np.interp(along, np.arange(len(positions)), column) for column in positions.T])
    anchors = 1e3 * np.array([line.exit_point for line in robot.lines])
    away = at[:, None, :] - anchors
    apart = np.linalg.norm(away, axis=2)
    to_nozzle = np.linalg.pinv(away / apart[..., None])  # (k, 3, m)
    spans = np.array([line.advantage for line in robot.lines], float)
    moved = apart - np.linalg.norm(anchors, axis=1)  # (k, m)
    steps = np.linspace(np.minimum(moved.min(axis=0), 0.0), np.maximum(moved.max(axis=0), 0.0), 60)
    wanted, even = _angles(robot, drums, moved), _angles(robot, drums, steps)
    radii = 1e3 * np.array(
        [drum.radii(np.asarray(at)) for drum, at in zip(drums, lengths_at_origin(robot), strict=True)]
    )
    side_by_side = np.array([line.cables for line in robot.lines], float)

    def error(growth: float, radii: Array) -> float:
        turned = in_firmware(at, anchors, radii, growth, spans, side_by_side)
        off = (turned - wanted) * radii / spans
        worst = float(np.linalg.norm(np.einsum("kjm,km->kj", to_nozzle, off), axis=1).max())
        return worst if np.isfinite(worst) else np.inf

    if may_be_zero and not growth:
        law = SpoolLaw(0.0, tuple(radii), error(0.0, radii), own=True)
        if law.error <= LARGEST:
            return law
    best = SpoolLaw(np.nan, (), np.inf, own=False)
    for candidate in CANDIDATES:
        fitted = _fitted(float(f"{candidate:.3g}") * spans * side_by_side, spans, steps, even, radii)
        law = SpoolLaw(float(f"{candidate:.3g}"), tuple(fitted), error(float(f"{candidate:.3g}"), fitted), own=False)
        best = min(best, law, key=lambda each: each.error)
    if growth:
        own = error(growth, radii)
        if own <= min(best.error + KEPT, LARGEST):
            return SpoolLaw(growth, tuple(radii), own, own=True)
    if not best.error <= LARGEST:
        raise InputError(
            f"robot {robot.name!r}: by the firmware's law of spools (M666 Q, R) the nozzle is {best.error:.2g} mm off "
            f"on this job, over {LARGEST:g} mm: give build_up and drum_length of its [winch] if its spools have them, "
            "export klipper, or a smaller job"
        )
    return best


def _angles(robot: Robot, drums: Sequence[WinchDrum], moved: Array) -> Array:
    """Return the angles (k, m), rad, of the drums whose lines are *moved* (k, m), mm a span, from the origin."""
    found = []
    for k, (drum, origin) in enumerate(zip(drums, lengths_at_origin(robot), strict=True)):
        angles = drum.angles(np.append(origin, origin + 1e-3 * robot.lines[k].advantage * moved[:, k]))
        found.append(angles[1:] - angles[0])
    return np.column_stack(found)


def in_firmware(at: Array, anchors: Array, radii: Array, growth: float, spans: Array, side_by_side: Array) -> Array:
    """Return the angles (k, m), rad, to which the firmware turns the spools: all that it computes is float32.

    *growth*: Q, mm; of 0, as from 3.7 on, a spool has one radius. *at* (k, 3) and *anchors* (m, 3): mm.
    """
    single = np.float32
    origin = _distance(-anchors.astype(single))
    moved = _distance(at.astype(single)[:, None, :] - anchors.astype(single)) - origin
    r = radii.astype(single)
    if growth == 0.0:
        return np.asarray(moved * (spans.astype(single) / r), float)
    k2 = -(spans * side_by_side).astype(single) * single(growth)
    k0 = (2.0 * spans / k2).astype(single)
    with np.errstate(invalid="ignore"):  # an empty spool: NaN
        return np.asarray(k0 * (np.sqrt(r * r + moved * k2) - r), float)


def _distance(away: _Single) -> _Single:
    x, y, z = np.moveaxis(away, -1, 0)
    return np.asarray(np.sqrt(z * z + y * y + x * x))


def _fitted(growth: Array, spans: Array, steps: Array, even: Array, radii: Array) -> Array:
    """Return the radii (m,), mm, whose exact law is nearest to angles *even* (k, m) at *steps* (k, m), mm.

    An angle falls as the radius grows, so that the largest error has one minimum.
    """
    low, high = 0.7 * radii, 1.5 * radii

    def worst(r: Array) -> Array:
        share = np.maximum(r * r - growth * steps, 1e-12)  # of an empty spool, with a large error
        return np.asarray(np.abs(2.0 * spans * steps / (np.sqrt(share) + r) - even).max(axis=0))

    for _ in range(_ROUNDS):
        one, two = (2.0 * low + high) / 3.0, (low + 2.0 * high) / 3.0
        left = worst(one) < worst(two)
        low, high = np.where(left, low, one), np.where(left, two, high)
    return np.round(0.5 * (low + high), 6)
