"""The ground that was seen: each cell has what was seen last, and no other place answers for it."""

from __future__ import annotations

import numpy as np
import pytest

from cablewright.estimation.kalman.ground_map import GroundMap


def test_a_cell_has_the_mean_of_what_was_seen_there_last() -> None:
    ground = GroundMap()
    places = np.array([[-0.001, -2.001], [-0.012, -2.012], [0.001, -2.001], [3.0, 4.0]])
    assert not ground.at(places, 0.0)[1].any()
    ground.write(places[:3], np.array([0.01, 0.03, 0.5]), 0.0)
    heights, known = ground.at(places, 0.0)
    assert known.tolist() == [True, True, True, False]
    assert heights[:3] == pytest.approx([0.02, 0.02, 0.5])
    ground.write(places[1:2], np.array([0.04]), 0.0)
    assert ground.at(places, 0.0)[0][:3] == pytest.approx([0.04, 0.04, 0.5])


@pytest.mark.parametrize("apart", [(25.6, 0.0), (0.0, 25.6), (-51.2, 25.6), (25.6 * 40_009, 0.0)])
def test_no_place_answers_for_another_that_shares_its_memory(apart: tuple[float, float]) -> None:
    ground, here = GroundMap(), np.array([[0.51, -1.01]])
    there = here + apart
    ground.write(here, np.array([0.1]), 0.0)
    assert not ground.at(there, 0.0)[1].any()
    ground.write(there, np.array([0.2]), 0.0)
    assert not ground.at(here, 0.0)[1].any()
    assert ground.at(there, 0.0)[0] == pytest.approx([0.2])


def test_ground_that_grows_is_expected_to_and_known_until_it_has_grown_much() -> None:
    """1.5 mm each 900 s, as by layers; the floor beside it stays as it is."""
    ground, places = GroundMap(), np.array([[0.03 * i, 0.0] for i in range(40)])
    laid = np.arange(40) < 30
    for layer in range(40):
        ground.write(places, laid * (0.02 + 1.5e-3 * layer), 900.0 * layer)
    last = 900.0 * 39
    assert ground.growth == pytest.approx(1.5e-3 / 900.0, rel=0.2)
    later, known = ground.at(places, last + 900.0)
    assert known.all()
    assert later == pytest.approx(laid * (0.02 + 1.5e-3 * 40), abs=4e-4)
    assert not ground.at(places, last + 10_000.0)[1].any()


def test_where_nothing_grows_nothing_is_forgotten() -> None:
    ground, places = GroundMap(), np.array([[0.03 * i, 0.0] for i in range(40)])
    for time in (0.0, 1000.0, 2000.0):
        ground.write(places, np.zeros(40), time)
    heights, known = ground.at(places, 1e6)
    assert known.all()
    assert np.abs(heights).max() == 0.0


def test_what_was_seen_later_than_now_is_not_known() -> None:
    """The machine's clock was set back."""
    ground, here = GroundMap(), np.array([[0.1, 0.2]])
    ground.write(here, np.array([0.1]), 1e9 + 40.0)
    assert ground.at(here, 1e9 + 40.0)[1].all()
    assert not ground.at(here, 3.0)[1].any()


def test_who_stands_on_the_ground_and_what_goes_up_a_wall_is_no_growth() -> None:
    ground, places = GroundMap(), np.array([[0.03 * i, 0.0] for i in range(40)])
    for time, height in ((0.0, 0.1), (120.0, 0.5), (240.0, 1.7), (360.0, 0.1)):
        ground.write(places, np.full(40, height), time)
    assert ground.growth == 0.0
