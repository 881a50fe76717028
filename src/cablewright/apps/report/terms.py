"""The terms that a page uses, explained at its end; the first use of each is a link there."""

from __future__ import annotations

import re
from collections.abc import Iterable

from cablewright.apps.glossary import GLOSSARY, Term
from cablewright.apps.report.page import Html, element, join, section

TERMS = {term.name.lower(): term for terms in GLOSSARY.values() for term in terms}
_NAMES = re.compile(r"\b(" + "|".join(sorted(map(re.escape, TERMS), key=len, reverse=True)) + r")s?\b", re.IGNORECASE)
_TAG = re.compile(r"(<[^>]*>)")
_CLOSED = ("h1", "h2", "a", "strong", "script", "svg", "summary")  # in which nothing is linked


def with_terms(body: Iterable[Html]) -> list[Html]:
    """Return the parts of a page, the terms in them linked, and a section that explains these terms."""
    used: dict[str, Term] = {}
    parts = [_linked(part, used) for part in body]
    rows = [_explained(used[name]) for name in sorted(used)]
    return [*parts, section("Terms", element("dl", *rows, class_="terms"))] if rows else parts


def _explained(term: Term) -> Html:
    name = f"{term.name}, {term.symbol}" if term.symbol else term.name
    return join([element("dt", name, id=_anchor(term)), element("dd", f"{term.meaning}.")])


def _linked(part: Html, used: dict[str, Term]) -> Html:
    """The part with links from terms that are not in *used* yet, which are added there."""
    pieces, within = _TAG.split(part), ""
    for k, piece in enumerate(pieces):
        tag = re.match(r"</?(\w+)", piece)
        if tag and tag[1] in _CLOSED:
            within = "" if piece.startswith("</") else tag[1]
        elif not (tag or within):
            pieces[k] = _NAMES.sub(lambda found: _link(found[0], found[1].lower(), used), piece)
    return Html("".join(pieces))


def _link(text: str, name: str, used: dict[str, Term]) -> str:
    term = TERMS.get(name)
    if term is None or name in used:
        return text
    used[name] = term
    return element("a", text, href=f"#{_anchor(term)}")


def _anchor(term: Term) -> str:
    return "term-" + re.sub(r"\W+", "-", term.name)
