import numpy as np
import pytest
from benchmarks.campaigns import tag_pictures
from benchmarks.campaigns.camera_rooms import seen

import cablewright as cw
from cablewright.calibration.sightings.detection import MIN_SIDE, Sighting, detected, in_light, measured
from cablewright.kernels.fitting import sighting
from cablewright.models.rotation import matrices
from cablewright.robot.direction import facing

LENS = np.array([800.0, 805.0, 325.0, 236.0, -0.12, 0.05, 1e-3, -5e-4, 0.01])
CAMERA = cw.Camera(width=640, height=480, focal=(800.0, 805.0), principal=(325.0, 236.0), distortion=tuple(LENS[4:]))
AHEAD = np.diag([1.0, -1.0, -1.0])  # a tag that faces the camera


def _tag(rng: np.random.Generator, depth: float, size: float = 0.16, turn: float = 0.3) -> tag_pictures.Tag:
    place = np.array([rng.uniform(-0.2, 0.2) * depth, rng.uniform(-0.15, 0.15) * depth, depth])
    return tag_pictures.Tag(int(rng.integers(587)), size, place, matrices(rng.normal(0.0, turn, 3)) @ AHEAD)


def _true(tag: tag_pictures.Tag, found: Sighting) -> np.ndarray:
    half = 0.5 * tag.size
    square = np.array([[-half, half], [half, half], [half, -half], [-half, -half]])
    corners = tag_pictures.pixel_of(LENS, tag.place + square @ tag.rotation[:, :2].T)
    ends = [(corners[at], corners[(at + 1) % 4]) for at in range(4)]
    pairs = zip(found.normals, ends, strict=True)
    return np.array([(n @ (one + two), n @ (one - two)) for n, (one, two) in pairs]).ravel()


def test_edges_are_found_to_the_stated_sigma() -> None:
    rng = np.random.default_rng(1)
    errors = []
    for _ in range(30):
        tag = _tag(rng, rng.uniform(1.2, 4.0))
        flaws = tag_pictures.Flaws(blur=rng.uniform(0.5, 0.9))
        picture = tag_pictures.picture(LENS, 640, 480, [tag], rng, flaws)
        for number, corners in detected(picture.astype(float)):
            found = measured(in_light(picture), CAMERA, number, corners)
            if isinstance(found, Sighting):
                assert number == tag.number
                errors.append((found.values - _true(tag, found)) / found.sigmas)
    normal = np.array(errors).ravel()
    assert len(errors) >= 25
    assert 0.4 < np.sqrt(np.mean(normal**2)) < 1.3
    assert np.abs(normal).max() < 5.0
    assert abs(normal.mean()) < 0.4


def test_a_large_tag_is_read_at_eight_metres_and_a_small_one_is_too_far() -> None:
    rng = np.random.default_rng(2)
    large = tag_pictures.Tag(7, 0.4, np.array([0.5, 0.3, 8.0]), AHEAD)
    picture = tag_pictures.picture(LENS, 640, 480, [large], rng)
    found = seen(picture, CAMERA, "far.png")
    assert [each.number for each in found.sightings] == [7]
    assert found.sightings[0].side > MIN_SIDE
    depth = 0.4 * 800.0 / found.sightings[0].side
    assert depth == pytest.approx(8.0, rel=0.02)
    small = np.array([[100.0, 100.0], [124.0, 100.0], [124.0, 124.0], [100.0, 124.0]])
    words = measured(in_light(picture), CAMERA, 8, small)
    assert words == "too far: its side is 24 px; at least 25 px are required"


def test_a_blurred_tag_is_left_out() -> None:
    rng = np.random.default_rng(3)
    tag = tag_pictures.Tag(3, 0.16, np.array([0.0, 0.0, 2.0]), AHEAD)
    found = seen(tag_pictures.picture(LENS, 640, 480, [tag], rng, tag_pictures.Flaws(motion=9.0)), CAMERA, "blur.png")
    assert not found.sightings


