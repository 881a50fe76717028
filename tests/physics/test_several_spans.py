"""Lines of several spans, over pulleys on the platform or side by side, against MuJoCo, the energy and plain lines."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from pydantic import ValidationError
from scipy.optimize import minimize, root

import cablewright as cw
from cablewright.analyses import feasibility
from cablewright.foundation.signals import Command
from cablewright.kernels.plant import winding
from cablewright.machine.simulated.machine_file import built_machine
from cablewright.models.stiffness import stiffness
from cablewright.robot import Eyelet, Robot
from cablewright.solvers.hardware_limits import winch_torques
from cablewright.solvers.tension import self_stresses, structures
from print_logs import RING

EXITS = np.array([(-2.0, -2.0, 0.1), (2.0, -2.0, 0.2), (2.0, 2.0, 0.0), (-2.0, 2.0, 0.1), (0.1, 0.2, 3.0)])
SPANS, CABLES = (2, 3, 1, 2, 4), (1, 2, 2, 1, 1)
BODY_SPANS, BODY_CABLES = (1, 2, 3, 4, 1, 2, 3, 4), (2, 1, 1, 2, 1, 1, 2, 1)
STIFFNESS, DENSITY, LIMITS = 4.5e4, 0.05, (5.0, 400.0)  # N, kg/m, N


def robot(plain: bool = False, **own: Any) -> Robot:
    """A point on lines of several spans; *plain*: on one span each, of the same strength together."""
    lines = []
    for i, (spans, cables) in enumerate(zip(SPANS, CABLES, strict=True)):
        pulls = spans * cables if plain else 1
        cable = {"axial_stiffness": pulls * STIFFNESS, "linear_density": pulls * DENSITY, "breaking_load": pulls * 4e3}
        limits = (pulls * LIMITS[0], pulls * LIMITS[1])
        line = {"name": f"line {i}", "exit_point": tuple(EXITS[i]), "cable": cable, "sheave": {"kind": "eyelet"}}
        line |= {"tension_limits": limits, "winch": {"drum_radius": 0.03}} | own
        line |= {} if plain else {"advantage": spans, "cables": cables}
        lines.append(line)
    scene = {"frame_min": (-2, -2, 0), "frame_max": (2, 2, 3)}
    return Robot.model_validate({"name": "point", "scene": scene, "platform": {"mass": 9}, "lines": lines})


def body(plain: bool = False) -> Robot:
    """The same of a body on eight lines, two cables for every third and up to four spans."""
    there, lines = cw.load("cogiro"), []
    for i, line in enumerate(there.lines):
        spans, cables = BODY_SPANS[i], BODY_CABLES[i]
        pulls = spans * cables if plain else 1
        own = line.cable.model_copy(update={
            "young_modulus": None, "section": None, "axial_stiffness": pulls * line.cable.stiffness,
            "linear_density": pulls * line.cable.linear_density, "breaking_load": pulls * line.cable.breaking_load,
        })  # fmt: skip
        limits = (10.0 * pulls, 5e3 * pulls)
        more = {} if plain else {"advantage": spans, "cables": cables}
        eyelet = {"sheave": Eyelet(), "winch_exit": None, "dead_length": 0.0}
        lines.append(line.model_copy(update={"cable": own, "tension_limits": limits} | eyelet | more))
    return there.model_copy(update={"lines": tuple(lines)})


def places(count: int = 40) -> np.ndarray:
    return np.random.default_rng(4).uniform([-1.2, -1.2, 0.4], [1.2, 1.2, 2.4], (count, 3))


def turned(count: int) -> np.ndarray:
    return np.random.default_rng(5).uniform([-2, -1.5, 1, -0.1, -0.1, -0.1], [2, 1.5, 3, 0.1, 0.1, 0.1], (count, 6))


@pytest.mark.parametrize("cable", ["rigid", "elastic", "catenary"])
def test_they_are_stronger_lines_that_take_more_length(cable: str) -> None:
    several, plain = (cw.inverse(robot(each), places(), cable=cable) for each in (False, True))
    np.testing.assert_array_equal(several.ok, plain.ok)
    assert several.ok.sum() > 20
    held, same = several[several.ok], plain[plain.ok]
    assert held.is_valid()
    np.testing.assert_allclose(held.lengths, same.lengths * SPANS, rtol=2e-6)  # tensions differ in their minimum
    assert (held.margin() >= 0.0).all()


@pytest.mark.parametrize("kind", ["point", "body"])
@pytest.mark.parametrize("cable", ["elastic", "catenary"])
def test_the_way_back_and_its_derivatives(cable: str, kind: str) -> None:
    made, spans, poses = (robot, SPANS, places(12)) if kind == "point" else (body, BODY_SPANS, turned(12))
    several, plain = (cw.Model.of(made(each), cable=cable) for each in (False, True))
    held = cw.inverse(several, poses)
    held = held[held.ok]
    assert len(held) > 4
    found = cw.forward(several, held.lengths, guess=held.pose).checked()
    np.testing.assert_allclose(found.pose, held.pose, atol=1e-8)
    same = cw.forward(plain, held.lengths / spans, guess=held.pose).checked()
    np.testing.assert_allclose(found.pose, same.pose, atol=1e-9)
    factors = several.lines.pulls
    np.testing.assert_allclose(found.tensions * factors, same.tensions, rtol=1e-6)
    axial = [stiffness(each).axial for each in (found, same)]
    np.testing.assert_allclose(axial[0], axial[1], rtol=1e-5)
    own, other = cw.linearise(found), cw.linearise(same)
    np.testing.assert_allclose(own.stiffness, other.stiffness, rtol=1e-6, atol=1e-6 * np.abs(own.stiffness).max())
    scale = np.abs(other.motion).max()
    np.testing.assert_allclose(own.motion[..., 0] * spans, other.motion[..., 0], atol=1e-6 * scale)
    np.testing.assert_allclose(own.motion[..., 1:], other.motion[..., 1:], atol=1e-6 * scale)


def test_a_drum_holds_all_its_cables() -> None:
    held = cw.inverse(robot(), [0.1, 0.2, 1.0]).checked()
    np.testing.assert_allclose(winch_torques(held), held.winch_tensions * CABLES * 0.03)
    room = next(limit for limit in feasibility.LIMITS if limit.name == "cable length")
    allowed = room.allowed(robot(winch={"drum_radius": 0.03, "capacity": 12}).lines)
    np.testing.assert_allclose(allowed[:, 1], 12.0 / np.array(CABLES))


@pytest.mark.parametrize("winch_exit", [None, (0.4, 0.7, -1.0)])
def test_the_platform_rests_where_the_energy_is_least(winch_exit: tuple[float, ...] | None) -> None:
    """Between winch and platform the whole cable stretches; its length is that of all spans and of the dead one."""
    model = cw.Model.of(robot(winch_exit=winch_exit), cable="elastic")
    held = cw.inverse(model, places(16))
    held = held[held.ok]
    assert len(held) > 4
    dead = 0.0 if winch_exit is None else np.linalg.norm(EXITS - winch_exit, axis=1)
    for pose, tensions, own in zip(held.pose, held.tensions, held.lengths, strict=True):
        span = np.linalg.norm(EXITS - pose, axis=1)
        np.testing.assert_allclose(own * (1.0 + tensions / STIFFNESS), span * SPANS + dead, atol=1e-9)

        def energy(x: np.ndarray, own: np.ndarray = own) -> float:
            stretch = np.maximum(np.linalg.norm(EXITS - x, axis=1) * SPANS + dead - own, 0.0)
            return float((0.5 * STIFFNESS * stretch**2 / own) @ CABLES + 9.0 * 9.81 * x[2])

        rest = minimize(energy, pose + 1e-3, method="Nelder-Mead", options={"xatol": 1e-11, "fatol": 1e-15})
        np.testing.assert_allclose(pose, rest.x, atol=2e-8)


def test_the_platform_rests_where_mujocos_does() -> None:
    """There a tendon runs to and fro between two sites, once for each span."""
    model = cw.Model.of(robot(), cable="elastic")
    held = cw.inverse(model, places(8))
    held = held[held.ok]
    assert len(held) > 2
    for pose, tensions, lengths in zip(held.pose, held.tensions, held.lengths, strict=True):
        world = mujoco.MjModel.from_xml_string(_xml(lengths))
        data = mujoco.MjData(world)

        def forces(x: np.ndarray, world: Any = world, data: Any = data) -> np.ndarray:
            data.qpos[:], data.qvel[:] = x, 0.0
            mujoco.mj_forward(world, data)
            return np.array(data.qfrc_passive - data.qfrc_bias)

        rest = root(forces, pose + 1e-3, tol=1e-13)
        np.testing.assert_allclose(rest.x, pose, atol=1e-8)
        first = np.cumsum([0, *CABLES])[:-1]
        pulled = (data.ten_length - world.tendon_lengthspring[:, 0]) * world.tendon_stiffness
        np.testing.assert_allclose(pulled[first], tensions, rtol=1e-6)


def _xml(lengths: np.ndarray) -> str:
    sites = "".join(f'<site name="A{i}" pos="{x} {y} {z}"/>' for i, (x, y, z) in enumerate(EXITS))
    tendons = ""
    for i, (spans, cables, length) in enumerate(zip(SPANS, CABLES, lengths, strict=True)):
        route = "".join(f'<site site="{"B" if k % 2 else f"A{i}"}"/>' for k in range(spans + 1))
        tendons += f'<spatial stiffness="{STIFFNESS / length}" springlength="{length}">{route}</spatial>' * cables
    slides = "".join(f'<joint type="slide" axis="{axis}"/>' for axis in ("1 0 0", "0 1 0", "0 0 1"))
    load = f'<body>{slides}<geom size="0.01" mass="9"/><site name="B"/></body>'
    return (
        f'<mujoco><option gravity="0 0 -9.81"/><worldbody>{sites}{load}</worldbody><tendon>{tendons}</tendon></mujoco>'
    )


def test_each_span_sags_by_itself() -> None:
    """A span of one cable at one tension: neither its sag nor its shape knows of the other spans."""
    held = cw.inverse(robot(), places())
    held = held[held.ok]
    alone = cw.inverse(robot(True), held.pose)
    np.testing.assert_allclose(held.line_states.free_angle, alone.line_states.free_angle, atol=1e-4)
    spans = held.line_states.free_length
    np.testing.assert_allclose(held.lengths, spans * SPANS, rtol=1e-12)


@pytest.mark.parametrize("cable", ["elastic", "catenary"])
def test_slack_lines_hang_by_all_their_spans(cable: str) -> None:
    several, plain = (cw.Model.of(robot(each), cable=cable) for each in (False, True))
    pose, excess = [-0.3, 0.4, 1.2], 0.03  # m
    found = cw.solve_with_slack(several, pose, {1: excess * SPANS[1]}).checked()
    same = cw.solve_with_slack(plain, pose, {1: excess}).checked()
    np.testing.assert_allclose(found.lengths, same.lengths * SPANS, rtol=1e-9)
    np.testing.assert_allclose(found.tensions * several.lines.pulls, same.tensions, rtol=1e-7)
    back = cw.forward(several, found.lengths, guess=pose).checked()
    np.testing.assert_allclose(back.pose, pose, atol=1e-8)


def test_tensions_that_balance_each_other() -> None:
    held = cw.inverse(robot(), [0.3, -0.4, 1.2], cable="elastic").checked()
    structure, _ = structures(cw.Model.of(robot(), cable="elastic"), held.pose)
    np.testing.assert_allclose(structure[0] @ self_stresses(held).T, 0.0, atol=1e-12)


def test_lengths_between_samples_are_too_long_in_each_span(tmp_path: Path) -> None:
    """The expected error of exact robots is that of straight lines between the samples' lengths."""
    job = tmp_path / "ring.toml"
    job.write_text(RING.format(radius=0.6).replace("[helix]", '[sampling]\nstep = "10 cm"\n[helix]'))
    exact = tmp_path / "exact.toml"
    exact.write_text('schema = 1\nname = "exact"\n[[parameters]]\nname = "length_offset"\nplus_minus = "0.001 um"\n')
    ranges = cw.load_uncertainty(exact)
    several, plain = (cw.check(robot(each), job, uncertainty=ranges).expected for each in (False, True))
    assert plain.value > 1e-6
    assert several.value == pytest.approx(plain.value, rel=0.02)


