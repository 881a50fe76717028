"""Every equilibrium: what many starts find beside what the exhaustive search proves.

`python -m benchmarks.equilibria 100` takes 100 random sets of lengths in place of the few of `make bench`.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from benchmarks.timing import Row
from cablewright.foundation.errors import Status
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.equilibria import equilibria
from cablewright.solvers.exhaustive import begin, exhaust
from cablewright.solvers.inverse import solve_inverse

SEED = 5
EXCESS = 0.3  # m: up to which one line is too long, in two sets of three


@dataclass(frozen=True)
class Size:
    """How much is searched."""

    sets: int = 2  # of lengths
    machines: tuple[str, ...] = ("merlet2023", "paty2021")
    longest: float = 600.0  # s, a search, once the shapes of its lines are known


FULL, QUICK = Size(), Size(1, ("merlet2023",), 1e-3)


def rows(size: Size) -> Iterator[Row]:
    """All rows of this file."""
    for name in size.machines:
        yield from machine_rows(name, size.sets, size.longest)


def machine_rows(name: str, sets: int, longest: float) -> Iterator[Row]:
    """Random poses within the limits, one line longer or not."""
    model, rng = Model(load(name)), np.random.default_rng(SEED)
    starts, searches, complete, missed, boxes = [], [], 0, 0, 0
    _compile(model)
    for lengths in random_lengths(model, rng, sets):
        clock = time.perf_counter()
        found = equilibria(model, lengths)
        starts.append(time.perf_counter() - clock)
        clock = time.perf_counter()
        every, _ = exhaust(found, begin(model, None), time_limit=longest)
        searches.append(time.perf_counter() - clock)
        complete += every.complete_for is not None
        missed += len(every.stable) > len(found.stable)
        boxes += len(every.undecided)
    quick = 1e3 * float(np.median(starts))
    slow = max(searches)
    yield Row(f"{name}: equilibria from many starts", quick, "ms", "<= 50", quick <= 50)
    yield Row(f"{name}: sets of lengths, of {sets}, in which the search finds more", missed, "sets", "= 0", missed == 0)
    yield Row(f"{name}: sets proved complete", 100 * complete / sets, "%")
    yield Row(f"{name}: boxes left undecided in the others", boxes, "boxes")
    yield Row(f"{name}: slowest exhaustive search", slow, "s", "<= 600", slow <= 600)


def _compile(model: Model) -> None:
    """Have both compiled, at lengths that are in no set."""
    (lengths,) = random_lengths(model, np.random.default_rng(SEED + 1), 1)
    exhaust(equilibria(model, lengths), begin(model, None), time_limit=1e-3)


def random_lengths(model: Model, rng: np.random.Generator, sets: int) -> Iterator[np.ndarray]:
    """Lengths of poses that the machine can hold, a random line longer in two of three."""
    low, high = np.array(model.robot.scene.frame_min), np.array(model.robot.scene.frame_max)
    given = 0
    while given < sets:
        pose = low + (high - low) * rng.uniform([0.2, 0.2, 0.1], [0.8, 0.8, 0.7])
        held = solve_inverse(model, pose)
        if held.status is Status.OK:
            lengths = held.lengths.copy()
            lengths[rng.integers(model.m)] += EXCESS * rng.random() if given % 3 else 0.0
            given += 1
            yield lengths


if __name__ == "__main__":
    for row in rows(Size(int(sys.argv[1]))):
        print(f"{row.name}: {row.value:.3g} {row.unit}")
