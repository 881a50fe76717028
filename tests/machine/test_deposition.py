"""Powder and beads on a height field: volume, symmetry, heaps of known shape."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.machine.simulated.deposition import Powder, extrude, pour
from cablewright.printing.heightfield import HeightField, rebuilt
from cablewright.printing.job import Bead
from cases import some

POWDER = Powder()
STEEP = np.tan(POWDER.repose)


def flat(cell: float = 0.01, half: float = 1.0) -> HeightField:
    return HeightField.flat((-half, -half), (half, half), cell)


def at(x: float, y: float) -> np.ndarray:
    return np.array([[x, y]])


def test_a_heap_is_a_cone_at_the_angle_of_repose() -> None:
    field, volume = flat(), 0.02
    pour(field, at(0.005, 0.005), at(0.005, 0.005), np.array([volume * POWDER.density]), POWDER)
    height = (3 * volume * STEEP**2 / np.pi) ** (1 / 3)
    assert field.heights.max() == pytest.approx(height, rel=1e-4)
    assert (field.heights > 0).sum() * field.cell**2 == pytest.approx(np.pi * (height / STEEP) ** 2, rel=5e-3)
    assert field.volume == pytest.approx(volume, rel=1e-13)


def test_a_ridge_is_a_triangle_whichever_way_it_runs() -> None:
    volume, length = 0.0128, 1.6
    height = np.roots([np.pi / (3 * STEEP**2), length / STEEP, 0.0, -volume])  # a prism and two half cones
    height = float(height[np.isreal(height) & (height.real > 0)].real[0])
    for angle in (0.0, 0.3, np.pi / 4):
        field, way = flat(), np.array([[np.cos(angle), np.sin(angle)]])
        pour(field, -0.5 * length * way, 0.5 * length * way, np.array([volume * POWDER.density]), POWDER)
        middle = field.at(np.zeros((1, 2)))[0]
        assert 0.0 <= height - middle <= 0.75 * field.cell * STEEP  # middles of cells lie beside the crest
        across = field.at(np.outer([0.05, 0.1], [-way[0, 1], way[0, 0]]))
        np.testing.assert_allclose(middle - across, [0.05 * STEEP, 0.1 * STEEP], atol=2 * field.cell * STEEP)


def test_the_papers_bead_is_steeper_than_its_powder() -> None:
    assert np.rad2deg(np.arctan(0.09 / 0.11)) == pytest.approx(39, abs=0.5)  # 9 cm high, 22 cm wide
    assert pytest.approx(2.5, abs=0.03) == 1 / STEEP  # half the width, in heights


@pytest.mark.parametrize("seed", some(range(3)))
def test_volume_is_kept_and_nothing_is_steeper_than_the_repose(seed: int) -> None:
    rng, field = np.random.default_rng(seed), flat(0.02)
    start, end = rng.uniform(-0.6, 0.6, (2, 60, 2))
    end = start + 0.1 * (end - start)
    masses = rng.uniform(0.0, 2.0, 60)
    for k in range(60):
        before = field.heights.copy()
        pour(field, start[k : k + 1], end[k : k + 1], masses[k : k + 1], POWDER)
        assert (field.heights >= before).all()
    assert field.volume * POWDER.density == pytest.approx(masses.sum(), rel=1e-12)
    for axis in (0, 1):
        assert np.abs(np.diff(field.heights, axis=axis)).max() <= field.cell * STEEP * (1 + 1e-9)
    diagonal = np.abs(field.heights[1:, 1:] - field.heights[:-1, :-1]).max()
    assert diagonal <= np.sqrt(2) * field.cell * STEEP * (1 + 1e-9)


def test_powder_runs_into_a_ditch_first() -> None:
    field = flat(0.02)
    field.heights[:, 50:] = 0.1  # a step
    pour(field, at(0.0, -0.05), at(0.0, -0.05), np.array([1.0]), POWDER)
    assert (field.heights[:, 50:] == 0.1).all()
    assert field.heights[:, :50].max() < 0.1


def test_a_mirrored_path_gives_a_mirrored_heap() -> None:
    rng = np.random.default_rng(5)
    start, end = rng.uniform(-0.5, 0.5, (2, 20, 2))
    one, other = flat(0.02), flat(0.02)
    pour(one, start, end, np.full(20, 1.0), POWDER)
    pour(other, start * [-1, 1], end * [-1, 1], np.full(20, 1.0), POWDER)
    np.testing.assert_allclose(one.heights, other.heights[::-1], atol=1e-12)


def test_a_heap_against_the_edge_of_the_field_stays_in_it() -> None:
    field = HeightField.flat((0.0, 0.0), (0.5, 0.5), 0.01)
    pour(field, at(0.01, 0.01), at(0.01, 0.01), np.array([60.0]), POWDER)
    assert field.volume == pytest.approx(60.0 / POWDER.density, rel=1e-12)


def test_a_bead_is_as_high_and_wide_as_its_section_says() -> None:
    field, bead = flat(0.01), Bead(width=0.1, height=0.02)
    extrude(field, at(-0.5, 0.0), at(0.5, 0.0), np.array([bead.section]), bead.width)  # 1 m
    section = 0.1 * 0.02 - (1 - np.pi / 4) * 0.02**2
    assert field.volume == pytest.approx(section, rel=1e-12)
    laid = field.heights[field.heights > 0]
    assert np.ptp(laid) < 1e-12  # pressed flat
    assert laid[0] == pytest.approx(section / (0.1 + np.pi / 4 * 0.1**2), rel=0.03)  # its ends are round


def test_a_bead_fills_the_groove_between_its_neighbours() -> None:
    field, bead = flat(0.01), Bead(width=0.1, height=0.02)
    y = np.array([-0.1, 0.1, 0.0])
    start, end = np.stack([np.full(3, -0.5), y], axis=1), np.stack([np.full(3, 0.5), y], axis=1)
    extrude(field, start, end, np.full(3, bead.section), bead.width)  # 1 m each
    middle = field.heights[60:140, 85:115]
    assert middle.min() > 0.0
    assert middle.max() <= 0.03


@pytest.mark.parametrize("axis", [0, 1])
def test_what_leaves_the_field_is_rejected_and_changes_nothing(axis: int) -> None:
    field = flat()
    end = at(0.0, 0.0)
    end[0, axis] = 1.2
    with pytest.raises(InputError, match=r"piece 0 of the path leaves the field at"):
        pour(field, at(0.0, 0.0), end, np.array([1.0]), POWDER)
    with pytest.raises(InputError, match=r"piece 1 of the path has -"):
        pour(field, np.zeros((2, 2)), np.zeros((2, 2)), np.array([1.0, -1.0]), POWDER)
    assert not field.heights.any()


def test_heights_between_cells_are_linear() -> None:
    field = flat(0.1)
    field.heights[:] = field.centres(0)[:, None] * 0.2 - field.centres(1) * 0.1 + 1.0
    places = np.random.default_rng(0).uniform(-0.94, 0.94, (100, 2))
    np.testing.assert_allclose(field.at(places), places @ [0.2, -0.1] + 1.0, atol=1e-12)
    assert np.isnan(field.at(at(1.1, 0.0))[0])


def test_a_solid_is_closed_and_holds_the_volume() -> None:
    field = flat(0.05)
    field.heights[:] = 0.1 + 0.05 * np.random.default_rng(2).random(field.shape)
    mesh = field.solid()
    assert mesh.is_closed
    assert mesh.volume == pytest.approx(field.heights.mean() * 1.95**2, rel=5e-3)  # above 0: outside out


def test_scans_give_the_field_back() -> None:
    field = flat(0.05)
    pour(field, at(0.0, 0.0), at(0.3, 0.2), np.array([40.0]), POWDER)
    rng = np.random.default_rng(3)
    places = rng.uniform(-1.0, 1.0, (40_000, 2))
    z = field.at(places) + 0.002 * rng.standard_normal(len(places))
    z[::50] += 0.5  # what else a lidar sees
    found = rebuilt(np.column_stack([places, z]), field)
    assert np.isfinite(found.heights).mean() > 0.99
    off = (found.heights - field.heights)[np.isfinite(found.heights)]
    assert np.sqrt((off**2).mean()) < 0.003
    assert np.isnan(rebuilt(np.zeros((0, 3)), field).heights).all()


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (lambda: HeightField.flat((0, 0), (0, 1), 0.1), "m is empty"),
        (lambda: HeightField.flat((0, 0), (1, 1), 0.0), "cell = 0"),
        (lambda: HeightField.flat((0, 0), (1e3, 1e3), 1e-3), "give a larger cell"),
        (lambda: Powder(density=0.0), "density = 0"),
        (lambda: Powder(repose=2.0), "repose = 2"),
    ],
)
def test_bad_input_is_one_line(made: object, words: str) -> None:
    with pytest.raises(InputError, match=words):
        made()  # type: ignore[operator]
