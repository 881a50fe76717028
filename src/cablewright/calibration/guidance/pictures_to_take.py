"""Pictures to take next in a guided calibration: where the camera stands, and what it will see at poses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import compress
from pathlib import Path
from typing import Any, Final

import numpy as np

from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.measurements import Measured, read_measured
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.sightings.camera import load_camera
from cablewright.calibration.sightings.expected import expected, standpoints
from cablewright.calibration.sightings.layout import load_layout
from cablewright.calibration.sightings.pictures import SUFFIXES
from cablewright.calibration.sightings.placing import started, words_of
from cablewright.calibration.sightings.reading import read_sightings
from cablewright.calibration.sightings.sighted import CAMERA, Sightings, turned
from cablewright.foundation.arrays import Array, Mask
from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress
from cablewright.robot import Robot

PICTURED: Final = 4
"""Poses with pictures that there must be: each line has four unknowns, and a picture gives the pose."""


@dataclass(frozen=True, eq=False)
class CameraView:
    """One place of the camera: ``seen`` has its pose, in the world or on the platform; ``words`` describe it."""

    seen: Sightings
    words: str

    def at(self, poses: Array) -> Sightings:
        """Return the sightings that pictures at *poses* (N, n) will give."""
        full = np.zeros((len(poses), 6))
        full[:, : poses.shape[1]] = poses
        return expected(self.seen, full)


def sightings_so_far(
    robot: Robot, data: Path, pictures: Path, tags: Path, camera: Path, progress: Progress
) -> tuple[Measured | None, Sightings]:
    """Return the measurements with their sightings, None before there are any, and the sightings.

    All are files, *pictures* a folder that may be absent. Raises `InputError` as `read_sightings`, and for pictures
    without data.
    """
    layout, lens = load_layout(tags), load_camera(camera)
    there = pictures.is_dir() and any(each.suffix.lower() in SUFFIXES for each in pictures.iterdir())
    if not data.exists():
        if there:
            raise InputError(f"{data}: does not exist, but {pictures} has pictures: write a row of lengths for each")
        return None, Sightings(layout, lens, ())
    measured = read_measured(data, robot)
    count = len(measured.counted)
    none = Sightings(layout, lens, (None,) * count)
    seen = read_sightings(pictures, layout, lens, count, progress=progress) if there else none
    return replace(measured, sightings=seen), seen


def usable(measured: Measured, plan: CalibrationPlan) -> tuple[Measured | None, CalibrationPlan, tuple[str, ...]]:
    """Return the rows whose picture shows a tag, None for none, the *plan* of these, and sentences on the others."""
    seen = measured.sightings
    assert seen is not None
    shown = seen.counts > 0
    missing = [at for at in np.flatnonzero(np.logical_not(shown)).tolist() if seen.pictures[at] is None]
    take = "has no picture: take pose-{:02d}.jpg there, or leave the row out"
    words = (*words_of(seen), *(f"{measured.place(at)}: {take.format(at + 1)}" for at in missing))
    return (measured.only(shown) if shown.any() else None), _renumbered(plan, shown), words


def _renumbered(plan: CalibrationPlan, kept: Mask) -> CalibrationPlan:
    """Return the *plan* for the *kept* poses (N,) alone; poses after the last one keep their numbers."""
    rows = np.cumsum(kept).tolist()
    new = {old: row if stays else 0 for old, (row, stays) in enumerate(zip(rows, kept, strict=True), 1)}  # 0: dropped
    entries: dict[str, list[Any]] = {"planes": [], "ranges": []}
    for key, found in entries.items():
        for each in getattr(plan, key):
            poses = [new.get(pose, pose) for pose in each.poses]
            columns = {"poses": poses} | ({"values": each.values} if key == "ranges" else {})
            if any(poses):
                left = {name: tuple(compress(column, poses)) for name, column in columns.items()}
                found.append(each.model_copy(update=left))
    return plan.model_copy(update={key: tuple(found) for key, found in entries.items()})


def views_of(
    seen: Sightings, measured: Measured | None, robot: Robot, found: Calibration | None, middle: Array
) -> list[CameraView]:
    """Return where the camera stands: by the calibration, by the pictures, or places to choose from, around the frame.

    *measured*: rows with pictures, if any; *found*: the calibration so far; *middle* (3,): of the poses, m.
    """
    if seen.layout.camera == "platform":
        mount = seen.layout.mount
        return [
            CameraView(
                replace(seen, place=np.array(mount.at), rotation=mount.rotation), "the camera is on the platform"
            )
        ]
    if found is not None and (data := found.problem.measured.sightings) is not None:
        value = dict(zip(((each.kind, each.line) for each in found.unknowns), found.values.tolist(), strict=True))
        place, turn = (
            np.array([value[f"camera_{what}.{axis}", CAMERA] for axis in "xyz"]) for what in ("place", "turn")
        )
        return [_standing(replace(data, place=place, rotation=turned(data.rotation, turn)))]
    why = ""
    if measured is not None:
        try:
            return [_standing(started(seen, robot, measured.counted, measured.guess, measured.origin)[0])]
        except InputError as error:
            why = f"; from the pictures so far its place is not known ({error})"
    looks = f"and let it look at {_told(middle)}; do not move it from picture to picture{why}"
    return [
        CameraView(each, f"put the camera at {_told(each.place)} {looks}") for each in standpoints(seen, robot, middle)
    ]


def _standing(seen: Sightings) -> CameraView:
    return CameraView(seen, f"the camera stands at {_told(seen.place)}: leave it there")


def _told(place: Array) -> str:
    return f"({', '.join(f'{number:.2f}' for number in (place.round(2) + 0.0).tolist())}) m"
