"""The scene of a result that has a robot: at the pose of the result, or at rest, with what the result adds."""

from __future__ import annotations

from pathlib import Path

from cablewright.analyses.interference import Interference
from cablewright.analyses.modes import Modes
from cablewright.analyses.workspace.workspace import Workspace
from cablewright.apps.web.log_scene import log_scene
from cablewright.apps.web.robot_scene import one_state, robot_scene
from cablewright.apps.web.scene import SceneBody, SceneDescription
from cablewright.results import Pictured
from cablewright.robot import Robot
from cablewright.studies.interference import JobInterference
from cablewright.studies.replay import Replay, Replays


def scene_of(found: Pictured, title: str) -> SceneDescription | None:
    """Return the scene of *found*; None where it has no robot."""
    if isinstance(found, JobInterference) and found.closest is not None:
        return one_state(found.closest.equilibrium[0], title, "where a line is nearest to something, at rest")
    if isinstance(found, Interference | Modes) and found.equilibrium.single:
        return one_state(found.equilibrium, title, "at the pose that was asked for, at rest")
    if isinstance(found, Replay | Replays):
        first = found if isinstance(found, Replay) else found.first
        return log_scene(Path(first.log))
    robot = found.criterion.model.robot if isinstance(found, Workspace) else getattr(found, "robot", None)
    if not isinstance(robot, Robot):
        return None
    scene = robot_scene(robot, title)
    if isinstance(found, Workspace) and len(found.mesh.triangles):
        scene = scene.with_bodies(SceneBody("workspace", "--space", mesh=found.mesh, opacity=0.35))
    return scene
