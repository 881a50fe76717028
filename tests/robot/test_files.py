"""Robot files: default tables, and one clear line for everything that can be wrong with a file."""

import contextlib
import os
import re
import tomllib
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cablewright.foundation.errors import InputError, UnknownName
from cablewright.robot import Eyelet, Line, Swivel, UniversalJoint, library_names, library_text, load, loads
from cablewright.solvers.inverse import inverse

HOUSE = library_text("house-printer")
BEAM = library_text("jung2020")

FILE = """
schema = 1
name = "two"
[scene]
frame_min = [-1, -1, 0]
frame_max = [1, 1, 3]
[platform]
mass = "10 kg"
[cable]
young_modulus = "100 GPa"
section = "10 mm^2"
linear_density = "30 g/m"
breaking_load = "10 kN"
[sheave]
kind = "swivel"
radius = "50 mm"
[winch]
drum_radius = "100 mm"
[line]
tension_limits = ["10 N", "1 kN"]
[[lines]]
name = "east"
exit_point = [1, 0, 3]
[[lines]]
name = "west"
exit_point = [-1, 0, 3]
"""


def message(text: str) -> str:
    with pytest.raises(InputError) as caught:
        loads(text, "r.toml")
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith("r.toml: ")
    return str(caught.value).removeprefix("r.toml: ")


def changed(old: str, new: str, text: str = FILE) -> str:
    assert old in text
    return text.replace(old, new)


def last_line(extra: str) -> str:
    return FILE + extra


def test_defaults_reach_every_line() -> None:
    robot = loads(FILE)
    assert robot.m == 2
    for line in robot.lines:
        assert line.cable.young_modulus == 1e11
        assert line.sheave == Swivel(radius=0.05)
        assert line.winch.drum_radius == 0.1
        assert line.tension_limits == (10.0, 1000.0)


def test_a_line_overrides_one_key_of_a_default() -> None:
    east, west = loads(last_line("cable = { young_modulus = '95 GPa' }\ntension_limits = [5, 50]\n")).lines
    assert (east.cable.young_modulus, west.cable.young_modulus) == (100e9, 95e9)
    assert east.cable.section == west.cable.section
    assert (east.tension_limits, west.tension_limits) == ((10.0, 1000.0), (5.0, 50.0))


def test_a_sheave_of_another_kind_replaces_the_default_wholly() -> None:
    east, west = loads(last_line("sheave = { kind = 'eyelet' }")).lines
    assert isinstance(east.sheave, Swivel)
    assert west.sheave == Eyelet()


def test_a_sheave_of_the_same_kind_is_merged() -> None:
    _, west = loads(last_line("sheave = { kind = 'swivel', wrap = 'under' }")).lines
    assert west.sheave == Swivel(radius=0.05, wrap="under")


def test_default_sheave_without_a_kind_lends_its_keys() -> None:
    text = changed("kind = 'swivel'", "", changed('kind = "swivel"', "kind = 'swivel'"))
    text = changed('name = "east"', 'name = "east"\nsheave.kind = "swivel"', text)
    own = 'sheave = { kind = "universal-joint", lever = 0.1, lever_weight = 5, lever_mass_centre = 0.05 }'
    east, west = loads(text + own).lines
    assert isinstance(east.sheave, Swivel)
    assert isinstance(west.sheave, UniversalJoint)
    assert east.sheave.radius == west.sheave.radius == 0.05


