"""Print how long the files and functions of ``src/`` are, and fail where one is longer than a reader can hold."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path
from statistics import median, quantiles
from typing import NamedTuple

SOURCE = Path(__file__).resolve().parent.parent / "src"
MOST_FILE_LINES = 460
MOST_FUNCTION_LINES = 70
MOST_KERNEL_LINES = 110  # a kernel repeats its arithmetic inline where a call would cost an allocation
SHOWN = 5


class Piece(NamedTuple):
    """A file or function, its length in lines and the most it may have."""

    lines: int
    most: int
    name: str


def main() -> int:
    """Print the report; return 1 if a cap is broken."""
    files, functions = measure(SOURCE)
    for kind, pieces in (("files", files), ("functions", functions)):
        print_profile(kind, pieces)
    broken = [piece for piece in (*files, *functions) if piece.lines > piece.most]
    for piece in broken:
        print(f"too long: {piece.name} has {piece.lines} lines, at most {piece.most} allowed", file=sys.stderr)
    return 1 if broken else 0


def measure(source: Path) -> tuple[list[Piece], list[Piece]]:
    """Return the files and the functions under ``source``."""
    files, functions = [], []
    for path in sorted(source.rglob("*.py")):
        text, name = path.read_text(encoding="utf-8"), str(path.relative_to(source))
        most = MOST_KERNEL_LINES if "kernels" in path.parts else MOST_FUNCTION_LINES
        files.append(Piece(len(text.splitlines()), MOST_FILE_LINES, name))
        functions += [Piece(body_lines(node), most, f"{name}:{node.lineno} {node.name}") for node in walk(text)]
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


def print_profile(kind: str, pieces: list[Piece]) -> None:
    """Print number, median, 90th percentile and the largest."""
    if len(pieces) < 2:
        return
    lengths = [piece.lines for piece in pieces]
    high = quantiles(lengths, n=10, method="inclusive")[-1]
    print(f"{kind}: {len(pieces)}, {sum(lengths)} lines, median {median(lengths):g}, 90th percentile {high:g}")
    for piece in sorted(pieces, reverse=True)[:SHOWN]:
        print(f"  {piece.lines:4d}  {piece.name}")


if __name__ == "__main__":
    sys.exit(main())
