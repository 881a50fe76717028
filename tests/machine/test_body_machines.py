"""Simulated machines with bodies: rest, both plants, material, retraction, faults of lines, as built, snapshots."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import (
    BeamLength,
    Command,
    Condition,
    Encoders,
    Inertial,
    Reading,
    Scan,
    SensorFrame,
    Swivels,
    Tensions,
)
from cablewright.kernels.plant.machine_step import carry_ends
from cablewright.machine.settings import RoomSettings
from cablewright.machine.simulated.machine_file import machine_file
from cablewright.machine.simulated.settings import FaultPlan, TwinSettings, load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.models.rotation import matrices
from cablewright.models.statics import Model
from cablewright.robot import Robot, load
from cablewright.robot.winch import Winch
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from twins import changed

Array = NDArray[np.float64]
STARTS = {"cogiro": (0.5, -0.4, 1.0), "jung2020": (0.1, 0.05, 0.5), "ipanema": (0.2, 0.1, 0.8)}
EXACT = {"anchor": 0.0, "sheave_radius": 0.0, "modulus": 0.0, "home_length": 0.0, "drum_radius": 0.0, "mass": 0.0}
DAMPED = {
    "cogiro": {"drag": 900.0, "turn_damping": 300.0},
    "jung2020": {"drag": 60.0, "turn_damping": 0.1},
    "ipanema": {"drag": 300.0, "turn_damping": 10.0},
}
PLANTS = ("dynamic", "quasi-static")


def still(name: str, **tables: dict[str, Any]) -> TwinSettings:
    """The machine as described, in air that stays as it is."""
    given: dict[str, dict[str, Any]] = {
        "climate": {"swing": 0.0},
        "tolerances": EXACT,
        "body": DAMPED[name],
        "line": {"vibration": 0.0},
    }
    return changed(load_twin(name), **given, **tables)


def made(twin: TwinSettings, plant: str = "dynamic", seed: int = 1, **faults: Any) -> SimulatedMachine:
    name = str(twin.owner.robot)
    planned = twin.with_simulation(faults=(FaultPlan(**faults),)) if faults else twin
    return SimulatedMachine(load(name), planned, STARTS[name], seed=seed, plant=plant)


def run(
    machine: SimulatedMachine, duration: float, speeds: Any = 0.0, valve: float = 0.0, beam: float = 0.0
) -> list[SensorFrame]:
    outputs = {"retraction": beam} if beam else {}
    given = np.broadcast_to(np.array(speeds, dtype=np.float64), (machine.robot.m,))
    steps = range(round(duration / machine.period))
    return [machine.step(Command(machine.time, given, valve, outputs=outputs)) for _ in steps]


def last(kind: type[Any], frames: list[SensorFrame]) -> Any:
    return [reading for frame in frames for reading in frame.of(kind)][-1]


def told(frames: list[SensorFrame]) -> set[tuple[Condition, str]]:
    return {(notice.condition, notice.subject) for frame in frames for notice in frame.notices}


def pose_of(machine: SimulatedMachine) -> Array:
    return np.concatenate([machine.truth.position, machine.truth.rotation])


def without(robot: Robot, name: str) -> Robot:
    return robot.model_copy(update={"lines": tuple(line for line in robot.lines if line.name != name)})


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize("name", STARTS)
def test_it_hangs_still_until_it_is_commanded_to_move(name: str, plant: str) -> None:
    machine = made(still(name), plant)
    np.testing.assert_allclose(pose_of(machine), [*STARTS[name], 0.0, 0.0, 0.0], atol=1e-9)
    held = solve_inverse(Model(machine.robot), pose_of(machine)).checked()
    np.testing.assert_allclose(machine.truth.tensions, held.tensions, rtol=1e-6)
    assert not told(run(machine, 2.0))
    np.testing.assert_allclose(pose_of(machine), [*STARTS[name], 0.0, 0.0, 0.0], atol=2e-8)


@pytest.mark.parametrize("name", STARTS)
def test_both_plants_come_to_the_equilibrium_of_the_solver(name: str) -> None:
    ends = []
    for plant in PLANTS:
        machine = made(still(name), plant)
        way = solve_inverse(Model(machine.robot), np.add(STARTS[name], [0.05, -0.03, 0.04])).checked()
        speeds = (way.lengths - machine.truth.lengths) / machine.truth.radii / 2.0
        run(machine, 2.0, speeds)
        run(machine, 20.0)
        hung = solve_forward(Model(machine.robot), machine.truth.lengths, guess=pose_of(machine)).checked()
        np.testing.assert_allclose(pose_of(machine), hung.pose, atol=1e-7)
        np.testing.assert_allclose(machine.truth.tensions, hung.tensions, rtol=1e-4, atol=1e-3)
        assert machine.truth.position[0] - STARTS[name][0] > 0.02
        ends.append(pose_of(machine))
    np.testing.assert_allclose(*ends, atol=5e-4)


@pytest.mark.parametrize("plant", PLANTS)
def test_sensors_read_the_motion_of_the_body(plant: str) -> None:
    machine = made(
        still(
            "cogiro",
            wire={"latency": 0.0},
            load_cells={"deviation": 0.0, "bias": 0.0},
            swivels={"deviation": 0.0, "bias": 0.0},
            inertial={"acceleration_deviation": 0.0, "acceleration_bias": 0.0, "rate_deviation": 0.0, "rate_bias": 0.0},
        ).with_simulation(
            tolerances=load_twin("cogiro").simulation.tolerances.model_copy(update={"tension_gain": 0.0})
        ),
        plant,
    )
    frames = run(machine, 2.0, [0.01, -0.02, 0.02, -0.01, 0.01, -0.01, 0.0, 0.01])
    frames += run(machine, 1.0)
    truth = machine.truth
    np.testing.assert_allclose(last(Tensions, frames).tensions, truth.tensions, rtol=1e-9)
    R = matrices(truth.rotation)
    ends = truth.position + np.array([line.platform_point for line in machine.robot.lines]) @ R.T
    away = ends - [line.exit_point for line in machine.robot.lines]
    np.testing.assert_allclose(last(Swivels, frames).angles, np.arctan2(away[:, 1], away[:, 0]), atol=1e-5)
    imu = last(Inertial, frames)
    np.testing.assert_allclose(imu.acceleration, R.T @ [0.0, 0.0, machine.robot.scene.gravity], atol=2e-3)
    np.testing.assert_allclose(imu.rate, R.T @ truth.rate, atol=1e-9)
    assert np.abs(truth.rotation).max() > 1e-3


def test_a_lidar_on_a_turned_body_sees_the_walls_where_they_are() -> None:
    """The body stands turned about all axes: each ray ends on a wall, the floor or the ceiling."""
    lidar = load_twin("merlet2023").owner.lidars["north"]
    exact = {"masks": (), "deviation": 0.0, "bias": 0.0, "resolution": 1e-12, "most": 100.0}
    corners = [(-9.0, -7.0), (9.0, -7.0), (9.0, 7.0), (-9.0, 7.0), (-9.0, -7.0)]
    walls = [{"name": str(i), "from": a, "to": b} for i, (a, b) in enumerate(pairwise(corners))]
    empty = still("cogiro")
    room = RoomSettings.model_validate({"ceiling": 8.0, "walls": walls})
    twin = empty.with_owner(lidars={"north": lidar.model_copy(update=exact)}, room=room)
    pose = [0.5, -0.4, 1.5, 0.05, -0.04, 0.3]
    machine = SimulatedMachine(load("cogiro"), twin, pose, seed=1)
    scan = last(Scan, run(machine, 1.1))
    x, y = np.array(lidar.axes)
    points = np.array(lidar.place) + scan.points @ np.array([x, y])
    world = machine.truth.position + points @ matrices(machine.truth.rotation).T
    off = np.abs(
        np.column_stack([np.abs(world[:, 0]) - 9.0, np.abs(world[:, 1]) - 7.0, world[:, 2], world[:, 2] - 8.0])
    )
    assert off.min(axis=1).max() < 1e-6
    assert (off.argmin(axis=1) < 2).any()


def test_each_accelerometer_on_a_line_moves_with_its_own_platform_point() -> None:
    """A body that turns about its own origin: a point off it accelerates towards the origin."""
    motion, acceleration, ends = np.zeros(12), np.zeros(6), np.zeros((2, 3))
    motion[9:12], acceleration[:] = [0.0, 0.0, 2.0], [0.1, 0.0, 0.0, 0.0, 0.0, 0.5]
    arms = np.array([[0.5, 0.0, 0.0], [0.0, 0.0, 0.0]])
    carry_ends(motion, acceleration, arms, ends)
    np.testing.assert_allclose(ends, [[0.1 - 0.5 * 4.0, 0.25, 0.0], [0.1, 0.0, 0.0]])


def test_a_hopper_gets_lighter_as_it_lays() -> None:
    hopper = {"capacity": 30.0, "powder": 20.0, "powder_density": 1500.0, "radius": 0.15, "hopper": (0.3, 0.0, 0.4)}
    empty = still("cogiro")
    twin = empty.with_owner(body=empty.owner.body.model_copy(update={**hopper, "flow": 0.2}))
    machine = made(twin, "quasi-static")
    platform = load("cogiro").platform
    rig, g = machine.rig, machine.robot.scene.gravity
    for _ in range(3):
        run(machine, 10.0, valve=1.0)
        left = machine.truth.powder
        assert left == pytest.approx(20.0 - 0.2 * machine.time)
        assert rig.ground.mass + rig.falling_mass == pytest.approx(20.0 - left)
        assert rig.packed.platform[3] == pytest.approx((platform.mass + left) * g)
        fill = left / (1500.0 * math.pi * 0.15**2)
        moment = platform.mass * np.array(platform.centre_of_mass) + left * np.array([0.3, 0.0, 0.4 + fill / 2])
        np.testing.assert_allclose(rig.packed.platform[:3], moment / (platform.mass + left))
    hung = solve_forward(
        Model(
            machine.robot.model_copy(
                update={
                    "platform": platform.model_copy(
                        update={
                            "mass": platform.mass + left,
                            "centre_of_mass": tuple(moment / (platform.mass + left)),
                        }
                    )
                }
            )
        ),
        machine.truth.lengths,
        guess=pose_of(machine),
    ).checked()
    np.testing.assert_allclose(pose_of(machine), hung.pose, atol=1e-5)
    with pytest.raises(InputError, match="the hopper takes 0 to 30 kg"):
        machine.refill(31.0)


@pytest.mark.parametrize("plant", PLANTS)
def test_a_beam_retracts_with_its_speed_to_its_ends_and_rests_where_the_solver_says(plant: str) -> None:
    machine = made(still("jung2020"), plant)
    frames = run(machine, 3.0, beam=-0.01)
    assert machine.truth.retraction == pytest.approx(2.0 - 0.01 * (3.0 - 0.05), abs=1e-4)  # less the lag
    run(machine, 12.0)
    assert last(BeamLength, frames).length == pytest.approx(machine.truth.retraction, abs=2e-3)
    short = machine.robot.retracted(machine.truth.retraction)
    hung = solve_forward(Model(short), machine.truth.lengths, guess=pose_of(machine)).checked()
    np.testing.assert_allclose(pose_of(machine), hung.pose, atol=1e-6)
    assert not told(frames)
    assert (Condition.LIMITED, "retraction") in told(run(machine, 0.4, beam=0.5))
    assert (Condition.DRUM_END, "retraction") in told(run(machine, 3.0, beam=0.02))
    assert machine.truth.retraction == 2.0


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize(("length", "against"), [(1.4, -0.01), (1.9, 0.01)])
def test_a_retraction_stalls_on_more_than_its_force(plant: str, length: float, against: float) -> None:
    """A short beam's upper lines go up to the frame and hold its points there; those of a long one come from below."""
    for force, stalls in ((0.5, True), (200.0, False)):
        twin = still("jung2020", retraction={"max_force": force})
        machine = SimulatedMachine(load("jung2020").retracted(length), twin, STARTS["jung2020"], seed=1, plant=plant)
        frames = run(machine, 1.0, beam=against)
        assert ((Condition.STALLED, "retraction") in told(frames)) == stalls
        assert (machine.truth.retraction == length) == stalls
        assert not told(run(machine, 1.0, beam=-against))  # they help


