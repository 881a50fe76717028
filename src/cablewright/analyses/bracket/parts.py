"""The parts of a bracket as solids: mesh, supports, loads, and the regions where stress is evaluated.

A part is solved for a few unit load cases; any load is their sum. Stress is evaluated plate by plate: at each position
of a plate, the stress through the thickness is linearised, that is reduced to its membrane and bending parts. Next to a
sharp inner edge, a clamped edge or a contact the peak stress diverges under refinement, the linearised stress does not.
Nothing is evaluated within half a thickness of such edges.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from cablewright.analyses.bracket.elasticity import Elastic, von_mises
from cablewright.analyses.bracket.hexahedra import Bore, HexMesh, Index, build, levels, ticks
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.robot.bracket import Bracket

BASE_CASES = ("fx", "fy", "fz", "mx", "my")
"""Loads of the joint on the base: force and moment at the joint, N and N m. The spindle rotates freely about z."""

LEVER_CASES = ("along", "across", "weight along", "weight across")
"""Loads of a cheek: force of the axle along the lever and across it, and its own weight along these, N."""

_COARSEST = 12  # smallest number of elements along the longest side
_AT_ONCE = 200_000  # stresses evaluated at a time; bounds memory
_SLACK = 1e-9  # m; tolerance of comparisons between positions


@dataclass(frozen=True, eq=False)
class Plate:
    """Nodes and cells of a plate at which stress is evaluated: columns of nodes (C, L) through its thickness (m).

    Stress is recovered from these cells alone, so that its singularities elsewhere have no influence.
    """

    name: str
    columns: Index
    cells: Index
    thickness: float

    def linearised(self, stress: Array) -> Array:
        """Return the membrane minus and plus the bending part of *stress* (6, P, k), at both faces: (6, C, 2, k)."""
        layers = self.columns.shape[1]
        weights = np.ones(layers)
        weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
        weights /= weights.sum()  # Simpson's rule: exact for a quadratic stress, also times the position
        place = np.linspace(-1.0, 1.0, layers)
        inside = stress[:, self.columns]
        membrane = np.einsum("l,sclk->sck", weights, inside)
        bending = 3.0 * np.einsum("l,sclk->sck", weights * place, inside)
        return np.stack([membrane - bending, membrane + bending], axis=2)


@dataclass(frozen=True, eq=False)
class BracketPart:
    """A solid with unit load *cases* (3 N, k), and its plates where stress is evaluated."""

    name: str
    elastic: Elastic
    cases: Array
    plates: tuple[Plate, ...]

    @cached_property
    def moved(self) -> Array:
        """Displacements (3 N, k) of the unit cases, m/N and m/(N m)."""
        return self.elastic.solve(self.cases)

    @cached_property
    def stress(self) -> Array:
        """Recovered stresses (6, P, k) of the unit cases."""
        return self.elastic.recovered(self.moved)

    @cached_property
    def compliance(self) -> Array:
        """Compliance (k, k) of the unit cases: the displacement by one at the point of application of another."""
        return np.asarray(self.cases.T @ self.moved)

    @cached_property
    def faces(self) -> tuple[Array, ...]:
        """The linearised stresses (6, C, 2, k) of each plate."""
        found = (self.elastic.recovered(self.moved, plate.cells) for plate in self.plates)
        return tuple(plate.linearised(stress) for plate, stress in zip(self.plates, found, strict=True))

    def peaks(self, loads: Array, only: tuple[Index, ...] | None = None) -> Array:
        """Return the largest linearised von Mises stress, Pa, of each plate under *loads* (M, k): (plates, M).

        *only*: the positions of each plate that are evaluated, from `hot`.
        """
        found = np.empty((len(self.plates), len(loads)))
        for k, (own, faces) in enumerate(zip(found, self.faces, strict=True)):
            flat = faces.reshape(6, -1, faces.shape[-1])
            looked = flat if only is None else flat[:, only[k]]
            step = max(1, _AT_ONCE // looked.shape[1])
            for first in range(0, len(loads), step):
                some = slice(first, first + step)
                own[some] = von_mises(looked @ loads[some].T).max(axis=0)
        return found

    def hot(self, loads: Array) -> tuple[Index, ...]:
        """Return the positions on each plate where the stress is largest under any of *loads* (M, k)."""
        flats = (faces.reshape(6, -1, faces.shape[-1]) for faces in self.faces)
        return tuple(np.unique([int(von_mises(flat @ load).argmax()) for load in loads]) for flat in flats)

    def peak_place(self, plate: int, load: Array) -> Array:
        """Return the position (3,) of the plate's largest linearised stress under one load (k,), m, part's frame."""
        over = von_mises(self.faces[plate] @ load)
        column, face = np.unravel_index(int(over.argmax()), over.shape)
        node = self.plates[plate].columns[column, -1 if face else 0]
        return np.asarray(self.elastic.solid.places[:, node])


def base_solid(bracket: Bracket, times: int) -> HexMesh:
    """Return the mesh of baseplate, uprights and block, in the bracket's frame."""
    plate, uprights, bearing = bracket.baseplate, bracket.uprights, bracket.bearing
    inner, t, rise = 0.5 * uprights.gap, uprights.thickness, bracket.rise
    edge = 0.5 * plate.thickness
    bore = Bore(2, (0.0, 0.0), 0.5 * bearing.bore, inner)
    tall, root = 0.5 * uprights.height, -bracket.standoff
    x = [root - plate.thickness, root, root + 0.5 * t, -inner - 0.5 * t]
    y = [0.5 * plate.width, inner - edge, inner, inner + t, inner + t + edge]
    y += _pad(plate.bolts[0], plate.clamped, edge)
    z = [0.5 * plate.height, tall - bearing.width, tall, tall + edge, *_pad(plate.bolts[1], plate.clamped, edge)]
    finer_x = [root - edge, *(root + share * t for share in (0.25, 0.75, 1.0, 2.0))]  # where stress is highest
    finer_y = _both([inner - 2.0 * edge, inner + 0.5 * t, inner + t + 2.0 * edge], 0.5 * plate.width)
    finer_z = _both([tall - t, tall - 0.5 * t, tall - 0.25 * t, tall + 2.0 * edge], 0.5 * plate.height)
    size = max(2.0 * plate.thickness, max(plate.height, plate.width, bracket.standoff + inner) / _COARSEST)
    planes = (
        ticks([*x, *bore.marks(0)], size, times, finer_x),
        ticks([*_both(y, 0.5 * plate.width), *bore.marks(1)], size, times, finer_y),
        ticks([rise + each for each in _both(z, 0.5 * plate.height)], size, times, [rise + each for each in finer_z]),
    )

    def kept(p: Array) -> Mask:
        arm = (p[0] > -bracket.standoff) & (np.abs(p[2] - rise) < tall) & (np.abs(p[1]) < inner + t)
        hollow = (p[0] < -inner) & (np.abs(p[1]) < inner)  # between the uprights, behind the block
        return np.asarray((p[0] < -bracket.standoff) | (arm & ~hollow))

    return build(planes, kept, [bore])


