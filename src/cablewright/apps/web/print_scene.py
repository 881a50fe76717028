"""The scene of a print's record: its thinned steps, and the printed structure."""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.apps.web.motion_scene import Gone, MotionSteps, motion_scene
from cablewright.apps.web.path_scene import chosen
from cablewright.apps.web.scene import SceneBody, SceneDescription
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import PrintState
from cablewright.foundation.triangle_mesh import TriangleMesh
from cablewright.live.prints.result import PrintRecord
from cablewright.live.prints.steps_table import in_state
from cablewright.models.rotation import matrices
from cablewright.printing.heightfield import HeightField

_PLATE: Final = 0.01  # m that a mesh of the structure goes below the floor, so that bare floor is a body too
_MOST_FACES: Final = 60_000  # of the structure in the view


def print_scene(found: PrintRecord, title: str) -> SceneDescription | None:
    """Return the scene of a print; None where no position is known."""
    rows = found.rows
    valid = rows["valid"] == 1.0
    told = np.where(valid[:, None], rows["position"], np.nan)
    if not (np.isfinite(told).any() or np.isfinite(rows["true_position"]).any()):
        return None
    printing = in_state(rows, PrintState.PRINTING)
    layer = np.nan_to_num(rows["layer"]).astype(int)
    nozzle, rigid = np.array(found.head.nozzle), found.head.robot.n == 6
    to_nozzle, to_origin = (0.0, -1.0) if rigid else (1.0, 0.0)  # a record has the nozzle of a body, else the origin
    gone = Gone(
        rows["time"],
        _moved(rows["true_position"], rows["true_rotation"], to_nozzle * nozzle),
        _moved(told, rows["rotation"], to_nozzle * nozzle),
        layer,
        printing,
    )
    at = chosen(len(rows))
    some, own = rows[at], told[at]
    moments = MotionSteps(
        time=some["time"],
        true=_poses(_moved(some["true_position"], some["true_rotation"], to_origin * nozzle), some["true_rotation"]),
        told=_poses(_moved(own, some["rotation"], to_origin * nozzle), some["rotation"]),
        lengths=some["true_lengths"],
        tensions=some["tensions"],
        covariances=np.full((len(some), 3, 3), np.nan),
    )
    return motion_scene(title, found.head, gone, moments, bodies=_structure(found))


def structure_mesh(field: HeightField, found: PrintRecord) -> TriangleMesh:
    """The structure about the path as a body on a plate; unscanned parts are floor."""
    low = np.maximum(field.cells_of(found.track.positions[:, :2].min(axis=0)[None] - 0.5)[0], 0)
    high = np.minimum(field.cells_of(found.track.positions[:, :2].max(axis=0)[None] + 0.5)[0] + 1, field.shape)
    corner = (field.low[0] + field.cell * int(low[0]), field.low[1] + field.cell * int(low[1]))
    part = np.nan_to_num(field.heights[low[0] : high[0], low[1] : high[1]], nan=0.0)
    return HeightField(corner, field.cell, part).solid(-_PLATE)


def _structure(found: PrintRecord) -> list[SceneBody]:
    """The surface of the structure, where it is higher than the floor; none that is too large for a page."""
    if found.structure is None or found.structure.best is None:
        return []
    whole = structure_mesh(found.structure.best, found)
    above = whole.corners[..., 2].max(axis=1) > 1e-4
    if not 0 < int(above.sum()) <= _MOST_FACES:
        return []
    return [SceneBody("structure", "--structure", mesh=TriangleMesh.of_corners(whole.corners[above]))]


def _moved(positions: Array, rotations: Array, offset: Array) -> Array:
    """Places (k, 3), m, of a point at *offset* (3,), m, in a platform's frame; a rotation that is not known is none."""
    return np.asarray(positions + matrices(np.nan_to_num(rotations)) @ offset)


def _poses(positions: Array, rotations: Array) -> Array:
    """Poses (k, 6); a rotation that is not known is none."""
    return np.concatenate([positions, np.nan_to_num(rotations)], axis=1)