def test_who_has_no_beam_takes_no_order_for_it() -> None:
    with pytest.raises(InputError, match="'retraction': the machine has no such output"):
        run(made(still("ipanema")), 0.01, beam=0.01)
    assert made(still("jung2020")).abilities.outputs == {"retraction"}


@pytest.mark.parametrize("plant", PLANTS)
def test_a_line_breaks_and_the_body_hangs_on_the_others(plant: str) -> None:
    machine = made(still("cogiro"), plant, source="line", line="3", kind="broken", begin=1.0)
    begin = pose_of(machine)
    run(machine, 1.0)
    np.testing.assert_allclose(pose_of(machine), begin, atol=1e-8)
    frames = run(machine, 40.0)
    left = without(machine.robot, "3")
    kept = np.delete(machine.truth.lengths, 2)
    hung = solve_forward(Model(left), kept, guess=pose_of(machine)).checked()
    np.testing.assert_allclose(pose_of(machine), hung.pose, atol=1e-6)
    assert np.linalg.norm(pose_of(machine)[:3] - begin[:3]) > 1e-3
    assert machine.truth.tensions[2] < 1e-3
    assert last(Tensions, frames).tensions[2] < 30.0
    assert len(last(Encoders, frames).counts) == 8


@pytest.mark.parametrize("name", STARTS)
def test_both_plants_come_to_rest_at_one_place_when_a_line_breaks(name: str) -> None:
    """The quasi-static plant says so, unless the step is a small one."""
    ends = []
    for plant in PLANTS:
        machine = made(still(name), plant, source="line", line="1", kind="broken", begin=0.2)
        frames = run(machine, 40.0)
        assert told(frames) <= ({(Condition.BRANCH_END, "")} if plant == "quasi-static" else set())
        ends.append(pose_of(machine))
    assert np.linalg.norm(ends[0][:3] - STARTS[name]) > 1e-3
    np.testing.assert_allclose(*ends, atol=1e-5)


