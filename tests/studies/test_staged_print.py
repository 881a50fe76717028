"""Prints in stages on a simulated machine: whole, killed in the middle of the recalibration, doubtful, and by files."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
from cablewright.apps.cli.main import run
from cablewright.foundation.errors import InputError
from cablewright.studies.stages import recalibration
from cablewright.studies.stages.staged_print import StagedPrint, print_stages
from cases import some

pytestmark = pytest.mark.usefixtures("unpictured")

ROOT = Path(__file__).resolve().parents[2]
ROBOT = str(ROOT / "examples" / "rails.toml")
OPTIONS = cw.PrintOptions(plant="quasi-static", period=1.0, seed=4)


@pytest.fixture(scope="module")
def job(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two strands below 1.5 m and two from there on, where the exit points are raised by 1.5 m."""
    folder = tmp_path_factory.mktemp("job")
    rows = ["G21", "G90", "M83"]
    for layer, height in enumerate((1460, 1480, 1500, 1520)):
        far = 200.0 * (-1) ** layer
        rows += [f";LAYER:{layer}", f"G0 X{-far} Y0 Z{height} F12000", f"G1 X{far} E50 F6000"]
    (folder / "wall.gcode").write_text("\n".join(rows) + "\n")
    parts = ('[bead]\nwidth = "60 mm"\nheight = "20 mm"\n', "[motion]\nprint_speed = 0.1\ntravel_speed = 0.2\n")
    head = 'schema = 1\nname = "wall"\ngcode = "wall.gcode"\nmax_error = 0.01\n'
    (folder / "wall.toml").write_text(head + "".join(parts) + "acceleration = 0.2\n[[stages]]\nz = 1.5\nraised = 1.5\n")
    return folder / "wall.toml"


@pytest.fixture(scope="module")
def whole(job: Path, tmp_path_factory: pytest.TempPathFactory) -> StagedPrint:
    return print_stages(ROBOT, job, tmp_path_factory.mktemp("whole") / "run", options=OPTIONS)


def test_a_print_over_two_stages(whole: StagedPrint) -> None:
    """Both stages are printed by their exit points, the upper upon the material of the lower."""
    assert whole.status == "finished"
    below, above = whole.stages
    np.testing.assert_allclose(above.stage.exit_points[:, 2], 4.0, atol=0.02)
    assert (above.stage.exit_points[:, 2] != 4.0).all()  # as calibrated
    assert above.record is not None
    assert above.record.verdict == "good"
    grounds = [each.printed.run.machine.rig.ground for each in (below, above)]
    assert grounds[1].mass == pytest.approx(2.0 * grounds[0].mass, rel=0.2)
    assert grounds[1].heights.max() > grounds[0].heights.max()
    for each in whole.stages:
        assert each.printed.record.best.space.max < 0.01
    (seam,) = whole.seams
    assert seam.by == "uncertainties and a good calibration"
    assert 0.0 < seam.value < seam.allowed


def test_the_calibration_is_nearer_than_a_person_sets_it(whole: StagedPrint) -> None:
    """Heights of the exit points are nearer to the true ones, which are set to 5 mm, than those of the plan."""
    above = whole.stages[1]
    true = np.array([line.exit_point for line in above.printed.run.machine.robot.lines])[:, 2]
    assert np.abs(above.stage.exit_points[:, 2] - true).max() < np.abs(4.0 - true).max()


