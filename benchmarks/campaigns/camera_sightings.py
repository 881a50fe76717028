"""Calibrations and checks by camera from sightings with the noise of pixels, without pictures: many rooms soon.

    python -m benchmarks.campaigns.camera_sightings rooms 5 200   # number of the set-up in `camera_setups`, rooms
    python -m benchmarks.campaigns.camera_sightings lens 5 48     # how often a right or a wrong set-up is rejected
    python -m benchmarks.campaigns.camera_sightings check 5 30    # a bump of 10 mm, three pictures, four checks a room

Edges have errors of the standard deviations that the detection reaches on rendered pictures. Poses at which no tag is
seen are left out.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray
from scipy import special

import cablewright as cw
from benchmarks.campaigns import camera_setups
from benchmarks.campaigns.camera_rooms import Room, Setup, exit_errors, room
from benchmarks.campaigns.camera_setups import CASES, Case, expected, scaled
from cablewright.calibration.drift.record import CalibrationRecord, record_of
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.poses.simulation import measure, random_poses
from cablewright.calibration.sightings import bundle
from cablewright.calibration.unknowns import exit_rows
from cablewright.models.rotation import matrices
from cablewright.models.statics import Model

Array = NDArray[np.float64]
BUMP, CHECKS, TRIED = 0.01, 4, 30  # m, checks of each room, triples of poses of which the widest is taken
MOVED = (0.05, 0.03)  # m, rad: of the camera between calibration and check
WRONG = {"right": {}, "print at 98 %": {"print_scale": 0.98}, "a tag moved": {"moved": 1}} | {
    f"focal length {share:.0%} wrong": {"focal_error": share} for share in (0.02, 0.03, 0.04, 0.06, 0.1)
}


def drawn(robot: cw.Robot, setup: Setup, seed: int) -> Room:
    """Return a room with noisy sightings at the poses at which there are any."""
    made = room(robot, setup, seed, pixels=False)
    seen = expected(robot, replace(setup, size=setup.print_scale * setup.size), made, np.random.default_rng([seed, 77]))
    assert seen.data.sightings is not None
    assert made.data.sightings is not None
    told = replace(made.data.sightings, pictures=seen.data.sightings.pictures)
    data = replace(made.data, sightings=told)
    shown = told.counts > 0
    return replace(made, data=data if shown.all() else data.only(shown), poses=made.poses[shown])


def rooms(case: Case, count: int) -> str:
    """Return errors of exit points, and how often all are in the joint 95 % ellipsoid."""
    robot, inside, errors = scaled(case.robot, 5.0), 0, list[Array]()
    for seed in range(count):
        made = drawn(robot, case.setup, seed)
        found = cw.calibrate(robot, made.data, case.plan, rough=0.05)
        off = exit_errors(made.robot, found.robot, found.gauge != ())
        rows, _ = exit_rows(found.problem.robot, found.unknowns)
        values, vectors = np.linalg.eigh(rows @ found.covariance @ rows.T)
        kept = values > 1e-10
        square = float(np.sum((vectors[:, kept].T @ off.ravel()) ** 2 / values[kept]))
        inside += square < float(special.chdtri(int(kept.sum()), 0.05))
        errors.append(np.linalg.norm(exit_errors(made.robot, found.robot, True), axis=1))
    size = 1e3 * np.percentile(np.concatenate(errors), 95.0)
    return f"{inside} of {count} rooms in the joint 95 % ellipsoid, exit points to {size:.2f} mm (95 %)"


def lens(case: Case, count: int) -> Iterator[str]:
    """Yield how far the lens that fits is from its file, over chance, for right and wrong set-ups."""
    robot, excess = scaled(case.robot, 5.0), bundle.excess_of
    for words, change in WRONG.items():
        found = list[float]()

        def kept(off: Array, left: Array, sigma: float, among: int, found: list[float] = found) -> float:
            value = excess(off, left, sigma, among)
            if among == 1:  # the lens: there are more tags
                found.append(value)
            return value

        sizes = list[float]()
        for seed in range(3000, 3000 + count):
            with patch.object(bundle, "excess_of", kept), patch.object(bundle, "OTHER_CAMERA", -1.0):
                try:
                    cw.calibrate(robot, drawn(robot, replace(case.setup, **change), seed).data, case.plan, rough=0.05)
                except cw.InputError:  # at once, as any lens is too far from its file
                    sizes += found[-1:]
            found.clear()
        share = np.mean(np.array(sizes) > bundle.OTHER_CAMERA)
        yield f"{words}: {min(sizes):.2f} to {max(sizes):.2f}, rejected {share:.0%} of {len(sizes)}"


def check(case: Case, count: int) -> Iterator[str]:
    """Yield how often three pictures at random poses, or at widely spread ones, find that nothing or one exit moved."""
    robot, found = (
        scaled(case.robot, 5.0),
        {(how, bump): [0, 0] for how in ("random", "spread") for bump in (0.0, BUMP)},
    )
    for seed in range(count):
        made = drawn(robot, case.setup, seed)
        calibrated = cw.calibrate(robot, made.data, case.plan, rough=0.05)
        record, rng = _record(calibrated), np.random.default_rng(seed + 500)
        for (how, bump), counted in list(found.items()) * CHECKS:
            tried = random_poses(Model.of(made.robot), 3 * (1 if how == "random" else TRIED), rng).reshape(-1, 3, 6)
            data = _later(case, made, max(tried, key=lambda three: _area(robot, three)), bump, rng)
            if data.sightings is not None and (data.sightings.counts > 0).all():
                counted[0] += 1
                counted[1] += cw.check_drift(calibrated.robot, data, record).verdict != "unchanged"
    for (how, bump), (total, alarms) in found.items():
        yield f"{how} poses, bump {1e3 * bump:.0f} mm: {alarms} alarms of {total}"


def _area(robot: cw.Robot, poses: Array) -> float:
    """Area of the triangle of three *poses* (3, 6), over the size of the frame."""
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    one, two, three = (poses[:, :3] - low) / (high - low)
    return 0.5 * float(np.linalg.norm(np.cross(two - one, three - one)))


def _record(found: Calibration) -> CalibrationRecord:
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "data.csv").write_text("")
        return record_of(found, Path(folder) / "data.csv", datetime.now(UTC))


def _later(case: Case, before: Room, poses: Array, bump: float, rng: np.random.Generator) -> cw.Measured:
    """Return lengths and sightings at three *poses* (3, 6), with one exit point *bump*, m, away, and a moved camera."""
    lines, at, way = list(before.robot.lines), int(rng.integers(before.robot.m)), rng.normal(size=3)
    moved = lines[at].exit_point + bump * way / np.linalg.norm(way)
    lines[at] = lines[at].model_copy(update={"exit_point": tuple(moved.tolist())})
    robot = cw.Robot.model_validate(before.robot.model_copy(update={"lines": tuple(lines)}).model_dump())
    every = np.concatenate([before.poses[:1], poses])
    home = measure(before.robot, every, 0.0, rng).home_lengths
    made, seen, (place, looks) = measure(robot, every, case.setup.encoder, rng), before.data.sightings, before.camera
    assert seen is not None
    counted = made.measured.counted[1:] + (made.home_lengths - home)  # the counts are from the old home
    data = replace(made.measured.only(np.array([False, True, True, True])), counted=counted, guess=None)
    camera = place + rng.normal(0.0, MOVED[0], 3), matrices(rng.normal(0.0, MOVED[1], 3)) @ looks
    there = replace(before, robot=robot, poses=poses, camera=camera)
    there = replace(there, data=replace(data, sightings=replace(seen, pictures=(), left_out=frozenset())))
    with patch.object(camera_setups, "layout_of", lambda *_: (seen.layout, *camera)):
        return expected(robot, case.setup, there, rng).data


def main() -> None:
    """Print one of the tables."""
    what, case, count = sys.argv[1], CASES[int(sys.argv[2])], int(sys.argv[3])
    print(case.words)
    if what == "rooms":
        print(rooms(case, count))
        return
    for line in (lens if what == "lens" else check)(case, count):
        print(line, flush=True)


if __name__ == "__main__":
    main()
