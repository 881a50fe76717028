"""Checks, before any fit, whether the data are sufficient to calibrate a robot."""

from __future__ import annotations

import math

import numpy as np

from cablewright.calibration.measurement_rows.load_cells import require_tensions
from cablewright.calibration.measurement_rows.positions import check_plane
from cablewright.calibration.measurements import SENSORS, Measured
from cablewright.calibration.plan import STRETCH
from cablewright.calibration.poses.problem import CalibrationProblem
from cablewright.calibration.poses.ranges_of_unknowns import OF_NOTHING, SHARES
from cablewright.calibration.unknowns import unknowns_of
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.models.parameters import lines_of
from cablewright.robot import Eyelet, Robot

_APART = 1e-3  # m: poses with smaller differences in all lengths count as one
_MOVED = 0.01  # m, and ...
_BEYOND = 5.0  # ... sigmas of a position, from which on a platform has moved
_REPEATS = 2  # positions with counts that were read elsewhere: one may be wrong itself
_UP = 2  # the world's axis along which gravity acts
_THREE = 3  # measured positions that fix place and direction
_FAR = 3.0  # diagonals of the frame: max length change, and max distance of a pose from its centre


def check_lengths(robot: Robot, measured: Measured) -> None:
    """Raise `InputError` for lengths or poses too large for their unit, and for poses outside the plane."""
    scene = robot.scene
    diagonal = math.dist(scene.frame_min, scene.frame_max)
    hosts = list(robot.hosts)
    spans = np.array([float(robot.lines[i].advantage) for i in hosts])
    _check_size(measured, measured.counted[:, hosts], [f"dl_{i + 1}" for i in hosts], diagonal, spans=spans)
    if measured.guess is not None:
        middle = 0.5 * (np.array(scene.frame_min) + np.array(scene.frame_max))
        _check_size(measured, measured.guess[:, :3] - middle, ["x", "y", "z"], diagonal, middle)
    check_plane(robot, measured)


def _check_size(
    measured: Measured,
    values: Array,
    names: list[str],
    diagonal: float,
    middle: Array | None = None,
    spans: Array | float = 1.0,
) -> None:
    large = np.argwhere(np.abs(values) > _FAR * diagonal * spans)
    if not len(large):
        return
    pose, column = (int(at) for at in large[0])
    value = float(values[pose, column] + (0.0 if middle is None else middle[column]))
    others = [name for at, name in enumerate(names) if at not in large[:, 1]]
    mixed = f"; {', '.join(others)} look like m: are units mixed?" if others else ""
    raise InputError(
        f"{measured.origin}, {measured.place(pose)}: {names[column]} = {value:g} m, but the frame's diagonal is "
        f"{diagonal:.3g} m: are these mm? then name the column '{names[column]} (mm)'{mixed}"
    )


def gauge_size(problem: CalibrationProblem) -> int:
    """Return how many coordinates of world and platform frame the machine's own sensors leave undetermined."""
    names = {each.name for each in problem.unknowns}
    if "exit_point" not in names or problem.measured.positioned >= _THREE:
        return 0
    sees_gravity = problem.measured.tensions is not None or problem.elastic
    tiltable = all(isinstance(line.sheave, Eyelet) for line in problem.robot.lines) and not sees_gravity
    plane = problem.robot.platform.plane
    if plane is not None:  # two translations, and the turn about the normal
        return (3 if tiltable or plane.axis == _UP else 2) + (3 if "platform_point" in names else 0)
    return (6 if tiltable else 4) + (6 if "platform_point" in names else 0)


def surplus_per_pose(problem: CalibrationProblem) -> int:
    """Return the smallest number of measurements of a pose less the number of its unknowns."""
    return int(problem.row_counts.min()) - problem.unknowns_per_pose


