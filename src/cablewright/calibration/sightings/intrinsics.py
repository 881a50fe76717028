"""Calibration of a camera's lens from pictures of a flat sheet of tags (Zhang 2000), with covariance.

OpenCV gives a start; the numbers are those of the bundle adjustment of all pictures, in which edges have their own
standard deviations and the tags of the sheet may be displaced. Edges are found again with the lens of the first round.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Final

import numpy as np

from cablewright.calibration.sightings.bundle import consistent
from cablewright.calibration.sightings.camera import LENS, Camera, load_camera
from cablewright.calibration.sightings.detection import SeenPicture, seen_in
from cablewright.calibration.sightings.layout import Tag, TagLayout, load_layout
from cablewright.calibration.sightings.pictures import picture_files, read_picture, require_camera_extra
from cablewright.calibration.sightings.placing import in_own_frame, tag_corners, words_of
from cablewright.calibration.sightings.sighted import CAMERA, Sightings
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.progress import Progress, silent
from cablewright.foundation.results import Figure, Result
from cablewright.foundation.validation import validated

MIN_PICTURES: Final = 5
MIN_TAGS: Final = 4
"""Tags that a picture must show to count."""

COLUMNS, ROWS, PITCH, SIZE = 4, 6, 0.046, 0.035  # of the sheet, m
FIRST: Final = 400
"""Number of the sheet's first tag."""

_WIDE: Final = (0.5, 0.5, 0.2, 0.2, 1.0, 3.0, 0.1, 0.1, 0.0)  # sigmas before, of the first four over the focal length
_FOCAL: Final = 1.2  # first guess of the focal length, over the picture's width
_NEEDED: Final = 5e-3  # max relative sigma of the focal length of a good answer
_BAD: Final = 1.0  # px: max residual of one


def sheet() -> TagLayout:
    """Return the layout of the calibration sheet: tags in a grid on one page of A4, x to the right and y up."""
    places = [(column * PITCH, -row * PITCH, 0.0) for row in range(ROWS) for column in range(COLUMNS)]
    tags = (Tag(number=FIRST + at, size=SIZE, at=place, sigma=2e-4, turn_sigma=0.0) for at, place in enumerate(places))
    return TagLayout(print_sigma=0.0, tags=tuple(tags))


FIGURES = (
    Figure("width", "px", "Width of the pictures.", "camera.width"),
    Figure("height", "px", "Height of the pictures.", "camera.height"),
    Figure("focal", "px", "Focal lengths along x and y.", "camera.focal", "focal lengths", 6),
    Figure("focal_sigma", "px", "Their standard deviation.", lambda of: of.sigmas[:2], "standard deviation", 2),
    Figure("principal", "px", "Principal point.", "camera.principal", "principal point", 6),
    Figure("principal_sigma", "px", "Its standard deviation.", lambda of: of.sigmas[2:4], "its standard deviation", 2),
    Figure("distortion", "1", "Distortion k1, k2, p1, p2, k3.", "camera.distortion", digits=3),
    Figure("distortion_sigma", "1", "Standard deviation of each.", lambda of: of.sigmas[4:], "their deviations", 2),
    Figure("residual", "px", "Root mean square distance of the edges; null of a camera that was read.", digits=2),
    Figure("pictures", "1", "Number of pictures that count; 0 of a camera that was read."),
    Figure("left_out", "", "Pictures and tags that do not count, with the reason.", sentences=True),
    Figure("covariance", "px, 1", "Covariance of all nine numbers.", lambda of: of.camera.spread, detail=True),
)


@dataclass(frozen=True, eq=False, repr=False)
class CameraFit(Result):
    """A calibrated camera from pictures, or one from an OpenCV file, whose standard deviations are assumed."""

    FIGURES: ClassVar = FIGURES
    HEADLINES: ClassVar = ("focal", "residual", "pictures")

    camera: Camera
    residual: float | None
    pictures: int
    left_out: tuple[str, ...]

    @property
    def sigmas(self) -> Array:
        """Standard deviations (9,) of the lens parameters."""
        return np.asarray(np.sqrt(np.diag(self.camera.spread)))

    @property
    def refusal(self) -> str:
        """Reason why the camera is not known well enough; empty if it is."""
        share = float(self.sigmas[0]) / self.camera.focal[0]
        if self.pictures and share > _NEEDED:
            return (
                f"the focal length is known to {100.0 * share:.2g} % only, {100.0 * _NEEDED:g} % are needed: "
                "take more pictures with the sheet turned by 30 to 50 degrees, and in the corners of the picture"
            )
        if self.residual is not None and self.residual > _BAD:
            return f"edges are {self.residual:.2g} px off: is the sheet flat, and the camera's focus and zoom fixed?"
        return ""


