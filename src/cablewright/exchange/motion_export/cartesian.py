"""A job in plain X Y Z for a firmware that computes the lengths itself, from straight lines to its anchors.

Effects that its model lacks, as sag, stretch and sheaves, are put into X Y Z: the position is commanded at which the
lengths that the firmware then pays out bring the nozzle to the path. Lines are as taut at the first point as stated;
from there the firmware adds differences of straight distances, in RepRapFirmware with its law of spools in float32.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from cablewright.exchange.firmware_robots import as_points
from cablewright.exchange.rrf_spool import SpoolLaw, in_firmware
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import AnswerError, InputError, Status
from cablewright.foundation.progress import Progress, silent
from cablewright.models.drum import WinchDrum
from cablewright.models.job_poses import poses_at
from cablewright.models.statics import Equilibrium, Model
from cablewright.printing.job import Job
from cablewright.robot import Robot
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.checks.winch_angles import WinchPath

LARGEST: Final = 2e-4
"""Largest error of the nozzle that remains, m, with which a job is written."""

_CLOSE: Final = 1e-6  # m, at which the place to command is found
_ROUNDS: Final = 8
_TRIED: Final = 200  # points of the path at which first tensions are tried
_SHARES: Final = (0.02, 0.1, 0.25, 0.5, 0.75)  # of the limits, preferred first tensions that are tried
_BLOCK: Final = 8192

Turns = Callable[[Array], Array]
"""Angles (k, m), rad, to which a firmware turns the drums for places (k, 3), m, up to a constant for each drum."""


def as_anchors(robot: Robot, job: Job) -> Robot:
    """Return the robot of `as_points`. Raises `InputError` for a job that rotates its platform."""
    if any(step.rotation is not None and any(step.rotation) for step in job.schedule):
        raise InputError(
            f"job {job.name}: the schedule rotates the platform, which X Y Z of a firmware cannot do; "
            f"remove the rotation from the schedule"
        )
    return as_points(robot)


def rrf_turns(anchored: Robot, law: SpoolLaw) -> Turns:
    """Return a function that computes RepRapFirmware's spool angles."""
    anchors = 1e3 * np.array([line.exit_point for line in anchored.lines])
    spans = np.array([line.advantage for line in anchored.lines], float)
    side_by_side = np.array([line.cables for line in anchored.lines], float)
    radii = np.array(law.radii)
    return lambda at: in_firmware(1e3 * at, anchors, radii, law.growth, spans, side_by_side)


def klipper_turns(anchored: Robot, rotation_distances: Array) -> Turns:
    """Return a function that computes the angles of Klipper's winches.

    *rotation_distances* (m,): m of the nozzle's distance for a turn.
    """
    anchors = np.array([line.exit_point for line in anchored.lines])
    return lambda at: 2.0 * np.pi * np.linalg.norm(at[:, None, :] - anchors, axis=2) / rotation_distances


@dataclass(frozen=True, eq=False)
class OwnModelPath:
    """A path for firmware kinematics. ``path``: positions to command; ``error``: m, the largest of the nozzle.

    ``difference``: m, the largest between the place commanded and the path; ``without``: m, the largest error of the
    nozzle without it. ``first``: (m,) N, tension of each line at the first point; ``tensions``: (2, m) N, the least and
    the largest.
    """

    path: WinchPath
    error: float
    difference: float
    without: float
    first: Array
    tensions: Array


def own_model_path(
    model: Model, job: Job, drums: Sequence[WinchDrum], turns: Turns, path: WinchPath, progress: Progress = silent
) -> OwnModelPath:
    """Return the positions to command so that the firmware brings the nozzle along *path*.

    Raises `AnswerError` where tensions would leave the limits of a line, or the nozzle's error exceeds `LARGEST`.
    """
    wanted = path.samples.positions
    few = np.unique(np.linspace(0, len(wanted) - 1, _TRIED).astype(int))
    best: tuple[float, _Driven] | None = None
    for driven in _starts(model, job, drums, turns, wanted[0]):
        _, held = driven.commanded(wanted[few])
        margin = _margin(model, held) if held.holds.all() else -np.inf
        if best is None or margin > best[0]:
            best = margin, driven
    if best is None:
        raise AnswerError(f"nozzle at {_at(wanted[0])} m: no lines are taut there as their tension_limits allow")
    driven = best[1]
    places, extremes, error, without = np.empty_like(wanted), [], 0.0, 0.0
    for first in range(0, len(wanted), _BLOCK):
        progress("firmware's model", first, len(wanted))
        at = slice(first, first + _BLOCK)
        places[at], held = driven.commanded(wanted[at])
        _require(model, held, wanted[at])
        extremes += [held.tensions.min(axis=0), held.tensions.max(axis=0)]
        error = max(error, _off(held, wanted[at]))
        plain = driven.held(wanted[at], wanted[at])
        without = max(without, _off(plain, wanted[at]) if plain.ok.all() else np.inf)
        half = 0.5 * (places[at][1:] + places[at][:-1]), 0.5 * (wanted[at][1:] + wanted[at][:-1])
        between = driven.held(*half)
        _require(model, between, half[1])
        error = max(error, _off(between, half[1]))
    if error > LARGEST:
        raise AnswerError(
            f"the nozzle's error by the firmware's own model would be {1e3 * error:.2g} mm, over {1e3 * LARGEST:g} mm: "
            "export klipper, which moves winches by their angle"
        )
    far = float(np.linalg.norm(places - wanted, axis=1).max())
    moved = replace(path, samples=replace(path.samples, positions=places))
    bounds = np.array([np.min(extremes, axis=0), np.max(extremes, axis=0)])
    return OwnModelPath(moved, error, far, without, driven.first, bounds)


