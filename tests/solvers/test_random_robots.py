"""Random robots of all sizes: each OK holds in extended precision, which itself is held to 50 digits."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from tools.long_double import Claims, judge
from tools.random_robots import PROMISED, Answer, Case, Tally, largest_margin, random_case

import cases
from cablewright.models.fidelity import CableLaw
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from oracles import machine

SEED = 1
COUNT = cases.often(500, 1500)
FORGED = {"states": "geometry", "lengths": "geometry", "tensions": "force", "load": "force"}


@pytest.fixture(scope="module")
def tally() -> Tally:
    found = Tally()
    found.run(random_case(SEED, number, 4) for number in range(COUNT))
    return found


def answers(asked: str, count: int) -> list[Answer]:
    """OK answers of robots from the same seed."""
    number, found = 1500, []
    while len(found) < count:
        case = random_case(SEED, number, 1)
        number += 1
        held = solve_inverse(case.model, case.poses[0])
        if not held.ok or (asked == "forward" and case.model.fidelity.cable is CableLaw.RIGID):
            continue
        found += [Answer(case, asked, held if asked == "inverse" else solve_forward(case.model, held.lengths))]
        found = [answer for answer in found if answer.found.ok]
    return found


def test_every_ok_holds(tally: Tally) -> None:
    assert not tally.failures


def test_there_are_oks_of_every_class(tally: Tally) -> None:
    for asked, least in (("inverse", 600), ("forward", 120)):
        assert sum(count for what, count in tally.classes.items() if what.startswith(asked)) > least
    for part in ("point held", "point hanging", "body held", "body hanging"):
        for law in CableLaw:
            assert any(f"inverse {part} {law.value}" in what for what in tally.classes)
    for kind in ("eyelet", "swivel", "universal-joint"):
        assert sum(count for what, count in tally.classes.items() if what.endswith(kind)) > 80
    assert tally.programs > 30


def test_sizes_and_moduli_are_of_all_decades() -> None:
    drawn = [random_case(SEED, number, 1) for number in range(300)]
    sizes = np.log10([case.size for case in drawn])
    moduli = np.log10([case.model.robot.lines[0].cable.stiffness for case in drawn])
    assert sizes.min() < -2.9
    assert sizes.max() > 2.9
    assert moduli.min() < 0.1
    assert moduli.max() > 8.9


@pytest.mark.parametrize("asked", ["inverse", "forward"])
def test_residuals_are_those_of_50_digits(asked: str) -> None:
    for answer in answers(asked, 40):
        row, robot = answer.found, answer.found.model.robot
        law = row.model.fidelity.cable.value
        forged = dataclasses.replace(row, lengths=row.lengths * (1 + 1e-7), pose=row.pose * (1 - 1e-8))
        for claim in (row, forged):
            states = [s if s.tension > 0.0 else None for s in cases.line_states(claim)]
            exact = machine.balance(robot, claim.lengths, claim.pose, states, law)
            found = judge(Claims.of([claim]))
            scale = max(claim.tensions.max(), robot.platform.mass * robot.scene.gravity)
            assert found.metres[0] == pytest.approx(exact.geometry, rel=1e-2, abs=1e-16 * answer.case.size)
            # the one is of components and over the largest force, the other is of vectors
            assert found.force[0] * scale <= 4 * (exact.force + exact.turning / arm(claim)) + 1e-17 * scale
            assert exact.force <= 4 * found.force[0] * scale + 1e-17 * scale


def arm(row) -> float:
    """The longest arm of a platform, m; 1 of a point's."""
    arms = row.platform_points - row.pose[:3]
    return max(float(np.linalg.norm(arms, axis=1).max()), 1e-300) if row.model.n == 6 else 1.0


@pytest.mark.parametrize("part", FORGED)
def test_a_forged_claim_is_rejected(part: str) -> None:
    for answer in answers("inverse", 5):
        claims = Claims.of([answer.found])
        forged = dataclasses.replace(claims, **{part: getattr(claims, part) * (1 + 1e-6)})
        assert getattr(judge(forged), FORGED[part])[0] > PROMISED[FORGED[part]]


def edge(number: int, seed: int = 0) -> Case:
    return random_case(seed, number, 4)


def test_tensions_of_next_to_nothing_are_not_slack() -> None:
    """A platform of 2 mg on massless lines that carry micronewtons."""
    held = solve_inverse(edge(74).model, edge(74).poses)
    assert (held.tensions[held.ok] > 0.0).all()
    assert held.tensions[held.ok].min() < 2e-6


def test_a_light_platform_on_short_stiff_lines_is_balanced() -> None:
    """This solve stopped at steps below a tenth of a nanometre, with two thirds of the weight unbalanced."""
    case = edge(2987)
    held = solve_inverse(case.model, case.poses)
    found = solve_forward(case.model, held.lengths[held.ok])
    weight = case.model.robot.platform.mass * case.model.robot.scene.gravity
    assert (found.unbalanced_force()[found.ok] < 1e-9 * weight).all()


def test_idle_lines_of_a_large_robot_meet_their_ends() -> None:
    """Lines of 1 km that carry a millionth of the largest tension were 0.1 micrometres off."""
    held = solve_inverse(edge(20980).model, edge(20980).poses)
    assert held.ok.any()
    assert (held.residual_norm()[held.ok] < 1e-11).all()


def test_a_tension_at_its_limit_has_the_margin_0() -> None:
    held = [solve_inverse(edge(number).model, edge(number).poses) for number in (2600, 2014, 1069, 359)]
    low, least = zip(*((each.extremes()[0][each.ok], each.lines.tension_min) for each in held), strict=True)
    assert any((a < b).any() for a, b in zip(low, least, strict=True))  # by rounding
    for each in held:
        assert (each.margin()[each.ok] >= 0.0).all()


def test_linear_programs_know_the_margin() -> None:
    case = next(c for c in map(edge, range(1000)) if c.kind == "point held rigid eyelet" and c.straight)
    held = solve_inverse(case.model, case.poses)
    for i in np.flatnonzero(held.ok):
        assert largest_margin(case, case.poses[i]) >= held.margin()[i] - 1e-9 * held.tensions[i].max()
