"""Walls and place from planar lidars: laws of the plane, honest covariance, and what a made-up room does to them."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cablewright.estimation.lidar.localisation import (
    WallPose,
    WallSettings,
    WallState,
    start,
    step,
)
from cablewright.estimation.lidar.noise import estimate_noise
from cablewright.estimation.lidar.room import Laser, RoomMap, RoomWall
from cablewright.estimation.lidar.scan import (
    Clustering,
    LidarModel,
    drift_of,
    find_clusters,
    level_mount,
    level_points,
)
from cablewright.estimation.lidar.wall_lines import LidarTurn, LineSearch, WallLine, find_lines, turn_of
from cablewright.foundation.errors import InputError
from cases import some
from oracles.room import EAST, NORTH, WEST, cast, rectangle, scan
from oracles.room import Room as InRoom

ROOM = rectangle()
KNOWN = RoomMap.of(ROOM.walls)
NORTH_LIDAR = LidarModel("north", mount=(0.1, 0.15, -0.3))
SOUTH_LIDAR = LidarModel("south", mount=(0.0, -0.15, -0.3), yaw=math.pi, visible_walls=("east", "west"))
BOTH = WallSettings(KNOWN, (NORTH_LIDAR, SOUTH_LIDAR))
SEARCH = LineSearch()


def seen(angles, ranges) -> list[WallLine]:
    return [WallLine(*line) for line in find_lines(level_points(LidarModel(), angles, ranges), LidarModel(), SEARCH)]


def turned(settings_: WallSettings, angles, ranges, lidar: int = 0, **how) -> LidarTurn:
    return turn_of(settings_.lidars[lidar], lidar, settings_.search, angles, ranges, **how)


def pose_of(seed: int) -> tuple[float, float, float]:
    rng = np.random.default_rng(seed)
    return float(rng.uniform(-1.7, 1.6)), float(rng.uniform(-3.0, 3.5)), float(rng.uniform(-0.5, 0.5))


def run(
    settings_: WallSettings, pose, rng, turns: int = 3, bias=(0.0, 0.0), room=ROOM, lasers=(), **how
) -> tuple[WallState, WallPose]:
    """Some turns of all lidars at one pose."""
    state = start()
    for _ in range(turns):
        for i, lidar in enumerate(settings_.lidars):
            a, r = scan(room, pose, rng, mount=lidar.mount[:2], lidar_yaw=lidar.yaw, bias=bias[i], **how)
            state, found = step(settings_, state, turned(settings_, a, r, i), lasers)
    return state, found


# Lines


@pytest.mark.parametrize("seed", some(range(6)))
def test_walls_are_where_they_are(seed: int) -> None:
    """Every long line is a wall of the room, the window or a thing; distances within five sigma."""
    x, y, yaw = pose_of(seed)
    lines = seen(*scan(ROOM, (x, y, yaw), np.random.default_rng(seed), spikes=0.03))
    wanted = [(math.pi - yaw, x - WEST), (-yaw, EAST - x), (math.pi / 2 - yaw, NORTH - y), (-yaw, EAST + 0.05 - x)]
    for angle, distance in wanted:
        near = [a for a in lines if abs(math.remainder(a.angle - angle, math.tau)) < 0.02]
        best = min(near, key=lambda line: abs(line.distance - distance))
        assert abs(best.distance - distance) < 5 * math.sqrt(best.covariance[1, 1])
        assert abs(math.remainder(best.angle - angle, math.tau)) < 5 * math.sqrt(best.covariance[0, 0])
        assert math.sqrt(best.variance) < 3e-3


def test_covariance_of_a_line_is_honest() -> None:
    """Over 300 scans, the squared error of angle and distance over their covariance: chi-squared with 2 degrees of
    freedom."""
    pose, squares = (0.4, 0.3, 0.2), []
    for seed in range(300):
        lines = seen(*scan(ROOM, pose, np.random.default_rng(seed)))
        west = min(lines, key=lambda line: abs(math.remainder(line.angle - math.pi + pose[2], math.tau)))
        off = np.array([math.remainder(west.angle - math.pi + pose[2], math.tau), west.distance - (pose[0] - WEST)])
        squares.append(off @ np.linalg.solve(west.covariance, off))
    # points of a flat wall at most; grazing rays are trusted less than their noise here allows, so not over 2
    assert 1.2 < np.mean(squares) < 2.0 + 4 * math.sqrt(4 / 300)
    assert np.mean(np.array(squares) < 5.991) > 0.93


def test_a_bias_moves_lines_as_said() -> None:
    for seed in range(3):
        a, r = scan(ROOM, pose_of(seed), np.random.default_rng(seed))
        plain, off = seen(a, r), seen(a, r + np.where(r > 0, 1e-4, 0.0))
        for one, other in zip(plain, off, strict=True):
            assert other.distance - one.distance == pytest.approx(1e-4 * one.bias_slopes[1], abs=3e-6)
            assert other.angle - one.angle == pytest.approx(1e-4 * one.bias_slopes[0], abs=3e-6)


@settings(deadline=None, max_examples=20)
@given(seed=st.integers(0, 1000), turn=st.floats(-3.1, 3.1))
def test_turning_the_scan_turns_the_walls(seed: int, turn: float) -> None:
    a, r = scan(ROOM, pose_of(seed), np.random.default_rng(seed), spikes=0.02)
    for one, other in zip(seen(a, r), seen(a + turn, r), strict=True):
        assert math.remainder(other.angle - one.angle - turn, math.tau) == pytest.approx(0.0, abs=1e-9)
        assert other.distance == pytest.approx(one.distance, abs=1e-9)
        assert other.point_count == one.point_count
        assert other.covariance == pytest.approx(one.covariance, rel=1e-6)


def test_the_order_of_points_does_not_matter() -> None:
    rng = np.random.default_rng(2)
    a, r = scan(ROOM, (0.3, 0.2, 0.1), rng, spikes=0.02)
    mixed = rng.permutation(len(a))
    for one, other in zip(seen(a, r), seen(a[mixed], r[mixed]), strict=True):
        assert other.angle == one.angle
        assert other.distance == one.distance


def test_mirrored_rooms_have_mirrored_walls() -> None:
    a, r = scan(ROOM, (0.3, 0.2, 0.1), np.random.default_rng(3))
    here, there = seen(a, r), seen(-a, r)
    assert len(here) == len(there)
    for one in here:
        other = min(there, key=lambda line: abs(line.distance - one.distance))
        assert other.distance == pytest.approx(one.distance, abs=1e-6)
        assert math.remainder(other.angle + one.angle, math.tau) == pytest.approx(0.0, abs=1e-6)


def test_clusters_end_at_corners_and_steps() -> None:
    """No cluster has points of two walls, nor of the window and its wall."""
    for seed in range(4):
        x, y, yaw = pose_of(seed)
        a, r = scan(ROOM, (x, y, yaw), np.random.default_rng(seed))
        points = level_points(LidarModel(), a, r)
        c, s = math.cos(yaw), math.sin(yaw)
        world = points.xy @ np.array([[c, s], [-s, c]]) + (x, y)
        on = [np.abs(world[:, 0] - WEST), np.abs(world[:, 0] - EAST), np.abs(world[:, 1] - NORTH)]
        on.append(np.abs(world[:, 0] - EAST - 0.05))
        owner = np.where(np.min(on, axis=0) < 0.012, np.argmin(on, axis=0), -1)
        members, firsts, sizes, _ = find_clusters(points, 2e-3, Clustering())
        for first, size in zip(firsts, sizes, strict=True):
            owners = owner[members[first : first + size]]
            most = np.bincount(owners + 1).max()
            assert most >= size - 2


def test_noise_is_estimated() -> None:
    for sigma in (1e-3, 2e-3, 5e-3, 0.02):
        a, r = scan(ROOM, (0.3, 0.2, 0.1), np.random.default_rng(4), sigma=sigma)
        assert 0.8 * sigma < estimate_noise(level_points(LidarModel(), a, r)) < 1.6 * sigma


def test_masked_bearings_do_not_count() -> None:
    a, r = scan(ROOM, (0.3, 0.2, 0.1), np.random.default_rng(5))
    r[(a > 3.0) & (a < 3.6)] = 0.3  # the drum
    assert len(level_points(LidarModel(masks=((3.0, 3.6),)), a, r)) < len(level_points(LidarModel(), a, r))
    across = LidarModel(masks=((-0.3, 0.3),))
    bearings = np.arctan2(*level_points(across, a, r).xy.T[::-1])
    assert np.abs(bearings).min() > 0.29


def test_what_did_not_come_back_does_not_count() -> None:
    a, r = scan(ROOM, (0.3, 0.2, 0.1), np.random.default_rng(6))
    for none in (0.0, math.nan, math.inf, -1.0, 1e308):
        holed = r.copy()
        holed[::7] = none
        assert len(level_points(LidarModel(), a, holed)) < len(level_points(LidarModel(), a, r))
        assert len(seen(a, holed)) >= 4


@pytest.mark.parametrize(
    "ranges",
    [np.full(720, math.nan), np.zeros(720), np.full(720, 3.0), np.full(720, 0.2), np.empty(0), np.ones(1), np.ones(2)],
)
def test_no_wall_in_sight(ranges: np.ndarray) -> None:
    """Nothing, a round room, points too near: said, never a crash, and the state stays."""
    angles = np.linspace(0, math.tau, len(ranges), endpoint=False)
    state = replace(start(), yaw=0.1, position=(1.0, 2.0))
    state, found = step(WallSettings(KNOWN), state, turned(WallSettings(KNOWN), angles, ranges))
    assert found.status == "no-wall"
    assert np.isnan(found.position).all()
    assert "no wall is in sight" in found.note
    assert (state.yaw, state.position) == (0.1, (1.0, 2.0))


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(0, 300), st.sampled_from([0.01, 0.3, 5.0]))
def test_any_points_give_an_answer(seed: int, n: int, spread: float) -> None:
    rng = np.random.default_rng(seed)
    ranges = np.abs(rng.normal(2.0, spread, n))
    ranges[rng.random(n) < 0.1] = rng.choice([math.nan, math.inf, 0.0])
    _, found = step(WallSettings(KNOWN), start(), turned(WallSettings(KNOWN), rng.uniform(-7, 7, n), ranges))
    assert found.status in ("ok", "ambiguous", "parallel", "no-wall")


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 0.3), st.sampled_from(["variance", "evidence"]))
def test_any_room_gives_an_answer(seed: int, jump: float, rank: str) -> None:
    """Straight things anywhere, a platform that jumps between turns: an answer with a status, never a crash."""
    rng = np.random.default_rng(seed)
    room = InRoom(rng.uniform(-4, 4, (rng.integers(1, 9), 1, 2)) + rng.normal(0, 3, (1, 2, 2)))
    wide = replace(BOTH, rank=rank, yaw_range=(-math.pi, math.pi), lidars=(NORTH_LIDAR,))
    state, pose = start(), rng.normal(0, 1, 3)
    for _ in range(4):
        pose = pose + rng.normal(0, jump, 3)
        state, found = step(wide, state, turned(wide, *scan(room, tuple(pose), rng)))
        assert found.status in ("ok", "ambiguous", "parallel", "no-wall")
        known = np.isfinite(found.position).all()
        assert known == (found.status in ("ok", "ambiguous"))
        assert np.linalg.eigvalsh(found.covariance).min() > 0 if known else np.isnan(found.covariance[0, 0])


# Place


def test_place_is_found_and_its_covariance_is_honest() -> None:
    """60 random poses, two biased lidars, outliers: within 2 mm always; chi-squared with 3 degrees of freedom."""
    squares, worst = [], 0.0
    for seed in range(60):
        rng, pose = np.random.default_rng(seed), pose_of(seed)
        _, found = run(BOTH, pose, rng, bias=rng.normal(0, 2e-3, 2), spikes=0.02)
        assert found.status == "ok"
        off = np.array([*(found.position - pose[:2]), found.yaw - pose[2]])
        squares.append(off @ np.linalg.solve(found.covariance, off))
        worst = max(worst, float(np.abs(off[:2]).max()))
    assert worst < 2e-3
    assert np.mean(squares) == pytest.approx(3.0, abs=4 * math.sqrt(6 / 60))


def test_moving_the_room_moves_the_place() -> None:
    """The frame of the walls is the frame of the answer: a room turned and shifted by a law of its own."""
    pose, turn, shift = (0.4, -0.3, 0.1), 0.3, np.array([3.0, -1.0])
    c, s = math.cos(turn), math.sin(turn)
    R = np.array([[c, -s], [s, c]])
    walls = []
    for wall in KNOWN.walls:
        n = R @ np.array(wall.normal)
        walls.append(RoomWall(wall.name, (n[0], n[1]), wall.distance + float(n @ shift)))
    low, high = BOTH.yaw_range
    moved = replace(BOTH, room=RoomMap(tuple(walls)), yaw_range=(low + turn, high + turn))
    _, one = run(BOTH, pose, np.random.default_rng(1))
    _, other = run(moved, pose, np.random.default_rng(1))
    assert other.position == pytest.approx(R @ one.position + shift, abs=1e-9)
    assert other.yaw == pytest.approx(one.yaw + turn, abs=1e-9)


def test_constraints_are_the_papers() -> None:
    """a x + b y + c = 0 with b = 1 and a small for C, a = 1 and b small for D, true at the true place."""
    pose = pose_of(3)
    _, found = run(BOTH, pose, np.random.default_rng(3), turns=1)
    kinds = set()
    for i in found.used:
        one = found.constraints[i]
        lead = one.normal[1] if one.kind == "C" else one.normal[0]
        a, b, c = one.normal[0] / lead, one.normal[1] / lead, -one.offset / lead
        assert (b if one.kind == "C" else a) == 1.0
        assert abs(a if one.kind == "C" else b) < 1e-9
        assert a * pose[0] + b * pose[1] + c == pytest.approx(0.0, abs=0.01)
        kinds.add(one.kind)
    assert kinds == {"C", "D"}
    north, south = found.turns
    assert (north.lidar, south.lidar) == (0, 1)
    assert all(one.kind == "D" for one in found.constraints if one.line >= len(north))


def test_a_window_is_not_the_wall() -> None:
    """The papers' rank takes the window where its points scatter least; the share of points explained does not."""
    wrong = 0
    for seed in range(20):
        rng, pose = np.random.default_rng(seed), pose_of(seed)
        _, found = run(BOTH, pose, rng)
        assert abs(found.candidates[0].position[0] - pose[0]) < 0.01
        by_variance = replace(BOTH, rank="variance")
        _, paper = run(by_variance, pose, np.random.default_rng(seed))
        wrong += abs(paper.candidates[0].position[0] - pose[0]) > 0.03
        variances = [one.variance for one in paper.candidates]
        assert variances == sorted(variances)
    assert wrong > 0


