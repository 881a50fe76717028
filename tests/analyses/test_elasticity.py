"""Finite elements against known solutions: uniform strain, bending, a cantilever and its rate, scikit-fem, CalculiX."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
import scipy.sparse.linalg as sla
import skfem
from skfem.models.elasticity import lame_parameters, linear_elasticity

from cablewright.analyses.bracket.elasticity import Elastic, von_mises
from cablewright.analyses.bracket.hexahedra import Bore, HexMesh, build, ticks
from cablewright.analyses.bracket.nested_dissection import dissected
from cablewright.robot.bracket import Material
from oracles import calculix

STEEL = Material(young_modulus=2e11, poisson_ratio=0.3, yield_strength=4e8)
CORK = STEEL.model_copy(update={"poisson_ratio": 0.0})
NOTHING = np.empty(0, dtype=np.int64)
SEED = 3


def box(x: float, y: float, z: float, parts: tuple[int, int, int]) -> HexMesh:
    planes = [np.linspace(0.0, side, count + 1) for side, count in zip((x, y, z), parts, strict=True)]
    return build(planes, lambda p: np.ones(p.shape[1], dtype=bool), [])


def drilled() -> HexMesh:
    """A block with a round bore: its elements are neither boxes nor straight."""
    bore = Bore(2, (0.0, 0.0), 0.016, 0.03)
    sides = ticks([-0.03, 0.035, *bore.marks(0)], 0.02, 1)
    return build([sides, sides, ticks([0.0, 0.05], 0.03, 1)], lambda p: np.ones(p.shape[1], dtype=bool), [bore])


def all_of(solid: HexMesh) -> tuple[np.ndarray, np.ndarray]:
    count = solid.cells.shape[1]
    return np.arange(count), np.ones(count)


def at_nodes(solid: HexMesh) -> np.ndarray:
    return solid.places[:, : solid.basis.N]


def test_a_bore_is_round_and_nothing_is_lost() -> None:
    solid = drilled()
    assert solid.basis.dx.sum() == pytest.approx((0.065**2 - np.pi * 0.016**2) * 0.05, rel=2e-4)
    assert (solid.basis.dx > 0).all()


def test_patch_a_uniform_strain_is_uniform_stress_everywhere() -> None:
    solid = drilled()
    gradient = 1e-3 * np.random.default_rng(SEED).normal(size=(3, 3))
    elastic = Elastic(solid, STEEL, NOTHING)
    moved = (gradient @ at_nodes(solid)).T.reshape(-1, 1)
    lam, mu = lame_parameters(2e11, 0.3)
    strain = 0.5 * (gradient + gradient.T)
    stress = lam * np.trace(strain) * np.eye(3) + 2.0 * mu * strain
    told = stress[[0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]]
    recovered = elastic.recovered(moved)[..., 0]
    np.testing.assert_allclose(recovered, np.broadcast_to(told[:, None], recovered.shape), rtol=1e-10, atol=1e-2)
    inner = elastic.inner_forces(moved).reshape(-1, 3)
    outside = np.unique(np.concatenate([solid.basis.get_dofs().flatten()]))
    inside = np.setdiff1d(np.arange(solid.basis.N), outside)
    assert len(inside)
    assert np.abs(inner[inside]).max() < 1e-9 * np.abs(inner).max()
    assert elastic.energy_error(moved, elastic.recovered(moved))[0] < 1e-10


def test_tractions_of_a_uniform_stress_balance_it_round_bores_too() -> None:
    solid = drilled()
    elastic = Elastic(solid, CORK, NOTHING)
    moved = np.zeros((solid.basis.N, 3))
    moved[:, 0] = 1e-3 * at_nodes(solid)[0]
    pull = elastic.traction(solid.mesh.boundary_facets(), lambda _, n: 2e8 * n * np.array([1.0, 0.0, 0.0]))
    missed = elastic.inner_forces(moved.reshape(-1, 1))[:, 0] - pull
    assert np.abs(missed).max() < 1e-9 * np.abs(pull).max()


def test_element_matrices_are_those_of_scikit_fem() -> None:
    solid = drilled()
    basis = skfem.Basis(solid.mesh, skfem.ElementVector(skfem.element.ElementHexS2()), intorder=4)
    theirs = linear_elasticity(*lame_parameters(2e11, 0.3)).assemble(basis)
    ours = Elastic(solid, STEEL, NOTHING).stiffness(*all_of(solid))
    same = skfem.Basis(solid.mesh, skfem.element.ElementHexS2(), intorder=4)
    order = np.empty(basis.N, dtype=np.int64)  # theirs by node and component
    order[(3 * same.element_dofs[:, None, :] + np.arange(3)[:, None]).reshape(60, -1)] = basis.element_dofs
    difference = ours - theirs[order][:, order]
    assert np.abs(difference.data).max() < 1e-12 * np.abs(ours.data).max()


def cantilever(solid: HexMesh, length: float, depth: float, force: float) -> np.ndarray:
    """Timoshenko and Goodier's cantilever of unit width without Poisson effect: displacements (N, 3) of the nodes.

    With y from the middle of the depth 2 c: stress xx = P (L - x) y / I, xy = -P (c^2 - y^2) / 2 I.
    """
    x, y, _ = at_nodes(solid)
    y, c = y - 0.5 * depth, 0.5 * depth
    stretch, shear = force / (CORK.young_modulus * 2.0 / 3.0 * c**3), 0.5 * CORK.young_modulus
    u = stretch * (length * x - 0.5 * x**2) * y + stretch * CORK.young_modulus * y**3 / (6.0 * shear)
    v = -stretch * (0.5 * length * x**2 - x**3 / 6.0) - stretch * CORK.young_modulus * c**2 * x / (2.0 * shear)
    return np.stack([u, v, np.zeros_like(u)], axis=1)


def test_a_cantilever_converges_to_its_exact_stress_at_the_second_order() -> None:
    """Displacements given on the boundary: the stress is right to the square of the elements' size."""
    errors = []
    for times in (1, 2):
        solid = box(0.2, 0.05, 0.02, (4 * times, 2 * times, 2 * times))
        exact = cantilever(solid, 0.2, 0.05, 1e4)
        elastic = Elastic(solid, CORK, NOTHING)
        matrix = elastic.stiffness(*all_of(solid))
        given = np.unique(solid.basis.get_dofs().flatten())
        held = (3 * given[:, None] + np.arange(3)).ravel()
        free = np.setdiff1d(np.arange(3 * solid.basis.N), held)
        moved = exact.ravel().copy()
        moved[free] = 0.0
        moved[free] = sla.spsolve(matrix[free][:, free], -(matrix @ moved)[free])
        stress = elastic.stress_in(solid.basis, moved[:, None])[..., 0]
        x, y, _ = np.asarray(solid.basis.global_coordinates())
        inertia, y = 2.0 / 3.0 * 0.025**3, y - 0.025
        missed = (stress[0] - 1e4 * (0.2 - x) * y / inertia) ** 2
        missed += (stress[5] + 1e4 * (0.025**2 - y**2) / (2.0 * inertia)) ** 2
        errors.append(np.sqrt((missed * solid.basis.dx).sum()))
    assert errors[1] == pytest.approx(errors[0] / 4.0, rel=0.15)


