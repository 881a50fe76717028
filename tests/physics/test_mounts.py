"""Laws of exit points whose mounts give: energy, the stiff robot with its exit points where they are, the plant's own
mounts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.optimize import minimize

import cablewright as cw
import out_of_plane
from cablewright.control.length_check import check_lengths, lengths_at
from cablewright.foundation.errors import InputError, Status
from cablewright.kernels import layout
from cablewright.kernels.statics.equilibrium import evaluate, workspace
from cablewright.machine.simulated.unmodelled.exit_mounts import ExitMountState
from cablewright.models.statics import Model
from cablewright.models.stiffness import stiffness
from cablewright.robot import Eyelet, Robot, load
from cablewright.robot.parameter_values import with_exit_point
from cablewright.robot.parameters import Parameter
from cablewright.solvers.linearise import tension_changes
from cablewright.solvers.parameter_effects import response, tension_response
from cablewright.solvers.uniqueness import unique_among
from cablewright.studies.checks.path_statics import PathStatics
from physics.test_lines_out_of_plane import differences

POSE = [0.4, -0.3, 1.2]


def on_mounts(robot: Robot, compliance: Any, **own: Any) -> Robot:
    """The robot with the compliance, or one for each line, and other keys of its lines."""
    each = compliance if isinstance(compliance, list) else [compliance] * robot.m
    return out_of_plane.checked(
        robot.model_copy(
            update={
                "lines": tuple(
                    line.model_copy(update={"exit_compliance": soft} | own)
                    for line, soft in zip(robot.lines, each, strict=True)
                )
            }
        )
    )


def random_matrices(count: int, size: float = 5e-6) -> list[Any]:
    rng, out = np.random.default_rng(3), []
    for _ in range(count):
        half = rng.normal(size=(3, 3))
        out.append(tuple(map(tuple, (size / 3.0 * half @ half.T).tolist())))
    return out


@pytest.mark.parametrize("dead", [False, True])
def test_the_platform_rests_where_the_energy_is_least(dead: bool) -> None:
    """Straight lines through eyelets: over the platform's place and where each exit goes, with dead spans or not."""
    own: dict[str, Any] = {"sheave": Eyelet(), "dead_length": 0.0, "winch_exit": None}
    robot = on_mounts(load("merlet2023"), random_matrices(4, 2e-5), **own)
    if dead:
        lines = tuple(
            line.model_copy(update={"winch_exit": tuple(np.array(line.exit_point) - [0.3 * i, 0.2, 2.5])})
            for i, line in enumerate(robot.lines)
        )
        robot = out_of_plane.checked(robot.model_copy(update={"lines": lines}))
    lengths = cw.inverse(robot, POSE, cable="elastic").checked().lengths - [0.004, 0.0, 0.002, 0.001]
    found = cw.forward(robot, lengths, cable="elastic")
    exits = np.array([line.exit_point for line in robot.lines])
    soft = np.array([line.exit_compliance for line in robot.lines])
    stiff, hard = np.linalg.inv(soft), np.array([line.cable.stiffness for line in robot.lines])
    weight = robot.platform.mass * robot.scene.gravity
    back = np.array([line.winch_exit or line.exit_point for line in robot.lines]) - exits
    span = np.linalg.norm(back, axis=1)
    toward_winch = back / np.maximum(span, 1e-300)[:, None]

    def energy_and_slope(q: np.ndarray) -> tuple[float, np.ndarray]:
        place, gone = q[:3], 1e-3 * q[3:].reshape(4, 3)
        free = place - exits - gone
        chord = np.linalg.norm(free, axis=1)
        covered = span - (toward_winch * gone).sum(axis=1)
        drawn = chord + covered - lengths  # the same strain in both spans, since the tension is the same
        tension = hard * drawn / lengths
        slope, pull = np.zeros(15), tension[:, None] * free / chord[:, None]
        slope[:3] = pull.sum(axis=0) + np.array([0, 0, weight])
        load = -pull - tension[:, None] * toward_winch
        slope[3:] = 1e-3 * (load + np.einsum("iab,ib->ia", stiff, gone)).ravel()
        whole = 0.5 * hard * drawn**2 / lengths
        return float(whole.sum() + weight * place[2] + 0.5 * np.einsum("ia,iab,ib", gone, stiff, gone)), slope

    start = np.concatenate([found.pose + np.array([1e-3, -1e-3, 2e-3]), np.zeros(12)])
    least = minimize(energy_and_slope, start, jac=True, method="BFGS", options={"gtol": 1e-9, "maxiter": 5000})
    np.testing.assert_allclose(least.x[:3], found.pose, atol=1e-8)


