"""Scans of made-up rooms by a made-up lidar, with their truth: nothing here is shared with the tested code.

A scan has what real ones have: the device's own housing at a few centimetres, noise that grows with range, glass that
sends nothing back or shows what is behind it, a person who walks during the turn, a pillar, furniture, edges between
two echoes, rays without an echo.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from oracles.room import Room, box, cast


class Surface(NamedTuple):
    """A straight surface of the truth as a scan shows it, in the lidar's frame."""

    angle: float  # rad, of the normal from the lidar
    distance: float  # m
    angle_sigma: float  # rad, of the best estimate that knows which points are on it, and their noise
    distance_sigma: float  # m
    length: float  # m, between the outer points on it
    points: int
    is_wall: bool  # of the room, and not the side of a thing
    ends: np.ndarray  # (2, 2) m, of the whole segment, in the lidar's frame


class Scanned(NamedTuple):
    """One turn, and the surfaces in it."""

    angles: np.ndarray  # (n,) rad
    ranges: np.ndarray  # (n,) m, 0 without an echo
    surfaces: tuple[Surface, ...]
    noise: tuple[float, float]  # m, and m per m of range
    housing: tuple[tuple[float, float], ...]  # bearings from, to, rad


def outline(rng: np.random.Generator) -> list[tuple[float, float]]:
    """Corners of a room, counter-clockwise and closed: a rectangle, one with a corner cut off, or an L."""
    a, b = rng.uniform(3.0, 11.0), rng.uniform(3.0, 8.0)
    kind = rng.choice(["rectangle", "cut", "L"], p=[0.5, 0.25, 0.25])
    if kind == "rectangle":
        corners = [(0.0, 0.0), (a, 0.0), (a, b), (0.0, b)]
    elif kind == "cut":
        c = rng.uniform(0.3, 0.45) * min(a, b)
        corners = [(0.0, 0.0), (a, 0.0), (a, b - c), (a - c, b), (0.0, b)]
    else:
        c, d = rng.uniform(0.5, 0.7) * a, rng.uniform(0.5, 0.7) * b
        corners = [(0.0, 0.0), (a, 0.0), (a, d), (c, d), (c, b), (0.0, b)]
    return [*corners, corners[0]]


def round_thing(x: float, y: float, radius: float) -> list[tuple]:
    """A pillar of many short sides."""
    turn = np.linspace(0.0, math.tau, 25)
    return list(pairwise(zip(x + radius * np.cos(turn), y + radius * np.sin(turn), strict=True)))


