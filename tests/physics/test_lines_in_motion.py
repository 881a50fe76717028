"""Every kind of line moves by the laws of mechanics, and estimators know how it hangs and what winches pay out."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import out_of_plane
from cablewright.control.balance_check import balance
from cablewright.control.length_check import check_lengths
from cablewright.estimation.kalman.sag import Sag, balanced
from cablewright.estimation.slackness import SlacknessSettings
from cablewright.foundation.signals import Command, Encoders, SensorFrame
from cablewright.kernels.plant import dynamics
from cablewright.kernels.statics.equilibrium import evaluate, workspace
from cablewright.kernels.statics.line.interface import condense_moving_line, place_lines
from cablewright.kernels.statics.line.solved_line import end_of_line
from cablewright.live.estimators import estimator, reckoning_of
from cablewright.machine.simulated.settings import load_twin
from cablewright.machine.simulated.severities import with_severity
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.machine.simulated.unmodelled.exit_mounts import ExitMountState
from cablewright.machine.simulated.unmodelled.sheave_slip import SheaveSlip
from cablewright.models.fidelity import Fidelity
from cablewright.models.packed_views import LineStates
from cablewright.models.rotation import matrix_of, moved
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Eyelet, Robot, load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.taut import taut_at
from observer_runs import forces_at

BODIES = ("guides", "platform sheaves", "both", "platform pulleys", "mixed", "wheels", "several")
POINTS = ("guides", "tilted", "aside", "pulleys", "several")
ASLANT = ("aside", "pulleys", "platform pulleys", "mixed", "wheels")
"""Kinds whose cables run aslant into a groove, which is no shortest way: forces and lengths agree to 0.2 %."""

DT = 1e-3  # s


@cache
def robot_of(kind: str, body: bool) -> Robot:
    """A robot whose lines are of a kind; *several*: spans of an advantage of 2, and cables side by side."""
    if kind != "several":
        return out_of_plane.body(kind) if body else out_of_plane.point(kind)
    plain = load("cogiro" if body else "merlet2023")
    own = {"sheave": Eyelet(), "winch_exit": None, "platform_sheave": None}
    lines = [
        line.model_copy(update=own | {"advantage": 1 + i % 2, "cables": 1 + (i // 2) % 2})
        for i, line in enumerate(plain.lines)
    ]
    return out_of_plane.checked(plain.model_copy(update={"lines": tuple(lines)}))


class Moving:
    """A body on lines, from rest at a pose that is held; with its energy."""

    def __init__(self, kind: str, body: bool, cable: str = "catenary", relaxation: float = 0.0) -> None:
        self.robot = robot_of(kind, body)
        if body:
            self.robot = self.robot.with_platform(centre_of_mass=(0.0, 0.0, 0.0))
        self.model = Model(self.robot, Fidelity.of(cable))
        centre = 0.5 * np.add(self.robot.scene.frame_min, self.robot.scene.frame_max)
        pose = np.array([0.1, -0.2, 0.5 * centre[2], 0.02, -0.03, 0.05])[: self.robot.n]
        self.rest: Equilibrium = solve_forward(
            self.model, solve_inverse(self.model, pose).checked().lengths, guess=pose
        ).checked()
        self.mass, inertia = self.robot.platform.mass, np.array([3.0, 4.0, 5.0]) if body else np.ones(3)
        self.inertia = np.diag(inertia)
        numbers = np.zeros(dynamics.BODY)
        numbers[dynamics.MASS], numbers[dynamics.RELAXATION] = self.mass, relaxation
        numbers[dynamics.INERTIA : dynamics.INERTIA + 9] = self.inertia.ravel()
        self.body, self.lengths = numbers, self.rest.lengths.copy()
        self.states, self.motion = self.rest.states.copy(), np.zeros(dynamics.MOTION)
        self.motion[:3], self.motion[6 : 3 + self.robot.n] = self.rest.pose[:3], self.rest.pose[3:]
        self.work, self.swing = dynamics.moving_workspace(self.model.packed)

    @property
    def pose(self) -> np.ndarray:
        return self.motion[[0, 1, 2, 6, 7, 8][: self.robot.n]]

    def step(self, after: np.ndarray) -> np.ndarray:
        """Move on; return the tensions halfway."""
        given = (self.model.packed, self.body, self.motion, self.lengths, after, DT, self.states, self.work, self.swing)
        assert dynamics.midpoint_step(*given) == 0
        self.lengths = after.copy()
        return LineStates(self.states).tension

    def energy(self) -> float:
        """Of motion, height, and lines without weight that all are taut, J."""
        velocity, rate = self.motion[3:6], self.motion[9:12]
        turned = matrix_of(self.motion[6:9])
        kinetic = 0.5 * self.mass * velocity @ velocity + 0.5 * rate @ (turned @ self.inertia @ turned.T) @ rate
        height = self.mass * self.robot.scene.gravity * self.motion[2]
        return float(kinetic + height + self.elastic())

    def elastic(self) -> float:
        """Half of tension times stretch of every cable, J."""
        lines, states = self.model.lines, self.states.copy()
        stretch = taut_at(self.model, self.pose).lengths - self.lengths
        assert (stretch > 0.0).all()
        evaluate(self.model.packed, self.lengths, self.pose, states, self.work)
        for _ in range(20):  # the lines at this very pose, one Newton step after another
            worst, _, _ = evaluate(self.model.packed, self.lengths, self.pose, states, self.work)
            if worst < 1e-12:
                break
            still = np.zeros((self.robot.n, 1))
            pulled, turning = np.zeros(self.robot.n), np.zeros((3, 6))
            for i, row in enumerate(self.model.packed.lines):
                assert condense_moving_line(row, states[i], i, 0.0, self.work, self.work.spatial, pulled, turning)
                dynamics.advance_line(row, states[i], i, still, self.work, self.work.spatial)
        tensions = LineStates(states).tension
        return float((0.5 * lines.pulls / lines.spans * tensions * stretch).sum())


KINDS = [(kind, True) for kind in BODIES] + [(kind, False) for kind in POINTS]


@pytest.mark.parametrize(("kind", "body"), KINDS)
def test_a_machine_at_rest_stays_where_statics_have_it(kind: str, body: bool) -> None:
    moving = Moving(kind, body)
    for _ in range(20):
        moving.step(moving.lengths)
    assert moving.pose == pytest.approx(moving.rest.pose, abs=1e-9)
    assert LineStates(moving.states).tension == pytest.approx(moving.rest.tensions, rel=1e-6)


@pytest.mark.parametrize(("kind", "body"), KINDS)
def test_energy_is_what_winches_put_in(kind: str, body: bool) -> None:
    moving, work = Moving(kind, body, "elastic"), 0.0
    moving.motion[3:6] = 0.02, -0.01, 0.015
    cables, soft = moving.model.lines.pulls / moving.model.lines.spans, moving.model.lines.free_compliance
    begin = moving.energy()
    for k in range(60):
        rates = 0.004 * np.sin(np.arange(moving.robot.m) + 0.04 * k)
        tensions = moving.step(moving.lengths + DT * rates)
        given = tensions * (1.0 + 0.5 * tensions * soft)  # cable that is paid out has stretched already
        work += float((cables * given * rates).sum()) * DT
    # cable on sheaves does not stretch: what comes onto one loses the energy of its stretch
    within = 3e-4 if kind in ASLANT else 3e-5
    assert moving.energy() + work == pytest.approx(begin, abs=within * max(abs(work), 0.1))


@pytest.mark.parametrize(("kind", "body"), KINDS)
def test_lines_that_relax_only_take_energy(kind: str, body: bool) -> None:
    moving = Moving(kind, body, "elastic", relaxation=2e-3)
    moving.motion[3:6] = 0.02, -0.01, 0.015
    if body:
        moving.motion[9:12] = 0.02, 0.03, -0.02
    found = []
    for _ in range(8):
        for _ in range(10):
            moving.step(moving.lengths)
        found.append(moving.energy())
    assert (np.diff(found) < 1e-9).all()
    assert found[0] - found[-1] > 1e-4


@pytest.mark.parametrize("kind", BODIES)
def test_damping_pulls_at_the_end_of_the_span(kind: str) -> None:
    moving = Moving(kind, True)
    packed, work = moving.model.packed, moving.work
    evaluate(packed, moving.lengths, moving.pose, moving.states, work)
    for i, row in enumerate(packed.lines):
        pulled, turning = np.zeros(6), np.zeros((3, 6))
        work.stiffness[:], work.wrench[:] = 0.0, 0.0
        assert condense_moving_line(row, moving.states[i], i, 1.0, work, work.spatial, pulled, turning)
        arm = np.array(end_of_line(row, i, work, work.spatial))
        forces = work.stiffness[:3]
        scale = np.abs(work.stiffness).max()
        assert pytest.approx(work.stiffness[3:] - turning, abs=1e-9 * scale) == np.cross(arm, forces.T).T
        assert pulled[3:] == pytest.approx(np.cross(arm, pulled[:3]), abs=1e-9 * np.abs(pulled).max())


@pytest.mark.parametrize(("kind", "body"), KINDS)
def test_straight_lines_stretch_in_proportion_to_tension(kind: str, body: bool) -> None:
    model = Moving(kind, body).model
    pose = solve_inverse(model, np.array([0.2, 0.3, 1.5, 0.05, -0.02, 0.1])[: model.n]).pose
    step, found, within = 1e-5, taut_at(model, pose), 2e-3 if kind in ASLANT else 2e-8
    for k in range(model.n):
        motion = step * np.eye(model.n)[k]
        ahead, behind = (
            taut_at(model, moved(pose, way * motion) if model.n == 6 else pose + way * motion).lengths
            for way in (1.0, -1.0)
        )
        assert (ahead - behind) / (2.0 * step) == pytest.approx(found.per_motion[:, k], abs=within)


@pytest.mark.parametrize("kind", POINTS)
def test_estimators_and_checks_know_how_lines_hang_and_pull(kind: str) -> None:
    model = Model(robot_of(kind, False))
    found = solve_inverse(model, [0.3, -0.4, 1.2]).checked()
    taut, states = taut_at(model, found.pose), LineStates(found.states)
    forces = states.tension * np.cos(states.free_angle)
    sag = Sag.at(SlacknessSettings(model), taut, np.ones(model.m))
    excess = found.lengths - taut.lengths
    assert sag.excess(forces) == pytest.approx(excess, rel=0.06, abs=4e-4)
    weight = model.robot.platform.mass * model.robot.scene.gravity
    may_be = balanced(SlacknessSettings(model), taut, weight, 0.1 * weight)
    assert may_be is not None
    share = ((forces - may_be.forces[0]) / may_be.forces[1])[0]
    assert forces_at(may_be, np.array([share]))[0] == pytest.approx(forces, rel=0.02, abs=1.0)
    assert np.linalg.norm(balance(model, found.pose, found.tensions, 0.1).off) < 0.02 * weight
    judged = check_lengths(model, found.lengths, found.tensions, found.pose + 0.05)
    assert judged is not None
    assert judged.fits
    assert judged.pose == pytest.approx(found.pose, abs=2e-3)


@pytest.mark.parametrize("kind", POINTS)
def test_dead_reckoning_follows_winches(kind: str) -> None:
    robot = robot_of(kind, False)
    twin = load_twin("merlet2023").with_owner(robot=None)
    model, begin = Model(robot), np.array([0.3, -0.4, 1.2])
    reckoning = estimator("encoders", robot, twin.owner, begin)
    settings = reckoning_of(robot, twin.owner)
    there = solve_inverse(settings.model, np.array([0.31, -0.39, 1.19])).checked()
    first = solve_inverse(settings.model, begin).checked().lengths
    turned = [
        coil.angle(settings.total_length - out)
        for coil, out in zip(settings.coils, there.lengths.tolist(), strict=True)
    ]
    begun = [coil.angle(settings.total_length - out) for coil, out in zip(settings.coils, first.tolist(), strict=True)]
    counts = np.rint((np.array(begun) - turned) * settings.counts_per_radian).astype(np.int64)
    for k in range(1, 11):
        frame = SensorFrame(0.01 * k, (Encoders(0.01 * k, (counts * (k - 1)) // 9),), ())
        found = reckoning.step(frame)
    assert found.position == pytest.approx(there.pose, abs=1e-5)
    assert reckoning.tensions == pytest.approx(there.tensions, rel=1e-2)
    assert found.excess == pytest.approx(there.lengths - taut_at(model, there.pose).lengths, abs=1e-5)


@pytest.mark.parametrize("kind", ["guides", "tilted", "pulleys", "several"])
def test_exit_points_of_the_plant_give_as_mounts_in_statics(kind: str) -> None:
    robot, rng = robot_of(kind, False), np.random.default_rng(4)
    halves = 2e-3 * rng.normal(size=(4, 3, 3))
    soft = np.array([half @ half.T for half in halves])  # m/N
    lines = [
        line.model_copy(update={"exit_compliance": tuple(map(tuple, each.tolist()))})
        for line, each in zip(robot.lines, soft, strict=True)
    ]
    on_mounts = Model(out_of_plane.checked(robot.model_copy(update={"lines": tuple(lines)})))
    model = Model(robot)
    lengths = solve_inverse(model, [0.3, -0.4, 1.2]).checked().lengths
    firm = solve_forward(model, lengths, guess=[0.3, -0.4, 1.2]).checked()
    packed, pose, states = model.packed._replace(lines=model.packed.lines.copy()), firm.pose.copy(), firm.states.copy()
    work = workspace(packed)
    evaluate(packed, lengths, pose, states, work)
    assert ExitMountState(soft).close(packed, np.arange(4), lengths, pose, states, np.ones(4), work) == 0
    found = solve_forward(on_mounts, lengths, guess=firm.pose).checked()
    assert np.linalg.norm(found.pose - firm.pose) > 1e-3
    assert pose == pytest.approx(found.pose, abs=3e-6)
    assert LineStates(states).tension == pytest.approx(found.tensions, rel=3e-4)


def test_friction_acts_over_all_turns_of_the_cable() -> None:
    robot = robot_of("guides", False)
    model = Model(robot, Fidelity.of("elastic"))
    found = solve_inverse(model, [0.3, -0.4, 1.2]).checked()
    turned = np.array([line.dead_span().turned for line in robot.lines])
    slip = SheaveSlip(0.03, found.states, turned)
    states = found.states.copy()
    LineStates(states).free_length += 0.1  # paid out
    ratio = slip.slide(model.packed, states, found_planes(found))
    for i, line in enumerate(robot.lines):
        stops = np.array([line.winch_exit, *line.guides, line.exit_point, found.pose])
        ways = np.diff(stops, axis=0) / np.linalg.norm(np.diff(stops, axis=0), axis=1)[:, None]
        angle = np.arccos(np.clip((ways[1:] * ways[:-1]).sum(axis=1), -1.0, 1.0)).sum()
        assert ratio[i] == pytest.approx((1.0 - 0.03) ** (angle / (0.5 * np.pi)), rel=1e-6)


def found_planes(found: Equilibrium) -> np.ndarray:
    """The planes of the lines of an equilibrium."""
    work = workspace(found.model.packed)
    place_lines(found.model.packed, found.pose, work)
    return work.planes


def test_a_machine_goes_on_from_a_snapshot_to_the_bit_and_both_plants_hold_it() -> None:
    robot, pose = robot_of("mixed", True), np.array([0.3, -0.2, 1.5, 0.0, 0.0, 0.0])
    twin = with_severity(load_twin("cogiro"), "typical").with_owner(robot=None)
    speeds = 0.2 * np.sin(np.arange(8.0))
    first = SimulatedMachine(robot, twin, pose, seed=5)
    for k in range(1, 16):
        first.step(Command(0.01 * k, speeds))
    second = SimulatedMachine.resumed(robot, twin, first.snapshot(), seed=5)
    for k in range(16, 26):
        for each in (first, second):
            each.step(Command(0.01 * k, -speeds))
        for name in ("position", "rotation", "tensions", "excess", "lengths"):
            assert getattr(first.truth, name).tolist() == getattr(second.truth, name).tolist()
    ideal = load_twin("cogiro").with_owner(robot=None)
    swings, still = (SimulatedMachine(robot, ideal, pose, seed=5, plant=plant) for plant in ("dynamic", "quasi-static"))
    for k in range(1, 101):
        swings.step(Command(0.01 * k, np.zeros(8)))
    still.step(Command(0.2, np.zeros(8)))
    assert swings.truth.position == pytest.approx(still.truth.position, abs=2e-6)
    assert swings.truth.tensions == pytest.approx(still.truth.tensions, rel=2e-3)
