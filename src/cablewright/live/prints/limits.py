"""Path, speeds and limits of a print, from the owner's settings of the machine, checked before anything moves."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

import numpy as np

from cablewright.control import manual
from cablewright.control.guard import UNCOUNTED, GuardSettings
from cablewright.control.height import HeightControl
from cablewright.control.manual import ManualSettings
from cablewright.control.path_follower import TimedPath
from cablewright.control.stop import StopSettings
from cablewright.control.stretch_damping import DampingLoop, StretchDamping, swings_at
from cablewright.control.supervisor import SupervisorSettings
from cablewright.control.swing_damping import SwingDamping
from cablewright.control.velocity import VelocitySettings
from cablewright.control.yaw import YawSettings
from cablewright.foundation.arrays import Array
from cablewright.foundation.choices import HeightRule, LawName
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.live.estimator_settings import with_drum_mass
from cablewright.live.prints import body_limits
from cablewright.live.prints.body_corner_speeds import calmed, told
from cablewright.live.prints.loop import PrintPlan
from cablewright.machine.carried_load import Drum
from cablewright.machine.powder_load import PowderLoad
from cablewright.machine.sensors.barrier import BARRIER
from cablewright.machine.sensors.inertial import INERTIAL
from cablewright.machine.sensors.line_angles import LINE_ANGLES
from cablewright.machine.sensors.tensions import LOAD_CELLS, MOTOR_TORQUES
from cablewright.machine.sensors.yaw_encoder import YAW_ENCODER
from cablewright.machine.settings import MachineSettings
from cablewright.models.inertia import compensates
from cablewright.models.statics import Equilibrium, Model
from cablewright.models.support_table import Capability, require
from cablewright.printing.job import Job
from cablewright.printing.path import Samples
from cablewright.robot import Robot
from cablewright.robot.plausibility import overstretched
from cablewright.solvers.hanging_path import hung
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.swing_free_motion import SLOWEST, SlowestMode

_SPEED_FACTOR: Final = 3.0  # speed limit as a multiple of the job's fastest motion ...
_SWING_SPEED: Final = 0.05  # ... plus this, m/s, for a swinging platform
_BODY_GAIN: Final = 4.0  # 1/s, of a rigid platform's errors: its estimate is by the lengths, and does not swing
_BEYOND: Final = 0.02  # m beyond the frame where the platform's path is the nozzle's, and may begin on the floor
_DRUM_SPEED: Final = 1.2  # of a winch's own limit: where the machine stops
_RAMP_TIMES: Final = (0.05, 0.5)  # s: shortest and longest ramp of a stop
_LOAD_SHARE: Final = 0.5  # share of a line's breaking load at which the machine stops


def path_of(
    robot: Robot,
    job: Job,
    samples: Samples,
    owner: MachineSettings,
    estimator: str,
    law: LawName = "model",
    layers: int | None = None,
) -> TimedPath:
    """Return the path of the first *layers* of a *job*, from its *samples*, for the machine of *owner*.

    Raises `InputError` where robot, job and machine do not fit together.
    """
    body_limits.require_fit(robot, job, owner, law)
    lift = owner.drum.valve if owner.extrusion is not None and owner.drum is not None else 0.0
    path = TimedPath.of(job, layers, lift, robot.platform.own_nozzle, samples, robot)  # a strand's is the nozzle's
    return body_limits.with_tour(path, owner, estimator)


def planned(
    robot: Robot,
    settings: MachineSettings,
    path: TimedPath,
    period: float,
    estimator: str,
    law: LawName,
    rule: HeightRule | None,
    *,
    damps: bool = False,
) -> PrintPlan:
    """Return the plan of a print along *path* in steps of *period*, s, with that *estimator* and control *law*.

    *rule*: rule for the height; None chooses it by the machine's sensors. *damps*: the swing of a drum, where the
    estimator knows its tilt, and swings in which lines stretch, where tensions are measured. Raises `AnswerError` where
    the path leaves the frame or lines cannot hold the platform, `InputError` for a height that the machine cannot keep.
    """
    require(robot, Capability.PRINT)
    model = Model(with_drum_mass(robot, settings))
    notes = path.notes
    manages_slack = model.winches == model.m > model.n and settings.sensor(LINE_ANGLES) is not None
    if path.attitude is None:
        held = _check_path(model, path)
        narrow, told_of = (model, ()) if manages_slack else body_limits.with_margin(model, path, settings)
    else:
        held, linear = body_limits.check_held(model, path)
        body_limits.check_tour(model, path)
        narrow, told_of = body_limits.with_margin(model, path, settings)
        wanted, path = path, calmed(model, narrow, path, settings)
        notes += told(wanted, path)
        body_limits.check_accelerations(path, held, linear)
        body_limits.check_speeds(model, path, settings)
    notes += (*told_of, *overstretched(robot, held.tensions.max(axis=0)))
    path = _calm(model, path)
    begin, scene = path.track.at(0.0).position, robot.scene
    velocity = VelocitySettings(
        narrow,
        settings.winch.max_speed,
        law,
        manage_slack=manages_slack,
        by_lengths=estimator == "encoders",
        lag=settings.winch.lag,
        ages=estimator == "encoders" or path.attitude is not None,
    )
    if path.attitude is not None:
        velocity = replace(velocity, gain=_BODY_GAIN)
    elif damps and settings.body is None and estimator != "encoders" and settings.sensor(INERTIAL) is not None:
        velocity = replace(velocity, swing=_swing(settings.point_drum, scene.gravity))
        notes += ("the swing of the drum is damped: the platform follows it",)
    if damps:
        velocity, how = _stretch_damped(path, settings, velocity)
        notes += how
    yaw = _held_yaw(settings, estimator)
    if yaw is not None:
        notes += (f"the yaw of the drum is held at {math.degrees(yaw.held):.3g} deg by its drive",)
    over_structure = _is_over_structure(rule, settings, estimator, begin[2] > scene.frame_min[2])
    load = PowderLoad.of(settings.carrier)
    return PrintPlan(
        path,
        velocity,
        _limits(robot, settings, path, period),
        _guard(robot, settings, path, period),
        _by_hand(narrow, path, manual.MAX_SPEED - velocity.max_correction),
        HeightControl(float(begin[2]) - scene.frame_min[2]) if over_structure else None,
        load.flow,
        load.full,
        frozenset({"encoders"}),
        beam=body_limits.beam_of(robot, settings),
        yaw=yaw,
        notes=notes,
    )


def _by_hand(model: Model, path: TimedPath, speed: float) -> ManualSettings:
    """Limits of motions by hand: of a rigid platform those of its nozzle, with its origin and nozzle in the frame."""
    scene, attitude, plane = model.robot.scene, path.attitude, model.robot.platform.plane
    low, high = np.array(scene.frame_min), np.array(scene.frame_max)
    if attitude is None:
        limits = scene.frame_min, scene.frame_max, path.acceleration, speed
        return ManualSettings(*limits, period=path.period, plane=plane)

    def holds(place: Array, rotation: Array) -> bool:
        pose = np.concatenate([attitude.origin(place, rotation), rotation])
        return bool(solve_inverse(model, hung(model, pose[None]), path=True).holds[0])

    nozzle = attitude.nozzle
    if plane is not None:  # of the nozzle, at its distance from the origin's plane
        plane = plane.model_copy(update={"distance": plane.distance + float(nozzle @ plane.across)})
    x, y, z = np.maximum(low, low + nozzle).tolist()
    far_x, far_y, far_z = np.minimum(high, high + nozzle).tolist()
    limits = (x, y, z), (far_x, far_y, far_z), path.acceleration, speed
    return ManualSettings(*limits, holds=holds, period=path.period, plane=plane)


def _calm(model: Model, path: TimedPath) -> TimedPath:
    """Return the *path* with the slowest mode's period anywhere in the frame, for motions off the path and pauses.

    As it is where the job does not want its motion shaped, or no mode in the frame is fast enough.
    """
    if path.motion.shaping == "none":
        return path
    scene, begin = model.robot.scene, path.track.at(0.0).position

    def poses(places: Array) -> tuple[Array, Array | None]:
        return body_limits.poses_at(model, path, places)

    corners = np.array(scene.frame_min), np.array(scene.frame_max)
    modes = SlowestMode.within(model, *corners, begin, poses, SLOWEST)
    return path if modes is None else replace(path, period=modes.period_at)


def _swing(drum: Drum, gravity: float) -> SwingDamping:
    """The pendulum of a drum that carries half of its powder at the beginning."""
    powder = 0.5 * drum.powder
    mass, depth = drum.empty_mass + powder, drum.powder_bottom - 0.5 * drum.fill_height(powder)
    centre = (drum.empty_mass * drum.empty_centre + powder * depth) / mass
    square = drum.empty_mass * (drum.empty_centre**2 + drum.empty_gyration[0] ** 2) + powder * depth**2
    return SwingDamping.of(gravity, centre, math.sqrt(square / mass - centre**2))


def _stretch_damped(
    path: TimedPath, settings: MachineSettings, velocity: VelocitySettings
) -> tuple[VelocitySettings, tuple[str, ...]]:
    """Return the *velocity* that damps swings in which lines stretch, as far as it can, and notes of how far.

    It takes measured tensions, of lines that are all taut. Lengths of fewer winches than degrees of freedom, or with
    counterweights, do not hold the platform against its inertia; a drum with several lines cannot follow each.
    """
    model = velocity.model
    sensor = settings.tension_sensor
    sheet = None if sensor is None else settings.sensor(sensor)
    follows = velocity.law == "model" and not (model.n == 3 and velocity.manage_slack)
    if sensor is None or sheet is None or not follows or not compensates(model.robot) or model.robot.sharing:
        return velocity, ()
    late = 1.5 * settings.period + 0.5 / sheet.rate
    found = StretchDamping(sensor.source, DampingLoop(late, settings.winch.lag, velocity.gain))
    poses, retraction = body_limits.poses_at(model, path, body_limits.chosen_places(path))
    held = solve_inverse(model, poses, path=True, retraction=retraction)
    rates = np.concatenate([np.zeros(0), *(each.rates for each in map(swings_at, held) if each is not None)])
    if not (rates > 0.0).any():
        return velocity, ()
    damped, told = found.note(rates[rates > 0.0])
    return (replace(velocity, stretch=found) if damped else velocity), (told,)


def _held_yaw(settings: MachineSettings, estimator: str) -> YawSettings | None:
    """How the drum's yaw is held; None without a drive, or where the estimator does not know it: the drive stands."""
    drive = None if settings.drum is None else settings.drum.yaw_drive
    if drive is None or estimator == "encoders":
        return None
    turn = max(settings.lidars[name].turn for name in ("north", "south") if name in settings.lidars)
    return YawSettings(drive.held, drive.max_speed, drive.travel, turn)