@pytest.mark.parametrize("killed", some(["record_text", "measured", "fitted"]))
def test_a_kill_in_the_recalibration(
    whole: StagedPrint, job: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, killed: str
) -> None:
    """Killed before the data, the calibration or the record, the print goes on as if it had not been."""

    def kill(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    folder = tmp_path / "run"
    with monkeypatch.context() as patch:
        patch.setattr(recalibration, killed, kill)
        with pytest.raises(KeyboardInterrupt):
            print_stages(ROBOT, job, folder, options=OPTIONS)
    assert not (folder / "stage-2").exists()
    assert not (folder / "stage-2-calibration" / "calibrated.calibration.toml").exists()
    resumed = print_stages(ROBOT, job, folder, options=OPTIONS, resume=True)
    assert resumed.status == "finished"
    for name in ("measured.csv", "calibrated.toml"):
        texts = [(each / "stage-2-calibration" / name).read_text() for each in (folder, whole.folder)]
        assert texts[0] == texts[1], name
    errors = [of.stages[1].printed.record.best.space.max for of in (resumed, whole)]
    assert errors[0] == errors[1]
    again = print_stages(ROBOT, job, folder, options=OPTIONS, resume=True)  # a finished print
    assert [each.printed.run.steps for each in again.stages] == [0, 0]


@pytest.mark.parametrize("file", ["calibrated.toml", "calibrated.calibration.toml"])
def test_another_calibration_is_noticed(whole: StagedPrint, job: Path, file: str) -> None:
    """A stage that has begun is that of its calibrated robot and its record."""
    path = whole.folder / "stage-2-calibration" / file
    text = path.read_text()
    path.write_text(text + "# measured again\n")
    with pytest.raises(InputError, match="stage-2 holds a print of another"):
        print_stages(ROBOT, job, whole.folder, options=OPTIONS, resume=True)
    path.write_text(text)


def test_another_record_of_the_first_stage_is_noticed(whole: StagedPrint, job: Path, tmp_path: Path) -> None:
    """It is the record beside the robot's file, also where there was none."""
    robot = tmp_path / "rails.toml"
    robot.write_text(Path(ROBOT).read_text())
    record = (whole.folder / "stage-2-calibration" / "calibrated.calibration.toml").read_text()
    (tmp_path / "rails.calibration.toml").write_text(record)
    with pytest.raises(InputError, match="stage-1 holds a print of another"):
        print_stages(robot, job, whole.folder, options=OPTIONS, resume=True)


def test_a_doubtful_recalibration_stops(
    job: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A person may accept it, by an option of that name."""
    monkeypatch.setattr(recalibration, "NEED", 1e-5)
    given = ["print", ROBOT, str(job), "--plant", "quasi-static", "--out", str(tmp_path / "run"), "--json"]
    assert run(given) == 1
    printed = capsys.readouterr()
    assert json.loads(printed.out)["status"] == "recalibrate"
    assert "stage 2: the calibration is doubtful; --accept-doubtful goes on as it is" in printed.err
    assert not (tmp_path / "run" / "stage-2").exists()
    assert run([*given, "--resume", "--accept-doubtful"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [each["calibration"] for each in found["stages"]] == [None, "doubtful"]
    assert (tmp_path / "run" / "stage-2" / "report.html").is_file()


def test_a_seam_that_is_unknown_stops(whole: StagedPrint, job: Path, tmp_path: Path) -> None:
    """The record beside the robot's file is that of another robot."""
    robot = tmp_path / "rails.toml"
    robot.write_text(Path(ROBOT).read_text())
    record = (whole.folder / "stage-2-calibration" / "calibrated.calibration.toml").read_text()
    (tmp_path / "rails.calibration.toml").write_text(record.replace('robot = "rails"', 'robot = "other"'))
    found = print_stages(robot, job, tmp_path / "run", options=OPTIONS)
    assert found.status == "recalibrate"
    assert found.seams == ()
    assert "the seam is unknown: stage 1: the calibration is of 'other'" in found.reason


@pytest.mark.slow  # `test_a_kill_in_the_recalibration` goes on with data too
def test_a_person_recalibrates(
    whole: StagedPrint, job: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The print stops and says what to do; with the data that it asks for, the command that it names lets it go on."""
    folder = tmp_path / "run"
    given = ["print", ROBOT, str(job), "--plant", "quasi-static", "--seed", "4", "--out", str(folder), "--json"]
    given += ["--recalibration", "file"]
    assert run(given) == 1
    reason = json.loads(capsys.readouterr().out)["reason"]
    assert "set the exit points to the heights south-west 4 m, south-east 4 m" in reason
    measured = (whole.folder / "stage-2-calibration" / "measured.csv").read_text()
    (folder / "stage-2-calibration" / "measured.csv").write_text(measured)
    (calibrate,) = re.findall(r"then `cablewright (.*?)`", reason)
    assert run([*shlex.split(calibrate), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["verdict"] == "good"
    assert run([*given, "--resume"]) == 0
    assert json.loads(capsys.readouterr().out)["status"] == "finished"


def test_what_a_print_in_stages_does_not_take(job: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "other.txt").touch()
    for more, words in (
        (["--restart", "--out", str(tmp_path / "run")], "--restart: a job with stages begins again in another folder"),
        (["--layers", "1", "--out", str(tmp_path / "run")], "--layers: is for jobs without stages"),
        (["--out", str(tmp_path)], "holds something already; --resume, or another folder"),
    ):
        assert run(["print", ROBOT, str(job), *more]) == 2
        assert words in capsys.readouterr().err
    assert run(["print", ROBOT, str(job), "--resume", "--out", str(tmp_path / "none")]) == 2
    assert f"--resume: {tmp_path / 'none'} holds no print" in capsys.readouterr().err
    assert not (tmp_path / "none").exists()
    with pytest.raises(InputError, match="unknown recalibration 'other'"):
        print_stages(ROBOT, job, tmp_path / "run", recalibration="other")  # type: ignore[arg-type]
