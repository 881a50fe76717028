"""Laws of `Track`: the nearest place by brute force, its side by the tangent, branches of a crossing distinguished."""

from pathlib import Path

import numpy as np
import pytest

from cablewright.models.path_offset import nearest, nearest_of_each
from cablewright.printing.arc_length_path import Track
from cablewright.printing.job import load_job
from cablewright.printing.path import Samples

JOB = Path(__file__).parents[2] / "examples" / "blind-machines.toml"


def samples_of(places: list[tuple[float, float, float]], layer: list[int], laying: list[bool]) -> Samples:
    """Samples at *places*; *layer* and *laying* of the pieces between them."""
    positions = np.array(places)
    distance = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(positions, axis=0), axis=1))])
    k = len(positions)
    layers, on = np.array([layer[0], *layer], dtype=np.int32), np.array([False, *laying])
    numbers = np.arange(k, dtype=np.int32)
    return Samples(positions, distance, np.ones(k), np.zeros(k), numbers.astype(np.int64), on, layers, numbers)


@pytest.fixture(scope="module")
def track() -> Track:
    """Three layers of the exhibition's curve."""
    job = load_job(JOB)
    assert job.curve is not None
    job = job.model_copy(update={"curve": job.curve.model_copy(update={"layers": 3})})
    return Track.of(job.samples(job.toolpath()))


def brute_force(track: Track, point: np.ndarray, around: float, within: float) -> float:
    """Least plan distance to points finely spread over the pieces that touch the window."""
    first = track.piece(around - within)
    stop = max(first + 1, int(np.searchsorted(track.distance, around + within)))
    ends = track.positions[first : stop + 1, :2]
    share = np.linspace(0.0, 1.0, 401)[:, None, None]
    spread = (ends[:-1] + share * (ends[1:] - ends[:-1])).reshape(-1, 2)
    return float(np.hypot(*(spread - point[:2]).T).min())


def test_the_nearest_place_is_that_of_brute_force(track: Track) -> None:
    rng = np.random.default_rng(1)
    for around in rng.uniform(0.0, track.length, 60):
        point = track.at(around).position + rng.normal(0.0, 0.1, 3)
        found = nearest(track, point, around, 0.4)
        least = brute_force(track, point, around, 0.4)
        assert abs(found.offset) <= least + 1e-12
        assert abs(found.offset) == pytest.approx(least, abs=2e-6)
        assert np.hypot(*(track.places([found.distance])[0] - point)[:2]) == pytest.approx(abs(found.offset), abs=1e-9)


def test_a_batch_agrees_with_single_calls(track: Track) -> None:
    rng = np.random.default_rng(2)
    around = rng.uniform(-0.2, track.length + 0.2, 300)
    points = track.places(around) + rng.normal(0.0, 0.05, (300, 3))
    points[7, 0] = np.nan
    distance, offset = nearest_of_each(track, points, around, 0.3)
    assert np.isnan(distance[7])
    assert np.isnan(offset[7])
    for i in np.flatnonzero(np.isfinite(offset)):
        one = nearest(track, points[i], around[i], 0.3)
        assert (distance[i], offset[i]) == pytest.approx((one.distance, one.offset), abs=1e-12)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_left_of_the_path_is_positive(track: Track, side: float) -> None:
    for distance in np.linspace(0.5, track.length - 0.5, 40):
        place = track.at(distance)
        left = np.array([-place.tangent[1], place.tangent[0], 0.0])
        found = nearest(track, place.position + 0.02 * side * left, distance)
        assert found.offset == pytest.approx(0.02 * side, rel=5e-3)
        assert found.distance == pytest.approx(distance, abs=2e-3)


def test_round_a_sharp_corner_the_offset_keeps_its_side_and_size() -> None:
    """Outside a turn of 150 degrees to the left one is right of the path, also straight ahead."""
    turn = np.radians(150.0)
    end = (1.0 + np.cos(turn), np.sin(turn), 0.0)
    track = Track.of(samples_of([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), end], [0, 0], [True, True]))
    for direction in np.linspace(-np.pi / 2, turn - np.pi / 2, 31):
        point = np.array([1.0 + 0.1 * np.cos(direction), 0.1 * np.sin(direction), 0.0])
        assert nearest(track, point, 1.0).offset == pytest.approx(-0.1)


