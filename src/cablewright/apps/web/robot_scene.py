"""Scenes of a robot in few states: at rest, at a pose, and of accuracy studies at their worst position."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.analyses.interference import Interference
from cablewright.analyses.modes import Modes
from cablewright.analyses.workspace.workspace import Workspace
from cablewright.apps.quantities import quantity
from cablewright.apps.web.check_scene import extent
from cablewright.apps.web.log_scene import log_scene
from cablewright.apps.web.path_scene import PathScene, Quantity, states_along
from cablewright.apps.web.scene import Mark, SceneBody, SceneDescription
from cablewright.apps.web.viewer_states import States
from cablewright.foundation.results import Pictured
from cablewright.live.replay import Replay, Replays
from cablewright.live.rest_pose import RestPose, rest_pose
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.accuracy import AccuracyStudy
from cablewright.studies.accuracy_at_pose import AccuracyAtPose
from cablewright.studies.interference import JobInterference


def robot_scene(robot: Robot | Model, title: str = "") -> SceneDescription:
    """Return the scene of a robot at rest about the middle of its frame; first a pose within its limits."""
    rest = rest_pose(robot)
    model = rest.equilibrium.model
    count = len(rest.lattice.notes)
    notes = [f"The sliders choose among {count} poses, each solved at rest when the page was written."]
    notes += [] if rest.held else [_sentence(rest.note)]
    told = _with_dead(model.robot, notes)
    return SceneDescription(title or model.robot.name, model.robot, _lattice(rest), notes=told)


def one_state(found: Equilibrium, title: str, note: str) -> SceneDescription:
    """Return the scene of one solved pose, with a *note*."""
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


def scene_of(found: Pictured, title: str) -> SceneDescription | None:
    """Return the scene of a result *found*; None where it has no robot."""
    if isinstance(found, JobInterference) and found.closest is not None:
        return one_state(found.closest.equilibrium[0], title, "where a line is nearest to something, at rest")
    if isinstance(found, Interference | Modes) and found.equilibrium.single:
        return one_state(found.equilibrium, title, "at the requested pose, at rest")
    if isinstance(found, Replay | Replays):
        return log_scene(Path((found if isinstance(found, Replay) else found.first).log))
    robot = found.criterion.model.robot if isinstance(found, Workspace) else getattr(found, "robot", None)
    if not isinstance(robot, Robot):
        return None
    scene = robot_scene(robot, title)
    if isinstance(found, Workspace) and len(found.mesh.triangles):
        scene = scene.with_bodies(SceneBody("workspace", "--space", mesh=found.mesh, opacity=0.35))
    return scene


_REST: Final = "Each state of the slider is an equilibrium at rest of the robot as it is described."


def study_scene(study: AccuracyStudy, title: str) -> SceneDescription:
    """Return the scene of an accuracy study.

    A path or helix is coloured by its largest error. For a plane or the workspace the robot is shown at the position of
    the largest error.
    """
    found = study.accuracy
    places, error = found.wanted_nozzle, found.spread.max_error
    worst = int(np.nanargmax(error))
    x, y, z = places[worst].tolist()
    mark = Mark(f"largest error: {quantity(float(error[worst]), 'm')}", (x, y, z))
    model = Model(found.robot)
    if study.places.distance is None:
        own = one_state(solve_inverse(model, found.wanted[worst]), title, "at the place of the largest error, at rest")
        return replace(own, worst=mark)
    quantities = (
        Quantity.of("max", "largest error", "m", error),
        Quantity.of("nominal", "nominal error", "m", found.nominal_error),
        Quantity.of("height", "height", "m", places[:, 2]),
    )
    count = len(places)
    laid, layer = np.ones(count, dtype=bool), np.ones(count, dtype=int)
    path = PathScene(places, laid, layer, extent(found.robot), quantities, worst=worst)
    states = states_along(model, found.wanted, worst=worst)
    return SceneDescription(title, found.robot, states, path, worst=mark, notes=(_REST,))


def place_scene(found: AccuracyAtPose, title: str) -> SceneDescription:
    """Return the scene of the robot at the pose of an accuracy study."""
    own = solve_inverse(Model(found.accuracy.robot), found.accuracy.wanted[0])
    return one_state(own, title, "at the requested pose, at rest")
