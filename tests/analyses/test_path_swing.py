"""Swing along a path: an own integration of a mass on elastic lines that may go slack is the oracle."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.optimize import fsolve

from cablewright.analyses.motion.sag_correction import with_sag
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.robot import Robot, loads
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import tension_changes
from cablewright.studies.checks.check import check
from cablewright.studies.checks.result import Check

MASS, GRAVITY, STIFFNESS = 200.0, 9.81, 102.2e9 * 4e-6 * np.pi  # kg, m/s^2, N
CORNERS = np.array([[-7.5, -7.5, 15.0], [7.5, -7.5, 15.0], [7.5, 7.5, 15.0], [-7.5, 7.5, 15.0]])
WEIGHT = 0.03 * GRAVITY  # N/m, where cables have any
DEAD = 15.0  # m of each cable from its winch up to its exit
STEP = 1e-3  # s

HOUSE = """
schema = 1
name = "four"
[scene]
gravity = "9.81 m/s^2"
frame_min = [-7.5, -7.5, 0.0]
frame_max = [7.5, 7.5, 15.0]
[platform]
kind = "point"
mass = "200 kg"
[cable]
young_modulus = "102.2 GPa"
section = "12.566370614359172 mm^2"
linear_density = 0.0
breaking_load = "10 kN"
[sheave]
kind = "eyelet"
[line]
dead_elastic = true
tension_limits = ["20 N", "5.15 kN"]
[dynamics]
damping_ratio = {ratio}
"""
LINES = "".join(
    f'[[lines]]\nname = "{name}"\nexit_point = [{x}, {y}, {z}]\nwinch_exit = [{x}, {y}, 0.0]\n'
    for name, (x, y, z) in zip(("south-west", "south-east", "north-east", "north-west"), CORNERS, strict=True)
)
WALL = ((0.0, 0.0), (4000.0, 0.0), (4000.0, 3000.0))
ANGLE = ((0.0, 0.0), (800.0, 0.0), (800.0, 600.0))


def house(ratio: float) -> Robot:
    """A point of 200 kg on four elastic lines without weight."""
    return loads(HOUSE.format(ratio=ratio) + LINES)


def meander(width: float) -> tuple[tuple[float, float], ...]:
    """Eight times to and fro over *width* (mm), 60 mm farther each time, mm."""
    sides = [(2000.0 + width * ((k // 2 + k % 2) % 2), 60.0 * (k // 2)) for k in range(33)]
    return tuple(sides)


@pytest.fixture
def printed(tmp_path: Path):
    """A check of a path (mm), with the lengths that it pays out."""

    def found(
        points: tuple[tuple[float, float], ...], ratio: float, feed: int, max_error: float = 0.03, **motion: float
    ) -> Check:
        (x, y), *rest = points
        lines = ["G21 G90 M83", ";LAYER:0", f"G0 X{x} Y{y} Z20 F{feed}", *(f"G1 X{x} Y{y} E9" for x, y in rest)]
        file = tmp_path / "path.gcode"
        file.write_text("\n".join(lines) + "\n")
        job = Job.model_validate(
            {
                "name": "path",
                "gcode": str(file),
                "motion": {"acceleration": 0.5, "shaping": "none", **motion},
                "max_error": max_error,
            }
        )
        return check(house(ratio), job, skip=("interference", "expected-error"))

    return found


def pulls(places: np.ndarray, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Forces (c, 3), N, on a mass at *places* (c, 3), with tensions (c, 4), by *lengths* (c, 4) that were paid out."""
    chords = CORNERS - places[:, None]
    spans = np.linalg.norm(chords, axis=2)
    tensions = STIFFNESS * np.maximum((DEAD + spans) / lengths - 1.0, 0.0)
    force = (tensions / spans)[:, :, None] * chords
    return force.sum(axis=1) - [0.0, 0.0, MASS * GRAVITY], tensions