def test_at_the_ends_only_what_is_beside_counts() -> None:
    track = Track.of(samples_of([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)], [0], [True]))
    assert nearest(track, (-0.3, 0.01), 0.0) == pytest.approx((0.0, 0.01))
    assert nearest(track, (1.3, -0.01), 1.0) == pytest.approx((1.0, -0.01))


def test_where_the_path_crosses_itself_the_branch_meant_is_found(track: Track) -> None:
    """On each branch, 1 cm before the crossing and 3 mm off, the other branch would be nearer or as near."""
    once = track.positions[track.layer.searchsorted(1) : int(np.searchsorted(track.layer, 2)) + 1, :2]
    start, way = once[:-1], np.diff(once, axis=0)
    n, found = len(start), []
    for i in range(n):
        for j in range(i + 50, n - 50 if i < 50 else n):
            d = way[i, 0] * way[j, 1] - way[i, 1] * way[j, 0]
            between = start[j] - start[i]
            if d != 0.0:
                s = (between[0] * way[j, 1] - between[1] * way[j, 0]) / d
                t = (between[0] * way[i, 1] - between[1] * way[i, 0]) / d
                if 0.0 <= s < 1.0 and 0.0 <= t < 1.0:
                    found.append((track.distance[i] + s * np.hypot(*way[i]), track.distance[j] + t * np.hypot(*way[j])))
    assert len(found) >= 2
    for branches in found:
        for distance in branches:
            place = track.at(distance - 0.01)
            point = place.position + 0.003 * np.array([-place.tangent[1], place.tangent[0], 0.0])
            near = nearest(track, point, distance, 0.5)
            assert near.offset == pytest.approx(0.003, abs=1e-5)
            assert near.distance == pytest.approx(distance - 0.01, abs=1e-3)


def test_layers_above_each_other_are_distinguished(track: Track) -> None:
    visits = track.visits
    assert visits.number.tolist() == [1, 2, 3]
    assert visits.begin == pytest.approx([0.0, 28.0, 56.0], abs=1e-2)
    for layer, begin in zip(visits.number, visits.begin, strict=True):
        at = nearest(track, track.at(begin + 5.0).position, begin + 5.01)
        assert at.distance == pytest.approx(begin + 5.0, abs=1e-9)
        assert track.layer[track.piece(at.distance)] == layer
        assert track.laying[track.piece(begin + 5.0)]


def test_an_upright_rise_between_two_layers_lays_nothing_and_points_up() -> None:
    square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 0.0)]
    places = [(*xy, 0.1 * layer) for layer in (0, 1) for xy in square]
    track = Track.of(samples_of(places, [0, 0, 0, 1, 1, 1, 1], [True, True, True, False, True, True, True]))
    begin = track.visits.begin[1]
    assert track.at(begin + 0.05).tangent == pytest.approx([0.0, 0.0, 1.0])
    assert not track.laying[track.piece(begin + 0.05)]
    assert nearest(track, (0.3, 0.02), begin + 0.35).distance == pytest.approx(begin + 0.4)
    assert nearest(track, (0.3, 0.02), 0.35) == pytest.approx((0.3, 0.02))


def test_way_back_along_the_same_line_is_where_one_is_meant_to_be() -> None:
    track = Track.of(samples_of([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 0.0)], [0, 1], [True, False]))
    point = (0.7, 0.01)
    assert nearest(track, point, 0.72) == pytest.approx((0.7, 0.01))
    assert nearest(track, point, 1.28) == pytest.approx((1.3, -0.01))


def test_beyond_the_ends_places_stay(track: Track) -> None:
    assert track.at(-1.0).position == pytest.approx(track.positions[0])
    assert track.at(track.length + 1.0).position == pytest.approx(track.positions[-1])
    distances = np.linspace(0.0, track.length, 50)
    assert track.places(distances) == pytest.approx(np.array([track.at(d).position for d in distances]), abs=1e-12)
    assert track.pieces(distances).tolist() == [track.piece(d) for d in distances]


def test_a_path_that_only_rises_has_places_beside_it() -> None:
    track = Track.of(samples_of([(0.0, 0.0, 0.0), (0.0, 0.0, 1.0)], [0], [True]), shift=(1.0, 0.0, 0.0))
    assert nearest(track, (1.0, 0.2, 0.5), 0.5) == pytest.approx((0.0, 0.2))