DEFAULT_FAULTS = [
    (
        '"100 GPa"',
        '"5 kg"',
        "cable.young_modulus = '5 kg': must be a finite pressure: a number (Pa) or a text such as '2 Pa'",
    ),
    ("young_modulus", "yung_modulus", "cable.yung_modulus = '100 GPa': unknown key; did you mean 'young_modulus'?"),
    ('breaking_load = "10 kN"', "", "cable.breaking_load: is missing"),
    ('radius = "50 mm"', "", "sheave.radius: is missing"),
    (
        'section = "10 mm^2"',
        "",
        "cable.section: is missing: give young_modulus and section, or diameter",
    ),
    ('"1 kN"', '"11 kN"', "line.tension_limits = ['10 N', '11 kN']: must end at or below the breaking load, 10000 N"),
    ('["10 N", "1 kN"]', "3", "line.tension_limits = 3: must be a list"),
    ('"swivel"', '"swivle"', "sheave.kind = 'swivle': must be one of 'eyelet', 'swivel', 'universal-joint'"),
    ('radius = "50 mm"', 'radius = 1\nwrap = "oven"', "sheave.wrap = 'oven': must be 'over' or 'under'"),
    ("[line]", "[line]\nname = 'x'", "line.name: cannot be a default here; each line has its own"),
    ("[line]", "[line]\ncable = {}", "line.cable: cannot be a default here; the table [cable] is for that"),
    ('[winch]\ndrum_radius = "100 mm"', "[[winch]]", "winch = [{}]: must be a table"),
]

LINE_FAULTS = [  # keys for the second line, where in it, and why
    ("cable = { section = 0 }", ".cable.section", " = 0: must be greater than 0"),
    ("cable = 3", ".cable", " = 3: must be a table"),
    ("sheave = 3", ".sheave", " = 3: must be a table"),
    ("winch = { drum_radus = 1 }", ".winch.drum_radus", " = 1: unknown key; did you mean 'drum_radius'?"),
    ("winch = { 'drum radius' = 1 }", ".winch.'drum radius'", " = 1: unknown key; did you mean 'drum_radius'?"),
    ("sheave = { swing = 1 }", ".sheave.swing", " = 1: needs facing, the azimuth it swings about"),
    ("dead_elastic = 'yes'", ".dead_elastic", " = 'yes': must be true or false"),
    ("dead_length = -1", ".dead_length", " = -1: must be at least 0"),
    ("winch_exit = [-1, 0, 3]", ".winch_exit", " = [-1, 0, 3]: must differ from exit_point"),
    (
        "winch_exit = [-1, 0, 4]",
        ".winch_exit",
        " = [-1, 0, 4]: must be below exit_point for a cable that wraps over its sheave",
    ),
    ("winch_exit = [-1, 0]", ".winch_exit[2]", ": is missing"),
    ("winch_exit = [-1, 0, 3, 4]", ".winch_exit", " = [-1, 0, 3, 4]: must have at most 3 entries, has 4"),
    ("winch_exit = [-1, 0, inf]", ".winch_exit[2]", " = inf: must be a finite length"),
]

OTHER_FAULTS = [
    ('name = "west"', "", "lines[1].name: is missing"),
    ('name = "west"', "name = 3", "lines[1].name = 3: must be a text"),
    ('name = "west"', 'name = "east"', "lines: 2 lines are named 'east'; each needs a name of its own"),
    ('name = "west"', "name = 'w'\nplatform_point = [0, 0, 1]", "lines: all lines of a point platform must have one"),
    ("[platform]", "[platfrom]", "platfrom: unknown key; did you mean 'platform'?"),
    ("[cable]", "[cabel]", "cabel: unknown key; did you mean 'cable'?"),
    ('"10 kg"', "nan", "platform.mass = nan: must be a finite mass"),
    ('"10 kg"', "-1", "platform.mass = -1: must be greater than 0"),
    ('"10 kg"', "true", "platform.mass = True: must be a finite mass"),
    ('"10 kg"', f'"{"9" * 99} kg"', f"platform.mass = '{'9' * 56}...: must be a finite mass"),
    ('"10 kg"', "1\nkind = 'body'", "platform.kind = 'body': must be one of 'point', 'rigid'"),
    ("[scene]", "[[scene]]", "scene: must be a table"),
    (
        "[1, 1, 3]",
        "[1, -1, 3]",
        "scene.frame_max = [1, -1, 3]: must be above frame_min in y, where they are -1 and -1 m",
    ),
    ('name = "two"', "", "name: is missing"),
    ("schema = 1", "schema = 2\nfuture = 3", "schema = 2: written for a newer cablewright"),
    ("schema = 1", "", "missing key 'schema'; write schema = 1"),
    ("schema = 1", "schema = true", "schema = True: must be an integer from 1 to 1"),
    ("schema = 1", "schema = ", "not TOML: "),
    ("schema = 1", "schema = 1\nschema = 1", "not TOML: Cannot overwrite a value"),
    ("schema = 1", "\x00", "not TOML: "),
    ("schema = 1", "schema = 1" + "0" * 5000, "not TOML: "),
]


