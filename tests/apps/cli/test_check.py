"""`check`: the contract's JSON, a run folder that is whole or not there, and a reason for every no."""

from __future__ import annotations

import errno
from collections.abc import Callable
from pathlib import Path

import pytest

pytestmark = pytest.mark.usefixtures("undrawn")

KEYS = {
    "schema",
    "feasible",
    "verdict",
    "layers",
    "extruded_length",
    "duration",
    "min_tension",
    "max_tension",
    "max_error_uncompensated",
    "max_error_compensated",
    "report",
}


@pytest.fixture(scope="module")
def yes(cli, write_job, tmp_path_factory: pytest.TempPathFactory):
    """The answer to a square in the middle of the house-printer, and its run folder."""
    folder = tmp_path_factory.mktemp("runs") / "square"
    return cli("check", "house-printer", write_job(), "--out", folder, "--json"), folder


def test_a_job_that_can_be_printed(yes) -> None:
    answer, folder = yes
    assert answer.code == 0
    assert "cablewright:" not in answer.err  # nothing but progress, where the machine is slow
    found = answer.json
    assert found.keys() >= KEYS
    assert found["feasible"] is True
    assert found["verdict"].startswith("house-printer can print square. ")
    assert found["layers"] == 3
    assert found["extruded_length"] == pytest.approx(12.0)
    assert found["duration"] > 12.0 / 0.3
    assert 20 <= found["min_tension"] < found["max_tension"] <= 5150
    assert found["max_error_compensated"] < 1e-6 < found["max_error_uncompensated"]
    assert Path(found["report"]) == folder / "report.html"


def test_its_run_folder_holds_what_the_answer_names(yes) -> None:
    answer, folder = yes
    for key in ("report", "lengths"):
        assert Path(answer.json[key]).stat().st_size > 0
    names = {path.name for path in folder.iterdir()}
    assert names >= {"manifest.json", "samples.parquet", "lengths.csv", "report.html"}
    assert [path.name for path in folder.parent.iterdir()] == [folder.name]


def test_findings_name_place_and_margin(yes) -> None:
    for finding in yes[0].json["findings"]:
        assert finding["violations"] == 0
        assert finding["margin"] >= 0
        assert len(finding["place"]["position"]) == 3
        assert finding["place"]["gcode_line"] >= 1


def test_a_job_outside_the_frame_is_a_no_with_a_report(cli, write_job, tmp_path: Path) -> None:
    job = write_job(origin=(7.0, 0.0, 1.0), name="too far out")
    answer = cli("check", "house-printer", job, "--out", tmp_path / "run", "--json")
    found = answer.json
    assert found["feasible"] is False
    assert answer.no == found["verdict"]
    assert "house-printer cannot print too far out: " in answer.no
    assert "G-code line" in answer.no
    frame = next(finding for finding in found["findings"] if finding["limit"] == "frame, x")
    assert frame["margin"] == pytest.approx(-0.5)
    assert frame["allowed"] == [-7.5, 7.5]
    assert (tmp_path / "run" / "report.html").stat().st_size > 0


def test_people_get_the_figures(cli, write_job, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    answer = cli("check", "house-printer", write_job(), "--tension-limits", "20,500")
    assert answer.no.startswith("house-printer cannot print square: highest tension of line ")
    assert "allowed: at most 500 N" in answer.no
    rows = [row.split(maxsplit=1) for row in answer.out.splitlines() if row]
    assert rows[:2] == [["feasible", "no"], ["verdict", answer.no]]
    assert ["layers", "3"] in rows
    assert "limits of the robot" in answer.out
    assert (tmp_path / "runs" / "check-house-printer-job" / "report.html").is_file()


def test_bare_gcode_is_a_job(cli, tmp_path: Path) -> None:
    part = tmp_path / "two moves.gcode"
    part.write_text("G21\nG90\nM83\nG1 Z500 F6000\nG1 X100 E1\nG1 Y100 E1\n")
    found = cli("check", "merlet2023", part, "--out", tmp_path / "run", "--json").json
    assert found["verdict"].startswith("merlet2023 can")
    assert found["extruded_length"] == pytest.approx(0.2, rel=0.05)  # corners are rounded


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--tension-limits", "500,20"), "0 <= lowest < highest"),
        (("--tension-limits", "nan,20"), "0 <= lowest < highest"),
        (("--tension-limits", "20"), "expected MIN,MAX in N"),
    ],
)
def test_limits_that_are_none(cli, write_job, tmp_path: Path, arguments: tuple[str, str], says: str) -> None:
    out = tmp_path / "run"
    assert says in cli("check", "house-printer", write_job(), *arguments, "--out", out).refusal
    assert not list(tmp_path.iterdir())


def test_a_folder_of_somebody_else_is_rejected(cli, write_job, tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("years")
    line = cli("check", "house-printer", write_job(), "--out", tmp_path).refusal
    assert line.startswith(f"--out = {tmp_path}: ")
    assert (tmp_path / "thesis.txt").read_text() == "years"


@pytest.mark.parametrize("out", ["", pytest.param(".", marks=pytest.mark.slow)])
def test_the_present_folder_is_used_or_rejected(cli, write_job, tmp_path: Path, monkeypatch, out: str) -> None:
    monkeypatch.chdir(tmp_path)
    answer = cli("check", "house-printer", write_job(), "--out", out)
    assert answer.code == (0 if (tmp_path / "report.html").is_file() else 2)


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (OSError(errno.ENOSPC, "No space left on device"), 3),
        (PermissionError(errno.EACCES, "Permission denied"), 3),
        (KeyboardInterrupt(), 130),
    ],
)
@pytest.mark.parametrize("place", ["studies.checks.tables.write_check", "apps.report.check.write"])
def test_what_interrupts_the_writing_leaves_nothing(
    cli, write_job, tmp_path: Path, monkeypatch, error: BaseException, code: int, place: str
) -> None:
    monkeypatch.setattr(f"cablewright.{place}", raising(error))
    answer = cli("check", "house-printer", write_job(), "--out", tmp_path / "run", "--json")
    assert (answer.code, answer.out) == (code, "")
    assert not list(tmp_path.iterdir())


def test_a_parent_that_cannot_be_written(cli, write_job, tmp_path: Path, monkeypatch) -> None:
    job = write_job()
    monkeypatch.setattr(Path, "mkdir", raising(PermissionError(errno.EACCES, "Permission denied")))
    answer = cli("check", "house-printer", job, "--out", tmp_path / "run", "--json")
    assert (answer.code, answer.out) == (3, "")
    assert answer.err == f"cablewright: {tmp_path / 'run'}: the run folder cannot be created: Permission denied\n"


def raising(error: BaseException) -> Callable[..., None]:
    def call(*_arguments: object, **_options: object) -> None:
        raise error

    return call
