"""What users write, a function each, for a type checker: none is run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import cablewright as cw

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
POSE = [0.3, 0.2, 2.0]


def robot() -> cw.Robot:
    return cw.load("cogiro")


def from_file(file: Path) -> cw.Robot:
    return cw.load(file)


def from_text(text: str) -> cw.Robot:
    return cw.loads(text, "mine.toml")


def from_points(exits: Array) -> cw.Robot:
    return cw.Robot.from_points(exits, mass=5.0, cable="dyneema-2mm", tension_limits=(1.0, 500.0))


def from_both(exits: Array, ends: Array) -> cw.Robot:
    return cw.Robot.from_points(
        exits, ends, mass="5 kg", cable="steel-4mm", tension_limits=("1 N", 5e2), inertia=(1, 1, 1)
    )


def heavier(robot: cw.Robot) -> cw.Robot:
    return robot.with_(mass=80.0, tension_limits=(10.0, 1e3))


def moved(robot: cw.Robot) -> cw.Robot:
    return robot.with_(exit_points=robot.exit_points + 0.1)


def varied(robot: cw.Robot) -> cw.Robot:
    return cw.changed(robot, {"exit_point.z": 8.0})


def varied_by(robot: cw.Robot) -> cw.Robot:
    return cw.changed(robot, {cw.Change("mass"): 8.0})


def names(robot: cw.Robot) -> list[str]:
    return [line.name for line in robot.lines]


def lengths(robot: cw.Robot) -> Array:
    return cw.inverse(robot, POSE).lengths


def tensions(robot: cw.Robot, poses: Array) -> Array:
    return cw.inverse(robot, poses, cable="elastic").tensions


def rows(robot: cw.Robot, poses: Array) -> list[Array]:
    return [row.pose for row in cw.inverse(robot, poses)]


def there_and_back(robot: cw.Robot) -> Array:
    return cw.forward(robot, cw.inverse(robot, POSE).checked().lengths).pose


def model() -> cw.Model:
    return cw.Model(cw.load("cogiro"), cw.Fidelity(cw.CableLaw.ELASTIC))


def jacobian(robot: cw.Robot) -> Array:
    return cw.jacobian(robot, POSE)


def jacobians(robot: cw.Robot, poses: Array) -> Array:
    return cw.jacobian(robot, poses, retraction=1.0)


def structure(robot: cw.Robot) -> Array:
    return cw.structure_matrix(robot, POSE) @ np.ones(robot.m)


def speeds(robot: cw.Robot, twist: Array) -> Array:
    return np.asarray(cw.jacobian(robot, POSE) @ twist)


def stiffness(robot: cw.Robot) -> Array:
    return cw.stiffness(robot, POSE).total


def stiffness_held(hold: cw.Equilibrium) -> cw.Stiffness:
    return cw.stiffness(hold)


def stiffness_rigid(robot: cw.Robot) -> Array:
    return cw.stiffness(robot, POSE, cable="rigid", tension_limits=(5.0, 100.0)).elastic


def softest(robot: cw.Robot) -> float:
    return float(np.linalg.eigvalsh(np.asarray(cw.stiffness(robot, POSE)))[0])


def hertz(robot: cw.Robot) -> Array:
    return cw.natural_frequencies(robot, POSE)


def hertz_held(hold: cw.Equilibrium) -> Array:
    return cw.natural_frequencies(hold)


def lowest(robot: cw.Robot, poses: Array) -> float:
    return float(np.nanmin(cw.natural_frequencies(robot, poses)))


def modes(robot: cw.Robot) -> cw.Modes:
    return cw.modes(robot, POSE, geometric=False)


def condition(robot: cw.Robot) -> float:
    return float(cw.dexterity(robot, POSE, length=0.5).condition_number)


def condition_of_stiffness(robot: cw.Robot) -> Array:
    return cw.dexterity(robot, [POSE, POSE], of="stiffness").dexterity


def facets(robot: cw.Robot) -> tuple[Array, Array]:
    found = cw.available_wrenches(robot, POSE)
    return found.normals, found.offsets


def margin(robot: cw.Robot, poses: Array) -> Array:
    return cw.available_wrenches(robot, poses, length=0.5).margin


def inside(robot: cw.Robot, wrench: Array) -> bool:
    return bool(cw.available_wrenches(robot, POSE).contains(wrench))


def corners(robot: cw.Robot) -> Array:
    return cw.available_wrenches(robot, POSE).vertices(moment=(0.0, 0.0, 1.0))


def capacity(robot: cw.Robot) -> Array:
    return cw.capacity(robot, POSE, box=([-1.0] * 6, [1.0] * 6)).margin


def methods(robot: cw.Robot) -> tuple[str, ...]:
    return cw.compare_tensions(robot, POSE, ["exact", cw.Quadratic(np.ones(8))]).methods


def chosen(robot: cw.Robot) -> Array:
    return cw.tension_distribution(robot, POSE, "exact", wrench=[0.0] * 6).tensions


def closed(robot: cw.Robot) -> bool:
    return bool(cw.wrench_closure(robot, POSE).feasible)


def linear(hold: cw.Equilibrium) -> Array:
    return cw.linearise(hold).per_length


def by_exit(hold: cw.Equilibrium) -> Array:
    return cw.linearise(hold).per_exit_point


def proof(hold: cw.Equilibrium) -> bool:
    return bool(cw.certify(hold).certified)


def straight(points: Array) -> cw.Trajectory:
    return cw.Trajectory.through(points, speed=0.5, acceleration=1.0)


def smooth(points: Array) -> float:
    return cw.Trajectory.spline(points, 8.0).max_speed


def of_file(robot: cw.Robot, file: Path) -> cw.Trajectory:
    return cw.Trajectory.of_job(robot, file, duration=30.0)


def power(robot: cw.Robot, way: cw.Trajectory) -> Array:
    return cw.inverse_dynamics(robot, way).max_power


def feasible(robot: cw.Robot, way: cw.Trajectory) -> bool:
    return cw.inverse_dynamics(robot, way, cable="rigid").feasible


def simulated(way: cw.Trajectory) -> list[Array]:
    return cw.simulate(cw.load("merlet2023"), trajectory=way).drive.poses


def held(robot: cw.Robot) -> cw.Simulation:
    return cw.simulate(robot, hold=POSE, duration=2.0, plant="quasi-static")


def figure(found: cw.Modes) -> Figure:
    return found.plot()


def paper(found: cw.Modes, file: Path) -> Figure:
    return found.plot(file, width="one-column", style={"font.size": 8.0})


def styled(found: cw.WrenchPolytope) -> Figure:
    return found.plot("w.svg", width=0.12, style=Path("mine.mplstyle"))


def errors(robot: cw.Robot) -> cw.AccuracyAtPose:
    return cw.accuracy(robot, POSE)


def many_errors(robot: cw.Robot, poses: Array) -> Array:
    found = cw.accuracy(robot, poses, method=cw.FirstOrder())
    assert isinstance(found, cw.Accuracy)  # of several poses
    return found.nominal_error


def over_plane(robot: cw.Robot) -> cw.AccuracyStudy:
    return cw.accuracy(robot, cw.Places.plane(robot, 1.0, 4.0, 2.0), method=cw.Vertices())


def volume(robot: cw.Robot) -> float:
    return cw.workspace(robot, "closed-form", tolerance=0.05).volume


def counted(robot: cw.Robot) -> int:
    return cw.count_nodes(robot, "exact", grid=9).counted


def area(robot: cw.Robot) -> float:
    return cw.workspace_area(robot, "exact", box=[-1, 1, -1, 1, 0.8, 0.8]).area


def checked(robot: cw.Robot) -> str:
    return cw.check(robot, cw.load_job("part.gcode")).verdict


def calibrated(robot: cw.Robot) -> cw.Robot:
    return cw.calibrate(robot, "calibration.csv").robot


def guessed(robot: cw.Robot) -> cw.SimulatedCalibration:
    return cw.simulate_calibration(robot, 20, 1e-4, seed=1)


def plain(found: cw.Result) -> dict[str, object]:
    return found.to_dict()


def refused(robot: cw.Robot) -> str:
    try:
        cw.inverse(robot, POSE).checked()
    except cw.AnswerError as reason:
        return str(reason)
    return ""


def objective(robot: cw.Robot) -> Callable[[Array], Array]:
    return lambda pose: cw.inverse(robot, pose).lengths


def turned(robot: cw.Robot) -> cw.View:
    return cw.view(cw.inverse(robot, POSE), height=500)


def solved() -> list[float]:
    return [problem.error(problem.solve()[0]) for problem in cw.problems("margin")]


class Proportional:
    def __init__(self, robot: cw.Robot, settings: cw.MachineSettings) -> None:
        self.robot = robot

    def __call__(self, estimate: cw.Estimate, target: Any, period: float) -> Array:
        return np.asarray(cw.jacobian(self.robot, estimate.position) @ target.velocity)


def compared(robot: cw.Robot, way: cw.Trajectory) -> cw.LoopComparison:
    return cw.compare_loops(robot, way, controllers=["model", Proportional], estimators=("truth",), seeds=range(3))
