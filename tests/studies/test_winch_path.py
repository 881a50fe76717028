"""A job as turns of winches: closeness of points, layers, and what cannot be done."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.machine.drums import drums_of
from cablewright.machine.files import load_machine
from cablewright.models.statics import Model
from cablewright.printing.job import Job, load_job
from cablewright.robot import load
from cablewright.robot.new_robot import Outline
from cablewright.studies.checks.winch_angles import winch_path
from cablewright.studies.new_robot import MACHINE, PART, ROBOT, new_robot

MODEL = Model.full(load("merlet2023"))
DRUMS = drums_of(MODEL.robot)
GCODE = """;LAYER:0
G1 X-500 Y-800 Z300 F9000
G1 X500 Y700 E9
;LAYER:1
G1 Z320
G1 X-500 Y-800 E19
;LAYER:2
G1 Z340
G1 X500 Y700 E29
"""


@pytest.fixture
def job(tmp_path: Path) -> Job:
    (tmp_path / "wall.gcode").write_text(GCODE)
    return load_job(tmp_path / "wall.gcode")


@pytest.mark.parametrize("tolerance", [1e-4, 1e-5, 1e-6])
def test_lengths_between_points_are_as_good_as_asked(job: Job, tolerance: float) -> None:
    found = winch_path(MODEL, job, DRUMS, tolerance=tolerance)
    at, radius = found.samples.positions, DRUMS[0].radius
    first = found.lengths[0]
    for share in (0.25, 0.5):
        held = cw.inverse(MODEL.robot, (1 - share) * at[:-1] + share * at[1:])
        between = first + radius * ((1 - share) * found.turns[:-1] + share * found.turns[1:])
        assert np.abs(held.lengths - between).max() <= tolerance
    assert found.error <= tolerance


def test_points_are_close_only_where_a_length_bends(tmp_path: Path) -> None:
    """Where a line gets its least tension its sag bends the lengths: the own part of a new robot has such places."""
    new_robot(Outline(name="over", layout="over-middle"), tmp_path / "over")
    robot, machine = load(tmp_path / "over" / ROBOT), load_machine(tmp_path / "over" / MACHINE)
    job = load_job(tmp_path / "over" / PART)
    found = winch_path(Model.full(robot), job, drums_of(robot, machine), tolerance=1e-6)
    pieces = np.diff(found.samples.distance)
    assert found.error <= 1e-6
    assert pieces.max() > 10.0 * pieces.min()
    np.testing.assert_allclose(np.linalg.norm(np.diff(found.samples.positions, axis=0), axis=1), pieces, atol=1e-12)


def test_layers(job: Job) -> None:
    whole, part = (winch_path(MODEL, job, DRUMS, layers=layers) for layers in (None, (2, 3)))
    assert set(part.samples.layer) == {2, 3}
    assert part.laid[0] == 0.0
    assert part.laid[-1] == pytest.approx(2 / 3 * whole.laid[-1], rel=0.02)
    np.testing.assert_array_equal(part.turns[0], 0.0)


def test_what_cannot_be_done(job: Job) -> None:
    with pytest.raises(InputError, match="layers 2 to 9: this part has 1 to 3"):
        winch_path(MODEL, job, DRUMS, layers=(2, 9))
    with pytest.raises(AnswerError, match=r"line .* jumps.* between points is .*; 1e-17 m asked.*allow it with --tol"):
        winch_path(MODEL, job.model_copy(update={"scale": 0.02}), DRUMS, tolerance=1e-17)
    with pytest.raises(AnswerError, match=r"nozzle at .*in layer 1"):
        winch_path(MODEL, job.model_copy(update={"origin": (0.0, 0.0, 4.5)}), DRUMS)
