"""Counterweights and shared winches move by the laws of mechanics: energy, momentum, Atwood, and statics at rest."""

from __future__ import annotations

import numpy as np
import pytest

import shared_winch_robots
from cablewright.foundation.signals import Command, Encoders
from cablewright.kernels.layout import COUNTERWEIGHT
from cablewright.kernels.plant import counterweights, dynamics, winding
from cablewright.machine.simulated.machine_file import built_machine
from cablewright.machine.simulated.severities import with_severity
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.machine.simulated.winches import Winches
from cablewright.models.fidelity import Fidelity
from cablewright.models.packed_views import LineStates
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.taut import taut_at

DT = 1e-3  # s
PLACE = np.array([0.1, 0.2, 1.0])


class Hoisted:
    """A point on lines of a hoist, with its energy; *only*: these lines alone."""

    def __init__(self, robot: Robot, place: np.ndarray, only: list[int]) -> None:
        self.robot, self.model = robot, Model(robot, Fidelity.of("elastic"))
        rest = solve_inverse(self.model, place).checked()
        packed = self.model.packed
        self.packed = packed._replace(lines=packed.lines[only].copy())
        self.only, self.lengths, self.states = only, rest.lengths[only].copy(), rest.states[only].copy()
        self.body, self.motion = np.zeros(dynamics.BODY), np.zeros(dynamics.MOTION)
        self.body[dynamics.MASS], self.motion[:3] = robot.platform.mass, place
        self.body[dynamics.INERTIA : dynamics.INERTIA + 9] = np.eye(3).ravel()
        self.work, self.swing = dynamics.moving_workspace(self.packed)
        self.hung = only.index(3)
        own, row, line = self.swing.weights[self.hung], self.packed.lines[self.hung], robot.lines[3]
        assert line.counterweight is not None
        self.mass = line.counterweight
        own[: counterweights.SPEED] = self.mass / line.cables, row[COUNTERWEIGHT], 1.0
        row[COUNTERWEIGHT] = 0.0

    @property
    def speed(self) -> float:
        return float(self.swing.weights[self.hung, counterweights.SPEED])

    def step(self, rates: np.ndarray) -> np.ndarray:
        """Move on as winches pay out at *rates*, m/s; return the tensions halfway."""
        after = self.lengths + DT * rates
        own = (self.swing.weights, self.packed.lines, self.states, DT)
        counterweights.hang(*own, self.lengths, after)
        given = (self.packed, self.body, self.motion, self.lengths, after, DT, self.states, self.work, self.swing)
        assert dynamics.midpoint_step(*given) == 0
        self.lengths[:] = after
        counterweights.rise(*own, self.lengths, True)
        return LineStates(self.states).tension

    def energy(self) -> float:
        """Of motion, of heights, and of cables that stretch, J."""
        gravity, lines = self.robot.scene.gravity, self.model.lines
        kinetic = 0.5 * self.robot.platform.mass * self.motion[3:6] @ self.motion[3:6] + 0.5 * self.mass * self.speed**2
        height = self.robot.platform.mass * gravity * self.motion[2] + self.mass * gravity * self.lengths[self.hung]
        taut = taut_at(self.model, self.motion[:3]).lengths[self.only]
        assert (taut > self.lengths).all()
        rates = 1.0 / lines.free_compliance[self.only] / self.lengths  # of cable that stretches along its whole length
        return float(kinetic + height + 0.5 * (rates * (taut - self.lengths) ** 2).sum())


@pytest.mark.parametrize("dead", [True, False])
def test_energy_of_a_hoist_is_what_its_winches_put_in(dead: bool) -> None:
    hoisted, work = Hoisted(shared_winch_robots.hoist(dead), PLACE, [0, 1, 2, 3]), 0.0
    hoisted.motion[3:6] = 0.01, -0.005, 0.02
    begin, soft = hoisted.energy(), hoisted.model.lines.free_compliance
    for k in range(400):
        rates, risen = np.append(0.01 * np.sin(np.arange(3) + 0.01 * k), 0.0), hoisted.lengths[3]
        tensions = hoisted.step(rates)
        given = tensions * (1.0 + 0.5 * tensions * soft)  # cable that is paid out has stretched already
        work += float((given * rates).sum()) * DT + 0.5 * tensions[3] ** 2 * soft[3] * (hoisted.lengths[3] - risen)
    assert abs(hoisted.speed) > 1e-3
    assert hoisted.energy() + work == pytest.approx(begin, abs=1e-6)


