"""Run folders: whole or not there, never over somebody else's files, the same bytes from the same input."""

from __future__ import annotations

import errno
import hashlib
import json
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pyarrow.csv
import pyarrow.parquet
import pytest

from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.foundation.file_output import write_whole
from cablewright.printing.job import load_job
from cablewright.robot import library_text, load
from cablewright.running.run_folders import folder_name, run_folder
from cablewright.solvers.inverse import inverse
from cablewright.studies.checks.check import check
from cablewright.studies.checks.result import Check
from cablewright.studies.checks.tables import write_check


@pytest.fixture
def earlier(tmp_path: Path, found: Check, job_file: Path) -> Path:
    """The folder of an earlier run."""
    folder = tmp_path / "runs" / "run"
    with run_folder(folder) as part:
        write_check(found, part, "house-printer", job_file)
    (folder / "earlier").write_text("yes")
    return folder


def test_a_run_appears_at_its_end(tmp_path: Path) -> None:
    folder = tmp_path / "runs" / "a"
    with run_folder(folder) as part:
        (part / "file").write_text("text")
        assert not folder.exists()
        assert part.parent.parent == folder.parent  # so that a rename will do
    assert (folder / "file").read_text() == "text"
    assert list(folder.parent.iterdir()) == [folder]


@pytest.mark.parametrize("error", [ValueError, OSError, KeyboardInterrupt, SystemExit])
def test_a_run_that_breaks_leaves_nothing(tmp_path: Path, error: type[BaseException]) -> None:
    def broken_run() -> None:
        with run_folder(tmp_path / "a") as part:
            (part / "file").write_text("half")
            raise error

    with pytest.raises(EnvironmentFault if error is OSError else error):
        broken_run()
    assert not list(tmp_path.iterdir())


def test_a_file_that_cannot_be_written_is_named_where_it_was_to_be(tmp_path: Path) -> None:
    with pytest.raises(EnvironmentFault) as caught, run_folder(tmp_path / "a") as part:
        write_whole(part / "none" / "file", b"text")
    assert str(caught.value) == f"{tmp_path / 'a/none/file'}: cannot be written: No such file or directory"
    assert not list(tmp_path.iterdir())


def test_a_second_run_replaces_the_first(earlier: Path) -> None:
    with run_folder(earlier) as part:
        (part / "later").write_text("yes")
        assert (earlier / "earlier").exists()
    assert [path.name for path in earlier.iterdir()] == ["later"]
    assert list(earlier.parent.iterdir()) == [earlier]


def test_a_second_run_that_breaks_leaves_the_first(earlier: Path) -> None:
    with pytest.raises(ValueError, match="broken"), run_folder(earlier):
        raise ValueError("broken")
    assert (earlier / "earlier").exists()
    assert list(earlier.parent.iterdir()) == [earlier]


def test_a_second_run_that_cannot_take_its_place_leaves_the_first(earlier: Path, monkeypatch) -> None:
    rename = Path.rename

    def refuse(self: Path, target: Path) -> Path:
        if self.name == "new":
            raise OSError(errno.ENOSPC, "No space left on device")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", refuse)
    with pytest.raises((OSError, EnvironmentFault)), run_folder(earlier):
        pass
    assert (earlier / "earlier").exists()


def test_an_empty_folder_is_taken(tmp_path: Path) -> None:
    with run_folder(tmp_path / "empty") as part:
        (part / "file").write_text("text")
    (tmp_path / "new").mkdir()
    with run_folder(tmp_path / "new") as part:
        (part / "file").write_text("text")
    assert (tmp_path / "new" / "file").exists()


@pytest.mark.parametrize("name", ["thesis.txt", "manifest.toml", ".hidden"])
def test_a_foreign_folder_is_rejected(tmp_path: Path, name: str) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / name).write_text("years of work")
    with pytest.raises(InputError, match="holds no earlier run"), run_folder(tmp_path / "a"):
        pytest.fail("the block must not be entered")
    assert (tmp_path / "a" / name).read_text() == "years of work"


@pytest.mark.parametrize("manifest", ['{"name": "my web app", "icons": []}', "", "[1, 2]", "\xff"])
def test_a_manifest_of_something_else_makes_no_run(tmp_path: Path, manifest: str) -> None:
    """`manifest.json` is a common name: web applications and browser extensions have one."""
    (tmp_path / "manifest.json").write_text(manifest, encoding="latin-1")
    (tmp_path / "thesis.txt").write_text("years of work")
    with pytest.raises(InputError, match="holds no earlier run"), run_folder(tmp_path):
        pytest.fail("the block must not be entered")
    assert (tmp_path / "thesis.txt").read_text() == "years of work"


