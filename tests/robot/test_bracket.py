"""What a bracket may be: the library's, a file of its own, and the lines that bad ones get."""

from __future__ import annotations

import pytest

from cablewright.foundation.errors import InputError
from cablewright.robot import library_text, load, load_bracket, loads

TEXT = library_text("house-printer")


def own_file(text: str) -> str:
    """The library's bracket as a file of its own."""
    table = text[text.index("[bracket]") : text.index("[winch]")]
    return "schema = 1\n" + table.replace("[bracket]", "").replace("[bracket.", "[")


def test_the_library_has_one_bracket() -> None:
    assert load("house-printer").bracket == load("paty2021").bracket
    assert load("merlet2023").bracket is None
    assert load("house-printer").bracket.material.yield_strength == 160e6


def test_a_file_of_its_own_is_the_same(tmp_path) -> None:
    (tmp_path / "bracket.toml").write_text(own_file(TEXT))
    assert load_bracket(tmp_path / "bracket.toml") == load("house-printer").bracket


BAD = [
    ('thickness = "10 mm"', 'thickness = "0 mm"', "bracket.baseplate.thickness = '0 mm': must be at least 0.0001"),
    ('thickness = "8 mm"\nheight', "thickness = 0\nheight", "bracket.uprights.thickness = 0: must be at least 0.0001"),
    ('yield_strength = "160 MPa"     # the paper\n', "", "bracket.material.yield_strength: is missing"),
    ('yield_strength = "160 MPa"', 'yield_strength = "0 MPa"', "bracket.material.yield_strength = '0 MPa': must be"),
    ('lever = "104 mm"', 'lever = "40 mm"', "sheave.lever = '40 mm': must be at least the sheave's radius, 0.05 m"),
    ('bolts = ["100 mm", "140 mm"]', 'bolts = ["130 mm", "140 mm"]', "with clamped must stay within the plate's width"),
    ('bolts = ["100 mm", "140 mm"]', 'bolts = ["20 mm", "140 mm"]', "must be further apart than clamped"),
    ('gap = "60 mm"', 'gap = "130 mm"', "bracket.standoff = '70 mm': must leave room for the block"),
    ('bore = "32 mm"', 'bore = "50 mm"', "bracket.bearing.bore = '50 mm': must be at most two thirds"),
    ('pin = "16 mm"', 'pin = "40 mm"', "bracket.lever.pin = '40 mm': must be at most two thirds"),
    ('sheave_width = "20 mm"', 'sheave_width = "30 mm"', "bracket.axle.sheave_width = '30 mm': must be at most"),
    ("poisson_ratio = 0.33", "poisson_ratio = 0.5", "bracket.material.poisson_ratio = 0.5: must be"),
    ('standoff = "70 mm"', 'standof = "70 mm"', "bracket.standof = '70 mm': unknown key; did you mean 'standoff'?"),
    ('height = "60 mm"', 'height = "190 mm"', "bracket.uprights.height = '190 mm': must be less than the baseplate's"),
    (
        'height = "60 mm"',
        'height = "30 mm"',
        "bracket.bearing.width = '20 mm': must be under half the uprights' height",
    ),
]


@pytest.mark.parametrize(("old", "new", "told"), BAD)
def test_a_bad_bracket_is_reported_in_one_line(old: str, new: str, told: str) -> None:
    assert TEXT.count(old) == 1
    with pytest.raises(InputError) as caught:
        loads(TEXT.replace(old, new))
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_bad_file_is_named(tmp_path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(own_file(TEXT).replace('thickness = "10 mm"', 'thickness = "-1 mm"'))
    with pytest.raises(InputError, match=r"mine.toml: baseplate.thickness = '-1 mm': must be at least"):
        load_bracket(file)
    file.write_text(own_file(TEXT).replace("schema = 1", "schema = 2"))
    with pytest.raises(InputError, match="newer cablewright"):
        load_bracket(file)
