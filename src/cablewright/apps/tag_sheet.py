"""Printable pages of tags, to scale, as SVG or PDF: each tag with number, size and position, and a ruler.

A page is a list of black rectangles and texts, lengths in mm from its top left; both formats are written from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import Final

import numpy as np

from cablewright.calibration.sightings.intrinsics import sheet
from cablewright.calibration.sightings.layout import MODULES, Tag, TagLayout
from cablewright.calibration.sightings.pictures import require_camera_extra
from cablewright.foundation.arrays import Mask
from cablewright.foundation.errors import InputError

PAPERS: Final = {"A4": (210.0, 297.0), "A3": (297.0, 420.0), "A2": (420.0, 594.0), "A1": (594.0, 841.0)}
"""Width and height of a page, mm."""

RULER: Final = 150.0
"""Length of the ruler of each page, mm."""

_EDGE: Final = 8.0  # mm that printers leave white
_FOOT: Final = 26.0  # mm for the ruler
_LINE: Final = 4.5  # mm between lines of text
_POINT: Final = 72.0 / 25.4  # points of a mm


@dataclass
class TagPage:
    """A page of tags: black rectangles x, y, width, height, and texts x, y, size, words; mm from its top left."""

    size: tuple[float, float]
    boxes: list[tuple[float, float, float, float]]
    texts: list[tuple[float, float, float, str]]


def modules_of(number: int) -> Mask:
    """Return the pattern (8, 8) of a tag, True for black. Raises `EnvironmentFault` without OpenCV."""
    require_camera_extra()
    import cv2

    family = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    return np.asarray(np.equal(cv2.aruco.generateImageMarker(family, number, MODULES, borderBits=1), 0))


def pages_of(layout: TagLayout, paper: str = "A4") -> list[TagPage]:
    """Return the pages of a layout: one with all tags in their places for `sheet`, else row by row.

    Raises `InputError` for a tag that is larger than the paper.
    """
    width, height = PAPERS[paper]
    if layout == sheet():
        return [_in_place(layout, paper)]
    pages, x, y, deep = [_page(paper)], _EDGE, _EDGE, 0.0
    for tag in layout.tags:
        side = 1e3 * tag.size
        whole = side * (MODULES + 2) / MODULES
        room = whole, whole + 2.0 * _LINE + 2.0
        if room[0] > width - 2.0 * _EDGE or room[1] > height - 2.0 * _EDGE - _FOOT:
            raise InputError(f"tag {tag.number}: {side:g} mm with its margin is larger than {paper}; give --paper")
        if x + room[0] > width - _EDGE:
            x, y, deep = _EDGE, y + deep, 0.0
        if y + room[1] > height - _EDGE - _FOOT:
            pages.append(_page(paper))
            x, y, deep = _EDGE, _EDGE, 0.0
        _put(pages[-1], tag, x + side / MODULES, y + side / MODULES)
        where = f"on {tag.on}, centre at {_numbers(tag.at)} m"
        where = where if tag.line is None else f"at exit point {tag.line}, centre {_numbers(tag.at)} m from it"
        facing = f"faces {_numbers(tag.normal)}, top to {_numbers(tag.up)}"
        pages[-1].texts += [
            (x + side / MODULES, y + whole + 2.0, 3.2, f"tag {tag.number}, black square {side:g} mm, {where}"),
            (x + side / MODULES, y + whole + 2.0 + _LINE, 3.2, facing),
        ]
        x, deep = x + room[0] + 4.0, max(deep, room[1] + 4.0)
    return pages


def _in_place(layout: TagLayout, paper: str) -> TagPage:
    """Return the page on which tags are where the layout has them, in the middle."""
    page, (width, height) = _page(paper), PAPERS[paper]
    centres = 1e3 * np.array([tag.at[:2] for tag in layout.tags])
    middle = 0.5 * (centres.min(axis=0) + centres.max(axis=0))
    for tag, (right, up) in zip(layout.tags, (centres - middle).tolist(), strict=True):
        half = 500.0 * tag.size
        _put(page, tag, 0.5 * width + right - half, 0.5 * (height - _FOOT) - up - half)
    return page


def _numbers(values: tuple[float, float, float]) -> str:
    return f"({', '.join(f'{value:g}' for value in values)})"


def _put(page: TagPage, tag: Tag, x: float, y: float) -> None:
    """Put a tag on a page, its black square's top left at (x, y), mm; a row of black modules is one rectangle."""
    module = 1e3 * tag.size / MODULES
    for row, black in enumerate(modules_of(tag.number)):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], black.astype(int), [0]])))
        for begin, end in edges.reshape(-1, 2).tolist():
            page.boxes.append((x + begin * module, y + row * module, (end - begin) * module, module))