def test_the_operators_laser_picks() -> None:
    pose = pose_of(5)
    by_variance = replace(BOTH, rank="variance")
    for wrong in (0.0, -0.05):
        lasers = (Laser("west", pose[0] + wrong - WEST),)
        _, found = run(by_variance, pose, np.random.default_rng(5), lasers=lasers)
        assert found.candidates[0].position[0] == pytest.approx(pose[0] + wrong, abs=0.01)
        assert found.candidates[0].laser_misfit < 3
    _, found = run(by_variance, pose, np.random.default_rng(5), lasers=(Laser("north", 1.0),))
    assert found.status == "ambiguous"
    assert "no position agrees with the laser" in found.note


def test_one_direction_only_is_said() -> None:
    only = WallSettings(KNOWN, (SOUTH_LIDAR,))
    _, found = run(only, (0.3, 0.2, 0.1), np.random.default_rng(7), turns=1)
    assert found.status == "parallel"
    assert np.isnan(found.position).all()
    assert found.yaw == pytest.approx(0.1, abs=1e-3)
    assert "position along them is not known" in found.note


def test_east_taken_for_west_is_caught() -> None:
    """With any yaw allowed, three walls determine north; a fourth that the survey does not have makes it doubtful.

    Never is a wrong place called sure, and a laser decides.
    """
    wide = replace(BOTH, yaw_range=(-math.pi, math.pi))
    doubted = 0
    for seed in range(20):
        rng = np.random.default_rng(seed)
        x, y, _ = pose_of(seed)
        pose = x, y, float(rng.uniform(-math.pi, math.pi))
        for south in (False, True):
            for lasers in ((), (Laser("north", NORTH - y),)):
                _, found = run(wide, pose, rng, turns=2, room=rectangle(south=south), lasers=lasers)
                right = abs(math.remainder(found.yaw - pose[2], math.tau)) < 2e-3
                right &= bool(np.abs(found.position - pose[:2]).max() < 3e-3)
                assert right or found.status == "ambiguous", (seed, south, lasers)
                doubted += found.status == "ambiguous"
                if not south:
                    assert found.status == "ok"
                if lasers and abs(NORTH - y - (y + 5.2)) > 0.1:  # the other end is not as far
                    assert right, (seed, south)
    assert doubted > 5


