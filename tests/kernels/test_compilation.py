"""One signature per kernel, a cache that no edit can fool, and the same numbers without the compiler."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from numba.core.types import unliteral

import cases
from cablewright import kernels
from cablewright.analyses.interference import interference
from cablewright.kernels import batches
from cablewright.kernels.statics import catenary
from cablewright.machine.simulated.simulated_machine import PLANTS
from cablewright.models.fidelity import CableLaw, Fidelity
from cablewright.models.statics import Model
from cablewright.models.stiffness import stiffness
from cablewright.robot import library_names, load
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise
from cablewright.solvers.tension import METHODS, capacity, distribute
from twins import machine, run

MODULES = [import_module(f"cablewright.kernels.{path.stem}") for path in Path(kernels.__file__).parent.glob("[!_]*.py")]


def test_every_kernel_has_one_compiled_signature() -> None:
    for name in library_names():
        model = Model(load(name))
        asked = cases.poses(model, 1).pose
        asked[:, 3 : 3 + model.n - model.m] = np.nan  # what gravity decides, if anything
        for rows in (1, 100):
            found = solve_inverse(model, np.repeat(asked, rows, axis=0))
            solve_forward(model, found.lengths, guess=found.pose, path=True)
            stiffness(found)
            linearise(solve_forward(model, found.lengths, modulus_factors=np.ones(model.m)).checked())
            assert found.is_valid()
            interference(found).curves()
            for method in METHODS:
                distribute(Model(load(name), Fidelity(CableLaw.RIGID)), found.pose, method)
            capacity(Model(load(name), Fidelity(CableLaw.RIGID)), found.pose)
    for plant in PLANTS:
        run(machine(plant=plant), 100, valve=1.0)
    for module in MODULES:
        for each in vars(module).values():
            if hasattr(each, "signatures"):
                kinds = {tuple(map(unliteral, signature)) for signature in each.signatures}
                assert len(kinds) <= 1, f"{each.__name__}: {kinds}"


def test_the_cache_is_stamped_with_all_sources() -> None:
    stamp = batches.forward_rows._cache._cache_file._source_stamp
    assert stamp == kernels.STAMP == kernels._stamp()
    assert catenary.span._cache._cache_file._source_stamp == stamp


def test_an_edited_callee_is_not_answered_by_a_stale_caller(tmp_path) -> None:
    """The trap itself: a caller in one file, its callee in another, the callee edited between two processes."""
    package = tmp_path / "trap"
    package.mkdir()
    (package / "__init__.py").write_text(Path(kernels.__file__).read_text())
    (package / "caller.py").write_text(
        "from trap import jit\nfrom trap.callee import f\n@jit\ndef g():\n    return f()\n"
    )

    def answer(value: float) -> str:
        (package / "callee.py").write_text(f"from trap import jit\n@jit\ndef f():\n    return {value}\n")
        code = "from trap.caller import g; print(g())"
        run = [sys.executable, "-B", "-c", code]  # Python's own cache tells files apart by size and second
        return subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, check=True).stdout.strip()

    assert answer(1.0) == "1.0"
    assert answer(2.0) == "2.0"


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


def test_an_unwritable_cache_compiles_and_says_so(monkeypatch, caplog) -> None:
    def refuse(**options):
        if options.get("cache"):
            raise RuntimeError("cannot cache function: no locator available")
        return original(**options)

    original = kernels.numba.jit
    monkeypatch.setattr(kernels.numba, "jit", refuse)
    double = kernels.jit(lambda x: 2.0 * x)
    assert double(3.0) == 6.0
    assert "compiled anew" in caplog.text