@pytest.mark.parametrize("kind", ["mounts", "pulleys on mounts"])
@pytest.mark.parametrize("cable", ["elastic", "catenary"])
def test_it_is_the_stiff_robot_with_its_exit_points_where_they_are(kind: str, cable: str) -> None:
    """With dead spans that do not stretch: an exit that goes by d takes d, along the dead span, off its length."""
    robot = out_of_plane.body(kind)
    lines = tuple(line.model_copy(update={"dead_elastic": False}) for line in robot.lines)
    robot = robot.model_copy(update={"lines": lines})
    found = cw.inverse(robot, [0.5, 0.2, 1.6, 0.02, -0.03, 0.05], cable=cable).checked()
    gone, longer = [], []
    for line, state in zip(robot.lines, found.states, strict=True):
        phi, tau, _, _, azimuth, _ = state
        force = np.exp(tau) * np.array([np.cos(phi) * np.cos(azimuth), np.cos(phi) * np.sin(azimuth), np.sin(phi)])
        gone.append(out_of_plane.given_way(line, force))
        longer.append(gone[-1] @ out_of_plane.towards_winch(line))
    moved = tuple(
        with_exit_point(line, tuple(line.exit_point + each)).model_copy(update={"exit_compliance": None})
        for line, each in zip(robot.lines, gone, strict=True)
    )
    assert np.abs(gone).max() > 1e-3
    stiff = robot.model_copy(update={"lines": moved})
    there = cw.forward(stiff, found.lengths + longer, cable=cable)
    np.testing.assert_allclose(there.pose, found.pose, atol=1e-9)
    np.testing.assert_allclose(there.tensions, found.tensions, rtol=1e-7)


@pytest.mark.parametrize("name", ["merlet2023", "cogiro", "house-printer", "jung2020"])
@pytest.mark.parametrize("cable", ["elastic", "catenary"])
def test_one_number_keeps_a_line_in_its_plane(name: str, cable: str) -> None:
    """It is the stiff robot with its exit points where the forces in that plane put them; winches go along sideways."""
    robot = on_mounts(load(name), [(1 + i) * 2e-6 for i in range(load(name).m)])
    assert all(line.in_plane for line in robot.lines)
    found = held(robot, cable)
    exits = []
    for i, line in enumerate(robot.lines):
        phi, tau, psi = found.states[i, [layout.PHI, layout.TAU, layout.PSI]]
        away = (found.platform_points[i] - line.exit_point)[:2]
        dead = np.sin(psi) if line.winch_exit is not None else 0.0
        ahead = np.append(np.cos(phi) * away / np.linalg.norm(away), np.sin(phi) + dead)
        exits.append(line.exit_point + line.exit_compliance * np.exp(tau) * ahead)
    moved = tuple(
        with_exit_point(line, tuple(at)).model_copy(update={"exit_compliance": None})
        for line, at in zip(robot.lines, exits, strict=True)
    )
    there = cw.forward(robot.model_copy(update={"lines": moved}), found.lengths, cable=cable, guess=found.pose)
    np.testing.assert_allclose(there.pose, found.pose, atol=1e-9)
    np.testing.assert_allclose(there.tensions, found.tensions, rtol=1e-7)
    again = cw.forward(robot, found.lengths, cable=cable)
    np.testing.assert_allclose(again.pose, found.pose, atol=1e-9)
    assert np.linalg.norm(cw.forward(load(name), found.lengths, cable=cable).pose[:3] - found.pose[:3]) > 1e-4


@pytest.mark.parametrize("name", ["merlet2023", "cogiro", "jung2020"])
@pytest.mark.parametrize("cable", ["elastic", "catenary"])
def test_one_number_is_an_isotropic_compliance_matrix(name: str, cable: str) -> None:
    """The one in the plane's kernel, the other in that of lines out of the plane."""
    one = on_mounts(load(name), 6e-6, arc_elastic=True)
    other = on_mounts(one, tuple(map(tuple, (6e-6 * np.eye(3)).tolist())))
    assert not other.lines[0].in_plane
    first = held(one, cable)
    second = cw.forward(other, first.lengths, cable=cable, guess=first.pose)
    np.testing.assert_allclose(second.pose, first.pose, atol=1e-9)
    np.testing.assert_allclose(second.tensions, first.tensions, rtol=1e-8)
    matrices = [cw.linearise(each).stiffness for each in (first, second)]
    np.testing.assert_allclose(*matrices, rtol=1e-6, atol=1e-8 * np.abs(matrices[0]).max())
    parts = [stiffness(each).axial for each in (first, second)]
    np.testing.assert_allclose(*parts, rtol=1e-7)


