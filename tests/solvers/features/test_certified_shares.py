"""Share of poses that are certified with each feature, and adversarial poses against 50 digits.

``pytest -m slow -s tests/solvers/features/test_certified_shares.py`` prints the table of `docs/theory/certificates.md`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

import cases
import out_of_plane
import planar_robots
from cablewright.models.statics import Equilibrium, Model
from cablewright.solvers.certify import certify
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from solvers.features.test_certificates_everywhere import off
from solvers.test_certify import Exact, let_out, softened

ADVERSE = ("slack", "between")  # one line too long by 0 to 30 cm, and by 1e-6 to 1e-2 m


def softened_on(kind: str) -> list[Model]:
    return [softened(f"{name} on {kind}") for name in ("merlet2023", "paty2021", "cogiro")]


def unlike(kind: str) -> list[Model]:
    return [Model(out_of_plane.point(kind)), Model(out_of_plane.body(kind))]


def boards() -> list[Model]:
    shapes = [(plane, body) for plane in planar_robots.PLANES for body in (False, True)]
    return [Model(planar_robots.board(plane, body, force=(3.0, -2.0, 4.0))) for plane, body in shapes]


FEATURES = {
    "mounts": lambda: [*softened_on("mount"), *unlike("mounts")],
    "springs": lambda: [*softened_on("spring"), *softened_on("both")],
    "planes": boards,
    "guides": lambda: [*unlike("guides"), *unlike("wheels")],
    "tilted swivels": lambda: [*unlike("tilted"), *unlike("horizontal")],
}


@dataclass
class Tally:
    """How many poses were solved, how many of them are certified, and how many certificates are wrong."""

    solved: int = 0
    certified: int = 0
    wrong: int = 0

    def add(self, found: Equilibrium, exact: bool) -> None:
        """Count the solved rows of *found*; *exact*: compare those that are certified with 50 digits."""
        found = found[found.ok]
        proofs = certify(found)
        self.solved += len(found)
        self.certified += int(proofs.certified.sum())
        for i in np.flatnonzero(proofs.certified) if exact else ():
            upright = found.packed.general is None or found.model.robot.platform.plane is not None
            far = Exact(found[i]).polished() if upright else off(found[i])
            self.wrong += int((np.abs(far) > proofs.bound[i]).any())


def held_by(model: Model, count: int, seed: int) -> Equilibrium:
    """*count* poses within the tension limits, in the plane if there is one."""
    if model.robot.platform.plane is None:
        return cases.poses(model, count, seed)
    held = solve_inverse(model, planar_robots.places(model.robot, 2 * count, seed=seed))
    return held[held.ok][:count]


def tallies(feature: str, count: int, seed: int) -> tuple[Tally, Tally, int]:
    """Of *count* ordinary and of *count* adversarial poses, and how many wrong poses are certified."""
    models = FEATURES[feature]()
    ordinary, adverse, accepted = Tally(), Tally(), 0
    each = -(-count // len(models))
    for model in models:
        held, rng = held_by(model, each, seed), np.random.default_rng(seed)
        ordinary.add(held, False)
        moved = held.pose.copy()
        moved[np.arange(len(held)), rng.integers(0, 3, len(held))] += 10 ** rng.uniform(-8, -3, len(held))
        accepted += int(certify(replace(held, pose=moved), 1e-9).certified.sum())
        for k, kind in enumerate(ADVERSE):
            rows = held[k::2]
            adverse.add(solve_forward(model, let_out(rows, kind, rng), guess=rows.pose), True)
    return ordinary, adverse, accepted


def assert_true(feature: str, count: int, seed: int) -> None:
    ordinary, adverse, accepted = tallies(feature, count, seed)
    print(
        f"\n| {feature} | {ordinary.certified} of {ordinary.solved} | {adverse.certified} of {adverse.solved} "
        f"| {adverse.wrong} | {accepted} |"
    )
    assert ordinary.certified >= 0.95 * ordinary.solved
    assert ordinary.solved >= 0.95 * count
    assert adverse.certified > 0
    assert (adverse.wrong, accepted) == (0, 0)


@pytest.mark.slow
@pytest.mark.parametrize("feature", FEATURES)
def test_certificates_hold_in_hundreds_of_poses(feature: str) -> None:
    assert_true(feature, 300, 11)