@pytest.mark.parametrize("advantage", [1, 2])
def test_platform_and_counterweight_alone_are_an_atwood_machine(advantage: int) -> None:
    robot = shared_winch_robots.hoist(
        False, advantage=advantage, counterweight=8.0, cable=shared_winch_robots.CABLE | {"axial_stiffness": 6e8}
    )
    hoisted, carried, hung = Hoisted(robot, np.array([0.0, 0.0, 1.0]), [3]), robot.platform.mass, 8.0
    for _ in range(200):
        hoisted.step(np.zeros(1))
    # by energy: m v^2 / 2 + M (s v)^2 / 2, with s spans, of the load that falls under (m - s M) g
    own = (carried - advantage * hung) * robot.scene.gravity / (carried + advantage**2 * hung)
    assert hoisted.motion[5] == pytest.approx(-0.2 * own, rel=2e-3)
    assert hoisted.speed == pytest.approx(0.2 * advantage * own, rel=2e-3)
    momentum = carried * hoisted.motion[5] - hung * advantage * hoisted.speed  # each cable pulls both equally
    assert momentum == pytest.approx(-0.2 * robot.scene.gravity * (carried - advantage * hung), rel=2e-3, abs=1e-9)


@pytest.mark.parametrize(
    "robot",
    [shared_winch_robots.hoist(), shared_winch_robots.hoist(cables=2), shared_winch_robots.pairs()],
    ids=["hoist", "two", "pairs"],
)
@pytest.mark.parametrize("plant", ["dynamic", "quasi-static"])
def test_a_machine_at_rest_is_where_forward_has_it(robot: Robot, plant: str) -> None:
    settings = with_severity(built_machine(robot)[0], "ideal")
    machine = SimulatedMachine(robot, settings, PLACE, seed=1, plant=plant)  # type: ignore[arg-type]
    seen, w, steps = (), robot.winches, 600 if plant == "dynamic" else 20
    for _ in range(50 if plant == "dynamic" else 2):  # it stays at rest
        machine.step(Command(machine.time, np.zeros(w)))
    begun = solve_forward(
        Model(machine.robot), machine.truth.lengths, guess=np.append(PLACE, np.zeros(robot.n - 3))
    ).checked()
    assert machine.truth.position == pytest.approx(begun.pose[:3], abs=1e-6)
    for k in range(steps):
        turns = np.sin(np.pi * min(k / (0.2 * steps), 1.0)) * np.linspace(0.1, 0.2, w)
        frame = machine.step(Command(machine.time, turns))
        seen = frame.of(Encoders) or seen
        assert not frame.notices
    truth = machine.truth
    counts = seen[0].counts
    assert counts.shape == (w,)
    at = np.concatenate([truth.position, truth.rotation])[: robot.n]
    rest = solve_forward(Model(machine.robot), truth.lengths, guess=at).checked()
    assert at == pytest.approx(rest.pose, abs=1e-6 if plant == "quasi-static" else 3e-5)  # it still swings a little
    assert truth.lengths == pytest.approx(rest.lengths, abs=3e-5)


@pytest.mark.parametrize("winds", ["along", "against"])
def test_lines_on_one_drum_follow_its_turn_and_its_motor_has_the_torque_of_both(winds: str) -> None:
    robot = shared_winch_robots.two_on_one(winds)
    twin = built_machine(robot)[0]
    walk = twin.simulation.winch.model_copy(update={"radius_walk": 0.0, "sideways_walk": 0.0})
    winches = Winches(robot, twin.owner.winch, walk, np.array([2.0, 1.5]), 0)
    sense, radius = (1.0 if winds == "along" else -1.0), 0.04

    def turned(speed: float, tensions: tuple[float, float], most: float) -> tuple[np.ndarray, int]:
        drums = (winches.state, np.array([9.0, 0.0, most]), winches.radii, winches.wound, winches.sideways)
        lengths, flags = np.array([2.0, 1.5]), np.zeros(2, dtype=np.int64)
        winding.turn_winches(*drums, winches.by_line(np.array([speed])), np.array(tensions), 0.1, lengths, flags)
        assert flags[1] == 0
        return lengths, int(flags[0])

    before = winches.counts
    lengths, flags = turned(-2.0, (100.0, 50.0), 1.01 * radius * (100.0 + sense * 50.0))
    assert flags == 0
    assert lengths - (2.0, 1.5) == pytest.approx([-0.2 * radius, -0.2 * radius * sense], rel=1e-6)
    assert winches.counts.shape == (1,)
    assert winches.counts[0] < before[0]
    _, flags = turned(-2.0, (100.0, 50.0), 0.99 * radius * (100.0 + sense * 50.0))
    assert flags == winding.STALLED
