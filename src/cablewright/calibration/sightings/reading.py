"""Sightings of tags at the poses of a calibration, read from picture files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from cablewright.calibration.sightings.camera import Camera, load_camera
from cablewright.calibration.sightings.detection import SeenPicture, seen_in
from cablewright.calibration.sightings.layout import TagLayout, load_layout
from cablewright.calibration.sightings.pictures import by_pose
from cablewright.calibration.sightings.sighted import Sightings
from cablewright.foundation.progress import Progress, silent


def read_sightings(
    pictures: str | Path | Sequence[str | Path],
    layout: str | Path | TagLayout,
    camera: str | Path | Camera,
    count: int,
    *,
    progress: Progress = silent,
) -> Sightings:
    """Return the tags of a *layout* seen at each of *count* poses in *pictures*, which are files or folders.

    The name of a picture ends with the number of its pose, from 1: ``pose-07.jpg``. Raises `InputError` for names
    without one, two pictures of a pose, pictures of another size than the camera's, damaged ones, and a tag that is
    twice in one; `EnvironmentFault` without OpenCV, the extra ``camera``.
    """
    tags = layout if isinstance(layout, TagLayout) else load_layout(layout)
    lens = camera if isinstance(camera, Camera) else load_camera(camera)
    wanted, found = frozenset(tag.number for tag in tags.tags), list[SeenPicture | None]([None] * count)
    given = [pictures] if isinstance(pictures, str | Path) else pictures
    for at, (pose, path) in enumerate(by_pose(given, count)):
        progress("pictures", at, count)
        found[pose] = seen_in(path, lens, wanted)
    return Sightings(tags, lens, tuple(found))
