"""Comparison of closed loops: controllers, estimators and plants, built-in or a user's own, with the same seeds."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import ClassVar, Final, Protocol, TypeVar, cast, get_args

import numpy as np
from numpy.typing import ArrayLike

from cablewright.analyses.motion.trajectory import Trajectory
from cablewright.control import velocity
from cablewright.control.path_follower import Target
from cablewright.foundation.arrays import Array
from cablewright.foundation.choices import EstimatorName, LawName, PlantName
from cablewright.foundation.errors import AnswerError, InputError, UnknownName
from cablewright.foundation.progress import Progress, silent
from cablewright.foundation.results import Figure, Pictured
from cablewright.foundation.signals import Command, Estimate, SensorFrame, Truth
from cablewright.live.error_statistics import SLACK
from cablewright.live.estimator_settings import with_drum_mass
from cablewright.live.estimators import estimator
from cablewright.live.simulate import machine_of
from cablewright.machine.interface import Machine
from cablewright.machine.settings import MachineSettings
from cablewright.machine.simulated.settings import TwinSettings
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.statics import Model
from cablewright.robot import Robot

TRUTH: Final = "truth"
"""Name of the estimator that knows the true state, by which a controller alone is seen."""

_MadeT = TypeVar("_MadeT")
_LONGEST_START: Final = 20.0  # s that an estimator may take to find the platform


class LoopController(Protocol):
    """Interface of a control law in a comparison of loops."""

    def __call__(self, estimate: Estimate, target: Target, period: float) -> ArrayLike:
        """Return rates (m,), m/s, of the lengths of the lines in the next *period*, s; positive pays out."""


class Observing(Protocol):
    """Interface of an estimator in a comparison of loops."""

    def step(self, frame: SensorFrame) -> Estimate:
        """Return the estimate after one frame."""


MakeController = Callable[[Robot, MachineSettings], LoopController]
MakeEstimator = Callable[[Robot, MachineSettings, Array], Observing]
MakePlant = Callable[[Robot, Array, int], Machine]


@dataclass(frozen=True, eq=False)
class LoopRun:
    """A run. ``errors`` and ``estimate_errors`` (k,), m, of the position at ``times`` (k,), s of the trajectory."""

    controller: str
    estimator: str
    plant: str
    seed: int
    times: Array
    errors: Array
    estimate_errors: Array
    tensions: Array  # (k + 1, m) N, true, at the sheaves, from before the first step on
    step_times: Array  # (k,) s of computing, of estimator and controller
    reason: str = ""  # for which it ended early

    @property
    def name(self) -> str:
        """Label of the run: the properties that differ between runs."""
        return f"{self.controller}, {self.estimator}, {self.plant}"


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else np.nan


_RUN: Final = (
    Figure("controller", "", "Controller."),
    Figure("estimator", "", "Estimator."),
    Figure("plant", "", "Plant."),
    Figure("seed", "1", "Seed of the machine as built, of its sensors' noise and of its disturbances."),
    Figure("rms_error", "m", "Distance of the true position from the target, rms.", lambda of: _rms(of.errors)),
    Figure("max_error", "m", "Its maximum.", lambda of: float(of.errors.max(initial=0.0))),
    Figure(
        "rms_estimate_error", "m", "Distance of the estimated position from the true one, rms.",
        lambda of: _rms(of.estimate_errors),
    ),
    Figure("min_tension", "N", "Smallest true tension.", lambda of: float(of.tensions.min(initial=np.inf))),
    Figure("max_tension", "N", "Largest true tension.", lambda of: float(of.tensions.max(initial=0.0))),
    Figure(
        "step_time", "s", "Computing time of a step, median; of estimator and controller.",
        lambda of: float(np.median(of.step_times)) if len(of.step_times) else np.nan, digits=2,
    ),
    Figure("reason", "", "Why it ended early; empty where it did not."),
)  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class LoopComparison(Pictured):
    """Runs of closed loops along one trajectory, to compare."""

    FIGURES: ClassVar = (
        Figure("status", "", "ok, or stopped: a run ended early."),
        Figure("robot", "", "Name of the robot."),
        Figure("trajectory", "", "Source of the trajectory.", "trajectory.source"),
        Figure("duration", "s", "Time of the trajectory.", "trajectory.duration", shown="s"),
        Figure("runs", "", "The runs.", parts=_RUN),
    )
    HEADLINES: ClassVar = ("robot", "trajectory", "status")

    robot: str
    trajectory: Trajectory
    runs: tuple[LoopRun, ...]

    @property
    def status(self) -> str:
        """Status of the comparison: "ok", or "stopped" if a run ended early."""
        return "stopped" if self.refusal else "ok"

    @property
    def refusal(self) -> str:
        """Reason of the first run that ended early; empty where none did."""
        return next((f"{run.name}, seed {run.seed}: {run.reason}" for run in self.runs if run.reason), "")


def compare_loops(
    robot: Robot,
    trajectory: Trajectory,
    *,
    controllers: Sequence[str | MakeController] = ("model",),
    estimators: Sequence[str | MakeEstimator] = ("encoders",),
    plants: Sequence[str | MakePlant] = ("quasi-static",),
    seeds: Sequence[int] = (0,),
    machine: TwinSettings | str | None = None,
    progress: Progress | None = None,
) -> LoopComparison:
    """Run each controller with each estimator on each plant along a *trajectory*, all with the same *seeds*.

    Give a user's own as classes or functions; the results have their names:

    * *controllers*: ``model`` or ``paper``, laws of `print_job`, or ``make(robot, settings)``, which returns a callable
      ``(estimate, target, period)``. It returns rates of the lines' lengths (m,), m/s; positive pays out.
    * *estimators*: ``encoders``, ``filter``, ``paper``, or ``truth``, which knows the true state; or
      ``make(robot, settings, start)``, which returns an object whose ``step(frame)`` returns an `Estimate`.
    * *plants*: ``quasi-static``, ``dynamic``, or ``make(robot, start, seed)``, which returns a machine with the true
      state among its `Abilities`. *start* (n,), m and rad, is the first pose.

    *machine*: machine to simulate, see `simulate`. The largest drum speed bounds all controllers equally. The
    trajectory begins when the estimate is valid.

    Raises `InputError` for unknown names, two of one name, rates that are not m finite numbers, and a plant without a
    truth.

    Examples
    --------
    >>> import cablewright as cw
    >>> robot = cw.load("merlet2023")
    >>> way = cw.Trajectory.through([[0.0, 0.0, 1.2], [0.2, 0.0, 1.2]], speed=0.1, acceleration=0.1)
    >>> cw.compare_loops(robot, way, controllers=("model", "paper"), estimators=["truth"])
    LoopComparison(status='ok', robot='merlet2023', trajectory='waypoints')
    """
    twin, start = machine_of(robot, machine), trajectory.poses[0]
    if trajectory.poses.shape[1] != robot.n:
        raise InputError(f"trajectory: poses of {robot.n} numbers are expected for {robot.name!r}, not {len(start)}")
    choices = (
        _named("controller", controllers, get_args(LawName), lambda name: partial(_OurLaw, name)),
        _named("estimator", estimators, (*get_args(EstimatorName), TRUTH), lambda name: partial(estimator, name)),
        _named("plant", plants, get_args(PlantName), lambda name: partial(_our_plant, twin, name)),
        seeds,
    )
    runs, loops = [], list(product(*choices))
    for k, ((law, controller), (name, observer), (kind, plant), seed) in enumerate(loops):
        (progress or silent)(f"{law}, {name}, {kind}, seed {seed}", k, len(loops))
        built = plant(robot, start, seed)
        truth = built.abilities.truth
        if truth is None:
            raise InputError(f"plant {kind}: its abilities have no truth, to which the loop is compared")
        seen = _TrueState(truth) if name == TRUTH else observer(robot, twin.owner, start)
        loop = _Loop(built, truth, seen, controller(robot, twin.owner), robot, twin.owner.winch.max_speed, law)
        runs.append(loop.run(trajectory, (law, name, kind, seed)))
    return LoopComparison(robot.name, trajectory, tuple(runs))


def _named(
    what: str, given: Sequence[str | _MadeT], known: Sequence[str], ours: Callable[[str], _MadeT]
) -> list[tuple[str, _MadeT]]:
    """Return names with the function that makes each. Raises `InputError`."""
    found: dict[str, _MadeT] = {}
    for each in given:
        name = each if isinstance(each, str) else getattr(each, "__name__", type(each).__name__)
        if isinstance(each, str) and each not in known:
            raise UnknownName(what, each, known)
        if name in found:
            raise InputError(f"{what} {name}: this name occurs twice; give each a name of its own")
        found[name] = ours(each) if isinstance(each, str) else each
    return list(found.items())


def _our_plant(twin: TwinSettings, kind: str, robot: Robot, start: Array, seed: int) -> Machine:
    return SimulatedMachine(robot, twin, start, seed=seed, plant=cast(PlantName, kind))


class _OurLaw:
    """A law of a print as a `LoopController`; errors count in time here, so it does not allow for the winches' lag."""

    def __init__(self, law: str, robot: Robot, settings: MachineSettings) -> None:
        model, speed = Model(with_drum_mass(robot, settings)), settings.winch.max_speed
        self._settings = velocity.VelocitySettings(model, speed, cast(LawName, law), manage_slack=False)
        self._state = velocity.start(self._settings)

    def __call__(self, estimate: Estimate, target: Target, period: float) -> Array:
        speeds = velocity.step(self._settings, self._state, estimate, target, period)
        hosts, rates = self._settings.hosts, np.zeros(self._settings.model.m)
        rates[hosts] = speeds * estimate.radii[hosts]
        return rates


