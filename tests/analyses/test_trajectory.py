"""Trajectories by differences in time, and inverse dynamics by energy and by Euler."""

import numpy as np
import pytest

import cablewright as cw
from cablewright.models.inertia import mass_matrix
from cablewright.models.rotation import matrices, turn_between

RNG = np.random.default_rng(1)
POINTS = np.column_stack([RNG.uniform(-1.0, 1.0, (5, 3)) + np.array([0, 0, 2]), RNG.uniform(-0.15, 0.15, (5, 3))])
MADE = {
    "waypoints of a body": lambda: cw.Trajectory.through(POINTS, speed=0.5, acceleration=1.0, period=1e-3),
    "waypoints of a point": lambda: cw.Trajectory.through(POINTS[:, :3], speed=0.5, acceleration=1.0, period=1e-3),
    "spline of a body": lambda: cw.Trajectory.spline(POINTS, 8.0, period=1e-3),
    "spline of a point": lambda: cw.Trajectory.spline(POINTS[:, :3], 8.0, period=1e-3),
}


@pytest.mark.parametrize("name", MADE)
def test_velocities_and_accelerations_are_derivatives(name: str) -> None:
    way = MADE[name]()
    twice = 2.0 * (way.times[1] - way.times[0])
    moved = (way.poses[2:, :3] - way.poses[:-2, :3]) / twice
    if way.poses.shape[1] == 6:
        moved = np.column_stack([moved, turn_between(way.poses[:-2, 3:], way.poses[2:, 3:]) / twice])
    assert moved == pytest.approx(way.velocities[1:-1], abs=1e-5)
    changed = (way.velocities[2:] - way.velocities[:-2]) / twice
    assert changed == pytest.approx(way.accelerations[1:-1], abs=5e-3)
    assert way.velocities[[0, -1]] == pytest.approx(0.0, abs=1e-12)


def test_limits_hold_and_one_of_them_is_reached() -> None:
    way = MADE["waypoints of a point"]()
    assert way.max_speed <= 0.5 * (1.0 + 1e-9)
    assert way.max_acceleration <= 1.0 + 1e-9
    assert way.max_speed == pytest.approx(0.5, rel=1e-4) or way.max_acceleration == pytest.approx(1.0, rel=1e-4)
    ends = np.abs(way.poses[:, None] - POINTS[:, :3]).max(axis=2).min(axis=0)
    assert ends.max() < 1e-3  # it comes to each waypoint


def test_a_trajectory_of_a_job_follows_its_time_law() -> None:
    robot, job = cw.load("house-printer"), cw.load_job("examples/house.toml")
    samples = job.samples(job.toolpath())
    law = job.time_law(samples)
    way = cw.Trajectory.of_job(robot, job, duration=30.0, period=5e-3)
    known = law.time < 30.0
    places = np.stack([np.interp(law.time[known], way.times, column) for column in way.poses.T], axis=1)
    assert places == pytest.approx(samples.positions[known], abs=2e-3)
    assert np.linalg.norm(way.velocities, axis=1).max() <= samples.speed_limit.max() * (1.0 + 1e-9)
    with pytest.raises(cw.InputError, match="jerk"):
        cw.Trajectory.of_job(robot, job.model_copy(update={"motion": job.motion.model_copy(update={"jerk": 1.0})}))


def test_the_power_of_the_lines_is_the_change_of_energy() -> None:
    robot = cw.load("cogiro").with_(centre_of_mass=(0.1, -0.05, 0.2))
    way = cw.Trajectory.spline(POINTS, 12.0, period=1e-2)
    found = cw.inverse_dynamics(robot, way, cable="rigid")
    assert found.feasible
    v, centre = way.velocities, matrices(way.poses[:, 3:]) @ np.array(robot.platform.centre_of_mass)
    height = way.poses[:, 2] + centre[:, 2]
    energy = 0.5 * np.einsum("ki,kij,kj->k", v, mass_matrix(robot, way.poses), v)
    energy += robot.platform.mass * robot.scene.gravity * height
    expected = np.gradient(energy, way.times, edge_order=2)
    assert found.power.sum(axis=1)[2:-2] == pytest.approx(expected[2:-2], abs=2e-4 * np.abs(expected).max())
    rates = np.gradient(found.lengths, way.times, axis=0)
    assert found.length_rates[2:-2] == pytest.approx(rates[2:-2], abs=1e-4)


