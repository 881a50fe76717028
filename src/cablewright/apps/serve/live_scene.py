"""The 3-D view of a running machine: its scene, and its lines with their present shapes from statics."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from cablewright.analyses.line_shapes import polylines
from cablewright.analyses.travel_moves import driven_job
from cablewright.apps.web.check_scene import extent
from cablewright.apps.web.detail_levels import packed
from cablewright.apps.web.motion_scene import drum_of, walls_of
from cablewright.apps.web.path_scene import PathScene, Quantity
from cablewright.apps.web.robot_scene import one_state
from cablewright.apps.web.scene import STEPS, SceneDescription
from cablewright.foundation.arrays import Array
from cablewright.live.logged_line_shapes import hanging_lines
from cablewright.live.rest_pose import rest_pose
from cablewright.machine.log.head import LogHead
from cablewright.models.job_poses import on_plane
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.robot import Robot
from cablewright.solvers.swing_free_motion import JobMotion

POINTS: Final = 14
"""Points of a line."""

_FINE: Final = 2000.0  # chords are so many times nearer to a line than the frame is large
_MOST: Final = 400_000  # points of a path that is drawn


def live_scene(head: LogHead, job: Job | None = None) -> dict[str, Any]:
    """Return the scene of an operated robot, and of the path of its job, as a JSON object."""
    robot = head.robot
    at_rest = rest_pose(robot)
    rest = one_state(at_rest.equilibrium, robot.name, at_rest.note)
    path = None if job is None else _path(robot, job)
    scene = SceneDescription(robot.name, robot, rest.states, path, walls=walls_of(head), drum=drum_of(head))
    made = scene.as_dict()
    low, high = (np.array(each) for each in scene.bounds)
    step = max(float((high - low).max()), 1e-9) / STEPS
    curves = np.stack(
        [_thinned(each, line.exit_point) for each, line in zip(rest.states.curves[0], robot.lines, strict=True)]
    )
    made["frames"]["curves"] = packed(np.clip(np.round((curves[None] - low) / step), 0, STEPS), "u16", delta=True)
    made["frames"]["samples"] = None if path is None else packed(np.zeros(1), "u32")
    made["frames"]["layers"] = made["frames"]["fileLines"] = None
    limits = np.array([line.tension_limits for line in robot.lines])
    made["tension_scale"] = {
        "low": float(limits[:, 0].min()),
        "high": float(limits[:, 1].max()),
        "limits": "of each line",
    }
    return made


def _path(robot: Robot, job: Job) -> PathScene | None:
    job = on_plane(robot, job)
    toolpath = job.toolpath()
    motion = JobMotion.of(robot, *driven_job(robot, job, toolpath=toolpath))
    samples, law = motion.samples, motion.law
    if len(samples.positions) > _MOST:
        return None
    quantities = (
        Quantity.of("height", "height", "m", samples.positions[:, 2]),
        Quantity.of("speed", "planned speed", "m/s", law.speed),
    )
    bead = job.beads(toolpath).typical
    places, laid, layer = samples.positions, samples.extruding, samples.layer
    return PathScene(
        places, laid, layer, extent(robot), quantities, None, samples.line, job.move_name, (bead.width, bead.height)
    )


def _thinned(curve: Array, end: Any) -> Array:
    """A curve (k, 3) as `POINTS` points along its length; a point where there is none."""
    if len(curve) < 2:
        return np.repeat(np.array(end, dtype=float)[None], POINTS, axis=0)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    at = np.linspace(0.0, along[-1], POINTS)
    return np.stack([np.interp(at, along, column) for column in curve.T], axis=1)


class Shapes:
    """Shapes of one machine's lines, as points on the grid of its scene."""

    def __init__(self, head: LogHead, scene: dict[str, Any]) -> None:
        """Draw on the grid of a *scene*."""
        self.robot, self.model = head.robot, Model(head.robot)
        frame = np.subtract(head.robot.scene.frame_max, head.robot.scene.frame_min)
        self._tolerance = float(frame.max()) / _FINE
        self.low, high = np.array(scene["bounds"]["low"]), np.array(scene["bounds"]["high"])
        self.step = max(float((high - self.low).max()), 1e-9) / STEPS

    def curves(self, state: dict[str, Any]) -> list[int] | None:
        """Return the points of all lines, as numbers of the grid; None where they are unknown."""
        platform, lengths = state["platform"], state["lines"]["lengths"]
        pose = np.array([*platform["position"], *platform["rotation"]], dtype=float)[: self.robot.n]
        if lengths is None or not np.isfinite(pose).all() or None in lengths:
            return None
        states = hanging_lines(self.model, pose[None], np.array([lengths]))[0]
        drawn = polylines(self.model.packed, pose, states, self._tolerance)
        points = np.stack([_thinned(each, line.exit_point) for each, line in zip(drawn, self.robot.lines, strict=True)])
        return [int(each) for each in np.clip(np.round((points - self.low) / self.step), 0, STEPS).ravel()]
