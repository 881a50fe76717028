"""A robot before any job: its scene at rest."""

from __future__ import annotations

from cablewright.apps.web.scene import SceneDescription
from cablewright.apps.web.states import States
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.studies.rest_pose import rest_pose


def robot_scene(robot: Robot | Model, title: str = "") -> SceneDescription:
    """The robot at rest near the middle of its frame, by its own statics."""
    rest = rest_pose(robot)
    return one_state(rest.equilibrium, title or rest.equilibrium.model.robot.name, rest.note)


def one_state(found: Equilibrium, title: str, note: str) -> SceneDescription:
    """The scene of one solved pose, and a *note* on it."""
    states = States.held(found)
    dead = any(line.winch_exit is not None for line in found.model.robot.lines)
    notes = [note[:1].upper() + note[1:] + "."]
    if dead:
        notes.append("Between winch and sheave the cable is drawn straight.")
    return SceneDescription(title, found.model.robot, states, notes=(" ".join(notes),))
