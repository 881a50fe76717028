"""Reading a stranger's TOML: capped, quick whatever it holds, rejected in one line."""

import contextlib
import os
import time
from typing import Annotated, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import Field

from cablewright.foundation.errors import InputError
from cablewright.foundation.toml_input import (
    MAX_BYTES,
    MAX_DEPTH,
    parse_table,
    read_table,
    require_schema,
)
from cablewright.foundation.validation import Description, validated


def test_table_and_text(tmp_path):
    file = tmp_path / "a.toml"
    file.write_bytes(b"\xef\xbb\xbf# note\nx = [1, {y = 'z'}]\n")
    assert read_table(file) == ({"x": [1, {"y": "z"}]}, "# note\nx = [1, {y = 'z'}]\n")


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"x = 1\n" * (MAX_BYTES // 6 + 1), "larger than 1048576 bytes"),
        (b"x = '\xff'", "not UTF-8 text at byte 5"),
        (b"x = ", "not TOML: Invalid value"),
        (b"x = 1" + b"0" * 5000, "not TOML: "),
        (b"x = 1\nx = 2", "not TOML: "),
    ],
)
def test_rejected(data, reason, tmp_path):
    file = tmp_path / "a.toml"
    file.write_bytes(data)
    with pytest.raises(InputError) as caught:
        read_table(file)
    assert str(caught.value).startswith(f"{file}: {reason}")


def test_what_is_no_file(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path, reason in [
        (tmp_path / "none", "no such file"),
        (tmp_path, "not a regular file"),
        (tmp_path / "pipe", "not a regular file"),
        ("x" * 5000, "cannot be read"),
    ]:
        with pytest.raises(InputError, match=reason):
            read_table(path)


@pytest.mark.parametrize(
    ("opening", "closing"),
    [("[", "]"), ("{a = ", "}"), ("[{a = ", "}]")],
)
def test_nesting(opening, closing):
    levels = MAX_DEPTH // len([mark for mark in opening if mark in "[{"])
    assert parse_table("x = " + opening * levels + "1" + closing * levels, "t")
    with pytest.raises(InputError, match="t: nested deeper than 32 levels"):
        parse_table("x = " + opening * (levels + 1) + "1" + closing * (levels + 1), "t")


def test_long_dotted_keys_nest_too():
    assert parse_table("a." * (MAX_DEPTH - 1) + "a = 1", "t")
    for text in ("a." * MAX_DEPTH + "a = 1", "[" + "'a'." * MAX_DEPTH + "a]", "x = {" + "a . " * MAX_DEPTH + "a = 1}"):
        with pytest.raises(InputError, match="nested deeper"):
            parse_table(text, "t")


@pytest.mark.parametrize("quote", ['"', "'", '"""', "'''"])
def test_brackets_in_strings_and_comments_do_not_nest(quote):
    brackets = "[{" * 40
    table = parse_table(f"x = {quote}{brackets}{quote} # {brackets}\ny = [1]", "t")
    assert table == {"x": brackets, "y": [1]}


@pytest.mark.parametrize("end", ['"""', '""""', '"""""', '\\""""', '\\\\"""'])
def test_nesting_behind_a_string_that_ends_in_quotes_is_seen(end):
    text = f'x = ["""a{end}, {"[" * 40}{"]" * 40}]'
    with pytest.raises(InputError, match="nested deeper"):
        parse_table(text, "t")


@pytest.mark.parametrize(
    "text",
    [
        '"\\' * (MAX_BYTES // 2),
        '"a' + '\\"' * (MAX_BYTES // 2 - 1),
        '"""' + '\\"""' * (MAX_BYTES // 4 - 1),
        "'''" * (MAX_BYTES // 3),
        '"' * MAX_BYTES,
        "a" * MAX_BYTES,
        "a " * (MAX_BYTES // 2),
        "[" * MAX_BYTES,
        "[]" * (MAX_BYTES // 2),
        "a." * (MAX_BYTES // 2),
    ],
)
def test_hostile_texts_are_rejected_quickly(text):
    begin = time.perf_counter()
    with pytest.raises(InputError):
        parse_table(text, "t")
    assert time.perf_counter() - begin < 5


@given(st.text(alphabet="\"'\\[]{}=.,#\n ab1", max_size=60))
def test_any_text_gives_a_table_or_one_line(text):
    with contextlib.suppress(InputError):
        assert isinstance(parse_table(text, "t"), dict)


@pytest.mark.parametrize("value", [None, 0, 3, 1.0, "1", True])
def test_schema(value):
    require_schema({"schema": 1}, "t")
    with pytest.raises(InputError, match=r"t: .*schema"):
        require_schema({} if value is None else {"schema": value}, "t")


class Circle(Description):
    kind: Literal["circle"]
    radius: Annotated[float, Field(gt=0)]


class Square(Description):
    kind: Literal["square"]
    side_length: float


class Plate(Description):
    holes: tuple[Annotated[Circle | Square, Field(discriminator="kind")], ...] = ()
    material: Annotated[str, Field(alias="made_of")] = "steel"
    weight: float = 1.0


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"hole": 1}, "hole = 1: unknown key; did you mean 'holes'?"),
        ({"made": "x"}, "made = 'x': unknown key; did you mean 'made_of'?"),
        (
            {"holes": [{"kind": "square", "side_lenght": 1}]},
            "holes[0].side_lenght = 1: unknown key; did you mean 'side_length'?",
        ),
        (
            {"holes": [{"kind": "circle", "side_length": 1}]},
            "holes[0].side_length = 1: unknown key; allowed: kind, radius",
        ),
        ({"holes": [{"kind": "circle"}]}, "holes[0].radius: is missing"),
        ({"holes": [{"kind": "circle", "radius": -1}]}, "holes[0].radius = -1: must be greater than 0"),
        ({"made_of": 3}, "made_of = 3: must be a text"),
        ({"weight": []}, "weight = []: must be a valid number"),
        ({"made_of": ["x" * 99]}, "made_of = ['" + "x" * 55 + "...: must be"),
        ({"made_of": int("f" * 9000, 16)}, "made_of = (a number of thousands of digits): must be"),
    ],
)
def test_one_line(table, message):
    with pytest.raises(InputError) as caught:
        validated(Plate, table, "p.toml")
    assert str(caught.value).startswith(f"p.toml: {message}")
