"""The plan of a print: from robot, job, machine and options to a checked plan."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Final, get_args

import numpy as np

from cablewright.arrays import Array
from cablewright.choices import HeightRule, LawName, PlantName
from cablewright.control.guard import GuardSettings
from cablewright.control.guide import TimedPath
from cablewright.control.height import HeightControl
from cablewright.control.manual import ManualSettings
from cablewright.control.supervisor import SupervisorSettings
from cablewright.control.velocity import LAWS, VelocitySettings
from cablewright.errors import AnswerError, InputError, UnknownName
from cablewright.estimation.lidar.room import Laser
from cablewright.machine.simulated.settings import (
    MachineSettings,
    extruding,
    load_machine,
    machine_names,
    require_robot,
)
from cablewright.machine.simulated.simulated_machine import PLANTS
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.estimator_settings import with_drum_mass
from cablewright.studies.estimators import ESTIMATORS
from cablewright.studies.prints.loop import PrintPlan
from cablewright.studies.prints.structure import CELLS_PER_BEAD

HEIGHTS: Final = get_args(HeightRule)

_SPEED_FACTOR: Final = 3.0  # speed limit as a multiple of the job's fastest motion ...
_SWING_SPEED: Final = 0.05  # ... plus this, m/s, for a swinging drum
_DRUM_SPEED: Final = 1.2  # of a winch's own limit: where the machine stops
_RAMP_TIMES: Final = (0.05, 0.5)  # s: shortest and longest ramp of a stop
_LOAD_SHARE: Final = 0.5  # share of a line's breaking load at which the machine stops
_MAX_INTRUSIONS: Final = 1000
_FINEST_CELL: Final = 1e-3  # m
_MAX_CELLS: Final = 4_000_000  # of the floor: 32 MB
_INTRUSION_TIME: Final = 20.0  # s of one interruption of the light barrier


@dataclass(frozen=True)
class PrintOptions:
    """Options of a print. ``estimator``, ``height``: None chooses by the machine's sensors.

    ``estimator``: see `studies/estimators.py`. ``height``: ``structure`` controls the height over the structure by the
    vertical lidar; ``job`` follows the job's heights. ``layers``: number of layers to print (None: all). ``period``: s,
    of a quasi-static step. ``intrusions``: number of simulated light-barrier interruptions. ``lasers``: distances to
    walls that an operator measured at the start.
    """

    estimator: str | None = None
    law: LawName = "model"
    height: HeightRule | None = None
    layers: int | None = None
    plant: PlantName = "dynamic"
    period: float = 1.0
    seed: int = 0
    intrusions: int = 0
    lasers: tuple[Laser, ...] = ()

    def __post_init__(self) -> None:
        """Raise `UnknownName` for an unknown choice."""
        known = (("plant", self.plant, PLANTS), ("height", self.height, HEIGHTS), ("control law", self.law, LAWS))
        for name, value, allowed in (*known, ("estimator", self.estimator, ESTIMATORS)):
            if value is not None and value not in allowed:
                raise UnknownName(name, value, allowed)


@dataclass(frozen=True, eq=False)
class MachineTwin:
    """A machine to be simulated, and the path and options of its print."""

    robot: Robot
    settings: MachineSettings
    choices: PrintOptions
    estimator: str
    path: TimedPath


def twin_of(robot: Robot, job: Job, machine: MachineSettings | str | Path | None, choices: PrintOptions) -> MachineTwin:
    """Combine robot, job and machine. *machine*: settings, a file, or a library name (default: the robot's name).

    Raises `InputError` for a robot without a machine, a job or machine of another, layers that the job does not have.
    """
    if job.robot is not None and job.robot != robot.name:
        raise InputError(f"job {job.name!r}: robot = {job.robot!r}, but the robot is {robot.name!r}")
    if machine is None:
        if robot.name not in machine_names():
            known = ", ".join(machine_names())
            raise InputError(f"robot {robot.name!r}: has no machine of its own; give --machine FILE, or one of {known}")
        machine = robot.name
    own = machine if isinstance(machine, MachineSettings) else load_machine(machine)
    require_robot(own, robot.name)
    settings = _fine(extruding(own, job.bead, job.motion.print_speed), robot)
    if choices.plant == "quasi-static":
        if not 1e-3 <= choices.period <= 60.0:
            raise InputError(f"period = {choices.period:g} s: must be from 1 ms to 60 s")
        settings = settings.model_copy(update={"quasi_static_period": choices.period})
    nozzle = 0.0 if settings.extrusion is None else settings.drum.valve  # a strand's path is the nozzle's
    path = TimedPath.of(job, choices.layers, nozzle)
    settings = _intruded(settings, choices, path.duration)
    return MachineTwin(robot, settings, choices, choices.estimator or _best_estimator(settings, choices), path)


def _fine(settings: MachineSettings, robot: Robot) -> MachineSettings:
    """Return the settings with cells of the material that are finer than the bead, as far as memory allows."""
    if settings.extrusion is None:
        return settings
    (x, y, _), (far_x, far_y, _) = robot.scene.frame_min, robot.scene.frame_max
    finest = max(_FINEST_CELL, math.sqrt((far_x - x) * (far_y - y) / _MAX_CELLS))
    cell = max(settings.extrusion.bead.width / CELLS_PER_BEAD, finest)
    if cell >= settings.room.cell:
        return settings
    return settings.model_copy(update={"room": settings.room.model_copy(update={"cell": cell})})


def _best_estimator(settings: MachineSettings, choices: PrintOptions) -> str:
    """The best estimator for a machine's sensors: the filter, or the paper's chain for long steps."""
    if settings.line_angles is None or not {"north", "south"} & settings.lidars.keys():
        return "encoders"
    return "filter" if choices.plant == "dynamic" else "paper"


def _intruded(settings: MachineSettings, choices: PrintOptions, duration: float) -> MachineSettings:
    """Return the settings with interruptions of the light barrier at random times, by the seed."""
    if not choices.intrusions:
        return settings
    if settings.barrier is None:
        raise InputError(f"machine {settings.name!r}: has no light barrier for {choices.intrusions} intrusions")
    if not 0 < choices.intrusions <= _MAX_INTRUSIONS:
        raise InputError(f"intrusions = {choices.intrusions}: must be from 0 to {_MAX_INTRUSIONS}")
    begins = np.sort(np.random.default_rng([choices.seed, 8]).uniform(0.0, duration, choices.intrusions)).tolist()
    times = tuple((begin, begin + _INTRUSION_TIME) for begin in begins)
    barrier = settings.barrier.model_copy(update={"intrusions": (*settings.barrier.intrusions, *times)})
    return settings.model_copy(update={"barrier": barrier})


def plan_print(twin: MachineTwin) -> PrintPlan:
    """Return the plan. Raises `AnswerError` where the path leaves the frame or lines cannot hold the platform."""
    robot, settings, choices, path = twin.robot, twin.settings, twin.choices, twin.path
    model = Model(with_drum_mass(robot, settings))
    _check_path(model, path)
    sees_structure = "vertical" in settings.lidars and twin.estimator != "encoders"
    rule = choices.height or ("structure" if sees_structure else "job")
    if rule == "structure" and not sees_structure:
        raise InputError(f"height = structure: estimator {twin.estimator!r} on {settings.name!r} does not see it")
    begin = path.track.at(0.0).position
    scene = robot.scene
    if rule == "structure" and not begin[2] > scene.frame_min[2]:
        why = "the path begins on the floor, over which no height can be kept; height = job follows the job's own"
        raise InputError(f"height = structure: {why}")
    fastest = max(path.print_speed, path.travel_speed)
    barrier = settings.barrier
    limits = SupervisorSettings(
        scene.frame_min,
        scene.frame_max,
        _SPEED_FACTOR * fastest + _SWING_SPEED,
        max_error=max(0.15, fastest),
        barrier_timeout=None if barrier is None else max(0.5, 2.5 / barrier.rate, 2.5 * _period(twin)),
    )
    velocity = VelocitySettings(
        model,
        settings.winch.max_speed,
        choices.law,
        manage_slack=model.m > model.n and settings.line_angles is not None,
    )
    drum = settings.drum
    return PrintPlan(
        path,
        velocity,
        limits,
        _guard(twin, fastest),
        ManualSettings(scene.frame_min, scene.frame_max, path.acceleration),
        HeightControl(float(begin[2]) - scene.frame_min[2]) if rule == "structure" else None,
        drum.flow if drum.capacity else 0.0,
        drum.powder if drum.capacity else math.inf,
        frozenset({"encoders"}),
    )


def _guard(twin: MachineTwin, fastest: float) -> GuardSettings:
    """Limits of what is measured. A ramp takes as long as the path's acceleration needs from its *fastest*, m/s."""
    winch, path = twin.settings.winch, twin.path
    low, high = _RAMP_TIMES
    return GuardSettings(
        _max_tensions(twin.robot),
        max_drum_speed=_DRUM_SPEED * winch.max_speed,
        counts_per_radian=winch.counts * winch.ratio / math.tau,
        timeouts={"encoders": max(0.5, 2.5 * _period(twin))},
        ramp_time=min(max(fastest / path.acceleration, low), high),
    )


def _period(twin: MachineTwin) -> float:
    return twin.settings.period if twin.choices.plant == "dynamic" else twin.settings.quasi_static_period


def _max_tensions(robot: Robot) -> Array:
    """Tensions (m,), N, at which the machine stops: the lesser of each line's limit and half of its breaking load."""
    lines = robot.lines
    return np.array(
        [min(line.tension_limits[1], _LOAD_SHARE * (line.cable.breaking_load or math.inf)) for line in lines]
    )


def _check_path(model: Model, path: TimedPath) -> None:
    """Raise `AnswerError` at the first place of the path that is out of the frame or cannot be held."""
    scene, places = model.robot.scene, path.track.positions
    inside = ((places >= scene.frame_min) & (places <= scene.frame_max)).all(axis=1)
    if not inside.all():
        bad = int(np.argmin(inside))
        raise AnswerError(f"the path leaves the frame of {model.robot.name!r} {_where(path, bad)}")
    held = solve_inverse(model, places, path=True)
    if not held.ok.all():
        bad = int(np.argmin(held.ok))
        where = _where(path, bad)
        raise AnswerError(f"the path leaves the workspace of {model.robot.name!r} {where}: {held[bad].sentence()}")


def _where(path: TimedPath, row: int) -> str:
    place = ", ".join(f"{x:.3f}" for x in path.track.positions[row])
    return f"at {place} m, {path.track.distance[row]:.1f} m along it"
