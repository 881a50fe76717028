"""Checks of a rigid platform's path before anything moves: frame, equilibria, speeds, accelerations, tensions."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.analyses.accuracy.tension_spread import tension_spread
from cablewright.analyses.steady_acceleration import tensions_by_acceleration
from cablewright.control.path_follower import TimedPath
from cablewright.control.retraction import BeamSettings
from cablewright.estimation.body.creep import ASSUMED, LOOP
from cablewright.foundation.arrays import Array
from cablewright.foundation.choices import LawName
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.machine.description_sigmas import MachineAccuracy
from cablewright.machine.settings import MachineSettings
from cablewright.models.job_poses import require_retractions
from cablewright.models.rotation import matrices
from cablewright.models.statics import Equilibrium, Model
from cablewright.printing.job import Job
from cablewright.robot import Robot
from cablewright.solvers import held_tensions
from cablewright.solvers.hanging_path import hung
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import Linearisation, linearise_where_regular

_LEVEL: Final = 1.96  # standard deviations: of 95 of 100 machines
_TOUR_STEP: Final = 0.2  # m between places of a tour that are checked
_STOPS: Final = 0.5  # share of the least tension under which a print stops


def require_fit(robot: Robot, job: Job, owner: MachineSettings, law: LawName) -> None:
    """Raise `InputError` where robot, job and machine do not fit together."""
    turns = any(step.rotation is not None for step in job.schedule)
    if robot.n == 3:
        if turns:
            raise InputError(f"job {job.name}: schedule sets a rotation; the platform of {robot.name} is a point")
        if robot.platform.plane is not None and owner.drum is not None and owner.drum.valve:
            why = f"must be 0 m: the tool of {robot.name!r} works in its plane"
            raise InputError(f"machine {owner.name!r}: drum.valve = {owner.drum.valve:g} m: {why}")
        return
    if law != "model":
        raise InputError(f"law = {law}: is only for a point platform; the platform of {robot.name!r} is rigid")
    if owner.body is None:
        raise InputError(f"machine {owner.name!r}: has no [body]; the platform of {robot.name!r} is rigid")
    require_retractions(robot, job)
    if owner.retraction is None and any(step.retraction is not None for step in job.schedule):
        raise InputError(f"machine {owner.name!r}: has no [retraction], which the job's schedule moves")


def poses_at(model: Model, path: TimedPath, places: Array) -> tuple[Array, Array | None]:
    """Return poses (k, n) and retraction lengths (k,), or None, with the nozzle at *places* (k, 3), m.

    With fewer winches than degrees of freedom, NaN marks coordinates that equilibrium decides.
    """
    if path.attitude is None:
        return places, None
    schedule, rotations = path.attitude.schedule, path.attitude.rotations(places[:, 2])
    origins = places - matrices(rotations) @ path.attitude.nozzle
    retraction = schedule.retractions(places[:, 2])
    return hung(model, np.concatenate([origins, rotations], axis=1), retraction), retraction


def with_tour(path: TimedPath, owner: MachineSettings, estimator: str) -> TimedPath:
    """Return the path preceded by the machine's tour, if its *estimator* learns from a tour."""
    if path.attitude is None or owner.body is None or estimator == "encoders":
        return path
    return replace(path, tour=np.array(owner.body.tour).reshape(-1, 3))


def tour_places(path: TimedPath) -> Array:
    """Return positions (k, 3), m, along the tour, from the beginning of the path and back to it."""
    begin = path.track.positions[:1]
    corners = np.concatenate([begin, path.tour, begin])
    parts = [
        here + (there - here) * np.linspace(0.0, 1.0, 2 + int(np.linalg.norm(there - here) / _TOUR_STEP))[:, None]
        for here, there in pairwise(corners)
    ]
    return np.concatenate(parts)


def check_tour(model: Model, path: TimedPath) -> None:
    """Raise `AnswerError` at the first position of the tour that is out of the frame or cannot be held."""
    if not len(path.tour):
        return
    poses, retraction = poses_at(model, path, tour_places(path))
    inside, held = _inside(model.robot, poses), solve_inverse(model, poses, path=True, retraction=retraction)
    good = inside & held.holds
    if good.all():
        return
    bad = int(np.argmin(good))
    why = held[bad].sentence() if inside[bad] else "it is out of the frame"
    place = ", ".join(f"{x:.3f}" for x in poses[bad, :3])
    raise AnswerError(f"the machine's [body] tour cannot be held by {model.robot.name!r} at {place} m: {why}")


def _inside(robot: Robot, poses: Array) -> NDArray[np.bool_]:
    """Return which of the *poses* (k, 6) are in the frame (k,)."""
    low, high = robot.scene.frame_min, robot.scene.frame_max
    return np.asarray(((poses[:, :3] >= low) & (poses[:, :3] <= high)).all(axis=1))


def check_held(model: Model, path: TimedPath) -> tuple[Equilibrium, Linearisation]:
    """Return the equilibria along the path, and their linearisation.

    Raises `AnswerError` at the first position that is out of the frame, not held, or where the platform moves freely.
    """
    poses, retraction = poses_at(model, path, path.track.positions)
    inside = _inside(model.robot, poses)
    if not inside.all():
        raise AnswerError(
            f"the path leaves the frame of {model.robot.name!r} {_where(path, poses, int(inside.argmin()))}"
        )
    held = solve_inverse(model, poses, path=True, retraction=retraction)
    if not (good := held.holds).all():
        bad = int(np.argmin(good))
        where = _where(path, poses, bad)
        raise AnswerError(f"{model.robot.name!r} cannot hold the platform on the path {where}: {held[bad].sentence()}")
    linear, codes = linearise_where_regular(held)
    if codes.any():
        bad = int(np.flatnonzero(codes)[0])
        raise AnswerError(f"the platform can move without any line resisting {_where(path, held.pose, bad)}")
    return held, linear


