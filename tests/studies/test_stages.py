"""Jobs with stages: checks by stage, seams between stages, and the fewest stages, against what is counted by hand."""

from __future__ import annotations

import json
from collections.abc import Sequence
from itertools import pairwise, product
from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
from cablewright.apps.cli.main import run
from cablewright.calibration.drift.record import CalibrationRecord, record_text
from cablewright.foundation.errors import InputError
from cablewright.models.job_stages import JobStage, raised, stages_of, with_exit_points
from cablewright.printing.job import Job, load_job
from cablewright.printing.schedule import Stage
from cablewright.robot import Robot, Uncertainty, load
from cablewright.studies.stages.seam import Seam, seam_of
from cablewright.studies.stages.search import Stages, find_stages
from cablewright.studies.stages.staged_check import check_stages

ROOT = Path(__file__).resolve().parents[2]
HEIGHTS = (400, 1200, 2000, 2800, 3600)  # mm: five layers of a wall, far apart
QUICK = ("interference", "expected-error")


@pytest.fixture(scope="module")
def rails() -> Robot:
    return load(str(ROOT / "examples" / "rails.toml"))


@pytest.fixture(scope="module")
def wall(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of a job: a strand of 0.6 m at each height."""
    folder = tmp_path_factory.mktemp("wall")
    rows = ["G21", "G90", "M83"]
    for layer, height in enumerate(HEIGHTS):
        far = 300.0 * (-1) ** layer
        rows += [f";LAYER:{layer}", f"G0 X{-far} Y0 Z{height} F12000", f"G1 X{far} E50 F6000"]
    (folder / "wall.gcode").write_text("\n".join(rows) + "\n")
    motion = "[motion]\nprint_speed = 0.1\ntravel_speed = 0.2\nacceleration = 0.2\n"
    bead = '[bead]\nwidth = "60 mm"\nheight = "20 mm"\n'
    (folder / "wall.toml").write_text(
        f'schema = 1\nname = "wall"\ngcode = "wall.gcode"\nmax_error = 0.01\n{bead}{motion}'
    )
    return folder / "wall.toml"


def staged(job: Job, *stages: tuple[float, float]) -> Job:
    return job.model_copy(update={"stages": tuple(Stage(z=z, raised=up) for z, up in stages)})


def test_a_stage_that_moves_nothing_changes_nothing(rails: Robot, wall: Path) -> None:
    """Tensions of each layer, and distances from the strands below, are those of the part in one stage."""
    high = raised(rails, 2.0)
    job = load_job(wall)
    job = job.model_copy(update={"motion": job.motion.model_copy(update={"shaping": "none"})})  # else by the way before
    once = cw.check(high, job, skip=("expected-error",))
    twice = check_stages(high, staged(job, (1.9, 0.0)), skip=("expected-error",))
    assert [each.check.toolpath.layer_count for each in twice.stages] == [2, 3]
    upper = twice.stages[1].check
    assert upper.nearest is not None
    assert once.distances is not None
    for whole, part in ((once.samples, upper.samples),):
        laid = whole.extruding & (whole.positions[:, 2] > 1.99)
        own = part.extruding
        np.testing.assert_allclose(whole.positions[laid], part.positions[own], atol=1e-9)
        np.testing.assert_allclose(once.lengths[laid], upper.lengths[own], atol=1e-7)
        assert upper.distances is not None
        np.testing.assert_allclose(once.distances.smallest[laid], upper.distances.smallest[own], atol=1e-6)
    assert twice.feasible is once.feasible


def seam_with(robot: Robot, job: Job, text: str, rise: float = 0.0) -> Seam:
    """The seam at 1.2 m, the exit points that much higher above, with the uncertainty of a TOML text."""
    below, above = stages_of(robot, staged(job, (1.9, rise)))
    return seam_of(below, above, Uncertainty.model_validate({"parameters": [json.loads(text)]}), allowed=0.01)


def test_what_both_stages_have_in_common_leaves_no_seam(rails: Robot, wall: Path) -> None:
    """An uncertain mass moves both prints by the same where the exit points stay, and apart where they are moved."""
    high, job, mass = raised(rails, 1.0), load_job(wall), '{"name": "mass", "factor": [0.9, 1.1]}'
    assert seam_with(high, job, mass).value < 1e-12
    assert seam_with(high, job, mass, 1.0).value > 1e-6


def test_the_seam_is_that_of_machines_built_one_by_one(rails: Robot, wall: Path) -> None:
    """Machines with exit points displaced again in each stage are solved one by one for the lengths of an exact one."""
    job, rng, sigma = load_job(wall), np.random.default_rng(5), 0.001
    places = [[x, 0.0, 1.2] for x in (-0.3, 0.0, 0.3)]
    ends = []
    for stage in stages_of(raised(rails, 1.0), staged(job, (1.9, 0.7))):
        exact = cw.inverse(stage.robot, places, cable="catenary")
        points = []
        for _ in range(300):
            moved = stage.exit_points + rng.normal(0.0, sigma, (4, 3))
            built = with_exit_points(stage.robot, [(x, y, z) for x, y, z in moved.tolist()])
            points.append(cw.forward(built, exact.lengths, guess=places, cable="catenary").pose)
        ends.append(np.array(points))
    apart = np.linalg.norm(ends[0] - ends[1], axis=2).max(axis=1)
    found = seam_with(raised(rails, 1.0), job, json.dumps({"name": "exit_point", "deviation": sigma}), 0.7)
    assert found.height == pytest.approx(1.2)
    assert found.value == pytest.approx(np.quantile(apart, 0.95), rel=0.1)


def motions_of(robot: Robot) -> np.ndarray:
    """Orthonormal motions (12, 6) of all exit points as a rigid body."""
    arms = np.array([line.exit_point for line in robot.lines])
    turns = [np.cross(axis, arms - arms.mean(axis=0)).ravel() for axis in np.eye(3)]
    return np.linalg.qr(np.array([*(np.tile(axis, 4) for axis in np.eye(3)), *turns]).T)[0]


def record_of(
    robot: Robot, sigma: float, inner: Sequence[int] = (), name: str = "rails", held: Sequence[int] = ()
) -> CalibrationRecord:
    """A record whose exit points have *sigma*, m, each coordinate on its own.

    *inner*: numbers of the rigid motions that are held; *held*: numbers of the coordinates.
    """
    values = [
        {"name": f"exit_point.{axis}", "line": line.name, "value": line.exit_point[k], "sigma": sigma}
        for line in robot.lines
        for k, axis in enumerate("xyz")
    ]
    motions, free = motions_of(robot)[:, list(inner)], np.diag([float(k not in held) for k in range(12)])
    spread = free - motions @ motions.T
    rows = [row[: at + 1].tolist() for at, row in enumerate(sigma**2 * spread)]
    head = {"schema": 1, "robot": name, "date": "2026-01-01T00:00:00Z", "data": "d.csv", "sha256": 64 * "0"}
    more = {"verdict": "good", "cable": "rigid", "poses": 20, "unknowns": ["exit_point"], "sigma": {"encoder": 1e-4}}
    return CalibrationRecord.model_validate(head | more | {"values": values, "covariance": rows})


def test_records_of_both_stages_are_their_uncertainties(rails: Robot, wall: Path) -> None:
    """Independent coordinates of a record are those of an uncertainty with the same deviation."""
    high, job = raised(rails, 1.0), load_job(wall)
    below, above = stages_of(high, staged(job, (1.9, 0.7)))
    entry = {"name": "exit_point", "deviation": 0.001}
    own = Uncertainty.model_validate({"parameters": [entry]})
    wanted = seam_of(below, above, own, allowed=0.01)
    records = tuple(record_of(each.robot, 0.001) for each in (below, above))
    found = seam_of(below, above, own, records, allowed=0.01)
    assert found.value == pytest.approx(wanted.value, rel=0.04)
    assert (wanted.by, found.by) == ("uncertainties", "a good calibration")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"inner": [0]}, "stage 1: the calibration holds the translation along x of the exit points"),
        ({"inner": [5]}, "stage 1: the calibration holds the yaw of the exit points .datum.: .*priors, and no datum"),
        ({"inner": [3]}, "stage 1: the calibration holds the tilt about x of the exit points"),
        ({"held": [0, 1, 2, 3, 4, 5]}, "stage 1: the calibration holds the exit point of 'south-west' along x"),
        ({"held": [10]}, "stage 1: the calibration holds the exit point of 'north-west' along y"),
        ({"name": "other"}, "stage 1: the calibration is of 'other', and the robot is 'rails'"),
    ],
)
def test_records_that_say_nothing_of_a_seam_are_rejected(
    rails: Robot, wall: Path, change: dict[str, object], words: str
) -> None:
    both: tuple[JobStage, ...] = stages_of(raised(rails, 1.0), staged(load_job(wall), (1.9, 0.7)))
    records = tuple(record_of(each.robot, 0.001, **change) for each in both)  # type: ignore[arg-type]
    uncertain = Uncertainty.model_validate({"parameters": [{"name": "mass", "deviation": 0.1}]})
    with pytest.raises(InputError, match=words):
        seam_of(both[0], both[1], uncertain, records, allowed=0.01)


def test_records_are_those_of_their_stages(rails: Robot, wall: Path) -> None:
    """In another order they are 0.7 m from the exit points; one record is not of two stages, be they equal."""
    job = staged(load_job(wall), (1.9, 0.7))
    uncertain = Uncertainty.model_validate({"parameters": [{"name": "mass", "deviation": 0.1}]})
    below, above = stages_of(raised(rails, 1.0), job)
    records = record_of(above.robot, 0.001), record_of(below.robot, 0.001)
    with pytest.raises(InputError, match=r"stage 1: the calibration has the exit point of 'south-west' 0[.]7 m"):
        seam_of(below, above, uncertain, records, allowed=0.01)
    with pytest.raises(InputError, match="records: stages 1 and 2 have the same record: calibrate each stage again"):
        check_stages(rails, job, (records[0], records[0]), skip=QUICK)


def test_the_search_is_for_whole_parts(rails: Robot, wall: Path) -> None:
    job = load_job(wall)
    for part, key in ((job.model_copy(update={"heights": (1.0, 2.0)}), "heights"), (staged(job, (1.9, 1.0)), "stages")):
        with pytest.raises(InputError, match=f"job wall: {key}: the search is for a whole part: remove {key}"):
            find_stages(rails, part, (2.5, 3.6), layers=1)


@pytest.fixture(scope="module")
def found(rails: Robot, wall: Path) -> Stages:
    """Stages of the wall at three heights, each of which is too low or too high for some layer."""
    job = load_job(wall).model_copy(update={"max_error": 0.0054, "max_seam": 0.01})
    return find_stages(rails, job, (2.5, 3.6, 4.7), layers=3)


def test_the_fewest_stages_are_those_of_a_search_by_hand(found: Stages) -> None:
    """Of all ways to give each layer one of the heights none changes it less often."""
    good = {(each.layer, each.exit_height): each.feasible for each in found.layer_checks}
    moves = [
        sum(a != b for a, b in pairwise(heights))
        for heights in product(found.exit_heights, repeat=len(found.layers))
        if all(good[each] for each in zip(found.layers, heights, strict=True))
    ]
    assert found.status == "ok"
    assert found.to_dict()["moves"] == min(moves) == 1
    assert {False, True} == set(good.values())
    assert "no fewer than 2 stages" in found.proof
    assert found.checked is not None
    assert found.checked.feasible


def test_a_layer_that_no_height_prints_is_named(rails: Robot, wall: Path) -> None:
    lost = find_stages(rails, load_job(wall), (2.5, 3.0), layers=2)
    assert lost.status == "no-height"
    assert lost.to_dict()["moves"] is None
    assert lost.refusal.startswith(
        "layer 5 cannot be printed with the exit points at any of the heights; at 2.5 m: frame"
    )


@pytest.mark.slow  # checks and searches above; a job with stages is printed in test_staged_print.py
@pytest.mark.usefixtures("undrawn_here")
def test_the_commands(found: Stages, wall: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`stages` writes a job that `check` takes with records of calibrations, and a picture."""
    robot, out = str(ROOT / "examples" / "rails.toml"), tmp_path / "staged.toml"
    given = ["stages", robot, str(wall), "--exit-heights", "2.5,4.5", "--layers", "2", "--out", str(out), "--json"]
    assert run([*given, "--plot", str(tmp_path / "stages.png")]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert (printed["status"], printed["moves"]) == ("ok", len(load_job(out).stages) - 1)
    assert (tmp_path / "stages.png").stat().st_size > 10_000
    both = stages_of(load(robot), staged(load_job(wall), (1.9, 2.0)))
    files = []
    for each in both:
        files.append(tmp_path / f"{each.number}.calibration.toml")
        files[-1].write_text(record_text(record_of(each.robot, 3e-4)))
    out.write_text(wall.read_text().replace("wall.gcode", str(wall.parent / "wall.gcode"))
                   + '\n[[stages]]\nz = "1.9 m"\nraised = "2 m"\n')  # fmt: skip
    check = ["check", robot, str(out), "--no-interference", "--out", str(tmp_path / "run"), "--json"]
    assert run([*check, "--stage-record", str(files[0]), "--stage-record", str(files[1])]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert [each["layers"] for each in printed["stages"]] == [2, 3]
    assert [each["by"] for each in printed["seams"]] == ["a good calibration"]
    assert (tmp_path / "run" / "stage-2" / "report.html").is_file()
    assert json.loads((tmp_path / "run" / "manifest.json").read_text())["command"] == "check"
    assert run(check) in (0, 1)  # a second run takes the place of the first
    printed = json.loads(capsys.readouterr().out)
    assert [each["by"] for each in printed["seams"]] == ["uncertainties"]
    check[check.index("--out") + 1] = str(tmp_path / "another")
    assert run([*check, "--stage-record", str(files[0])]) == 2
    assert "records: 1 are given; the job has 2 stages" in capsys.readouterr().err
    plain = ["check", robot, str(wall), "--stage-record", str(files[0])]
    assert run(plain) == 2
    assert "--stage-record: is for jobs with stages" in capsys.readouterr().err
