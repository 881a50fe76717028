"""The oracles against each other and against what can be worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from mpmath import mp, mpf

from cablewright.robot import (
    Cable,
    Eyelet,
    Line,
    PointPlatform,
    Robot,
    Scene,
    Sheave,
    Swivel,
    UniversalJoint,
    load,
)
from oracles import chain, irvine, machine, mujoco_model, tangent
from oracles.line import LineState, check

OVER = Swivel(radius=0.5, wrap="over")
UNDER = Swivel(radius=0.5, wrap="under")


def _line(sheave: Sheave, **changes: object) -> Line:
    cable = Cable(axial_stiffness=1e5, linear_density=0.05, breaking_load=1e5)
    given = {"name": "x", "exit_point": (0, 0, 0), "cable": cable, "sheave": sheave, "tension_limits": (0, 1e4)}
    return Line.model_validate(given | changes)


def _with(robot: Robot, density: float | None = None, **changes: object) -> Robot:
    lines = []
    for line in robot.lines:
        cable = line.cable if density is None else line.cable.model_copy(update={"linear_density": density})
        lines.append(line.model_copy(update={"cable": cable, **changes}))
    return robot.model_copy(update={"lines": tuple(lines)})


class TestSpan:
    def test_hanging_straight_down_it_stretches_by_its_load_and_half_its_weight(self) -> None:
        x, z = irvine.span(0, 10, 2, 1, 100)
        assert x == 0
        assert float(z) == 2.22

    def test_hanging_straight_it_goes_down_and_up_again(self) -> None:
        x, z = irvine.span(0, -3, 5, 1, 1e300)  # 3 m down, 2 m up
        assert x == 0
        assert float(z) == pytest.approx(-1, abs=1e-15)

    def test_from_its_lowest_point_it_is_the_catenary(self) -> None:
        x, z = irvine.span(4, 0, 3, 1, mp.inf)  # a = H/w = 4 m, L/a = 3/4
        assert float(x) == pytest.approx(4 * math.log(2), rel=1e-15)
        assert float(z) == pytest.approx(1, rel=1e-15)

    def test_it_is_mirrored_by_the_sign_of_its_horizontal_force(self) -> None:
        right, left = irvine.span(3, -7, 5, 0.4, 1e4), irvine.span(-3, -7, 5, 0.4, 1e4)
        assert right[0] > 0
        assert right[0] + left[0] == 0
        assert right[1] == left[1]

    def test_travelled_backwards_it_is_the_same(self) -> None:
        with mp.workdps(50):
            x, z = irvine.span(3, -7, 5, mpf("0.4"), 1e4)
            back = irvine.span(-3, 5, 5, mpf("0.4"), 1e4)  # from its end, where the force is (3, -7 + 2), reversed
            assert abs(back[0] + x) < 1e-45
            assert abs(back[1] + z) < 1e-45

    def test_without_weight_it_is_a_spring(self) -> None:
        x, z = irvine.span(3, -4, 10, 0, 100)
        assert float(x) == pytest.approx(6 * 1.05, rel=1e-15)
        assert float(z) == pytest.approx(-8 * 1.05, rel=1e-15)

    def test_its_weight_fades_linearly_without_loss_of_digits(self) -> None:
        spring = irvine.span(3, -4, 10, 0, 100)
        with mp.workdps(50):
            gaps = [
                [a - b for a, b in zip(irvine.span(3, -4, 10, w, 100), spring, strict=True)] for w in (1e-20, 1e-30)
            ]
            for heavier, lighter in zip(*gaps, strict=True):
                assert float(heavier / lighter) == pytest.approx(1e10, rel=1e-15)

    @pytest.mark.parametrize("force", [(5.0, -4.0), (70.0, -40.0), (0.2, -0.9), (1e-3, -2.0)])
    def test_its_start_tension_is_found_back(self, force: tuple[float, float]) -> None:
        end = irvine.span(*force, 11, 0.3, 1e6)
        H, V0 = irvine.start_tension(*end, 11, 0.3, 1e6, (force[0] * 1.01, force[1] * 0.99))
        assert float(abs(H - force[0]) + abs(V0 - force[1])) < 1e-25


class TestChain:
    @pytest.mark.parametrize(
        ("x", "z", "L", "w", "EA"),
        [(10, -5, 11.3, 0.3, 1e6), (10, -5, 11.17, 0.3, 1e6), (10, 2, 14, 5, 1e4), (3, -10, 10.5, 0.0667, 7e5)],
        ids=["slack", "taut", "loop", "steep"],
    )
    def test_it_nears_the_catenary_with_the_square_of_its_links(
        self, x: float, z: float, L: float, w: float, EA: float
    ) -> None:
        errors = []
        for links in (200, 400):
            ends = chain.end_tensions(x, z, L, w, EA, links)
            H, V0 = (float(v) for v in irvine.start_tension(x, z, L, w, EA, tuple(ends[0])))
            errors.append(np.abs(ends - [[H, V0], [H, V0 + w * L]]).max() / np.abs(ends).max())
        assert errors[1] < 1e-5
        assert errors[0] / errors[1] == pytest.approx(4, abs=0.2)


class TestLine:
    def test_a_quarter_turn_over_a_sheave(self) -> None:
        """Up 2 m to the exit point, over the sheave, then 3 m level: the middle of a sheave of 0.5 m is at (0.5, 0)."""
        line = _line(OVER, winch_exit=(0, 0, -2))
        result = check(line, 10, (3.5, 0, 0.5), 5 + math.pi / 4, LineState(100, 0, 3, -math.pi / 2, 2), "rigid")
        assert max(abs(value) for value in result.vector) < 1e-15
        assert [float(value) for value in result.force] == pytest.approx([-100, 0, 0], abs=1e-12)
        assert float(result.wound) == pytest.approx(math.pi / 2)

    def test_a_quarter_turn_under_a_sheave(self) -> None:
        line = _line(UNDER, winch_exit=(0, 0, 2))
        result = check(line, 10, (0, 3.5, -0.5), 5 + math.pi / 4, LineState(100, 0, 3, math.pi / 2, 2), "rigid")
        assert max(abs(value) for value in result.vector) < 1e-15
        assert [float(value) for value in result.force] == pytest.approx([0, -100, 0], abs=1e-12)

    def test_without_a_winch_exit_its_dead_length_counts_as_it_is(self) -> None:
        line = _line(OVER, dead_length=7)
        result = check(line, 10, (3.5, 0, 0.5), 10 + math.pi / 4, LineState(100, 0, 3), "rigid")
        assert max(abs(value) for value in result.vector) < 1e-15

    @pytest.mark.parametrize(("dead", "arc"), [(True, True), (True, False), (False, True), (False, False)])
    def test_each_part_stretches_if_it_is_said_to(self, dead: bool, arc: bool) -> None:
        line = _line(OVER, winch_exit=(0, 0, -2), dead_elastic=dead, arc_elastic=arc)
        free, hangs, turn = 3 / 1.001, 2 / (1.001 if dead else 1), math.pi / 4 / (1.001 if arc else 1)  # T/EA = 0.001
        state = LineState(100, 0, free, -math.pi / 2, hangs)
        result = check(line, 10, (3.5, 0, 0.5), free + hangs + turn, state, "elastic")
        assert max(abs(value) for value in result.vector) < 1e-15

    def test_the_weight_of_its_spans_is_shared_between_platform_and_winch(self) -> None:
        line = _line(Eyelet(), exit_point=(0, 0, 5), winch_exit=(-3, -4, 0))
        w, EA = mpf(0.05) * 10, 1e5
        free, dead = irvine.span(20, -15, 6, w, EA), irvine.span(15, -20, 7, w, EA)
        B = [free[0] * mpf(3) / 5, free[0] * mpf(4) / 5, 5 + free[1]]
        at = LineState(25, mp.atan2(-15, 20), 6, mp.atan2(-20, 15), 7)
        result = check(line, 10, B, 13, at)
        assert max(abs(result.free_end[0]), abs(result.free_end[1]), abs(result.length)) < 1e-14
        assert float(result.dead_end[0]) == pytest.approx(float(dead[0]) - 5)
        assert float(result.dead_end[1]) == pytest.approx(float(dead[1]) + 5)
        assert [float(value) for value in result.force] == pytest.approx([-12, -16, 15 - 3], abs=1e-12)

    def test_a_weightless_lever_halves_the_angle_of_the_cable_and_a_heavy_one_sags(self) -> None:
        joint = UniversalJoint(radius=0.05, lever=0.1, lever_weight=0, lever_mass_centre=0.07)
        line = _line(joint, winch_exit=(0, 0, -9))
        light = tangent.straight(line, (4, 0, -6), 100)
        assert light.beta == pytest.approx((light.phi + light.psi) / 2, abs=1e-12)
        heavy = tangent.straight(
            line.model_copy(update={"sheave": joint.model_copy(update={"lever_weight": 50})}), (4, 0, -6), 100
        )
        assert heavy.beta < light.beta - 0.01

    @pytest.mark.parametrize("wrap", ["over", "under"])
    @pytest.mark.parametrize("kind", ["eyelet", "swivel", "universal-joint"])
    def test_school_geometry_fulfils_it(self, kind: str, wrap: str) -> None:
        sheave = {
            "eyelet": Eyelet(),
            "swivel": Swivel(radius=0.3, wrap=wrap),
            "universal-joint": UniversalJoint(radius=0.3, lever=0.5, lever_weight=40, lever_mass_centre=0.2, wrap=wrap),
        }[kind]
        line = _line(sheave, exit_point=(1, 2, 3), winch_exit=(1, 2, -4 if wrap == "over" else 9))
        state = tangent.straight(line, (3, -1, -2), 80)
        result = check(line, 9.81, (3, -1, -2), tangent.length(line, state), state, "rigid")
        assert max(abs(value) for value in result.vector) < 1e-14

    @pytest.mark.parametrize("sheave", [Eyelet(), OVER, UNDER])
    def test_it_pulls_against_the_growth_of_its_length(self, sheave: Sheave) -> None:
        line, B = _line(sheave), np.array([3.0, -2.0, -4.0])
        growth = [
            (tangent.length(line, tangent.straight(line, B + d)) - tangent.length(line, tangent.straight(line, B - d)))
            / 2e-5
            for d in np.eye(3) * 1e-5
        ]
        force = check(line, 9.81, B, 1, tangent.straight(line, B, 70), "rigid").force
        assert [float(value) for value in force] == pytest.approx(list(-70 * np.array(growth)), abs=1e-7)

    def test_below_its_exit_point_it_has_no_plane(self) -> None:
        with pytest.raises(ValueError, match="has no plane"):
            check(_line(OVER), 9.81, (0, 0, -3), 3, LineState(1, 0, 3))


class TestMachine:
    def test_paty2021_sinks_by_19_mm_where_rigid_lengths_should_hold_it_at_the_ground(self) -> None:
        robot = load("paty2021")
        states, lengths = machine.start(robot, (0, 0, 0), [600] * 4)
        assert machine.balance(robot, lengths, (0, 0, 0), states, "rigid").geometry < 1e-14
        found = machine.solve(robot, lengths, (0, 0, 0), states)
        assert float(found.pose[2]) == pytest.approx(-19.0e-3, abs=0.05e-3)
        assert max(abs(value) for value in found.pose[:2]) < 1e-20
        assert found.balance.geometry < 1e-20
        assert found.balance.force < 1e-15
        assert found.balance.moment < 1e-20

    def test_it_finds_the_same_from_elsewhere(self) -> None:
        robot = load("merlet2023")
        pose = (0.7, -1.9, 1.1)
        near = machine.start(robot, pose, [150] * 4)
        far = machine.start(robot, (-0.4, 0.3, 1.5), [120] * 4)
        lengths = [length - 5e-4 for length in near[1]]
        first = machine.solve(robot, lengths, pose, near[0])
        second = machine.solve(robot, lengths, (-0.4, 0.3, 1.5), far[0])
        assert machine.distance(first.pose, second.pose) < 1e-20

    def test_the_error_of_a_wrong_claim_is_reported(self) -> None:
        robot = load("merlet2023")
        states, lengths = machine.start(robot, (0.7, -1.9, 1.1), [150] * 4)
        lengths = [length - 5e-4 for length in lengths]
        found = machine.solve(robot, lengths, (0.7, -1.9, 1.1), states)
        longer = machine.balance(robot, [lengths[0] + 1e-6, *lengths[1:]], found.pose, found.states)
        assert longer.geometry == pytest.approx(1e-6, rel=1e-9)
        heavier = robot.model_copy(update={"platform": PointPlatform(mass=robot.platform.mass + 1)})
        assert machine.balance(heavier, lengths, found.pose, found.states).force == pytest.approx(9.81)

    def test_two_lines_over_eyelets_share_a_load_by_their_angles(self) -> None:
        """Straight and stiff, 3 m out and 4 m down on either side, a third line slack: T = 0.5 load / 0.8."""
        exits = ((3, 0, 4), (-3, 0, 4), (0, 9, 0))
        cable = Cable(axial_stiffness=1e9, linear_density=0, breaking_load=1e6)
        lines = [_line(Eyelet(), name=str(i), exit_point=point, cable=cable) for i, point in enumerate(exits)]
        robot = Robot(
            name="two lines",
            scene=Scene(gravity=10, frame_min=(-9, -9, -9), frame_max=(9, 9, 9)),
            platform=PointPlatform(mass=16),
            lines=lines,
        )
        T = 100
        L = 5 / (1 + T / 1e9)
        states = [LineState(T, -math.atan2(4, 3), L), LineState(T, -math.atan2(4, 3), L), None]
        fits = machine.balance(robot, [L, L, 9.5], (0, 0, 0), states, "elastic")
        assert fits.geometry < 1e-14
        assert fits.force < 1e-12
        too_short = machine.balance(robot, [L, L, 8.9], (0, 0, 0), states, "elastic")
        assert too_short.geometry == pytest.approx(0.1)


class TestMujoco:
    @pytest.mark.parametrize("name", ["merlet2023", "paty2021", "wang2021"])
    def test_it_rests_where_massless_elastic_lines_balance(self, name: str) -> None:
        robot, pose = _with(load(name), arc_elastic=True), (0.4, -0.3, 1.0)
        states, lengths = machine.start(robot, pose, [200] * robot.m)
        lengths = [length - 1e-3 for length in lengths]
        found = machine.solve(robot, lengths, pose, states, "elastic")
        rest = mujoco_model.rest(robot, lengths, pose)
        assert machine.distance(found.pose, rest.pose) < 1e-11
        assert list(rest.tensions) == pytest.approx([float(state.tension) for state in found.states], rel=1e-8)

    @pytest.mark.parametrize("seed", range(8))
    def test_it_rests_there_for_robots_by_chance(self, seed: int) -> None:
        robot, lengths, pose = _by_chance(seed)
        rest = mujoco_model.rest(robot, lengths, pose)
        states, _ = machine.start(robot, rest.pose, np.maximum(rest.tensions, 1))
        states = [state if T > 0 else None for state, T in zip(states, rest.tensions, strict=True)]
        found = machine.solve(robot, lengths, rest.pose, states, "elastic")
        assert machine.distance(found.pose, rest.pose) < 1e-10
        assert found.balance.geometry < 1e-14

    def test_it_rejects_a_cable_that_does_not_stretch_on_its_sheave(self) -> None:
        robot = load("merlet2023")
        with pytest.raises(ValueError, match="stretches on its sheave too"):
            mujoco_model.xml(robot, [5] * 4)


def _by_chance(seed: int) -> tuple[Robot, list[float], tuple[float, ...]]:
    """Return a robot with 3 to 5 lines of all kinds, lengths a little too short for a pose, and that pose."""
    rng = np.random.default_rng(seed)
    m, joint, lines = int(rng.integers(3, 6)), tuple(rng.uniform(-0.3, 0.3, 3)), []
    for i in range(m):
        angle = 2 * np.pi * i / m + rng.uniform(-0.3, 0.3)
        A = np.array([6 * np.cos(angle), 6 * np.sin(angle), rng.uniform(5, 9)])
        wrap, r = str(rng.choice(["over", "under"])), float(rng.uniform(0.03, 0.3))
        down = -1 if wrap == "over" else 1
        weight = float(rng.uniform(0, 20))
        sheave = [
            Eyelet(),
            Swivel(radius=r, wrap=wrap),
            UniversalJoint(radius=r, lever=2 * r, lever_weight=weight, lever_mass_centre=1.2 * r, wrap=wrap),
        ][rng.integers(3)]
        aside = (1.0, -0.5) if isinstance(sheave, Eyelet) else (0.0, 0.0)
        winch = {"winch_exit": tuple(A + np.array([*aside, down * rng.uniform(2, 5)]))}
        if not isinstance(sheave, UniversalJoint) and rng.integers(2):
            winch = {"dead_length": float(rng.uniform(0, 3))}
        lines.append(
            _line(
                sheave,
                name=str(i),
                exit_point=tuple(A),
                platform_point=joint,
                arc_elastic=True,
                dead_elastic=isinstance(sheave, UniversalJoint) or bool(rng.integers(2)),
                cable=Cable(axial_stiffness=rng.uniform(1e4, 1e6), linear_density=0.01, breaking_load=1e5),
                **winch,
            )
        )
    scene = Scene(frame_min=(-9, -9, -9), frame_max=(9, 9, 9))
    robot = Robot(name="by chance", scene=scene, platform=PointPlatform(mass=50), lines=lines)
    pose = tuple(rng.uniform(-1, 1, 3))
    return robot, [length - rng.uniform(0, 4e-3) for length in machine.start(robot, pose, [200] * m)[1]], pose