def square() -> InRoom:
    corners = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0), (-2.0, -2.0)]
    return InRoom(np.array(list(pairwise(corners))))


def square_settings() -> WallSettings:
    walls = {"west": ((-1, 0), 2.0), "east": ((1, 0), 2.0), "north": ((0, 1), 2.0), "south": ((0, -1), 2.0)}
    return WallSettings(RoomMap.of(walls), yaw_range=(-math.pi, math.pi))


def test_a_square_room_is_ambiguous() -> None:
    """Four equal walls look the same at four yaws: said, not guessed; a laser decides."""
    room, wide = square(), square_settings()
    pose = (0.5, -0.7, 0.2)
    _, found = run(wide, pose, np.random.default_rng(1), turns=1, room=room)
    assert found.status == "ambiguous"
    lasers = (Laser("west", 2.5), Laser("south", 1.3))
    _, found = run(wide, pose, np.random.default_rng(1), turns=1, room=room, lasers=lasers)
    assert found.status == "ok"
    assert [*found.position, found.yaw] == pytest.approx(pose, abs=2e-3)


def test_the_yaw_is_followed_through_whole_turns() -> None:
    """Turn by turn the yaw may go round; each answer starts the next one's range."""
    rng, state = np.random.default_rng(2), start()
    settings_ = WallSettings(KNOWN)
    for yaw in np.arange(0.0, 7.0, 0.15):
        state, found = step(settings_, state, turned(settings_, *scan(ROOM, (0.2, 1.0, yaw), rng)))
        assert math.remainder(found.yaw - yaw, math.tau) == pytest.approx(0.0, abs=2e-3)
        assert found.position == pytest.approx((0.2, 1.0), abs=3e-3)