@lru_cache(maxsize=8)
def base(bracket: Bracket, times: int) -> BracketPart:
    """Return the base of a bracket: bolted to the pillar, loaded by two bearings and the block's thrust face.

    The pressure of a bearing varies as the cosine around its whole ring, as for a ring pressed in. The thrust is
    uniform over the block's upper face.
    """
    solid = base_solid(bracket, times)
    fixed = np.flatnonzero(_clamped(bracket, solid.nodes[:, : solid.basis.N]))
    elastic = Elastic(solid, bracket.material, fixed, ((1, 0.0), (2, bracket.rise)))
    inner, tall, rise = 0.5 * bracket.uprights.gap, 0.5 * bracket.uprights.height, bracket.rise
    width, reach = bracket.bearing.width, 0.5 * bracket.bearing.bore

    def ring(low: float, high: float) -> Index:
        def chosen(p: Array) -> Mask:
            within = (np.maximum(np.abs(p[0]), np.abs(p[1])) < reach) & (p[2] > low) & (p[2] < high)
            level = (np.abs(p[2] - rise) > tall - _SLACK) | (np.abs(p[2] - low) < _SLACK)
            return np.asarray(within & ~level)

        return solid.boundary(chosen)

    rings = [ring(rise + tall - width, rise + tall), ring(rise - tall, rise - tall + width)]
    top = solid.boundary(
        lambda p: (p[2] > rise + tall - _SLACK) & (np.maximum(np.abs(p[0]), np.abs(p[1])) < inner) & (p[0] > -inner)
    )
    pushes = [_push(elastic, facets, axis) for facets in rings for axis in (0, 1)]
    thrust = elastic.traction(top, lambda places, _: np.broadcast_to([0.0, 0.0, 1.0], places.shape))
    heights = rise + tall - 0.5 * width, rise - tall + 0.5 * width
    shares = _bearing_shares(*heights)
    cases = np.column_stack([*pushes, thrust / thrust.sum()]) @ shares
    return BracketPart("base", elastic, cases, (_baseplate(bracket, solid), _uprights(bracket, solid)))