class _TrueState:
    """An estimator that reports the truth."""

    def __init__(self, truth: Callable[[], Truth]) -> None:
        self._truth = truth

    def step(self, _frame: SensorFrame) -> Estimate:
        now = self._truth()
        told = now.time, now.position, now.velocity, now.rotation, now.lengths, now.excess
        return Estimate(*told, slack=now.excess > SLACK, radii=now.radii)


@dataclass
class _Loop:
    """One closed loop."""

    machine: Machine
    truth: Callable[[], Truth]
    observer: Observing
    controller: LoopController
    robot: Robot
    max_speed: float  # rad/s of a drum
    law: str

    def run(self, way: Trajectory, name: tuple[str, str, str, int]) -> LoopRun:
        """Follow the trajectory to its end, or until the machine cannot."""
        rows: list[tuple[float, float, float, float]] = []
        tensions, reason = [self.truth().tensions], ""
        self.machine.open()
        try:
            begin, frame, estimate = self._found()
            while (now := frame.time - begin) < way.duration:
                period = self.machine.period
                target, asked = _target(way, now, period), time.perf_counter()
                speeds = self._speeds(estimate, target, period)
                spent = time.perf_counter() - asked
                frame, read = self.machine.step(Command(frame.time, speeds)), time.perf_counter()
                estimate = self.observer.step(frame)
                spent += time.perf_counter() - read
                true = self.truth()
                error = np.linalg.norm(true.position - target.position - period * target.velocity)
                rows.append(
                    (now + period, float(error), float(np.linalg.norm(estimate.position - true.position)), spent)
                )
                tensions.append(true.tensions)
        except AnswerError as failed:
            reason = str(failed)
        finally:
            self.machine.close()
        columns = np.array(rows).reshape(-1, 4).T
        times, errors, estimate_errors, spent_times = columns
        return LoopRun(*name, times, errors, estimate_errors, np.array(tensions), spent_times, reason)

    def _found(self) -> tuple[float, SensorFrame, Estimate]:
        """Stand until the estimate is valid. Raises `AnswerError` where it does not become so."""
        still, now = np.zeros(len(self.robot.hosts)), 0.0
        while now <= _LONGEST_START:
            frame = self.machine.step(Command(now, still))
            estimate, now = self.observer.step(frame), frame.time
            if estimate.valid and np.isfinite(estimate.position).all():
                return now, frame, estimate
        raise AnswerError(f"the estimate is not valid after {_LONGEST_START:g} s")

    def _speeds(self, estimate: Estimate, target: Target, period: float) -> Array:
        """Return speeds (w,), rad/s, of the winch drums within the limit. Raises `InputError`."""
        rates = np.asarray(self.controller(estimate, target, period), dtype=np.float64)
        if rates.shape != (self.robot.m,) or not np.isfinite(rates).all():
            given = f"shape {rates.shape}" if rates.shape != (self.robot.m,) else f"{rates.tolist()}"
            raise InputError(f"controller {self.law}: {self.robot.m} finite rates, m/s, are expected, not {given}")
        hosts = list(self.robot.hosts)
        speeds = rates[hosts] / estimate.radii[hosts]
        largest = float(np.abs(speeds).max())
        return np.asarray(speeds * min(1.0, self.max_speed / largest) if largest else speeds)


def _target(way: Trajectory, now: float, period: float) -> Target:
    """Return the pose at *now*, s, and the mean velocities over the next *period*, s."""
    here, there, rate = (
        np.array([np.interp(at, way.times, column) for column in values.T])
        for at, values in ((now, way.poses), (now + period, way.poses), (now + 0.5 * period, way.velocities))
    )
    speed = (there[:3] - here[:3]) / period
    turned = (here[3:], rate[3:]) if len(here) == 6 else (np.zeros(3), np.zeros(3))
    return Target(here[:3], speed, 0.0, 1, float(np.linalg.norm(speed)), False, False, False, *turned)