@pytest.mark.parametrize(("old", "new", "expected"), [*DEFAULT_FAULTS, *OTHER_FAULTS])
def test_each_fault_names_place_value_and_what_is_allowed(old: str, new: str, expected: str) -> None:
    """A fault in a default table is blamed there, and counted once however many lines it reaches."""
    found = message(changed(old, new))
    assert found.startswith(expected)
    assert "more)" not in found


@pytest.mark.parametrize(("extra", "place", "why"), LINE_FAULTS)
def test_a_fault_in_a_line_names_the_line(extra: str, place: str, why: str) -> None:
    assert message(last_line(extra)).startswith(f"lines[1]{place} (line 'west'){why}")


@pytest.mark.parametrize("lines", ["lines = 3", "lines = []", "lines = [3]", "lines = [{}]", "lines = {}", ""])
def test_lines_that_are_no_lines(lines: str) -> None:
    text = FILE.partition("[[lines]]")[0].replace("[scene]", f"{lines}\n[scene]")
    assert message(text).startswith("lines")


def test_all_faults_are_reported_together_and_further_ones_counted() -> None:
    text = changed('mass = "10 kg"', "mass = -1", last_line("winch_exit = 'x'\ncable = { section = 0 }"))
    first, second, third = message(text).split("; ")
    assert first == "platform.mass = -1: must be greater than 0"
    assert second.startswith("lines[1].winch_exit (line 'west') = 'x'") or "winch_exit" in third
    many = "schema = 1\nname = 1\ndescription = 2\nsource = 3\nscene = 4\nplatform = 5\nlines = 6\nbracket = 7\n"
    assert message(many).endswith("(and 2 more)")


@pytest.mark.parametrize(
    "deep",
    [
        "a = " + "[" * 1000,
        "a = " + "[" * 1000 + "]" * 1000,
        "a = " + "{a = " * 1000 + "1" + "}" * 1000,
        "a." * 1000 + "b = 1",
        "[" + "a." * 1000 + "b]",
        "['" + "'.'" * 1000 + "']",
        "a = " + "[" * 200_000,
    ],
)
def test_deep_nesting_is_rejected_before_parsing(deep: str) -> None:
    assert "nested deeper than 32" in message(deep)


def test_brackets_and_dots_in_texts_and_comments_are_not_nesting() -> None:
    text = "# " + "[" * 100 + "\n" + changed('name = "two"', f'name = "two"\ndescription = "{"[.{" * 100}"  # [[[')
    assert loads(text).m == 2


def test_a_file_or_text_too_large_is_not_parsed(tmp_path: Path) -> None:
    file = tmp_path / "large.toml"
    file.write_text(FILE + "#" * 2**20)
    with pytest.raises(InputError, match=r"large\.toml: larger than 1048576 bytes"):
        load(file)
    assert "longer than 1048576 characters" in message(FILE + "#" * 2**20)


