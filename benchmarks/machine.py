"""The simulated machine beside the clock, and beside MuJoCo; one thread. As a command: the integrators compared.

`python -m benchmarks.machine` prints the table of docs/decisions/0009: a drum dropped by 2 mm, by implicit midpoint and
by velocity Verlet, which settles the lines at each step.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from benchmarks.timing import Row, best, installed
from cablewright.control.guard import GuardSettings, GuardState, judge
from cablewright.foundation.signals import Command, Drives, DriveState, Encoders, Inputs, SensorFrame, Tensions
from cablewright.kernels.layout import FREE, PHI, TAU, WEIGHT
from cablewright.kernels.plant import dynamics
from cablewright.kernels.statics.line.upright import settle
from cablewright.live.drive_along_path import DriveSettings, Pilot, random_loop
from cablewright.machine.simulated.plant_parts.load_mass import Masses
from cablewright.machine.simulated.settings import TwinSettings, load_twin
from cablewright.machine.simulated.severities import with_severity
from cablewright.machine.simulated.simulated_machine import PlantName, SimulatedMachine
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.solvers.inverse import solve_inverse

Array = NDArray[np.float64]
START = (0.3, -1.0, 1.2)
AIMS = {"dynamic": 20.0, "quasi-static": 500.0}
SENSORS = ("inertial", "line_angles", "distance", "encoders", "climate_sensor")
DROP = 2e-3  # m
DROPPED = 0.5  # s that the integrators are compared over
FINE = 0.125e-3  # s, the step of the reference
FULL: dict[PlantName, float] = {"dynamic": 10.0, "quasi-static": 60.0}  # s of a drive
QUICK: dict[PlantName, float] = {"dynamic": 0.1, "quasi-static": 1.0}


def rows(seconds: dict[PlantName, float]) -> Iterator[Row]:
    """All rows of this file."""
    full = load_twin("merlet2023")
    bare = full.with_owner(lidars={}, **dict.fromkeys(SENSORS))
    for plant, settings, what in (
        ("dynamic", full, "with all sensors"),
        ("dynamic", bare, "alone"),
        ("quasi-static", full, "with all sensors"),
        ("quasi-static", bare, "alone"),
    ):
        ratio = speed(settings, plant, seconds[plant])
        aim = AIMS[plant] if what == ("alone" if plant == "quasi-static" else "with all sensors") else None
        told = "" if aim is None else f">= {aim:.0f}"
        yield Row(f"merlet2023: {plant} plant, {what}", ratio, "x real", told, None if aim is None else ratio >= aim)
    yield from bodies(seconds)
    yield from unmodelled(seconds)
    guarded = guard_time()
    yield Row(
        "the guard, a step: 8 lines, encoders, load cells, drives", 1e6 * guarded, "us", "<= 20", guarded <= 20e-6
    )
    each = step_time(full)
    yield Row("merlet2023: a dynamic step of 2 ms", 1e6 * each, "us")
    if installed("mujoco"):
        theirs = mujoco_time(load("merlet2023"), full.simulation.substep)
        name = "merlet2023: MuJoCo's step, tendons without weight"
        yield Row(name, 1e6 * theirs, "us", peer="ours", ratio=theirs / each)


def bodies(seconds: dict[PlantName, float]) -> Iterator[Row]:
    """cogiro, a body on eight lines with all sensors of its machine, once round a circle and again."""
    twin, angles = load_twin("cogiro"), np.linspace(0.0, 2.0 * np.pi, 401)
    way = np.column_stack([np.cos(angles), np.sin(angles)])
    slow = twin.with_simulation(quasi_static_period=1.0)
    for plant, settings, length in (("dynamic", twin, seconds["dynamic"]), ("quasi-static", slow, 600.0)):
        machine = SimulatedMachine(load("cogiro"), settings, [1.0, 0.0, 1.0], seed=1, plant=plant)
        ratio = ratio_of(machine, Pilot(machine, way, DriveSettings(), 1), length)
        if plant == "dynamic":
            yield Row("cogiro: dynamic plant, with all sensors", ratio, "x real", ">= 20", ratio >= 20.0)
        else:
            steps = ratio / machine.period
            yield Row("cogiro: quasi-static plant, steps of 1 s", steps, "steps/s", ">= 800", steps >= 800.0)


def unmodelled(seconds: dict[PlantName, float]) -> Iterator[Row]:
    """Plants without sensors, with all that no model has on ``rough`` over without, by processor time."""
    places = {"merlet2023": START, "house-printer": (0.0, 0.0, 0.5), "cogiro": (0.0, 0.0, 1.0)}
    for name, place in places.items():
        twin = load_twin(name)
        bare = twin.with_owner(lidars={}, **dict.fromkeys(SENSORS))
        rough = with_severity(bare, "rough", ("creep", "hysteresis", "exits", "sheaves", "gears", "wind"))
        for plant, length in seconds.items():
            made = [SimulatedMachine(load(name), each, place, seed=1, plant=plant) for each in (bare, rough)]
            ratio = slower(*made, length)
            yield Row(f"{name}: {plant} plant, with what no model has", ratio, "x time", "<= 2", ratio <= 2.0)


def slower(plain: SimulatedMachine, other: SimulatedMachine, seconds: float) -> float:
    """Processor time of *other* over that of *plain* for motions of so many *seconds*, the best of five."""
    best_times = [math.inf, math.inf]
    for turn in range(6):  # the first compiles
        for i, machine in enumerate((plain, other)):
            begin = time.process_time()
            for _ in range(round(seconds / machine.period)):
                machine.step(Command(machine.time, 0.2 * np.cos(np.arange(machine.robot.m) + machine.time)))
            if turn:
                best_times[i] = min(best_times[i], time.process_time() - begin)
    return best_times[1] / best_times[0]


def guard_time() -> float:
    """Seconds of one step of the guard on a machine with 8 lines and all that it reads."""
    m = 8
    limits = GuardSettings(
        np.full(m, 900.0),
        max_torques=np.full(m, 50.0),
        max_drum_speed=20.0,
        max_following_error=0.1,
        counts_per_radian=1e4,
        timeouts={"encoders": 0.5, "load_cells": 0.1, "drives": 0.1},
    )
    quiet = np.zeros(m)
    frames = [
        SensorFrame(
            0.01 * k,
            (
                Encoders(0.01 * k, np.full(m, k, dtype=np.int64)),
                Tensions("load_cells", 0.01 * k, np.full(m, 300.0)),
                Drives(0.01 * k, (DriveState.ENABLED,) * m, quiet, quiet, quiet, quiet, ("",) * m),
                Inputs(0.01 * k, chain_closed=True, torque_off=False, enabling=True, brakes_closed=()),
            ),
        )
        for k in range(1, 2001)
    ]
    inferred = np.full(m, 300.0)

    def run() -> None:
        state = GuardState()
        for frame in frames:
            assert judge(limits, state, frame, inferred) is None

    return best(run) / len(frames)


def speed(settings: TwinSettings, plant: PlantName, seconds: float) -> float:
    """Times real time of a drive round a loop, six times so many *seconds*: what the pilot takes is not counted."""
    robot = load("merlet2023")
    way = random_loop(robot, 28.0, seed=1)
    machine = SimulatedMachine(robot, settings, [*way[0], 1.2], seed=1, plant=plant)
    return ratio_of(machine, Pilot(machine, way, DriveSettings(), 1), seconds)


def ratio_of(machine: SimulatedMachine, pilot: Pilot, seconds: float) -> float:
    """Times real time of six drives of so many *seconds*, the best but for the first."""
    ratios = []
    steps = round(seconds / machine.period)
    for _ in range(6):  # the first compiles
        spent = 0.0
        for _ in range(steps):
            command = pilot.command()
            begin = time.perf_counter()
            machine.step(command)
            spent += time.perf_counter() - begin
        ratios.append(steps * machine.period / spent)
    return max(ratios[1:])


def step_time(settings: TwinSettings) -> float:
    """Time of one step of the drum and its lines, swinging, s."""
    drop = Drop(settings)
    drop.motion[dynamics.RATE : dynamics.RATE + 3] = 0.2, 0.1, 0.3

    def hundred() -> None:
        for _ in range(100):
            drop.midpoint(settings.simulation.substep)

    return best(hundred, 50) / 100.0


def mujoco_time(robot: Robot, step: float) -> float:
    """Time of MuJoCo's step, s: the drum on a ball joint, lines as springs without weight through eyelets."""
    import mujoco

    held = solve_inverse(Model(robot), START).checked()
    tendons, sites = "", ""
    for i, (line, length) in enumerate(zip(robot.lines, held.lengths, strict=True)):
        begin = line.winch_exit or line.exit_point
        sites += f'<site name="C{i}" pos="{_text(begin)}"/><site name="A{i}" pos="{_text(line.exit_point)}"/>'
        path = f'<site site="C{i}"/><site site="A{i}"/><site site="B"/>'
        stiffness = line.cable.stiffness / length
        tendons += f'<spatial stiffness="{stiffness}" springlength="0 {length}">{path}</spatial>'
    slides = "".join(f'<joint type="slide" axis="{axis}"/>' for axis in ("1 0 0", "0 1 0", "0 0 1"))
    drum = '<inertial pos="0 0 -0.5" mass="40" diaginertia="3 3 1"/>'
    hung = f'<body><joint type="ball"/>{drum}</body>'
    knot = '<inertial pos="0 0 0" mass="1e-3" diaginertia="1e-6 1e-6 1e-6"/>'
    body = f'<body pos="{_text(START)}">{slides}{knot}<site name="B"/>{hung}</body>'
    text = f'<mujoco><option timestep="{step}" integrator="implicit"/><worldbody>{sites}{body}</worldbody>'
    model = mujoco.MjModel.from_xml_string(f"{text}<tendon>{tendons}</tendon></mujoco>")
    data = mujoco.MjData(model)
    return best(lambda: mujoco.mj_step(model, data, 100), 50) / 100.0