def _page(paper: str) -> TagPage:
    """Return an empty page with its ruler."""
    width, height = PAPERS[paper]
    left, top = 0.5 * (width - RULER), height - _EDGE - 10.0
    page = TagPage((width, height), [(left, top, RULER, 0.3)], [])
    for at in range(0, int(RULER) + 1, 10):
        page.boxes.append((left + at - 0.15, top - (5.0 if at % 50 == 0 else 3.0), 0.3, 5.0 if at % 50 == 0 else 3.0))
    words = f"{RULER:g} mm between the outer ticks: measure them. AprilTag 36h11. Print at 100 %, and glue it flat."
    page.texts.append((left, top + 5.0, 3.2, words))
    return page


def svg_of(page: TagPage) -> str:
    """Return a page of printed tags as SVG."""
    width, height = page.size
    boxes = "".join(f'<rect x="{x:.4f}" y="{y:.4f}" width="{w:.4f}" height="{h:.4f}"/>' for x, y, w, h in page.boxes)
    texts = "".join(
        f'<text x="{x:.3f}" y="{y:.3f}" font-family="sans-serif" font-size="{size:g}">{escape(words)}</text>'
        for x, y, size, words in page.texts
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}mm" height="{height:g}mm" '
        f'viewBox="0 0 {width:g} {height:g}" shape-rendering="crispEdges"><rect width="{width:g}" height="{height:g}" '
        f'fill="white"/>{boxes}{texts}</svg>\n'
    )


def pdf_of(pages: list[TagPage]) -> bytes:
    """Return pages as PDF 1.4: one font, rectangles and texts, no compression."""
    kids = " ".join(f"{4 + 2 * at} 0 R" for at in range(len(pages)))
    objects = [
        b"<< /Type /Catalog /Pages 2 0 R >>",
        f"<< /Type /Pages /Kids [{kids}] /Count {len(pages)} >>".encode(),
        b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>",
    ]
    for at, page in enumerate(pages):
        width, height = page.size
        drawn = [f"{_POINT:.6f} 0 0 {-_POINT:.6f} 0 {height * _POINT:.4f} cm"]
        drawn += [f"{x:.4f} {y:.4f} {w:.4f} {h:.4f} re f" for x, y, w, h in page.boxes]
        for x, y, size, words in page.texts:
            safe = words.replace("\\", r"\\").replace("(", r"\(").replace(")", r"\)")
            drawn.append(f"BT /F1 {size:g} Tf 1 0 0 -1 {x:.4f} {y:.4f} Tm ({safe}) Tj ET")
        stream = "\n".join(drawn).encode("cp1252", "replace")
        box = f"/MediaBox [0 0 {width * _POINT:.4f} {height * _POINT:.4f}]"
        fonts = f"/Resources << /Font << /F1 3 0 R >> >> /Contents {5 + 2 * at} 0 R"
        objects.append(f"<< /Type /Page /Parent 2 0 R {box} {fonts} >>".encode())
        objects.append(b"<< /Length %d >>\nstream\n" % len(stream) + stream + b"\nendstream")
    text, places = b"%PDF-1.4\n", list[int]()
    for number, content in enumerate(objects, 1):
        places.append(len(text))
        text += b"%d 0 obj\n" % number + content + b"\nendobj\n"
    table = b"".join(b"%010d 00000 n \n" % place for place in places)
    end = b"trailer\n<< /Size %d /Root 1 0 R >>\nstartxref\n%d\n%%%%EOF\n" % (len(objects) + 1, len(text))
    return text + b"xref\n0 %d\n0000000000 65535 f \n" % (len(objects) + 1) + table + end
