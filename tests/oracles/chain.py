"""Oracle: a sagging span as a chain of many weights on springs, which finds its shape by lowering its energy."""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import solveh_banded


def end_tensions(x: float, z: float, L: float, w: float, EA: float, links: int = 400) -> np.ndarray:
    """Return the tension vectors (2, 2) N at start and end of a chain hung from (0, 0) to (x, z), x > 0.

    ``L`` m is its unstrained length, ``w`` N/m its weight per unstrained length, ``EA`` N the stiffness of its links.
    Each inner node weighs as much as a link and each end half of that: the error falls with the square of ``links``.
    """
    link = L / links
    nodes = _first_shape(x, z, L, links)
    energy = _energy(nodes, link, w, EA)
    shift = 1e-3 * EA / link
    for _ in range(5000):
        force, bands = _forces(nodes, link, w, EA)
        bands[-1] += shift
        step = solveh_banded(bands, force.ravel()).reshape(-1, 2)
        trial = nodes.copy()
        trial[1:-1] += step
        lower = _energy(trial, link, w, EA)
        if lower <= energy + 1e-13 * abs(energy):
            nodes, energy, shift = trial, lower, max(shift / 5, 1e-12 * EA / link)
            if abs(step).max() < 1e-12 * L:
                return _ends(nodes, link, w, EA)
        else:
            shift *= 4
    raise ArithmeticError("the links did not come to rest")


def _first_shape(x: float, z: float, L: float, links: int) -> np.ndarray:
    """Return nodes (links + 1, 2) on a parabola, a little longer than the links."""
    at = np.linspace(0.0, 1.0, links + 1)
    chord = math.hypot(x, z)
    sag = math.sqrt(max(0.0, 0.375 * chord * (L - chord))) + 0.02 * L
    return np.column_stack([at * x, at * z - 4 * sag * at * (1 - at)])


def _links(nodes: np.ndarray, link: float, EA: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the links' lengths, directions and tensions; none can push."""
    vectors = np.diff(nodes, axis=0)
    lengths = np.hypot(vectors[:, 0], vectors[:, 1])
    return lengths, vectors / lengths[:, None], np.maximum(0.0, EA * (lengths / link - 1))


def _energy(nodes: np.ndarray, link: float, w: float, EA: float) -> float:
    tensions = _links(nodes, link, EA)[2]
    return float((tensions**2).sum() * link / (2 * EA) + w * link * nodes[1:-1, 1].sum())


def _forces(nodes: np.ndarray, link: float, w: float, EA: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the forces on the inner nodes and the stiffness, as `scipy.linalg.solveh_banded` wants it."""
    lengths, directions, tensions = _links(nodes, link, EA)
    pulls = tensions[:, None] * directions
    force = pulls[1:] - pulls[:-1] - [0.0, w * link]
    along = directions[:, :, None] * directions[:, None, :]
    stiffness = EA / link * (tensions > 0)[:, None, None] * along
    stiffness += (tensions / lengths)[:, None, None] * (np.eye(2) - along)
    diagonal = stiffness[1:] + stiffness[:-1]
    bands = np.zeros((4, 2 * len(diagonal)))
    bands[3, 0::2], bands[3, 1::2], bands[2, 1::2] = diagonal[:, 0, 0], diagonal[:, 1, 1], diagonal[:, 0, 1]
    between = -stiffness[1:-1]
    bands[1, 2::2], bands[1, 3::2] = between[:, 0, 0], between[:, 1, 1]
    bands[0, 3::2], bands[2, 2::2] = between[:, 0, 1], between[:, 1, 0]
    return force, bands


def _ends(nodes: np.ndarray, link: float, w: float, EA: float) -> np.ndarray:
    _, directions, tensions = _links(nodes, link, EA)
    half = np.array([0.0, w * link / 2])
    return np.array([tensions[0] * directions[0] - half, tensions[-1] * directions[-1] + half])
