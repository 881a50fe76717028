"""Places of a robot's frame to look at: a plane, a helix, the whole workspace."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Self

import numpy as np

from cablewright.arrays import Array
from cablewright.errors import InputError
from cablewright.robot import Robot

Shape = Literal["helix", "path", "plane", "workspace"]

MAX_PLACES = 5_000_000
HELIX_STEP = 0.1  # m


@dataclass(frozen=True, eq=False)
class Places:
    """Where to look: nozzle positions (N, 3), m, and what orders them."""

    shape: Shape
    positions: Array
    distance: Array | None = None  # (N,) m, along a helix or a path
    axes: tuple[Array, ...] = ()  # coordinates of a grid's nodes: x and y of a plane, x, y and z of the workspace
    step: float | None = None  # m, of a workspace's grid whose nodes are still to be counted: no positions yet

    @classmethod
    def workspace(cls, step: float) -> Self:
        """The nodes of a grid of *step*, m, that are in the static workspace of the robot asked about."""
        if not 0.0 < step < float("inf"):
            raise InputError(f"step {step:g} m: a number over 0 is wanted")
        return cls("workspace", np.empty((0, 3)), step=step)

    @classmethod
    def helix(
        cls, robot: Robot, radius: float, pitch: float, low: float, high: float, step: float = HELIX_STEP
    ) -> Self:
        """A helix about the frame's upright middle axis, from height *low* to *high*, with places every *step*, m.

        *radius* and *pitch*, its rise per turn, in m. Raises `InputError` for what is no helix, leaves the frame, or
        has too many places.
        """
        if not (radius > 0.0 and pitch > 0.0 and step > 0.0 and low < high):
            asked = f"{radius:g},{pitch:g},{low:g},{high:g}"
            raise InputError(f"helix {asked}: radius and pitch over 0 and Z0 < Z1 are wanted")
        middle, widest = _middle(robot)
        if radius > widest:
            raise InputError(f"helix radius {radius:g} m: the frame of {robot.name} allows at most {widest:g} m")
        for height in (low, high):
            _require_height(robot, "helix", height)
        turn = float(np.hypot(2.0 * np.pi * radius, pitch))
        length = (high - low) / pitch * turn
        count = _counted(length / step + 1.0)
        distance = np.linspace(0.0, length, count)
        angle = 2.0 * np.pi * distance / turn
        around = middle + radius * np.column_stack([np.cos(angle), np.sin(angle)])
        return cls("helix", np.column_stack([around, np.linspace(low, high, count)]), distance)

    @classmethod
    def plane(cls, robot: Robot, height: float, half_width: float | None, step: float) -> Self:
        """A square of nodes about the frame's middle at a *height*, to *half_width* from it, at most *step* apart, m.

        As wide as the frame where no half-width is given. Raises `InputError` for a plane outside the frame, or too
        many places.
        """
        middle, widest = _middle(robot)
        half_width = widest if half_width is None else half_width
        if not (half_width > 0.0 and 0.0 < step <= 2.0 * half_width):
            raise InputError(f"half-width {half_width:g} m, step {step:g} m: over 0, and the step at most the width")
        if half_width > widest:
            raise InputError(f"half-width {half_width:g} m: the frame of {robot.name} allows at most {widest:g} m")
        _require_height(robot, "plane", height)
        count = _counted(2.0 * half_width / step + 1.0 - 1e-9)
        _counted(float(count) ** 2)
        axes = tuple(centre + np.linspace(-half_width, half_width, count) for centre in middle)
        x, y = np.meshgrid(*axes, indexing="ij")
        positions = np.column_stack([x.ravel(), y.ravel(), np.full(count * count, height)])
        return cls("plane", positions, axes=axes)


def _middle(robot: Robot) -> tuple[Array, float]:
    """The middle (2,) of the frame seen from above, and its distance from the nearest side, m."""
    low, high = np.array(robot.scene.frame_min[:2]), np.array(robot.scene.frame_max[:2])
    return 0.5 * (low + high), float(0.5 * (high - low).min())


def _require_height(robot: Robot, what: str, height: float) -> None:
    low, high = robot.scene.frame_min[2], robot.scene.frame_max[2]
    if not low <= height <= high:
        raise InputError(f"{what} at {height:g} m: the frame of {robot.name} is from {low:g} to {high:g} m high")


def _counted(number: float) -> int:
    """*number* of places, rounded up. Raises `InputError` for too many."""
    if not number <= MAX_PLACES:
        raise InputError(f"{number:.3g} places; at most {MAX_PLACES} are allowed: take a larger step")
    return max(2, int(np.ceil(number)))