def _bearing_shares(upper: float, lower: float) -> Array:
    """(5, 5) shares of the bearings, whose middles are at these heights, and the thrust face in `BASE_CASES`.

    Rows: upper x, upper y, lower x, lower y, thrust.
    """
    apart = upper - lower
    shares = np.zeros((5, 5))
    shares[0, 0], shares[0, 4] = -lower / apart, 1.0 / apart
    shares[1, 1], shares[1, 3] = -lower / apart, -1.0 / apart
    shares[2], shares[3] = -shares[0], -shares[1]
    shares[2, 0] += 1.0
    shares[3, 1] += 1.0
    shares[4, 2] = 1.0
    return shares


def _baseplate(bracket: Bracket, solid: HexMesh) -> Plate:
    """The baseplate without the uprights' feet and the clamped squares, and half a thickness around both."""
    plate, uprights = bracket.baseplate, bracket.uprights
    edge, front = 0.5 * plate.thickness, -bracket.standoff
    middle, half = 0.5 * (uprights.gap + uprights.thickness), 0.5 * plate.clamped + edge

    def judged(p: Array, slack: float) -> Mask:
        y, z = np.abs(p[1]), np.abs(p[2] - bracket.rise)
        foot = np.abs(y - middle) < 0.5 * uprights.thickness + edge - slack
        foot &= z < 0.5 * uprights.height + edge - slack
        pad = np.maximum(np.abs(y - 0.5 * plate.bolts[0]), np.abs(z - 0.5 * plate.bolts[1])) < half - slack
        return np.asarray((p[0] < front + slack) & ~foot & ~pad)

    return _plate("baseplate", solid, judged, 0, plate.thickness)


def _uprights(bracket: Bracket, solid: HexMesh) -> Plate:
    """Both uprights between baseplate and block, without half a thickness at either end."""
    t, inner = bracket.uprights.thickness, 0.5 * bracket.uprights.gap

    def judged(p: Array, slack: float) -> Mask:
        between = (p[0] > -bracket.standoff + 0.5 * t - slack) & (p[0] < -inner - 0.5 * t + slack)
        return np.asarray(between & (np.abs(p[1]) > inner - slack))

    return _plate("uprights", solid, judged, 1, t)


