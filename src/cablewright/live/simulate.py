"""`simulate`: a simulated machine moved along a path or held in position, and its log."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from cablewright.analyses.motion.trajectory import Trajectory
from cablewright.foundation.arrays import Array
from cablewright.foundation.choices import PlantName, SeverityName
from cablewright.foundation.errors import CablewrightError, EnvironmentFault, InputError
from cablewright.foundation.file_output import cannot_write
from cablewright.foundation.progress import Progress
from cablewright.foundation.results import Figure, Pictured
from cablewright.live.drive_along_path import DriveSettings, PilotedDrive, drive, path_length, random_loop
from cablewright.machine.files import machine_names
from cablewright.machine.log.head import LogHead
from cablewright.machine.log.log import write_log
from cablewright.machine.settings import require_robot
from cablewright.machine.simulated.machine_file import built_machine
from cablewright.machine.simulated.settings import TwinSettings, load_twin, whole_machine
from cablewright.machine.simulated.severities import with_severity
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.statics import Model
from cablewright.printing.random_curve import MAX_LENGTH
from cablewright.robot import Robot

_DEFAULT = "merlet2023"  # the machine of a robot that has none of its own


@dataclass(frozen=True, eq=False, repr=False)
class Simulation(Pictured):
    """Summary of one run of the simulated machine, along a path or held at a position."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok: what cannot be simulated is an error.", lambda _: "ok"),
        Figure("robot", "", "Name of the robot.", "head.robot.name"),
        Figure("machine", "", "Name of the machine's settings.", "head.settings.name"),
        Figure("plant", "", "Motion of the machine: dynamic, or quasi-static.", "head.plant"),
        Figure("severity", "", "Deviations of the machine from its description: ideal, typical, rough, or own numbers.",
               "head.severity"),
        Figure("built", "", "Deviations of the machine as built, by that severity.", "head.built", "as built"),
        Figure("seed", "1", "Seed of the robot as built, the path and all noise.", "head.seed"),
        Figure("period", "s", "Duration of one step.", "head.period", detail=True),
        Figure("steps", "1", "Number of steps.", "drive.steps"),
        Figure("duration", "s", "Time on the machine's clock at the end.", "drive.duration", shown="s"),
        Figure("distance", "m", "Length of the path of the platform point B.", "drive.distance", shown="m"),
        Figure("powder", "kg", "Mass of the powder left in the drum.", "drive.powder", "powder left"),
        Figure("refills", "1", "Number of refills of the drum.", "drive.refills"),
        Figure("max_tension", "N", "Largest tension at a sheave.", "drive.max_tension"),
        Figure("max_tilt", "rad", "Largest angle of the drum's axis from the vertical.", "drive.max_tilt"),
        Figure("yaw", "rad", "Smallest and largest yaw of the drum.", "drive.yaw", "min and max yaw"),
        Figure("readings", "1", "Number of readings that arrived, by source.", lambda of: _sorted(of.drive.readings)),
        Figure("notices", "1", "Number of steps with each notice of the machine, by notice.",
               lambda of: _sorted(of.drive.notices), "steps with a notice"),
        Figure("real_time_ratio", "1", "Simulated time over computing time.", "drive.real_time_ratio", digits=2),
        Figure("lines", "", "Names of the lines.", "drive.lines", "line", along="line"),
        Figure("slack_share", "1", "Share of the time in which each line was slack by over 5 mm.", "drive.slack_share",
               "time slack by over 5 mm", 3, shown="%", along="line"),
    )  # fmt: skip
    HEADLINES: ClassVar = ("robot", "plant", "duration", "distance", "max_tension")

    head: LogHead
    drive: PilotedDrive


