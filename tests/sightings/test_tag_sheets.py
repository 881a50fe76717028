import re
from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
from cablewright.apps.tag_sheet import PAPERS, pages_of, pdf_of, svg_of
from cablewright.calibration.sightings.detection import detected
from cablewright.calibration.sightings.intrinsics import sheet
from cablewright.calibration.sightings.layout import load_layout

DOTS = 6.0  # a mm


def _drawn(boxes: list[tuple[float, ...]], size: tuple[float, float]) -> np.ndarray:
    """Return grey levels of black boxes x, y, width, height on white, mm."""
    page = np.full((int(size[1] * DOTS), int(size[0] * DOTS)), 255.0)
    for x, y, width, height in np.array(boxes) * DOTS:
        page[round(y) : round(y + height), round(x) : round(x + width)] = 0.0
    return page


@pytest.mark.parametrize("form", ["svg", "pdf"])
def test_tags_of_the_sheet_are_read_back_where_the_layout_has_them(form: str) -> None:
    layout = sheet()
    (page,) = pages_of(layout)
    if form == "svg":
        numbers = re.findall(r'<rect x="(\S+)" y="(\S+)" width="(\S+)" height="(\S+)"/>', svg_of(page))
    else:
        numbers = re.findall(r"^(\S+) (\S+) (\S+) (\S+) re f$", pdf_of([page]).decode("cp1252"), re.MULTILINE)
    boxes = [tuple(map(float, each)) for each in numbers]
    found = {number: corners.mean(axis=0) / DOTS for number, corners in detected(_drawn(boxes, page.size))}
    assert set(found) == {tag.number for tag in layout.tags}
    first = layout.tags[0]
    for tag in layout.tags:
        right, down = found[tag.number] - found[first.number]
        assert [right, -down] == pytest.approx(1e3 * (np.array(tag.at) - first.at)[:2], abs=0.3)


def test_large_tags_have_a_page_each_and_say_where_they_belong() -> None:
    pages = pages_of(load_layout("examples/tags.toml"))
    assert len(pages) == 5
    words = " ".join(text for page in pages for *_, text in page.texts)
    assert "tag 3, black square 150 mm, on platform, centre at (0, -0.2, -0.25) m" in words
    assert words.count("150 mm between the outer ticks") == 5


def test_tags_of_a_floor_are_drawn_within_the_pages_whatever_their_numbers() -> None:
    tags = tuple(cw.Tag(number=at, size=0.1, on="room", at=(at - 400.0, 0.0, 0.0)) for at in (400, 401, 402))
    pages = pages_of(cw.TagLayout(camera="platform", tags=tags))
    for page in pages:
        corners = np.array([(x, y, x + w, y + h) for x, y, w, h in page.boxes])
        assert corners.min() >= 0.0
        assert (corners.max(axis=0)[2:] <= page.size).all()


def test_a_tag_larger_than_the_paper_is_an_error() -> None:
    layout = cw.TagLayout(tags=(cw.Tag(number=1, size=0.3, at=(0.0, 0.0, 0.0)),))
    with pytest.raises(cw.InputError, match=r"tag 1: 300 mm with its margin is larger than A4; give --paper"):
        pages_of(layout)
    assert len(pages_of(layout, "A2")) == 1


def test_a_pdf_has_its_page_size_and_its_objects_where_its_table_says() -> None:
    data = pdf_of(pages_of(sheet(), "A3"))
    width, height = PAPERS["A3"]
    assert f"/MediaBox [0 0 {width * 72 / 25.4:.4f} {height * 72 / 25.4:.4f}]".encode() in data
    assert len(re.findall(rb"/Type /Page(?![A-Za-z])", data)) == 1
    for number, place in enumerate(re.findall(rb"^(\d{10}) 00000 n $", data, re.MULTILINE), 1):
        assert data[int(place) :].startswith(b"%d 0 obj" % number)


def test_the_ruler_is_as_long_as_it_says() -> None:
    (page,) = pages_of(sheet())
    ticks = sorted(x + 0.5 * w for x, _, w, h in page.boxes if w == pytest.approx(0.3) and h == pytest.approx(5.0))
    assert ticks[-1] - ticks[0] == pytest.approx(150.0)


@pytest.mark.parametrize(
    ("tags", "words"),
    [
        ('[[tags]]\nnumber = 600\nsize = "0.1 m"\nat = [0, 0, 0]', "number"),
        ('[[tags]]\nnumber = 1\nsize = "1 mm"\nat = [0, 0, 0]', "size"),
        ("[[tags]]\nnumber = 1\nsize = 0.1\nat = [0, 0, 0]\nup = [0, 0, 2.0]", r"up = .*: is along the normal"),
        ('[[tags]]\nnumber = 1\nsize = 0.1\non = "room"\nat = [0, 0, 0]', "all in the room, as the camera is"),
        ('[[tags]]\nnumber = 1\nsize = 0.1\non = "north"\nat = [0, 0, 0]', r"on = .north.: .*platform.*room"),
        (2 * "[[tags]]\nnumber = 1\nsize = 0.1\nat = [0, 0, 0]\n", "2 tags have the number 1"),
    ],
)
def test_a_bad_layout_is_an_error_in_one_line(tmp_path: Path, tags: str, words: str) -> None:
    (tmp_path / "tags.toml").write_text(f"schema = 1\n{tags}\n")
    with pytest.raises(cw.InputError, match=words) as error:
        load_layout(tmp_path / "tags.toml")
    assert "\n" not in str(error.value)
