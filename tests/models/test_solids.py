"""The tree of the growing part: every piece is in it once, within its boxes, from its birth on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cablewright.foundation import memory_mapped
from cablewright.foundation.memory_mapped import MEMORY, Room
from cablewright.models.obstacles import Obstacle, nothing, of_beads
from cablewright.printing.growing_part import Deposit, deposit
from cablewright.printing.job import Job
from cablewright.printing.numeric_path import Helix


def laid(room: Room = MEMORY) -> Deposit:
    """The strands of a helix of 700 moves or so."""
    job = Job(name="helix", helix=Helix(radius=0.8, layers=4, layer_height=0.05, first_height=0.1))
    return deposit(job.samples(job.toolpath(), 0.02), job.bead, room)


@pytest.fixture(scope="module")
def whole() -> Obstacle:
    return of_beads(laid())


def test_the_tree_holds_every_strand_once(whole: Obstacle) -> None:
    found, solid = laid(), whole.solid
    assert sorted(whole.order) == list(range(len(found)))
    pieces = np.concatenate([found.centre, found.along, found.across, found.half], axis=1)
    np.testing.assert_array_equal(solid.pieces, pieces[whole.order])
    np.testing.assert_array_equal(solid.births, found.sample[whole.order])
    assert whole.whole == found.sample.max()


def test_a_box_holds_all_below_it(whole: Obstacle) -> None:
    solid, leaves = whole.solid, len(whole.solid.ranges) - 1
    first = len(solid.boxes) - leaves
    corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)], dtype=float)
    for leaf in range(leaves):
        own = slice(solid.ranges[leaf], solid.ranges[leaf + 1])
        for row, birth in zip(solid.pieces[own], solid.births[own], strict=True):
            sides = np.stack([row[3:6], row[6:9], np.cross(row[3:6], row[6:9])])
            points = row[:3] + (corners * row[9:12]) @ sides
            node = first + leaf
            while True:
                assert (np.abs(points - solid.boxes[node, :3]) <= solid.boxes[node, 3:] + 1e-12).all()
                assert solid.since[node] <= birth
                if node == 0:
                    break
                node = (node - 1) // 2


def test_in_files_and_in_blocks_it_is_the_same(
    whole: Obstacle, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(memory_mapped, "BLOCK", 7)
    monkeypatch.setattr(memory_mapped, "SMALL", 1)
    room = Room(tmp_path)
    again = of_beads(laid(room), room)
    for one, other in zip(whole.solid, again.solid, strict=True):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(whole.order, again.order)
    assert again.whole == whole.whole


def test_nothing_has_no_piece() -> None:
    assert len(nothing().order) == len(nothing().solid.pieces) == 0