def test_where_it_was_decides() -> None:
    """A square room looks the same at four yaws; who knows where the platform was is not in doubt, and sees a jump."""
    room, wide, pose = square(), square_settings(), (0.5, -0.7, 0.2)
    state = WallState(yaw=0.25, position=(0.4, -0.6))
    turn = turned(wide, *scan(room, pose, np.random.default_rng(1)))
    _, found = step(replace(wide, yaw_step=math.pi), state, turn)
    assert found.status == "ok"
    assert [*found.position, found.yaw] == pytest.approx(pose, abs=2e-3)
    _, jumped = step(wide, replace(state, position=(-1.0, 1.5)), turn)
    assert jumped.status == "ambiguous"
    assert "the position jumps" in jumped.note


def test_a_lost_position_is_found_again() -> None:
    """While nothing is seen the platform goes far: the old place counts for some turns, then not."""
    only = WallSettings(KNOWN, (NORTH_LIDAR,), max_misses=4)
    rng, state = np.random.default_rng(3), start()
    state, found = step(only, state, turned(only, *scan(ROOM, (1.0, 3.0, 0.1), rng)))
    assert found.status == "ok"
    there = (-1.2, -2.0, -0.4)
    said = []
    for _ in range(6):
        state, found = step(only, state, turned(only, *scan(ROOM, there, rng, mount=NORTH_LIDAR.mount[:2])))
        said.append(found.status)
    assert said[0] != "ok"
    assert said[-1] == "ok"
    assert [*found.position, found.yaw] == pytest.approx(there, abs=2e-3)


