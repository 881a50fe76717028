"""What is to be printed, how and by which machine: from a robot, a job and a few choices to a plan that is sound."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from cablewright.control.guide import TimedPath
from cablewright.control.height import HeightControl
from cablewright.control.supervisor import SupervisorSettings
from cablewright.control.velocity import LawName, VelocitySettings
from cablewright.errors import AnswerError, InputError, UnknownName
from cablewright.estimation.lidar.room import Laser
from cablewright.machine.simulated.settings import MachineSettings, extruding, load_settings, settings_names
from cablewright.machine.simulated.simulated_machine import PlantName
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.estimator_settings import with_drum_mass
from cablewright.studies.estimators import ESTIMATORS
from cablewright.studies.prints.loop import PrintPlan

__all__ = ["HEIGHTS", "Choices", "HeightRule", "MachineTwin", "plan_print", "twin_of"]

Array = NDArray[np.float64]
HeightRule = Literal["structure", "job"]
HEIGHTS: Final = ("structure", "job")

_SPARE: Final = 3.0  # times the job's fastest motion that the platform may move at before it is stopped
_EASY: Final = 0.05  # m/s beyond that, for a drum that swings
_BREAKS: Final = 0.5  # of its breaking load, at which a line stops the machine
_MAX_INTRUSIONS: Final = 1000
_INSIDE: Final = 20.0  # s that somebody is in the light barrier


@dataclass(frozen=True)
class Choices:
    """What a person decides on; what is None is decided by what the machine has.

    ``estimator``: see `studies/estimators.py`. ``height``: whether the platform keeps its height over the structure, by
    the vertical lidar, or the job's. ``layers``: print the first so many. ``period``: s of a quasi-static step.
    ``intrusions``: how often somebody walks into the light barrier.
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


@dataclass(frozen=True, eq=False)
class MachineTwin:
    """A machine to be simulated, and what is chosen for it."""

    robot: Robot
    settings: MachineSettings
    choices: Choices
    estimator: str
    path: TimedPath


def twin_of(robot: Robot, job: Job, machine: str | Path | None, choices: Choices) -> MachineTwin:
    """Put together what is printed on. *machine*: a file, or a name of the library; None: that of the robot's name.

    Raises `InputError` for a robot without a machine, a job of another robot, layers that the job does not have.
    """
    if job.robot is not None and job.robot != robot.name:
        raise InputError(f"job {job.name!r}: robot = {job.robot!r}, but the robot is {robot.name!r}")
    if choices.estimator is not None and choices.estimator not in ESTIMATORS:
        raise UnknownName("estimator", choices.estimator, ESTIMATORS)
    if machine is None:
        if robot.name not in settings_names():
            known = ", ".join(settings_names())
            raise InputError(f"robot {robot.name!r}: has no machine of its own; --machine FILE, or one of {known}")
        machine = robot.name
    settings = extruding(load_settings(machine), job.bead, job.motion.print_speed)
    if choices.plant == "quasi-static":
        if not 0.0 < choices.period <= 60.0:
            raise InputError(f"period = {choices.period:g} s: over 0 and up to 60 s is wanted")
        settings = settings.model_copy(update={"quasi_static_period": choices.period})
    nozzle = 0.0 if settings.extrusion is None else settings.drum.valve  # a strand's path is the nozzle's
    path = TimedPath.of(job, choices.layers, nozzle)
    settings = _intruded(settings, choices, path.duration)
    return MachineTwin(robot, settings, choices, choices.estimator or _best(settings, choices), path)


def _best(settings: MachineSettings, choices: Choices) -> str:
    """The estimator for what a machine has: the filter, or over long steps, for which it is not made, the chain."""
    if settings.line_angles is None or not {"north", "south"} & settings.lidars.keys():
        return "encoders"
    return "filter" if choices.plant == "dynamic" else "paper"


def _intruded(settings: MachineSettings, choices: Choices, duration: float) -> MachineSettings:
    """The machine with somebody walking into its light barrier at times drawn by the seed."""
    if not choices.intrusions:
        return settings
    if settings.barrier is None:
        raise InputError(f"machine {settings.name!r}: has no light barrier for {choices.intrusions} intrusions")
    if not 0 < choices.intrusions <= _MAX_INTRUSIONS:
        raise InputError(f"intrusions = {choices.intrusions}: 0 to {_MAX_INTRUSIONS} is wanted")
    begins = np.sort(np.random.default_rng([choices.seed, 8]).uniform(0.0, duration, choices.intrusions)).tolist()
    times = tuple((begin, begin + _INSIDE) for begin in begins)
    barrier = settings.barrier.model_copy(update={"intrusions": (*settings.barrier.intrusions, *times)})
    return settings.model_copy(update={"barrier": barrier})


def plan_print(twin: MachineTwin) -> PrintPlan:
    """Return the plan. Raises `AnswerError` where the path leaves the frame or lines cannot hold the platform."""
    robot, settings, choices, path = twin.robot, twin.settings, twin.choices, twin.path
    model = Model(with_drum_mass(robot, settings))
    _check_path(model, path)
    seen = "vertical" in settings.lidars and twin.estimator != "encoders"
    rule = choices.height or ("structure" if seen else "job")
    if rule == "structure" and not seen:
        raise InputError(f"height = structure: estimator {twin.estimator!r} on {settings.name!r} does not see it")
    begin = path.track.at(0.0).position
    scene = robot.scene
    fastest = max(path.print_speed, path.travel_speed)
    barrier = settings.barrier
    limits = SupervisorSettings(
        scene.frame_min,
        scene.frame_max,
        _SPARE * fastest + _EASY,
        _max_tensions(robot),
        max_error=max(0.15, fastest),
        barrier_timeout=None if barrier is None else max(0.5, 2.5 / barrier.rate, 2.5 * _period(twin)),
        encoder_timeout=max(0.5, 2.5 * _period(twin)),
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
        HeightControl(float(begin[2]) - scene.frame_min[2]) if rule == "structure" else None,
        drum.flow if drum.capacity else 0.0,
        drum.powder if drum.capacity else math.inf,
    )


def _period(twin: MachineTwin) -> float:
    return twin.settings.period if twin.choices.plant == "dynamic" else twin.settings.quasi_static_period


def _max_tensions(robot: Robot) -> Array:
    """N of each line, at which the machine is stopped: its limit, and half of its breaking load."""
    breaking = [line.cable.breaking_load or math.inf for line in robot.lines]
    return np.array([min(line.tension_limits[1], _BREAKS * b) for line, b in zip(robot.lines, breaking, strict=True)])


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