@dataclass(frozen=True, eq=False)
class _Driven:
    """Lines that the firmware drives from a start: ``base``, rad, of each drum, and ``own``, the firmware's, there."""

    model: Model
    job: Job
    drums: Sequence[WinchDrum]
    turns: Turns
    base: Array  # (m,)
    own: Array  # (m,)
    first: Array  # (m,) N

    def held(self, commanded: Array, near: Array) -> Equilibrium:
        """Return the equilibria at commanded positions (k, 3), m; *near*: positions of the nozzle nearby, m."""
        angles = self.base + self.turns(commanded) - self.own
        lengths = np.column_stack([drum.lengths(angles[:, i]) for i, drum in enumerate(self.drums)])
        poses, retraction = poses_at(self.model.robot, self.job, near)
        return solve_forward(self.model, lengths, guess=poses, retraction=retraction)

    def commanded(self, wanted: Array) -> tuple[Array, Equilibrium]:
        """Return the positions (k, 3), m, to command for the nozzle to reach those *wanted*, and equilibria there."""
        places = wanted.copy()
        held = self.held(places, wanted)
        for _ in range(_ROUNDS):
            off = self.model.nozzle(held.pose) - wanted
            if not np.isfinite(off).all() or np.abs(off).max() < _CLOSE:
                break
            places -= off
            held = self.held(places, wanted)
        return places, held


def _starts(model: Model, job: Job, drums: Sequence[WinchDrum], turns: Turns, begin: Array) -> list[_Driven]:
    """Return starts of a job with the nozzle at *begin* (3,), m, of tensions that the limits allow."""
    poses, retraction = poses_at(model.robot, job, begin[None])
    low, high = np.array([line.tension_limits for line in model.robot.lines]).T
    found = []
    for share in _SHARES:
        held = solve_inverse(model, poses, retraction=retraction, preferred=low + share * (high - low))
        if held.holds.all():
            base = np.array([float(drum.angles(held.lengths[:, i])[0]) for i, drum in enumerate(drums)])
            found.append(_Driven(model, job, drums, turns, base, turns(begin[None])[0], held.tensions[0]))
    return found


def _margin(model: Model, held: Equilibrium) -> float:
    """Return the smallest distance of a tension to its limits, as a share of their range."""
    low, high = np.array([line.tension_limits for line in model.robot.lines]).T
    return float((np.minimum(held.tensions - low, high - held.tensions) / (high - low)).min())


def _require(model: Model, held: Equilibrium, wanted: Array) -> None:
    """Raise `AnswerError` for tensions beyond the limits of their lines."""
    if (codes := held.judged_code).any():
        bad = int(np.flatnonzero(codes)[0])
        raise AnswerError(
            f"nozzle at {_at(wanted[bad])} m, with the lengths that the firmware computes: {held[bad].sentence()}",
            Status.of(int(codes[bad])),
        )
    for i, line in enumerate(model.robot.lines):
        low, high = line.tension_limits
        tension = held.tensions[:, i]
        k = int(np.argmax(np.maximum(low - tension, tension - high)))
        if not low - 1e-6 <= tension[k] <= high + 1e-6:
            raise AnswerError(
                f"nozzle at {_at(wanted[k])} m: the lengths that the firmware computes give line {line.name!r} "
                f"{tension[k]:.3g} N, and its tension_limits are {low:g} to {high:g} N: export klipper, which moves "
                "winches by their angle, or take a smaller part"
            )


def _off(held: Equilibrium, wanted: Array) -> float:
    """Return the largest distance of the nozzle from where it is *wanted*, m; 0 without points."""
    return float(np.linalg.norm(held.model.nozzle(held.pose) - wanted, axis=1).max(initial=0.0))


def _at(place: Array) -> str:
    return ", ".join(f"{each:.4g}" for each in place)