def test_a_proof_covers_them() -> None:
    model = cw.Model.of(robot())
    held = cw.inverse(model, places(12))
    held = held[held.ok]
    found = cw.forward(model, held.lengths).checked()
    proofs = cw.certify(found)
    assert proofs.certified.all()
    assert (np.abs(found.pose - held.pose).max(axis=1) <= proofs.bound.max(axis=1) + 1e-9).all()


@pytest.mark.slow
@pytest.mark.parametrize("criterion", ["exact", "wrench-closure", "static"])
def test_the_workspace_is_that_of_stronger_lines(criterion: str) -> None:
    several, plain = (cw.workspace(robot(each), criterion, tolerance=0.05) for each in (False, True))
    assert several.volume == pytest.approx(plain.volume, rel=5e-3)


@pytest.mark.parametrize(
    ("own", "message"),
    [
        ({"advantage": 0}, "greater than or equal to 1"),
        ({"advantage": 2.5}, "integer"),
        ({"advantage": 13}, "less than or equal to 12"),
        ({"cables": True}, "integer"),
        ({"advantage": 2, "sheave": {"kind": "swivel", "radius": 0.02}}, "must be 1 over a sheave that turns"),
    ],
)
def test_what_is_no_number_of_spans(own: dict[str, Any], message: str) -> None:
    line = robot().lines[0].model_dump(mode="json") | {"advantage": 1, "cables": 1} | own
    with pytest.raises(ValidationError, match=message):
        type(robot().lines[0]).model_validate(line)