def test_the_quasi_static_plant_goes_on_where_lines_fall_slack() -> None:
    """All lines of ipanema get longer: those from below hang slack then, and the body comes down all the same."""
    machine = made(still("ipanema"), "quasi-static")
    frames = run(machine, 2.0, 0.2 / 0.05) + run(machine, 1.0)
    assert told(frames) <= {(Condition.BRANCH_END, "")}
    assert machine.truth.position[2] < 0.3
    assert (machine.truth.excess[4:] > 0.1).all()
    hung = solve_forward(Model(machine.robot), machine.truth.lengths, guess=pose_of(machine)).checked()
    np.testing.assert_allclose(pose_of(machine), hung.pose, atol=1e-6)


@pytest.mark.parametrize(("name", "size"), [("cogiro", 0.03), ("ipanema", 0.01)])
def test_a_cable_falls_off_its_sheave_or_eyelet(name: str, size: float) -> None:
    """Less cable is needed then: both plants find where the longer line lets the body go."""
    ends = []
    for plant in PLANTS:
        fault = {"source": "line", "line": "2", "kind": "off_sheave", "begin": 0.5, "size": size}
        machine, usual = made(still(name), plant, **fault), made(still(name), plant)
        run(machine, 20.0)
        run(usual, 1.0)
        assert abs(machine.truth.excess[1] - usual.truth.excess[1]) > 1e-5
        assert np.abs(machine.truth.tensions - usual.truth.tensions).max() > 5.0
        np.testing.assert_array_equal(machine.rig.winches.counts, usual.rig.winches.counts)
        ends.append(pose_of(machine))
    np.testing.assert_allclose(*ends, atol=1e-6)


