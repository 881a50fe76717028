"""No module imports another in a circle, imports for types counted too, and none names a higher rank as text."""

from __future__ import annotations

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import cablewright

HOME = Path(cablewright.__file__).parent
FOUND = ("cablewright.estimation.body.updates", "cablewright.machine.simulated.sensors")
"""Packages whose modules are found: their methods name, for types alone, the states and machines that hold them."""


def imports_below(home: Path) -> dict[str, set[str]]:
    """The modules of a package, the root left out, and which others of it each imports, anywhere in it."""
    root, paths = home.name, {}
    for path in sorted(home.rglob("*.py")):
        parts = path.relative_to(home.parent).with_suffix("").parts
        paths[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    paths.pop(root, None)
    found: dict[str, set[str]] = {}
    for module, path in paths.items():
        names = set[str]()
        tree = ast.parse(path.read_text(encoding="utf-8"))
        if module.startswith(FOUND):
            tree.body = [node for node in tree.body if "TYPE_CHECKING" not in ast.unparse(node).partition(":")[0]]
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                names |= {each.name for each in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module is not None:
                own = {f"{node.module}.{each.name}" for each in node.names}
                names |= {each if each in paths else node.module for each in own}
        found[module] = (names & paths.keys()) - {module}
    return found


def circle_in(graph: dict[str, set[str]]) -> list[str]:
    """The modules of one circle; none: there is no circle."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        circle: list[str] = error.args[1]
        return circle
    return []


def test_no_module_is_in_a_circle() -> None:
    graph = imports_below(HOME)
    assert len(graph) > 600
    assert circle_in(graph) == []


@pytest.mark.parametrize(
    "text", ["from shop.b import B", "import shop.b", "from shop import b", "def f():\n    from shop.b import B",
             "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from shop.b import B"]
)  # fmt: skip
def test_a_planted_circle_is_found(text: str, tmp_path: Path) -> None:
    home = tmp_path / "shop"
    home.mkdir()
    (home / "__init__.py").write_text("from shop.a import A\n")
    (home / "a.py").write_text(f"{text}\n")
    (home / "b.py").write_text("x = 1\n")
    assert circle_in(imports_below(home)) == []
    (home / "b.py").write_text("from shop.a import A\n")
    assert set(circle_in(imports_below(home))) == {"shop.a", "shop.b"}


def test_no_module_below_apps_names_apps() -> None:
    """As text: an import by name, which no contract sees."""
    named = [
        f"{path.relative_to(HOME)}:{node.lineno}"
        for path in sorted(HOME.rglob("*.py"))
        if path.relative_to(HOME).parts[0] not in ("apps", "__init__.py", "__main__.py")
        if "cablewright.apps" in path.read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.startswith("cablewright.apps")
    ]
    assert named == []