def test_a_black_stripe_over_an_edge_moves_no_edge_silently() -> None:
    rng = np.random.default_rng(4)
    tag = tag_pictures.Tag(3, 0.16, np.array([0.0, 0.0, 1.5]), AHEAD)
    picture = tag_pictures.picture(LENS, 640, 480, [tag], rng)
    sharp = next(iter(detected(picture.astype(float))))[1]
    picture[:, 310:330] = 5
    assert isinstance(measured(in_light(picture), CAMERA, 3, sharp), str)


def _bodies(theta: np.ndarray, mounted: tuple[float, float]) -> np.ndarray:
    """Return a camera and a tag whose 16 numbers each are *theta* (32,)."""
    bodies = np.zeros((2, sighting.BODY_COLUMNS))
    bodies[:, sighting.BASE : sighting.HALF] = np.array(facing((0.3, -1.0, 0.2), (0.0, 0.1, 1.0))).T.ravel()
    if mounted[0]:
        bodies[0, sighting.BASE : sighting.HALF] = np.diag([1.0, -1.0, -1.0]).ravel()
        bodies[1, sighting.BASE : sighting.HALF] = np.eye(3).ravel()
    else:
        z = np.array([0.1, 1.0, -0.1]) / np.linalg.norm([0.1, 1.0, -0.1])
        x = np.cross(z, [0.0, 0.0, 1.0])
        bodies[0, sighting.BASE : sighting.HALF] = np.column_stack([x, np.cross(z, x), z]).ravel()
    bodies[:, sighting.HALF], bodies[:, sighting.UNIT], bodies[:, sighting.MOUNTED] = 0.1, 800.0, mounted
    bodies[:, : sighting.NUMBERS] = theta.reshape(2, -1)
    for body in bodies:
        sighting.place_body(body, np.zeros((3, 3)), np.zeros((3, 3)))
    return bodies


@pytest.mark.parametrize("mounted", [(0.0, 1.0), (1.0, 0.0)], ids=["camera in the room", "camera on the platform"])
def test_derivatives_of_an_edge_are_those_of_differences(mounted: tuple[float, float]) -> None:
    rng = np.random.default_rng(5)
    theta = np.zeros(32)
    theta[:3], theta[16:19] = ((0.0, 0.0, 0.0), (0.1, 0.2, 0.0)) if mounted[0] else ((0.2, -2.0, 0.1), (0.1, 0.2, 0.0))
    theta[3:6], theta[19:22] = rng.normal(0.0, 0.1, (2, 3))
    theta[6:15] = np.append(LENS[:4] / 800.0, LENS[4:])
    theta[[15, 31]] = 1.0, 0.98
    pose = np.array([0.1, 0.3, 1.8 if mounted[0] else 0.2, 0.05, -0.1, 0.2])
    extra = np.array([1.0, -1.0, 0.6, 0.8, 0.0, 0.0])

    def value(numbers: np.ndarray, at: np.ndarray) -> float:
        slope, by = np.zeros(6), np.zeros((2, sighting.NUMBERS))
        turned = np.ascontiguousarray(matrices(at[3:]))
        return float(sighting.edge(_bodies(numbers, mounted), 0, 1, extra, at, turned, slope, by))

    slope, by = np.zeros(6), np.zeros((2, sighting.NUMBERS))
    rotation = np.ascontiguousarray(matrices(pose[3:]))
    assert np.isfinite(sighting.edge(_bodies(theta, mounted), 0, 1, extra, pose, rotation, slope, by))
    step = 1e-6
    for at in range(32):
        change = step * np.eye(32)[at]
        expected = (value(theta + change, pose) - value(theta - change, pose)) / (2.0 * step)
        assert by.ravel()[at] == pytest.approx(expected, abs=2e-4 + 1e-6 * abs(expected)), at
    for axis in range(6):
        change = step * np.eye(6)[axis]
        moved = [cw_moved(pose, sign * change) for sign in (1.0, -1.0)]
        expected = (value(theta, moved[0]) - value(theta, moved[1])) / (2.0 * step)
        assert slope[axis] == pytest.approx(expected, abs=2e-4 + 1e-6 * abs(expected)), axis


def cw_moved(pose: np.ndarray, motion: np.ndarray) -> np.ndarray:
    from cablewright.models.rotation import moved

    return moved(pose, motion)
