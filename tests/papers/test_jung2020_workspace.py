"""Jung 2020: converged volumes beside the counted ones, the largest slice, the retraction law, what widening costs.

The paper prints 2.96 m^3 (Table 1), 0.64 (Fig. 10), l_e(z) = -0.675 z + 1.929 (Eq. 15) and 3 %. Counting 41^3 nodes
gives the first two. The law is not reproduced: neither its slices nor its reference height are given.
"""

from __future__ import annotations

import re
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cablewright.analyses.workspace.best_retraction import retraction
from cablewright.analyses.workspace.criterion import RetractionLaw
from cablewright.analyses.workspace.workspace import count_nodes, workspace
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import load

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "examples" / "papers" / "jung2020.py"
RIGID = Fidelity.of("rigid")


@pytest.fixture(scope="module")
def example() -> dict[str, Any]:
    return runpy.run_path(str(EXAMPLE), run_name="example")


@pytest.fixture(scope="module")
def table_3(example: dict[str, Any]) -> Model:
    return Model(example["beam"](0.1), RIGID)


@pytest.mark.slow  # its volumes and laws are those of the tests below
def test_the_page_shows_what_the_example_prints(example: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    example["main"]()
    page = (ROOT / "docs" / "papers" / "jung2020.md").read_text(encoding="utf-8")
    shown = re.search(r"```text\n(.*?)```", page, re.DOTALL)
    assert shown is not None
    assert capsys.readouterr().out == shown[1]


def test_table_1_converges_to_more_than_the_paper_counts() -> None:
    model = Model(load("jung2020-table1"), RIGID)
    counted, whole = count_nodes(model, "closed-form"), workspace(model, "closed-form")
    assert 100.0 * counted.fraction == pytest.approx(37.1, abs=0.05)
    assert counted.volume == pytest.approx(2.96, abs=0.01)  # the paper
    assert whole.volume == pytest.approx(3.19, abs=0.01)
    assert abs(whole.volume - 3.188) <= whole.volume_error + 0.004  # 4e6 random places: 3.188 +- 0.002
    assert abs(counted.volume - whole.volume) <= counted.volume_error


def test_the_largest_slice(table_3: Model) -> None:
    counted = count_nodes(table_3, "closed-form", retraction=1.2)
    slices = counted.slices() / 4.0
    assert slices.max() == pytest.approx(0.636, abs=5e-4)  # the paper: 0.64
    assert counted.axes[2][slices.argmax()] == pytest.approx(1.2, abs=0.03)
    whole = workspace(table_3, "closed-form", retraction=1.2).slices(np.linspace(0.0, 2.0, 201)) / 4.0
    assert whole.max() == pytest.approx(0.666, abs=1e-3)


def test_laws(table_3: Model) -> None:
    """Counted as the paper counts: its own law loses with z of p against always 2 m, gains with z of the lower end."""

    def counted(slope: float, intercept: float) -> float:
        law = RetractionLaw(slope, intercept, 1.2, 2.0, "origin")
        return count_nodes(table_3, "closed-form", retraction=law, point="origin").volume

    constant = counted(0.0, 2.0)
    assert constant == pytest.approx(3.217, abs=5e-4)
    assert counted(-0.675, 1.929) == pytest.approx(3.048, abs=5e-4)
    assert counted(-0.675, 1.929 + 0.675 * 0.2) == pytest.approx(3.702, abs=5e-4)
    own = retraction(table_3, "closed-form", point="origin")
    assert own.share > 0.99
    assert counted(own.law.slope, own.law.intercept) > 0.99 * 3.851  # each slice at its best, counted
    assert own.law.slope == pytest.approx(-1.0, abs=0.02)  # the paper: -0.675


def test_widening_costs_three_points_of_the_frame(example: dict[str, Any], table_3: Model) -> None:
    narrow = count_nodes(table_3, "closed-form").fraction
    wide = count_nodes(Model(example["beam"](0.1, 0.16), RIGID), "closed-form").fraction
    assert 100.0 * (narrow - wide) == pytest.approx(3.0, abs=0.05)  # the paper: 3 %
