"""Terms of a page: each is explained once, at its end, and its first use is a link there."""

from __future__ import annotations

import re

from cablewright.apps.glossary import GLOSSARY
from cablewright.apps.report.document import with_terms
from cablewright.apps.report.page import Html, element


def test_the_first_use_is_a_link_that_resolves() -> None:
    body = [element("p", "Two lines leave their exit points."), element("p", "A line is taut; the NEES is 3.")]
    page = "".join(with_terms(body))
    links, anchors = re.findall(r'href="#([^"]+)"', page), re.findall(r' id="([^"]+)"', page)
    assert sorted(links) == sorted(anchors) == ["term-NEES", "term-exit-point", "term-line"]
    assert page.startswith(
        '<p>Two <a href="#term-line">lines</a> leave their <a href="#term-exit-point">exit points</a>.'
    )


def test_titles_links_and_attributes_stay() -> None:
    body = [element("h1", "A line"), Html('<img src="data:image/png;base64,error" alt="line"><a href="#x">line</a>')]
    assert with_terms(body) == body


def test_every_term_ends_without_a_full_stop_and_stands_once() -> None:
    terms = [term for each in GLOSSARY.values() for term in each]
    assert all(term.meaning and not term.meaning.endswith(".") for term in terms)
    assert len({term.name.lower() for term in terms}) == len(terms)
