"""Records of total stations that are of several kinds: all in one frame, or an error of one line.

Oracle: the site of `oracles.surveyor`, written as coordinates alone.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cablewright.calibration.survey.plan import SurveyPlan
from cablewright.calibration.survey.shots import read_shots
from cablewright.calibration.survey.survey import survey
from cablewright.foundation.errors import InputError
from oracles.surveyor import csv, polar, site


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "survey.txt"


def read(file: Path, text: str):
    file.write_text(text, encoding="utf-8")
    return read_shots(file)


SIGHT = "11{0:04d}+00000X{0:02d} 21.322+00000000 22.322+10000000 31..00+00001000"


def gsi_word(index: int, metres: float | None, wide: bool) -> str:
    digits = "-" * 16 if metres is None else f"{abs(round(1e4 * metres)):016d}"
    return f"{index}..16{'-' if (metres or 0.0) < 0 else '+'}{digits if wide else digits[8:]}"


def test_a_horizontal_distance_is_no_slope_distance(file: Path) -> None:
    with pytest.raises(InputError, match=r"line 1: 'horizontal distance \(m\)' is no slope distance: export slope"):
        read(file, "point,hz (gon),v (gon),horizontal distance (m)\nX1,0,90,10\n")


def test_sights_without_a_slope_distance_are_named(file: Path) -> None:
    """Words 32 and 33 are a horizontal distance and a height."""
    found = read(file, SIGHT.replace("31..00", "32..00").format(1) + "\n\x1a")
    with pytest.raises(InputError, match=r"no shot of a marker; X01 at line 1 is left out: .*nor angles with a slope"):
        survey(found)


@pytest.mark.parametrize("end", ["\x1a", "\n\x1a", "\n\0\0\0"])
def test_an_end_of_file_of_dos_is_no_word(file: Path, end: str) -> None:
    assert read(file, SIGHT.format(1) + end).shots == read(file, SIGHT.format(1)).shots


STATION = {84: 10.0, 85: -20.0, 86: 5.0, 88: 1.62}


def blocks_of(place, by_angles, wide: bool = False, station=STATION, turned: float = 0.0, heights=None) -> list[str]:
    """The station's block, then one of each marker: words 21, 22, 31 of names *by_angles*, else words 81 to 83."""
    star, digits = ("*", 16) if wide else ("", 8)
    axis = np.array([10.0, -20.0, 5.0 + 1.62])
    blocks = [f"{star}110001+{'STAT':0>{digits}} " + " ".join(gsi_word(i, v, wide) for i, v in station.items())]
    for number, (name, (x, y, z, reflector)) in enumerate(place.items(), 2):
        words = [f"{star}11{number:04d}+{name:0>{digits}}"]
        if name in by_angles:
            slope = math.sqrt(x * x + y * y + (z + reflector) ** 2)
            hz, v = (math.atan2(x, y) - turned) % math.tau, math.acos((z + reflector) / slope)
            words += [f"{i}.322+{round(a * 200e5 / math.pi):0{digits}d}" for i, a in ((21, hz), (22, v))]
            words.append(gsi_word(31, slope, wide))
            words += [] if heights is None else [gsi_word(87, heights[name], wide)]
        else:
            words += [
                gsi_word(i, v, wide) for i, v in zip((81, 82, 83), (axis[0] + x, axis[1] + y, axis[2] + z), strict=True)
            ]
        blocks.append(" ".join(words))
    return blocks


def room(reflector: float = 0.0) -> dict[str, tuple[float, ...]]:
    """Markers of the oracle's site from the instrument, with the reflector's height over each."""
    where = site(turned=0.0)
    return {name: (*where.to_grid(place), reflector) for name, place in where.markers.items()}


@pytest.mark.parametrize("wide", [False, True])
@pytest.mark.parametrize("end", ["\n", " "])
@pytest.mark.parametrize("share", [0.2, 0.5, 1.0])
def test_angles_and_coordinates_are_in_one_grid(file: Path, wide: bool, end: str, share: float) -> None:
    place = room()
    names = np.random.default_rng(3).permutation(list(place))[: int(share * len(place))]
    whole, mixed = (survey(read(file, end.join(blocks_of(place, by, wide)))) for by in ((), set(names)))
    for a, b in zip(whole.exits, mixed.exits, strict=True):
        assert np.allclose(a.exit_point, b.exit_point, atol=5e-4)
    assert any("in the grid of the coordinates" in note for note in mixed.notes) == (share < 1.0)


def test_a_station_in_each_block_is_the_same_station(file: Path) -> None:
    first, *rest = blocks_of(room(), {"X1-1", "X2-1"})
    station = first.partition(" ")[2]
    one, each = (read(file, "\n".join(b)) for b in ([first, *rest], [f"{block} {station}" for block in rest]))
    assert [(s.point, s.position, s.sight) for s in one.shots] == [(s.point, s.position, s.sight) for s in each.shots]


