"""States of a robot that the viewer shows one at a time: poses, tensions, sagging lines and turned sheaves.

The lines are drawn from the line states that a solver found. Nothing is interpolated between states.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from cablewright.analyses.line_shapes import polylines
from cablewright.apps.quantities import allowed_range
from cablewright.apps.web.detail_levels import Packed, packed
from cablewright.foundation.arrays import Array, Indices
from cablewright.kernels.layout import PULLEY
from cablewright.kernels.layout import Packed as PackedRobot
from cablewright.models.packed_views import LineNumbers, LineStates
from cablewright.models.rotation import placed
from cablewright.models.statics import Equilibrium
from cablewright.robot import Robot

_FINE: Final = 4000.0  # chords of lines are so many times nearer to the curve than the frame is large


@dataclass(frozen=True, eq=False)
class States:
    """F states of a robot with m lines, for the frames of a 3-D view."""

    poses: Array  # (F, n) m and rad, of the platform's origin
    tensions: Array  # (F, m) N; NaN: not known
    curves: tuple[tuple[Array, ...], ...]  # F times m arrays (k, 3), m
    sheaves: Array  # (F, m, 6): centre, m, and axis of each sheave; NaN: none
    times: Array | None = None  # (F,) s
    samples: Indices | None = None  # (F,) the sample of the path that each state is at
    names: tuple[str, ...] = ()  # of the states, where they have names
    notes: tuple[str, ...] = ()  # what has to be known of each state
    estimates: Array | None = None  # (F, n) estimated poses
    ellipsoids: Array | None = None  # (F, 3, 3) m: rows are half axes of one sigma
    ellipsoid_times: float = 1.0  # by which ellipsoids are drawn larger
    shown: int = 0  # the first to be shown
    lattice: tuple[Array, Array, Array] | None = None  # m: x, y and z of the nozzle, of which all F are, x fastest
    scans: tuple[Array, ...] | None = None  # F arrays (k, 3), m: points that lidars saw

    @classmethod
    def held(cls, found: Equilibrium, tensions: Array | None = None, **more: Any) -> States:
        """Return the states of equilibria; *tensions* (F, m), N, in place of those of `found`."""
        _, poses, states = found.solved_arrays()
        own = np.atleast_2d(found.tensions) if tensions is None else tensions
        return cls.drawn(found.packed, found.model.robot, poses, states, own, **more)

    @classmethod
    def drawn(
        cls, packed_robot: PackedRobot, robot: Robot, poses: Array, states: Array, tensions: Array, **more: Any
    ) -> States:
        """Return the states to draw from line states (F, m, 6); a line of unknown state is drawn straight."""
        frame = np.subtract(robot.scene.frame_max, robot.scene.frame_min)
        tolerance = float(frame.max()) / _FINE
        curves, sheaves = [], []
        for k, (pose, state) in enumerate(zip(poses, states, strict=True)):
            own = packed_robot.lines[k if len(packed_robot.lines) > 1 and packed_robot.lines.ndim == 3 else 0]
            own = own if packed_robot.lines.ndim == 3 else packed_robot.lines
            platform = packed_robot.platform.reshape(-1, packed_robot.platform.shape[-1])
            row = packed_robot._replace(lines=own, platform=platform[k if len(platform) > 1 else 0])
            drawn = _curves(row, pose, state, tolerance)
            curves.append(drawn)
            sheaves.append(_sheaves(LineNumbers(own), LineStates(state), drawn))
        return cls(poses, tensions, tuple(curves), np.array(sheaves), **more)

    def __len__(self) -> int:
        """The number of states."""
        return len(self.poses)

    def with_estimates(self, poses: Array, covariances: Array | None, times: float) -> States:
        """Return the states with estimates: *poses* (F, n), *covariances* (F, 3, 3) of the position, m^2."""
        axes = None if covariances is None else _half_axes(covariances)
        return replace(self, estimates=poses, ellipsoids=axes, ellipsoid_times=times)

    def scale(self, robot: Robot) -> dict[str, Any] | None:
        """Ends of the tensions' colour scale, N, and the limits in words; None where no tension is known."""
        known = self.tensions[np.isfinite(self.tensions)]
        if not len(known):
            return None
        low, high = float(known.min()), float(known.max())
        if high - low < 0.02 * max(high, 1e-9):  # all equal: one colour, in the middle
            low, high = 0.9 * low, 1.1 * high + 1e-9
        limits = np.array([line.tension_limits for line in robot.lines])
        words = (
            allowed_range(float(limits[0, 0]), float(limits[0, 1]), "N")
            if (limits == limits[0]).all()
            else "of each line: see below"
        )
        return {"low": low, "high": high, "limits": words}

    def as_dict(self, corner: Array, step: float) -> dict[str, Any]:
        """Return the states as a JSON object; points on a grid from *corner* (3,) by *step*, m."""
        count = max((len(each) for curves in self.curves for each in curves), default=0)
        points = np.empty((len(self.curves), self.tensions.shape[1], max(count, 2), 3))
        for k, curves in enumerate(self.curves):
            for i, own in enumerate(curves):
                points[k, i, : len(own)] = own
                points[k, i, len(own) :] = own[-1]
        grid = np.clip(np.round((points - corner) / step), 0, 65_535)
        return {
            "curves": packed(grid, "u16", delta=True),
            "poses": packed(self.poses, "f32"),
            "tensions": packed(self.tensions, "f32"),
            "sheaves": packed(self.sheaves, "f32") if np.isfinite(self.sheaves).any() else None,
            "times": _optional(self.times, "f32"),
            "samples": _optional(self.samples, "u32"),
            "estimates": _optional(self.estimates, "f32"),
            "ellipsoids": _optional(self.ellipsoids, "f32"),
            "ellipsoid_times": self.ellipsoid_times,
            "ellipsoid_label": f"one sigma, {self.ellipsoid_times:g} times its size",
            "names": list(self.names) or None,
            "notes": list(self.notes) or None,
            "shown": self.shown,
            "lattice": None if self.lattice is None else [axis.tolist() for axis in self.lattice],
            **self._scans_as_dict(corner, step),
        }

    def _scans_as_dict(self, corner: Array, step: float) -> dict[str, Any]:
        """The points of all states one after the other, as far as the grid of `as_dict` goes; where each's end."""
        if self.scans is None or not any(map(len, self.scans)):
            return {"scans": None, "scan_ends": None}
        grids = [np.round((each - corner) / step) for each in self.scans]
        inside = [each[((each >= 0.0) & (each <= 65_535.0)).all(axis=1)] for each in grids]
        grid, ends = np.concatenate(inside), np.cumsum([len(each) for each in inside])
        return {"scans": packed(grid, "u16", delta=True), "scan_ends": packed(ends, "u32")}


