"""Find the banned words of ``tools/words.toml`` in README, docs, ``src`` and tests; fail if a file has more.

``tools/writing/words_ceilings.json`` holds the ceiling of each file; a file without an entry has the ceiling 0.

* ``python tools/writing/words.py`` compares the counts with the ceilings.
* ``--list [FILE ..]`` shows each banned word with its line and the replacement.
* ``--write`` lowers the ceilings to the present counts. Without a file of ceilings it writes a new one.

The search covers Markdown without code and links; comments, docstrings, texts with a space, file names and test names
of Python, without names of parameters; comments of TOML; comments and texts with a space of pages and scripts of the
browser.
"""

from __future__ import annotations

import io
import json
import re
import sys
import tokenize
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
CEILINGS = Path(__file__).with_name("words_ceilings.json")
SEARCHED = ("README.md", "docs", "src", "tests")
SUFFIXES = {".md", ".py", ".toml", ".html", ".js"}
SHOWN = 10
TEXTS = {tokenize.COMMENT, tokenize.STRING, getattr(tokenize, "FSTRING_MIDDLE", tokenize.STRING)}
CODE = re.compile(r"^(`{3,}).*?^\1|`+[^`]+`+|(?<=\])\([^)]*\)|^:::.*$", re.MULTILINE | re.DOTALL)

OF_SCRIPTS = re.compile(r"//[^\n]*|/\*.*?\*/|\"(?:[^\"\\\n]|\\.)*\"|'(?:[^'\\\n]|\\.)*'|`(?:[^`\\]|\\.)*`", re.DOTALL)
OF_PAGES = re.compile(r'(?<=>)[^<>]+(?=<)|(?<==)"[^"]*"')
PARAMETER = re.compile(r"(?<![\w*])\*\w+\*(?![\w*])")
INSERTED = re.compile(r"\{[^{}]*\}")


class Found(NamedTuple):
    """A banned word, the line it stands in, and what to write instead."""

    line: int
    word: str
    instead: str


class Words:
    """The banned words, and the files that are exempt."""

    def __init__(self, file: Path) -> None:
        table = tomllib.loads(file.read_text(encoding="utf-8"))
        self.instead = list(table["banned"].values())
        self.pattern = re.compile(
            "|".join(rf"(\b(?:{each})\b)" for each in map(_closed, table["banned"])), re.IGNORECASE
        )
        self.files: list[str] = table["exempt"]["files"]
        self.folders: list[str] = table["exempt"]["folders"]

    def files_below(self, root: Path) -> Iterator[Path]:
        """Yield the files to search."""
        for name in SEARCHED:
            path = root / name
            for each in sorted(path.rglob("*")) if path.is_dir() else [path]:
                own = each.relative_to(root).as_posix()
                exempt = own in self.files or own.startswith(tuple(f"{folder}/" for folder in self.folders))
                if each.suffix in SUFFIXES and each.is_file() and not exempt:
                    yield each

    def found_in(self, path: Path) -> list[Found]:
        """Return the banned words of a file in their order."""
        found = []
        for line, text in pieces(path):
            for hit in self.pattern.finditer(text):
                assert hit.lastindex is not None
                before = text.count("\n", 0, hit.start())
                found.append(Found(line + before, " ".join(hit[0].split()), self.instead[hit.lastindex - 1]))
        return found


def _closed(pattern: str) -> str:
    """Return a pattern whose groups are not counted and whose spaces may be line ends."""
    return re.sub(r"\((?!\?)", "(?:", pattern).replace(" ", r"\s+")


def pieces(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the texts of a file that are read by people, each with the number of its first line."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        yield 1, path.stem.replace("_", " ")
        yield from _of_python(text)
    elif path.suffix == ".toml":
        yield from ((at, line.partition("#")[2]) for at, line in enumerate(text.splitlines(), 1) if "#" in line)
    elif path.suffix == ".md":
        yield 1, CODE.sub(_blank, text)
    else:
        for found in (OF_SCRIPTS if path.suffix == ".js" else OF_PAGES).finditer(text):
            if " " in found[0].strip():
                yield text.count("\n", 0, found.start()) + 1, INSERTED.sub(" value", found[0])


def _of_python(text: str) -> Iterator[tuple[int, str]]:
    before = ""
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type in TEXTS and " " in token.string:
            text = INSERTED.sub(" value", token.string) if token.string[0] in "fF" else token.string
            yield token.start[0], PARAMETER.sub("code", CODE.sub(_blank, text))
        elif token.type == tokenize.NAME and before == "def" and token.string.startswith("test_"):
            yield token.start[0], token.string.replace("_", " ")
        before = token.string


def _blank(code: re.Match[str]) -> str:
    """Return as many lines as the code has."""
    return " code" + "\n" * code[0].count("\n")


def main(arguments: list[str]) -> int:
    """Compare with the ceilings, list, or lower the ceilings."""
    words = Words(ROOT / "tools" / "words.toml")
    chosen = [Path(each).resolve() for each in arguments if not each.startswith("--")]
    found = {path.relative_to(ROOT).as_posix(): words.found_in(path) for path in chosen or words.files_below(ROOT)}
    if "--list" in arguments:
        for name, hits in found.items():
            for hit in hits:
                print(f"{name}:{hit.line}: {hit.word!r}: {hit.instead}")
        return 0
    counts = {name: len(hits) for name, hits in found.items() if hits}
    kept: dict[str, int] = json.loads(CEILINGS.read_text(encoding="utf-8")) if CEILINGS.exists() else counts
    if "--write" in arguments:
        kept = {name: min(counts[name], most) for name, most in kept.items() if name in counts}
        CEILINGS.write_text(json.dumps(kept, indent=0, sort_keys=True) + "\n", encoding="utf-8")
    print(f"banned words: {sum(counts.values())} in {len(counts)} files; ceilings: {sum(kept.values())}")
    for name, count in sorted(counts.items(), key=lambda item: -item[1])[:SHOWN]:
        print(f"  {count:4d}  {name}")
    over = over_ceilings(counts, kept)
    for each in over:
        print(f"banned words: {each}", file=sys.stderr)
    return 1 if over else 0


def over_ceilings(counts: dict[str, int], ceilings: dict[str, int]) -> list[str]:
    """Return a sentence for each file that has more banned words than its ceiling."""
    return [
        f"{name} has {count}, its ceiling is {ceilings.get(name, 0)}: see python tools/writing/words.py --list {name}"
        for name, count in counts.items()
        if count > ceilings.get(name, 0)
    ]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
