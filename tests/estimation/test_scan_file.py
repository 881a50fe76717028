"""Files of scans: every way to write one gives the same points, and whatever else is rejected in one line."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from cablewright.estimation.lidar.scan import LidarModel
from cablewright.estimation.lidar.scan_file import FileScan, read_scan
from cablewright.estimation.lidar.wall_lines import LineSearch, turn_of
from cablewright.foundation.errors import InputError
from oracles.room import rectangle, scan

ROOT = Path(__file__).resolve().parents[2]
ANGLES, RANGES = scan(rectangle(), (0.4, -0.6, 0.2), np.random.default_rng(1))


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("scans")


def read(folder: Path, content: str | bytes | object, suffix: str = "csv", **how) -> FileScan:
    file = folder / f"scan.{suffix}"
    if not isinstance(content, str | bytes):
        content = json.dumps(content)
    file.write_bytes(content.encode() if isinstance(content, str) else content)
    return read_scan(file, **how)


def rows(header: str, *columns, separator: str = ",") -> str:
    lines = [header] if header else []
    return "\n".join(lines + [separator.join(f"{v:.12g}" for v in row) for row in zip(*columns, strict=True)])


X, Y = RANGES * np.cos(ANGLES), RANGES * np.sin(ANGLES)
DEGREES = np.degrees(ANGLES)
LIST = {"x": X.tolist(), "y": Y.tolist()}
ROS = {"angle_min": 0.0, "angle_increment": math.tau / 720, "ranges": RANGES.tolist()}


def dump(rows_of_list: bool, frame: str = "laser") -> str:
    """A laser scan as ROS prints it: lists in rows in ROS 2, in brackets in ROS 1."""
    head = f"header:\n  stamp:\n    sec: 1\n  frame_id: {frame}\nangle_min: 0.0\nangle_increment: {math.tau / 720!r}\n"
    values = [repr(float(v)) if v > 0 else (".inf" if rows_of_list else "inf") for v in RANGES]
    if rows_of_list:
        return head + "ranges:\n" + "".join(f"- {v}\n" for v in values) + "intensities: []\n---\n"
    return head + "ranges: [" + ",\n  ".join(values) + "]\nintensities: []\n---\n"


WAYS = {
    "xy": (rows("x,y", X, Y), "csv", {}),
    "xy in mm": (rows("x (mm);y (mm)", 1e3 * X, 1e3 * Y, separator=";"), "csv", {}),
    "xy guessed as mm": (rows("x,y", 1e3 * X, 1e3 * Y), "txt", {}),
    "polar": (rows("angle (rad),distance (m)", ANGLES, RANGES), "csv", {}),
    "polar guessed": (rows("quality\ttheta\tdist", ANGLES, DEGREES, 1e3 * RANGES, separator="\t"), "tsv", {}),
    "no header": (
        rows("", DEGREES, 1e3 * RANGES, ANGLES, separator=" "),
        "txt",
        {"columns": ["angle", "distance", "q"]},
    ),
    "clockwise": (rows("angle (deg),range (cm)", -DEGREES, 100 * RANGES), "csv", {"clockwise": True}),
    "given": (rows("angle,distance", 200 / math.pi * ANGLES, 1e3 * RANGES), "csv", {"unit": "mm", "angle_unit": "gon"}),
    "pairs": (np.stack([X, Y], 1).tolist(), "json", {}),
    "points": ({"points": np.stack([X, Y], 1).tolist()}, "json", {}),
    "objects": ([{"x": x, "y": y} for x, y in zip(X, Y, strict=True)], "json", {}),
    "polar objects": ([{"angle": a, "distance": d} for a, d in zip(DEGREES, RANGES, strict=True)], "json", {}),
    "lists": (LIST, "json", {}),
    "polar lists": ({"angles": ANGLES.tolist(), "ranges": RANGES.tolist()}, "json", {}),
    "ros": (ROS, "json", {}),
    "foxglove": (
        {"start_angle": 0.0, "end_angle": ANGLES[-1], "ranges": RANGES.tolist(), "frame_id": "lidar"},
        "json",
        {},
    ),
    "rplidar": (
        [{"angle": a, "distance": 1e3 * d, "quality": 47} for a, d in zip(DEGREES, RANGES, strict=True)],
        "json",
        {},
    ),
    "foxglove message": ({"topic": "/scan", "message": ROS}, "json", {}),
    "ros 2 echo": (dump(rows_of_list=True), "yaml", {}),
    "ros 1 echo": (dump(rows_of_list=False), "txt", {}),
    "one of two": (dump(True, "rear") + dump(True, "front"), "yaml", {"device": "front"}),
    "one of two by name": ({"front": ROS, "rear": {"points": [[1, 2]]}}, "json", {"device": "front"}),
    "one of two topics": (
        [{"topic": "/rear", "msg": ROS | {"ranges": [1.0]}}, {"topic": "/front", "msg": ROS}],
        "json",
        {"device": "/front"},
    ),
}


@pytest.mark.parametrize("way", WAYS)
def test_ways_to_write_a_scan(folder: Path, way: str) -> None:
    content, suffix, how = WAYS[way]
    found = read(folder, content, suffix, **how)
    assert len(found.ranges) == 720
    hit = RANGES > 0
    assert not np.isfinite(found.ranges[~hit]).any()
    assert np.allclose(found.ranges[hit], RANGES[hit], atol=1e-6)
    turn = np.remainder(found.angles[hit] - ANGLES[hit] + math.pi, math.tau) - math.pi
    assert np.allclose(turn, 0.0, atol=1e-6)
    assert len(turn_of(LidarModel(), 0, LineSearch(), found.angles, found.ranges)) >= 4


def test_guesses_are_reported(folder: Path) -> None:
    found = read(folder, rows("angle,distance", DEGREES, 1e3 * RANGES))
    assert (found.length_unit, found.angle_unit) == ("mm", "deg")
    assert [note.split(":")[0] for note in found.guessed] == ["lengths taken as mm", "angles taken as deg"]
    found = read(folder, rows("angle (deg),distance (m)", DEGREES, RANGES))
    assert found.guessed == ()


def test_no_echo_in_many_ways(folder: Path) -> None:
    found = read(folder, "angle (deg),distance (m)\n1,nan\n2,0\n3,inf\n4,\n5,-1\n6,2.5\n7,NaN")
    assert np.isnan(found.ranges[[0, 1, 3, 4, 6]]).all()
    assert found.ranges[5] == 2.5
    found = read(folder, '{"angle_min": 0, "angle_increment": 0.1, "ranges": [null, 1.5, NaN, Infinity]}', "json")
    assert found.ranges[1] == 1.5
    assert not np.isfinite(found.ranges[[0, 2, 3]]).any()


def test_quality_0_is_no_echo_and_rplidars_are_reported(folder: Path) -> None:
    points = [{"angle": 0.5 * i, "distance": 2000.0 + i, "quality": i % 3} for i in range(12)]
    found = read(folder, points, "json")
    assert np.isnan(found.ranges[::3]).all()
    assert found.ranges[1] == pytest.approx(2.001)
    assert found.angles[2] == pytest.approx(math.radians(1.0))
    assert any("as RPLIDARs give them" in note for note in found.guessed)
    assert any("give --clockwise" in note for note in found.guessed)


def test_echoes_outside_the_limits_of_a_message_are_none(folder: Path) -> None:
    message = {"angle_min": 0, "angle_increment": 0.1, "ranges": [0.05, 1.5, "Infinity", 31.0, "nan"]}
    found = read(folder, message | {"range_min": 0.1, "range_max": 30.0}, "json")
    assert np.isnan(found.ranges[[0, 2, 3, 4]]).all()
    assert found.ranges[1] == 1.5


def test_of_several_scans_the_first_is_read_and_reported(folder: Path) -> None:
    found = read(folder, dump(True) + dump(True), "yaml")
    assert (len(found.ranges), found.device) == (720, "laser")
    assert found.guessed == ("the first of 2 scans in the file is used",)


@pytest.mark.parametrize(
    ("content", "suffix", "how", "says"),
    [
        ("", "csv", {}, "empty; columns x,y or angle,distance are expected"),
        ("x,y\n", "csv", {}, "no points"),
        ("1,2\n3,4", "csv", {}, "line 1: no header; name the columns, as in --columns angle,distance"),
        ("a,b\n3,4", "csv", {}, "columns x,y or angle,distance are expected"),
        ("x,z\n3,4", "csv", {}, "not 'x, z'"),
        ("1,2", "csv", {"columns": ["a", "b"]}, "not 'a, b'"),
        ("x (foot),y\n3,4", "csv", {}, "unknown unit 'foot'"),
        ("x (m),y (mm)\n3,4", "csv", {}, "x and y have different units"),
        ("x,x,y\n3,4,5", "csv", {}, "more than one column 'x'"),
        ("x,y\n3", "csv", {}, "line 2: 1 cells; 2 are expected"),
        ("x,y\n3,four", "csv", {}, "line 2: y = 'four': must be a number"),
        ("x,y\n3," + "4" * 41, "csv", {}, "must be a number"),
        ("x,y\n" + "1,1\n" * 100_001, "csv", {}, "more than 100000 points"),
        ("x,y\n3,4", "csv", {"unit": "inch"}, "--unit = 'inch': must be one of m, mm"),
        ("angle,distance\n3,4", "csv", {"angle_unit": "turn"}, "--angle-unit = 'turn': must be one of rad"),
        ("x,y\n3000,4000", "csv", {"unit": "m"}, "the median range is 5000 m"),
        (b"x,y\n3,\xff", "csv", {}, "line 2: not UTF-8"),
        ("{", "json", {}, "not JSON"),
        ("[" * 100_000, "json", {}, "not JSON"),
        ("[1, 2]", "json", {}, "point 1 = '1': a pair of numbers is expected"),
        ("[[1], [2]]", "json", {}, "a pair of numbers"),
        ('[["a", "b"]]', "json", {}, "x 1 = '\"a\"': a number or null is expected"),
        ("[[true, 1]]", "json", {}, "a number or null is expected"),
        ("[]", "json", {}, "no points"),
        ("3", "json", {}, "a list of points or an object with lists is expected"),
        ('{"x": [1, 2], "y": [1]}', "json", {}, "2 of x, but 1 of y"),
        ('{"x": 1, "y": [1]}', "json", {}, "columns x,y or angle,distance are expected"),
        ('{"angle_min": "a", "angle_increment": 1, "ranges": []}', "json", {}, "a number or null is expected"),
        ('{"angle_min": 1, "angle_increment": 1, "ranges": 3}', "json", {}, "ranges = '3': a list of numbers"),
        ("[[1, " + "9" * 400 + "]]", "json", {}, "a whole number of hundreds of digits"),
        (dump(True, "a") + dump(True, "b"), "yaml", {}, "scans of 2 devices: 'a', 'b'; choose one with --device"),
        ({"a": ROS, "b": ROS}, "json", {"device": "c"}, "--device = 'c': must be one of 'a', 'b'"),
        (dump(True).replace("intensities: []", "- '...'"), "yaml", {}, "ranges is cut short by '...'"),
        ("angle_min: 0\n  what is this\n", "yaml", {}, "line 2: 'what is this': expected KEY: VALUE"),
        ("ranges: [1, 2,\n3", "yaml", {}, "line 1: 'ranges: [1, 2,': the list has no end"),
        ("", "yaml", {}, "no points"),
        (b"ranges: [\xff]", "yaml", {}, "not UTF-8"),
        (rows("angle,distance (m)", DEGREES, RANGES), "csv", {"angle_unit": "rad"}, "span 57.22 turns; check the unit"),
        (rows("angle (deg),distance", DEGREES, RANGES), "csv", {"unit": "mm"}, "too small for a room; check the unit"),
        ('[{"x": 1}, {"y": 2}]', "json", {}, "columns x,y or angle,distance are expected"),
    ],
)
def test_what_is_rejected(folder: Path, content: str | bytes, suffix: str, how: dict, says: str) -> None:
    with pytest.raises(InputError) as error:
        read(folder, content, suffix, **how)
    assert says in str(error.value)
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 400


def test_large_files_are_not_read(folder: Path) -> None:
    with pytest.raises(InputError, match="larger than 8388608 bytes, the maximum size of a scan"):
        read(folder, b" " * (8 << 20) + b"x", "json")
    large = folder / "large.yaml"
    with large.open("wb") as file:
        file.truncate(60_000_000)
    with pytest.raises(InputError, match="larger than 8388608 bytes"):
        read_scan(large)


def judged(folder: Path, content: bytes, suffix: str) -> None:
    """Whatever it is, it becomes walls or one short line."""
    said = ""
    try:
        found = read(folder, content, suffix)
        turn_of(LidarModel(), 0, LineSearch(), found.angles, found.ranges)
    except InputError as error:
        said = str(error)
    assert "\n" not in said
    assert len(said) < 600


FUZZ = settings(deadline=None, max_examples=120, suppress_health_check=[HealthCheck.function_scoped_fixture])
GOOD = [(rows("angle,distance", DEGREES, 1e3 * RANGES).encode(), "csv"), (json.dumps(ROS).encode(), "json")]
GOOD.append((dump(True).encode(), "yaml"))
LEAF = st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=5)
TREE = st.recursive(
    LEAF,
    lambda inner: (
        st.lists(inner, max_size=5)
        | st.dictionaries(
            st.sampled_from(
                [
                    "x",
                    "y",
                    "points",
                    "ranges",
                    "angle_min",
                    "angle_increment",
                    "angle",
                    "distance",
                    "quality",
                    "topic",
                    "msg",
                ]
            ),
            inner,
        )
    ),
    max_leaves=12,
)


@FUZZ
@given(data=st.binary(max_size=200), suffix=st.sampled_from(["csv", "json", "yaml", "txt"]))
@example(data=b"\x0b", suffix="csv")
def test_any_bytes(folder: Path, data: bytes, suffix: str) -> None:
    judged(folder, data, suffix)


@FUZZ
@given(tree=TREE)
def test_any_json(folder: Path, tree: object) -> None:
    judged(folder, json.dumps(tree).encode(), "json")


@FUZZ
@given(good=st.sampled_from(GOOD), at=st.integers(0, 9000), gone=st.integers(0, 60), new=st.binary(max_size=10))
def test_wounded_files(folder: Path, good: tuple[bytes, str], at: int, gone: int, new: bytes) -> None:
    judged(folder, good[0][:at] + new + good[0][at + gone :], good[1])


def test_the_example_follows_its_rule() -> None:
    a, r = scan(rectangle(), (0.4, -0.6, math.radians(12)), np.random.default_rng(2023), spikes=0.01)
    lines = [
        "# Synthetic, no lidar has measured this: the rule is in tests/estimation/test_scan_file.py.",
        "angle,distance",
    ]
    lines += [f"{math.degrees(angle):.2f},{1e3 * far:.0f}" for angle, far in zip(a, r, strict=True)]
    assert (ROOT / "examples" / "scan.csv").read_text() == "\n".join(lines) + "\n"