@pytest.mark.parametrize("gone", [(84,), (85,), (86,), (88,), (84, 85, 86, 88), (85, 86)])
@pytest.mark.parametrize("blank", [False, True])
def test_a_mix_without_its_whole_station_is_rejected(file: Path, gone: tuple[int, ...], blank: bool) -> None:
    station = {i: v for i, v in STATION.items() if i not in gone} | (dict.fromkeys(gone) if blank else {})
    text = "\n".join(blocks_of(room(), {"X1-1"}, station=station))
    with pytest.raises(InputError, match=f"line 11: .* line 2.* has no word {', '.join(map(str, gone))}: write E0, N0"):
        read(file, text)
    assert read(file, "\n".join(blocks_of(room(), set(room()), station=station))).shots  # all in one frame


def test_another_station_before_the_sights_leaves_nothing_of_the_first(file: Path) -> None:
    """Its block has no height: that of the first station is not of it."""
    first, *rest = blocks_of(room(), {"X1-1"})
    for news in (
        "84..16+00200000 85..16+00100000",
        "86..16+00060000",
        "84..16+00200000 85..16+-------- 88..16+00016200",
    ):
        with pytest.raises(InputError, match="has no word 8"):
            read(file, "\n".join([first, *rest[:8], f"110900+000STAT2 {news}", *rest[8:]]))


@pytest.mark.parametrize("wide", [False, True])
@pytest.mark.parametrize("known", [(84, 85), (84, 85, 86), (84, 85, 86, 88), (88,), (86, 88)])
@pytest.mark.parametrize("change", [0.4, None])
def test_any_word_of_a_station_that_changes_after_a_sight_is_rejected(
    file: Path, wide: bool, known: tuple[int, ...], change: float | None
) -> None:
    star, name = ("*", "STAT2".rjust(16, "0")) if wide else ("", "000STAT2")
    station = {index: STATION[index] for index in known}
    blocks = blocks_of(room(), set(room()), wide, station)
    for index in STATION:
        news = {i: STATION[i] if i != index else change and STATION[i] + change for i in {*known, index}}
        words = " ".join(gsi_word(i, v, wide) for i, v in news.items())
        with pytest.raises(InputError, match=f"line 6: the station differs from that of line 5;.* word {index} "):
            read(file, "\n".join([*blocks[:5], f"{star}110900+{name} {words}", *blocks[5:]]))
    again = " ".join(gsi_word(i, v, wide) for i, v in station.items())
    same = read(file, "\n".join([*blocks[:5], f"{star}110900+{name} {again}", *blocks[5:]]))
    assert len(same.shots) == len(room())


def test_a_circle_that_is_not_of_the_grid_is_rejected(file: Path) -> None:
    """A block with both angles and coordinates shows it."""
    for turned, allowed in ((0.0, True), (0.3, False)):
        polar_, plain = (blocks_of(room(), by, turned=turned) for by in (set(room()), ()))
        both = f"{plain[3]} {polar_[3].partition(' ')[2]}"
        text = "\n".join([*plain[:3], both, *polar_[4:]])
        if allowed:
            assert read(file, text).shots
        else:
            with pytest.raises(InputError, match=r"at line 4 angles and coordinates of one point are .* not oriented"):
                read(file, text)


@pytest.mark.parametrize("form", ["each", "own block", "station's block"])
def test_reflectors_by_block_are_of_their_sights(file: Path, form: str) -> None:
    place = room(1.3)
    heights = dict.fromkeys(place, 1.3) if form == "each" else None
    first, *rest = blocks_of(place, set(place), heights=heights)
    word = gsi_word(87, 1.3, False)
    more = {"each": [first], "own block": [first, f"110900+00000000 {word}"], "station's block": [f"{first} {word}"]}
    found = survey(read(file, "\n".join([*more[form], *rest])))
    for a, b in zip(survey(read(file, "\n".join(blocks_of(room(), set(room()))))).exits, found.exits, strict=True):
        assert np.allclose(a.exit_point, b.exit_point, atol=5e-4)


def test_a_reflector_that_is_in_some_blocks_alone_is_rejected(file: Path) -> None:
    _, *blocks = blocks_of(room(), set(room()))
    raised = f"{blocks[0]} {gsi_word(87, 1.3, False)}"
    with pytest.raises(InputError, match=r"line 2: the sight has no word 87, that of line 1 has 1\.3 m"):
        read(file, "\n".join([raised, *blocks[1:]]))
    assert len(read(file, "\n".join([f"{blocks[0]} {gsi_word(87, 0.0, False)}", *blocks[1:]])).shots) == len(blocks)


def test_a_lone_point_between_sights_may_be_a_station(file: Path) -> None:
    with pytest.raises(InputError, match="line 2: a block without a measurement before the sight at line 3 may begin"):
        read(file, "\n".join([SIGHT.format(1), "110002+000STAT2 71....+00000PEG", SIGHT.format(3)]))
    found = read(file, "\n".join(["110002+000STAT1", SIGHT.format(1), SIGHT.format(2), "110002+00000END"]))
    assert len(found.shots) == 2
    gone = SIGHT.format(2).replace("00000000", "-" * 8).replace("10000000", "-" * 8).replace("00001000", "-" * 8)
    found = read(file, "\n".join([SIGHT.format(1), gone, SIGHT.format(3)]))
    assert [note.partition(" at")[0] for note in found.notes] == ["X02"]


