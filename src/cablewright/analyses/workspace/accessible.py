"""The accessible static workspace: where the machine can be, which limit ends it, and where.

Paty 2021, section 4.1: tension limits, swing and elevation of the sheaves, no collision in them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cablewright.analyses.feasibility import broken_limits
from cablewright.errors import InputError
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.inverse import solve_inverse

__all__ = ["Accessible", "Edge", "Rule", "accessible", "box", "sheave_rules"]

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]

BLOCK = 8192  # poses solved between two reports
CLOSE = 1e-3  # m: to which an end of the workspace is found
SHEAVE_RATIO = 20.0  # least radius of a sheave over that of its cable, Paty 2021, section 3.1.1
MOST_NODES = 20_000_000


@dataclass(frozen=True)
class Edge:
    """Where one limit ends the workspace: how many of the grid's ends, and the lowest and highest place of them, m."""

    limit: str
    ends: int
    lowest: tuple[float, float, float]
    highest: tuple[float, float, float]


@dataclass(frozen=True)
class Rule:
    """A rule of thumb that a line keeps or breaks wherever the platform is."""

    line: str
    value: float  # radius of the sheave over radius of the cable
    wanted: float
    holds: bool


@dataclass(frozen=True, eq=False)
class Accessible:
    """A grid of places and whether the machine can be there. Nodes count with z fastest, then y, then x."""

    axes: tuple[Array, Array, Array]  # coordinates of the nodes along x, y, z, m
    inside: NDArray[np.bool_]  # (X, Y, Z)
    edges: tuple[Edge, ...]  # by how often they end it, most first; none where nothing is accessible
    ends: Array  # (E, 3) points of the boundary, to CLOSE, m
    ended_by: NDArray[np.int64]  # (E,) which of `limits`
    limits: tuple[str, ...]

    @property
    def nodes(self) -> Array:
        """(X * Y * Z, 3) all places, m."""
        return np.stack(np.meshgrid(*self.axes, indexing="ij"), axis=-1).reshape(-1, 3)

    @property
    def volume(self) -> float:
        """Accessible nodes times what is theirs of a cell within the frame, m^3: as exact as the grid is fine."""
        widths = [np.r_[0.5, np.ones(len(axis) - 2), 0.5] * (axis[1] - axis[0]) for axis in self.axes]
        return float(np.einsum("ijk,i,j,k->", self.inside.astype(np.float64), *widths))


def box(robot: Robot, step: float) -> tuple[Array, Array, Array]:
    """Nodes every *step* (m) or a little less, from side to side of the frame. Raises `InputError`."""
    sides = list(zip(robot.scene.frame_min, robot.scene.frame_max, strict=True))
    shortest = min(high - low for low, high in sides)
    if not 0.0 < step <= shortest:
        raise InputError(f"step {step:g} m: more than 0 and at most {shortest:g} m, a side of the frame, is allowed")
    counts = [int(np.ceil((high - low) / step - 1e-9)) + 1 for low, high in sides]
    if np.prod(counts) > MOST_NODES:
        raise InputError(f"step {step:g} m: {np.prod(counts)} nodes; at most {MOST_NODES} are allowed")
    x, y, z = (np.linspace(low, high, count) for (low, high), count in zip(sides, counts, strict=True))
    return x, y, z


def accessible(model: Model, step: float, progress: Progress | None = None) -> Accessible:
    """Where on a grid of *step* (m) over its frame the machine of *model* can hold its nozzle, the platform unrotated.

    A place counts where the inverse problem has a solution within the tension limits and swing, lever angle, cable
    length, winch torque and the clearance of the sheaves are within theirs. Raises `InputError` for a bad step.
    """
    axes = box(model.robot, step)
    shape = tuple(len(axis) for axis in axes)
    grid = Accessible(axes, np.zeros(shape, dtype=bool), (), np.empty((0, 3)), np.empty(0, dtype=np.int64), ())
    limits, broken = _broken(model, grid.nodes, progress)
    inside = np.asarray(~broken.any(axis=1)).reshape(shape)
    ends, ended_by = _ends(model, axes, inside)
    sides = grid.nodes[(_on_sides(shape) & inside).ravel()]
    ends, ended_by = np.concatenate([ends, sides]), np.append(ended_by, np.full(len(sides), len(limits)))
    limits = (*limits, "frame")
    return Accessible(axes, inside, tuple(_edges(limits, ends, ended_by)), ends, ended_by, limits)


