"""Workspace against lowest frequency: each combination by hand, what is not dominated, sweeps that go on."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cablewright.analyses.workspace.boundary_frequencies import boundary_modes
from cablewright.analyses.workspace.criterion import RetractionLaw
from cablewright.analyses.workspace.workspace import count_nodes, workspace
from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.robot.design_variables import Change, changed, with_box_inertia
from cablewright.studies import trade as module
from cablewright.studies.trade import Trade, TradeSettings, best_of, trade

BEAM = Model(load("jung2020"), Fidelity.of("elastic"))
APART, WIDE, LENGTH = (Change(name) for name in ("exit-distance", "width-top-x+width-bottom-y", "retraction"))
QUICK = TradeSettings(criterion="closed-form", tolerance=0.02, boundary_grid=11, inertia="box")
VARIED = {APART: (0.05, 0.1, 0.2), WIDE: (0.04, 0.12)}


@pytest.fixture(scope="module")
def found() -> Trade:
    return trade(BEAM, VARIED, QUICK)


def test_each_combination_is_that_of_the_robot_made_by_hand(found: Trade) -> None:
    assert [each.values for each in found.combinations] == [(d, w) for d in (0.05, 0.1, 0.2) for w in (0.04, 0.12)]
    for each in found.combinations[1::3]:
        robot = with_box_inertia(changed(BEAM.robot, dict(zip(VARIED, each.values, strict=True))))
        own = workspace(Model(robot, Fidelity.of("rigid")), "closed-form", tolerance=0.02)
        assert (each.volume, each.volume_error, each.fraction) == (own.volume, own.volume_error, own.fraction)
        held = boundary_modes(replace(BEAM, robot=robot), "closed-form", grid=11)
        assert (each.least, each.median, each.greatest) == held.spread
        assert (each.n, each.unheld, each.dominant, each.shares) == (len(held.lowest), 0, held.dominant, held.shares)
        assert held.worst is not None
        assert each.worst_pose == tuple(held.modes.equilibrium.pose[held.worst])
        assert each.exit_distance == pytest.approx(each.values[0])


def test_volumes_fall_and_frequencies_rise_as_the_paper_says(found: Trade) -> None:
    volumes = np.array([each.volume for each in found.combinations]).reshape(3, 2)
    least = np.array([each.least for each in found.combinations]).reshape(3, 2)
    assert (np.diff(volumes, axis=0) < 0.0).all()  # further apart
    assert (np.diff(volumes, axis=1) < 0.0).all()  # wider
    assert (np.diff(least, axis=1) > 0.0).all()


def test_sheaves_nearer_than_the_clearance_collide(found: Trade) -> None:
    np.testing.assert_allclose(found.margins, [-0.05, -0.05, 0.0, 0.0, 0.1, 0.1], atol=1e-12)
    assert found.clear.tolist() == [False, False, True, True, True, True]
    assert not (found.best & ~found.clear).any()
    free = replace(found, settings=replace(QUICK, clearance=0.0))
    assert free.clear.all()
    assert free.best[:2].any()


@pytest.mark.parametrize("mirrored", ["2", "4"])
def test_mirror_images_have_the_same(mirrored: str) -> None:
    asked = TradeSettings("closed-form", count="nodes", grid=15, boundary_grid=11)
    one, other = (
        trade(BEAM, {Change(f"exit_point.z@{line}"): (1.9, 2.2)}, asked).combinations for line in ("1", mirrored)
    )
    for a, b in zip(one, other, strict=True):
        assert (a.volume, a.n) == (b.volume, b.n)
        assert (a.least, a.median, a.greatest) == pytest.approx((b.least, b.median, b.greatest), rel=1e-6)
        assert a.shares == pytest.approx(b.shares)


def test_nodes_and_a_length_that_stays() -> None:
    asked = TradeSettings("exact", count="nodes", grid=9, boundary_grid=9, retraction=1.4, inertia="box")
    (each,) = trade(BEAM, {WIDE: [0.1]}, asked).combinations
    robot = with_box_inertia(WIDE.on(BEAM.robot.retracted(1.4), 0.1))
    own = count_nodes(Model(robot, Fidelity.of("rigid")), "exact", grid=9)
    assert (each.volume, each.volume_error) == (own.volume, own.volume_error)
    assert each.least == pytest.approx(boundary_modes(replace(BEAM, robot=robot), "exact", grid=9).spread[0], rel=1e-9)


def test_with_sag_and_a_law() -> None:
    model = Model(BEAM.robot)
    law = RetractionLaw(-1.0, 2.4, 1.2, 2.0)
    (each,) = trade(
        model, {Change("mass"): [12.0]}, TradeSettings("exact", grid=9, boundary_grid=7, retraction=law)
    ).combinations
    robot = Change("mass").on(BEAM.robot, 12.0)
    assert each.volume == workspace(Model(robot, Fidelity.of("rigid")), "exact", grid=9, retraction=law).volume
    assert each.least == boundary_modes(Model(robot), "exact", grid=7, retraction=law).spread[0]


def test_what_cannot_be_held_anywhere_has_no_frequencies() -> None:
    found = trade(BEAM, {Change("mass"): (10.0, 1000.0)}, replace(QUICK, inertia="given"))
    assert (found.combinations[1].volume, found.combinations[1].least, found.combinations[1].n) == (0.0, None, 0)
    assert found.best.tolist() == [True, False]


@given(
    st.lists(
        st.tuples(st.integers(0, 4), st.one_of(st.integers(-2, 4), st.just(float("nan"))), st.booleans()), max_size=12
    )
)
def test_the_best_are_those_that_no_other_dominates(rows: list[tuple[int, float, bool]]) -> None:
    """Against each pair, one by one."""
    usable = [row for row in rows if row[2] and row[0] > 0 and row[1] == row[1]]
    wanted = [
        row in usable and not any(v >= row[0] and f >= row[1] and (v > row[0] or f > row[1]) for v, f, _ in usable)
        for row in rows
    ]
    volumes, frequencies, allowed = zip(*rows, strict=True) if rows else ((), (), ())
    assert best_of(volumes, frequencies, np.array(allowed, dtype=np.bool_)).tolist() == wanted


class _EndedError(Exception):
    """Represents a person who ends the sweep."""


@pytest.mark.slow  # as `test_a_sweep_continues_with_the_results_in_its_file` in apps/cli/test_trade.py
def test_a_sweep_that_was_ended_goes_on_and_writes_the_same_bytes(
    found: Trade, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, part = tmp_path / "whole.jsonl", tmp_path / "part.jsonl"
    assert trade(BEAM, VARIED, QUICK, file=whole).combinations == found.combinations

    def ending(stage: str, done: int, total: int) -> None:
        assert (stage, total) == ("combinations", 6)
        if done >= 1:  # the first chunk is one combination
            raise _EndedError

    with pytest.raises(_EndedError):
        trade(BEAM, VARIED, QUICK, file=part, progress=ending)
    kept = len(part.read_bytes().splitlines()) - 1
    assert kept == 1
    told: list[tuple[int, int]] = []
    again = trade(BEAM, VARIED, QUICK, file=part, progress=lambda _, done, total: told.append((done, total)))
    assert told[0] == (kept, 6)
    assert again.combinations == found.combinations
    assert part.read_bytes() == whole.read_bytes()
    monkeypatch.setattr(module, "found_for", None)  # a finished one computes nothing
    assert trade(BEAM, VARIED, QUICK, file=part).combinations == found.combinations


def test_another_question_adds_to_the_file(tmp_path: Path) -> None:
    file, asked = tmp_path / "a.jsonl", TradeSettings("closed-form", count="nodes", grid=5, boundary_grid=5)
    one = trade(BEAM, {APART: [0.1]}, asked, file=file)
    for known, (model, change) in enumerate((
        (BEAM, {APART: [0.2]}),
        (replace(BEAM, tension_limits=(20.0, 200.0)), {APART: [0.1]}),
        (replace(BEAM, robot=Change("mass").on(BEAM.robot, 11.0)), {APART: [0.1]}),
    ), 2):  # fmt: skip
        other = trade(model, change, asked, file=file)
        assert other.combinations != one.combinations
        assert len(file.read_bytes().splitlines()) == 1 + known


def test_a_tampered_combination_is_rejected(tmp_path: Path) -> None:
    file, asked = tmp_path / "a.jsonl", TradeSettings("closed-form", count="nodes", grid=5, boundary_grid=5)
    trade(BEAM, {APART: [0.1]}, asked, file=file)
    head, line = file.read_text().splitlines()
    stored = json.loads(line)
    stored["value"]["volume"] = "large"
    file.write_text(f"{head}\n{json.dumps(stored)}\n")
    with pytest.raises(InputError, match="holds no results of a trade study"):
        trade(BEAM, {APART: [0.1]}, asked, file=file)


def test_a_folder_that_cannot_be_written_is_said(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    asked = TradeSettings("closed-form", count="nodes", grid=5, boundary_grid=5)
    with pytest.raises((EnvironmentFault, NotADirectoryError)):
        trade(BEAM, {APART: [0.1]}, asked, file=tmp_path / "file" / "a.json")


@pytest.mark.parametrize(
    ("varied", "asked", "says"),
    [
        ({}, TradeSettings(), "vary: give at least one parameter"),
        ({APART: ()}, TradeSettings(), "vary: give at least one parameter"),
        ({APART: range(101), WIDE: range(100)}, TradeSettings(), "10100 combinations: at most 10000"),
        ({APART: [0.1], LENGTH: [1.5, 3.0]}, TradeSettings(), "retraction = 3: .* retracts from 1.2 to 2 m"),
        (
            {WIDE: [0.1], Change("width-bottom-y"): [0.1]},
            TradeSettings(),
            "width-bottom-y: .* more than once",
        ),
        ({LENGTH: [1.5]}, TradeSettings(retraction=1.4), "cannot vary while"),
        ({Change("width-x+width-y"): [0.0]}, TradeSettings(inertia="box"), "on one line"),
    ],
)
def test_bad_sweeps_are_rejected_before_any_work(
    varied: dict[Change, list[float]], asked: TradeSettings, says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "found_for", None)
    with pytest.raises(InputError, match=says):
        trade(BEAM, varied, asked)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"count": "cells"}, "unknown count"),
        ({"inertia": "cylinder"}, "unknown inertia"),
        ({"count": "nodes", "tolerance": 0.1}, "cannot be combined with count nodes"),
        ({"clearance": -1.0}, "must be at least 0 m"),
        ({"clearance": float("nan")}, "must be at least 0 m"),
        ({"inertia": "box", "retraction": RetractionLaw(0.0, 1.5)}, "cannot be combined with a retraction law"),
    ],
)
def test_bad_questions_are_rejected(given: dict[str, object], says: str) -> None:
    with pytest.raises(InputError, match=says):
        TradeSettings(**given)
