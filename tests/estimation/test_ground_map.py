"""The ground that was seen: each cell has what was seen last, and no other place answers for it."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.estimation.kalman.ground_map import GroundMap
from cablewright.foundation.arrays import Array

_ROW = np.array([[0.03 * i, 0.0] for i in range(40)])
"""Places, m, in as many cells."""


def test_a_cell_has_the_mean_of_its_last_points() -> None:
    ground = GroundMap()
    places = np.array([[-0.001, -2.001], [-0.012, -2.012], [0.001, -2.001], [3.0, 4.0]])
    assert not ground.at(places).known.any()
    ground.write(places[:3], np.array([0.01, 0.03, 0.5]))
    heights, may_have_grown, known, *_ = ground.at(places)
    assert known.tolist() == [True, True, True, False]
    assert heights[:3] == pytest.approx([0.02, 0.02, 0.5])
    assert not may_have_grown[:3].any()
    ground.write(places[1:2], np.array([0.04]))
    assert ground.at(places).heights[:3] == pytest.approx([0.04, 0.04, 0.5])


@pytest.mark.parametrize("apart", [(25.6, 0.0), (0.0, 25.6), (-51.2, 25.6), (25.6 * 40_009, 0.0)])
def test_no_place_answers_for_another_that_shares_its_memory(apart: tuple[float, float]) -> None:
    ground, here = GroundMap(), np.array([[0.51, -1.01]])
    ground.growth = 1e-3
    there = here + apart
    ground.write(here, np.array([0.1]))
    ground.passing(*(here[0] - 0.05))
    ground.passing(*here[0])
    assert not ground.at(here).may_be_floor.any()
    assert not ground.at(there).known.any()
    assert ground.at(there).may_be_floor.all()
    ground.write(there, np.array([0.2]))
    assert not ground.at(here).known.any()
    assert ground.at(here).may_be_floor.all()
    assert ground.at(there).heights == pytest.approx([0.2])


def test_the_path_near_each_place_is_counted() -> None:
    """Of a straight way of the nozzle, the chord of 50 cm about each place, however it is divided into steps."""
    distances = np.array([0.0, 0.12, 0.18, 0.4, 0.55])
    places = np.array([[x, y] for y in distances for x in np.linspace(0.8, 1.2, 33)])
    chords = 2.0 * np.sqrt(np.maximum(0.5**2 - distances**2, 0.0))
    for step in (0.01, 0.11, 2.0):
        ground = GroundMap()
        ground.write(places, np.zeros(len(places)))
        for x in np.arange(0.0, 2.001, step):
            ground.passing(x, 0.0)
        ground.growth = 1e-3
        free = ground.at(places).may_be_floor.reshape(5, -1).mean(axis=1)
        assert free == pytest.approx([0.0, 0.0, 1.0, 1.0, 1.0])  # within 15 cm it may be laid on
        grown = ground.at(places).may_have_grown.reshape(5, -1).mean(axis=1)
        assert grown == pytest.approx(1e-3 * chords, abs=7e-5)


def test_who_stands_or_comes_from_far_away_has_laid_nothing() -> None:
    ground, random = GroundMap(), np.random.default_rng(3)
    ground.growth = 1e-3
    for x, y in 5e-3 * random.standard_normal((1000, 2)):
        ground.passing(x, y)
    ground.passing(100.0, 0.0)
    assert ground.at(np.array([[0.0, 0.0], [50.0, 0.0], [100.0, 0.0]])).may_be_floor.all()


def test_ground_that_grows_is_expected_to_and_known_until_it_has_grown_much() -> None:
    """1.5 mm each time that the nozzle passes; the floor beside its way stays as it is."""
    ground, laid = GroundMap(), np.arange(40) < 30
    ground.passing(-2.0, 0.0)

    def layer() -> None:
        for corner in ((-2.0, 0.0), (1.5, 0.0), (1.5, -2.0), (-2.0, -2.0)):
            ground.passing(*corner)

    for number in range(1, 70):
        layer()
        ground.write(_ROW, laid * (0.02 + 1.5e-3 * number))
    layer()
    expected = ground.at(_ROW)
    assert expected.known.all()
    assert expected.heights[laid] == pytest.approx(0.02 + 1.5e-3 * 70, abs=2e-4)
    assert expected.may_have_grown[laid] == pytest.approx(1.5e-3, abs=2e-4)
    assert expected.heights[~laid] == pytest.approx(0.0, abs=1e-5)
    for _ in range(20):
        layer()
    assert not ground.at(_ROW).known[laid].any()


def test_floor_beside_laid_material_counts_as_long_as_it_is_seen() -> None:
    """The foot of laid material may hide it: 30 cm beside the path, where two metres of path near it are too much."""
    ground, beside, far = GroundMap(), np.array([[0.0, 0.3]]), np.array([[0.0, 0.6]])
    ground.growth = 1e-3
    ground.write(beside, np.zeros(1))
    ground.passing(-1.0, 0.0)
    counts = []
    for way in range(6):
        ground.passing(1.0 if way % 2 == 0 else -1.0, 0.0)
        counts.append(bool(ground.at(beside).may_be_floor[0]))
        if way == 2:
            ground.write(beside, np.array([1e-3]))
    assert counts == [True, True, False, True, True, False]
    assert ground.at(far).may_be_floor.all()
    ground.write(beside, np.array([0.01]))
    assert not ground.at(beside).may_be_floor.any()


def test_what_was_floor_just_now_is_not_what_was_floor_once() -> None:
    ground, here = GroundMap(), np.array([[0.0, 0.0], [0.0, 0.1]])
    ground.passing(-1.0, 0.0)
    ground.write(here, np.array([2e-3, 9e-3]))
    assert ground.at(here).was_floor.tolist() == [True, False]
    ground.passing(-0.6, 0.0)
    assert ground.at(here).was_floor.tolist() == [True, False]
    ground.passing(-0.4, 0.0)
    assert not ground.at(here).was_floor.any()


def test_where_nothing_is_laid_the_floor_stays_the_floor() -> None:
    """Thirty ways over it with the valve shut, seen at each of them with 2 mm of noise: nothing is seen to grow."""
    ground, random = GroundMap(), np.random.default_rng(11)
    places = np.array([[0.03 * i, 0.03 * j] for i in range(40) for j in range(3)])
    for _ in range(30):
        for x in (-0.5, 0.2, 0.6, 1.0, 1.7):
            ground.passing(x, 0.0)
            ground.write(places, 2e-3 * random.standard_normal(len(places)))
        ground.passing(1.7, 1.0)
        ground.passing(-0.5, 1.0)
    assert ground.at(places).may_be_floor.mean() > 0.95
    for _ in range(5):
        for corner in ((1.7, 0.0), (1.7, 1.0), (-0.5, 1.0), (-0.5, 0.0)):
            ground.passing(*corner)
    heights, _, known, *_ = ground.at(places)
    assert known.all()
    assert abs(float(heights.mean())) < 1e-3


def test_ground_over_no_number_is_not_passed() -> None:
    ground = GroundMap()
    for place in ((0.0, 0.0), (np.nan, 0.0), (np.inf, 1.0), (np.inf, 1.0), (0.5, 0.0)):
        ground.passing(*place)
    ground.growth = 1e-3
    assert not ground.at(np.array([[0.25, 0.0]])).may_be_floor.any()


def test_what_comes_and_goes_and_what_goes_up_a_wall_is_no_growth() -> None:
    ground = GroundMap()
    for height in (0.1, 0.5, 1.7, 0.1):
        ground.passing(0.0, 0.0)
        ground.passing(1.2, 0.0)
        ground.write(_ROW, np.full(40, height))
    assert ground.growth == 0.0


def test_the_map_is_that_of_a_dictionary_of_cells() -> None:
    """Positions at random, cells of which some are seen again, and the nozzle's way between."""
    ground, random, known = GroundMap(), np.random.default_rng(5), _Dictionary()
    shares = np.zeros(3)
    for number in range(45):
        if number % 3 == 0:
            x, y = random.uniform(-0.6, 0.6, 2)
            ground.passing(x, y)
            known.passing(x, y)
        places = random.uniform(-0.7, 0.7, (200, 2)) + np.array([25.6 * (number % 20 == 19), 0.0])
        expected, found = known.at(places), ground.at(places)
        for one, other in zip(found, expected, strict=True):
            assert one == pytest.approx(other, rel=1e-5, abs=1e-6, nan_ok=True)
        shares += [each.mean() / 45 for each in found[2:]]
        heights = random.choice([1e-3, 2e-2], 200) * (1.0 + 0.02 * number) + 1e-3 * random.standard_normal(200)
        ground.write(places, heights)
        known.write(places, heights)
        assert ground.growth == pytest.approx(known.growth, rel=1e-5)
    assert known.growth > 0.0
    assert ((shares > 0.05) & (shares < 0.95)).all()