def test_a_machine_with_cables_side_by_side_moves_as_with_one_of_their_strength() -> None:
    found = []
    for strong in (True, False):
        lines = []
        for line, cables in zip(robot().lines, CABLES, strict=True):
            pulls = cables if strong else 1
            cable = line.cable.model_copy(update={
                "axial_stiffness": pulls * STIFFNESS, "linear_density": pulls * DENSITY, "breaking_load": pulls * 4e3,
                "diameter": 2e-3,
            })  # fmt: skip
            limits = (pulls * LIMITS[0], pulls * LIMITS[1])
            own = {"advantage": 1, "cables": 1 if strong else cables, "cable": cable, "tension_limits": limits}
            lines.append(line.model_copy(update=own))
        described = robot().model_copy(update={"lines": tuple(lines)})
        twin, _ = built_machine(described)
        found.append(cw.SimulatedMachine(described, twin, [0.3, -0.2, 0.8], seed=3))
    speeds = np.array([0.2, -0.1, 0.1, -0.2, 0.05])
    for k in range(1, 21):
        one, several = (each.step(Command(0.01 * k, speeds)) for each in found)
        assert [each.condition for each in one.notices] == [each.condition for each in several.notices]
    one, several = (each.truth for each in found)
    assert several.position == pytest.approx(one.position, abs=1e-9)
    assert several.tensions * CABLES == pytest.approx(one.tensions, rel=1e-6)
    pulls = [each.rig.winches.state[:, winding.RATIO] * each.truth.tensions for each in found]
    assert pulls[1] == pytest.approx(pulls[0], rel=1e-6)