@pytest.mark.parametrize("name", ["merlet2023", "cogiro", "house-printer", "jung2020"])
def test_of_lines_in_planes_motions_are_differences(name: str) -> None:
    robot = on_mounts(load(name), 4e-6)
    each, model = held(robot, "catenary"), Model.of(robot)
    kinds = ("modulus", "exit_point.x", "exit_point.z", "length_offset", "exit_compliance", "creep_compliance")
    for kind in (*kinds, *(() if isinstance(robot.lines[0].sheave, Eyelet) else ("sheave_radius",))):
        step = {"modulus": 1e-4, "exit_compliance": 1e-9, "creep_compliance": 1e-9}.get(kind, 1e-6)
        parameter = Parameter(kind, robot.lines[0].name)
        motion = response(each[None], [parameter])[0, :, 0]
        apart = differences(model, each, parameter, step)
        np.testing.assert_allclose(motion, apart, rtol=2e-5, atol=2e-6 * np.abs(apart).max(), err_msg=kind)
    skew = cw.linearise(each).stiffness - cw.linearise(each).stiffness.T
    assert np.abs(skew).max() < 1e-6 * np.abs(cw.linearise(each).stiffness).max()


def held(robot: Robot, cable: str) -> cw.Equilibrium:
    """A pose in the middle of the robot, turned a little where it can turn."""
    at = {"house-printer": [1.0, -0.7, 2.0], "jung2020": [0.2, 0.1, 0.8], "cogiro": [0.4, -0.3, 1.2]}
    place = at.get(robot.name, POSE)
    turn = [0.0, 0.0, 0.01] if robot.name == "jung2020" else [0.02, -0.01, 0.03]
    pose = [*place, *turn] if robot.n == 6 else place
    return cw.inverse(robot, pose, cable=cable).checked()


@pytest.mark.parametrize("cable", ["rigid", "elastic"])
def test_a_mount_of_zero_compliance_is_stiff(cable: str) -> None:
    """Compliant mounts are stiff too where cables are rigid: lengths are then geometry."""
    plain = load("merlet2023")
    for compliance in (0.0, *([1e-5] if cable == "rigid" else [])):
        same = cw.inverse(on_mounts(plain, compliance), POSE, cable=cable)
        stiff = cw.inverse(plain, POSE, cable=cable)
        np.testing.assert_allclose(same.lengths, stiff.lengths, rtol=1e-12)
        np.testing.assert_allclose(same.tensions, stiff.tensions, rtol=1e-9)


@pytest.mark.parametrize("described", [False, True])
def test_it_is_the_plant_with_these_mounts(described: bool) -> None:
    """Which closes the mounts, line by line, around the stiff robot."""
    plain = load("merlet2023")
    if not described:
        lines = tuple(line.model_copy(update={"winch_exit": None}) for line in plain.lines)
        plain = plain.model_copy(update={"lines": lines})
    soft = random_matrices(4)
    lengths = cw.inverse(plain, POSE).checked().lengths
    model, states = Model.of(plain), cw.forward(plain, lengths)
    pose, own = states.pose.copy(), states.states.copy()
    packed = model.packed._replace(lines=model.packed.lines.copy())
    work = workspace(packed)
    evaluate(packed, lengths, pose, own, work)
    mounts = ExitMountState(np.array(soft))
    assert mounts.close(packed, np.arange(4), lengths, pose, own, np.ones(4), work) == 0
    found = cw.forward(on_mounts(plain, soft), lengths)
    assert np.linalg.norm(found.pose - states.pose) > 2e-3
    # the plant's dead span is a catenary and its exit goes aside of its winch: both by the square alone
    np.testing.assert_allclose(found.pose, pose, atol=2e-5)


def test_tensions_follow_the_mounts() -> None:
    robot = on_mounts(load("merlet2023"), 5e-6)
    parameter, step = Parameter("exit_compliance"), 1e-9
    found = cw.inverse(robot, POSE).checked()
    there = [cw.forward(on_mounts(robot, 5e-6 + way * step), found.lengths, guess=found.pose) for way in (-1, 1)]
    motion = response(found[None], [parameter])
    np.testing.assert_allclose(motion[0, :, 0], (there[1].pose - there[0].pose) / (2 * step), rtol=1e-5, atol=1e-4)
    changes = tension_response(found[None], [parameter], motion, tension_changes(found[None]))
    np.testing.assert_allclose(
        changes[0, :, 0], (there[1].tensions - there[0].tensions) / (2 * step), rtol=1e-4, atol=10.0
    )