def test_a_file_is_read_and_named_in_faults(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    good, bad, bare = tmp_path / "good.toml", tmp_path / "bad.toml", tmp_path / "noending"
    good.write_bytes(b"\xef\xbb\xbf" + FILE.replace("\n", "\r\n").encode())
    bad.write_text(changed("10 kg", "10 m"))
    bare.write_text(FILE)
    assert load(good) == load(str(good)) == loads(FILE)
    with pytest.raises(InputError, match=r"bad\.toml: platform\.mass = '10 m'"):
        load(bad)
    monkeypatch.chdir(tmp_path)
    assert load("noending") == load("./noending") == loads(FILE)


@pytest.mark.parametrize(
    ("content", "match"),
    [
        (b"\xff\xfe\x00", "not UTF-8 text"),
        (b"\x7fELF\x02\x01\x01" + bytes(64), "not TOML"),
        (b"", "missing key 'schema'"),
    ],
)
def test_a_file_that_is_no_robot(tmp_path: Path, content: bytes, match: str) -> None:
    file = tmp_path / "r.toml"
    file.write_bytes(content)
    with pytest.raises(InputError, match=match):
        load(file)


def test_what_is_no_readable_file(tmp_path: Path) -> None:
    for path in (
        tmp_path,
        str(tmp_path),
        tmp_path / "none.toml",
        "none.toml",
        "no/such",
        "a\0b.toml",
        "x" * 5000 + ".toml",
    ):
        with pytest.raises(InputError) as caught:
            load(path)
        assert "\n" not in str(caught.value)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may read everything")
def test_an_unreadable_file(tmp_path: Path) -> None:
    file = tmp_path / "r.toml"
    file.write_text(FILE)
    file.chmod(0)
    with pytest.raises(InputError, match="cannot be read"):
        load(file)


def test_the_examples_in_the_documentation() -> None:
    root = Path(__file__).parents[2]
    page = (root / "docs" / "robots.md").read_text(encoding="utf-8")
    whole, *_, line, _ = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    point = loads(whole)
    rigid, board, pairs = (load(root / "examples" / "robots" / f"{name}.toml") for name in ("beam", "board", "pairs"))
    assert (point.m, point.n) == (3, 3)
    assert (rigid.m, rigid.n, [load.name for load in rigid.platform.loads]) == (8, 6, ["full", "windy"])
    assert (board.m, board.n, board.freedoms) == (4, 3, 2)
    assert (pairs.m, pairs.winches) == (6, 3)
    assert rigid.retracted(1.1).lines[0].platform_point == pytest.approx((0.1, 0.1, 0.9))
    held = inverse(board, [0.2, float("nan"), 0.6])
    pose = ", ".join(f"{x:.7f}" for x in held.pose)
    assert f"pose              {pose} m\nplane force       {held.plane_force:.2f} N" in page
    own = tomllib.loads(line)["lines"][0]
    up = Line(**own, cable=rigid.lines[0].cable, tension_limits=(1, 2))
    assert (up.sheave.kind, up.sheave.upright, up.in_plane) == ("swivel", False, False)


def test_a_library_name_wins_over_a_file_unless_it_looks_like_a_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("paty2021").write_text(FILE)
    assert load("paty2021").name == "paty2021"
    assert load("./paty2021").name == load(Path("paty2021")).name == "two"


def test_an_unknown_name_offers_the_nearest() -> None:
    with pytest.raises(
        InputError, match="no robot 'paty2012' in the library and no file of that name; did you mean 'paty2021'"
    ):
        load("paty2012")
    with pytest.raises(
        UnknownName, match="unknown robot 'nothing'; allowed: building-printer, cable-robot-simulator, caroca,"
    ):
        library_text("nothing")
    with pytest.raises(UnknownName):
        library_text("../robot")


def test_a_fault_in_the_library_would_name_the_library() -> None:
    assert "house-printer" in library_names()
    with pytest.raises(InputError, match=r"^x \(library\): platform\.mass"):
        loads(HOUSE.replace("200 kg", "200"), "x (library)")


@given(st.text(max_size=200))
@example('"""\\"""' * 50)
@example("'" * 7 + "[" * 40)
def test_random_text_is_rejected(text: str) -> None:
    with pytest.raises(InputError):
        loads(text)


@st.composite
def mangled(draw: st.DrawFn) -> str:
    """Return a library file with a few pieces replaced by others of its own, or by something nasty."""
    text = draw(st.sampled_from([HOUSE, FILE, BEAM]))
    for _ in range(draw(st.integers(1, 3))):
        start = draw(st.integers(0, len(text)))
        end = min(len(text), start + draw(st.integers(0, 30)))
        other = draw(st.integers(0, len(text)))
        piece = draw(
            st.sampled_from(["", "[", "]]", '"', "=", "\n", "1e999", "nan", "{}", "-", "\\", "'''", "[[lines]]\n"])
        )
        text = text[:start] + draw(st.sampled_from([piece, text[other : other + 20]])) + text[end:]
    return text


@given(mangled())
def test_a_mangled_file_is_read_or_rejected(text: str) -> None:
    with contextlib.suppress(InputError):
        loads(text)
