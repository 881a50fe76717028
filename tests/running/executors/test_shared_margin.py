"""The margins of a workspace: the same surface to the bit whoever computes them, and resumed from stored results."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cablewright.analyses.workspace.area import workspace_area
from cablewright.analyses.workspace.criterion import RetractionLaw
from cablewright.analyses.workspace.workspace import count_nodes, workspace
from cablewright.robot import load
from cablewright.running.executors.executor import Serial
from cablewright.running.executors.parallel_margins import SharedMargin
from cablewright.running.executors.processes import Processes
from cablewright.running.executors.stored_results import KeptResults, kept_in

JUNG = load("jung2020")
QUESTIONS: tuple[tuple[str, str, dict[str, Any]], ...] = (
    ("jung2020", "exact", {"tolerance": 0.02, "orientations": [[0.0, 0.0, 0.0], [0.0, 0.0, 0.1]]}),
    ("jung2020", "capacity", {"grid": 15, "wrench_box": ([-5.0] * 3 + [0.0] * 3, [5.0] * 3 + [0.0] * 3)}),
    ("jung2020", "closed-form", {"grid": 15, "retraction": RetractionLaw(-0.5, 2.0, 1.2, 2.0)}),
    ("merlet2023", "static", {"grid": 9}),
)


@pytest.fixture(scope="module")
def processes() -> Iterator[Processes]:
    executor = Processes(2)
    yield executor
    executor.close()


@pytest.mark.parametrize(("name", "criterion", "options"), QUESTIONS)
def test_a_workspace_is_the_same_to_the_bit(
    name: str, criterion: str, options: dict[str, Any], processes: Processes
) -> None:
    robot = load(name)
    own = workspace(robot, criterion, **options)
    for executor in (Serial(), processes):
        found = workspace(robot, criterion, margins=SharedMargin(executor), **options)
        assert (found.volume, found.volume_error, found.nodes) == (own.volume, own.volume_error, own.nodes)
        np.testing.assert_array_equal(found.mesh.vertices, own.mesh.vertices)


def test_nodes_and_areas_are_the_same(processes: Processes) -> None:
    shared, flat = SharedMargin(processes), (-0.5, 0.5, -0.5, 0.5, 1.0, 1.0)
    np.testing.assert_array_equal(count_nodes(JUNG, grid=21, margins=shared).inside, count_nodes(JUNG, grid=21).inside)
    own = workspace_area(JUNG, box=flat)
    assert workspace_area(JUNG, box=flat, margins=shared).area == own.area > 0.0


def test_an_interrupted_workspace_goes_on_and_without_orientations_it_is_empty(tmp_path: Path) -> None:
    calls: list[int] = []

    class Counting(Serial):
        def run(self, chunks):
            for computed in super().run(chunks):
                calls.append(len(computed.numbers))
                yield computed
                if len(calls) == 1:
                    raise KeyboardInterrupt

    file = tmp_path / "kept.jsonl"
    with pytest.raises(KeyboardInterrupt), kept_in(file) as kept:
        count_nodes(JUNG, grid=21, margins=SharedMargin(Counting(), kept))
    done = sum(calls)
    with kept_in(file) as kept:
        found = count_nodes(JUNG, grid=21, margins=SharedMargin(Counting(), kept))
    assert sum(calls) - done == -(-(21**3) // 4096) - done
    np.testing.assert_array_equal(found.inside, count_nodes(JUNG, grid=21).inside)
    empty = count_nodes(JUNG, grid=5, orientations=np.zeros((0, 3)), margins=SharedMargin(Serial(), KeptResults()))
    assert not empty.counted
