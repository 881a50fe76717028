"""A print on a simulated machine: from robot, job, machine and options to its twin and its plan."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, get_args

import numpy as np

from cablewright.analyses.motion.lower_acceleration import slower_note
from cablewright.analyses.travel_moves import driven_job
from cablewright.control.path_follower import TimedPath
from cablewright.control.velocity import LAWS
from cablewright.estimation.lidar.room import Laser
from cablewright.foundation.choices import HeightRule, LawName, PlantName, SeverityName
from cablewright.foundation.errors import InputError, UnknownName
from cablewright.live.estimators import ESTIMATORS, best_estimator
from cablewright.live.prints.limits import path_of, planned
from cablewright.live.prints.loop import PrintPlan
from cablewright.live.prints.part_contact import check_clear
from cablewright.live.prints.structure import CELLS_PER_BEAD
from cablewright.machine.files import machine_names
from cablewright.machine.log.head import MAX_EVERY
from cablewright.machine.sensors.barrier import BARRIER
from cablewright.machine.settings import MachineSettings, extruding, require_robot
from cablewright.machine.simulated.floor import Ground
from cablewright.machine.simulated.machine_file import built_machine
from cablewright.machine.simulated.sensors import barrier
from cablewright.machine.simulated.settings import TwinSettings, whole_machine
from cablewright.machine.simulated.severities import with_severity
from cablewright.machine.simulated.severity_tables import SEVERITIES
from cablewright.machine.simulated.simulated_machine import PLANTS
from cablewright.models.job_poses import on_plane
from cablewright.models.statics import Model
from cablewright.models.support_table import Capability, require
from cablewright.printing.job import Job
from cablewright.printing.path import Samples
from cablewright.robot import Robot

HEIGHTS: Final = get_args(HeightRule)
MOST_IRREGULAR: Final = 1e-4
"""Largest ``winch.radius_deviation``, m, of a machine whose places teach lengths: half a centimetre in ten turns."""

MACHINE_FILE: Final = "machine.toml"
"""Of a run folder: the file of the machine that was built for the robot, where none was given."""

_MAX_INTRUSIONS: Final = 1000
_FINEST_CELL: Final = 1e-3  # m
_MAX_CELLS: Final = 4_000_000  # of the floor: 32 MB
_LEAST_EVERY: Final = 60.0  # s between places: the platform stands as long
_MOST_STOPS: Final = 100
_INTRUSION_TIME: Final = 20.0  # s of one interruption of the light barrier


@dataclass(frozen=True)
class PrintOptions:
    """Options of a print. ``estimator``, ``height``: None chooses by the machine's sensors.

    ``estimator``: see `live/estimators.py`. ``height``: ``structure`` controls the height over the structure by the
    vertical lidar; ``job`` follows the job's heights. ``layers``: number of layers to print (None: all). ``period``: s,
    of a quasi-static step. ``intrusions``: number of simulated light-barrier interruptions. ``severity``: see
    `with_severity`; None: of the machine. ``lasers``: distances to walls that an operator measured at the start.
    ``place_layers``: after each so many layers the platform stands and its place is measured, with ``place_sigma``, m,
    in each coordinate; 0: never. Of a point platform by encoders alone. ``place_every``: s of machine time after which
    it is too, first where the path begins; 0: never. ``place_stops``: number of positions that are measured each time,
    evenly along a layer. ``place_tensions``: measured tensions determine the lengths that a place leaves open.
    ``place_learn``: all places together determine errors of lengths, creep and compliance of mounts, see
    `length_corrections`. ``damping``: whether to damp a swinging platform by its lines, where its tilt is measured, and
    of swings in which lines stretch, where tensions are measured; on a plant that swings. ``log_every``: see
    `LogHead.every`.
    """

    estimator: str | None = None
    law: LawName = "model"
    height: HeightRule | None = None
    layers: int | None = None
    plant: PlantName = "dynamic"
    period: float = 1.0
    seed: int = 0
    intrusions: int = 0
    severity: SeverityName | None = None
    lasers: tuple[Laser, ...] = ()
    place_layers: int = 0
    place_sigma: float = 1e-3
    place_tensions: bool = False
    place_every: float = 0.0
    place_stops: int = 1
    place_learn: bool = False
    damping: bool = True
    log_every: int = 1

    def __post_init__(self) -> None:
        """Raise `UnknownName` for an unknown choice, `InputError` for a number that cannot be."""
        known = (("plant", self.plant, PLANTS), ("height", self.height, HEIGHTS), ("control law", self.law, LAWS))
        more = (("estimator", self.estimator, ESTIMATORS), ("severity", self.severity, SEVERITIES))
        for name, value, allowed in (*known, *more):
            if value is not None and value not in allowed:
                raise UnknownName(name, value, allowed)
        if self.place_layers < 0:
            raise InputError(f"place layers = {self.place_layers}: must be 1 or more, or 0 for never")
        if not 0.0 <= self.place_sigma <= 1.0:
            raise InputError(f"place sigma = {self.place_sigma:g} m: must be from 0 to 1 m")
        if not (self.place_every == 0.0 or _LEAST_EVERY <= self.place_every < math.inf):
            raise InputError(f"place every = {self.place_every:g} s: must be {_LEAST_EVERY:g} s or more, or 0: never")
        if not 1 <= self.log_every <= MAX_EVERY:
            raise InputError(f"log every = {self.log_every}: must be from 1 to {MAX_EVERY} steps")
        if not 1 <= self.place_stops <= _MOST_STOPS:
            raise InputError(f"place stops = {self.place_stops}: must be from 1 to {_MOST_STOPS}")


@dataclass(frozen=True, eq=False)
class Upon:
    """Initial conditions of a print: the robot of which its machine is built, and the ground; None: an empty floor.

    ``inputs``: hashes of further files that identify the print.
    """

    described: Robot
    ground: Ground | None
    inputs: Mapping[str, str]


@dataclass(frozen=True, eq=False)
class MachineTwin:
    """A machine to be simulated, and the path and options of its print."""

    robot: Robot
    job: Job
    settings: TwinSettings
    choices: PrintOptions
    estimator: str
    path: TimedPath
    notes: tuple[str, ...]  # deviations from the job, and the machine that was built for it
    built: str = ""  # file of the machine that was built for the robot, where there was none
    upon: Upon | None = None  # None: the machine is built of the robot, and begins with an empty floor


def twin_of(
    robot: Robot,
    job: Job,
    machine: TwinSettings | str | Path | None,
    choices: PrintOptions,
    samples: Samples | None = None,
) -> MachineTwin:
    """Return the simulated machine of a print from robot, job and machine.

    *machine*: settings, a file, or a library name; by default the library's machine of the robot's name, or where there
    is none the one that `built_machine` builds. *samples*: samples of the job's path; by default those of its file.
    Raises `InputError` for a job or machine of another robot, and for layers that the job does not have.
    """
    if job.robot is not None and job.robot != robot.name:
        raise InputError(f"job {job.name!r}: robot = {job.robot!r}, but the robot is {robot.name!r}")
    require(robot, Capability.PRINT)
    built = ""
    notes: tuple[str, ...] = ()
    if machine is None and robot.name not in machine_names():
        machine, built = built_machine(robot)
        notes = (f"no machine was given: one was built for {robot.name}, with assumed numbers, in {MACHINE_FILE}",)
    given = whole_machine(machine or robot.name)
    if choices.severity is not None:
        given = with_severity(given, choices.severity)
    require_robot(given.owner, robot.name)
    chosen = choices.estimator or best_estimator(given.owner)
    _require_places(choices, chosen, robot, given.owner)
    job = on_plane(robot, job)
    toolpath = job.toolpath()
    asked, (job, samples) = job, driven_job(robot, job, samples, toolpath=toolpath)
    bead, differing = job.typical_bead(toolpath)
    owner = extruding(given.owner, bead, job.motion.print_speed)
    settings = _fine(given.model_copy(update={"owner": owner}), robot)
    if choices.plant == "quasi-static":
        if not 1e-3 <= choices.period <= 60.0:
            raise InputError(f"period = {choices.period:g} s: must be from 1 ms to 60 s")
        settings = settings.with_simulation(quasi_static_period=choices.period)
    path = path_of(robot, job, samples, owner, chosen, choices.law, choices.layers)
    settings = _intruded(settings, choices, path.duration)
    return MachineTwin(
        robot,
        job,
        settings,
        choices,
        chosen,
        path,
        (*notes, *slower_note(asked, job), *(() if owner.extrusion is None else differing)),
        built,
    )


def _require_places(choices: PrintOptions, chosen: str, robot: Robot, owner: MachineSettings) -> None:
    """Raise `InputError` for places where they are of no use, and tensions without what measures them."""
    measured = {"place layers": choices.place_layers, "place every": choices.place_every}
    for name, often in measured.items():
        if often and (chosen != "encoders" or robot.n == 6 or robot.platform.plane is not None):
            why = "is for point platforms in no plane, by encoders alone (--estimator encoders)"
            raise InputError(f"{name}: {why}")
    for name, given in (
        ("place tensions", choices.place_tensions),
        ("place learn", choices.place_learn),
        ("place stops", choices.place_stops > 1),
    ):
        if given and not any(measured.values()):
            raise InputError(
                f"{name}: give place layers or place every, which set when positions are measured; both are 0"
            )
    if choices.place_tensions and choices.place_learn:
        raise InputError(
            "place tensions, place learn: measured positions are used with tensions, or to estimate "
            "errors of the lines; give one of them, not both"
        )
    irregular = owner.winch.radius_deviation
    if choices.place_learn and irregular > MOST_IRREGULAR:
        why = f"machine {owner.name!r}: cable that lies so irregularly on its drums, winch.radius_deviation ="
        end = f"{irregular:g} m, teaches nothing that lasts: must be {MOST_IRREGULAR:g} m or less"
        raise InputError(f"place learn: {why} {end}")
    if choices.place_tensions and owner.tension_sensor is None:
        raise InputError(f"place tensions: machine {owner.name!r} has neither load_cells nor motor_torques")


def _fine(settings: TwinSettings, robot: Robot) -> TwinSettings:
    """Return the settings with cells of the material that are finer than the bead, as far as memory allows."""
    extrusion, floor = settings.owner.extrusion, settings.simulation.room
    if extrusion is None:
        return settings
    (x, y, _), (far_x, far_y, _) = robot.scene.frame_min, robot.scene.frame_max
    finest = max(_FINEST_CELL, math.sqrt((far_x - x) * (far_y - y) / _MAX_CELLS))
    cell = max(extrusion.bead.width / CELLS_PER_BEAD, finest)
    return settings if cell >= floor.cell else settings.with_simulation(room=floor.model_copy(update={"cell": cell}))


def _intruded(settings: TwinSettings, choices: PrintOptions, duration: float) -> TwinSettings:
    """Return the settings with interruptions of the light barrier at random times, by the seed."""
    if not choices.intrusions:
        return settings
    if settings.owner.sensor(BARRIER) is None:
        raise InputError(f"machine {settings.owner.name!r}: has no light barrier for {choices.intrusions} intrusions")
    if not 0 < choices.intrusions <= _MAX_INTRUSIONS:
        raise InputError(f"intrusions = {choices.intrusions}: must be from 0 to {_MAX_INTRUSIONS}")
    begins = np.sort(np.random.default_rng([choices.seed, 8]).uniform(0.0, duration, choices.intrusions)).tolist()
    times = tuple((begin, begin + _INTRUSION_TIME) for begin in begins)
    flaws = settings.simulation.flaws(barrier.SIMULATED)
    return settings.with_simulation(barrier=flaws.model_copy(update={"intrusions": (*flaws.intrusions, *times)}))


def plan_print(twin: MachineTwin) -> PrintPlan:
    """Return the plan of a print.

    Raises `AnswerError` where the path leaves the frame, lines cannot hold the platform, or those of a rigid one would
    touch laid material.
    """
    owner, simulation, choices = twin.settings.owner, twin.settings.simulation, twin.choices
    period = owner.period if choices.plant == "dynamic" else simulation.quasi_static_period
    damps = choices.damping and choices.plant == "dynamic"
    plan = planned(twin.robot, owner, twin.path, period, twin.estimator, choices.law, choices.height, damps=damps)
    if twin.path.attitude is not None:
        check_clear(Model(twin.robot), twin.job, choices.layers)
    return replace(plan, notes=(*plan.notes, *twin.notes))