def scanned(seed: int, clutter: int = 0) -> Scanned:
    """A room, its things, a place of the lidar and one turn, all drawn from *seed*.

    *clutter*: more things, small boxes, pillars and plants whose echoes scatter.
    """
    rng = np.random.default_rng(seed)
    corners = outline(rng)
    walls = list(pairwise(corners))
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    place = low + rng.uniform(0.25, 0.6, 2) * (high - low) * (0.8, 0.8)
    things: list[tuple] = []

    def free(gap: float) -> np.ndarray:
        while True:
            at = rng.uniform(low + 0.5, high - 0.5)
            if math.dist(at, place) > gap:
                return at

    if rng.random() < 0.7:
        at = free(1.2)
        if rng.random() < 0.5:
            things += box(*at, *rng.uniform(0.25, 0.5, 2), rng.uniform(0, math.pi))
        else:
            things += round_thing(*at, rng.uniform(0.12, 0.3))
    if rng.random() < 0.5:
        things += box(*free(1.3), *rng.uniform(0.4, 1.2, 2), rng.uniform(0, math.pi))
    plants = []
    for _ in range(clutter):
        kind, at = rng.integers(3), free(0.7)
        if kind == 2:
            plants.append(len(walls + things))
        round_one = round_thing(*at, rng.uniform(0.1, 0.35))
        things += round_one if kind else box(*at, *rng.uniform(0.1, 0.5, 2), rng.uniform(0, 3.0))
    segments = np.array(walls + things, dtype=float)

    n = int(rng.choice([360, 720, 1080, 1440]))
    yaw = rng.uniform(-math.pi, math.pi)
    angles = np.linspace(0.0, math.tau, n, endpoint=False) + rng.normal(0.0, 0.05 * math.tau / n, n)
    bearings = angles + yaw
    every = np.array([cast(Room(segments[i : i + 1]), place, bearings) for i in range(len(segments))])
    owner, true = every.argmin(axis=0), every.min(axis=0)
    true, owner = _glass(rng, walls, place, bearings, true, owner)
    person = _person(rng, place, yaw, free(1.0), n, bearings)
    owner[person < true] = -1
    true = np.minimum(true, person)

    noise = (rng.uniform(0.001, 0.005), rng.uniform(0.0, 0.006))
    leaves = np.isin(owner, [first + k for first in plants for k in range(24)])
    true[leaves] += rng.exponential(0.1, int(leaves.sum()))
    owner[leaves] = -1
    ranges = true + rng.standard_normal(n) * (noise[0] + noise[1] * np.where(np.isfinite(true), true, 0.0))
    step = np.where(np.isfinite(true), true, 0.0)
    both = np.isfinite(true) & np.isfinite(np.roll(true, -1))
    edge = np.flatnonzero((np.abs(np.roll(step, -1) - step) > 0.15) & both)
    mixed = edge[rng.random(len(edge)) < 0.5]
    ranges[mixed] += rng.uniform(0.2, 0.8, len(mixed)) * (true[(mixed + 1) % n] - true[mixed])
    owner[mixed] = -1
    housing = _housing(rng, angles, ranges, owner)
    lost = (rng.random(n) < rng.uniform(0.0, 0.04)) | ~np.isfinite(ranges) | (ranges > 25.0)
    owner[lost] = -1
    ranges = np.where(lost, 0.0, np.round(ranges, 3))
    surfaces = [
        _surface(np.flatnonzero(owner == k), one, place, yaw, bearings, true, noise, k < len(walls))
        for k, one in enumerate(segments)
        if (owner == k).sum() >= 3
    ]
    return Scanned(angles, ranges, tuple(surfaces), noise, housing)


def _glass(rng, walls, place, bearings, true, owner) -> tuple[np.ndarray, np.ndarray]:
    """Make parts of some walls glass: most rays see what is behind it, or nothing, and few the pane itself."""
    true, owner = true.copy(), owner.copy()
    for k, (a, b) in enumerate(walls):
        size = math.dist(a, b)
        if rng.random() > 0.35 or size < 2.5:
            continue
        width = rng.uniform(0.6, min(2.5, 0.5 * size))
        begin = rng.uniform(0.2, size - width - 0.2)
        hit = np.flatnonzero(owner == k)
        at = place + true[hit, None] * np.stack([np.cos(bearings[hit]), np.sin(bearings[hit])], axis=1)
        along = (at - a) @ (np.subtract(b, a) / size)
        pane = hit[(along > begin) & (along < begin + width)]
        kind = rng.choice(["missing", "scattered", "facade"])
        draw = rng.random(len(pane))
        far = pane[draw > 0.15]
        owner[far] = -1
        if kind == "missing":
            true[far] = np.inf
        elif kind == "scattered":
            true[far] += rng.uniform(0.5, 8.0, len(far))
            true[far[rng.random(len(far)) < 0.5]] = np.inf
        else:  # a house across the street, seen through the pane
            normal = np.array([b[1] - a[1], a[0] - b[0]]) / size
            tilt = rng.uniform(-0.3, 0.3)
            normal = np.array([[math.cos(tilt), -math.sin(tilt)], [math.sin(tilt), math.cos(tilt)]]) @ normal
            off = normal @ (np.array(a) - place) + rng.uniform(2.0, 5.0)
            true[far] = off / (np.cos(bearings[far]) * normal[0] + np.sin(bearings[far]) * normal[1])
    return true, owner


def _person(rng, place, yaw, at, n, bearings) -> np.ndarray:
    """Ranges (n,) to a body that walks, and changes its size as limbs swing, while the lidar rotates; inf beside it."""
    if rng.random() < 0.4:
        return np.full(n, np.inf)
    velocity, radius = rng.normal(0.0, 0.8, 2), rng.uniform(0.12, 0.28)
    time = np.linspace(0.0, 0.15, n)
    centre = at + time[:, None] * velocity - place
    size = radius * (1.0 + 0.3 * np.sin(rng.uniform(0, 6) + 40.0 * time)) + rng.normal(0.0, 0.015, n)
    u = np.stack([np.cos(bearings), np.sin(bearings)], axis=1)
    along = (centre * u).sum(axis=1)
    across = np.abs(centre[:, 1] * u[:, 0] - centre[:, 0] * u[:, 1])
    with np.errstate(invalid="ignore"):
        front = along - np.sqrt(size**2 - across**2)
    return np.where((across < size) & (front > 0.1), front, np.inf)


