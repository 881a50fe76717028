"""The public names, and what importing costs: nothing that is not requested."""

from __future__ import annotations

import ast
import doctest
import re
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module, resources
from pathlib import Path
from typing import get_args

import pytest

import cablewright
from cablewright import Robot
from cablewright.foundation.validation import Description
from cablewright.robot import Bracket

ROOT = Path(__file__).resolve().parent.parent
EXTRAS = (
    "can",
    "cma",
    "distributed",
    "meshio",
    "pandas",
    "pymoo",
    "pysoem",
    "rosbags",
    "skfem",
    "starlette",
    "uvicorn",
    "websockets",
    "xarray",
)
HEAVY = {"numba", "scipy", "matplotlib", "pyarrow", "numpy", "llvmlite", "typer", "rich"}


def loaded_by(statement: str) -> set[str]:
    """The heavy packages that a fresh process has loaded after *statement*."""
    code = f"import sys\n{statement}\nprint(*{{name.partition('.')[0] for name in sys.modules}})"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return HEAVY & set(ended.stdout.split())


def test_every_public_name_is_there() -> None:
    for name in cablewright.__all__:
        value = getattr(cablewright, name)
        assert value is not None, name
        assert getattr(value, "__doc__", None), name
        assert value is getattr(cablewright, name), name


def test_the_list_is_sorted_short_and_complete() -> None:
    names = cablewright.__all__
    assert names == sorted(set(names))
    assert len(names) <= 208
    assert dir(cablewright) == names


def test_every_line_of_the_stub_declares_one_name_that_its_module_defines() -> None:
    stub = ast.parse(Path(cablewright.__file__).with_suffix(".pyi").read_text("utf-8"))
    declared = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    assert len(declared) == len(cablewright.__all__)
    for node in declared:
        (alias,) = node.names
        assert node.level == 0
        assert alias.asname == alias.name  # what type checkers need to export it
        assert hasattr(import_module(str(node.module)), alias.name)


@pytest.mark.parametrize("name", [name for name in cablewright.__all__ if name.islower()])
def test_the_example_in_a_docstring_prints_its_output(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    for case in doctest.DocTestFinder(recurse=False).find(getattr(cablewright, name), name):
        assert runner.run(case).failed == 0


def test_another_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'cablewright' has no attribute 'nothing'"):
        _ = cablewright.nothing
    assert not hasattr(cablewright, "__path_to_nowhere__")


WITHOUT_EXTRAS = f"""
import sys
for name in {EXTRAS!r}:
    sys.modules[name] = None  # an import of it is an ImportError, as where it is not installed
"""


@pytest.mark.slow  # members are found one by one in test_public_calls.py
def test_a_star_brings_all_and_help_shows_all_without_extras() -> None:
    code = f"{WITHOUT_EXTRAS}import cablewright\nhelp(cablewright)\nfrom cablewright import *\nprint(*globals())"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    shown, brought = ended.stdout.rstrip().rsplit("\n", 1)
    assert set(re.findall(r"\w+", shown)) >= set(cablewright.__all__)
    assert set(brought.split()) >= set(cablewright.__all__)


def test_a_robot_is_built_with_public_names_only() -> None:
    of_robots = {name for name, home in cablewright._HOMES.items() if home.startswith("cablewright.robot")}
    parts = {part.__name__ for part in descriptions_in(Robot)}
    assert parts - of_robots == {"Bracket"}  # a file of its own, which `load_bracket` reads
    for example in sorted((ROOT / "examples").glob("[0-9]*.py")):
        assert "from cablewright." not in example.read_text("utf-8"), example.name


def descriptions_in(annotation: object) -> Iterator[type[Description]]:
    """The descriptions that a field may have, in unions, tuples and annotations too, and all that they have."""
    if isinstance(annotation, type) and issubclass(annotation, Description):
        yield annotation
        fields = {} if annotation is Bracket else annotation.model_fields
        for field in fields.values():
            yield from descriptions_in(field.annotation)
            yield from (part for each in field.metadata for part in descriptions_in(each))
    for part in get_args(annotation):
        yield from descriptions_in(part)


def test_class_names_are_unique() -> None:
    homes: dict[str, list[str]] = {}
    for file in sorted(Path(cablewright.__file__).parent.rglob("*.py")):
        for found in re.finditer(r"^ *class ([A-Za-z]\w*)", file.read_text("utf-8"), re.MULTILINE):
            homes.setdefault(found[1], []).append(str(file))
    assert {name: places for name, places in homes.items() if len(places) > 1} == {}


def test_the_package_says_that_it_is_typed() -> None:
    assert (resources.files("cablewright") / "py.typed").is_file()


LOADED = """
import sys, numba, numpy as np
from cablewright import Model, inverse, load
inverse(Model(load("merlet2023")), (0.0, 0.0, 1.0))
assert not {"scipy.linalg", "matplotlib", "pyarrow", "cablewright.solvers.pose_hull"} & set(sys.modules)
"""
OWN = """
own = numba.njit(lambda a, b: np.sum(a) + b[0])
assert own(np.array([[2.0, 1.0], [0.5, 3.0]]), np.array([1.0])) == 7.5
"""
OWN_ALGEBRA = """
own = numba.njit(lambda a, b: (np.dot(a, b), np.sum(a), np.linalg.solve(a, b)))
a, b = np.array([[2.0, 1.0], [0.5, 3.0]]), np.array([[1.0, -1.0], [4.0, 0.25]])
for found, right in zip(own(a, b), (a @ b, np.sum(a), np.linalg.solve(a, b)), strict=True):
    assert np.allclose(found, right, rtol=1e-14)
"""


@pytest.mark.parametrize("own", [OWN, pytest.param(OWN_ALGEBRA, marks=pytest.mark.slow)], ids=["sum", "algebra"])
def test_a_kernel_is_loaded_without_unneeded_modules(own: str) -> None:
    subprocess.run([sys.executable, "-c", LOADED + own], check=True)


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