def _on_sides(shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Which nodes of a grid are on a side of the frame."""
    inner = np.zeros(shape, dtype=bool)
    inner[1:-1, 1:-1, 1:-1] = True
    return ~inner


def _broken(model: Model, places: Array, progress: Progress | None = None) -> tuple[tuple[str, ...], NDArray[np.bool_]]:
    """Names of all limits, and which of them each of the *places* (N, 3) breaks, (N, L)."""
    limits: tuple[str, ...] = ()
    found = []
    for first in range(0, len(places), BLOCK):
        if progress:
            progress(first, len(places))
        limits, broken = broken_limits(
            solve_inverse(model, model.unrotated_at(places[first : first + BLOCK]), path=True)
        )
        found.append(broken)
    if progress:
        progress(len(places), len(places))
    return limits, np.concatenate(found)


def _ends(model: Model, axes: tuple[Array, Array, Array], inside: NDArray[np.bool_]) -> tuple[Array, NDArray[np.int64]]:
    """Points (E, 3) where the way from a node inside to its neighbour outside ends, and the limit that ends it.

    Halved until CLOSE: whatever is broken just outside is what ends it, the first of the limits where several do.
    """
    pairs = list(_pairs(axes, inside))
    if not pairs:
        return np.empty((0, 3)), np.empty(0, dtype=np.int64)
    within, without = (np.concatenate(side) for side in zip(*pairs, strict=True))
    if not len(within):
        return np.empty((0, 3)), np.empty(0, dtype=np.int64)
    longest = float(np.linalg.norm(without - within, axis=1).max())
    for _ in range(max(1, int(np.ceil(np.log2(longest / CLOSE))))):
        middle = 0.5 * (within + without)
        good = ~_broken(model, middle)[1].any(axis=1)
        within[good], without[~good] = middle[good], middle[~good]
    return within, _broken(model, without)[1].argmax(axis=1)


def _pairs(axes: tuple[Array, Array, Array], inside: NDArray[np.bool_]) -> Iterator[tuple[Array, Array]]:
    """Neighbours of which one is inside and one is not, as points (E, 3) inside and outside, axis by axis."""
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    for axis in range(3):
        places, held = np.moveaxis(nodes, axis, 0), np.moveaxis(inside, axis, 0)
        last, first = held[:-1] & ~held[1:], held[1:] & ~held[:-1]
        yield places[:-1][last], places[1:][last]
        yield places[1:][first], places[:-1][first]


def _edges(limits: tuple[str, ...], ends: Array, ended_by: NDArray[np.int64]) -> Iterator[Edge]:
    """What ended the workspace how often, most first."""
    counts = np.bincount(ended_by, minlength=len(limits))
    for limit in np.argsort(-counts, kind="stable"):
        if counts[limit]:
            own = ends[ended_by == limit]
            lowest, highest = own[own[:, 2].argmin()], own[own[:, 2].argmax()]
            yield Edge(limits[limit], int(counts[limit]), _triple(lowest), _triple(highest))


def _triple(point: Array) -> tuple[float, float, float]:
    x, y, z = (float(number) for number in point)
    return x, y, z


def sheave_rules(robot: Robot) -> tuple[Rule, ...]:
    """Ratio of each sheave's radius to its cable's, over 20 to spare the cable; lines without either are left out."""
    found = []
    for line in robot.lines:
        radius = getattr(line.sheave, "radius", None)
        if radius is not None and line.cable.diameter is not None:
            ratio = 2.0 * radius / line.cable.diameter
            found.append(Rule(line.name, ratio, SHEAVE_RATIO, ratio > SHEAVE_RATIO))
    return tuple(found)
