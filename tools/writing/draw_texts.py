"""Draw texts at random for a fresh reader: ``python -m tools.writing.draw_texts [SEED] [ROOT]``.

Of each of five kinds 56: texts of options and arguments, docstrings of public functions and classes, names of files,
sentences of hand-written pages, and messages of errors and notes, from the sources below *root* (default: this
repository). The same seed draws the same texts of the same sources. The line after a text says where it is.
"""

from __future__ import annotations

import ast
import random
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tools.writing.prose import END, GENERATED, paragraphs

COUNT = 56
_SAYING = ("InputError", "EnvironmentFault", "AnswerError", "ValueError", "tell")


def main(arguments: list[str]) -> None:
    """Print what is drawn."""
    seed = int(arguments[0]) if arguments else 20
    root = Path(arguments[1]) if len(arguments) > 1 else Path(__file__).resolve().parents[2]
    files = sorted((root / "src" / "cablewright").rglob("*.py"))
    trees = {file.relative_to(root): ast.parse(file.read_text(encoding="utf-8")) for file in files}
    draw = random.Random(seed)
    kinds = {
        "help texts": _helps(trees),
        "docstrings": _docstrings(trees),
        "names of files": ((str(file), f"{file.parent.name}/{file.stem}") for file in trees if file.stem != "__init__"),
        "sentences": _sentences(root / "docs"),
        "messages": _messages(trees),
    }
    for title, texts in kinds.items():
        found = sorted(set(texts))
        count = min(COUNT, len(found))
        print(f"# {count} of {len(found)} {title}")
        for number, (where, text) in enumerate(draw.sample(found, count), 1):
            print(f"{number}. {' '.join(text.split())}\n    in {where}")


def _helps(trees: dict[Path, ast.Module]) -> Iterator[tuple[str, str]]:
    """Option or metavar, and help, of each ``typer.Option`` and ``typer.Argument``."""
    for file, tree in trees.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and ast.unparse(node.func) in ("typer.Option", "typer.Argument"):
                given = {each.arg: _text(each.value) for each in node.keywords if each.arg in ("help", "metavar")}
                names = [_text(each) for each in node.args] or [given.get("metavar", "")]
                if "help" in given:
                    yield f"{file.stem} {names[0]}", given["help"]


def _text(node: Any) -> str:
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


def _sentences(docs: Path) -> Iterator[tuple[str, str]]:
    """Sentences of hand-written pages, as they are written."""
    for page in sorted(docs.rglob("*.md")):
        if page.parent.name != "decisions" and page.name not in GENERATED:
            for paragraph in paragraphs(page.read_text(encoding="utf-8")):
                for sentence in END.split(re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", paragraph)):
                    if len(sentence.split()) > 2:
                        yield str(page.relative_to(docs)), sentence


def _messages(trees: dict[Path, ast.Module]) -> Iterator[tuple[str, str]]:
    """Texts of errors that are raised and of notes that are printed."""
    for file, tree in trees.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and ast.unparse(node.func).rpartition(".")[2] in _SAYING:
                text = node.args[0] if node.args else None
                if isinstance(text, ast.JoinedStr) or isinstance(getattr(text, "value", None), str):
                    yield f"{file}:{node.lineno}", _text(text)


if __name__ == "__main__":
    main(sys.argv[1:])