def check_accelerations(path: TimedPath, held: Equilibrium, linear: Linearisation) -> None:
    """Raise `AnswerError` where the path's acceleration needs tensions beyond the lines' limits."""
    size = path.acceleration * tensions_by_acceleration(held, linear)
    left = held.tensions - size
    if not (left > 0.0).all():
        bad, line = divmod(int(np.argmin(left)), left.shape[1])
        raise AnswerError(
            f"line {held.model.robot.lines[line].name} would fall slack under {path.acceleration:g} m/s^2 "
            f"{_where(path, held.pose, bad)}: {held.tensions[bad, line]:.0f} N less {size[bad, line]:.0f} N"
        )


def check_speeds(model: Model, path: TimedPath, settings: MachineSettings) -> None:
    """Raise `InputError` for a path too fast for the winches or the retraction."""
    fastest = max(path.print_speed, path.travel_speed)
    radius = min(line.winch.drum_radius or math.inf for line in model.robot.lines)
    fastest_cable = fastest * max(line.advantage for line in model.robot.lines)  # ... of a nozzle that does not turn
    if fastest_cable / radius > settings.winch.max_speed:
        why = f"{fastest_cable / radius:.3g} rad/s of a drum; at most {settings.winch.max_speed:g} is possible"
        raise InputError(f"the path is too fast for the winches: {fastest:g} m/s takes {why}")
    assert path.attitude is not None
    lengths = path.attitude.schedule.retractions(path.track.positions[:, 2])
    if lengths is None or settings.retraction is None:
        return
    time = np.maximum(np.diff(path.arrival), 1e-9)
    speeds = np.abs(np.diff(lengths)) / time
    worst = int(np.argmax(speeds))
    if speeds[worst] > settings.retraction.max_speed:
        where = f"at {path.track.distance[worst]:.1f} m along the path"
        most = settings.retraction.max_speed
        raise InputError(f"the schedule retracts by {speeds[worst]:.3g} m/s {where}; at most {most:g} is possible")


def chosen_places(path: TimedPath) -> Array:
    """Return positions (k, 3), m, of the tour and along the path, at which tensions are checked."""
    places = path.track.positions[held_tensions.chosen_rows(len(path.track.positions))]
    return np.concatenate([tour_places(path), places]) if len(path.tour) else places


def with_margin(model: Model, path: TimedPath, settings: MachineSettings) -> tuple[Model, tuple[str, ...]]:
    """Return the model with narrower tension limits, which control keeps along the whole path and tour.

    See `held_tensions`. Where nothing measures tensions they are kept as far from the limits as the machine's accuracy
    moves them, or as far as lines allow; notes say which.
    """
    if model.robot.winches <= model.freedoms:
        return model, ()
    poses, retraction = poses_at(model, path, chosen_places(path))
    off, fall = _unmeasured(settings, solve_inverse(model, poses, path=True, retraction=retraction))
    narrow, share = held_tensions.with_margin(model, poses, retraction, off + fall, off)
    return narrow, _told_of(off + fall, share)


def _unmeasured(settings: MachineSettings, held: Equilibrium) -> tuple[Array, Array]:
    """Return by how much tensions of 95 of 100 machines differ at most from those of *held*, and fall: (m,), N.

    Zeros where tensions are measured, so that the control holds them; of a plane, whose lines pull against each other
    as hard as they may; and where the path is not held.
    """
    if settings.tension_sensor is not None or held.model.robot.platform.plane is not None or not held.ok.all():
        return np.zeros(held.model.m), np.zeros(held.model.m)
    known = settings.accuracy or MachineAccuracy()
    stretch = (known.hysteresis or LOOP) + (known.creep or ASSUMED)
    found = tension_spread(held, known.home_length, known.drum_radius, known.exit_point, stretch)
    return _LEVEL * found.deviation.max(axis=0), np.maximum(found.fall.max(axis=0), 0.0)


def _told_of(off: Array, share: float) -> tuple[str, ...]:
    """Return what is to be known of tensions that nothing measures, of which a *share* of *off* (m,), N, is kept."""
    if not off.any():
        return ()
    size = f"nothing measures tensions: by the machine's accuracy they are up to {off.max():.0f} N from the chosen ones"
    if share == 1.0:
        return (f"{size}, which are so far within their limits",)
    return (f"{size}, which cannot be so far within their limits: measure tensions, or home the lines better",)


def least_tensions(robot: Robot) -> Array:
    """Return the tensions (m,), N, below which a print stops."""
    return np.array([_STOPS * line.tension_limits[0] for line in robot.lines])


def beam_of(robot: Robot, settings: MachineSettings) -> BeamSettings | None:
    """Return the settings of the retraction's drive; None without one."""
    return None if settings.retraction is None else BeamSettings.of(robot, settings.retraction.max_speed)


def _where(path: TimedPath, poses: Array, row: int) -> str:
    x, y, z, *turn = poses[row].tolist()
    turned = math.degrees(math.hypot(*turn))
    by = f", turned by {turned:.1f} deg" if turned else ""
    return f"at {x:.3f}, {y:.3f}, {z:.3f} m{by}, {path.track.distance[row]:.1f} m along it"