def test_no_theorem_is_about_them() -> None:
    robot = on_mounts(load("merlet2023"), 5e-6)
    plain = {"sheave": Eyelet(), "winch_exit": None}
    assert unique_among(cw.inverse(on_mounts(robot, None, **plain), POSE)) is not None
    assert unique_among(cw.inverse(on_mounts(robot, 0.0, **plain), POSE)) is not None
    assert unique_among(cw.inverse(on_mounts(robot, 1e-6, **plain), POSE)) is None


def test_a_tracker_proves_each_step() -> None:
    robot = on_mounts(load("merlet2023"), 5e-6)
    held = cw.inverse(robot, POSE).checked()
    tracker = cw.Tracker(Model.of(robot), held.lengths)
    aim = held.lengths + np.array([1e-3, -1e-3, 5e-4, 2e-3])
    assert tracker.step(aim) is Status.OK
    np.testing.assert_allclose(tracker.pose, cw.forward(robot, aim).pose, atol=1e-9)


@pytest.mark.parametrize(
    ("compliance", "message"),
    [
        (-1e-6, "must be 0 to 0.01 m/N"),
        (1.0, "must be 0 to 0.01 m/N"),
        ([[1e-6, 1e-7, 0], [0, 1e-6, 0], [0, 0, 1e-6]], "symmetric"),
        ([[1e-6, 2e-6, 0], [2e-6, 1e-6, 0], [0, 0, 1e-6]], "smallest eigenvalue is -1e-06 m/N"),
    ],
)
def test_bad_compliances_are_one_line(compliance: Any, message: str, tmp_path: Path) -> None:
    text = (Path(cw.robot.__file__).parent / "library" / "merlet2023.toml").read_text()
    (tmp_path / "soft.toml").write_text(text.replace("[line]", f"[line]\nexit_compliance = {compliance}", 1))
    with pytest.raises(InputError, match=message.replace("(", r"\(")) as caught:
        load(tmp_path / "soft.toml")
    assert "exit_compliance" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_mounts_of_zero_compliance_are_as_stiff_ones_everywhere() -> None:
    """A zero written in the file, where a bound is given in an uncertainty, rejects nothing."""
    zero = tuple(map(tuple, np.zeros((3, 3)).tolist()))
    for compliance in (0.0, zero):
        robot = on_mounts(load("merlet2023"), compliance)
        assert all(line.in_plane and not line.mount_gives for line in robot.lines)
        held = cw.inverse(robot, POSE).checked()
        assert cw.certify(held).certified
        cw.Tracker(Model.of(robot), held.lengths)


@pytest.mark.parametrize("name", ["house-printer", "merlet2023"])
def test_winches_on_drives_count_them(name: str) -> None:
    """Homing's lengths by a place and tensions are those of the statics."""
    robot, place = on_mounts(load(name), 3e-6), np.array([1.0, 0.7, 1.5])
    held = cw.inverse(robot, place).checked()
    assert np.abs(held.lengths - cw.inverse(load(name), place).lengths).max() > 1e-3
    np.testing.assert_allclose(lengths_at(Model.of(robot), place, held.tensions), held.lengths, atol=1.5e-3)
    found = check_lengths(Model.of(robot), held.lengths, held.tensions, place + 0.05)
    assert found is not None
    np.testing.assert_allclose(found.pose, place, atol=3e-3)


def test_a_check_compensates_mounts_with_the_stretch() -> None:
    robot = on_mounts(load("cogiro"), 1e-5)
    pose = np.array([[0.0, 0.0, 1.5, 0.0, 0.0, 0.0]])
    at = PathStatics.of(cw.inverse(robot, pose), pose, None)
    there = cw.forward(robot, cw.inverse(robot, pose, cable="elastic").checked().lengths, guess=pose)
    np.testing.assert_allclose(at.elastic_only, there.pose, atol=1e-6)
    assert np.abs(at.elastic_only - pose).max() < 1e-3 < 1e-2 < np.abs(at.uncompensated - pose).max()


def test_a_bracket_has_its_own_mount() -> None:
    with pytest.raises(InputError, match=r"bracket: line '.*' has exit_compliance"):
        cw.bracket(on_mounts(load("paty2021"), 1e-6), [0.0, 0.0, 1.0], times=1)


def test_mounts_of_universal_joints_and_swivels_aside() -> None:
    with pytest.raises(ValidationError, match="exit_compliance: must be one number on a universal joint"):
        on_mounts(load("paty2021"), random_matrices(4))
    with pytest.raises(ValidationError, match="exit_compliance: is not for a swivel whose cable comes from aside"):
        on_mounts(out_of_plane.point("aside"), 1e-6)
