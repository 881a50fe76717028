"""Which set-ups of a camera reach a required accuracy of exit points, by computation: no picture is taken.

Tags are projected where they would be seen, with the standard deviations that the detection reaches on rendered
pictures; the information of lengths and sightings together gives the covariance of exit points. With a number of rooms
the same set-ups are calibrated from pixels: ``python -m benchmarks.campaigns.camera_setups --rooms 20``.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import cablewright as cw
from benchmarks.campaigns import tag_pictures
from benchmarks.campaigns.camera_rooms import Room, Setup, exit_errors, in_camera, layout_of, room
from cablewright.calibration.measurement_rows.pictures import as_body
from cablewright.calibration.poses.observability import information
from cablewright.calibration.poses.problem import StraightProblem
from cablewright.calibration.sightings.detection import MIN_SIDE, SeenPicture, Sighting, mean_side
from cablewright.calibration.sightings.expected import EDGE_SIGMAS
from cablewright.calibration.unknowns import exit_rows

Array = NDArray[np.float64]
NEED = 3e-3  # m
_OBLIQUE = 0.35  # cosine of the angle of view, under which a tag is not counted on


@dataclass(frozen=True)
class Case:
    """A robot, its set-up, and what else is known."""

    words: str
    robot: str
    setup: Setup
    plan: cw.CalibrationPlan


def scaled(name: str, size: float) -> cw.Robot:
    """Return a robot of the library with exit points and frame so large that the frame's longest side is *size*, m."""
    robot = cw.load(name)
    scene = robot.scene
    by = size / float(np.subtract(scene.frame_max, scene.frame_min).max())
    lines = [line.model_copy(update={"exit_point": tuple(by * x for x in line.exit_point), "winch_exit": None})
             for line in robot.lines]  # fmt: skip
    frame = {key: tuple(by * x for x in getattr(scene, key)) for key in ("frame_min", "frame_max")}
    grown = robot.model_copy(update={"lines": tuple(lines), "scene": scene.model_copy(update=frame)})
    return cw.Robot.model_validate(grown.model_dump())


HD = Setup(width=1920, height=1080, focal=1500.0, size=0.15, poses=20, at=(3.8, -3.2, 1.5))
_FINE = cw.CalibrationPlan(sigma={"encoder": 1e-4})
_PLAN = cw.CalibrationPlan(sigma={"encoder": 5e-4})
_LEVEL = cw.CalibrationPlan(sigma={"encoder": 1e-4}, level=1e-3)
_LARGE = replace(HD, size=0.3)
_EXACT = replace(_LARGE, encoder=1e-4)
_CARRIED = replace(_EXACT, camera="platform", focal=1000.0, at=(0.0, 0.0, 0.0))
CASES = (
    Case("8 lines, encoders to 0.5 mm, tags of 150 mm", "ipanema", HD, _PLAN),
    Case("8 lines, encoders to 0.5 mm, tags of 300 mm", "ipanema", _LARGE, _PLAN),
    Case("8 lines, encoders to 0.5 mm, 12 Mpx", "ipanema",
         replace(_LARGE, width=4000, height=3000, focal=3100.0), _PLAN),
    Case("8 lines, encoders to 0.5 mm, 60 poses", "ipanema", replace(_LARGE, poses=60), _PLAN),
    Case("8 lines, encoders to 0.1 mm, tags of 150 mm", "ipanema", replace(HD, encoder=1e-4), _FINE),
    Case("8 lines, encoders to 0.1 mm, tags of 300 mm", "ipanema", _EXACT, _FINE),
    Case("the same, camera at 2.4 m, 4 tags on the floor too", "ipanema",
         replace(_EXACT, floor=4, at=(3.8, -3.2, 2.4)), _FINE),
    Case("8 lines, camera on the platform, 20 tags on the floor", "ipanema", _CARRIED, _FINE),
    Case("4 lines to a point, encoders to 0.1 mm", "wang2021", _EXACT, _FINE),
    Case("the same, exit points levelled to 1 mrad", "wang2021", _EXACT, _LEVEL),
    Case("the same, levelled, 60 poses", "wang2021", replace(_EXACT, poses=60), _LEVEL),
)  # fmt: skip


