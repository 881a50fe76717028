"""Random closed curves: laws of closed curves, and an independent count of crossings."""

from __future__ import annotations

import json

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.printing.random_curve import Curve, CurveRequirements, Curves, draw
from cablewright.printing.random_curve import curves as draw_many

WANTED = CurveRequirements(28.0, (3.6, 8.0))


@pytest.fixture(scope="module")
def found() -> Curves:
    return draw_many(WANTED.length, WANTED.area, count=12, seed=7)


@pytest.fixture(scope="module")
def curves(found: Curves) -> list[Curve]:
    return [one.curve for one in sorted(found.ranked, key=lambda one: one.number)]


def length_of(places: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())


def test_it_closes_and_is_as_long_as_asked(curves: list[Curve]) -> None:
    for curve in curves:
        coarse, fine = length_of(curve.even(2000)), length_of(curve.even(4000))
        assert fine + (fine - coarse) / 3.0 == pytest.approx(28.0, abs=1e-8)  # chords err with the square
        joint = curve.even(4000)
        ahead, behind = joint[1] - joint[0], joint[-1] - joint[-2]
        assert ahead @ behind / np.linalg.norm(ahead) / np.linalg.norm(behind) > 1.0 - 1e-3


def test_it_stays_within_its_area_about_the_origin(curves: list[Curve]) -> None:
    for curve in curves:
        places = curve.even(3000)
        assert (np.abs(places).max(axis=0) <= np.array(WANTED.area) / 2 + 1e-3).all()
        np.testing.assert_allclose(places.max(axis=0), -places.min(axis=0), atol=1e-9)


def test_pieces_are_even(curves: list[Curve]) -> None:
    steps = np.linalg.norm(np.diff(curves[0].even(5000), axis=0), axis=1)
    assert np.ptp(steps) < (steps.mean() / curves[0].min_radius) ** 2 / 24 * 1.01 * steps.mean()  # chords


def test_the_least_radius_is_that_of_circles_through_three_places(curves: list[Curve]) -> None:
    for curve in curves:
        z = curve.even(4000)[:-1] @ [1.0, 1.0j]
        a, b = z - np.roll(z, 1), np.roll(z, -1) - z
        turned = np.abs(np.angle(b / a))
        radii = 28.0 / 4000 / turned
        assert curve.min_radius == pytest.approx(radii.min(), rel=1e-3)
        assert curve.min_radius >= WANTED.min_radius


def turns_round(curve: np.ndarray, place: np.ndarray) -> int:
    angle = np.angle((curve - place) @ [1.0, 1.0j])
    return round(float(np.angle(np.exp(1j * np.diff(angle))).sum() / (2 * np.pi)))


def test_crossings_lie_on_two_branches_that_meet_at_the_angle(curves: list[Curve]) -> None:
    for curve in curves:
        assert len(curve.crossings) >= 2
        places = curve.even(8000)
        for x, y, angle, share in curve.crossings:
            away = np.linalg.norm(places[:-1] - [x, y], axis=1)
            near = np.flatnonzero(away < 0.006)
            assert (np.diff(near, append=near[0] + 8000) > 50).sum() >= 2  # branches
            assert angle >= WANTED.min_angle
            assert np.linalg.norm(places[round(share / (2 * np.pi) * 8000) % 8000] - [x, y]) < 0.01


def test_the_number_of_crossings_has_the_parity_of_whitneys_theorem(curves: list[Curve]) -> None:
    # H. Whitney, On regular closed curves in the plane, 1937: turning number and crossings differ in parity.
    for curve in curves:
        assert (len(curve.crossings) + curve.turns) % 2 == 1


def test_mean_distance_of_a_circle() -> None:
    none = np.zeros(6)
    circle = Curve(2 * np.pi, 1, 0.0, none, none)
    rng = np.random.default_rng(1)
    places = rng.uniform(-1.5, 1.5, (200_000, 2))
    expected = np.abs(np.linalg.norm(places, axis=1) - 1.0).mean()
    assert circle.min_radius == pytest.approx(1.0, rel=1e-12)
    assert len(circle.crossings) == 0
    assert circle.remoteness((3.0, 3.0)) == pytest.approx(expected, rel=0.03)
    assert {turns_round(circle.even(500), np.array(p)) for p in [(0.5, 0.2), (1.2, 0.0)]} == {1, 0}


def test_a_curve_is_the_same_however_many_are_requested(curves: list[Curve]) -> None:
    alone = draw(WANTED, 7, 5)
    np.testing.assert_array_equal(alone.even(100), curves[5].even(100))
    assert not np.allclose(draw(WANTED, 8, 5).even(100), alone.even(100))


def test_the_best_cover_comes_first(found: Curves, curves: list[Curve]) -> None:
    distances = [one.curve.remoteness(WANTED.area) for one in found.ranked]
    assert distances == sorted(distances) == [one.mean_distance for one in found.ranked]
    assert sorted(one.number for one in found.ranked) == list(range(12)) == list(range(len(found)))
    assert found[0].curve is curves[found[0].number]


def test_it_describes_itself(found: Curves) -> None:
    told = found.to_dict()
    assert json.loads(json.dumps(told, allow_nan=False)) == told
    assert told["curves"][0] == found[0].to_dict()
    assert len(repr(found)) < 160
    assert len(repr(found[0])) < 160
    assert found.plot().axes


@pytest.mark.parametrize(
    ("options", "words"), [({"count": 0}, "count = 0"), ({"count": 1001}, "1 to 1000"), ({"seed": -1}, "seed = -1")]
)
def test_options_that_no_drawing_has(options: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        draw_many(**options)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"length": -1.0, "area": (3.6, 8.0)}, "length = -1"),
        ({"length": float("nan"), "area": (3.6, 8.0)}, "length = nan"),
        ({"length": 28.0, "area": (0.0, 8.0)}, "two sides over 0 m"),
        ({"length": 28.0, "area": (3.6, 8.0), "crossings": -1}, "crossings = -1"),
        ({"length": 28.0, "area": (3.6, 8.0), "min_radius": 2.0}, "minimum radius = 2"),
        ({"length": 28.0, "area": (3.6, 8.0), "min_angle": 2.0}, "min_angle = 2"),
    ],
)
def test_what_no_curve_can_be_is_rejected(given: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        CurveRequirements(**given)


def test_a_curve_that_is_too_long_for_its_area_is_said_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cablewright.printing.random_curve._TRIES", 50)
    with pytest.raises(InputError, match=r"none of 50 random curves of 200 m fits into 1 x 1 m"):
        draw(CurveRequirements(200.0, (1.0, 1.0)), 0, 0)
