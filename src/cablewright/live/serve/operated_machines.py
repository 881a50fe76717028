"""Machines that a page can operate: simulated ones in real time, and those on drives.

A sitting is one run of the control loop: with a job to be printed, or without, to take up slack, home and jog. Each
begins in a fault with brakes closed, as `cablewright.live.prints.loop.Printer` does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Final, Protocol

import numpy as np

from cablewright.analyses.travel_moves import driven_job
from cablewright.control.path_follower import TimedPath
from cablewright.control.procedure import Procedure
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import PrintState
from cablewright.live.drives.printing import taken_up
from cablewright.live.drives.session import RealMachine, taking_up
from cablewright.live.estimators import Estimator, estimator
from cablewright.live.placeholder_path import still_path
from cablewright.live.prints.limits import path_of
from cablewright.live.prints.loop import Printer
from cablewright.live.prints.part_contact import check_clear
from cablewright.live.prints.plan import PrintOptions, plan_print, twin_of
from cablewright.live.prints.recorder import read_checkpoint
from cablewright.live.prints.run import CHECKPOINT, log_epoch
from cablewright.live.rest_pose import rest_pose
from cablewright.live.serve.winch import WinchByHand
from cablewright.machine.drives.can_bus import Port
from cablewright.machine.log.head import LogHead
from cablewright.machine.real_time_machine import Paced
from cablewright.machine.settings import MachineSettings, extruding
from cablewright.machine.simulated.settings import TwinSettings
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.job_poses import on_plane
from cablewright.models.statics import Model
from cablewright.printing.job import Job, Motion
from cablewright.robot import Robot

_BY_HAND: Final = Motion(print_speed=0.1, travel_speed=0.1, acceleration=0.2)  # m/s, m/s^2


@dataclass(eq=False)
class Sitting:
    """One run of the control loop.

    ``refill``: fills the container where the machine is simulated. ``lateness``: s, of its steps. ``notes``: notes on
    the machine for the person who starts it.
    """

    printer: Printer
    path: TimedPath
    head: LogHead
    job: Job | None
    refill: Callable[[], None] = lambda: None
    lateness: Callable[[], list[float]] = list
    home_at: Callable[[Array | None], None] = lambda _place: None
    """Takes where a person has measured the platform, (3,) m or (n,), before an order to home; None: not measured."""

    notes: tuple[str, ...] = ()
    winches: WinchByHand | None = None  # turns single winches; None: nothing measures their tensions

    @property
    def procedures(self) -> tuple[str, ...]:
        """States of the procedures, such as homing, that the machine offers."""
        return tuple(state.value for state in self.printer.plan.procedures)


class Station(Protocol):
    """Interface of a machine that a page can operate."""

    robot: Robot

    def sitting(self, job: Job | None, run: Path | None = None) -> Sitting:
        """Begin a run of the control loop, from where the last one ended.

        *run*: folder of a run of the job that goes on. Raises `InputError` and `AnswerError` for a job that it cannot
        print, `EnvironmentFault` for a machine that is not available.
        """

    def adopt(self, robot: Robot) -> None:
        """Take the machine for another *robot*, of other numbers, from now on.

        Raises `InputError` where that needs a new start, and for another machine's.
        """


def require_same(robot: Robot, other: Robot) -> None:
    """Raise `InputError` where *other* is not the same machine as *robot*, with other numbers."""
    if (robot.name, robot.m, robot.n) != (other.name, other.m, other.n):
        told = f"{other.name!r} with {other.m} lines, but the machine is {robot.name!r} with {robot.m}"
        raise InputError(f"the file is of robot {told}: calibrate this one")


def resting_pose(robot: Robot, place: Array | None = None) -> Array:
    """Return the initial pose of a simulated platform, (n,) m and rad: at *place* (3,) or (n,), if given."""
    return np.array(rest_pose(robot).equilibrium.pose) if place is None else np.pad(place, (0, robot.n - len(place)))


@dataclass(eq=False)
class SimulatedStation:
    """A simulated machine for the page.

    It is made again for each sitting, with a full container, where the platform was left.
    """

    robot: Robot
    settings: TwinSettings
    seed: int
    pose: Array  # (n,) m and rad, where it is
    told: Array | None = None  # (n,) m and rad, where the last sitting knew it; None: there
    _last: tuple[SimulatedMachine, Printer] | None = field(default=None, repr=False)

    def sitting(self, job: Job | None, run: Path | None = None) -> Sitting:
        """As `Station.sitting`; a run that goes on uses the machine of its checkpoint."""
        saved = None if run is None else read_checkpoint(run / CHECKPOINT)
        if self._last is not None:
            machine, printer = self._last
            truth = np.concatenate([machine.truth.position, machine.truth.rotation])
            self.pose, self.told = truth[: self.robot.n], printer.last_pose.copy()
        begin = self.pose if self.told is None else self.told
        owner = self.settings.owner
        lift = 0.0 if owner.extrusion is None or owner.drum is None else owner.drum.valve
        wanted, samples = job, None
        if wanted is None:
            wanted, samples = still_path(self.robot, Model(self.robot).nozzle(begin) - [0.0, 0.0, lift], _BY_HAND)
        twin = twin_of(self.robot, wanted, self.settings, PrintOptions(seed=self.seed), samples)
        plan = plan_print(twin)
        if saved is None:
            machine = SimulatedMachine(self.robot, twin.settings, self.pose, seed=self.seed)
        else:
            machine = SimulatedMachine.resumed(self.robot, twin.settings, saved["machine"], seed=self.seed)
        paced = Paced(machine)

        def made(pose: Array, radii: Array) -> Estimator:
            known = begin if saved is None else pose
            return estimator(twin.estimator, self.robot, machine.settings, known, (), radii)

        printer = Printer(plan, paced, made, now=machine.time, saved=saved)
        if saved is None:
            printer.last_pose[:] = begin
        self._last = machine, printer
        head = LogHead(
            self.robot,
            machine.settings,
            machine.period,
            simulation=machine.simulation,
            plant="dynamic",
            seed=self.seed,
            epoch=datetime.now(UTC).replace(microsecond=0) if run is None else log_epoch(run, real_time=True),
        )

        def refill() -> None:
            if owner.drum is not None:
                machine.refill(min(plan.powder, owner.drum.capacity))
            printer.refilled()

        return Sitting(printer, twin.path, head, job, refill, lambda: list(paced.lateness))

    def adopt(self, robot: Robot) -> None:
        """Take the machine for another *robot*: it is made again, as that one is built."""
        require_same(self.robot, robot)
        self.robot = robot


@dataclass(eq=False)
class DriveStation:
    """A machine on drives for the page.

    ``state``: path, without suffix, of the files with its counts and lengths. ``port``: port of a bus in this process.
    """

    robot: Robot
    settings: MachineSettings
    state: Path
    port: Callable[[], Port] | None = None
    begin: Array | None = None  # (n,) m and rad, roughly where the platform is if nothing is saved

    def sitting(self, job: Job | None, run: Path | None = None) -> Sitting:
        """Begin a sitting at the last position of the platform; see `Station.sitting`."""
        if job is not None and job.robot not in (None, self.robot.name):
            raise InputError(f"job {job.name!r}: robot = {job.robot!r}, but the robot is {self.robot.name!r}")
        samples, owner = None, self.settings
        if job is not None:
            job = on_plane(self.robot, job)
            toolpath = job.toolpath()
            job, samples = driven_job(self.robot, job, toolpath=toolpath)
            owner = extruding(owner, job.typical_bead(toolpath)[0], job.motion.print_speed)
        machine = RealMachine.of(self.robot, owner, self.state, self.port)
        near = machine.keeper.pose
        if near is None:
            near = resting_pose(self.robot) if self.begin is None else self.begin
        if job is None or samples is None:
            still, samples = still_path(self.robot, Model(self.robot).nozzle(near), _BY_HAND)
            path = TimedPath.of(still, nozzle=self.robot.platform.own_nozzle, samples=samples, robot=self.robot)
        else:
            path = path_of(self.robot, job, samples, owner, machine.estimator)
        homing = machine.homing(near)
        winches = WinchByHand(taking_up(machine), machine.winch_jog, self.robot.winches)
        procedures: dict[PrintState, Procedure] = {
            PrintState.TENSIONING: winches,
            PrintState.HOMING: homing,
        }

        def home_at(place: Array | None) -> None:
            homing.settings = replace(homing.settings, place=None if place is None else resting_pose(self.robot, place))

        paced = Paced(machine.machine)
        if self.port is not None:  # virtual time
            machine.machine = paced  # type: ignore[assignment]
        saved, epoch, start = (None, datetime.now(UTC).replace(microsecond=0), 0.0) if run is None else taken_up(run)
        printer = machine.printer(path, "model", procedures, saved, start)
        if job is not None:
            machine.reckon_powder(printer)
        if job is not None and path.attitude is not None:
            check_clear(Model(self.robot), job, None)
        head = LogHead(self.robot, owner, owner.period, kind="real", epoch=epoch)
        assert owner.drives is not None
        notes = () if job is None else owner.drives.valve_notes
        made = Sitting(printer, path, head, job, lateness=lambda: list(paced.lateness), home_at=home_at, notes=notes)
        return replace(made, winches=winches)

    def adopt(self, robot: Robot) -> None:
        """Raise `InputError`: saved counts and lengths are of the present exit points."""
        raise InputError(f"robot {robot.name!r} on drives: end serve, start it with the new file, and home the machine")