@lru_cache(maxsize=16)
def cheek(bracket: Bracket, lever: float, times: int) -> BracketPart:
    """Return one cheek of a lever of this length (m), held by its pin and loaded by its axle and its own weight.

    Its frame: origin on the pin's axis, x along the lever to the axle, y along the pin, z across.
    """
    sizes = bracket.lever
    t, half = sizes.thickness, 0.5 * sizes.width
    bores = []
    for bore, at in ((sizes.pin, 0.0), (sizes.axle, lever)):
        radius = 0.5 * bore
        bores.append(Bore(1, (at, 0.0), radius, min(radius + 0.5 * t, 0.5 * (radius + half))))
    if bores[0].room + bores[1].room >= lever:
        raise InputError(
            f"bracket.lever: pin and axle overlap on a lever of {lever:g} m; make them thinner or the lever longer"
        )
    size = max(2.0 * t, (lever + sizes.width) / _COARSEST)
    planes = (
        ticks([-half, lever + half, *bores[0].marks(0), *bores[1].marks(0)], size, 2 * times),
        ticks([-0.5 * t, 0.5 * t], size, times),
        ticks([-half, half, *bores[0].marks(1), *bores[1].marks(1)], size, 2 * times),
    )
    solid = build(planes, lambda p: np.ones(p.shape[1], dtype=bool), bores)

    def near(p: Array, bore: Bore) -> Array:
        return np.asarray(np.maximum(np.abs(p[0] - bore.centre[0]), np.abs(p[2])))

    held = np.flatnonzero(near(solid.nodes[:, : solid.basis.N], bores[0]) < bores[0].half + _SLACK)
    elastic = Elastic(solid, bracket.material, held, ((1, 0.0), (2, 0.0)))
    wall = solid.boundary(lambda p: (near(p, bores[1]) < bores[1].half + _SLACK) & (np.abs(p[1]) < 0.5 * t - _SLACK))
    volume = float(np.asarray(solid.basis.dx).sum())
    weights = [elastic.weight(np.array(axis) / volume) for axis in ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0))]
    cases = np.column_stack([_push(elastic, wall, 0), _push(elastic, wall, 2), *weights])

    def judged(p: Array, slack: float) -> Mask:
        return np.asarray(np.minimum(*(near(p, bore) - bore.room for bore in bores)) > -slack)

    return BracketPart("lever", elastic, cases, (_plate("lever", solid, judged, 1, t),))


def _push(elastic: Elastic, facets: Index, axis: int) -> Array:
    """The load (3 N,) of 1 N along an axis on a bore's facets, as pressure that varies as the cosine."""
    load = elastic.traction(facets, lambda _, n: n * n[..., axis : axis + 1])
    return np.asarray(load / load.reshape(-1, 3)[:, axis].sum())


def _clamped(bracket: Bracket, nodes: Array) -> Mask:
    """Whether the bolts hold nodes (3, N): squares on the baseplate's back."""
    plate = bracket.baseplate
    away = [
        np.abs(np.abs(nodes[k] - centre) - 0.5 * spacing) < 0.5 * plate.clamped + _SLACK
        for k, centre, spacing in ((1, 0.0, plate.bolts[0]), (2, bracket.rise, plate.bolts[1]))
    ]
    back = nodes[0] < -bracket.standoff - plate.thickness + _SLACK
    return np.asarray(back & away[0] & away[1])


def _pad(spacing: float, clamped: float, edge: float) -> list[float]:
    """Marks at the ends of a clamped square and at *edge* around it, m from the middle of the plate."""
    half = 0.5 * clamped
    return [0.5 * spacing + away for away in (-half - edge, -half, half, half + edge)]


def _both(marks: list[float], limit: float) -> list[float]:
    """*marks* on both sides of the middle, up to *limit*."""
    return [side * mark for mark in marks if 0.0 <= mark <= limit + _SLACK for side in (-1.0, 1.0)]


def _plate(name: str, solid: HexMesh, judged: Callable[[Array, float], Mask], axis: int, thickness: float) -> Plate:
    """A plate where positions (3, P) are *judged*, edges included by the slack; *axis* is across its thickness."""
    chosen = np.flatnonzero(judged(solid.nodes, _SLACK))
    keys = np.stack([levels(places) for places in solid.nodes[:, chosen]])
    across = [k for k in range(3) if k != axis]
    order = np.lexsort((keys[axis], keys[across[0]], keys[across[1]]))
    lowest = float(solid.nodes[axis, chosen].min())
    first = solid.nodes[axis, chosen] < lowest + thickness + _SLACK  # of two plates side by side, one
    layers = int(keys[axis, first].max()) + 1
    columns = chosen[order].reshape(-1, layers)
    return Plate(name, columns, np.flatnonzero(judged(solid.cells, 0.0)), thickness)
