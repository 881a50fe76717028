"""Interference along the whole house job, two threads: the strands as they grow, and a mesh of 50 000 triangles.

Beside, where it is installed: python-fcl's distance of one straight segment from the same mesh, which does not grow.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.commands import house
from benchmarks.timing import Row, installed
from cablewright.analyses.interference import distances
from cablewright.foundation.triangle_mesh import TriangleMesh
from cablewright.models.obstacles import of_beads, of_mesh
from cablewright.models.statics import Equilibrium, Model
from cablewright.printing.growing_part import deposit
from cablewright.printing.job import Job, load_job
from cablewright.robot import load
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.interference import interference

Array = NDArray[np.float64]
AIM = 60.0  # s, a whole job


@dataclass(frozen=True)
class Size:
    """How much is measured."""

    moves: int | None = None  # lines of the house's G-code; None: all
    side: int = 159  # corners of the mesh: 49 928 triangles
    compared: int = 5000  # segments for the other library


FULL, QUICK = Size(), Size(40, 5, 8)


def rows(size: Size) -> Iterator[Row]:
    """All rows of this file."""
    with tempfile.TemporaryDirectory() as folder:
        yield from job_rows(Model(load("house-printer")), load_job(house(Path(folder), size.moves)), size)


def job_rows(model: Model, job: Job, size: Size) -> Iterator[Row]:
    """Of one job."""
    samples = job.samples(job.toolpath())
    held = solve_inverse(model, samples.positions, path=True)
    mesh = hills(size.side)
    beads, triangles = of_beads(deposit(samples, job.bead)), of_mesh(mesh)
    grown = np.maximum.accumulate(samples.positions[:, 2])
    distances(held[:100], part=beads)  # compiled
    distances(held[:100])
    seconds = once(lambda: distances(held, part=triangles, now=grown))
    each = seconds / (len(samples) * model.m)
    yield Row(f"house: lines from {len(mesh.triangles)} triangles", seconds, "s")
    yield Row(f"house: lines from {len(beads.order)} beads", once(lambda: along_beads(held, beads)), "s")
    for name, part in (("beads", None), (f"mesh of {len(mesh.triangles)} triangles", mesh)):
        seconds = once(lambda given=part: interference(model, job, part=given))
        yield Row(f"house: interference of the job, {name}", seconds, "s", f"<= {AIM:.0f} s", seconds <= AIM)
    if installed("fcl"):
        yield peer_row(held, mesh, each, size.compared)


def along_beads(held: Equilibrium, beads: object) -> None:
    """The strands as they grow."""
    distances(held, part=beads, now=np.arange(len(held.code), dtype=float))


def hills(side: int) -> TriangleMesh:
    """A hilly sheet under the house's nozzle, of *side* times *side* corners."""
    u = np.linspace(0.0, 1.0, side)
    x, y = np.meshgrid(8.0 * u - 4.0, 6.0 * u - 3.0, indexing="ij")
    corners = np.stack([x, y, 1.2 + 1.2 * np.sin(3.0 * x) * np.cos(2.0 * y)], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(side - 1), np.arange(side - 1), indexing="ij")
    a = (i * side + j).ravel()
    faces = np.concatenate([np.stack([a, a + side, a + 1], 1), np.stack([a + 1, a + side, a + side + 1], 1)])
    return TriangleMesh(corners, faces)


def once(function: Callable[[], object]) -> float:
    """Time of one call, s: these take seconds."""
    begin = time.perf_counter()
    function()
    return time.perf_counter() - begin


def peer_row(held: Equilibrium, mesh: TriangleMesh, each: float, compared: int) -> Row:
    """What python-fcl takes for the straight line from platform to exit, as a triangle without an area."""
    import fcl

    corners = mesh.corners.reshape(-1, 3)
    whole = fcl.BVHModel()
    whole.beginModel(len(corners), len(mesh.triangles))
    whole.addSubModel(corners, np.arange(len(corners)).reshape(-1, 3))
    whole.endModel()
    part = fcl.CollisionObject(whole)
    exits = [line.exit_point for line in held.model.robot.lines]
    poses = held.pose[:: max(1, len(held.pose) // (compared // len(exits)))]
    begin = time.perf_counter()
    for pose in poses:
        for end in exits:
            line = fcl.BVHModel()
            line.beginModel(3, 1)
            line.addSubModel(np.array([pose, end, end]), np.array([[0, 1, 2]]))
            line.endModel()
            fcl.distance(part, fcl.CollisionObject(line), fcl.DistanceRequest(), fcl.DistanceResult())
    peer = (time.perf_counter() - begin) / (len(poses) * len(exits))
    cores = os.cpu_count() or 1
    return Row(
        "house: one sagging line from the mesh", 1e6 * each, f"us, {cores} cores", peer="python-fcl, straight, 1 core",
        ratio=peer / each,
    )  # fmt: skip
