"""Reading of picture files from any source: size limits before they are decoded, errors in one line.

The pixels are those that the sensor stored: a rotation in a picture's EXIF data, which says how a viewer shows it, is
not applied. So a camera's lens holds however the camera was held.
"""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.foundation.toml_input import read_bytes

MAX_BYTES: Final = 64 << 20
MAX_PIXELS: Final = 64_000_000
MAX_PICTURES: Final = 1000
_GREYS: Final = 65_535.0 / 255.0  # levels of 16 bits in one of 8
SUFFIXES: Final = (".jpg", ".jpeg", ".png")


def require_camera_extra() -> None:
    """Raise `EnvironmentFault` where the extra ``camera`` is not installed."""
    try:
        import cv2  # noqa: F401
        import PIL.Image  # noqa: F401
    except ImportError:
        raise EnvironmentFault("pictures: OpenCV is not installed: pip install 'cablewright[camera]'") from None


def read_picture(path: Path) -> Array:
    """Return the grey levels (height, width) of a JPEG or PNG, 0 to 255.

    Raises `InputError` for a file that is none, is too large or ends early; `EnvironmentFault` without the extra.
    """
    require_camera_extra()
    from PIL import Image, UnidentifiedImageError

    data = read_bytes(path, MAX_BYTES, "picture")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            picture = Image.open(io.BytesIO(data), formats=("JPEG", "PNG"))
        width, height = picture.size
        if width * height > MAX_PIXELS:
            raise InputError(f"{path}: {width} x {height} pixels; at most {MAX_PIXELS / 1e6:g} million are read")
        if picture.mode.startswith("I"):  # 16 bits of grey
            return np.asarray(picture, dtype=np.float64) / _GREYS
        return np.asarray(picture.convert("L"), dtype=np.float64)
    except UnidentifiedImageError:
        raise InputError(f"{path}: not a JPEG or PNG picture") from None
    except Image.DecompressionBombError:
        raise InputError(f"{path}: too many pixels; at most {MAX_PIXELS / 1e6:g} million are read") from None
    except (OSError, SyntaxError, ValueError) as error:
        raise InputError(f"{path}: damaged: {error}; copy it from the camera again") from None


def picture_files(given: Sequence[str | Path]) -> list[Path]:
    """Return the pictures of folders and files, by name. Raises `InputError` for none, too many, and other objects."""
    found: list[Path] = []
    try:
        paths = [Path(each) for each in given]
    except TypeError as reason:
        raise InputError(f"pictures: paths of pictures or folders are expected: {reason}") from None
    for each in paths:
        if each.is_dir():
            inside = (one for one in each.iterdir() if one.suffix.lower() in SUFFIXES and not one.name.startswith("."))
            found += sorted(inside, key=lambda one: (number_of(one) or 0, one.name))
        else:
            found.append(each)
    if not found:
        names = ", ".join(map(str, given))
        raise InputError(f"{names or 'pictures'}: no pictures; expected files {', '.join(SUFFIXES)}")
    if len(found) > MAX_PICTURES:
        raise InputError(f"{found[0].parent}: {len(found)} pictures; at most {MAX_PICTURES} are read")
    return found


def number_of(path: Path) -> int | None:
    """Return the number at the end of a picture's name: 7 of ``pose-07.jpg``."""
    digits = re.search(r"([0-9]{1,18})$", path.stem)
    return int(digits[1]) if digits else None


def by_pose(given: Sequence[str | Path], poses: int) -> Iterator[tuple[int, Path]]:
    """Yield the pictures with the pose of each, from 0: its name ends with the pose's number, from 1.

    Raises `InputError` for a name without a number, a pose that the data do not have, and a pose with two pictures.
    """
    taken = dict[int, Path]()
    for path in picture_files(given):
        number = number_of(path)
        if number is None or not 1 <= number <= poses:
            what = "does not end with a number" if number is None else f"is of pose {number}"
            raise InputError(f"{path}: its name {what}; expected that of its pose, 1 to {poses}, as in pose-07.jpg")
        if number in taken:
            raise InputError(f"{path}: pose {number} has a picture already, {taken[number].name}; leave one away")
        taken[number] = path
        yield number - 1, path
