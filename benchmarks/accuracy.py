"""Accuracy over a plane, the workspace and samples, beside what solving alone takes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from benchmarks.timing import Row, best
from cablewright.analyses.accuracy.corners import signs_of_box
from cablewright.analyses.accuracy.spread import FirstOrder, MonteCarlo, SpreadProblem, sampled
from cablewright.live.position_sets import Places
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.solvers.forward import solve_forward
from cablewright.studies.accuracy import AccuracyStudy, accuracy


@dataclass(frozen=True)
class Size:
    """How much is measured."""

    plane_step: float = 13.5 / 40  # m
    step: float = 0.39  # m: 50 000 places of the house printer's workspace
    samples: int = 100_000


FULL, QUICK = Size(), Size(13.5 / 4, 3.0, 100)


def rows(size: Size) -> Iterator[Row]:
    """All rows of this file."""
    house = load("house-printer")
    plane = Places.plane(house, 0.0, 6.75, size.plane_step)
    count = len(plane.positions)
    seconds = best(lambda: accuracy(house, plane), 3)
    beside = _beside(accuracy(house, plane), seconds)
    yield Row(f"accuracy of a plane, {count} places x 16", seconds, "s", "<= 1", seconds <= 1, *beside)
    whole = accuracy(house, Places.workspace(size.step))
    reached = len(whole.accuracy.codes)
    seconds = best(lambda: accuracy(house, Places.workspace(size.step)), 1)
    beside = _beside(whole, seconds)
    name = f"accuracy of the workspace, {reached} places x 16"
    yield Row(name, seconds, "s", "<= 15", seconds <= 15 and reached >= 50_000, *beside)
    pose = [2.0, 1.0, 3.0]
    seconds = best(lambda: accuracy(house, [pose], method=MonteCarlo(size.samples)), 3)
    yield Row(f"Monte Carlo at a place, {size.samples} samples", seconds, "s", "<= 2", seconds <= 2)
    first = best(lambda: accuracy(house, plane, method=FirstOrder()), 3)
    yield Row(f"first order over a plane, {count} places", first, "s")


def _beside(study: AccuracyStudy, seconds: float) -> tuple[str, float]:
    """How many times as long as solving the corners of all its places takes, and nothing else."""
    robot, found = study.accuracy.robot, study.accuracy
    nominal = solve_forward(Model(robot), found.commanded, guess=found.nominal, path=True)
    problem = SpreadProblem(nominal, found.commanded, found.wanted, found.ranges)
    corners = problem.middle + signs_of_box(len(found.ranges)) * problem.half_widths
    alone = best(lambda: sampled(problem, corners), 2)
    return "solving the corners alone", seconds / alone
