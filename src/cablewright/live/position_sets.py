"""Nozzle positions to analyse: a plane, a helix, or the whole workspace."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Self

import numpy as np

from cablewright.analyses.workspace.workspace import NodeCount, count_nodes
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.progress import Progress
from cablewright.models.statics import Model
from cablewright.models.support_table import Capability, require
from cablewright.robot import Robot

Shape = Literal["helix", "path", "plane", "workspace"]

MAX_PLACES = 5_000_000
HELIX_STEP = 0.1  # m


@dataclass(frozen=True, eq=False)
class Places:
    """Nozzle positions of a shape, and their order."""

    shape: Shape
    positions: Array  # (N, 3) m
    distance: Array | None = None  # (N,) m, along a helix or a path
    axes: tuple[Array, ...] = ()  # m, coordinates of a grid's nodes: x and y of a plane; x, y and z of the workspace
    step: float | None = None  # m, of the grid of a workspace that has no positions yet: see `workspace_nodes`

    @classmethod
    def workspace(cls, step: float) -> Self:
        """Return the nodes of a grid of *step*, m, in the static workspace of the robot that is analysed later."""
        if not 0.0 < step < float("inf"):
            raise InputError(f"step {step:g} m: must be over 0")
        return cls("workspace", np.empty((0, 3)), step=step)

    @classmethod
    def helix(
        cls, robot: Robot, radius: float, pitch: float, low: float, high: float, step: float = HELIX_STEP
    ) -> Self:
        """Return positions on a helix about the vertical axis through the frame's middle, from *low* to *high*, m.

        *radius*, *pitch* (rise per turn) and *step* (distance between positions) in m. Raises `InputError` for numbers
        that make no helix, a helix that leaves the frame, or too many positions.
        """
        if not (radius > 0.0 and pitch > 0.0 and step > 0.0 and low < high):
            given = f"{radius:g},{pitch:g},{low:g},{high:g}"
            raise InputError(f"helix {given}: requires radius and pitch over 0 and Z0 < Z1")
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
        """Return a square grid of positions about the frame's middle at a *height*, at most *step* apart, m.

        Up to *half_width* from the middle; as wide as the frame if that is None. Raises `InputError` for a plane
        outside the frame, or too many positions.
        """
        middle, widest = _middle(robot)
        half_width = widest if half_width is None else half_width
        if not (half_width > 0.0 and 0.0 < step <= 2.0 * half_width):
            raise InputError(
                f"half-width {half_width:g} m, step {step:g} m: must be over 0, the step at most the width"
            )
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
    """Centre (2,) of the frame seen from above, and its distance from the nearest side, m."""
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


def workspace_nodes(model: Model, step: float, progress: Progress | None = None) -> NodeCount:
    """Count the nodes of a grid of *step* (m) in the static workspace, the platform unrotated.

    Raises `InputError` for a robot with fewer lines than degrees of freedom, `AnswerError` if no node is in the
    workspace.
    """
    require(model, Capability.PATH)
    nodes = count_nodes(model, "static", step=step, progress=progress)
    if not nodes.counted:
        raise AnswerError(
            f"robot {model.robot.name}: no position of a grid with a step of {step:g} m is within all "
            f"limits; give a smaller step"
        )
    return nodes