def test_a_file_in_its_place_is_rejected(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("a file")
    with pytest.raises(InputError, match="--out"), run_folder(tmp_path / "a"):
        pytest.fail("the block must not be entered")


@pytest.mark.parametrize("ending", [".part", ".old"])
def test_neighbours_of_like_name_are_kept(tmp_path: Path, earlier: Path, ending: str) -> None:
    neighbour = earlier.with_name(earlier.name + ending)
    neighbour.mkdir()
    (neighbour / "thesis.txt").write_text("years of work")
    try:
        with run_folder(earlier) as part:
            (part / "file").write_text("text")
    except (InputError, EnvironmentFault):
        pass  # to reject is as good
    assert (neighbour / "thesis.txt").read_text() == "years of work"


@pytest.mark.parametrize(
    "error", [PermissionError(errno.EACCES, "Permission denied"), OSError(errno.ENOSPC, "No space left on device")]
)
def test_a_folder_that_cannot_be_made(tmp_path: Path, monkeypatch, error: OSError) -> None:
    def refuse(*_arguments: object, **_options: object) -> None:
        raise error

    monkeypatch.setattr(Path, "mkdir", refuse)
    with pytest.raises(EnvironmentFault, match=error.strerror) as caught, run_folder(tmp_path / "a"):
        pytest.fail("the block must not be entered")
    assert caught.value.exit_code == 3
    assert not list(tmp_path.iterdir())


def test_a_parent_that_is_a_file(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("text")
    with pytest.raises(EnvironmentFault), run_folder(tmp_path / "file" / "run"):
        pytest.fail("the block must not be entered")


@pytest.mark.parametrize(
    "name", ["../../etc", "/etc/passwd", "a/b\\c", "..", "", ".", "\0", "~root", "*", "Bär ☃", "a\nb"]
)
def test_names_of_strangers_are_one_plain_folder(name: str) -> None:
    made = folder_name("check", name, name)
    assert Path(made).name == made
    assert made.isascii()
    assert made.startswith("check-")
    assert set(made) <= set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-")


def test_long_names_are_cut() -> None:
    assert len(folder_name("check", "x" * 1000, "y" * 1000).encode()) <= 200


def test_lengths_csv(earlier: Path, found: Check) -> None:
    table = pyarrow.csv.read_csv(earlier / "lengths.csv")
    lengths = [f"length {line.name}" for line in found.robot.lines]
    turns = [f"turns {line.name}" for line in found.robot.lines]
    assert table.column_names == ["time", *lengths, *turns, "laid", "layer"]
    assert table.num_rows == len(found.samples)
    time = table["time"].to_numpy()
    assert time[0] == 0.0
    assert (np.diff(time) > 0).all()
    np.testing.assert_allclose(time, found.law.time, atol=1e-6)
    for i, line in enumerate(found.robot.lines):
        np.testing.assert_allclose(table[f"length {line.name}"].to_numpy(), found.lengths[:, i], atol=1e-9)
        assert line.winch.drum_radius is not None
        paid_out = 2 * np.pi * line.winch.drum_radius * table[f"turns {line.name}"].to_numpy()
        np.testing.assert_allclose(paid_out, found.lengths[:, i] - found.lengths[0, i], atol=1e-8)
    laid = table["laid"].to_numpy()
    assert (np.diff(laid) >= 0).all()
    assert laid[-1] == pytest.approx(found.samples.extruded_length, abs=1e-5)
    np.testing.assert_array_equal(table["layer"].to_numpy(), found.samples.layer)


def test_samples_parquet(earlier: Path, found: Check) -> None:
    table = pyarrow.parquet.read_table(earlier / "samples.parquet")
    assert table.num_rows == len(found.samples)
    for name, expected in {
        "time": found.law.time,
        "x": found.samples.positions[:, 0],
        "uncompensated_z": found.statics.uncompensated[:, 2],
        "lengths north-east": found.lengths[:, 2],
        "tensions south-west": found.statics.tensions[:, 0],
        "layer": found.samples.layer,
        "status": found.codes,
    }.items():
        np.testing.assert_array_equal(table[name].to_numpy(), expected)


def test_the_manifest_lists_the_inputs(earlier: Path, job_file: Path) -> None:
    manifest = json.loads((earlier / "manifest.json").read_text())
    assert (manifest["schema"], manifest["command"]) == (1, "check")
    assert manifest["cablewright"] == version("cablewright")
    gcode = job_file.with_name("part.gcode")
    assert manifest["inputs"] == {
        "robot": hashlib.sha256(library_text("house-printer").encode()).hexdigest(),
        "job": hashlib.sha256(job_file.read_bytes()).hexdigest(),
        "gcode": hashlib.sha256(gcode.read_bytes()).hexdigest(),
    }


def test_a_robot_file_has_the_hash_of_its_bytes(tmp_path: Path, found: Check, job_file: Path) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text("# my own\n" + library_text("house-printer"))
    write_check(found, tmp_path, str(mine), job_file)
    manifest = json.loads((tmp_path / "manifest.json").read_text())
    assert manifest["inputs"]["robot"] == hashlib.sha256(mine.read_bytes()).hexdigest()


def test_all_that_is_promised_is_written(earlier: Path) -> None:
    """`write_check` names four files."""
    names = {path.name for path in earlier.iterdir()} - {"earlier"}
    assert names == {"samples.parquet", "lengths.csv", "manifest.json"}


def test_the_same_input_gives_the_same_bytes(earlier: Path, tmp_path: Path, job_file: Path) -> None:
    again = tmp_path / "again"
    again.mkdir()
    write_check(check(load("house-printer"), load_job(job_file)), again, "house-printer", job_file)
    for name in ("lengths.csv", "samples.parquet", "manifest.json"):
        assert (again / name).read_bytes() == (earlier / name).read_bytes()


@pytest.mark.parametrize("name", ["merlet2023", "house-printer"])
def test_lengths_between_samples_are_good_to_20_micrometres(name: str, tmp_path: Path) -> None:
    """Unless the job asks for another step; measured here at thirds of each segment, by the inverse problem again."""
    (tmp_path / "wall.gcode").write_text(";LAYER:0\nG1 X-500 Y-800 Z300 F900\nG1 X500 Y700 E9\nG1 X-500 Y700 E19\n")
    robot = load(name)
    found = check(robot, tmp_path / "wall.gcode", skip=("interference", "expected-error"))
    assert found.interpolation_error is not None
    assert found.interpolation_error < 2e-5
    at, lengths = found.samples.positions, found.lengths
    for share in (1 / 3, 0.5, 2 / 3):
        between = (1 - share) * lengths[:-1] + share * lengths[1:]
        held = inverse(robot, (1 - share) * at[:-1] + share * at[1:])
        off = np.abs(held.lengths - between).max()
        assert off < 2e-5
        assert off <= found.interpolation_error * (1 + 1e-6)