def test_a_jump_is_never_taken_for_the_old_place() -> None:
    """Carried elsewhere between two turns, whatever is called sure is right: old lines do not outvote new points."""
    only, sure = WallSettings(KNOWN, (LidarModel(),)), 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        state, _ = step(only, start(), turned(only, *scan(ROOM, pose_of(seed), rng)))
        there = pose_of(1000 + seed)
        _, found = step(only, state, turned(only, *scan(ROOM, there, rng)))
        if found.status == "ok":
            sure += 1
            assert [*found.position, found.yaw] == pytest.approx(there, abs=0.03)
    assert sure < 60


def test_what_others_do_not_know_does_no_harm() -> None:
    """NaN as tilt, drift or motion: those rays or turns do not count, and the next turn is as good as ever."""
    only = WallSettings(KNOWN, (LidarModel(),))
    rng, pose = np.random.default_rng(4), (0.3, 0.2, 0.1)
    tilt, drift = np.zeros((720, 2)), np.zeros((720, 3))
    tilt[100:110] = math.nan
    drift[200:210, 1] = math.nan
    state, found = step(only, start(), turned(only, *scan(ROOM, pose, rng), tilt=tilt, drift=drift))
    assert [*found.position, found.yaw] == pytest.approx(pose, abs=2e-3)
    state, found = step(only, state, turned(only, *scan(ROOM, pose, rng)), moved=(math.nan, 0.0, 0.0))
    assert [*found.position, found.yaw] == pytest.approx(pose, abs=2e-3)
    state, found = step(only, state, turned(only, *scan(ROOM, pose, rng), tilt=(math.nan, 0.0)))
    assert math.isfinite(found.yaw)  # from the older turns
    state, found = step(only, state, turned(only, *scan(ROOM, pose, rng)))
    assert [*found.position, found.yaw] == pytest.approx(pose, abs=2e-3)
    _, found = step(only, start(), turned(only, *scan(ROOM, pose, rng), tilt=(math.nan, 0.0)))
    assert found.status == "no-wall"


