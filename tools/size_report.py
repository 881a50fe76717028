"""Print how long the files and functions of ``src/`` are; fail where one, or most, are longer than a reader can hold.

A folder may be too full as well, in the tests and the examples too. The statements of each folder of ``src`` have a
ceiling, in ``[tool.size_report.statements]`` of ``pyproject.toml``.
"""

from __future__ import annotations

import ast
import sys
import tomllib
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from statistics import median, quantiles
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = ("src", "tests", "examples", "benchmarks", "tools")
MAX_FILES = 26  # of Python in one folder
MAX_FILE_LINES = 460
MAX_FUNCTION_LINES = 70
MAX_KERNEL_LINES = 110  # a kernel repeats its arithmetic inline where a call would cost an allocation
SHOWN = 5
TOP = "cablewright"  # the ceiling of files that lie beside the folders
RAISING = "raise it in pyproject.toml only with a line in CHANGELOG.md: capability, statements added, removed"


class Piece(NamedTuple):
    """A file or function, its length in lines and the most it may have."""

    lines: int
    limit: int
    name: str


class Profile(NamedTuple):
    """Median and 90th percentile of lengths, in lines: the present ones, or their limits."""

    median: float
    high: float


class Content(NamedTuple):
    """What Python files consist of: statements of the syntax tree, and lines.

    ``code``: lines that are neither blank, comment, docstring nor import. ``imports``: lines of imports.
    """

    statements: int
    code: int
    imports: int

    @classmethod
    def of(cls, text: str) -> Content:
        """Return what a source text consists of."""
        tree, lines = ast.parse(text), text.splitlines()
        blank = {number for number, line in enumerate(lines, 1) if not line.strip() or line.lstrip().startswith("#")}
        nodes = list(ast.walk(tree))
        imports = _lines(node for node in nodes if isinstance(node, ast.Import | ast.ImportFrom))
        texts = _lines(
            node
            for node in nodes
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
        )
        code = len(set(range(1, len(lines) + 1)) - blank - imports - texts)
        return cls(sum(isinstance(node, ast.stmt) for node in nodes), code, len(imports - blank))

    def plus(self, other: Content) -> Content:
        """Return the sum of both."""
        return Content(*(one + another for one, another in zip(self, other, strict=True)))


MOST = {"files": Profile(140, 310), "functions": Profile(10, 25)}


def main() -> int:
    """Print the report; return 1 if a cap is broken."""
    files, functions = measure(ROOT / "src")
    broken = [
        f"{piece.name} has {piece.lines} lines, at most {piece.limit} allowed"
        for piece in (*files, *functions)
        if piece.lines > piece.limit
    ]
    for kind, pieces in (("files", files), ("functions", functions)):
        found, limit = profile(pieces), MOST[kind]
        print_profile(kind, pieces, found)
        if found.median > limit.median or found.high > limit.high:
            broken.append(f"{kind} of src: at most median {limit.median:g}, 90th percentile {limit.high:g} allowed")
    contents = folder_contents(ROOT / "src" / TOP)
    print_contents(contents)
    broken += over_ceilings(contents, ceilings(ROOT / "pyproject.toml"))
    broken += [f"{folder} has {count} Python files, at most {MAX_FILES} allowed" for folder, count in too_full(ROOT)]
    for each in broken:
        print(f"too long: {each}", file=sys.stderr)
    return 1 if broken else 0


def _lines(nodes: Iterable[ast.stmt]) -> set[int]:
    """Return the numbers of the lines that *nodes* take up."""
    return {number for node in nodes for number in range(node.lineno, (node.end_lineno or node.lineno) + 1)}


def folder_contents(source: Path) -> dict[str, Content]:
    """Return what each folder directly below *source* consists of, and at `TOP` the files beside the folders."""
    found: dict[str, Content] = {}
    for path in sorted(source.rglob("*.py")):
        parts = path.relative_to(source).parts
        folder = parts[0] if len(parts) > 1 else TOP
        found[folder] = Content.of(path.read_text(encoding="utf-8")).plus(found.get(folder, Content(0, 0, 0)))
    return found


def ceilings(project: Path) -> dict[str, int]:
    """Return the most statements of each folder, by the project's file."""
    table: dict[str, int] = tomllib.loads(project.read_text(encoding="utf-8"))["tool"]["size_report"]["statements"]
    return table


def over_ceilings(contents: dict[str, Content], most: dict[str, int]) -> list[str]:
    """Return a sentence for each folder that has more statements than its ceiling, has none, or is not there."""
    told = [
        f"src/{TOP}/{folder} has {found.statements} statements, its ceiling is {most[folder]}: {RAISING}"
        for folder, found in contents.items()
        if folder in most and found.statements > most[folder]
    ]
    told += [f"src/{TOP}/{folder} has no ceiling of statements: {RAISING}" for folder in contents if folder not in most]
    return told + [f"pyproject.toml has a ceiling of {folder}: no such folder" for folder in most.keys() - contents]


def print_contents(contents: dict[str, Content]) -> None:
    """Print the sums, and the statements of each folder."""
    every = Content(0, 0, 0)
    for each in contents.values():
        every = every.plus(each)
    print(f"src: {every.statements} statements, {every.code} lines of code, {every.imports} lines of imports")
    for folder, found in sorted(contents.items(), key=lambda item: -item[1].statements):
        print(f"  {found.statements:5d}  {folder}")


def too_full(root: Path) -> list[tuple[str, int]]:
    """Return the folders with more than `MAX_FILES` Python files, and how many each has."""
    paths = (path for name in FOLDERS for path in (root / name).rglob("*.py"))
    counts = Counter(str(path.parent.relative_to(root)) for path in paths)
    return sorted((folder, count) for folder, count in counts.items() if count > MAX_FILES)


def measure(source: Path) -> tuple[list[Piece], list[Piece]]:
    """Return the files and the functions under ``source``."""
    files, functions = [], []
    for path in sorted(source.rglob("*.py")):
        text, name = path.read_text(encoding="utf-8"), str(path.relative_to(source))
        limit = MAX_KERNEL_LINES if "kernels" in path.parts else MAX_FUNCTION_LINES
        files.append(Piece(len(text.splitlines()), MAX_FILE_LINES, name))
        functions += [Piece(body_lines(node), limit, f"{name}:{node.lineno} {node.name}") for node in walk(text)]
    return files, functions


def walk(text: str) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    """Yield all functions of a source text, nested ones and methods too."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node


def body_lines(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Return the length of a function from ``def`` to its end, without its docstring."""
    assert node.end_lineno is not None
    lines = node.end_lineno - node.lineno + 1
    if ast.get_docstring(node, clean=False) is not None:
        first = node.body[0]
        assert first.end_lineno is not None
        lines -= first.end_lineno - first.lineno + 1
    return lines


def profile(pieces: list[Piece]) -> Profile:
    """Return median and 90th percentile."""
    lengths = [piece.lines for piece in pieces]
    return Profile(median(lengths), quantiles(lengths, n=10, method="inclusive")[-1])


def print_profile(kind: str, pieces: list[Piece], found: Profile) -> None:
    """Print number, median, 90th percentile and the largest."""
    lines = sum(piece.lines for piece in pieces)
    print(f"{kind}: {len(pieces)}, {lines} lines, median {found.median:g}, 90th percentile {found.high:g}")
    for piece in sorted(pieces, reverse=True)[:SHOWN]:
        print(f"  {piece.lines:4d}  {piece.name}")


if __name__ == "__main__":
    sys.exit(main())