def simulate(
    robot: Robot | Model,
    machine: TwinSettings | str | Path | None = None,
    *,
    loop: float | None = None,
    hold: ArrayLike | None = None,
    trajectory: Trajectory | None = None,
    height: float = 1.2,
    duration: float | None = None,
    seed: int = 0,
    plant: PlantName = "dynamic",
    severity: SeverityName | None = None,
    driving: DriveSettings | None = None,
    log: str | Path | None = None,
    epoch: datetime | None = None,
    progress: Progress | None = None,
) -> Simulation:
    """Move a simulated machine, built by *seed* within its tolerances, along a random closed path, or hold it.

    *machine*: see `machine_of`. *loop*: length of the path, m, at *height*, m. *hold*: position (3,) of B, m, world, or
    pose (6,) of a body, to stay at instead. *trajectory*: trajectory to follow instead; ``drive.poses`` are then the
    true poses after each step. *duration*: s, by default once round the loop, or to the trajectory's end. Of a `Model`
    the robot alone is used: the *plant*, ``dynamic`` or ``quasi-static``, has its own laws. *severity*: see
    `with_severity`; None: of the *machine*. *log*: an MCAP file, which appears when it is complete. *epoch*: UTC of its
    time 0, for programs that show dates; by default 1970, so that the same input gives the same bytes.

    Raises `InputError` for contradictory or missing arguments, `AnswerError` where the path cannot be held,
    `EnvironmentFault` where the log cannot be written.

    Examples
    --------
    >>> import cablewright as cw
    >>> cw.simulate(cw.load("merlet2023"), hold=[0.0, 0.0, 1.2], duration=2.0, plant="quasi-static").drive.steps
    10
    """
    described, settings = robot.robot if isinstance(robot, Model) else robot, driving or DriveSettings()
    if sum(each is not None for each in (loop, hold, trajectory)) != 1:
        raise InputError("simulate: give one of loop (a length), hold (a position) and trajectory")
    if hold is not None and duration is None:
        raise InputError("simulate: hold needs a duration")
    if loop is not None and not 0.0 < loop < MAX_LENGTH:
        raise InputError(f"loop = {loop:g} m: must be more than 0 and less than {MAX_LENGTH:g} m")
    if log is not None and Path(log).suffix != ".mcap":
        raise InputError(f"log = {str(log)!r}: a name that ends in .mcap is expected")
    built = machine_of(described, machine)
    if severity is not None:
        built = with_severity(built, severity)
    path: Array | Trajectory | None = None
    if trajectory is not None:
        path, start = trajectory, trajectory.poses[0]
        duration = trajectory.duration if duration is None else duration
    elif loop is None:
        start = np.asarray(hold, dtype=np.float64)
        if start.shape not in {(3,), (described.n,)} or not np.isfinite(start).all():
            sizes, units = described.platform.pose_sizes, described.platform.pose_units
            raise InputError(f"hold = {start.tolist()}: {sizes} finite numbers are expected, {units}")
    else:
        path = random_loop(described, loop, seed)
        start = np.array([*path[0], height])
    if duration is None and isinstance(path, np.ndarray):  # whole seconds; half of the ramp is lost
        duration = math.floor(path_length(path) / settings.speed + 0.5 * settings.ramp)
    assert duration is not None
    twin = SimulatedMachine(described, built, start, seed=seed, plant=plant)
    pose = np.concatenate([start, np.zeros(described.n - len(start))])
    head = LogHead(
        described,
        built.owner,
        twin.period,
        simulation=built.simulation,
        plant=plant,
        seed=seed,
        epoch=epoch,
        home=tuple(pose.tolist()),
    )
    run = partial(drive, twin, path, duration, settings=settings, seed=seed, progress=progress)
    return Simulation(head, run() if log is None else _logged(run, Path(log), head))


def machine_of(robot: Robot, machine: TwinSettings | str | Path | None) -> TwinSettings:
    """Return *machine*: settings, a name of `machine_names` or a TOML file.

    By default the library's machine of the robot's name; if there is none, for a point platform ``merlet2023``, and for
    a body the one that `built_machine` builds. Raises `InputError` for the machine of another robot.
    """
    if machine is None and robot.n == 6 and robot.name not in machine_names():
        return built_machine(robot)[0]
    if machine is None:
        own = load_twin(robot.name if robot.name in machine_names() else _DEFAULT)
        return own if own.owner.robot == robot.name else own.with_owner(robot=None)
    settings = whole_machine(machine)
    require_robot(settings.owner, robot.name)
    return settings


def _logged(run: Callable[..., PilotedDrive], out: Path, head: LogHead) -> PilotedDrive:
    """Run with a log in a temporary file, renamed to *out* at the end. Raises `EnvironmentFault`."""
    part = out.with_name(f"{out.name}.part")
    try:
        with write_log(part, head, flush_every=None) as log:
            found = run(log=log)
        part.replace(out)
    except EnvironmentFault:  # the part that was written can be read
        raise
    except CablewrightError:
        part.unlink(missing_ok=True)
        raise
    except OSError as reason:
        raise cannot_write(out, reason) from None
    return found


def _sorted(counts: dict[str, int]) -> dict[str, int]:
    return dict(sorted(counts.items()))