def _text(vector: tuple[float, ...]) -> str:
    return " ".join(map(repr, vector))


class Drop:
    """The empty drum at rest over START, lifted by DROP, undamped."""

    def __init__(self, settings: TwinSettings) -> None:
        """Hang it."""
        robot = load("merlet2023")
        self.model = Model(robot)
        held = solve_inverse(self.model, START).checked()
        self.lengths, self.states = held.lengths.copy(), held.states.copy()
        masses = Masses(robot, settings)
        self.drum = masses.constant()
        masses.put(0.0, 0.0, math.nan, self.drum)
        self.drum[dynamics.DRAG :] = 0.0
        self.motion = np.zeros(dynamics.MOTION)
        self.motion[:3] = START
        self.motion[2] += DROP
        self.work, self.swing = dynamics.moving_workspace(self.model.packed)

    def midpoint(self, dt: float) -> None:
        """One step of the implicit midpoint rule."""
        lengths = (self.lengths, self.lengths)
        state = (self.states, self.work, self.swing)
        assert dynamics.midpoint_step(self.model.packed, self.drum, self.motion, *lengths, dt, *state) == 0

    def verlet(self, dt: float) -> None:
        """One step of velocity Verlet, of B alone: the drum hangs straight."""
        place, velocity = self.motion[:3], self.motion[3:6]
        velocity += 0.5 * dt * self.force() / self.drum[dynamics.MASS]
        place += dt * velocity
        velocity += 0.5 * dt * self.force() / self.drum[dynamics.MASS]

    def force(self) -> Array:
        """What acts on B, N: the lines settled where it is."""
        total = np.array([0.0, 0.0, -9.81 * self.drum[dynamics.MASS]])
        for row, y, length in zip(self.model.packed.lines, self.states, self.lengths, strict=True):
            away = self.motion[:2] - row[:2]
            x = math.hypot(*away)
            assert settle(row, x, self.motion[2] - row[2], length, y, np.zeros((6, 6)), np.zeros((6, 3)))
            h, v = math.exp(y[TAU]) * math.cos(y[PHI]), math.exp(y[TAU]) * math.sin(y[PHI])
            total -= [*(h * away / x), v + row[WEIGHT] * y[FREE]]
        return total


def height_after(method: str, dt: float) -> tuple[float, float]:
    """Where B is after DROPPED, m, and the highest it was; NaN where it is lost."""
    drop, highest = Drop(load_twin("merlet2023")), -math.inf
    for _ in range(round(DROPPED / dt)):
        try:
            getattr(drop, method)(dt)
        except AssertionError:
            return math.nan, math.nan
        highest = max(highest, float(drop.motion[2]))
    return float(drop.motion[2]), highest


def main() -> None:
    """Print the table."""
    methods = ("midpoint", "verlet")
    exact = {method: height_after(method, FINE)[0] for method in methods}  # Verlet's drum does not swing
    print(f"{'step':>8}  {'midpoint: off by':>18} {'at most':>10}  {'Verlet: off by':>16} {'at most':>10}")
    for dt in (0.5e-3, 1e-3, 2e-3, 5e-3, 10e-3, 25e-3, 50e-3):
        parts = [f"{1e3 * dt:6.1f} ms"]
        for method in methods:
            end, highest = height_after(method, dt)
            parts.append(f"{1e3 * (end - exact[method]):13.3f} mm {1e3 * (highest - START[2]):9.2f} mm")
        print("  ".join(parts))


if __name__ == "__main__":
    sys.exit(main())