def min_poses(problem: CalibrationProblem) -> int:
    """Return how many different poses determine all unknowns but those of the frames.

    Unknowns that no measurement determines do not count: zeros of sensors that did not measure. Raises `InputError`
    where no number of poses is enough.
    """
    surplus = surplus_per_pose(problem)
    if surplus < 1:
        m, n = problem.robot.m, problem.robot.freedoms
        why = f"{m} lines measure {m} lengths of a pose with {n} degrees of freedom"
        more = "measure more"
        if problem.elastic:
            why = f"for elastic lines {m} lengths determine pose and tensions, and encoders measure those {m} lengths"
            more = "measure tensions (f_1 .., even roughly, with their sigma.tension) or poses (x .. with sigma_x ..)"
        raise InputError(
            f"{problem.measured.origin}: {why}: there are no redundant measurements for the calibration; {more}"
        )
    rows = problem.row_counts
    given = len(problem.rows.linear) + len(problem.values) - problem.poses * problem.per_pose
    given += int((rows - rows.min()).sum())  # positions at some poses, contacts
    told = sum(_lacks(problem, each.name) is None for each in problem.unknowns)
    return max(1, -(-(told - gauge_size(problem) - given) // surplus))


def _lacks(problem: CalibrationProblem, unknown: str) -> str | None:
    """Return the column without which no data determine an *unknown*: that of its sensor, or of the lines' load."""
    by_loads = unknown == "exit_compliance" and not problem.elastic
    sensor = "tension" if by_loads else unknown.partition("_")[0]
    return SENSORS[sensor][1] if sensor in SENSORS and not problem.measured.has(sensor) else None


def line_with_counted_build_up(problem: CalibrationProblem) -> str | None:
    """Return the first line whose file has a build-up on the drum that the lengths contain already."""
    wound = (line.name for line in problem.robot.lines if line.winch.build_up is not None)
    return None if problem.measured.by_drum else next(wound, None)


def _check_known(problem: CalibrationProblem) -> None:
    """Raise `InputError` for a ``[[known]]`` number of a part that the robot lacks, or of a sensor without readings."""
    for at, known in enumerate(problem.plan.known):
        if known.name == STRETCH or not (known.value is not None or known.deviation):
            continue
        try:
            unknowns_of(problem.robot, (known.name,), elastic=problem.elastic)
        except InputError as error:
            raise InputError(f"known[{at}]: {str(error).removeprefix('unknowns: ')}") from None
        low, high = (SHARES | OF_NOTHING).get(known.name, (-math.inf, math.inf))
        if known.value is not None and not low <= known.value <= high:
            raise InputError(f"known[{at}]: value = {known.value:g} of {known.name}: must be {low:.4g} to {high:.4g}")
        column = _lacks(problem, known.name)
        if column is not None:
            raise InputError(
                f"known[{at}]: {known.name}: {problem.measured.origin} has no column {column}; leave it out"
            )


def _check_repeats(problem: CalibrationProblem) -> None:
    """Raise `InputError` for a copied row, and for counts that stay the same while the positions differ.

    A copy measures nothing new; only rows that are all zero, at home, may repeat. Counts must change when the platform
    moves, if the lines hold it. If only one row contradicts that, its position may be wrong: outlier rejection decides.
    """
    measured, robot = problem.measured, problem.robot
    others = [values for name, _ in SENSORS.values() if (values := getattr(measured, name)) is not None]
    if measured.pose_sigma is not None and measured.guess is not None:
        others.append(np.where(np.isnan(measured.pose_sigma), np.nan, measured.guess))
    table = np.column_stack([measured.counted, *(np.nan_to_num(each) for each in others)])
    first = dict[bytes, int]()
    for pose, row in enumerate(table + 0.0):
        before = first.setdefault(row.tobytes(), pose)
        if before != pose and row.any():
            raise InputError(
                f"{measured.origin}, {measured.place(pose)}: repeats all measurements of {measured.place(before)}; a "
                f"copied row is no new measurement: delete it"
            )
    if measured.pose_sigma is None or measured.guess is None or robot.winches < robot.freedoms:
        return
    counts, again = dict[bytes, int](), 0
    for pose in np.flatnonzero(np.isfinite(measured.pose_sigma[:, :3]).all(axis=1)).tolist():
        before = counts.setdefault((measured.counted[pose] + 0.0).tobytes(), pose)
        away = float(np.linalg.norm(measured.guess[pose, :3] - measured.guess[before, :3]))
        again += away > _MOVED + _BEYOND * float(measured.pose_sigma[[pose, before], :3].max())
        if again >= _REPEATS:
            raise InputError(
                f"{measured.origin}, {measured.place(pose)}: repeats the counts of {measured.place(before)}, but its "
                f"position is {away:.3g} m away: did encoders stop, or were rows pasted? Measure it again, or delete it"
            )


def check(problem: CalibrationProblem) -> None:
    """Raise `InputError` for too few or too similar poses, and for unknowns that only a missing sensor determines."""
    measured, count = problem.measured, problem.poses
    for name in problem.plan.unknowns:
        column = _lacks(problem, name)
        if column is not None:
            raise InputError(f"unknowns: {name}: {measured.origin} has no column {column}, so no data determine it")
    for each in problem.unknowns:
        sensor = each.name.partition("_")[0]
        if sensor not in ("tension", "swivel") or any(prior.is_of(each) for prior in problem.plan.priors):
            continue
        if np.isnan(getattr(measured, SENSORS[sensor][0])[:, lines_of(problem.robot, each)]).all():
            raise InputError(f"unknowns: {each.label}: {measured.origin} has no reading of it; give it a prior")
    _check_known(problem)
    _check_repeats(problem)
    wound = line_with_counted_build_up(problem)
    of_drums = (each.name == "build_up" and each.value is not None for each in problem.plan.known)
    said = next((f"known[{at}]" for at, each in enumerate(of_drums) if each), "unknowns")
    if wound is not None and (said != "unknowns" or "build_up" in problem.plan.unknowns):
        raise InputError(
            f"{said}: build_up: {measured.origin} has lengths, in which the winch.build_up of line {wound!r} is "
            "counted already; give turns of the drum, as in 'dl_1 (turns)', or leave build_up out"
        )
    if not problem.elastic:
        require_tensions(problem.robot, measured)
    needed = min_poses(problem)
    why = (
        f"each pose gives {problem.row_counts.min()} numbers and has {problem.unknowns_per_pose} unknowns, and "
        f"{len(problem.unknowns)} unknowns of the robot less {gauge_size(problem)} that stay open must be found"
    )
    if count < needed:
        raise InputError(f"{measured.origin}: {count} poses; at least {needed} are required: {why}")
    left, different = measured.counted, 0
    while len(left) and different < needed:
        left, different = left[np.abs(left - left[0]).max(axis=1) > _APART], different + 1
    if different < needed:
        raise InputError(
            f"{measured.origin}: only {different} of {count} poses differ by over {_APART * 1e3:g} mm in any line; at "
            f"least {needed} different ones are required: {why}"
        )