def camera(
    pictures: str | Path | Sequence[str | Path],
    layout: str | Path | TagLayout | None = None,
    *,
    progress: Progress = silent,
) -> CameraFit:
    """Return the camera that took *pictures*, files or folders, of a flat sheet of tags; or that of an OpenCV file.

    *layout*: the tags of the sheet, all "on" one body and in one plane; by default those of `sheet`. Raises
    `InputError` for pictures of two sizes, and too few that show the sheet; `EnvironmentFault` without OpenCV.
    """
    given = [pictures] if isinstance(pictures, str | Path) else list(pictures)
    if len(given) == 1 and Path(str(given[0])).suffix.lower() in (".yml", ".yaml", ".xml", ".toml"):
        return CameraFit(load_camera(given[0]), None, 0, ())
    files = picture_files(given)
    tags = layout if isinstance(layout, TagLayout) else sheet() if layout is None else load_layout(layout)
    require_camera_extra()
    height, width = read_picture(files[0]).shape
    focal = _FOCAL * max(width, height)
    first = {"width": width, "height": height, "focal": (focal, focal), "principal": (width / 2.0, height / 2.0)}
    guess = validated(Camera, first, files[0])
    detected = dict.fromkeys(files, tuple[tuple[int, Array], ...]())
    seen = _shown(detected, guess, tags, progress)
    start = _start(seen, guess)
    for _ in range(2):
        seen = _shown(detected, start, tags, progress)
        agreed, poses, _ = in_own_frame(seen)
        agreed, bundle = consistent(agreed, poses, False)
        off, shares, _, covariance = bundle.evidence()
        lens = start.lens
        which = [at for at, each in enumerate(bundle.bodies.unknowns) if each.line == CAMERA]
        free = [LENS.index(bundle.bodies.unknowns[at].kind) for at in which]
        sizes = np.array([bundle.bodies.unknowns[at].size for at in which])
        lens[free] = bundle.theta[which] * sizes
        left = float(off.size - np.isclose(off, 0.0).sum() - np.trace(shares, axis1=1, axis2=2).sum())
        scale = max(1.0, float(np.sum(off**2)) / max(left, 1.0))
        spread = np.zeros((len(LENS), len(LENS)))
        spread[np.ix_(free, free)] = covariance[np.ix_(which, which)] * np.outer(sizes, sizes) * scale
        start = _camera(start, lens, np.diag((np.array(_WIDE) * np.repeat([lens[0], 1.0], [4, 5])) ** 2))
    used = bundle.weights > 0.0
    residual = float(np.sqrt(np.mean((off.ravel()[used] / bundle.weights[used] / 2.0) ** 2)))
    return CameraFit(_camera(start, lens, spread), residual, len(poses), tuple(words_of(agreed)))


def _camera(old: Camera, lens: Array, spread: Array) -> Camera:
    """Return the camera with another *lens* (9,) and its covariance (9, 9). Raises `InputError` out of its range."""
    rows = tuple(tuple(row[: at + 1]) for at, row in enumerate(spread.tolist()))
    values: dict[str, Any] = {"focal": tuple(lens[:2]), "principal": tuple(lens[2:4]), "distortion": tuple(lens[4:])}
    return validated(Camera, old.model_dump() | values | {"covariance": rows}, "the lens that fits the pictures")


def _shown(
    detected: dict[Path, tuple[tuple[int, Array], ...]], guess: Camera, tags: TagLayout, progress: Progress
) -> Sightings:
    """Return the sightings of the pictures that show enough tags. Raises `InputError` for too few of them.

    *detected*: the files, with the tags that were detected in each, which are added at the first time.
    """
    wanted, files, found = frozenset(tag.number for tag in tags.tags), list(detected), list[SeenPicture]()
    for at, path in enumerate(files):
        progress("pictures", at, len(files))
        found.append(seen_in(path, guess, wanted, detected[path]))
        detected[path] = found[-1].found
    good = [each for each in found if len(each.sightings) >= min(MIN_TAGS, len(tags.tags))]
    if len(good) < MIN_PICTURES:
        reasons = Counter(word for each in found for word in each.left_out).most_common(2)
        why = "; ".join(word for word, _ in reasons) or "too few tags are in each"
        raise InputError(
            f"{files[0].parent}: {len(good)} of {len(files)} pictures show {MIN_TAGS} tags of the sheet, at least "
            f"{MIN_PICTURES} must: {why}"
        )
    return Sightings(tags, guess, tuple(good))


def _start(seen: Sightings, guess: Camera) -> Camera:
    """Return a camera near that of the pictures, by OpenCV. Raises `InputError` where it finds none."""
    import cv2

    tags = {tag.number: tag for tag in seen.layout.tags}
    points, pixels = list[Any](), list[Any]()
    for picture in seen.pictures:
        assert picture is not None
        points.append(np.concatenate([tag_corners(tags[each.number]) for each in picture.sightings]).astype(np.float32))
        pixels.append(np.concatenate([each.corners for each in picture.sightings]).astype(np.float32))
    if max(np.abs(each[:, 2]).max() for each in points) > 1e-6:
        raise InputError("layout: the tags of a sheet must be in the plane z = 0")
    size = (guess.width, guess.height)
    flags = cv2.CALIB_FIX_K3 | cv2.CALIB_FIX_ASPECT_RATIO
    matrix = np.array([[guess.focal[0], 0.0, size[0] / 2.0], [0.0, guess.focal[0], size[1] / 2.0], [0.0, 0.0, 1.0]])
    try:
        _, matrix, lens, _, _ = cv2.calibrateCamera(points, pixels, size, matrix, None, flags=flags)
        numbers = np.array([matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2], *lens.ravel()[:5]])
        wide = np.diag((np.array(_WIDE) * np.repeat([numbers[0], 1.0], [4, 5])) ** 2)
        return _camera(guess, numbers, wide)
    except (cv2.error, InputError):
        raise InputError("no lens fits the pictures: tilt the sheet in them, or is it another sheet?") from None
