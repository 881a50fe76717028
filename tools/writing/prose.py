"""Print the length of sentences and the share of passive ones by page: ``python tools/writing/prose.py [PAGE ..]``.

Without arguments: README.md and the hand-written pages of ``docs/``. A sentence is a part of a paragraph or list item
that ends with ``.``, ``!``, ``?`` or ``:`` before a space. Headings, tables, code and pictures have no sentences; long
table cells are counted separately. Code in backticks is one word. A sentence counts as passive if a form of *be* or
*get* precedes a past participle, with at most two adverbs between them: a word in *-ed*, or one of `PARTICIPLES`.
This heuristic counts "is tired" and misses "the cable held by the winch". It compares pages only.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from statistics import median, quantiles
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
GENERATED = {f"{each.stem}.md" for each in (ROOT / "tools" / "pages").glob("*.py")}  # by the tool of that name
LONG = 25  # words
LIMITS = "median <= 14, 95th percentile <= 26, over 25 words <= 5 %, passive <= 15 %"
PARTICIPLES = (
    "beaten bent bound bought broken brought built burnt caught chosen cut dealt done drawn driven eaten fallen "
    "fed felt found given gone got grown heard held hidden hit hung kept known laid lain led left lent let lost "
    "made meant measured met paid proven put read run said seen sent set shaken shot shown shut sold spent split "
    "spread spun stood strung stuck struck sunk swung taken taught thought thrown told torn understood unwound "
    "woken won worn wound written "
)
PASSIVE = re.compile(
    r"\b(?:is|are|was|were|be|been|being|gets?|got)\s+"
    r"(?:(?:not|never|also|then|thus|only|still|always|often|once|\w+ly)\s+)"
    rf"{{0,2}}(?:\w{{2,}}ed|{'|'.join(PARTICIPLES.split())})\b",
    re.IGNORECASE,
)
BLOCK = re.compile(r"^(`{3,}|~{3,}).*?^\1[^\n]*$|<!--.*?-->|^---\n.*?^---$", re.MULTILINE | re.DOTALL)
END = re.compile(r"(?<=[.!?:])[)\"”*_]*\s+(?=[\"“(*_`A-Z0-9\[])")
ABBREVIATIONS = re.compile(r"\b(e\.g|i\.e|cf|vs|Fig|Eq|No|Dr|approx|max|min)\.")


class Prose(NamedTuple):
    """Sentences of a page by number and length, in words; shares are between 0 and 1."""

    words: int
    sentences: int
    median: float
    high: float
    long: float
    passive: float
    long_cells: int


def main(names: list[str]) -> int:
    """Print a line for each page, and one for all."""
    pages = [Path(name).resolve() for name in names] or hand_written()
    print(f"limits: {LIMITS}")
    print("page                                words sentences median   p95   >25 passive long cells")
    texts = [page.read_text(encoding="utf-8") for page in pages]
    for name, text in [(str(page.relative_to(ROOT)), text) for page, text in zip(pages, texts, strict=True)]:
        print_line(name, prose(text))
    if len(texts) > 1:
        print_line(f"all {len(texts)}", prose("\n\n".join(texts)))
    return 0


def print_line(name: str, found: Prose) -> None:
    """Print the figures of one page."""
    print(
        f"{name:34s} {found.words:6d} {found.sentences:9d} {found.median:6.0f} {found.high:5.0f} "
        f"{found.long:5.0%} {found.passive:7.0%} {found.long_cells:10d}"
    )


def hand_written() -> list[Path]:
    """Return README.md and the pages of docs/ that no tool writes, without the records of decisions."""
    docs = (page for page in sorted((ROOT / "docs").rglob("*.md")) if page.parent.name != "decisions")
    return [ROOT / "README.md", *(page for page in docs if page.name not in GENERATED)]


def prose(text: str) -> Prose:
    """Return the figures of a text in Markdown. ``words`` counts all of it, code and tables too, as ``wc -w`` does."""
    lengths = [len(sentence.split()) for sentence in sentences(text)]
    passive = sum(bool(PASSIVE.search(sentence)) for sentence in sentences(text))
    cells = [len(cell.split()) for line in text.splitlines() if line.startswith("|") for cell in line.split("|")]
    number = max(1, len(lengths))
    high = quantiles(lengths, n=20, method="inclusive")[-1] if len(lengths) > 1 else sum(lengths)
    return Prose(
        words=len(text.split()),
        sentences=len(lengths),
        median=median(lengths or [0]),
        high=high,
        long=sum(length > LONG for length in lengths) / number,
        passive=passive / number,
        long_cells=sum(length > LONG for length in cells),
    )


def sentences(text: str) -> list[str]:
    """Return the sentences of the paragraphs and list items, of two words at least."""
    found = []
    for paragraph in paragraphs(text):
        whole = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", paragraph)
        whole = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", whole)
        whole = ABBREVIATIONS.sub(r"\1", re.sub(r"(`+).+?\1", "Code", whole))
        found += [each.strip() for each in END.split(whole) if len(each.split()) > 1]
    return found


def paragraphs(text: str) -> list[str]:
    """Return paragraphs and list items as one line each; no heading, table, block of code, formula or HTML."""
    found: list[str] = []
    current: list[str] = []
    for line in [*BLOCK.sub("\n", text).splitlines(), ""]:
        plain = line.strip()
        item = re.match(r"(?:[*+-]|\d+\.)\s+(.*)", plain)
        if not plain or item or plain.startswith(("#", "|", "<", ":::", "!!!", "$$", "![")):
            found += [" ".join(current)] * bool(current)
            current = [item[1]] if item else []
        else:
            current.append(plain)
    return found


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