class _Dictionary:
    """The map of the ground as a dictionary of cells."""

    def __init__(self) -> None:
        self.growth, self._gone, self._before = 0.0, 0.0, np.full(2, np.nan)
        self._cells: dict[tuple[int, int], dict[str, float]] = {}

    def _cell(self, place: Array) -> dict[str, float]:
        row, column = (int(each) for each in np.floor(place / 0.025))
        for square in {(r, c) for r in (-1024, 0, 1024) for c in (-1024, 0, 1024)} - {(0, 0)}:
            self._cells.pop((row + square[0], column + square[1]), None)
        new = {"height": np.nan, "growth": np.nan, "laid": 0.0, "path": 0.0, "path_seen": 0.0, "seen_at": 0.0}
        return self._cells.setdefault((row, column), new)

    def passing(self, x: float, y: float) -> None:
        before, self._before = self._before, np.array([x, y])
        away = float(np.hypot(*(self._before - before)))
        if not away > 0.0:
            return
        self._gone += away
        steps = int(np.ceil(away / 0.05))
        for kind, reach in (("path", 0.5), ("laid", 0.15)):
            offsets = np.arange(-reach, reach + 0.025, 0.025)
            near = [(a, b) for b in offsets for a in offsets if np.hypot(a, b) <= reach]
            for there in np.linspace([x, y], before, steps, endpoint=False):
                for offset in near:
                    self._cell(there + offset)[kind] += away / steps

    def write(self, places: Array, heights: Array) -> None:
        cells = [self._cell(place) for place in places]
        rises = [
            (height - cell["height"]) / (cell["path"] - cell["path_seen"])
            for cell, height in zip(cells, heights, strict=True)
            if cell["path"] - cell["path_seen"] > 0.5 and abs(height - cell["height"]) < 0.03
        ]
        if len(rises) >= 16:
            self.growth = max(0.0, self.growth + 0.05 * (float(np.median(rises)) - self.growth))
        for cell in {id(cell): cell for cell in cells}.values():
            seen = float(np.mean([height for each, height in zip(cells, heights, strict=True) if each is cell]))
            path, rise = cell["path"] - cell["path_seen"], seen - cell["height"]
            if path > 0.0 and abs(rise) < 0.03:
                own = self.growth if np.isnan(cell["growth"]) else cell["growth"]
                cell["growth"] = (rise + 6.0 * own) / (path + 6.0)
            cell.update(height=seen, path_seen=cell["path"], seen_at=self._gone)

    def at(self, places: Array) -> list[Array]:
        found = []
        for place in places:
            row, column = (int(each) for each in np.floor(place / 0.025))
            cell = self._cells.get((row, column))
            if cell is None:
                found.append([np.nan, 0.0, False, True, False])
                continue
            path, own = cell["path"] - cell["path_seen"], cell["growth"]
            rate, height = self.growth if np.isnan(own) else own, cell["height"]
            grown = max(rate, self.growth) * path
            free = self.growth < 3e-4 or (cell["laid"] == 0.0 and path <= 2.0)
            may_be, was = free and not height > 5e-3, height < 5e-3 and self._gone - cell["seen_at"] < 0.5
            found.append([height + rate * path, grown, not np.isnan(height) and grown <= 0.02, may_be, was])
        return list(np.array(found).T)


def test_a_map_takes_memory_only_where_ground_is_seen() -> None:
    """All is 0 at first, which costs a control step nothing; a scan across 10 m writes to few pages of 4 KiB."""
    ground, way = GroundMap(), np.linspace(-5.0, 5.0, 700)
    places = np.stack([way, 0.3 * way], axis=1)
    assert not ground.at(places).known.any()
    cells = ground._marks, ground._kept
    assert not any(each.view(np.uint8).any() for each in cells)
    ground.write(places, np.zeros(700))
    assert ground.at(places).known.all()
    pages = [each.view(np.uint8).reshape(-1, 4096).any(axis=1).sum() for each in cells]
    assert sum(pages) < 150
    assert sum(each.nbytes for each in cells) > 20 << 20
