"""Files of total stations: GSI-8, GSI-16 and CSV read as written, and whatever else rejected in one line."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cablewright.calibration.survey.plan import load_plan
from cablewright.calibration.survey.shots import read_shots
from cablewright.calibration.survey.survey import survey
from cablewright.foundation.errors import InputError
from oracles.surveyor import csv, gsi, polar, site

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("shots") / "survey.txt"


def read(file: Path, text: str | bytes):
    file.write_bytes(text.encode() if isinstance(text, str) else text)
    return read_shots(file)


@pytest.mark.parametrize("wide", [False, True])
@pytest.mark.parametrize("height", [None, 1.5])
def test_gsi_is_what_was_written(file: Path, wide: bool, height: float | None) -> None:
    where = site()
    rows = polar(where, np.random.default_rng(0), angle=0.0, distance=0.0, ppm=0.0)
    found = read(file, gsi(rows, wide, height)).shots
    assert [shot.point for shot in found] == [row[0] for row in rows]
    for shot, place in zip(found, where.markers.values(), strict=True):
        wanted = where.to_grid(place)
        assert np.allclose(shot.sight, wanted, atol=1e-4)  # a tenth of a millimetre is the last digit
        assert np.allclose(shot.position, wanted + np.array([0, 0, height or 0.0]), atol=1e-4)


def test_csv_and_gsi_say_the_same(file: Path) -> None:
    rows = polar(site(), np.random.default_rng(7))
    one = survey(read(file, csv(rows)))
    other = survey(read(file, gsi(rows, wide=True)))
    for a, b in zip(one.exits, other.exits, strict=True):
        assert np.allclose(a.exit_point, b.exit_point, atol=2e-4)


@pytest.mark.parametrize(
    ("word", "value"),
    [
        ("31..00+00012345", 12.345),
        ("31..06+00012345", 1.2345),
        ("31..08+00012345", 0.12345),
        ("31..01+00010000", 3.048),
        ("31..07+00010000", 0.3048),
    ],
)
def test_units_of_lengths(file: Path, word: str, value: float) -> None:
    (shot,) = read(file, f"110001+00000X11 21.322+00000000 22.322+10000000 {word}").shots
    assert shot.position == pytest.approx((0.0, value, 0.0), abs=1e-9)


@pytest.mark.parametrize(
    ("word", "degrees"),
    [
        ("21.322+05000000", 45.0),
        ("21.323+04500000", 45.0),
        ("21.324+04530000", 45.5),
        ("21.324+04530305", 45.0 + 30 / 60 + 30.5 / 3600),
        ("21.325+08000000", 45.0),
        ("21.322-05000000", -45.0),
    ],
)
def test_units_of_angles(file: Path, word: str, degrees: float) -> None:
    (shot,) = read(file, f"*110001+0000000000000X11 {word.replace('+', '+00000000').replace('-', '-00000000')} "
                         "22.322+0000000010000000 31..00+0000000000001000").shots  # fmt: skip
    assert math.degrees(math.atan2(*shot.position[:2])) == pytest.approx(degrees, abs=1e-9)


def test_coordinates_of_gsi(file: Path) -> None:
    text = (
        "410001+00000013 42....+00001810\n"
        "110001+00000STA 84..10+00100000 85..10+00200000 86..10+00050000 88..10+00001500\n"
        "110002+00000W11 81..10+00101000 82..10+00202000 83..10-00003000\n"
        "110003+00000007 21.102+00000000 22.102+10000000 31..00+00000000\n"
        "110004+00000H66 21.102+00000000 22.102+10000000\n"
    )
    found = read(file, text)
    (shot,) = found.shots
    assert shot.point == "W11"
    assert shot.position == pytest.approx((101.0, 202.0, -3.0))
    assert shot.sight == pytest.approx((1.0, 2.0, -54.5))
    assert [note.partition(" at")[0] for note in found.notes] == ["7", "H66"]


def test_reflectors_stand_above_their_points(file: Path) -> None:
    (shot,) = read(file, "110002+00000X11 21.322+00000000 22.322+10000000 31..00+00001000 87..10+00000200").shots
    assert shot.position == pytest.approx((0.0, 1.0, -0.2), abs=1e-12)
    assert shot.sight == pytest.approx((0.0, 1.0, 0.0), abs=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "point,x,y,z\nWEST1,1,2,3",
        "Point;X (mm);Y (mm);Z (mm)\nWEST1;1000;2000;3000",
        "# made up\nremark\teast\tnorth\theight\tname\nold\t1\t2\t3\tWEST1",
        '"point","x","y","z"\n"WEST1","1.0","2e0","+3"',
        "\N{BYTE ORDER MARK}pt,e,n,h\r\nWEST1,1,2,3\r\n",
    ],
)
def test_ways_to_write_a_csv(file: Path, text: str) -> None:
    (shot,) = read(file, text).shots
    assert (shot.point, shot.position, shot.sight) == ("WEST1", (1.0, 2.0, 3.0), None)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "empty; expected GSI, or a CSV with columns"),
        ("# nothing\n\n", "empty"),
        ("x,y,z\n1,2,3", "line 1: no column 'point', the markers' names"),
        ("point,name,x,y,z\n1,2,3,4,5", "more than one column 'point'"),
        ("point,x,y\nA,1,2", "no column 'z'"),
        ("point,hz (deg),v (deg)\nA,1,2", "no column 'slope'"),
        ("point,hz,v,slope\nA,1,2,3", "column 'hz': a unit must follow, as in 'hz (mrad)', one of rad, mrad, deg, gon"),
        ("point,x (inch),y,z\nA,1,2,3", "column 'x (inch)': unknown unit 'inch'"),
        ("point,x,y,z\nA,1,2", "line 2: 3 cells; the header has 4"),
        ("point,x,y,z\nA,1,2,nan", "line 2: z = 'nan': must be a finite number"),
        ("point,x,y,z\nA,1,2,3 m", "line 2: z = '3 m'"),
        ("point,x,y,z\n,1,2,3", "line 2: point = '': expected a name of 1 to 40 characters"),
        (f"point,x,y,z\n{'A' * 41},1,2,3", "expected a name of 1 to 40 characters"),
        ("point,hz (deg),v (deg),slope\nA,0,90,5000", "line 2: point 'A' is 5000 m from the instrument"),
        ("point,x,y,z\n" + "A,1,2,3\n" * 5001, "line 5002: more than 5000 shots"),
        (b"point,x,y,z\nA,1,2,\xff", "line 2: not UTF-8"),
        ("110001+00000X11 hello", "line 1: 'hello' is not a GSI word"),
        ("110001+00000X11 31..00+0001234", "has 7 places of data; expected 8"),
        ("*110001+00000000X11 31..00+00012345", "places of data; expected 16"),
        ("110001+00000X11 31..05+00012345", "unit '5'; a length has one of 0, 1, 6, 7, 8"),
        ("110001+00000X11 21.327+00012345", "unit '7'; an angle has one of 2, 3, 4, 5"),
        ("110001+00000X11 21.324+04565000", "65 minutes and 0 seconds; both must be under 60"),
        ("110001+00000X11 31..00+0001A345", "'0001A345' must be digits"),
        ("110001+00000X11 31..00+00012345 31..00+00012345", "the GSI word 31 occurs twice"),
        ("110001+00000X11 31..00+00012345 110002+00000X12 31..00+0001", "line 1, block 2: word '31..00+0001' has 4"),
        ("110001+00000X11 31..00+---", "has 3 places of data; expected 8"),
        ("110001+00000X11 " + "31..00+00012345 " * 65, "66 words, over the limit of 64"),
        ("110001+00000X11 21.322+00000000 22.322+10000000 31..00+99999999", "point 'X11' is 100000 m from"),
    ],
)
def test_what_is_rejected(file: Path, text: str | bytes, says: str) -> None:
    with pytest.raises(InputError) as error:
        read(file, text)
    line = str(error.value)
    assert says in line
    assert line.startswith(str(file))
    assert "\n" not in line
    assert len(line) < 400


def test_a_second_station_is_rejected(file: Path) -> None:
    shot = "110002+00000X11 21.322+00000000 22.322+10000000 31..00+00001000"
    station = "110001+00000STA 84..10+00000000 85..10+00000000 86..10+{:08d}"
    text = "\n".join([station.format(0), shot, station.format(1), shot])
    with pytest.raises(InputError, match="line 3: the station differs from that of line 2; survey from one station"):
        read(file, text)


@pytest.mark.parametrize("wide", [False, True])
@pytest.mark.parametrize("end", [" ", "  ", " \r", "\n \n"])
def test_blocks_without_line_ends_are_the_same_shots(file: Path, wide: bool, end: str) -> None:
    text = gsi(polar(site(), np.random.default_rng(2)), wide=wide)
    by_lines, joined = read(file, text), read(file, end.join(text.splitlines()))
    assert [(shot.point, shot.position) for shot in by_lines.shots] == [
        (shot.point, shot.position) for shot in joined.shots
    ]


def test_one_line_may_hold_hundreds_of_blocks(file: Path) -> None:
    text = "".join(f"11{i:04d}+{i:08d} 21.322+00000000 22.322+10000000 31..00+00001000 " for i in range(1, 901))
    assert len(read(file, text).shots) == 900


SIGHT = "11{0:04d}+00000X{0:02d} 21.322+00000000 22.322+10000000 31..00+00001000"
CODES = "41{:04d}+0000000{} 42....+000000{} 43....+0000{} "


@pytest.mark.parametrize("end", ["\n", " "])
@pytest.mark.parametrize("first", ["", CODES.format(1, 2, "P1", 1500)])
@pytest.mark.parametrize("code", [2, 7])
def test_codes_between_sights_that_may_begin_a_station_are_rejected(
    file: Path, end: str, first: str, code: int
) -> None:
    blocks = [first, SIGHT.format(1), SIGHT.format(2), CODES.format(3, code, "P2", 1620), SIGHT.format(3)]
    with pytest.raises(InputError, match=f"'41 {code}, 42 P2, 43 1620'.* one station is allowed"):
        read(file, end.join(filter(None, blocks)))


@pytest.mark.parametrize(
    ("blocks", "note"),
    [
        ([CODES.format(1, 2, "P1", 1500), SIGHT.format(1), SIGHT.format(2)], False),
        ([CODES.format(1, 2, "P1", 1500), SIGHT.format(1), CODES.format(1, 2, "P1", 1500), SIGHT.format(2)], True),
        ([SIGHT.format(1), "410001+00000104 ", SIGHT.format(2)], True),
        ([SIGHT.format(1), SIGHT.format(2), CODES.format(3, 9, "ND", 0)], True),
    ],
)
def test_codes_that_change_nothing_are_read_over(file: Path, blocks: list[str], note: bool) -> None:
    found = read(file, "\n".join(blocks))
    assert len(found.shots) == 2
    assert any("of codes" in each for each in found.notes) == note


def test_dashes_are_no_value(file: Path) -> None:
    found = read(file, "\n".join([SIGHT.format(1), SIGHT.format(2).replace("00001000", "-" * 8), SIGHT.format(3)]))
    assert [shot.point for shot in found.shots] == ["X01", "X03"]
    assert "X02 at line 2 is left out" in found.notes[0]
    found = read(file, "point,x,y,z\n,mm,mm,mm\nA,1000,2,3\nB,1,-,3\nC,\u2013,--,\nD,4,5,6")
    assert [(shot.point, shot.position[0]) for shot in found.shots] == [("A", 1.0), ("D", 0.004)]
    assert [note.partition(" is")[0] for note in found.notes] == ["B at line 4", "C at line 5"]


def judged(file: Path, data: bytes) -> None:
    """Whatever it is, it is read or rejected in one short line; and so is the survey of it."""
    said = ""
    try:
        survey(read(file, data))
    except InputError as error:
        said = str(error)
    assert "\n" not in said
    assert len(said) < 600


FUZZ = settings(deadline=None, max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
GOOD = [
    csv(polar(site(), np.random.default_rng(5))).encode(),
    gsi(polar(site(), np.random.default_rng(5)), height=1.4).encode(),
    gsi(polar(site(), np.random.default_rng(5)), wide=True).encode(),
]


@FUZZ
@given(data=st.binary(max_size=300))
def test_any_bytes(file: Path, data: bytes) -> None:
    judged(file, data)


@FUZZ
@given(good=st.sampled_from(GOOD), at=st.integers(0, 2500), gone=st.integers(0, 40), new=st.binary(max_size=12))
def test_wounded_files(file: Path, good: bytes, at: int, gone: int, new: bytes) -> None:
    judged(file, good[:at] + new + good[at + gone :])


@FUZZ
@given(good=st.sampled_from(GOOD), seed=st.integers(0, 2**32 - 1))
def test_lines_lost_or_doubled(file: Path, good: bytes, seed: int) -> None:
    rng = np.random.default_rng(seed)
    first, *rest = good.splitlines()
    judged(file, b"\n".join([first, *(rest[i] for i in rng.integers(0, len(rest), len(rest)))]))


@FUZZ
@given(values=st.lists(st.floats(allow_nan=False), min_size=24, max_size=24))
def test_any_numbers(file: Path, values: list[float]) -> None:
    names = ("WEST1", "WEST2", "A1-1", "A1-2", "A1-3", "S1-1", "S1-2", "S1-3")
    rows = [f"{name},{x!r},{y!r},{z!r}" for name, (x, y, z) in zip(names, np.reshape(values, (8, 3)), strict=True)]
    judged(file, ("point,x,y,z\n" + "\n".join(rows).replace("np.float64(", "").replace(")", "")).encode())


@FUZZ
@given(values=st.lists(st.floats(-10, 10) | st.sampled_from([0.0, 1e-9, 1.0, 5.0]), min_size=24, max_size=24))
def test_any_places_in_a_room(file: Path, values: list[float]) -> None:
    test_any_numbers.hypothesis.inner_test(file, values)


# The example


def test_the_example_follows_its_rule() -> None:
    rows = polar(site(), np.random.default_rng(2023))
    assert (ROOT / "examples" / "survey.gsi").read_text() == gsi(rows, height=1.5)


def test_the_plan_of_the_example_is_read() -> None:
    plan = load_plan(ROOT / "examples" / "survey.toml")
    assert plan.exit.offset == (0.0, 0.0, -0.05)
    assert plan.frame.origin == "exits"
