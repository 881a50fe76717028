"""Levels of detail keep what they promise."""

from itertools import pairwise

import numpy as np
import pytest

from cablewright.apps.web import path_scene
from cablewright.apps.web.detail_levels import LEFT_OUT, levels, packed, unpacked
from cablewright.apps.web.path_scene import PathScene, Quantity
from cablewright.foundation import memory_mapped


def distances(points, kept):
    """Distance of each point from the chord of the kept points around it."""
    found = np.zeros(len(points))
    at = np.flatnonzero(kept)
    for begin, end in pairwise(at):
        chord, away = points[end] - points[begin], points[begin : end + 1] - points[begin]
        share = np.clip(away @ chord / max(chord @ chord, 1e-300), 0.0, 1.0)
        found[begin : end + 1] = np.linalg.norm(away - share[:, None] * chord, axis=1)
    return found


@pytest.fixture
def wander():
    """A path that turns at all scales."""
    return np.cumsum(np.random.default_rng(3).normal(size=(3000, 3)), axis=0)


def test_nothing_is_farther_from_a_level_than_its_tolerance(wander):
    tolerances = np.array([8.0, 2.0, 0.5])
    found = levels(wander, np.zeros(len(wander), dtype=bool), tolerances)
    for number, tolerance in enumerate(tolerances):
        assert distances(wander, found <= number).max() <= tolerance * (1 + 1e-12)
    counts = [int((found <= number).sum()) for number in range(3)]
    assert counts[0] < counts[1] < counts[2] <= len(wander)


def test_a_straight_line_needs_its_ends_alone():
    line = np.linspace([0, 0, 0], [1, 2, 3], 300)
    found = levels(line, np.zeros(300, dtype=bool), np.array([1e-6]))
    assert np.flatnonzero(found != LEFT_OUT).tolist() == [0, 299]


def test_what_is_fixed_is_in_every_level(wander):
    fixed = np.zeros(len(wander), dtype=bool)
    fixed[[17, 1234]] = True
    assert (levels(wander, fixed, np.array([1e9, 1.0]))[fixed] == 0).all()


def test_the_worst_sample_and_every_break_are_kept():
    count = 5000
    t = np.linspace(0, 1, count)
    error = np.full(count, 1e-3)
    error[3210] = 0.5
    laid = t % 0.1 < 0.08
    path = PathScene(
        np.column_stack([t, t * 0, t * 0]),
        laid,
        (t * 4).astype(int),
        1.0,
        [Quantity.of("e", "e", "m", error)],
        worst=3210,
    )
    assert path.level[3210] == 0
    changes = np.flatnonzero(np.diff(path.kind.astype(int)))
    assert (path.level[changes] == 0).all()


def test_colours_are_as_near_as_places():
    """A value that changes along a straight line needs vertices, where it is not linear."""
    t = np.linspace(0, 1, 4000)
    value = np.sin(9 * t)
    path = PathScene(
        np.column_stack([t, t * 0, t * 0]), t >= 0, np.zeros(4000, int), 1.0, [Quantity.of("v", "v", "m", value)]
    )
    kept = path.overview
    assert 10 < len(kept) < 400
    assert np.abs(np.interp(t, t[kept], value[kept]) - value).max() < 0.05 * np.ptp(value)


@pytest.mark.parametrize(("kind", "top"), [("u8", 255), ("u16", 65_535), ("u32", 4_000_000_000)])
@pytest.mark.parametrize("delta", [False, True])
def test_arrays_come_back(kind, top, delta):
    given = np.random.default_rng(1).integers(0, top, size=(50, 3))
    assert (unpacked(packed(given, kind, delta=delta)) == given).all()


def test_a_number_that_does_not_fit_is_rejected():
    with pytest.raises(OverflowError, match="u16"):
        packed(np.array([70_000]), "u16")


def test_a_long_path_in_pieces_has_the_levels_of_the_whole(monkeypatch, wander):
    def levels_of() -> np.ndarray:
        laid, layer = np.arange(len(wander)) % 700 > 5, np.arange(len(wander)) // 900
        places = wander.copy()
        places[1000:1003] = np.nan
        colour = Quantity.of("error", "error", "m", np.abs(wander[:, 0]))
        path = PathScene(places, laid, layer, 300.0, (colour,), worst=1234)
        np.testing.assert_array_equal(path.bounds, [np.nanmin(places, axis=0), np.nanmax(places, axis=0)])
        return path.level

    monkeypatch.setattr(path_scene, "PIECE", 512)
    monkeypatch.setattr(memory_mapped, "BLOCK", 100)
    pieces = levels_of()
    monkeypatch.undo()
    np.testing.assert_array_equal(levels_of(), pieces)
    assert len(np.unique(pieces)) > 4