def test_a_body_about_its_fixed_centre_needs_the_torque_of_euler() -> None:
    """Rotation at a constant rate about an axis that is not principal: no force but weight, torque w x (I w)."""
    robot = cw.load("cogiro").with_(inertia_products=(0.0, 0.0, 0.0))
    turn = np.array([0.1, 0.05, 0.02])
    times = np.linspace(0.0, 1.0, 5)
    rate = np.tile(turn, (5, 1))
    poses = np.column_stack([np.tile([0.0, 0.0, 2.0], (5, 1)), times[:, None] * turn])
    still = np.zeros((5, 3))
    way = cw.Trajectory("turn", times, poses, np.column_stack([still, rate]), np.zeros((5, 6)))
    found = cw.inverse_dynamics(robot, way, cable="rigid")
    wrench = np.einsum("kij,kj->ki", cw.structure_matrix(robot, poses), found.tensions)
    R = matrices(poses[:, 3:])
    centre = R @ np.array(robot.platform.centre_of_mass)
    inertia = R @ np.diag(robot.platform.inertia) @ R.transpose(0, 2, 1)
    force = robot.platform.mass * (np.cross(rate, np.cross(rate, centre)) + np.array([0.0, 0.0, robot.scene.gravity]))
    torque = np.cross(rate, np.einsum("kij,kj->ki", inertia, rate)) + np.cross(centre, force)
    assert wrench == pytest.approx(np.column_stack([force, torque]), abs=1e-6)


def test_too_fast_a_trajectory_is_an_answer_of_no() -> None:
    way = cw.Trajectory.through([[0, 0, 3], [6, 6, 12]], speed=50.0, acceleration=300.0, period=0.01)
    found = cw.inverse_dynamics(cw.load("house-printer"), way)
    assert not found.feasible
    assert found.first_failure is not None
    assert "limits" in found.refusal
    assert found.plot().axes


def test_a_simulated_machine_follows_a_trajectory() -> None:
    robot = cw.load("merlet2023")
    way = cw.Trajectory.through([[0, 0, 1.2], [0.3, 0.2, 1.3]], speed=0.1, acceleration=0.1, period=0.1)
    calm = cw.DriveSettings(error=0.0)
    found = cw.simulate(robot, trajectory=way, severity="ideal", plant="quasi-static", driving=calm)
    poses = np.array(found.drive.poses)
    assert len(poses) == found.drive.steps
    assert poses[-1, :3] == pytest.approx(way.poses[-1], abs=2e-3)
    with pytest.raises(cw.InputError, match="give one of loop"):
        cw.simulate(robot, trajectory=way, hold=[0, 0, 1])


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: cw.Trajectory.through([[0, 0, 1]], speed=1, acceleration=1), "two rows"),
        (lambda: cw.Trajectory.through("path", speed=1, acceleration=1), "numbers in m"),
        (lambda: cw.Trajectory.through([[0, 0, 1], [0, 0, 1]], speed=1, acceleration=1), "number 2 is the same"),
        (lambda: cw.Trajectory.through([[0, 0, 1], [0, 0, 2]], speed=0, acceleration=1), "speed = 0: must be"),
        (lambda: cw.Trajectory.spline([[0, 0, 1], [0, np.nan, 2]], 1.0), "finite"),
        (lambda: cw.Trajectory.spline([[0, 0, 1], [0, 0, 2]], 1e9), "take a longer period"),
        (lambda: cw.Trajectory.spline([[0, 0, 1], [0, 0, 2]], 1.0, period=1e-320), "take a longer period"),
        (lambda: cw.Trajectory.through([[0, 0, 1], [0, 1]], speed=1, acceleration=1), "rows of 3 or of 6 numbers"),
        (lambda: cw.Trajectory.through([[0, 0, 0], [0, 0, 1e-320]], speed=1, acceleration=1), "too close"),
        (lambda: cw.inverse_dynamics(cw.load("cogiro"), MADE["spline of a point"]()), "3 coordinates"),
        (lambda: cw.inverse_dynamics(cw.load("grab-four-lines"), MADE["spline of a body"]()), "fewer winches"),
        (lambda: cw.inverse_dynamics(cw.load("cogiro"), [[0, 0, 1]]), "a Trajectory is expected"),
    ],
)
def test_wrong_input_is_named_in_one_line(make: object, text: str) -> None:
    with pytest.raises(cw.InputError, match=text):
        make()