def test_motion_known_from_other_sensors_corrects_scans() -> None:
    """3 cm/s: three turns spread over 6 cm; with `moved` they fall on one place, without within the paper's 2 cm."""
    north = replace(BOTH, lidars=(NORTH_LIDAR,))
    for known in (True, False):
        rng, state, errors = np.random.default_rng(8), start(), []
        before = np.array([-0.5, -0.5, 0.0])
        for k in range(12):
            pose = np.array([-0.5 + 0.018 * k, -0.5 + 0.024 * k, 0.02 * k])
            moved = tuple((pose - before).tolist()) if known else (0.0, 0.0, 0.0)
            a, r = scan(ROOM, tuple(pose), rng, mount=NORTH_LIDAR.mount[:2])
            state, found = step(north, state, turned(north, a, r), moved=moved)
            errors.append(np.abs(found.position - pose[:2]).max())
            before = pose
        assert max(errors) < (2e-3 if known else 0.04)


def test_a_leaning_platform_is_made_level() -> None:
    """A lidar that leans sees walls farther away by 1 / cos; with the tilt they are where they are."""
    tilt, pose = (math.radians(3.0), math.radians(-5.0)), (0.4, 0.3, 0.2)
    lidar = LidarModel(mount=(0.0, 0.0, -0.4))
    angle = math.hypot(*tilt)
    k = np.array([tilt[0], tilt[1], 0.0]) / angle
    K = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    R = np.eye(3) + math.sin(angle) * K + (1 - math.cos(angle)) * K @ K  # Rodrigues
    c, s = math.cos(pose[2]), math.sin(pose[2])
    yaw = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    a = np.linspace(0, math.tau, 720, endpoint=False)
    rays = np.stack([np.cos(a), np.sin(a), 0 * a], 1) @ (yaw @ R).T
    centre = yaw @ R @ np.array(lidar.mount)
    level = cast(ROOM, np.array(pose[:2]) + centre[:2], np.arctan2(rays[:, 1], rays[:, 0]))
    r = level / np.hypot(rays[:, 0], rays[:, 1]) + np.random.default_rng(9).normal(0, 2e-3, 720)
    only = WallSettings(KNOWN, (lidar,))
    _, found = step(only, start(), turned(only, a, r, tilt=tilt))
    assert [*found.position, found.yaw] == pytest.approx(pose, abs=2e-3)
    assert level_mount(lidar, tilt) == pytest.approx((R @ np.array(lidar.mount))[:2], abs=1e-12)
    _, wrong = step(only, start(), turned(only, a, r))
    assert np.abs(wrong.position - pose[:2]).max() > 0.02


