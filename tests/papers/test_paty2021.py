"""Paty 2021, Table 1, nominal error: lengths of rigid cables, platform with the full model.

Set A, the literal text: a = 7.5 m, H = 15 m, full 4 mm circle, 102.2 GPa, dead span elastic. The paper prints 19.5 mm
at P1 and 214.6 mm at P2; its cable section is not given, and no section reproduces both (docs/papers/paty2021.md).
"""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import numpy as np
import pytest

from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(("height", "error"), [(0.0, 19.0e-3), (13.25, 298e-3)])
def test_error_when_cable_deformation_is_neglected(height: float, error: float) -> None:
    robot = load("paty2021")
    wanted = np.array([0.0, 0.0, height])
    rigid = solve_inverse(Model(robot, Fidelity(CableLaw.RIGID)), wanted).checked()
    reached = solve_forward(Model(robot), rigid.lengths).checked()
    digits = 10 ** (np.floor(np.log10(error)) - 2)
    assert np.linalg.norm(reached.pose - wanted) == pytest.approx(error, abs=0.5 * digits)


@pytest.mark.slow  # its first rows are those of the test before
def test_the_page_shows_what_the_example_prints(capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(ROOT / "examples" / "papers" / "paty2021.py"), run_name="__main__")
    page = (ROOT / "docs" / "papers" / "paty2021.md").read_text(encoding="utf-8")
    shown = re.search(r"```text\n(.*?)```", page, re.DOTALL)
    assert shown is not None
    assert capsys.readouterr().out == shown[1]


def test_tensions_at_the_ground_are_600_newtons() -> None:
    rigid = solve_inverse(Model(load("paty2021"), Fidelity(CableLaw.RIGID)), [0.0, 0.0, 0.0]).checked()
    np.testing.assert_allclose(rigid.tensions, 600.0, atol=5.0)