def test_planned_faults_of_an_encoder_and_a_load_cell() -> None:
    plans = (
        FaultPlan(source="encoders", line="2", kind="slip", size=0.02, begin=0.5),
        FaultPlan(source="load_cells", line="7", kind="offset", size=150.0, begin=0.5),
    )
    machine, usual = made(still("cogiro").with_simulation(faults=plans)), made(still("cogiro"))
    for one, duration, off in ((machine, 0.4, 0.0), (machine, 0.4, 1.0)):
        ours, theirs = run(one, duration), run(usual, duration)
        counts = last(Encoders, ours).counts - last(Encoders, theirs).counts
        winch = one.settings.winch
        turns = 0.02 / (2 * math.pi * 0.06) * winch.ratio * winch.counts
        np.testing.assert_allclose(counts, off * turns * np.eye(8)[1], atol=1.0)
        shown = last(Tensions, ours).tensions - last(Tensions, theirs).tensions
        np.testing.assert_allclose(shown, off * 150.0 * np.eye(8)[6], atol=1e-9)
    np.testing.assert_array_equal(machine.truth.position, usual.truth.position)


@pytest.mark.parametrize(
    ("plan", "says"),
    [
        ({"source": "encoders", "kind": "slip", "size": 0.02}, "must be given"),
        ({"source": "encoders", "kind": "slip", "line": "1"}, "size"),
        ({"source": "inertial", "kind": "slip", "size": 0.02}, "'slip' is for encoders"),
        ({"source": "line", "line": "1"}, "'broken' or 'off_sheave'"),
        ({"source": "line", "kind": "broken"}, "the name of the line"),
        ({"source": "line", "line": "1", "kind": "off_sheave", "size": -0.1}, "above 0 m"),
        ({"source": "load_cells", "kind": "stuck", "size": 1.0}, "size"),
    ],
)
def test_faults_that_make_no_sense_are_rejected(plan: dict[str, Any], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        FaultPlan(**plan)


def test_as_built_lengths_and_drums_have_errors_within_their_tolerances() -> None:
    bounds = {"home_length": 3e-3, "drum_radius": 5e-3}
    lengths, radii = [], []
    for seed in range(30):
        exact = made(still("cogiro"), "quasi-static", seed)
        one = made(still("cogiro").with_simulation(tolerances=_only(home_length=3e-3)), "quasi-static", seed)
        other = made(still("cogiro").with_simulation(tolerances=_only(drum_radius=5e-3)), "quasi-static", seed)
        lengths.append(one.truth.lengths - exact.truth.lengths)
        radii.append([line.winch.drum_radius / 0.06 - 1.0 for line in other.robot.lines])
        np.testing.assert_allclose(other.truth.lengths, exact.truth.lengths, atol=1e-9)
        assert np.abs(one.truth.position - exact.truth.position).max() > 1e-5
    for found, bound in ((np.array(lengths), bounds["home_length"]), (np.array(radii), bounds["drum_radius"])):
        assert 0.95 * bound < np.abs(found).max() <= bound * (1 + 1e-9)
        assert found.std() == pytest.approx(bound / math.sqrt(3.0), rel=0.15)


def _only(**sizes: float) -> Any:
    return load_twin("cogiro").simulation.tolerances.model_copy(update={**EXACT, **sizes})


@pytest.mark.parametrize("plant", PLANTS)
def test_a_resumed_machine_goes_on_to_the_bit(plant: str) -> None:
    twin = load_twin("jung2020").with_simulation(
        faults=(FaultPlan(source="line", line="6", kind="broken", begin=1.0), FaultPlan(source="retraction", begin=2.0))
    )
    robot, random = load("jung2020"), np.random.default_rng(5)
    machine = SimulatedMachine(robot, twin, STARTS["jung2020"], seed=4, plant=plant)
    orders = 0.02 * random.standard_normal((300, 8))

    def steps(one: SimulatedMachine, first: int, end: int) -> list[Reading]:
        found: list[Reading] = []
        for k in range(first, end):
            frame = one.step(Command(one.time, orders[k], 0.3, outputs={"retraction": -0.01}))
            found += frame.readings
        return found

    steps(machine, 0, 150)
    twinned = SimulatedMachine.resumed(robot, twin, machine.snapshot(), seed=4, plant=plant)
    for name in ("position", "rotation", "tensions", "excess", "retraction"):
        np.testing.assert_array_equal(getattr(twinned.truth, name), getattr(machine.truth, name))
    assert repr(steps(machine, 150, 300)) == repr(steps(twinned, 150, 300))
    np.testing.assert_array_equal(pose_of(machine), pose_of(twinned))
    np.testing.assert_array_equal(machine.truth.tensions, twinned.truth.tensions)


def test_robots_and_machines_that_do_not_fit_are_rejected() -> None:
    body, drum = load_twin("cogiro"), load_twin("merlet2023")
    for robot, twin, says in (
        (load("merlet2023"), body, r"needs \[drum\]"),
        (load("cogiro"), drum, r"needs \[body\]"),
        (load("ipanema"), load_twin("jung2020"), "no retraction that"),
    ):
        with pytest.raises(InputError, match=says):
            SimulatedMachine(robot, twin, [0.0, 0.0, 1.0], seed=1)
    with pytest.raises(InputError, match="3 or 6 numbers"):
        SimulatedMachine(load("cogiro"), body, [0.0, 0.0], seed=1)
    bare = load("cogiro").platform.model_copy(update={"inertia": None, "inertia_products": (0.0, 0.0, 0.0)})
    unknown = load("cogiro").model_copy(update={"platform": bare})
    with pytest.raises(InputError, match=r"give body\.gyration"):
        SimulatedMachine(unknown, body, [0.0, 0.0, 1.0], seed=1)
    given = body.with_owner(body=body.owner.body.model_copy(update={"gyration": (0.5, 0.5, 0.4)}))
    assert SimulatedMachine(unknown, given, [0.0, 0.0, 1.0], seed=1).truth.time == 0.0


def grab() -> Robot:
    robot = load("grab-four-lines")
    winch = Winch(drum_radius=0.03)
    return robot.model_copy(update={"lines": tuple(line.model_copy(update={"winch": winch}) for line in robot.lines)})


@pytest.mark.parametrize("plant", PLANTS)
def test_a_body_on_fewer_lines_than_degrees_of_freedom_hangs_and_swings(plant: str, tmp_path: Path) -> None:
    robot, place = grab(), [1.2, 0.1, 0.0]
    (tmp_path / "grab.toml").write_text(machine_file(robot))
    given = load_twin(tmp_path / "grab.toml")
    bare = given.simulation.tolerances.model_copy(update={"anchor": 0.0, "sheave_radius": 0.0, "modulus": 0.0})
    twin = changed(given.with_simulation(tolerances=bare), climate={"swing": 0.0}, line={"vibration": 0.0})
    machine = SimulatedMachine(robot, twin, place, seed=2, plant=plant)
    begin = pose_of(machine)
    np.testing.assert_allclose(begin[:3], place, atol=1e-9)
    assert not told(run(machine, 1.0))
    np.testing.assert_allclose(pose_of(machine), begin, atol=1e-7)
    run(machine, 0.5, [-1.0, 1.0, 1.0, -1.0])
    tilts = [np.abs(pose_of(machine)[3:5] - begin[3:5]).max() for _ in range(40) if run(machine, machine.period)]
    assert (np.ptp(tilts) > 1e-3) == (plant == "dynamic")
    twinned = SimulatedMachine.resumed(robot, twin, machine.snapshot(), seed=2, plant=plant)
    np.testing.assert_array_equal(pose_of(twinned), pose_of(machine))
    run(machine, 30.0)
    hung = solve_forward(Model(machine.robot), machine.truth.lengths, guess=pose_of(machine)).checked()
    np.testing.assert_allclose(pose_of(machine), hung.pose, atol=1e-6 if plant == "quasi-static" else 2e-3)
