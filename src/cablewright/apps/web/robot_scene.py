"""A robot before any job: its scene at rest, at poses that one chooses by sliders."""

from __future__ import annotations

import numpy as np

from cablewright.apps.web.scene import SceneDescription
from cablewright.apps.web.states import States
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.studies.rest_pose import RestPose, rest_pose


def robot_scene(robot: Robot | Model, title: str = "") -> SceneDescription:
    """The robot at rest about the middle of its frame, by its own statics; first where it holds within its limits."""
    rest = rest_pose(robot)
    model = rest.equilibrium.model
    count = len(rest.lattice.notes)
    notes = [f"The sliders choose among {count} poses, each solved at rest when the page was written."]
    notes += [] if rest.held else [_sentence(rest.note)]
    told = _with_dead(model.robot, notes)
    return SceneDescription(title or model.robot.name, model.robot, _lattice(rest), notes=told)


def one_state(found: Equilibrium, title: str, note: str) -> SceneDescription:
    """The scene of one solved pose, and a *note* on it."""
    robot = found.model.robot
    return SceneDescription(title, robot, States.held(found), notes=_with_dead(robot, [_sentence(note)]))


def _lattice(rest: RestPose) -> States:
    """The states of all poses; tensions only of those that are equilibria."""
    found = rest.lattice.found
    tensions = np.where(found.ok[:, None], found.tensions, np.nan)
    notes = tuple(map(_sentence, rest.lattice.notes))
    return States.held(found, tensions, notes=notes, shown=rest.row, lattice=rest.lattice.axes)


def _with_dead(robot: Robot, notes: list[str]) -> tuple[str, ...]:
    dead = any(line.winch_exit is not None for line in robot.lines)
    return (" ".join([*notes, *(["Between winch and sheave the cable is drawn straight."] if dead else [])]),)


def _sentence(note: str) -> str:
    return f"{note[:1].upper()}{note[1:]}."
