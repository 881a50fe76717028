"""Scenes of a path on a robot: of a job, of a check, and of a check's run folder."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
import pyarrow as pa
import pyarrow.parquet

from cablewright.analyses.travel_moves import driven_job
from cablewright.apps.quantities import quantity
from cablewright.apps.web.path_scene import PathScene, Quantity, states_along
from cablewright.apps.web.scene import Mark, SceneDescription
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.memory_mapped import RowExtremes, let_go
from cablewright.foundation.progress import Progress, silent
from cablewright.models.job_poses import along, on_plane, sampled
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.printing.path import MAX_SAMPLES
from cablewright.robot import Robot
from cablewright.solvers.swing_free_motion import JobMotion
from cablewright.studies.checks.path_statics import largest_at
from cablewright.studies.checks.result import Check

MOST_LINES: Final = 12
"""Lines whose tension colours the path: more would make the page large."""

_REST: Final = (
    "Each state of the slider is an equilibrium at rest by the full statics, solved when the page was written; between "
    "states nothing is interpolated."
)


def extent(robot: Robot) -> float:
    """Return the largest side of the drawn robot, m."""
    points = np.array([robot.scene.frame_min, robot.scene.frame_max, *(line.exit_point for line in robot.lines)])
    return float(np.ptp(points, axis=0).max())


def job_scene(robot: Robot, job: Job, progress: Progress = silent) -> SceneDescription:
    """Return the scene of a job on a robot, without a check: its path, and the robot at rest along it."""
    job = on_plane(robot, job)
    toolpath = job.toolpath(progress)
    bead = job.beads(toolpath).typical
    motion = JobMotion.of(robot, *driven_job(robot, job, sampled(robot, job, toolpath)[0], toolpath))
    samples, law = motion.samples, motion.law
    poses, retraction = along(robot, job, samples)
    progress("states along the path", 0, 1)
    states = states_along(Model(robot), poses, retraction=retraction, time=law.time)
    path = PathScene(
        samples.positions,
        samples.extruding,
        samples.layer,
        extent(robot),
        (
            Quantity.of("height", "height", "m", samples.positions[:, 2]),
            Quantity.of("speed", "speed", "m/s", law.speed),
        ),
        law.time,
        samples.line,
        job.move_name,
        (bead.width, bead.height),
    )
    notes = (f"{_REST} Limits were not judged along the path: `cablewright check` does.",)
    return SceneDescription(f"{job.name} on {robot.name}", robot, states, path, notes=notes)


def check_scene(check: Check) -> SceneDescription:
    """Return the scene of a check: its path by error and by tension, and the robot along it."""
    samples, job = check.samples, check.job
    error = check.error_uncompensated
    worst = largest_at(error, samples.extruding)
    columns = {
        "error": error,
        "tensions": check.statics.tensions,
        "speed": check.law.speed,
        "displacement": check.statics.displacement,
        "clearance": None if check.distances is None else check.distances.smallest,
    }
    path = PathScene(
        samples.positions,
        samples.extruding,
        samples.layer,
        extent(check.robot),
        _quantities(check.robot, samples.positions, columns),
        check.law.time,
        samples.line,
        job.move_name,
        (check.beads.typical.width, check.beads.typical.height),
        worst,
    )
    tensions = check.statics.tensions
    states = states_along(
        Model(check.robot),
        check.poses,
        retraction=check.retraction,
        tensions=tensions,
        time=check.law.time,
        worst=worst,
    )
    let_go(check)
    return SceneDescription(
        f"{job.name} on {check.robot.name}",
        check.robot,
        states,
        path,
        worst=_mark(worst, error, samples.positions),
        notes=(_REST,),
    )


def check_folder_scene(robot: Robot, folder: Path) -> SceneDescription:
    """Return the scene of a check from the ``samples.parquet`` in its run folder.

    Raises `InputError` for another file.
    """
    column = _columns(folder / "samples.parquet")
    try:
        positions = _points(column, "")
        tensions = np.stack([column[f"tensions {line.name}"] for line in robot.lines], axis=1)
        error = np.linalg.norm(_points(column, "uncompensated_") - positions, axis=1)
        poses = positions
        if robot.n == 6:
            poses = Model(robot).at_nozzle(np.concatenate([positions, _points(column, "rotation_")], axis=1))
        time, speed, laid = column["time"], column["speed"], column["extruding"].astype(bool)
        layer, line = column["layer"], column["gcode_line"]
    except KeyError as missing:
        raise InputError(
            f"{folder / 'samples.parquet'}: column {missing} is missing; is this the run folder of another robot?"
        ) from None
    worst = largest_at(error, laid)
    columns = {
        "error": error, "tensions": tensions, "speed": speed,
        "displacement": column.get("acceleration_displacement"), "clearance": column.get("clearance"),
    }  # fmt: skip
    path = PathScene(
        positions, laid, layer, extent(robot), _quantities(robot, positions, columns), time, line, worst=worst
    )
    states = states_along(
        Model(robot), poses, retraction=column.get("retraction"), tensions=tensions, time=time, worst=worst
    )
    title = f"{folder.name} on {robot.name}"
    return SceneDescription(title, robot, states, path, worst=_mark(worst, error, positions), notes=(_REST,))


def _columns(file: Path) -> dict[str, Array]:
    """The numbers of a table by column. Raises `InputError` for what is none of a check, or is too large."""
    try:
        with pyarrow.parquet.ParquetFile(file) as table:
            rows = table.metadata.num_rows
            if not 2 <= rows <= MAX_SAMPLES:
                raise InputError(f"{file}: {rows} samples; 2 to {MAX_SAMPLES} are expected")
            found = table.read()
    except (pa.ArrowException, OSError) as reason:
        raise InputError(f"{file}: cannot be read as Parquet: {str(reason).splitlines()[0]}") from None
    numeric = (pa.types.is_floating, pa.types.is_integer, pa.types.is_boolean)
    names = [field.name for field in found.schema if any(kind(field.type) for kind in numeric)]
    return {name: found[name].to_numpy() for name in names}


def _points(column: Mapping[str, Array], prefix: str) -> Array:
    return np.stack([column[f"{prefix}{axis}"] for axis in "xyz"], axis=1)


def _mark(worst: int | None, error: Array, positions: Array) -> Mark | None:
    if worst is None:
        return None
    x, y, z = positions[worst].tolist()
    return Mark(f"largest error: {quantity(float(error[worst]), 'm')}", (x, y, z))


def _quantities(robot: Robot, positions: Array, columns: Mapping[str, Any]) -> list[Quantity]:
    """What colours the path, the error first."""
    tensions: Array = columns["tensions"]
    made = [
        Quantity.of("error", "error without compensation", "m", columns["error"]),
        Quantity.of("lowest", "lowest tension of a line", "N", RowExtremes(np.minimum, tensions), colours="tension"),
        Quantity.of("highest", "highest tension of a line", "N", RowExtremes(np.maximum, tensions), colours="tension"),
        Quantity.of("speed", "speed", "m/s", columns["speed"]),
        Quantity.of("height", "height", "m", positions[:, 2]),
    ]
    if columns["displacement"] is not None:
        made.append(Quantity.of("displacement", "error by motion", "m", columns["displacement"]))
    if columns["clearance"] is not None and np.isfinite(columns["clearance"]).any():
        near = np.where(np.isfinite(columns["clearance"]), columns["clearance"], np.nan)
        made.append(Quantity.of("clearance", "distance of lines from the nearest thing", "m", near))
    if robot.m <= MOST_LINES:
        made += [
            Quantity.of(f"tension {k}", f"tension of {line.name}", "N", tensions[:, k], colours="tension")
            for k, line in enumerate(robot.lines)
        ]
    return made