REFLECTORS = [
    "reflector height (m)", "Target Height [m]", "prism_height_m", "HR", "hr (mm)", "height of target (m)",
    "rod height",
    "Reflektorh\N{LATIN SMALL LETTER O WITH DIAERESIS}he (m)", "Zielhoehe [mm]", "Prismenho\N{COMBINING DIAERESIS}he",
    "H_Prism (cm)", "hauteur prisme (m)", "Pole Ht (m)", "target_h",
]  # fmt: skip
INSTRUMENTS = [
    "instrument height (m)",
    "Instr. Height",
    "HI (mm)",
    "Instrumentenh\u00f6he [m]",
    "ih_m",
    "tripod height",
]


def of_unit(name: str, metres: float) -> str:
    return f"{metres * (1000 if 'mm' in name else 100 if 'cm' in name else 1):.6g}"


@pytest.mark.parametrize("name", REFLECTORS)
def test_heights_of_reflectors_in_a_csv(file: Path, name: str) -> None:
    hz, v, slope = 0.3, 1.2, 4.0
    text = f"point,hz (rad),v (rad),slope (m),{name}\nA,{hz},{v},{slope},{of_unit(name, 1.3)}\nB,0,1.5,2,-"
    (shot,) = (found := read(file, text)).shots
    assert shot.position[2] == pytest.approx(slope * math.cos(v) - 1.3, abs=1e-12)
    assert (shot.reflector, found.notes) == (1.3, ("B at line 3 is left out: reflector height has no value",))
    with pytest.raises(InputError, match="unknown unit 'inch'"):
        read(file, text.replace(name, "Target height (inch)"))
    with pytest.raises(InputError, match="line 2: reflector height: must be at most 20 m; give its unit"):
        read(file, text.replace(name, "TH").replace(f",{of_unit(name, 1.3)}\n", ",1300\n"))


@pytest.mark.parametrize("name", INSTRUMENTS)
def test_heights_of_the_instrument_in_a_csv(file: Path, name: str) -> None:
    height = of_unit(name, 1.6)
    text = f"point,hz (rad),v (rad),slope,{name}\nA,0.3,1.2,4,{height}\nB,1,1.2,4,{height}\n"
    assert {round(shot.position[2], 9) for shot in read(file, text).shots} == {round(4 * math.cos(1.2) + 1.6, 9)}
    with pytest.raises(
        InputError, match=f"line 3: .* is '{of_unit(name, 1.7)}', '{height}' at line 2: sights from one"
    ):
        read(file, f"{of_unit(name, 1.7)}".join(text.rsplit(height, 1)))


def test_the_floor_is_below_the_instrument_for_raised_reflectors_too(file: Path) -> None:
    plan = SurveyPlan.model_validate({"schema": 1, "instrument": {"height": 1.5}})
    where = site()
    rows = [row for row in polar(where, np.random.default_rng(1), 0.0, 0.0, 0.0) if "FLOOR" not in row[0]]
    lifted = replace(where, markers={name: (x, y, z + 0.4) for name, (x, y, z) in where.markers.items()})
    above = [row for row in polar(lifted, np.random.default_rng(1), 0.0, 0.0, 0.0) if "FLOOR" not in row[0]]
    header, *cells = csv(above).splitlines()
    raised = "\n".join([f"{header},target height (m)", *(f"{row},0.4" for row in cells)])
    for a, b in zip(survey(read(file, csv(rows)), plan).exits, survey(read(file, raised), plan).exits, strict=True):
        assert np.allclose(a.exit_point, b.exit_point, atol=2e-4)


@pytest.mark.parametrize("name", ["station", "Station ID", "Standpunkt", "setup", "stn", "station_e (m)", "From"])
def test_sights_of_two_stations_in_a_csv_are_rejected(file: Path, name: str) -> None:
    text = f"{name},point,hz (rad),v (rad),slope\n1,A,0.3,1.2,4\n,B,0.4,1.2,4\n2,C,0.5,1.2,4\n"
    with pytest.raises(InputError, match=r"line 4: .* is '2', '1' at line 2: sights from one station are allowed"):
        read(file, text)
    assert len(read(file, text.replace("2,C", "1,C")).shots) == 3


def test_columns_that_are_not_read_are_named(file: Path) -> None:
    (note,) = read(file, "point,x,y,z,remark,code\nA,1,2,3,4,5").notes
    assert note == "columns that are not read: 'remark', 'code'"
    many = ",".join(f"{k}-{'c' * 90}" for k in range(300))
    (note,) = read(file, f"point,hz (rad),v (rad),slope,{many}\nA,1,1,2{',7' * 300}").notes
    assert "and 294 more" in note
    assert len(note) < 600
