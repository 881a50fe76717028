"""Interference along the whole house job, two threads: the strands as they grow, and a mesh of 50 000 triangles.

Beside, where it is installed: python-fcl's distance of one straight segment from the same mesh, which does not grow.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.timing import Row
from cablewright.analyses.interference import distances
from cablewright.models.solids import of_beads, of_mesh
from cablewright.models.statics import Equilibrium, Model
from cablewright.printing.deposit import deposit
from cablewright.printing.job import load_job
from cablewright.robot import load
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.interference import interference
from cablewright.triangle_mesh import TriangleMesh

Array = NDArray[np.float64]
HOUSE = Path(__file__).parent.parent / "examples" / "house.toml"
SIDE = 159  # corners: 49 928 triangles
AIM = 60.0  # s, a whole job
COMPARED = 5000  # segments for the other library


def rows() -> Iterator[Row]:
    """All rows of this file."""
    model, job = Model(load("house-printer")), load_job(HOUSE)
    samples = job.samples(job.toolpath())
    held = solve_inverse(model, samples.positions, path=True)
    mesh = hills()
    beads, triangles = of_beads(deposit(samples, job.bead)), of_mesh(mesh)
    grown = np.maximum.accumulate(samples.positions[:, 2])
    distances(held[:100], part=beads)  # compiled
    distances(held[:100])
    seconds = once(lambda: distances(held, part=triangles, now=grown))
    each = seconds / (len(samples) * model.m)
    yield Row(f"house: lines from {len(mesh.triangles)} triangles", seconds, "s")
    yield Row(f"house: lines from {len(beads.order)} beads", once(lambda: along_beads(held, beads)), "s")
    for name, part in (("beads", None), (f"mesh of {len(mesh.triangles)} triangles", mesh)):
        seconds = once(lambda given=part: interference(model, job, mesh=given))
        yield Row(f"house: interference of the job, {name}", seconds, "s", f"<= {AIM:.0f} s", seconds <= AIM)
    yield from peer_rows(held, mesh, each)


def along_beads(held: Equilibrium, beads: object) -> None:
    """The strands as they grow."""
    distances(held, part=beads, now=np.arange(len(held.code), dtype=float))


def hills() -> TriangleMesh:
    """A hilly sheet under the house's nozzle, of as many triangles as the aim speaks of."""
    u = np.linspace(0.0, 1.0, SIDE)
    x, y = np.meshgrid(8.0 * u - 4.0, 6.0 * u - 3.0, indexing="ij")
    corners = np.stack([x, y, 1.2 + 1.2 * np.sin(3.0 * x) * np.cos(2.0 * y)], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(SIDE - 1), np.arange(SIDE - 1), indexing="ij")
    a = (i * SIDE + j).ravel()
    faces = np.concatenate([np.stack([a, a + SIDE, a + 1], 1), np.stack([a + 1, a + SIDE, a + SIDE + 1], 1)])
    return TriangleMesh(corners, faces)


def once(function: Callable[[], object]) -> float:
    """Time of one call, s: these take seconds."""
    begin = time.perf_counter()
    function()
    return time.perf_counter() - begin


def peer_rows(held: Equilibrium, mesh: TriangleMesh, each: float) -> Iterator[Row]:
    """What python-fcl takes for the straight line from platform to exit, as a triangle without an area."""
    if find_spec("fcl") is None:
        print("interference: python-fcl is not installed, nothing to compare with", file=sys.stderr)
        return
    import fcl

    corners = mesh.corners.reshape(-1, 3)
    whole = fcl.BVHModel()
    whole.beginModel(len(corners), len(mesh.triangles))
    whole.addSubModel(corners, np.arange(len(corners)).reshape(-1, 3))
    whole.endModel()
    part = fcl.CollisionObject(whole)
    exits = [line.exit_point for line in held.model.robot.lines]
    poses = held.pose[:: max(1, len(held.pose) // (COMPARED // len(exits)))]
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
    yield Row(
        "house: one sagging line from the mesh", 1e6 * each, f"us, {cores} cores", peer="python-fcl, straight, 1 core",
        ratio=peer / each,
    )  # fmt: skip


if __name__ == "__main__":
    for row in rows():
        print(row.text(), flush=True)
