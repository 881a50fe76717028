"""Linear elasticity of one solid on second-order hexahedra: displacements, stresses, reactions and their error.

scikit-fem provides the basis, the quadrature and the numbering; element matrices are products of its gradients.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from cablewright.analyses.bracket.hexahedra import HexMesh, Index, levels
from cablewright.analyses.bracket.nested_dissection import dissected
from cablewright.foundation.arrays import Array
from cablewright.robot.bracket import Material

if TYPE_CHECKING:
    from skfem import Basis

Traction = Callable[[Array, Array], Array]

_CHUNK = 512  # elements assembled at a time; bounds memory
_THREADS = 2  # each holds the factorisation of its part
_SAME = 1e-9  # m; positions closer than this coincide
_NOTHING = 1e-14  # of the largest load: smaller parts are rounding
_VOIGT = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))


@dataclass(frozen=True, eq=False)
class Elastic:
    """A solid of one material, clamped at its *fixed* nodes.

    *mirrors*: (axis, position) of planes about which the solid and its supports are symmetric. Loads need not be: they
    are split into parts that are even or odd about each plane, and with two planes a part has a quarter of the
    unknowns.

    Displacements and loads are (3 N, k): x, y, z of node 0, of node 1 and so on, for each of k cases, m and N. Stresses
    are (6, ..., k): xx, yy, zz, yz, xz, xy, Pa.
    """

    solid: HexMesh
    material: Material
    fixed: Index
    mirrors: tuple[tuple[int, float], ...] = ()

    def stiffness(self, cells: Index, shares: Array) -> sp.csc_matrix:
        """Return the stiffness (3 N, 3 N), N/m, of *cells*, weighted by *shares*, without supports."""
        from skfem.models.elasticity import lame_parameters

        basis = self.solid.basis
        lam, mu = lame_parameters(self.material.young_modulus, self.material.poisson_ratio)
        weights = np.asarray(basis.dx)[cells] * shares[:, None]
        gradients = _gradients(basis, cells)  # (E, Q, 20, 3)
        dofs = (3 * _nodes(basis)[cells][:, :, None] + np.arange(3)).reshape(len(cells), -1)
        values = np.empty((len(cells), 60, 60))
        for first in range(0, len(cells), _CHUNK):
            some = slice(first, first + _CHUNK)
            g = gradients[some].reshape(-1, weights.shape[1], 60)
            moments = np.matmul((g * weights[some, :, None]).transpose(0, 2, 1), g).reshape(-1, 20, 3, 20, 3)
            trace = np.einsum("eaibi->eab", moments)
            matrix = lam * moments + mu * moments.transpose(0, 1, 4, 3, 2)
            matrix += mu * np.einsum("eab,ij->eaibj", trace, np.eye(3))
            values[some] = matrix.reshape(-1, 60, 60)
        rows, columns = np.repeat(dofs, 60, axis=1).ravel(), np.tile(dofs, (1, 60)).ravel()
        shape = (3 * basis.N, 3 * basis.N)
        return sp.csc_matrix(sp.coo_matrix((values.ravel(), (rows.astype(np.int32), columns.astype(np.int32))), shape))

    def solve(self, loads: Array) -> Array:
        """Return the displacements under *loads*. Two threads: SciPy's elimination uses one and releases the lock."""
        part = self.stiffness(*self._original())
        parities = list(product((1.0, -1.0), repeat=len(self.mirrors)))
        with ThreadPoolExecutor(max_workers=_THREADS) as threads:
            found = threads.map(lambda each: self._solve_part(part, loads, each), parities)
            return np.asarray(sum(found, np.zeros_like(loads)))

    def _solve_part(self, part: sp.csc_matrix, loads: Array, parities: tuple[float, ...]) -> Array:
        """The displacements by the parts of *loads* with these parities, one for each mirror."""
        images = self._images(parities)
        moved, pulled = np.zeros_like(loads), images.T @ loads
        some = np.flatnonzero(np.abs(pulled).max(axis=0, initial=0.0) > _NOTHING * np.abs(loads).max())
        if some.size:
            images = images[:, self._order(images)]
            inner = (2.0 ** len(self.mirrors) * (images.T @ part @ images)).tocsc()
            factor = splu(inner, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
            moved[:, some] = images @ factor.solve(images.T @ loads[:, some])
        return moved

    def _order(self, images: sp.csr_matrix) -> Index:
        """The elimination order of the unknowns of `_images`."""
        by_unknown = images.tocsc()
        nodes = by_unknown.indices[by_unknown.indptr[:-1]] // 3
        places = self.solid.nodes[:, nodes].copy()
        for axis, at in self.mirrors:
            places[axis] = np.abs(places[axis] - at)
        corner = nodes < self.solid.mesh.t.max() + 1
        return dissected(np.stack([levels(own) for own in places]), corner)

    def _original(self) -> tuple[Index, Array]:
        """The elements in front of all mirrors, and the share of each: half of one that a mirror cuts."""
        shares = np.ones(self.solid.cells.shape[1])
        for axis, at in self.mirrors:
            away = self.solid.cells[axis] - at
            shares *= np.where(np.abs(away) <= _SAME, 0.5, away > 0.0)
        cells = np.flatnonzero(shares)
        return cells, shares[cells]

    def _images(self, parities: tuple[float, ...]) -> sp.csr_matrix:
        """(3 N, u): all displacements per unknown in front of the mirrors, even (1) or odd (-1) about each."""
        places = self.solid.nodes[:, : self.solid.basis.N]
        folded, signs = places.copy(), np.ones((places.shape[1], 3))
        dead = np.zeros((places.shape[1], 3), dtype=bool)
        dead[self.fixed] = True
        for (axis, at), parity in zip(self.mirrors, parities, strict=True):
            behind, on = places[axis] < at - _SAME, np.abs(places[axis] - at) <= _SAME
            folded[axis, behind] = 2.0 * at - places[axis, behind]
            own = np.where(np.arange(3) == axis, -parity, parity)  # a mirror reverses the component across it
            signs[behind] *= own
            dead |= on[:, None] & (own < 0.0)
        keys = np.stack([levels(own) for own in folded])
        _, node = np.unique(keys, axis=1, return_inverse=True)
        used = np.unique((3 * node.reshape(-1, 1) + np.arange(3))[~dead])
        number = np.full(3 * (int(node.max()) + 1), -1)
        number[used] = np.arange(len(used))
        columns = number[(3 * node.reshape(-1, 1) + np.arange(3)).ravel()]
        rows = np.flatnonzero(~dead.ravel())
        return sp.csr_matrix((signs.ravel()[rows], (rows, columns[rows])), shape=(dead.size, len(used)))

    def traction(self, facets: Index, law: Traction) -> Array:
        """Return the load (3 N,) on *facets* of a traction *law* of positions and outward normals, (F, Q, 3), Pa."""
        from skfem.element import ElementHexS2

        # skfem.FacetBasis finds the quadrature points by Newton's method, which fails on bent elements.
        basis, load = self.solid.basis, np.zeros((self.solid.basis.N, 3))
        owners = np.asarray(self.solid.mesh.f2t)[0, facets]
        corners = np.asarray(self.solid.mesh.facets)[:, facets]
        own = np.asarray(self.solid.mesh.t)[:, owners]
        on = (own[:, None, :] == corners[None]).any(axis=1)  # (8, F) whether an element's corner is on the facet
        ends = np.asarray(ElementHexS2.doflocs[:8])
        for axis, end in product(range(3), (0.0, 1.0)):
            group = np.flatnonzero((on == (ends[:, axis] == end)[:, None]).all(axis=0))
            nodes = _nodes(basis)[owners[group]]
            at = self.solid.places.T[nodes]  # (F, 20, 3)
            values, slopes, weights = _on_face(axis, end)
            places = np.einsum("aq,fai->fqi", values, at)
            tangents = np.einsum("daq,fai->dfqi", slopes, at)
            normals = np.cross(tangents[0], tangents[1])
            areas = np.linalg.norm(normals, axis=-1)
            outward = np.sign((normals * (places - at[:, :8].mean(axis=1)[:, None])).sum(axis=-1))
            pull = law(places, normals * (outward / areas)[..., None]) * (areas * weights)[..., None]
            np.add.at(load, nodes.ravel(), np.einsum("aq,fqi->fai", values, pull).reshape(-1, 3))
        return load.ravel()

    def weight(self, density_force: Array) -> Array:
        """Return the load (3 N,) of a force per volume (3,), N/m^3."""
        basis = self.solid.basis
        load = np.zeros((basis.N, 3))
        for a, part in enumerate(basis.basis):
            share = (np.asarray(part[0]) * np.asarray(basis.dx)).sum(axis=-1)
            np.add.at(load, basis.element_dofs[a], share[:, None] * density_force)
        return load.ravel()

    def wrench(self, forces: Array) -> Array:
        """Return force and moment about the origin, (6, k), of nodal *forces* (3 N, k)."""
        at = self.solid.places.T[: self.solid.basis.N, :, None]
        each = forces.reshape(-1, 3, forces.shape[-1])
        return np.concatenate([each.sum(axis=0), np.cross(at, each, axis=1).sum(axis=0)])

    def reactions(self, loads: Array, moved: Array) -> Array:
        """Return the wrench (6, k) of the supports on the solid, N and N m about the origin."""
        held = np.zeros_like(loads)
        rows = (3 * self.fixed[:, None] + np.arange(3)).ravel()
        held[rows] = (self.inner_forces(moved) - loads)[rows]
        return self.wrench(held)

    def inner_forces(self, moved: Array) -> Array:
        """Return the nodal loads (3 N, k) in equilibrium with the stresses of given displacements."""
        basis = self.solid.basis
        stress = self.stress_in(basis, moved) * np.asarray(basis.dx)[:, :, None]
        whole = stress[[[0, 5, 4], [5, 1, 3], [4, 3, 2]]]  # (3, 3, E, Q, k)
        forces = np.einsum("eqai,ijeqk->eajk", _gradients(basis), whole, optimize=True)
        found = np.zeros((basis.N, 3, moved.shape[-1]))
        np.add.at(found, _nodes(basis).ravel(), forces.reshape(-1, *found.shape[1:]))
        return found.reshape(moved.shape)

    def stress_in(self, basis: Basis, moved: Array) -> Array:
        """Return stresses (6, E, Q, k) at the quadrature points of a *basis*, without recovery."""
        from skfem.models.elasticity import lame_parameters

        lam, mu = lame_parameters(self.material.young_modulus, self.material.poisson_ratio)
        at_nodes = moved.reshape(-1, 3, moved.shape[-1])[_nodes(basis)]  # (E, 20, 3, k)
        slopes = np.einsum("eqai,eajk->ijeqk", _gradients(basis), at_nodes, optimize=True)
        trace = lam * np.einsum("iieqk->eqk", slopes)
        return np.stack([mu * (slopes[i, j] + slopes[j, i]) + (trace if i == j else 0.0) for i, j in _VOIGT])

    def recovered(self, moved: Array, cells: Index | None = None) -> Array:
        """Return stresses (6, P, k) at the nodes: extrapolated from the 8 Gauss points of each element, and averaged.

        Stresses of second-order elements are most accurate at those points (Zienkiewicz, Zhu 1992). With *cells*, only
        these elements are averaged; nodes of none of them are 0.
        """
        from skfem import Basis
        from skfem.element import ElementHex2, ElementHexS2

        best = Basis(self.solid.mesh, ElementHexS2(), intorder=3)
        inner = self.stress_in(best, moved)
        outward = _trilinear(ElementHex2.doflocs) @ np.linalg.inv(_trilinear(np.asarray(best.X).T))  # (27, 8)
        at_nodes = np.einsum("aq,ceqk->ceak", outward, inner)
        nodes = _nodes(self.solid.points)
        if cells is not None:
            nodes, at_nodes = nodes[cells], at_nodes[:, cells]
        total = np.zeros((self.solid.points.N, 6, moved.shape[-1]))
        np.add.at(total, nodes.ravel(), at_nodes.transpose(1, 2, 0, 3).reshape(-1, *total.shape[1:]))
        shared = np.bincount(nodes.ravel(), minlength=len(total)).clip(min=1)
        return np.asarray((total / shared[:, None, None]).transpose(1, 0, 2))

    def energy_error(self, moved: Array, recovered: Array) -> Array:
        """Return (k,) Zienkiewicz and Zhu's estimate of the relative error in the energy norm."""
        basis = self.solid.points
        functions = np.stack([np.asarray(part[0])[0] for part in basis.basis])  # (27, Q): the same in each element
        smooth = np.einsum("aq,ceak->ceqk", functions, recovered[:, _nodes(basis)], optimize=True)
        missed = smooth - self.stress_in(self.solid.basis, moved)
        return np.asarray(np.sqrt(self._energy(missed) / self._energy(smooth)))

    def _energy(self, stress: Array) -> Array:
        """(k,) integral of stress times strain, J."""
        e, nu = self.material.young_modulus, self.material.poisson_ratio
        trace = stress[:3].sum(axis=0)
        squares = (stress[:3] ** 2).sum(axis=0) + 2.0 * (stress[3:] ** 2).sum(axis=0)
        strain = ((1.0 + nu) * squares - nu * trace**2) / e
        return np.asarray(np.einsum("eqk,eq->k", strain, np.asarray(self.solid.basis.dx)))


def _gradients(basis: Basis, cells: Index | None = None) -> Array:
    """Gradients of the 20 shape functions of each element, or of some *cells*, at its points: (E, Q, 20, 3)."""
    parts = (part[0].grad if cells is None else part[0].grad[:, cells] for part in basis.basis)
    return np.ascontiguousarray(np.stack(list(parts)).transpose(2, 3, 0, 1))


def _nodes(basis: Basis) -> Index:
    """(E, 20) nodes of each element, or (E, 27) with the middles of faces and elements."""
    return np.asarray(basis.element_dofs.T, dtype=np.int64)


def _on_face(axis: int, end: float) -> tuple[Array, Array, Array]:
    """Shape functions on a face of the reference cube: values (20, Q), slopes along it (2, 20, Q), weights (Q,)."""
    from skfem.element import ElementHexS2

    points, weights = np.polynomial.legendre.leggauss(3)
    u, v = (each.ravel() for each in np.meshgrid(0.5 + 0.5 * points, 0.5 + 0.5 * points, indexing="ij"))
    along = [k for k in range(3) if k != axis]
    at = np.full((3, len(u)), end)
    at[along[0]], at[along[1]] = u, v
    functions = [ElementHexS2().lbasis(at, a) for a in range(20)]
    values = np.stack([value for value, _ in functions])
    slopes = np.stack([np.broadcast_to(slope, at.shape)[along] for _, slope in functions], axis=1)
    return values, slopes, 0.25 * np.outer(weights, weights).ravel()


def _trilinear(points: Array) -> Array:
    """The eight products 1, x, y, z, xy, ... at *points* (p, 3): (p, 8)."""
    x, y, z = points.T
    return np.stack([np.ones_like(x), x, y, z, x * y, y * z, x * z, x * y * z], axis=1)


def von_mises(stress: Array) -> Array:
    """Return the equivalent stress (...) of stresses (6, ...), Pa."""
    xx, yy, zz, yz, xz, xy = stress
    spread = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.asarray(np.sqrt(0.5 * spread + 3.0 * (yz * yz + xz * xz + xy * xy)))
