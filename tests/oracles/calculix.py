"""Oracle: a solid as an input deck for CalculiX (Debian's ccx), an independent program, and its answer."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np

from cablewright.analyses.bracket.elasticity import Elastic
from cablewright.apps.report.bracket_vtu import CORNERS_THEN_EDGES


def deck(elastic: Elastic, load: np.ndarray) -> str:
    """Linear static analysis of C3D20 elements under nodal forces (3 N,), displacements printed at all nodes.

    ccx reads no more than 20 characters of a number.
    """
    basis = elastic.solid.basis
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{i + 1}, {x:.12e}, {y:.12e}, {z:.12e}" for i, (x, y, z) in enumerate(basis.doflocs.T)]
    lines.append("*ELEMENT, TYPE=C3D20, ELSET=SOLID")
    for number, nodes in enumerate(basis.element_dofs[CORNERS_THEN_EDGES].T + 1):
        lines += [f"{number + 1}, " + ", ".join(map(str, nodes[:10])) + ",", ", ".join(map(str, nodes[10:]))]
    material = elastic.material
    lines += ["*MATERIAL, NAME=M", "*ELASTIC", f"{material.young_modulus:.12e}, {material.poisson_ratio:.12e}"]
    lines += ["*SOLID SECTION, ELSET=SOLID, MATERIAL=M", "*BOUNDARY"]
    lines += [f"{node + 1}, 1, 3" for node in elastic.fixed]
    lines += ["*STEP", "*STATIC", "*CLOAD"]
    lines += [f"{dof // 3 + 1}, {dof % 3 + 1}, {load[dof]:.12e}" for dof in np.flatnonzero(load)]
    lines += ["*NODE PRINT, NSET=ALL", "U", "*END STEP", ""]
    return "\n".join(lines)


def displacements(elastic: Elastic, load: np.ndarray, folder: Path) -> np.ndarray:
    """What ccx says the nodes do, (3 N,) m."""
    (folder / "solid.inp").write_text(deck(elastic, load))
    subprocess.run(["ccx", "solid"], cwd=folder, check=True, capture_output=True, timeout=300)
    rows = [line.split() for line in (folder / "solid.dat").read_text().splitlines()]
    told = [[float(each) for each in row] for row in rows if len(row) == 4 and row[0].isdecimal()]
    found = np.zeros((elastic.solid.basis.N, 3))
    for node, *moved in told:
        found[int(node) - 1] = moved
    return found.ravel()
