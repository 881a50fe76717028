"""forward(inverse(x)) = x to 1e-9 m and 1e-9 rad: every robot, cable law and sheave law, random poses of each."""

from __future__ import annotations

import numpy as np
import pytest

import cases
from cablewright.models.fidelity import CableLaw
from cablewright.models.statics import Model
from cablewright.solvers.forward import solve_forward

MODELS = list(cases.models(CableLaw.ELASTIC, CableLaw.CATENARY))


@pytest.mark.parametrize("model", MODELS, ids=cases.name)
def test_forward_of_inverse_is_the_pose(model: Model) -> None:
    held = cases.poses(model, cases.often(60, 300))
    back = solve_forward(model, held.lengths)
    assert back.ok.all()
    assert np.linalg.norm(back.pose[:, :3] - held.pose[:, :3], axis=1).max() < 1e-9
    assert cases.turned(back.pose, held.pose).max() < 1e-9
    assert back.is_valid(1e-9)
    assert held.is_valid(1e-9)
    assert (held.margin() > -1e-6).all()
