"""Pictures of AprilTags as a camera takes them, by ray casting: distortion, blur, noise, uneven light, grey levels.

It shares no code with the detection: each sample of a pixel is a ray, by Newton's method on the lens, which meets the
plane of a tag where its print is black or white. Light adds up before the grey levels are made of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

Array = NDArray[np.float64]
_BLACK, _WHITE, _WALL = 0.03, 0.75, 0.25  # of the light
_SAMPLES = 4  # along each side of a pixel
_GAMMA = 2.2


@dataclass(frozen=True)
class Tag:
    """A printed tag: number, side of the black square (m), place (3,) and rotation (3, 3) in the camera's frame."""

    number: int
    size: float
    place: Array
    rotation: Array


@dataclass(frozen=True)
class Flaws:
    """Blur of the lens and of a motion along x (px), noise (grey levels), and light that falls across the picture."""

    blur: float = 0.7
    motion: float = 0.0
    noise: float = 2.0
    fall: float = 0.4


def print_of(number: int) -> Array:
    """Return the print (10, 10) of a tag with its white margin: 1 is white; row 0 is its top."""
    family = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    inside = cv2.aruco.generateImageMarker(family, number, 8, borderBits=1) / 255.0
    return np.pad(inside, 1, constant_values=1.0)


def rays(lens: Array, u: Array, v: Array) -> tuple[Array, Array]:
    """Return x / z and y / z of the rays to pixels, by Newton's method on the distortion."""
    fx, fy, cx, cy, k1, k2, p1, p2, k3 = lens
    xd, yd = (u - cx) / fx, (v - cy) / fy
    x, y = xd.copy(), yd.copy()
    for _ in range(8):
        r = x * x + y * y
        d = 1 + k1 * r + k2 * r**2 + k3 * r**3
        dr = k1 + 2 * k2 * r + 3 * k3 * r**2
        ex = x * d + 2 * p1 * x * y + p2 * (r + 2 * x * x) - xd
        ey = y * d + p1 * (r + 2 * y * y) + 2 * p2 * x * y - yd
        a, b = d + 2 * x * x * dr + 2 * p1 * y + 6 * p2 * x, 2 * x * y * dr + 2 * p1 * x + 2 * p2 * y
        c = d + 2 * y * y * dr + 6 * p1 * y + 2 * p2 * x
        det = a * c - b * b
        x, y = x - (c * ex - b * ey) / det, y - (a * ey - b * ex) / det
    return x, y


def pixel_of(lens: Array, points: Array) -> Array:
    """Return the pixels (..., 2) of *points* (..., 3) in the camera's frame."""
    fx, fy, cx, cy, k1, k2, p1, p2, k3 = lens
    x, y = points[..., 0] / points[..., 2], points[..., 1] / points[..., 2]
    r = x * x + y * y
    d = 1 + k1 * r + k2 * r**2 + k3 * r**3
    u = x * d + 2 * p1 * x * y + p2 * (r + 2 * x * x)
    v = y * d + p1 * (r + 2 * y * y) + 2 * p2 * x * y
    return np.stack([fx * u + cx, fy * v + cy], axis=-1)


def picture(
    lens: Array, width: int, height: int, tags: list[Tag], rng: np.random.Generator, flaws: Flaws = Flaws()
) -> NDArray[np.uint8]:
    """Return the grey levels (height, width) of *tags*, nearer ones before farther ones."""
    light = np.full((height, width), _WALL, dtype=np.float32)
    for tag in sorted(tags, key=lambda each: -each.place[2]):
        _draw(light, lens, tag)
    if flaws.blur:
        light = gaussian_filter(light, flaws.blur)
    if flaws.motion >= 1.0:
        kernel = np.ones(round(flaws.motion)) / round(flaws.motion)
        light = np.apply_along_axis(lambda row: np.convolve(row, kernel, mode="same"), 1, light)
    across, down = np.linspace(0.0, 1.0, width, dtype=np.float32), np.linspace(0.6, 1.0, height, dtype=np.float32)
    light *= np.float32(1.0) - np.float32(flaws.fall) * across * down[:, None]
    noise = rng.standard_normal(light.shape, dtype=np.float32) * np.float32(flaws.noise)
    grey = np.float32(255.0) * light ** np.float32(1.0 / _GAMMA) + noise
    return np.clip(np.round(grey), 0, 255).astype(np.uint8)


@lru_cache(maxsize=4)
def _ray_map(*given: float) -> list[tuple[NDArray[np.float32], ...]]:
    """Return x / z and y / z of the ray to each pixel, each with its derivatives by u and v; *given*: lens, size."""
    lens, (height, width) = np.array(given[:9]), map(int, given[9:])
    u, v = np.meshgrid(np.arange(float(width)), np.arange(float(height)))
    found = [(each, np.gradient(each, axis=1), np.gradient(each, axis=0)) for each in rays(lens, u, v)]
    return [tuple(part.astype(np.float32) for part in each) for each in found]  # twice as fast


def _draw(light: Array, lens: Array, tag: Tag) -> None:
    """Draw a tag with its white margin into *light* (height, width)."""
    if tag.place[2] < 0.1 or tag.rotation[:, 2] @ tag.place > 0.0:
        return  # behind the camera, or seen from behind
    half = 0.5 * tag.size * 10.0 / 8.0
    along = np.linspace(-half, half, 9)
    rim = np.array([(a, b) for a in along for b in along])
    points = tag.place + rim @ tag.rotation[:, :2].T
    if points[:, 2].min() < 0.1:
        return
    where = pixel_of(lens, points)
    (u0, v0), (u1, v1) = np.floor(where.min(axis=0)).astype(int) - 1, np.ceil(where.max(axis=0)).astype(int) + 2
    u0, v0, u1, v1 = max(u0, 0), max(v0, 0), min(u1, light.shape[1]), min(v1, light.shape[0])
    if u1 <= u0 or v1 <= v0:
        return
    ranks = np.arange(
        _SAMPLES
    )  # samples of a pixel share no row and no column, so that edges along the pixels are fine
    finer = (ranks + 0.5) / _SAMPLES**2 - 0.5
    shifts = (ranks / _SAMPLES + finer[:, None]).astype(np.float32)
    aside, below = shifts[:, None], shifts.T[:, None]
    box = np.s_[v0:v1, None, u0:u1, None]
    x, y = (at[box] + by_u[box] * aside + by_v[box] * below for at, by_u, by_v in _ray_map(*lens, *light.shape))
    right, down, normal = (tag.rotation * [1.0, -1.0, 1.0]).T.astype(np.float32)
    depth = float(normal @ tag.place) / (normal[0] * x + normal[1] * y + normal[2])

    def cells(way: Array) -> Array:
        """Cells of the print before each sample, along a side."""
        from_middle = depth * (way[0] * x + way[1] * y + way[2]) - float(way @ tag.place)
        return np.floor(5.0 / float(half) * from_middle + 5.0)

    column, row = cells(right), cells(down)
    inside = (depth > 0.0) & (column >= 0) & (column < 10) & (row >= 0) & (row < 10)
    levels = np.where(print_of(tag.number) > 0.5, _WHITE, _BLACK).astype(np.float32)
    shown = levels[row.clip(0, 9).astype(np.intp), column.clip(0, 9).astype(np.intp)]
    share = inside.mean(axis=(1, 3))
    total = np.where(inside, shown, np.float32(0.0)).mean(axis=(1, 3))
    light[v0:v1, u0:u1] = total + (1.0 - share) * light[v0:v1, u0:u1]