def damper(place: np.ndarray, lengths: np.ndarray, ratio: float) -> np.ndarray:
    """The matrix (3, 3), N s/m, that damps every mode about *place* (3,) by *ratio*."""
    moved = place + 1e-5 * np.vstack([np.eye(3), -np.eye(3)])
    forces = pulls(moved, np.tile(lengths, (6, 1)))[0]
    values, shapes = np.linalg.eigh(-0.5e5 * 0.5 * ((forces[:3] - forces[3:]) + (forces[:3] - forces[3:]).T))
    return 2.0 * ratio * (shapes * np.sqrt(MASS * values)) @ shapes.T


def integrated(checks: list[Check]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Largest error (c,), m, and the extremes of tensions (c, 4), N, while the lengths of some checks are paid out."""
    times = np.arange(0.0, max(each.law.duration for each in checks), STEP)
    arrays = [np.column_stack([each.samples.positions, each.lengths]) for each in checks]
    course = np.stack(
        [
            np.column_stack([np.interp(times, each.law.time, column) for column in values.T])
            for each, values in zip(checks, arrays, strict=True)
        ]
    )  # (c, steps, 7)
    wanted, lengths = course[..., :3].swapaxes(0, 1), course[..., 3:].swapaxes(0, 1)
    speeds = np.gradient(wanted, STEP, axis=0)
    damping = np.stack(
        [damper(each.samples.positions[0], each.lengths[0], each.robot.damping.ratio) for each in checks]
    )
    place, speed = wanted[0].copy(), np.zeros_like(wanted[0])
    error, (low, high) = np.zeros(len(checks)), (np.full((len(checks), 4), each) for each in (np.inf, -np.inf))
    for now in range(1, len(times)):
        force, tensions = pulls(place, lengths[now - 1])
        force -= np.einsum("cij,cj->ci", damping, speed - speeds[now - 1])
        speed += STEP / MASS * force
        place += STEP * speed
        error = np.maximum(error, np.linalg.norm(place - wanted[now], axis=1))
        low, high = np.minimum(low, tensions), np.maximum(high, tensions)
    return error, low, high


def test_errors_and_tensions_are_those_of_the_integration(printed) -> None:
    """A wall, with its acceleration and ten times that, and meanders, at several shares of damping."""
    cases = [(WALL, ratio, 6000, {}) for ratio in (0.01, 0.03, 0.05, 0.1)]
    cases += [(WALL, 0.01, 6000, {"acceleration": 5.0})]
    cases += [(meander(width), ratio, 18000, {}) for width in (60.0, 100.0, 150.0, 200.0) for ratio in (0.01, 0.03)]
    cases += [(meander(100.0), ratio, 18000, {}) for ratio in (0.05, 0.1)]
    checks = [printed(points, ratio, feed, **motion) for points, ratio, feed, motion in cases]
    errors, low, high = integrated(checks)
    found = np.array([np.nanmax(each.statics.displacement) for each in checks])
    least = np.array([each.statics.lines.lowest_tension.min(axis=0) for each in checks])
    most = np.array([each.statics.lines.highest_tension.max(axis=0) for each in checks])
    taut = (low > 0.0).all(axis=1)
    assert taut.sum() >= 9
    assert found[taut] == pytest.approx(errors[taut], rel=0.03)
    assert least[taut] == pytest.approx(low[taut], abs=6.0)
    assert most[taut] == pytest.approx(high[taut], abs=6.0)
    assert (least[~taut].min(axis=1) < 5.0).all()
    refused = [each for each in checks if each.statics.lines.lowest_tension.min() < 0.0]
    assert len(refused) >= 4
    for each in refused:
        assert not each.feasible
        assert "becomes slack" in each.verdict
        assert "--plant dynamic." in each.verdict


def test_meander_beyond_the_allowed_error_is_rejected_with_its_place_and_frequency(printed) -> None:
    found = printed(meander(100.0), 0.03, max_error=0.02, feed=9000)
    assert found.motion is not None
    assert "largest in layer 1, G-code line 7 at 1.81 Hz (allowed: at most 20 mm)" in found.verdict
    assert f"G-code line {found.place(found.motion.sample).gcode_line} at 1.8" in found.verdict
    told = found.to_dict()
    assert told["motion_error"] == told["acceleration_displacement"] == found.motion.largest
    assert told["motion_error"] > told["motion_error_95"] > 0.0
    assert told["motion_error_frequency"] == pytest.approx(1.8, abs=0.05)


def catenary(away: np.ndarray, length: float) -> float:
    """Tension, N, at the exit of a cable of that unstrained *length*, m, with its dead span, to a point *away*, m."""
    across, down = float(np.hypot(away[0], away[1])), -float(away[2])

    def off(force: np.ndarray) -> list[float]:
        h, v = force  # N, at the exit: level, and up on the cable
        free = length - DEAD / (1.0 + (np.hypot(h, v) - 0.5 * WEIGHT * DEAD) / STIFFNESS)
        end = v - WEIGHT * free
        level = h * free / STIFFNESS + h / WEIGHT * (np.arcsinh(v / h) - np.arcsinh(end / h))
        fall = (v - 0.5 * WEIGHT * free) * free / STIFFNESS + (np.hypot(h, v) - np.hypot(h, end)) / WEIGHT
        return [level - across, fall - down]

    start = 100.0 * np.array([across, down]) / np.hypot(across, down)
    return float(np.hypot(*fsolve(off, start, xtol=1e-12)))


@pytest.mark.parametrize("tension", [60.0, 150.0, 250.0])
def test_falls_of_sagging_cables_are_those_of_the_catenary(tension: float) -> None:
    """The platform moves 1 cm towards the exit of its least tense line, whose length stays."""
    text = HOUSE.format(ratio=0.0).replace("linear_density = 0.0", f"linear_density = {WEIGHT / GRAVITY}")
    model = Model.full(loads(text.replace("20 N", f"{tension} N") + LINES))
    held = solve_inverse(model, np.array([[4.0, 3.0, 1.5]]))
    line = int(np.argmin(held.tensions[0]))
    away = held.pose[0] - CORNERS[line]
    assert catenary(away, held.lengths[0, line]) == pytest.approx(held.tensions[0, line], rel=1e-6)
    nearer = away * (1.0 - 0.01 / np.linalg.norm(away))
    by_pose = tension_changes(held).by_pose
    falls = np.minimum(by_pose @ (nearer - away), 0.0)
    found = held.tensions + with_sag(held, by_pose, falls)
    assert found[0, line] == pytest.approx(catenary(nearer, held.lengths[0, line]), rel=0.05)


def in_mujoco(found: Check) -> float:
    """Largest error, m, of the mass on springs of MuJoCo whose lengths and stiffness follow those that are paid out."""
    ends = "".join(f'<site name="e{i}" pos="{x} {y} {z}"/>' for i, (x, y, z) in enumerate(CORNERS))
    slides = "".join(f'<joint type="slide" axis="{axis}"/>' for axis in ("1 0 0", "0 1 0", "0 0 1"))
    tendons = "".join(
        f'<spatial stiffness="1" springlength="0 1"><site site="e{i}"/><site site="p"/></spatial>' for i in range(4)
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{STEP}" gravity="0 0 -{GRAVITY}" integrator="implicit"/><worldbody>{ends}<body>'
        f'{slides}<inertial mass="{MASS}" pos="0 0 0" diaginertia="1 1 1"/><site name="p"/></body></worldbody>'
        f"<tendon>{tendons}</tendon></mujoco>"
    )
    data = mujoco.MjData(model)
    times = np.arange(0.0, found.law.duration, STEP)
    columns = np.column_stack([found.samples.positions, found.lengths]).T
    course = np.column_stack([np.interp(times, found.law.time, column) for column in columns])
    data.qpos[:] = course[0, :3]
    error = 0.0
    for row in course:
        error = max(error, float(np.linalg.norm(data.qpos - row[:3])))
        model.tendon_stiffness[:] = STIFFNESS / row[3:]
        model.tendon_lengthspring[:, 1] = row[3:] - DEAD
        mujoco.mj_step(model, data)
    return error


@pytest.mark.parametrize(("points", "feed"), [(ANGLE, 6000), (meander(200.0), 18000)])
def test_errors_are_those_of_mujoco(points: tuple[tuple[float, float], ...], feed: int, printed) -> None:
    found = printed(points, 0.0, feed)
    assert np.nanmax(found.statics.displacement) == pytest.approx(in_mujoco(found), rel=0.05)
