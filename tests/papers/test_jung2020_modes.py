"""Jung 2020, section 4: lowest natural frequencies along the boundary of the closed form's workspace.

Without geometric stiffness, as its Eq. 16 has it: "around 1.2 Hz", 7 to 17 Hz with the beam's ends widened to 0.08 m, 8
to 21 Hz with 0.16 m. Geometry is its Table 3, lengths 1.2, 1.6 and 2.0 m, the boundary the outermost nodes of a grid;
the paper names neither grid nor lengths. What differs: its text calls the lowest mode a translation along z. It is a
rotation about z, and nearly all its softness is the missing geometric stiffness.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from cablewright.analyses.modes import FREEDOMS, Modes, modes
from cablewright.analyses.workspace.boundary_frequencies import boundary_modes
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.robot import Robot, load

MIDDLE, LEAST, MOST = 105.0, 10.0, 200.0  # N
LENGTHS = (1.2, 1.6, 2.0)  # m
PRINTED, EXACT = 0.925, 1 - 0.1 / math.sqrt(2)  # Table 3, and neighbouring exit points exactly 0.1 m apart


def beam(length: float, width: float, corner: float = PRINTED) -> Robot:
    """The robot at a length, its beam widened to *width* at the top along x and at the bottom along y, m.

    The inertia is that of the paper's Eq. 6 for this box.
    """
    robot = load("jung2020").retracted(length)
    lines = []
    for i, line in enumerate(robot.lines):
        x, y, z = line.platform_point
        wide = math.copysign(0.5 * width, x if i < 4 else y)
        exits = tuple(math.copysign(corner, a) if abs(a) == PRINTED else a for a in line.exit_point)
        point = (wide, y, z) if i < 4 else (x, wide, z)
        lines.append(line.model_copy(update={"platform_point": point, "exit_point": exits}))
    mass = robot.platform.mass
    across, along = mass / 12 * (width**2 + length**2), mass / 6 * width**2
    platform = robot.platform.model_copy(update={"inertia": (across, across, along)})
    return robot.model_copy(update={"lines": tuple(lines), "platform": platform})


def closed_form(robot: Robot, places: np.ndarray) -> np.ndarray:
    """Tensions (N, m) by Eq. 8: f = f_M - pinv(A^T) (w + A^T f_M)."""
    points = np.array([line.platform_point for line in robot.lines])
    away = np.array([line.exit_point for line in robot.lines]) - points - places[:, None]
    u = away / np.maximum(np.linalg.norm(away, axis=2, keepdims=True), 1e-12)
    structure = np.concatenate([u, np.cross(points, u)], axis=2).transpose(0, 2, 1)
    middle = np.full(robot.m, MIDDLE)
    wrench = np.array([0, 0, -robot.platform.mass * robot.scene.gravity, 0, 0, 0])
    return middle - np.einsum("nij,nj->ni", np.linalg.pinv(structure), wrench + structure @ middle)


def along(width: float, corner: float = PRINTED, grid: int = 21) -> tuple[list[Modes], list[Modes]]:
    """Modes along the boundary for each length, with geometric stiffness and without."""
    whole = []
    for length in LENGTHS:
        robot = beam(length, width, corner)
        found = boundary_modes(Model(robot, Fidelity(CableLaw.ELASTIC)), "closed-form", grid=grid)
        tensions = closed_form(robot, found.places)
        assert found.modes.equilibrium.ok.all()
        np.testing.assert_allclose(found.modes.equilibrium.tensions, tensions, atol=1e-9)  # as his Eq. 8 has them
        assert (tensions >= LEAST).all()
        assert (tensions <= MOST).all()
        whole.append(found.modes)
    return whole, [modes(found.equilibrium, geometric=False) for found in whole]


def lowest(found: list[Modes]) -> np.ndarray:
    return np.concatenate([each.lowest for each in found])


def shares(found: list[Modes]) -> dict[str, float]:
    """How often each freedom dominates the lowest mode."""
    of = np.concatenate([each.dominant[:, 0] for each in found])
    return {name: float((of == k).mean()) for k, name in enumerate(FREEDOMS)}


def assert_range(values: np.ndarray, least: float, most: float, within: float) -> None:
    assert values.min() == pytest.approx(least, abs=within)
    assert values.max() == pytest.approx(most, abs=within)


def test_the_slender_beam_turns_about_z_at_about_one_hertz() -> None:
    whole, elastic = along(0.04)
    assert_range(lowest(elastic), 1.10, 2.65, 0.05)
    assert np.median(lowest(elastic)) == pytest.approx(1.40, abs=0.05)  # the paper: "around 1.2 Hz"
    assert shares(elastic)["rz"] > 0.8
    assert shares(elastic)["z"] == 0  # the paper: "mostly ... the translational motion in the z-direction"
    assert_range(lowest(whole), 5.3, 13.1, 0.1)


def test_with_neighbouring_exit_points_exactly_a_tenth_of_a_metre_apart() -> None:
    """The paper's text and Table 3 differ by 6 mm, and by 6 % in this frequency: it is that near to singular."""
    whole, elastic = along(0.04, EXACT, grid=41)
    assert_range(lowest(elastic), 1.01, 2.49, 0.02)
    assert np.median(lowest(elastic)) == pytest.approx(1.28, abs=0.03)
    assert_range(lowest(whole), 5.17, 12.97, 0.1)


@pytest.mark.parametrize(
    ("width", "elastic", "whole"), [(0.08, (7.5, 17.9), (7.8, 19.5)), (0.16, (8.4, 21.4), (8.5, 21.4))]
)
def test_widened_ends_stiffen_it(width: float, elastic: tuple[float, float], whole: tuple[float, float]) -> None:
    """The paper: 7 to 17 Hz and 8 to 21 Hz."""
    with_geometric, without = along(width)
    assert_range(lowest(without), *elastic, 0.1)
    assert_range(lowest(with_geometric), *whole, 0.1)
