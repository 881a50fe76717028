"""Parts of a job by height make the whole again, upon the strands below; stages that cannot be are rejected."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.models.job_stages import stages_of
from cablewright.printing.growing_part import deposit
from cablewright.printing.job import Job, load_job
from cablewright.robot import Robot, load

ROOT = Path(__file__).resolve().parents[2]
STRANDS = (200.0, 400.0, 600.0, 800.0)  # mm, heights of the layers


@pytest.fixture(scope="module")
def rails() -> Robot:
    return load(str(ROOT / "examples" / "rails.toml"))


def gcode(heights: tuple[float, ...] = STRANDS) -> str:
    """A wall along x, a strand a layer, back and forth."""
    rows = ["G21", "G90", "M83"]
    for layer, height in enumerate(heights):
        far = 300.0 * (-1) ** layer
        rows += [f";LAYER:{layer}", f"G0 X{-far} Y0 Z{height} F6000", f"G1 X{far} E50 F3000"]
    return "\n".join(rows) + "\n"


def job_of(folder: Path, text: str = "", heights: tuple[float, ...] = STRANDS) -> Job:
    (folder / "part.gcode").write_text(gcode(heights))
    (folder / "part.toml").write_text(f'schema = 1\nname = "part"\ngcode = "part.gcode"\n{text}')
    return load_job(folder / "part.toml")


def test_parts_by_height_are_the_whole(tmp_path: Path) -> None:
    """Moves and beads of successive parts are those of the whole, and no part begins within a layer."""
    job = job_of(tmp_path)
    whole = job.toolpath()
    ends = (-1.0, 0.3, 0.6, 9.0)  # the second is between layers, the third is one
    parts = [job.model_copy(update={"heights": each}) for each in pairwise(ends)]
    paths = [each.toolpath() for each in parts]
    assert [each.layer_count for each in paths] == [1, 1, 2]
    np.testing.assert_array_equal(np.concatenate([each.end for each in paths]), whole.end)
    assert all(before.extruding[-1] for before in paths[:-1])  # the way to a layer belongs to it
    beads = [each.beads(path) for each, path in zip(parts, paths, strict=True)]
    heights = np.concatenate([np.broadcast_to(of.height, len(path.end)) for of, path in zip(beads, paths, strict=True)])
    np.testing.assert_array_equal(heights[whole.extruding], job.beads(whole).height[whole.extruding])


def test_what_was_laid_below_is_there_from_the_beginning(tmp_path: Path) -> None:
    """The pieces of a part and of those below it are those of the whole; the latter exist at the first sample."""
    job = job_of(tmp_path)
    upper = job.model_copy(update={"heights": (0.5, 9.0)})
    laid = []
    for each in (job, upper):
        path = each.toolpath()
        laid.append(deposit(each.samples(path), each.beads(path)))
    np.testing.assert_allclose(laid[1].centre, laid[0].centre, atol=1e-12)
    np.testing.assert_array_equal(laid[1].sample < 0, laid[0].centre[:, 2] < 0.45)


def test_a_stage_moves_exit_points_and_the_top_of_the_box(tmp_path: Path, rails: Robot) -> None:
    """The first layers keep the robot file's exit points; a stage at the first layer replaces them."""
    job = job_of(tmp_path, '[[stages]]\nz = "50 cm"\nraised = "1 m"\n')
    first, second = stages_of(rails, job)
    assert first.robot == rails
    np.testing.assert_allclose(second.exit_points - first.exit_points, [[0.0, 0.0, 1.0]] * 4)
    assert second.robot.scene.frame_max == (1.5, 1.2, 3.5)
    assert [each.job.toolpath().layer_count for each in (first, second)] == [2, 2]
    (only,) = stages_of(rails, job_of(tmp_path, '[[stages]]\nz = "20 cm"\nraised = "1 m"\n'))
    assert only.begin == -np.inf
    assert only.job.toolpath().layer_count == 4


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "[[stages]]\nz = 0.6\nraised = 1.0\n\n[[stages]]\nz = 0.4\nraised = 2.0\n",
            "stages.*heights must rise; 0.4 m",
        ),
        ("[[stages]]\nz = 0.6\n", "stages.*raised.*give the exit points of a stage once"),
        ("heights = [0.0, 1.0]\n[[stages]]\nz = 0.6\nraised = 1.0\n", "heights.*for jobs without stages"),
        ("heights = [1.0, 0.5]\n", "heights.*the second must be over the first"),
    ],
)
def test_stages_that_cannot_be_are_rejected(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        job_of(tmp_path, text)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "[[stages]]\nz = 0.9\nraised = 1.0\n",
            r"stages\[0\].z = 0.9 m: nothing is laid there; the part ends at 0.8 m",
        ),
        ("[[stages]]\nz = 0.5\nexit_points = [[0, 0, 3]]\n", r"stages\[0\].exit_points: 1 are given; 'rails' has 4"),
        ("[[stages]]\nz = 0.5\nraised = -3.0\n", r"stages\[0\].raised: exit points 3 m lower"),
        (
            "[[stages]]\nz = 0.5\nexit_points = [[0.1, 0, 0.59], [1.5, -1.2, 3], [1.5, 1.2, 3], [-1.5, 1.2, 3]]\n",
            "stage 2: the exit point of 'south-west', 0.1, 0, 0.59 m, is within layer 3 of the part",
        ),
    ],
)
def test_stages_that_do_not_fit_the_part_are_rejected(tmp_path: Path, rails: Robot, text: str, words: str) -> None:
    job = job_of(tmp_path, text)
    with pytest.raises(InputError, match=words):
        stages_of(rails, job)


def test_a_part_that_is_not_laid_layer_by_layer_is_not_divided(tmp_path: Path, rails: Robot) -> None:
    """Of two objects, one after the other, the second is below the top of the first."""
    job = job_of(tmp_path, "[[stages]]\nz = 0.3\nraised = 1.0\n", heights=(200.0, 400.0, 200.0, 400.0))
    with pytest.raises(InputError, match=r"lays material at 0\.2 m of the file, after a layer at 0\.3 m"):
        stages_of(rails, job)


def test_other_commands_do_not_take_stages_for_one_robot(tmp_path: Path) -> None:
    job = job_of(tmp_path, "[[stages]]\nz = 0.5\nraised = 1.0\n")
    with pytest.raises(InputError, match="has stages, which check, print and stages take"):
        job.toolpath()
