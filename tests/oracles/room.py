"""Rooms for lidars and total stations, made by ray casting from their description alone: without the tested code."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

WEST, EAST, NORTH, SOUTH = -2.6, 2.5, 5.1, -5.2


@dataclass(frozen=True)
class Room:
    """Segments (k, 2, 2) that stop rays, m. `walls` has (normal, distance) of the planes that are walls, by name."""

    segments: np.ndarray
    walls: dict[str, tuple[tuple[float, float], float]] = field(default_factory=dict)


def rectangle(south: bool = False, window: bool = True, furniture: bool = True) -> Room:
    """The room of Merlet and Papegay's machine: three walls, a window 5 cm deep in the east one, things about."""
    east = [(EAST, SOUTH), (EAST, -1.0), (EAST + 0.05, -1.0), (EAST + 0.05, 0.5), (EAST, 0.5), (EAST, NORTH)]
    if not window:
        east = [(EAST, SOUTH), (EAST, NORTH)]
    chain = [*east, (WEST, NORTH), (WEST, SOUTH)]
    if south:
        chain.append((EAST, SOUTH))
    parts = list(pairwise(chain))
    if furniture:
        parts += box(-1.9, 3.6, 0.5, 0.35, 0.4) + box(1.6, -3.8, 0.3, 0.3, -0.2)
    walls = {"west": ((-1.0, 0.0), -WEST), "east": ((1.0, 0.0), EAST), "north": ((0.0, 1.0), NORTH)}
    return Room(np.array(parts, dtype=float), walls)


def box(x: float, y: float, width: float, depth: float, turned: float) -> list[tuple]:
    """The four sides of a thing that stands in the room."""
    c, s = math.cos(turned), math.sin(turned)
    corners = [(-width / 2, -depth / 2), (width / 2, -depth / 2), (width / 2, depth / 2), (-width / 2, depth / 2)]
    placed = [(x + c * u - s * v, y + s * u + c * v) for u, v in corners]
    return [(placed[i], placed[(i + 1) % 4]) for i in range(4)]


def cast(room: Room, place: np.ndarray, bearings: np.ndarray) -> np.ndarray:
    """Distance (n,) from a place to the nearest segment along each bearing; inf where there is none."""
    u = np.stack([np.cos(bearings), np.sin(bearings)], axis=1)  # (n, 2)
    a, e = room.segments[:, 0] - place, room.segments[:, 1] - room.segments[:, 0]  # (k, 2)
    det = e[:, 0] * u[:, None, 1] - e[:, 1] * u[:, None, 0]  # (n, k)
    with np.errstate(divide="ignore", invalid="ignore"):
        far = (e[:, 0] * a[:, 1] - e[:, 1] * a[:, 0]) / det
        along = (u[:, None, 0] * a[:, 1] - u[:, None, 1] * a[:, 0]) / det
    hit = (far > 0) & (along >= 0) & (along <= 1) & np.isfinite(far)
    return np.where(hit, far, np.inf).min(axis=1)


def scan(
    room: Room,
    pose: tuple[float, float, float],
    rng: np.random.Generator,
    n: int = 720,
    sigma: float = 2e-3,
    bias: float = 0.0,
    mount: tuple[float, float] = (0.0, 0.0),
    lidar_yaw: float = 0.0,
    most: float = 12.0,
    spikes: float = 0.0,
) -> tuple[np.ndarray, np.ndarray]:
    """One turn (angles, ranges) of a lidar on a platform at x, y, yaw. What is out of range is 0, as units say it."""
    x, y, yaw = pose
    c, s = math.cos(yaw), math.sin(yaw)
    place = np.array([x + c * mount[0] - s * mount[1], y + s * mount[0] + c * mount[1]])
    angles = np.linspace(0.0, math.tau, n, endpoint=False)
    ranges = cast(room, place, angles + yaw + lidar_yaw)
    ranges = ranges + bias + rng.normal(0.0, sigma, n)
    wrong = rng.random(n) < spikes
    ranges[wrong] *= rng.uniform(0.1, 0.97, wrong.sum())
    return angles, np.where(np.isfinite(ranges) & (ranges <= most), ranges, 0.0)
