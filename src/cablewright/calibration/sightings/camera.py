"""A camera: the size of its pictures, its lens with a covariance, and OpenCV's calibration files.

Lens: two focal lengths and the principal point in pixels, then k1, k2, p1, p2, k3 of Brown's distortion (1966), as
OpenCV has them. The centre of the first pixel is at (0, 0).
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Annotated, Final, Self

import numpy as np
import tomlkit
from pydantic import Field, Strict, model_validator

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.toml_input import load_model, read_bytes
from cablewright.foundation.validation import FileDescription, refusal, validated

LENS: Final = ("focal_length.x", "focal_length.y", "principal_point.x", "principal_point.y", "distortion_k1",
               "distortion_k2", "distortion_p1", "distortion_p2", "distortion_k3")  # fmt: skip
"""The numbers of a lens."""

ASSUMED: Final = (0.01, 0.01, 0.01, 0.01, 0.01, 0.0, 0.0, 0.0, 0.0)
"""Sigmas of a lens without a covariance: of its first four numbers over the focal length."""

_MAX_BYTES: Final = 1 << 20
_TABLE: Final = 4096  # characters after a key of an OpenCV file within which its numbers are
_Number = Annotated[float, Strict(), Field(allow_inf_nan=False, ge=-1e6, le=1e6)]
_Size = Annotated[int, Strict(), Field(ge=64, le=20_000)]
_Row = Annotated[tuple[_Number, ...], Field(max_length=len(LENS))]


class Camera(FileDescription):
    """A camera. ``width``, ``height``: of its pictures, px. ``focal``, ``principal``: px. ``distortion``: k1 to k3.

    ``covariance``: the rows of the lower triangle of that of all nine numbers, 0 for those that are exact.
    """

    width: _Size
    height: _Size
    focal: tuple[_Number, _Number]
    principal: tuple[_Number, _Number]
    distortion: Annotated[tuple[_Number, ...], Field(min_length=5, max_length=5)] = (0.0,) * 5
    covariance: Annotated[tuple[_Row, ...], Field(max_length=len(LENS))] = ()

    @model_validator(mode="after")
    def _is_possible(self) -> Self:
        if not min(self.focal) > 0.05 * max(self.width, self.height):
            raise refusal("focal", f"must be over {0.05 * max(self.width, self.height):g} px, 0.05 of the larger side")
        for name, value, size in zip("xy", self.principal, (self.width, self.height), strict=True):
            if not 0.0 <= value <= size:
                raise refusal("principal", f"{name} = {value:g} px is out of the picture, which has {size} px")
        if max(map(abs, self.distortion)) > 10.0:
            raise refusal("distortion", "must be at most 10 in size")
        if self.covariance and [len(row) for row in self.covariance] != list(range(1, len(LENS) + 1)):
            raise refusal("covariance", f"must be the lower triangle of {len(LENS)} numbers: rows of 1 to {len(LENS)}")
        spread, sigmas = self.spread, np.sqrt(np.diag(self.spread).clip(min=1e-300))
        if (np.linalg.eigvalsh(spread / np.outer(sigmas, sigmas))[0] < -1e-6) or (np.diag(spread) < 0.0).any():
            raise refusal("covariance", "is none: it has a negative variance")
        return self

    @property
    def lens(self) -> Array:
        """The numbers (9,) of the lens."""
        return np.array([*self.focal, *self.principal, *self.distortion])

    @property
    def spread(self) -> Array:
        """The covariance (9, 9) of the lens: that of the file, or assumed."""
        if not self.covariance:
            return np.diag((np.array(ASSUMED) * np.where(np.arange(9) < 4, self.focal[0], 1.0)) ** 2)
        found = np.zeros((len(LENS), len(LENS)))
        for at, row in enumerate(self.covariance):
            found[at, : at + 1] = found[: at + 1, at] = row
        return found

    def directions(self, pixels: Array) -> Array:
        """Return x / z and y / z (..., 2) of the rays to *pixels* (..., 2): distortion undone by fixed-point steps."""
        fx, fy, cx, cy, k1, k2, p1, p2, k3 = self.lens
        seen = (pixels - [cx, cy]) / [fx, fy]
        found = seen
        for _ in range(20):
            x, y = found[..., 0], found[..., 1]
            r = x * x + y * y
            aside = np.stack([2 * p1 * x * y + p2 * (r + 2 * x * x), p1 * (r + 2 * y * y) + 2 * p2 * x * y], axis=-1)
            found = (seen - aside) / (1.0 + r * (k1 + r * (k2 + r * k3)))[..., None]
        return np.asarray(found)

    def pixels(self, directions: Array) -> Array:
        """Return the pixels (..., 2) of rays with *directions* (..., 2), x / z and y / z."""
        fx, fy, cx, cy, k1, k2, p1, p2, k3 = self.lens
        x, y = directions[..., 0], directions[..., 1]
        r = x * x + y * y
        radial = 1.0 + r * (k1 + r * (k2 + r * k3))
        u = x * radial + 2.0 * p1 * x * y + p2 * (r + 2.0 * x * x)
        v = y * radial + p1 * (r + 2.0 * y * y) + 2.0 * p2 * x * y
        return np.stack([fx * u + cx, fy * v + cy], axis=-1)


def load_camera(path: str | Path) -> Camera:
    """Read a camera: a TOML file that `cablewright camera` wrote, or OpenCV's YAML or XML.

    Raises `InputError`, one line that names the file, the key, its value and what is allowed.
    """
    path = Path(path)
    if path.suffix.lower() not in (".yml", ".yaml", ".xml"):
        return load_model(Camera, path)
    text = read_bytes(path, _MAX_BYTES, "camera file").decode("utf-8", "replace")
    size = [_numbers(text, f"image_{name}", path, 1) for name in ("width", "height")]
    matrix = _numbers(text, "camera_matrix", path, 9)
    lens = _numbers(text, "distortion_coefficients", path)
    if len(lens) < 4 or any(lens[5:]):
        raise InputError(
            f"{path}: distortion_coefficients has {len(lens)} numbers; k1, k2, p1, p2 and k3 are read, and more must "
            "be 0: calibrate without a rational or fisheye model"
        )
    if any(matrix[at] for at in (1, 3, 6, 7)):
        raise InputError(f"{path}: camera_matrix has a skew; only focal lengths and the principal point are read")
    numbers = {
        "width": int(size[0][0]),
        "height": int(size[1][0]),
        "focal": (matrix[0], matrix[4]),
        "principal": (matrix[2], matrix[5]),
        "distortion": tuple([*lens, 0.0][:5]),
    }
    return validated(Camera, numbers, path)


def _numbers(text: str, key: str, path: Path, count: int | None = None) -> list[float]:
    """Return the numbers of a *key* of OpenCV's YAML or XML. Raises `InputError` where they are missing."""
    at = text.lower().find(key)
    part = text[at + len(key) : at + len(key) + _TABLE] if at >= 0 else ""
    if count == 1:
        found = re.match(r'"?[>:\s]\s*([^<\s]+)', part)
    else:
        found = re.search(r"data(?::\s*\[|>)([^\]<]*)[\]<]", part)
    words = re.split(r"[,\s]+", found[1].strip()) if found else []
    try:
        numbers = [float(word) for word in words if word]
        numbers = numbers if all(map(math.isfinite, numbers)) else []
    except ValueError:
        numbers = []
    if not numbers or (count is not None and len(numbers) != count) or len(numbers) > 14:
        raise InputError(
            f"{path}: no {key} with {count or '4 to 14'} finite numbers: is it a calibration file of OpenCV?"
        )
    return numbers


def camera_text(camera: Camera, comments: tuple[str, ...] = ()) -> str:
    """Return the text of a camera's TOML file."""
    table = camera.model_dump(mode="json", by_alias=True)
    return "".join(f"# {comment}\n" for comment in comments) + tomlkit.dumps(table)
