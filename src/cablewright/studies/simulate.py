"""A simulated machine driven along a path or held in a place, with its log: the verb `simulate`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from cablewright.arrays import Array
from cablewright.choices import PlantName
from cablewright.errors import CablewrightError, EnvironmentFault, InputError
from cablewright.file_output import cannot_write
from cablewright.machine.log.log import LogHead, write_log
from cablewright.machine.simulated.settings import MachineSettings, load_machine, machine_names
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.statics import Model
from cablewright.progress import Progress
from cablewright.results import Figure, Pictured
from cablewright.robot import Robot
from cablewright.studies.drive import Drive, DriveSettings, drive, path_length, random_loop

_DEFAULT = "merlet2023"  # the machine of a robot that has none of its own


@dataclass(frozen=True, eq=False, repr=False)
class Simulation(Pictured):
    """What happened to a simulated machine: `simulate`."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok: what cannot be simulated is an error.", lambda _: "ok"),
        Figure("robot", "", "Name of the robot.", "head.robot.name"),
        Figure("machine", "", "Name of the machine's settings.", "head.settings.name"),
        Figure("plant", "", "Motion of the machine: dynamic, or quasi-static.", "head.plant"),
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
    drive: Drive


def simulate(
    robot: Robot | Model,
    machine: MachineSettings | str | Path | None = None,
    *,
    loop: float | None = None,
    hold: ArrayLike | None = None,
    height: float = 1.2,
    duration: float | None = None,
    seed: int = 0,
    plant: PlantName = "dynamic",
    driving: DriveSettings | None = None,
    log: str | Path | None = None,
    progress: Progress | None = None,
) -> Simulation:
    """Drive a simulated machine, built by *seed* within its tolerances, round a random closed path, or hold it.

    *machine* is settings, a name of `machine_names` or a TOML file; by default that of the robot's name, else
    ``merlet2023``. *loop* is the length of the path, m, at *height*, m; *hold* the place (3,) of B to stay in, m,
    world. *duration*, s, is once round the loop by default. Of a `Model` the robot counts: the *plant*, dynamic or
    quasi-static, has laws of its own. *log* is an MCAP file; it appears when it is whole.

    Raises `InputError` for what cannot be simulated, `AnswerError` where the path cannot be held, `EnvironmentFault`
    where the log cannot be written.

    Examples
    --------
    >>> import cablewright as cw
    >>> cw.simulate(cw.load("merlet2023"), hold=[0.0, 0.0, 1.2], duration=2.0, plant="quasi-static").drive.steps
    10
    """
    described, settings = robot.robot if isinstance(robot, Model) else robot, driving or DriveSettings()
    if (loop is None) == (hold is None):
        raise InputError("simulate: either the length of a loop or a place to hold is wanted")
    if hold is not None and duration is None:
        raise InputError("simulate: a place to hold needs a duration")
    if log is not None and Path(log).suffix != ".mcap":
        raise InputError(f"log = {str(log)!r}: a name that ends in .mcap is wanted")
    built = machine_of(described, machine)
    way = None if loop is None else random_loop(described, loop, seed)
    start = np.array([*way[0], height]) if way is not None else _place(hold)
    if duration is None and way is not None:  # whole seconds; half of the ramp is lost
        duration = math.floor(path_length(way) / settings.speed + 0.5 * settings.ramp)
    assert duration is not None
    twin = SimulatedMachine(described, built, start, seed=seed, plant=plant)
    head = LogHead(described, built, twin.period, plant, seed)
    return Simulation(head, _run(twin, way, duration, settings, head, None if log is None else Path(log), progress))


def machine_of(robot: Robot, machine: MachineSettings | str | Path | None) -> MachineSettings:
    """Return *machine*: settings, a name of `machine_names` or a TOML file.

    By default the library's machine of the robot's name, or ``merlet2023`` if there is none.
    """
    if isinstance(machine, MachineSettings):
        return machine
    return load_machine(machine or (robot.name if robot.name in machine_names() else _DEFAULT))


def _run(
    twin: SimulatedMachine, way: Array | None, duration: float, settings: DriveSettings, head: LogHead,
    out: Path | None, progress: Progress | None,
) -> Drive:  # fmt: skip
    """Drive, with a log beside its place until it is whole. Raises `EnvironmentFault` where it cannot be written."""
    if out is None:
        return drive(twin, way, duration, settings=settings, seed=head.seed, progress=progress)
    part = out.with_name(f"{out.name}.part")
    try:
        with write_log(part, head, flush_every=None) as log:
            found = drive(twin, way, duration, settings=settings, seed=head.seed, log=log, progress=progress)
        part.replace(out)
    except EnvironmentFault:  # what there was room for can be read
        raise
    except CablewrightError:
        part.unlink(missing_ok=True)
        raise
    except OSError as reason:
        raise cannot_write(out, reason) from None
    return found


def _place(hold: ArrayLike | None) -> Array:
    place = np.asarray(hold, dtype=np.float64)
    if place.shape != (3,) or not np.isfinite(place).all():
        raise InputError(f"hold = {place.tolist()}: 3 finite numbers are wanted, m")
    return place


def _sorted(counts: dict[str, int]) -> dict[str, int]:
    return dict(sorted(counts.items()))
