"""Laws of arcs: every point on the circle or helix, the end exact, pieces equal and short."""

import io
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cablewright.printing.arc import centre_from_offset, centre_from_radius, piece_count, pieces, swept_angle
from cablewright.printing.gcode import parse

NUMBER = st.floats(-100, 100).map(lambda v: round(v, 3))


def arc_of(read, text: str, arc_step: float = 1e-3):
    """Start and points (mm) of the last line of a text, an arc."""
    path = read("M83\nG1 X1000 Y1000 Z1000 E1\n" + text, arc_step)
    rows = path.line == path.line.max()
    return path, path.start[rows][0] * 1e3, path.end[rows] * 1e3, path.extrusion[rows] * 1e3


@pytest.mark.parametrize(
    ("line", "centre", "radius", "sweep"),
    [
        ("G2 X10 Y0 I5 J0", (5, 0), 5, -math.pi),
        ("G3 X10 Y0 I5", (5, 0), 5, math.pi),
        ("G2 X10 Y0 R5", (5, 0), 5, -math.pi),
        ("G3 X10 Y10 R10", (0, 10), 10, math.pi / 2),
        ("G2 X10 Y10 R10", (10, 0), 10, -math.pi / 2),
        ("G3 X10 Y10 R-10", (10, 0), 10, 3 * math.pi / 2),
        ("G2 X10 Y10 R-10", (0, 10), 10, -3 * math.pi / 2),
        ("G3 X10 Y10 J10", (0, 10), 10, math.pi / 2),
        ("G2 X10 Y10 J10", (0, 10), 10, -3 * math.pi / 2),
        ("G2 I5", (5, 0), 5, -math.tau),
        ("G3 X0 Y0 J-5", (0, -5), 5, math.tau),
        ("G3 X10.008 R5", (5.004, 0), 5.004, math.pi),  # three decimals may miss half the chord
    ],
)
@pytest.mark.parametrize("rise", [0, 7])
def test_points_of_an_arc(line, centre, radius, sweep, rise, read):
    _, start, points, extrusion = arc_of(read, f"G1 X0 Y0 Z0\n{line} Z{rise} E6\n")
    assert start == pytest.approx([0, 0, 0])
    arm = points[:, :2] - centre
    assert np.hypot(*arm.T) == pytest.approx(radius, rel=1e-12)
    assert points[:, 2] == pytest.approx(np.linspace(0, rise, len(points) + 1)[1:])
    first = np.array([0.0, 0.0]) - centre
    angles = np.unwrap(np.arctan2(*np.vstack([first, arm]).T[::-1]))
    assert np.diff(angles) == pytest.approx(sweep / len(points))
    assert extrusion == pytest.approx(6 / len(points))


@pytest.mark.parametrize("arc_step", [1e-2, 1e-3, 1e-4])
def test_pieces_are_short_and_flat(arc_step, read):
    for radius in (0.2, 3.0, 50.0):
        _, _, points, _ = arc_of(read, f"G1 X0 Y0\nG3 I{radius} E1\n", arc_step)
        count = len(points)
        assert radius * 1e-3 * math.tau / count <= arc_step * (1 + 1e-9)
        assert radius * 1e-3 * (1 - math.cos(math.pi / count)) <= arc_step / 50 * (1 + 1e-9)


def test_pieces_are_not_many_more_than_needed(read):
    _, _, points, _ = arc_of(read, "G1 X0 Y0\nG3 I50 E1\n", 1e-3)
    assert len(points) == math.ceil(math.tau * 50)
    _, _, points, _ = arc_of(read, "G1 X0 Y0\nG3 I1 E1\n", 1e-3)
    assert len(points) == 64


@pytest.mark.parametrize("arc_error", [1e-3, 1e-5, 1e-6])
def test_pieces_are_cut_by_their_error(arc_error):
    path = parse(io.BytesIO(b"G1 X0 Y0\nG3 I50 E1\n"), 0.5, arc_error=arc_error)
    assert len(path.line) - 1 == max(64, math.ceil(math.pi / math.acos(1 - arc_error / 0.05)))
    middle = (path.start + path.end)[1:, :2] / 2 - [0.05, 0.0]
    assert 0.05 - np.hypot(*middle.T).min() <= arc_error * (1 + 1e-9)


