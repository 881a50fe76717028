"""Regular expressions of src take a time in proportion to the text, also of a hostile one.

A text that each pattern matches is made from its syntax tree. One character is repeated at each place, and the end
spoilt, so that the pattern backtracks. With the repetitions of this test linear time is some microseconds, quadratic
and cubic time many times the allowed one, which is the processor's, not the clock's.
"""

from __future__ import annotations

import ast
import importlib
import pkgutil
import re
import re._constants as code
import re._parser as parser
import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

import cablewright

FEW, MANY = 300, 2500
ALLOWED = 0.004  # s of the processor for a text; a linear pattern takes under 1 ms
METHODS = ("fullmatch", "match", "search", "sub", "subn", "split", "findall", "finditer")
FILL = " \t1a_.,-=:*;#([{\"'\\"
SPOILERS = ("", "\x00", "#")


def strings(tree) -> list[str]:
    """Texts that a parsed pattern matches, at least nearly: one for each branch."""
    found = [""]
    for kind, of in tree:
        found = [text + more for text in found[:12] for more in pieces(kind, of)[:4]]
    return found


def pieces(kind, of) -> list[str]:
    if kind in (code.LITERAL, code.NOT_LITERAL):
        return [chr(of) if kind is code.LITERAL else "a"]
    if kind is code.ANY:
        return ["a"]
    if kind is code.IN:
        return [member(of)]
    if kind is code.SUBPATTERN:
        return strings(of[-1])
    if kind is code.BRANCH:
        return [strings(branch)[0] for branch in of[1]]
    if kind in (code.MAX_REPEAT, code.MIN_REPEAT, code.POSSESSIVE_REPEAT):
        return [text * max(of[0], 1) for text in strings(of[2])]
    if kind is code.ATOMIC_GROUP:
        return strings(of)
    return [""]  # positions, assertions and references


def member(of) -> str:
    """A character of a set."""
    if of[0][0] is code.NEGATE:
        return next(each for each in "aA1 ~" if not any(holds(part, each) for part in of[1:]))
    kind, value = of[0]
    if kind is code.LITERAL:
        return chr(value)
    return chr(value[0]) if kind is code.RANGE else next(each for each in "1 a~" if holds(of[0], each))


def holds(part, each: str) -> bool:
    return re.fullmatch(sre_text(part), each) is not None


def sre_text(part) -> str:
    kind, value = part
    if kind is code.LITERAL:
        return re.escape(chr(value))
    if kind is code.RANGE:
        return f"[{re.escape(chr(value[0]))}-{re.escape(chr(value[1]))}]"
    return {
        code.CATEGORY_DIGIT: r"\d", code.CATEGORY_NOT_DIGIT: r"\D", code.CATEGORY_SPACE: r"\s",
        code.CATEGORY_NOT_SPACE: r"\S", code.CATEGORY_WORD: r"\w", code.CATEGORY_NOT_WORD: r"\W",
    }[value]  # fmt: skip


def hostile(pattern: re.Pattern, count: int) -> Iterator[str]:
    for text in dict.fromkeys(strings(parser.parse(pattern.pattern, pattern.flags & ~re.UNICODE & ~re.DEBUG))):
        for at in range(min(len(text), 40) + 1):
            for fill in {*FILL, *text[max(at - 1, 0) : at + 1]}:
                for spoiler in SPOILERS:
                    yield text[:at] + fill * count + text[at:] + spoiler
                    yield text[:at] + fill * count + spoiler


@dataclass(frozen=True)
class Use:
    """A pattern of a module, and the methods by which its text calls it."""

    where: str
    pattern: re.Pattern
    methods: tuple[str, ...]

    def seconds(self, text: str | bytes) -> float:
        """The processor's time of all methods on a text."""
        start = time.process_time()
        for method in self.methods:
            call = getattr(self.pattern, method)
            if method == "finditer":
                deque(call(text), maxlen=0)
            elif method in ("sub", "subn"):
                call(text[:0], text)
            else:
                call(text)
        return time.process_time() - start

    def slow(self) -> str | None:
        """A text that takes too long, None without one: few repetitions first, so that cubic ones end, too."""
        for count in (FEW, MANY):
            for text in hostile(self.pattern, count):
                given = text.encode("utf-8", "replace") if isinstance(self.pattern.pattern, bytes) else text
                if self.seconds(given) > ALLOWED and min(self.seconds(given) for _ in range(3)) > ALLOWED:
                    return f"{text[:30]!r}.. of {len(text)} characters"
        return None


def named(name: str) -> Iterator[Use]:
    """The compiled patterns of a module."""
    try:
        module = importlib.import_module(name)
    except ImportError:
        return  # of an extra that is not installed
    source = Path(module.__file__ or "").read_text(encoding="utf-8")
    for key, value in vars(module).items():
        held = value.values() if isinstance(value, dict) else value if isinstance(value, tuple | list) else (value,)
        of_key = [each for each in METHODS if f"{key}.{each}" in source]
        methods = tuple(of_key or ("match",))
        for at, each in enumerate(held):
            if isinstance(each, re.Pattern) and (key in source):
                yield Use(f"{name}.{key}[{at}]", each, methods)


def inline(path: Path) -> Iterator[Use]:
    """The patterns that a file gives to functions of `re`."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in METHODS:
            of, first = node.func.value, (node.args or [None])[0]
            if isinstance(of, ast.Name) and of.id == "re" and isinstance(first, ast.Constant):
                yield Use(f"{path.name}:{node.lineno}", re.compile(first.value), (node.func.attr,))


def uses() -> list[Use]:
    modules = [each.name for each in pkgutil.walk_packages(cablewright.__path__, "cablewright.")]
    compiled = [use for name in modules for use in named(name)]
    return compiled + [use for path in sorted(Path(cablewright.__path__[0]).rglob("*.py")) for use in inline(path)]


def test_patterns_take_linear_time() -> None:
    found = uses()
    assert len(found) > 50
    slow = {use.where: use.slow() for use in found}
    assert {where: text for where, text in slow.items() if text} == {}


@pytest.mark.parametrize(
    ("pattern", "method"),
    [
        (r"\[\s*([^\]]+?)\s*\]\s*(?:[#;].*)?", "fullmatch"),
        (r"([A-Za-z0-9_]+)\s*[:=]\s*([^#;]*?)\s*(?:[#;].*)?", "fullmatch"),
        (r"( *(?:- )?)([A-Za-z_][\w-]*) *:(?:\s+([^#]*?))?\s*(?:#.*)?", "fullmatch"),
        (r"[0-9]+\.?[0-9]*", "fullmatch"),
        (r"\s+$", "search"),
    ],
)
def test_slow_patterns_are_found(pattern: str, method: str) -> None:
    assert Use("here", re.compile(pattern), (method,)).slow() is not None