def _housing(rng, angles, ranges, owner) -> tuple[tuple[float, float], ...]:
    """Hide some bearings behind parts of the device itself, at a nearly constant few centimetres each."""
    hidden = []
    for _ in range(int(rng.integers(0, 4))):
        begin, width, far = rng.uniform(0, math.tau), math.radians(rng.uniform(4.0, 45.0)), rng.uniform(0.05, 0.2)
        inside = np.flatnonzero((angles - begin) % math.tau < width)
        ranges[inside] = far * (1.0 + 0.03 * rng.uniform(-1, 1)) + rng.normal(0.0, 0.0015, len(inside))
        owner[inside] = -1
        hidden.append((begin, begin + width))
    return tuple(hidden)


def _surface(hit, ends, place, yaw, bearings, true, noise, is_wall) -> Surface:
    """The line of a segment in the lidar's frame, and the bound of its accuracy by its points (Cramer-Rao)."""
    a, b = ends[0] - place, ends[1] - place
    along = (b - a) / np.hypot(*(b - a))
    normal = np.array([along[1], -along[0]])
    normal = normal if normal @ a > 0 else -normal
    u = np.stack([np.cos(bearings[hit]), np.sin(bearings[hit])], axis=1)
    at = (true[hit, None] * u) @ along
    sigma = (noise[0] + noise[1] * true[hit]) * np.abs(u @ normal)
    J = np.stack([at, np.ones(len(hit))], axis=1) / np.maximum(sigma, 1e-4)[:, None]
    covariance = np.linalg.pinv(J.T @ J)
    return Surface(
        math.remainder(math.atan2(normal[1], normal[0]) - yaw, math.tau), float(normal @ a),
        math.sqrt(covariance[0, 0]), math.sqrt(covariance[1, 1]), float(np.ptp(at)), len(hit), is_wall,
        np.stack([a, b]) @ np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]]),
    )  # fmt: skip


def judged(found: list[tuple[float, float, np.ndarray]], truth: Scanned) -> list[str]:
    """What is wrong with walls *found* (angle, distance, ends) in a scan; empty where nothing is.

    Each wall of the room that shows over 1 m with 20 points or more, and whose points determine its direction to 0.5
    deg and its distance to 20 mm with four sigma, must be found that well. A line over 0.8 m is invented if not both
    its ends are on one true surface: within 20 mm or three sigma of a range there, and that and 0.3 m past its corner
    at most.
    """
    half_degree, near = math.radians(0.5), 0.02
    wrong = []
    for one in truth.surfaces:
        told = 4 * one.angle_sigma < half_degree and 4 * one.distance_sigma < near
        if not (one.is_wall and one.length > 1.0 and one.points >= 20 and told):
            continue
        if not any(
            abs(math.remainder(angle - one.angle, math.tau)) < half_degree and abs(distance - one.distance) < near
            for angle, distance, _ in found
        ):
            wrong.append(f"missed {math.degrees(one.angle):.1f} deg, {one.distance:.3f} m, {one.length:.2f} m long")
    for angle, distance, ends in found:
        allowed = np.maximum(near, 3.0 * (truth.noise[0] + truth.noise[1] * np.hypot(*ends.T)))
        length = np.hypot(*(ends[1] - ends[0]))
        if length > 0.8 and not any(_lies_on(ends, one.ends, allowed) for one in truth.surfaces):
            wrong.append(f"invented {math.degrees(angle):.1f} deg, {distance:.3f} m, {length:.2f} m long")
    return wrong


def _lies_on(points: np.ndarray, ends: np.ndarray, allowed: np.ndarray) -> bool:
    """Whether points are as near a segment's line as *allowed* (n,), m, and at most 0.3 m more past its ends."""
    side = ends[1] - ends[0]
    size = np.hypot(*side)
    along, across = (points - ends[0]) @ side / size, (points - ends[0]) @ (-side[1], side[0]) / size
    past = np.maximum(-along, along - size)
    return bool(((np.abs(across) < allowed) & (past < 0.3 + allowed)).all())
