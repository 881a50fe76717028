"""The public names, and what importing costs: nothing that is not asked for."""

from __future__ import annotations

import ast
import doctest
import subprocess
import sys
from importlib import resources
from pathlib import Path

import pytest

import cablewright

HEAVY = {"numba", "scipy", "matplotlib", "pyarrow", "numpy", "llvmlite", "typer", "rich"}


def loaded_by(statement: str) -> set[str]:
    """The heavy packages that a fresh process has loaded after *statement*."""
    code = f"import sys\n{statement}\nprint(*{{name.partition('.')[0] for name in sys.modules}})"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return HEAVY & set(ended.stdout.split())


@pytest.mark.parametrize("name", cablewright.__all__)
def test_every_public_name_is_there(name: str) -> None:
    value = getattr(cablewright, name)
    assert getattr(value, "__doc__", None)
    assert value is getattr(cablewright, name)


def test_the_list_is_sorted_short_and_complete() -> None:
    names = cablewright.__all__
    assert len(names) == len(set(names))
    assert len(names) <= 150
    assert set(dir(cablewright)) >= set(names)
    assert sorted(names) == sorted(name for home in cablewright._HOMES.values() for name in home)


def test_the_types_say_the_same_as_the_loader() -> None:
    tree = ast.parse(Path(cablewright.__file__).read_text())
    guarded = next(node for node in tree.body if isinstance(node, ast.If))
    told = {
        alias.name: node.module for node in guarded.body if isinstance(node, ast.ImportFrom) for alias in node.names
    }
    lazy = {name: f"cablewright.{home}" for home, names in cablewright._HOMES.items() for name in names}
    assert told == lazy


@pytest.mark.parametrize("name", [name for name in cablewright.__all__ if name.islower()])
def test_the_example_in_a_docstring_prints_what_it_says(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(Path(__file__).resolve().parent.parent)
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    for case in doctest.DocTestFinder(recurse=False).find(getattr(cablewright, name), name):
        assert runner.run(case).failed == 0


def test_another_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'cablewright' has no attribute 'nothing'"):
        _ = cablewright.nothing
    assert not hasattr(cablewright, "__path_to_nowhere__")


def test_a_star_brings_all() -> None:
    space: dict[str, object] = {}
    exec("from cablewright import *", space)  # noqa: S102
    assert set(space) >= set(cablewright.__all__)


def test_the_package_says_that_it_is_typed() -> None:
    assert (resources.files("cablewright") / "py.typed").is_file()


def test_a_kernel_is_loaded_without_what_it_does_not_need() -> None:
    code = """
import sys, numba, numpy as np
from cablewright import Model, inverse, load
inverse(Model(load("merlet2023")), (0.0, 0.0, 1.0))
assert not {"scipy.linalg", "matplotlib", "pyarrow", "cablewright.solvers.pose_hull"} & set(sys.modules)
own = numba.njit(lambda a, b: (np.dot(a, b), np.convolve(a[0], b[0]), np.linalg.solve(a, b)))
a, b = np.array([[2.0, 1.0], [0.5, 3.0]]), np.array([[1.0, -1.0], [4.0, 0.25]])
for found, right in zip(own(a, b), (a @ b, np.convolve(a[0], b[0]), np.linalg.solve(a, b)), strict=True):
    assert np.allclose(found, right, rtol=1e-14)
"""
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(
    ("statement", "allowed"),
    [
        ("import cablewright", set()),
        ("import cablewright; dir(cablewright)", set()),
        ("import cablewright; cablewright.Status", set()),
        ("import cablewright.robot", set()),
        ("import cablewright; cablewright.load('house-printer')", set()),
        ("import cablewright.printing", {"numpy"}),
        ("import cablewright.apps.cli.main", {"typer", "rich"}),
        ("import cablewright.solvers.forward", {"numpy", "numba", "llvmlite", "scipy"}),  # Numba looks for SciPy
        ("import cablewright.studies.checks.check", {"numpy", "numba", "llvmlite", "scipy"}),
    ],
)
def test_an_import_loads_no_more_than_it_needs(statement: str, allowed: set[str]) -> None:
    assert loaded_by(statement) <= allowed
