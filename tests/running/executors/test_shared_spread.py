"""The spread of errors over many places: the same bytes whoever computes it, and resumed from stored results."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from cablewright.analyses.accuracy.nozzle_error import Accuracy
from cablewright.analyses.accuracy.spread import Method, MonteCarlo, Spread
from cablewright.foundation.errors import InputError
from cablewright.live.position_sets import Places
from cablewright.robot import load
from cablewright.running.executors.executor import Executor, Serial
from cablewright.running.executors.processes import Processes
from cablewright.studies.accuracy import accuracy

HOUSE, JUNG = load("house-printer"), load("jung2020")
POSES = np.column_stack([np.zeros((130, 2)), np.linspace(0.5, 1.5, 130), np.zeros((130, 3))])
RETRACTION = np.linspace(1.2, 1.9, len(POSES))


@pytest.fixture(scope="module")
def processes() -> Iterator[Processes]:
    executor = Processes(2)
    yield executor
    executor.close()


def require_same(one: Accuracy, other: Accuracy) -> None:
    assert (one.method, one.ranges) == (other.method, other.ranges)
    for each in fields(Spread):
        np.testing.assert_array_equal(getattr(one.spread, each.name), getattr(other.spread, each.name))


@pytest.mark.parametrize("method", ["vertices", "first-order", MonteCarlo(500, 3)])
def test_the_errors_of_a_plane_are_the_same_to_the_bit(method: Method | str, processes: Processes) -> None:
    where = Places.plane(HOUSE, 1.0, None, 2.0)
    own = accuracy(HOUSE, where, method=method).accuracy
    assert len(own) > 64  # more than one block
    require_same(accuracy(HOUSE, where, method=method, executor=Serial()).accuracy, own)
    require_same(accuracy(HOUSE, where, method=method, executor=processes).accuracy, own)


def test_poses_of_a_retracting_body_are_resumed_from_stored_results(tmp_path: Path, processes: Processes) -> None:
    own = accuracy(JUNG, POSES, retraction=RETRACTION)
    file = tmp_path / "kept.jsonl"

    class Interrupted(Serial):
        def run(self, chunks):
            yield next(iter(super().run(chunks)))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        accuracy(JUNG, POSES, retraction=RETRACTION, executor=Interrupted(), file=file)
    assert len(file.read_text().splitlines()) == 2  # the head, and the first of three blocks
    report: list[int] = []
    found = accuracy(
        JUNG,
        POSES,
        retraction=RETRACTION,
        executor=processes,
        file=file,
        progress=lambda _stage, done, _total: report.append(done),
    )
    assert report[0] == 1
    require_same(found, own)


def test_methods_without_options_are_not_taken_for_each_other(tmp_path: Path) -> None:
    file = tmp_path / "kept.jsonl"
    for method in ("vertices", "first-order", "vertices"):
        require_same(accuracy(JUNG, POSES[:3], method=method, file=file), accuracy(JUNG, POSES[:3], method=method))


def test_one_pose_has_no_executor() -> None:
    executor: Executor = Serial()
    with pytest.raises(InputError, match="leave them out for a single pose"):
        accuracy(JUNG, POSES[0].tolist(), executor=executor)  # type: ignore[call-overload]  # as one who checks no types
