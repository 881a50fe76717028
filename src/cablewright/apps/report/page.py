"""One self-contained HTML page, without outside requests. Any text that is not `Html` is escaped."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterable, Sequence
from html import escape
from importlib import resources
from typing import Final

_ONE_LINE: Final = 24  # characters
_FEW_COLUMNS: Final = 4  # that fit a phone
_DARK: Final = "screen and (prefers-color-scheme: dark)"


Themed = tuple[bytes, bytes]  # a picture as PNG files, for a light and for a dark page


class Html(str):
    """Text that is HTML markup already."""

    __slots__ = ()


def element(name: str, *content: str, **attributes: str) -> Html:
    """Return an HTML element; a trailing underscore of an attribute's name is dropped, as in ``class_``."""
    spelled = "".join(f' {key.rstrip("_").replace("_", "-")}="{escape(value)}"' for key, value in attributes.items())
    return Html(f"<{name}{spelled}>{join(content)}</{name}>")


def join(parts: Iterable[str], between: str = "") -> Html:
    """Return HTML of parts one after the other; plain text is escaped."""
    return Html(between.join(part if isinstance(part, Html) else escape(part) for part in parts))


def section(title: str, *content: str) -> Html:
    """Return an HTML section under a heading."""
    return element("section", element("h2", title), *content)


def table(head: Sequence[str], rows: Iterable[Sequence[str]], *, numbers: Sequence[int] = ()) -> Html:
    """Return an HTML table; the columns in ``numbers`` are set flush right."""

    def cell(kind: str, at: int, content: str) -> Html:
        short = at in numbers and (isinstance(content, Html) or len(content) <= _ONE_LINE)
        return element(kind, content, class_="number") if short else element(kind, content)

    top = element("tr", *(cell("th", at, name) for at, name in enumerate(head)))
    body = [element("tr", *(cell("td", at, value) for at, value in enumerate(row))) for row in rows]
    wide = "wide many" if len(head) > _FEW_COLUMNS else "wide"
    made = element("table", element("thead", top), element("tbody", *body))
    return element("div", made, class_=wide, tabindex="0", role="region", aria_label=", ".join(head))


def notice(text: str) -> Html:
    """Return the HTML of a caution on figures, as a sentence."""
    return element("p", f"{text[:1].upper()}{text[1:]}.", class_="notice")


def short_name(name: str) -> str:
    """Return HTML that keeps a short name on one line."""
    return element("span", name, class_="keep") if len(name) <= _ONE_LINE else name


def cards(figures: Iterable[tuple[str, str, str]]) -> Html:
    """Return the HTML of cards of key figures: name, value, and a note that may be empty."""
    shown = [
        element("div", element("dt", what), element("dd", value, element("small", note)), class_="card")
        for what, value, note in figures
    ]
    return element("dl", *shown, class_="cards")


def picture(drawn: Themed, told: str, caption: str) -> Html:
    """Return a picture that is part of the page, light or dark as the page; ``told``: its text for screen readers."""
    light, dark = (f"data:image/png;base64,{base64.b64encode(png).decode('ascii')}" for png in drawn)
    images = f'<source srcset="{dark}" media="{_DARK}"><img src="{light}" alt="{escape(told)}">'
    return element("figure", element("picture", Html(images)), element("figcaption", caption))


def bundled(name: str) -> str:
    """Return the text of a file of this Python package, such as a style sheet."""
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")


def page(title: str, body: Iterable[Html], script: str = "", style: str = "") -> str:
    """Return the whole HTML document. Its policy forbids all requests, and scripts and styles but its own.

    *style*: rules that come after those of all pages.
    """
    css = bundled("page.css") + style
    policy = f"default-src 'none'; img-src data:; style-src {_hash(css)}; script-src {_hash(script)}"
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        f"<title>{escape(title)}</title>\n<style>{css}</style>\n</head>\n<body>\n<main>\n"
        + "\n".join(body)
        + f"\n</main>\n<script>{script}</script>\n</body>\n</html>\n"
    )


def _hash(text: str) -> str:
    """Return what a content security policy calls this very text."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