def test_a_slender_cantilever_bends_as_a_beam() -> None:
    length, side, force = 1.0, 0.05, 100.0
    solid = box(length, side, side, (20, 2, 2))
    fixed = np.flatnonzero(at_nodes(solid)[0] < 1e-9)
    elastic = Elastic(solid, CORK, fixed, ((1, 0.5 * side), (2, 0.5 * side)))
    end = solid.boundary(lambda p: p[0] > length - 1e-9)
    load = elastic.traction(end, lambda at, _: np.broadcast_to([0.0, force / side**2, 0.0], at.shape))[:, None]
    moved = elastic.solve(load)
    inertia, young = side**4 / 12.0, CORK.young_modulus
    told = force * length**3 / (3.0 * young * inertia) + 1.2 * force * length / (0.5 * young * side**2)
    work = float(load[:, 0] @ moved[:, 0]) / force
    assert work == pytest.approx(told, rel=2e-3)
    assert elastic.reactions(load, moved)[:, 0] == pytest.approx(
        -np.array([0, force, 0, -force * side / 2, 0, force * length]), abs=1e-7
    )


def test_mirrors_change_nothing() -> None:
    solid = box(0.2, 0.06, 0.03, (4, 3, 2))  # a mirror through elements, and one between
    fixed = np.flatnonzero(at_nodes(solid)[0] < 1e-9)
    loads = np.random.default_rng(SEED).normal(size=(3 * solid.basis.N, 2))
    plain = Elastic(solid, STEEL, fixed).solve(loads)
    for mirrors in (((1, 0.03),), ((1, 0.03), (2, 0.015))):
        folded = Elastic(solid, STEEL, fixed, mirrors).solve(loads)
        np.testing.assert_allclose(folded, plain, atol=1e-9 * np.abs(plain).max())


def test_dissection_is_an_order() -> None:
    places = np.stack(np.meshgrid(*[np.arange(9)] * 3)).reshape(3, -1)
    order = dissected(places, (places % 2 == 0).all(axis=0))
    assert sorted(order) == list(range(9**3))


def test_von_mises_of_tension_shear_and_pressure() -> None:
    stress = np.array([[5.0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 2.0], [3.0, 3.0, 3.0, 0, 0, 0]]).T
    assert von_mises(stress) == pytest.approx([5.0, 2.0 * np.sqrt(3.0), 0.0])


def loaded() -> tuple[Elastic, np.ndarray]:
    solid = drilled()
    fixed = np.flatnonzero(at_nodes(solid)[2] < 1e-9)
    elastic = Elastic(solid, STEEL, fixed)
    top = solid.boundary(lambda p: p[2] > 0.05 - 1e-9)
    return elastic, elastic.traction(top, lambda at, _: np.broadcast_to([1e6, 2e6, -3e6], at.shape))


def test_the_deck_for_calculix_holds_the_mesh() -> None:
    elastic, load = loaded()
    text = calculix.deck(elastic, load)
    assert text.count("\n") > elastic.solid.basis.N + 2 * elastic.solid.cells.shape[1]
    members = elastic.solid.basis.element_dofs[calculix.CORNERS_THEN_EDGES].T
    at = elastic.solid.basis.doflocs.T[members]  # right-handed, middles of edges between their ends
    edges = at[:, [1, 3, 4]] - at[:, :1]
    assert (np.linalg.det(edges) > 0).all()
    straight = 0.5 * (at[:, 0] + at[:, 4])
    np.testing.assert_allclose(at[:, 16], straight, atol=1e-12)


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")
def test_calculix_finds_the_same(tmp_path) -> None:
    elastic, load = loaded()
    ours = elastic.solve(load[:, None])[:, 0]
    theirs = calculix.displacements(elastic, load, tmp_path)
    assert np.abs(ours - theirs).max() < 1e-5 * np.abs(theirs).max()  # ccx prints 7 digits
