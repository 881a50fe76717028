"""Scenes of accuracy studies: the places that were looked at, coloured by their error, and the robot at the worst."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from cablewright.apps.quantities import quantity
from cablewright.apps.web.check_scene import extent
from cablewright.apps.web.path_scene import PathScene, Quantity
from cablewright.apps.web.path_states import states_along
from cablewright.apps.web.robot_scene import one_state
from cablewright.apps.web.scene import Mark, SceneDescription
from cablewright.models.statics import Model
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.accuracy import AccuracyStudy
from cablewright.studies.accuracy_at_pose import AccuracyAtPose

_REST: Final = "Each state of the slider is an equilibrium at rest of the robot as it is described."


def study_scene(study: AccuracyStudy, title: str) -> SceneDescription:
    """A path or helix in the colours of its largest error; of a plane or the workspace the robot at the worst place."""
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
    """The robot at the pose."""
    own = solve_inverse(Model(found.accuracy.robot), found.accuracy.wanted[0])
    return one_state(own, title, "at the pose that was asked for, at rest")
