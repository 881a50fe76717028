"""Count the branches on a robot's kind outside the interfaces of a line and of the platform; fail above the ceilings.

A branch is the test of an ``if``, a conditional expression, a loop or a comprehension. It is on a kind if it asks for
the number of pose coordinates, for a plane, or for the guides, sheaves, counterweight or mount of a line. The folders
and files of `INTERFACES` may ask: there the kinds are defined, or one function decides for all callers.
"""

from __future__ import annotations

import argparse
import ast
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = Path("src", "cablewright")
INTERFACES = (
    "kernels/statics/line/",
    "kernels/statics/platform.py",
    "kernels/statics/platform_enclosure.py",
    "robot/",
    "models/",
)
CEILINGS = {"kernels": 18, "Python": 117}

COORDINATES = frozenset({"n", "freedoms"})
COLUMNS = frozenset({"GUIDE", "COUNTERWEIGHT", "UNKNOWNS", "LEVER", "RADIUS", "END_RADIUS", "MOUNT", "HELD"})
ASKED = frozenset({
    "plane", "guides", "counterweight", "platform_sheave", "in_plane", "is_aside", "has_lever", "has_dead_span",
    "upright", "is_held", "is_eyelet", "has_plane",
})  # fmt: skip
KINDS = frozenset({
    "Eyelet", "Swivel", "UniversalJoint", "Pulley", "PlatformSheave", "PlatformPulley", "GuideSheave", "PointPlatform",
    "RigidPlatform",
})  # fmt: skip
OPTIONAL = frozenset({"spatial", "general", "plane", "counterweight", "platform_sheave"})


class Branch(NamedTuple):
    """A test on a kind: its file under the package, its line, and what it asks."""

    file: str
    line: int
    test: str


def main() -> int:
    """Print the branches and their numbers; return 1 where there are more than the ceilings allow."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("root", nargs="?", type=Path, default=ROOT, help="checkout to count, by default this one")
    parser.add_argument("--quiet", action="store_true", help="print the numbers only")
    parser.add_argument("--also", nargs="*", default=[], help="further files of the interfaces, under the package")
    given = parser.parse_args()
    found = list(branches(given.root / PACKAGE, (*INTERFACES, *given.also)))
    inside = {"kernels": [one for one in found if one.file.startswith("kernels/")]}
    inside["Python"] = [one for one in found if not one.file.startswith("kernels/")]
    for part, own in inside.items():
        if not given.quiet:
            print(*(f"{PACKAGE / one.file}:{one.line}: {one.test}" for one in own), sep="\n")
        print(f"{part}: {len(own)} branches on a robot's kind, at most {CEILINGS[part]} allowed")
    return int(any(len(own) > CEILINGS[part] for part, own in inside.items()))


def branches(package: Path, interfaces: tuple[str, ...]) -> Iterator[Branch]:
    """Yield the branches on a kind in all files of *package* but those of the *interfaces*."""
    for path in sorted(package.rglob("*.py")):
        file = path.relative_to(package).as_posix()
        if file.startswith(interfaces):
            continue
        for test in tests(ast.parse(path.read_text(encoding="utf-8"))):
            if any(is_on_kind(node) for node in ast.walk(test)):
                yield Branch(file, test.lineno, " ".join(ast.unparse(test).split()))


def tests(tree: ast.Module) -> Iterator[ast.expr]:
    """Yield the tests of all branches, each once: a condition within the test of another is part of that one."""
    for node in ast.walk(tree):
        if isinstance(node, ast.If | ast.IfExp | ast.While):
            yield node.test
        elif isinstance(node, ast.comprehension):
            yield from node.ifs


def is_on_kind(node: ast.AST) -> bool:
    """Whether one part of a test asks for the kind of a robot."""
    if isinstance(node, ast.Compare):
        return is_of_coordinates(node) or is_of_optional(node)
    if isinstance(node, ast.Subscript):
        return any(name_of(one) in COLUMNS for one in ast.walk(node.slice))
    if isinstance(node, ast.Call) and name_of(node.func) == "isinstance":
        return any(name_of(one) in KINDS for one in ast.walk(node.args[1]))
    if isinstance(node, ast.Call):
        return name_of(node.func) in ASKED
    return isinstance(node, ast.Attribute) and node.attr in ASKED


def is_of_coordinates(node: ast.Compare) -> bool:
    """Whether a number of coordinates is compared with 3 or 6: `n`, `freedoms`, a shape or the length of a pose."""
    sides = (node.left, *node.comparators)
    if not any(isinstance(one, ast.Constant) and one.value in (3, 6) for one in sides):
        return False
    texts = map(ast.unparse, sides)
    return any(text.split(".")[-1] in COORDINATES or ".shape[" in text or text == "len(pose)" for text in texts)


def is_of_optional(node: ast.Compare) -> bool:
    """Whether what only robots out of the plane have is compared with None."""
    is_none = any(isinstance(one, ast.Constant) and one.value is None for one in node.comparators)
    return is_none and name_of(node.left) in OPTIONAL


def name_of(node: ast.AST) -> str:
    """Return the name of a variable or attribute, else nothing."""
    return node.id if isinstance(node, ast.Name) else node.attr if isinstance(node, ast.Attribute) else ""


if __name__ == "__main__":
    sys.exit(main())
