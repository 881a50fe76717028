"""A whole report page: verdict, terms explained at its end, 3-D views with their program, pictures."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from importlib import resources
from pathlib import Path
from typing import Final

from cablewright.apps.glossary import GLOSSARY, Term
from cablewright.apps.report.page import Html, Themed, element, join, page, section
from cablewright.apps.web.scene import SceneDescription
from cablewright.apps.web.svg_scene import svg
from cablewright.foundation.file_output import write_whole

HELP: Final = (
    "Drag to turn, with shift or the right button to move; click it and roll the wheel to zoom; hover over a line or "
    "the path for figures. With fingers: one sideways turns, two move and zoom. Keys: arrows turn, with shift they "
    "move; + and \N{MINUS SIGN} zoom; 0 all; 1, 2, 3 front, side, top; space plays; comma and full stop step; [ and ] "
    "change the layer."
)


def view(scene: SceneDescription, name: str = "scene") -> Html:
    """Return the HTML of a 3-D view of a scene; *name*: name of its element, unique in a page."""
    data = Html(f'<script type="application/json" id="{name}">{scene.as_json()}</script>')
    inner = [element("div", Html(svg(scene)), class_="stage")]
    inner += [element("p", note, class_="soft") for note in scene.notes]
    inner.append(element("details", element("summary", "How to use the view"), element("p", HELP), class_="help"))
    return element("div", data, *inner, class_="viewer", data_scene=name)


def document(title: str, body: Iterable[Html]) -> str:
    """Return the whole page with the terms of its *body* linked and explained. The same body gives the same text."""
    return page(title, with_terms(body), script(), _of_viewer("viewer.css"))


def write_report(folder: Path, title: str, body: Iterable[Html], pictures: Mapping[str, Themed]) -> Path:
    """Write ``report.html`` and the light *pictures* (PNG, by name) to an existing folder; return the report's path.

    The page holds its pictures and makes no request. Raises `EnvironmentFault` where the folder cannot be written.
    """
    for name, (light, _) in pictures.items():
        write_whole(folder / f"{name}.png", light)
    report = folder / "report.html"
    write_whole(report, document(title, body).encode("utf-8"))
    return report


def verdict(word: str, *sentences: str, kind: str = "") -> Html:
    """Return the verdict as HTML: the answer in a word and in sentences; *kind*: yes, no, doubt or none of these."""
    told = (element("p", each) for each in sentences)
    return element("div", element("strong", word), *told, class_=f"verdict {kind}".strip(), role="status")


def script() -> str:
    """Return the program that draws all views of a page."""
    return _of_viewer("viewer.js")


def _of_viewer(name: str) -> str:
    return resources.files("cablewright.apps.web").joinpath("viewer", name).read_text(encoding="utf-8")


TERMS = {term.name.lower(): term for terms in GLOSSARY.values() for term in terms}
_NAMES = re.compile(r"\b(" + "|".join(sorted(map(re.escape, TERMS), key=len, reverse=True)) + r")s?\b", re.IGNORECASE)
_TAG = re.compile(r"(<[^<>]*>)")
_CLOSED = ("h1", "h2", "a", "strong", "script", "svg", "summary")  # in which nothing is linked


def with_terms(body: Iterable[Html]) -> list[Html]:
    """Return the parts of a page with links from terms to a section that explains them."""
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