def test_a_scan_during_motion_is_corrected() -> None:
    """Rays one after another while the platform moves, turns and swings: with its drift known walls are straight."""
    lidar, velocity, rate = LidarModel(mount=(0.1, 0.0, -0.5), yaw=0.3), (0.05, -0.03), 0.06
    times = np.linspace(0.0, 0.9, 720)
    end = np.array([0.4, 0.3, 0.2])
    a = np.linspace(0, math.tau, 720, endpoint=False)
    tilt = 0.02 * np.stack([np.sin(2.0 * times), np.cos(3.0 * times)], axis=1)
    rng, r = np.random.default_rng(9), np.empty(720)
    for k, time in enumerate(times - times[-1]):
        x, y, yaw = end + np.array([*velocity, rate]) * time
        rx, ry = tilt[k]
        K = np.array([[0, 0, ry], [0, 0, -rx], [-ry, rx, 0]])
        angle = math.hypot(rx, ry)
        c, s = math.cos(yaw), math.sin(yaw)
        lean = np.eye(3) + math.sin(angle) / angle * K + (1 - math.cos(angle)) / angle**2 * K @ K
        R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ lean
        ray = R @ [math.cos(a[k] + 0.3), math.sin(a[k] + 0.3), 0.0]
        centre = np.array([x, y]) + (R @ lidar.mount)[:2]
        r[k] = cast(ROOM, centre, np.array([math.atan2(ray[1], ray[0])]))[0] / math.hypot(ray[0], ray[1])
    r += rng.normal(0, 2e-3, 720)
    only = WallSettings(KNOWN, (lidar,))
    since = times - times[-1]
    drift = drift_of(np.outer(since, velocity), rate * since, end[2])
    _, found = step(only, start(), turned(only, a, r, tilt=tilt, drift=drift))
    assert [*found.position, found.yaw] == pytest.approx(end, abs=2e-3)
    assert max(math.sqrt(found.constraints[i].variance) for i in found.used) < 3e-3
    _, skewed = step(only, start(), turned(only, a, r))
    assert np.abs(skewed.position - end[:2]).max() > 0.01


# Rejections


def test_rejections() -> None:
    a, r = scan(ROOM, (0, 0, 0), np.random.default_rng(0))
    with pytest.raises(InputError, match="lidar 1: must be from 0 to 0"):
        step(WallSettings(KNOWN), start(), turn_of(LidarModel(), 1, SEARCH, a, r))
    with pytest.raises(InputError, match="as many angles as ranges"):
        step(WallSettings(KNOWN), start(), turned(WallSettings(KNOWN), a, r[:-1]))
    with pytest.raises(InputError, match="a tilt \\(2,\\) or \\(n, 2\\) and a drift"):
        step(WallSettings(KNOWN), start(), turned(WallSettings(KNOWN), a, r, drift=np.zeros((3, 3))))
    with pytest.raises(InputError, match="room: no wall 'south'; it has west, east, north"):
        step(WallSettings(KNOWN), start(), turned(WallSettings(KNOWN), a, r), (Laser("south", 1.0),))
    with pytest.raises(InputError, match="0 walls"):
        WallSettings(RoomMap(()))
    with pytest.raises(InputError, match="two walls are named 'a'"):
        RoomMap((RoomWall("a", (1, 0), 1), RoomWall("a", (0, 1), 1)))
    with pytest.raises(InputError, match="a unit normal"):
        RoomMap((RoomWall("a", (1, 1), 1),))
    with pytest.raises(InputError, match="at most one turn apart"):
        WallSettings(KNOWN, yaw_range=(1.0, 1.0))
    with pytest.raises(InputError, match="sigma over 0"):
        LidarModel(sigma=0.0)
