"""Accuracy over a shape: places, a helix, a job's path, a plane, the whole workspace."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Literal, Self, Unpack

import numpy as np
from numpy.typing import NDArray

from cablewright.analyses.accuracy.nozzle_error import Accuracy, AccuracyOptions, AccuracyQuestion
from cablewright.analyses.sheave_ratio import SheaveRule, sheave_rules
from cablewright.analyses.workspace.boundary_limits import BoundaryLimits, boundary_limits
from cablewright.analyses.workspace.workspace import count_nodes
from cablewright.errors import AnswerError, InputError, Status
from cablewright.printing.job import Job
from cablewright.robot import Robot
from cablewright.robot.uncertainty import Range
from cablewright.studies.job_poses import along

__all__ = [
    "Places",
    "Study",
    "accuracy_over",
    "accuracy_over_job",
    "accuracy_over_workspace",
]

Array = NDArray[np.float64]
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


@dataclass(frozen=True, eq=False)
class Study:
    """How far off the machine is over a shape. Rows of `accuracy` are its places: of a workspace, those reached."""

    places: Places
    accuracy: Accuracy
    workspace: BoundaryLimits | None  # where the shape is the workspace
    rules: tuple[SheaveRule, ...]

    def summary(self) -> dict[str, object]:
        """The figures of the command line's JSON, SI."""
        found, spread = self.accuracy, self.accuracy.spread
        ok = found.ok
        low, high = int(np.nanargmin(spread.max_error)), int(np.nanargmax(spread.max_error))
        values: dict[str, object] = {
            "shape": self.places.shape,
            "robot": found.robot.name,
            "compensation": found.compensation,
            "parameters": [each.parameter.label for each in found.ranges],
            "places": len(ok),
            "answered": int(ok.sum()),
            "refused": {
                Status.of(int(code)).word: int((found.codes == code).sum()) for code in np.unique(found.codes) if code
            },
            "nominal_error": float(np.nanmax(found.nominal_error)),
            "max_error": float(spread.max_error[high]),
            "max_error_at": found.wanted_nozzle[high],
            "max_error_values": spread.worst_values[high],
            "smallest_max_error": float(spread.max_error[low]),
            "smallest_max_error_at": found.wanted_nozzle[low],
            "difference": float(np.nanmax(found.difference)),
            "max_deviation": float(np.nanmax(spread.max_deviation)),
            "lowest_error": np.nanmin(spread.low, axis=0),
            "highest_error": np.nanmax(spread.high, axis=0),
            "max_horizontal_error": float(np.nanmax(np.linalg.norm(found.worst_offset[:, :2], axis=1))),
            "max_vertical_error": float(np.nanmax(np.abs(found.worst_offset[:, 2]))),
            "max_turn": float(np.nanmax(spread.max_turn)),
            "nonlinearity": float(np.nanmax(spread.nonlinearity)),
            "unsolved": int(spread.unsolved.sum()),
            "contributions": self._contributions(),
            "sheave_rules": [rule.__dict__ for rule in self.rules],
        }
        if self.workspace is not None:
            ends = [asdict(each) for each in self.workspace.by_limit]
            values |= {"volume": self.workspace.nodes.trapezoid_volume, "ends": ends}
        return values

    def _contributions(self) -> list[dict[str, object]]:
        """Each number's own effect, the largest of any place, most first."""
        sizes = np.nanmax(np.linalg.norm(self.accuracy.spread.effects, axis=1), axis=0)
        labels = [each.parameter.label for each in self.accuracy.ranges]
        return [{"parameter": labels[k], "effect": float(sizes[k])} for k in np.argsort(-sizes, kind="stable")]


def accuracy_over(
    robot: Robot, places: Places, ranges: Sequence[Range] | None = None, **options: Unpack[AccuracyOptions]
) -> Study:
    """How far off *robot* is at *places*, its platform unrotated; *ranges* and *options* as of `accuracy`.

    Raises `InputError` for a robot whose lines do not hold all its freedoms, `AnswerError` where it can be at none of
    the places.
    """
    asked = _of_shape(AccuracyQuestion.of(robot, ranges, **options))
    return _studied(asked, places, asked.model.unrotated_at(places.positions))


def accuracy_over_job(
    robot: Robot, job: Job, ranges: Sequence[Range] | None = None, **options: Unpack[AccuracyOptions]
) -> Study:
    """`accuracy_over`, with its *options*, the samples of a job's path, held as its schedule has it."""
    asked = _of_shape(AccuracyQuestion.of(robot, ranges, **options))
    samples = job.samples(job.toolpath(asked.progress))
    return _studied(asked, Places("path", samples.positions, samples.distance), *along(robot, job, samples))


def accuracy_over_workspace(
    robot: Robot, step: float, ranges: Sequence[Range] | None = None, **options: Unpack[AccuracyOptions]
) -> Study:
    """`accuracy_over`, with its *options*, the nodes of a grid of *step* (m) that are in the static workspace."""
    asked = _of_shape(AccuracyQuestion.of(robot, ranges, **options))
    nodes = count_nodes(asked.model, "static", step=step, progress=asked.progress)
    if not nodes.counted:
        raise AnswerError(f"robot {robot.name}: no place of a grid of {step:g} m is within all limits")
    places = Places("workspace", nodes.places, axes=nodes.axes)
    found = _studied(asked, places, asked.model.unrotated_at(places.positions))
    return replace(found, workspace=boundary_limits(nodes))


def _of_shape(asked: AccuracyQuestion) -> AccuracyQuestion:
    """The question itself. Raises `InputError` where no shape can be gone through unrotated."""
    robot = asked.model.robot
    if robot.m < robot.n:
        raise InputError(f"robot {robot.name}: {robot.m} lines cannot hold {robot.n} freedoms over a shape")
    return asked


def _studied(asked: AccuracyQuestion, places: Places, poses: Array, retraction: Array | None = None) -> Study:
    """The study of *poses* (N, n) that bring the nozzle to *places*."""
    found = asked.answer(asked.hold(poses, retraction))
    robot = found.robot
    if not np.isfinite(found.spread.max_error).any():
        raise AnswerError(f"robot {robot.name}: at no place do the uncertain numbers leave an equilibrium")
    return Study(places, found, None, sheave_rules(robot))