def _optional(values: ArrayLike | None, kind: str) -> Packed | None:
    return None if values is None else packed(np.asarray(values), kind)


def _curves(row: PackedRobot, pose: Array, states: Array, tolerance: float) -> tuple[Array, ...]:
    """Each line's curve; straight where its state is not known."""
    numbers = LineNumbers(row.lines)
    ends = np.stack([numbers.exit_point, placed(pose, numbers.platform_point)], axis=1)
    if not np.isfinite(ends).all():
        return tuple(np.repeat(own[:1], 2, axis=0) for own in ends)
    if np.isfinite(states).all():
        found = polylines(row, pose, states, tolerance)
        return tuple(own if len(own) > 1 else straight for own, straight in zip(found, ends, strict=True))
    return tuple(ends)


def _sheaves(numbers: LineNumbers, states: LineStates, curves: tuple[Array, ...]) -> Array:
    """Centre and axis (m, 6) of each sheave: in the plane of its line, or as it is fixed; NaN of an eyelet."""
    exits, radius = numbers.exit_point, numbers.radius
    made = np.full((len(exits), 6), np.nan)
    for i, curve in enumerate(curves):
        if radius[i] == 0.0:
            continue
        away = curve[0] - exits[i]
        if numbers.guide[i] == PULLEY:
            centre, axis = exits[i], numbers.axis[i]
        elif numbers.guide[i]:  # a swivel: its plane has its axis and the point where the cable leaves
            outward = away - (away @ numbers.axis[i]) * numbers.axis[i]
            outward /= max(float(np.linalg.norm(outward)), 1e-12)
            centre, axis = exits[i] + radius[i] * outward, np.cross(numbers.axis[i], outward)
        else:
            level = np.append(curve[-1, :2] - exits[i, :2], 0.0)
            level /= max(float(np.linalg.norm(level)), 1e-12)
            angle = states.lever_angle[i] if np.isfinite(states.lever_angle[i]) else 0.0
            centre = exits[i] + numbers.lever[i] * (np.cos(angle) * level + np.array([0.0, 0.0, np.sin(angle)]))
            axis = np.cross([0.0, 0.0, 1.0], level)
        made[i] = (*centre, *axis)
    return made


def _half_axes(covariances: Array) -> Array:
    """Half axes of one sigma (F, 3, 3), m, as rows, of covariances (F, 3, 3), m^2."""
    made = np.full(covariances.shape, np.nan)
    for k, each in enumerate(covariances):
        if np.isfinite(each).all():
            sizes, axes = np.linalg.eigh(0.5 * (each + each.T))
            axes[:, 2] *= np.linalg.det(axes)  # right-handed
            made[k] = (axes * np.sqrt(np.maximum(sizes, 1e-18))).T
    return made