@pytest.mark.parametrize(
    ("line", "turns"), [("G3 I5 P1", 1), ("G3 I5 P3", 3), ("G3 X5 Y5 I5 P1", 0.75), ("G3 X5 Y5 I5 P2", 1.75)]
)
@pytest.mark.parametrize("rise", [0, 0.6])
def test_turns(line, turns, rise, read):
    _, start, points, _ = arc_of(read, f"G1 X0 Y0 Z0\n{line} Z{rise} E1\n", 1e-3)
    length = np.linalg.norm(np.diff(np.vstack([start, points]), axis=0), axis=1).sum()
    assert length == pytest.approx(math.hypot(turns * math.tau * 5, rise), rel=1e-3)
    assert points[-1][2] == pytest.approx(rise)


def test_a_helix_keeps_its_step_along_the_slope(read):
    _, start, points, _ = arc_of(read, "G1 X0 Y0 Z0\nG2 X0 Y0 Z100 I1 E1\n", 1e-3)
    lengths = np.linalg.norm(np.diff(np.vstack([start, points]), axis=0), axis=1)
    assert lengths.max() <= 1 + 1e-9
    assert lengths == pytest.approx(lengths[0])


def test_line_feed_and_place_after_an_arc(read):
    path, _, points, _ = arc_of(read, "G1 X0 Y0\nG92 X100\nG91\nG2 X10 Y0 I5 F600 E1\n")
    assert points[-1] == pytest.approx([10, 0, 1000])
    rows = path.line == path.line.max()
    assert path.feed[rows] == pytest.approx(0.01)


def test_arc_in_inches_and_repeated_by_axes_alone(read):
    _, _, points, _ = arc_of(read, "G1 X0 Y0 Z0\nG20\nG2 X1 R0.5\nX2 Y0 R0.5 E1\n")
    assert points[-1] == pytest.approx([50.8, 0, 0])
    assert points[:, 1].max() == pytest.approx(12.7, rel=1e-2)


@given(NUMBER, NUMBER, NUMBER, NUMBER, st.floats(1, 4), st.booleans(), st.booleans())
def test_radius_spelling_meets_both_ends(x0, y0, x1, y1, stretch, clockwise, longer):
    chord = math.dist((x0, y0), (x1, y1))
    if chord < 1e-2:
        return
    radius = chord / 2 * stretch
    centre = centre_from_radius((x0, y0), (x1, y1), -radius if longer else radius, clockwise)
    sweep = swept_angle((x0, y0), (x1, y1), centre, clockwise)
    assert math.dist(centre, (x0, y0)) == pytest.approx(radius, rel=1e-9)
    assert math.dist(centre, (x1, y1)) == pytest.approx(radius, rel=1e-9)
    assert (sweep < 0) == clockwise
    if stretch > 1.001:
        assert (abs(sweep) > math.pi) == longer


@given(NUMBER, NUMBER, st.floats(0.01, 100), st.floats(0, 6.28), st.floats(0.01, 6.27), st.booleans())
def test_offset_spelling_ends_exactly(x, y, radius, begin, turn, clockwise):
    centre = (x, y)
    start = (x + radius * math.cos(begin), y + radius * math.sin(begin), 1.0)
    sign = -1 if clockwise else 1
    end = (x + radius * math.cos(begin + sign * turn), y + radius * math.sin(begin + sign * turn), 2.0)
    found = centre_from_offset(start[:2], end[:2], (x - start[0], y - start[1]))
    sweep = swept_angle(start[:2], end[:2], found, clockwise)
    assert sweep == pytest.approx(sign * turn, abs=1e-6)
    count = piece_count(radius, sweep, 1.0, 0.05, 0.001)
    points = pieces(start, end, found, sweep, count)
    assert tuple(points[-1]) == end
    assert np.hypot(points[:, 0] - centre[0], points[:, 1] - centre[1]) == pytest.approx(radius, rel=1e-9)