def expected(robot: cw.Robot, setup: Setup, made: Room, noise: np.random.Generator | None = None) -> Room:
    """Return the room with the sightings that pictures of its tags would give, without errors.

    With *noise* edges have errors of their stated standard deviations, and fits start from the layout.
    """
    seen = made.data.sightings
    assert seen is not None
    layout, place, rotation = layout_of(robot, setup, made.poses[:, :3].mean(axis=0))
    square = np.array([[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]])
    pictures: list[SeenPicture | None] = []
    for pose in made.poses:
        found = []
        for tag in layout.tags:
            where, turned = in_camera(tag.mounted, *made.tags[tag.number], pose, layout, place, rotation)
            corners = tag_pictures.pixel_of(made.lens, where + 0.5 * tag.size * square @ turned[:, :2].T)
            inside = (corners > 5.0).all() and (corners < [setup.width - 5.0, setup.height - 5.0]).all()
            ahead = where[2] > 0.2 and -float(turned[:, 2] @ where) > _OBLIQUE * float(np.linalg.norm(where))
            if not (inside and ahead and mean_side(corners) > MIN_SIDE):
                continue
            ends = [(corners[at], corners[(at + 1) % 4]) for at in range(4)]
            along = np.array([(two - one) / np.linalg.norm(two - one) for one, two in ends])
            normals = np.column_stack([along[:, 1], -along[:, 0]])
            values = [(n @ (one + two), n @ (one - two)) for n, (one, two) in zip(normals, ends, strict=True)]
            sigmas = np.tile(EDGE_SIGMAS, 4)
            off = np.zeros(8) if noise is None else sigmas * noise.standard_normal(8)
            found.append(Sighting(tag.number, corners, np.ravel(values) + off, sigmas, normals))
        pictures.append(SeenPicture(Path("expected"), tuple(found), ()))
    if noise is not None:
        return replace(made, data=replace(made.data, sightings=replace(seen, pictures=tuple(pictures))))
    told = replace(seen, pictures=tuple(pictures), place=place, rotation=rotation)
    return replace(made, data=replace(made.data, sightings=told, guess=made.poses))


def accuracy(case: Case, seed: int) -> tuple[float, float, tuple[float, ...]]:
    """Return the 95th percentiles of the error of an exit point, m: in its own frame and the largest; and tags seen."""
    robot = scaled(case.robot, 5.0)
    made = expected(robot, case.setup, room(robot, case.setup, seed, pixels=False))
    body = as_body(made.robot)
    problem = StraightProblem.of(body, made.data, case.plan, hold=False)
    theta = problem.free.copy()
    home = problem.lengths(theta, made.poses)[0]
    theta[problem.named("length_offset")] = home
    found = information(problem, theta, made.poses, problem.weights, priors=True)
    rows, _ = exit_rows(body, found.unknowns)
    spread = rows @ found.covariance @ rows.T
    values, vectors = np.linalg.eigh(spread)
    draws = np.random.default_rng(0).normal(size=(4000, len(values))) * np.sqrt(values.clip(min=0.0)) @ vectors.T
    true = np.array([line.exit_point for line in body.lines])
    draws = draws.reshape(4000, -1, 3)
    own = np.array([cw.aligned(true + each, true, tilt=True)[0] - true for each in draws[:400]])
    sizes = [np.percentile(np.linalg.norm(each, axis=2), 95.0) for each in (own, draws)]
    assert made.data.sightings is not None
    return float(sizes[0]), float(sizes[1]), tuple(made.data.sightings.counts.tolist())


def from_pixels(case: Case, rooms: int) -> str:
    """Return how well exit points of a number of rooms are found from pixels, and how honest the sigmas are."""
    robot, errors, inside, seconds = scaled(case.robot, 5.0), list[Array](), 0, list[float]()
    for seed in range(rooms):
        made = room(robot, case.setup, 100 + seed)
        begin = time.process_time()
        found = cw.calibrate(robot, made.data, case.plan, rough=0.05)
        seconds.append(time.process_time() - begin)
        own = found.gauge != ()
        off = exit_errors(made.robot, found.robot, own)
        rows, _ = exit_rows(found.problem.robot, found.unknowns)
        spread = rows @ found.covariance @ rows.T
        values, vectors = np.linalg.eigh(spread)
        kept = values > 1e-10
        square = float(np.sum((vectors[:, kept].T @ off.ravel()) ** 2 / values[kept]))
        inside += square < _chi(int(kept.sum()))
        errors.append(np.linalg.norm(exit_errors(made.robot, found.robot, True), axis=1))
    size = 1e3 * np.percentile(np.concatenate(errors), 95.0)
    return f"{size:.2f} mm; {inside} of {rooms} in the joint 95 % ellipsoid; {np.median(seconds):.1f} s"


def _chi(count: int) -> float:
    from scipy import special

    return float(special.chdtri(count, 0.05))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rooms", type=int, default=0, help="rooms from pixels of each set-up")
    parser.add_argument("--only", type=int, default=-1, help="number of the set-up")
    given = parser.parse_args()
    print("| set-up, frame of 5 m | own frame, mm | world, mm | 3 mm | tags seen |")
    print("| --- | --- | --- | --- | --- |")
    for at, case in enumerate(CASES):
        if given.only not in (-1, at):
            continue
        own, world, counts = accuracy(case, 1)
        reached = "yes" if own <= NEED else "no"
        print(f"| {case.words} | {1e3 * own:.2f} | {1e3 * world:.2f} | {reached} | {np.mean(counts):.1f} |", flush=True)
        if given.rooms:
            print(from_pixels(case, given.rooms), flush=True)


if __name__ == "__main__":
    main()
