"""One signature per kernel, and the same numbers without the compiler."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

import cases
from cablewright.analyses.interference import distances
from cablewright.machine.simulated.simulated_machine import PLANTS
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.models.stiffness import stiffness
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise
from cablewright.solvers.tension import METHODS, capacity, tension_distribution
from twins import machine, run


def test_every_kernel_has_one_compiled_signature() -> None:
    for name in cases.LIBRARY:
        model = Model(load(name))
        asked = cases.poses(model, 1).pose
        asked[:, 3 : 3 + model.n - model.m] = np.nan  # what gravity decides, if anything
        for rows in (1, 100):
            found = solve_inverse(model, np.repeat(asked, rows, axis=0))
            solve_forward(model, found.lengths, guess=found.pose, path=True)
            stiffness(found)
            linearise(solve_forward(model, found.lengths, modulus_factors=np.ones(model.m)).checked())
            assert found.is_valid()
            distances(found).curves()
            for method in METHODS:
                tension_distribution(Model(load(name), Fidelity(CableLaw.RIGID)), found.pose, method)
            capacity(Model(load(name), Fidelity(CableLaw.RIGID)), found.pose)
    for plant in PLANTS:
        run(machine(plant=plant), 100, valve=1.0)
    cases.assert_one_signature_per_kernel()


@pytest.mark.parametrize("name", ["paty2021", "merlet2023", "cogiro"])
def test_without_the_compiler_the_numbers_are_the_same(name: str) -> None:
    code = (
        f"import cablewright as cw; r = cw.load({name!r}); e = cw.inverse(r, [0.2, -0.1, 1.0]);"
        "f = cw.forward(r, e.lengths); print(*map(repr, map(float, [*e.lengths, *f.pose])))"
    )
    plain = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    robot = load(name)
    held = solve_inverse(Model(robot), [0.2, -0.1, 1.0])
    back = solve_forward(Model(robot), held.lengths)
    np.testing.assert_allclose(
        [float(x) for x in plain.stdout.split()], [*held.lengths, *back.pose], rtol=0, atol=1e-12
    )
