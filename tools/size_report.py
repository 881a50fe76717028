"""Print how long the files and functions of ``src/`` are; fail where one, or most, are longer than a reader can hold.

A folder may be too full as well, in the tests and the examples too.
"""

from __future__ import annotations

import ast
import sys
from collections import Counter
from collections.abc import Iterator
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


class Piece(NamedTuple):
    """A file or function, its length in lines and the most it may have."""

    lines: int
    limit: int
    name: str


class Profile(NamedTuple):
    """Median and 90th percentile of lengths, in lines: what they are, or the most they may be."""

    median: float
    high: float


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
    broken += [f"{folder} has {count} Python files, at most {MAX_FILES} allowed" for folder, count in too_full(ROOT)]
    for each in broken:
        print(f"too long: {each}", file=sys.stderr)
    return 1 if broken else 0


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