def _is_over_structure(rule: HeightRule | None, settings: MachineSettings, estimator: str, begins_above: bool) -> bool:
    """Whether the height is that over the structure. Raises `InputError` where it cannot be."""
    sees_structure = "vertical" in settings.lidars and estimator != "encoders"
    if rule == "job" or (rule is None and not sees_structure):
        return False
    if not sees_structure:
        raise InputError(
            f"height = structure: estimator {estimator!r} on {settings.name!r} does not measure it; give height = job"
        )
    if not begins_above:
        why = "the path begins on the floor, above which there is no structure to measure; give height = job"
        raise InputError(f"height = structure: {why}")
    return True


def _limits(robot: Robot, settings: MachineSettings, path: TimedPath, period: float) -> SupervisorSettings:
    """The limits at which the machine stops, or waits."""
    fastest, barrier, scene = max(path.print_speed, path.travel_speed), settings.sensor(BARRIER), robot.scene
    beyond = 0.0 if path.attitude is None and path.lift > 0.0 else _BEYOND
    x, y, z = scene.frame_min
    far_x, far_y, far_z = scene.frame_max
    return SupervisorSettings(
        (x - beyond, y - beyond, z - beyond),
        (far_x + beyond, far_y + beyond, far_z + beyond),
        _SPEED_FACTOR * fastest + _SWING_SPEED,
        max_error=max(0.15, fastest) + fastest * period,  # targets are of the beginning of a step
        barrier_timeout=None if barrier is None else max(0.5, 2.5 / barrier.rate, 2.5 * period),
    )


