"""Draw help texts and docstrings at random for a fresh reader: ``tools/writing/draw_texts.py [SEED] [ROOT]``.

40 texts of options and arguments, and 40 docstrings of public functions and classes, from the sources below *root*
(default: this repository). The same seed draws the same texts of the same sources.
"""

from __future__ import annotations

import ast
import random
import sys
from collections.abc import Iterator
from pathlib import Path

COUNT = 40


def main(arguments: list[str]) -> None:
    """Print what is drawn."""
    seed = int(arguments[0]) if arguments else 20
    root = Path(arguments[1]) if len(arguments) > 1 else Path(__file__).resolve().parents[2]
    files = sorted((root / "src" / "cablewright").rglob("*.py"))
    trees = {file.relative_to(root): ast.parse(file.read_text(encoding="utf-8")) for file in files}
    draw = random.Random(seed)
    for title, texts in (("help texts", sorted(_helps(trees))), ("docstrings", sorted(_docstrings(trees)))):
        print(f"{COUNT} of {len(texts)} {title}")
        for where, text in draw.sample(texts, COUNT):
            print(f"  {where}: {' '.join(text.split())}")


def _helps(trees: dict[Path, ast.Module]) -> Iterator[tuple[str, str]]:
    """Option or metavar, and help, of each ``typer.Option`` and ``typer.Argument``."""
    for file, tree in trees.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and ast.unparse(node.func) in ("typer.Option", "typer.Argument"):
                given = {each.arg: _text(each.value) for each in node.keywords if each.arg in ("help", "metavar")}
                names = [_text(each) for each in node.args] or [given.get("metavar", "")]
                if "help" in given:
                    yield f"{file.stem} {names[0]}", given["help"]


def _text(node: ast.expr) -> str:
    """A text as it is written in the source; an f-string with its braces."""
    return str(node.value) if isinstance(node, ast.Constant) else ast.unparse(node)


def _docstrings(trees: dict[Path, ast.Module]) -> Iterator[tuple[str, str]]:
    """Name and docstring of each public function and class."""
    for file, tree in trees.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
                text = ast.get_docstring(node)
                if text:
                    yield f"{file.with_suffix('').as_posix().removeprefix('src/cablewright/')}.{node.name}", text


if __name__ == "__main__":
    main(sys.argv[1:])
