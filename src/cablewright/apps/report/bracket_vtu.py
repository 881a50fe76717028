"""File for ParaView of a bracket's displacement and stress: base and one cheek of both designs, side by side."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import meshio
import numpy as np
from numpy.typing import NDArray
from skfem.element import ElementHexS2

from cablewright.analyses.bracket.elasticity import von_mises
from cablewright.analyses.bracket.stress import Comparison, Design
from cablewright.foundation.arrays import Array

_APART: Final = 1.5  # of the baseplate's width

_CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))


def _order() -> list[int]:
    """Which node of scikit-fem's element is which of VTK's; both count from a corner whose axes are right-handed."""
    corners = np.array(_CORNERS, dtype=float)
    wanted = np.vstack([corners, *(corners[[pair]].mean(axis=1) for pair in _EDGES)])
    own = 1.0 - ElementHexS2.doflocs[:, [1, 2, 0]]  # as cells of a grid are turned: see `MeshHex.init_tensor`
    return [int(np.abs(own - place).sum(axis=1).argmin()) for place in wanted]


CORNERS_THEN_EDGES: Final = _order()
"""The 20 nodes of an element as VTK and CalculiX (C3D20) count them."""


def vtu_file(found: Comparison) -> bytes:
    """Return the VTU file (ParaView) of a bracket's displacement and stress.

    Point data `displacement` (m), `von_mises` and `stress` (Pa; xx, yy, zz, yz, xz, xy), cells' `design`. The universal
    joint's is design 0 and keeps the bracket's frame; the conventional one, design 1, stands beside it. Displacements
    are those of each part by itself, stresses those at the nodes, singular edges included.
    """
    pieces = [*_pieces(found.universal_joint, 0), *_pieces(found.conventional, 1)]
    starts = np.cumsum([0, *(len(places) for places, *_ in pieces[:-1])])
    cells = np.concatenate([members + start for (_, members, *_), start in zip(pieces, starts, strict=True)])
    moved, stress = (np.concatenate([piece[k] for piece in pieces]) for k in (2, 3))
    designs = np.concatenate([np.full(len(members), design) for _, members, _, _, design in pieces])
    mesh = meshio.Mesh(
        np.concatenate([piece[0] for piece in pieces]),
        [("hexahedron20", cells)],
        point_data={"displacement": moved, "von_mises": von_mises(stress.T), "stress": stress},
        cell_data={"design": [designs]},
    )
    with TemporaryDirectory() as folder:
        file = Path(folder) / "bracket.vtu"
        mesh.write(file)
        return file.read_bytes()


def _pieces(design: Design, number: int) -> list[tuple[Array, NDArray[np.int64], Array, Array, int]]:
    """Of base and cheek: places (N, 3), elements (E, 20), displacements, stresses (N, 6) and the design's number."""
    bracket, pieces = design.mesh.bracket, []
    beside = np.array([0.0, _APART * number * bracket.baseplate.width, 0.0])
    cheek = 0.5 * (bracket.lever.gap + bracket.lever.thickness)
    for part, moved, stress in design.fields:
        solid = part.elastic.solid
        turn = design.turn if part.name == "lever" else np.eye(3)
        shift = turn @ np.array([0.0, cheek if part.name == "lever" else 0.0, 0.0])
        places = solid.places.T[: solid.basis.N] @ turn.T + shift + beside
        members = np.asarray(solid.basis.element_dofs)[CORNERS_THEN_EDGES].T
        own = stress[:, : solid.basis.N].T if part.name != "lever" else _turned(stress[:, : solid.basis.N], turn)
        pieces.append((places, members, moved @ turn.T, own, number))
    return pieces


def _turned(stress: Array, turn: Array) -> Array:
    """Stresses (6, N) of a turned part, (N, 6)."""
    whole = stress[[[0, 5, 4], [5, 1, 3], [4, 3, 2]]]
    new = np.einsum("ia,abn,jb->ijn", turn, whole, turn)
    return np.stack([new[0, 0], new[1, 1], new[2, 2], new[1, 2], new[0, 2], new[0, 1]], axis=1)