def _guard(robot: Robot, settings: MachineSettings, path: TimedPath, period: float) -> GuardSettings:
    """Limits of the measured quantities. A ramp lasts until the path's acceleration stops its fastest motion."""
    winch, fastest = settings.winch, max(path.print_speed, path.travel_speed)
    low, high = _RAMP_TIMES
    radii = [robot.lines[i].winch.drum_radius for i in robot.hosts]
    timeouts = {"encoders": max(0.5, 2.5 * period)}
    for source in (LOAD_CELLS.source, MOTOR_TORQUES.source, YAW_ENCODER.source):
        if source in settings.sheets:
            timeouts[source] = max(0.5, 2.5 / settings.sheets[source].rate, 2.5 * period)
    return GuardSettings(
        _max_tensions(robot),
        body_limits.least_tensions(robot) if path.attitude is not None else None,
        max_drum_speed=_DRUM_SPEED * winch.max_speed,
        counts_per_radian=winch.counts * winch.ratio / math.tau,
        max_uncounted=np.array([math.inf if radius is None else UNCOUNTED / radius for radius in radii]),
        timeouts=timeouts,
        hosts=None if robot.winches == robot.m else robot.hosts,
        stop=StopSettings(ramp_time=min(max(fastest / path.acceleration, low), high)),
    )


def _max_tensions(robot: Robot) -> Array:
    """Tensions (m,), N, at which the machine stops: the lesser of each line's limit and half of its breaking load."""
    lines = robot.lines
    return np.array(
        [min(line.tension_limits[1], _LOAD_SHARE * (line.cable.breaking_load or math.inf)) for line in lines]
    )


def _check_path(model: Model, path: TimedPath) -> Equilibrium:
    """Return what holds the path. Raises `AnswerError` at its first place out of the frame or that cannot be held."""
    scene, places = model.robot.scene, path.track.positions
    inside = ((places >= scene.frame_min) & (places <= scene.frame_max)).all(axis=1)
    if not inside.all():
        bad = int(np.argmin(inside))
        raise AnswerError(f"the path leaves the frame of {model.robot.name!r} {_where(path, bad)}")
    held = solve_inverse(model, places, path=True)
    if not (good := held.holds).all():
        bad = int(np.argmin(good))
        where = _where(path, bad)
        raise AnswerError(f"the path leaves the workspace of {model.robot.name!r} {where}: {held[bad].sentence()}")
    return held


def _where(path: TimedPath, row: int) -> str:
    place = ", ".join(f"{x:.3f}" for x in path.track.positions[row])
    return f"at {place} m, {path.track.distance[row]:.1f} m along it"
