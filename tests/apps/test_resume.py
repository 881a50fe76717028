"""A print whose folder lost something asks what to do: nothing is laid twice unless that is wanted."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from cablewright.foundation.saved_state import LAYOUT, Snapshot, read_snapshots, write_snapshots
from cablewright.live.prints import run as prints
from cablewright.live.prints.run import CHECKPOINT, LOCK
from cablewright.running.run_folders import MANIFEST
from cablewright.running.signing_key import DIRECTORY, is_signed, signature
from print_logs import RING

pytestmark = pytest.mark.usefixtures("unpictured")


@pytest.fixture(scope="module")
def printed(cli, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A job, and the folder in which it was printed."""
    folder = tmp_path_factory.mktemp("print")
    (folder / "ring.toml").write_text(RING.format(radius=0.3))
    found = again(cli, folder / "ring.toml", folder / "run")
    assert found.json["status"] == "finished"
    return folder / "ring.toml", folder / "run"


@pytest.fixture
def copied(printed: tuple[Path, Path], tmp_path: Path) -> tuple[Path, Path]:
    """The same, in a folder that may be spoilt."""
    shutil.copytree(printed[1], tmp_path / "run")
    return printed[0], tmp_path / "run"


def killed(*_: object) -> None:
    raise KeyboardInterrupt


def again(cli, job: Path, run: Path, *options: str):
    return cli("print", "merlet2023", job, "--plant", "quasi-static", "--out", run, "--json", *options)


def test_a_finished_print_is_not_laid_again(cli, copied: tuple[Path, Path]) -> None:
    before = (copied[1] / CHECKPOINT).read_bytes()
    assert again(cli, *copied, "--resume").json["status"] == "finished"
    assert (copied[1] / CHECKPOINT).read_bytes() == before


def test_a_lost_checkpoint_is_asked_about(cli, copied: tuple[Path, Path]) -> None:
    (copied[1] / CHECKPOINT).unlink()
    says = again(cli, *copied, "--resume").refusal
    assert "the checkpoint is missing, and the log shows that 1.8" in says
    assert "--restart to print all again" in says
    assert not (copied[1] / CHECKPOINT).exists()


def test_a_forged_checkpoint_is_not_believed(cli, copied: tuple[Path, Path], tmp_path: Path, monkeypatch) -> None:
    """Whole, fitting and with the right checksum: it would have the print go on elsewhere."""
    file = copied[1] / CHECKPOINT
    state = read_snapshots(file, is_signed=is_signed)
    values = state["print"].values
    name = next(key for key, value in values.items() if isinstance(value, float) and value > 0.0)
    forged = state | {"print": Snapshot(dict(values) | {name: 0.5 * values[name]}, state["print"].arrays)}
    own = os.environ.get(DIRECTORY)
    for sign in (None, signature):  # without, and by another user
        monkeypatch.setenv(DIRECTORY, str(tmp_path / "stranger"))
        write_snapshots(file, forged, sign=sign)
        monkeypatch.setenv(DIRECTORY, own) if own else monkeypatch.delenv(DIRECTORY)
        before = file.read_bytes()
        assert f"{CHECKPOINT}: not signed by this user" in again(cli, *copied, "--resume").refusal
        assert file.read_bytes() == before
    assert again(cli, *copied, "--restart").json["status"] == "finished"


def test_a_checkpoint_of_another_layout_is_rejected_with_the_next_step(cli, copied: tuple[Path, Path]) -> None:
    """It was written, at the end of such a print, by the version before."""
    file = copied[1] / CHECKPOINT
    old = read_snapshots(Path(__file__).parents[1] / "earlier_files" / "print_checkpoint.bin")
    write_snapshots(file, old, sign=signature)
    before = file.read_bytes()
    says = again(cli, *copied, "--resume").refusal
    assert f"{CHECKPOINT}: is a checkpoint of layout 1, this version of cablewright reads layout {LAYOUT}" in says
    assert f"--resume with the version in {MANIFEST}, or --restart to print all again" in says
    assert file.read_bytes() == before
    assert again(cli, *copied, "--restart").json["status"] == "finished"


def test_a_lost_log_is_asked_about(cli, copied: tuple[Path, Path]) -> None:
    for log in copied[1].glob("log*.mcap"):
        log.unlink()
    assert "the log is missing" in again(cli, *copied, "--resume").refusal


def test_a_print_begins_again_where_that_is_wanted(cli, copied: tuple[Path, Path]) -> None:
    (copied[1] / CHECKPOINT).unlink()
    found = again(cli, *copied, "--restart")
    assert found.json["status"] == "finished"
    assert found.json["distance"] == pytest.approx(0.6 * 3.1416, rel=0.01)
    assert (copied[1] / CHECKPOINT).exists()


def test_a_restart_that_is_killed_immediately_resumes_as_itself(cli, copied: tuple[Path, Path]) -> None:
    """Nothing of the earlier print is left that would be taken for its end."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("cablewright.live.prints.run._run", killed)
        assert again(cli, *copied, "--restart").code == 130
    found = again(cli, *copied, "--resume")
    assert found.json["status"] == "finished"
    assert found.json["distance"] == pytest.approx(0.6 * 3.1416, rel=0.01)


@pytest.mark.parametrize("content", [b"", pytest.param(b"\x89MCAP0\r\n", marks=pytest.mark.slow)])
def test_a_log_that_was_never_flushed_shows_nothing(cli, copied: tuple[Path, Path], content: bytes) -> None:
    (copied[1] / CHECKPOINT).unlink()
    for log in copied[1].glob("log*.mcap"):
        log.unlink()
    (copied[1] / "log-000.mcap").write_bytes(content)
    assert again(cli, *copied, "--resume").json["status"] == "finished"


def test_a_log_that_cannot_be_read_is_no_permission(cli, copied: tuple[Path, Path]) -> None:
    (copied[1] / CHECKPOINT).unlink()
    (copied[1] / "log.mcap").write_bytes(bytes(5000))
    assert "--restart prints all again" in again(cli, *copied, "--resume").refusal


def test_nothing_laid_is_nothing_to_ask_about(cli, copied: tuple[Path, Path]) -> None:
    for kept in copied[1].iterdir():
        if kept.name != MANIFEST:
            kept.unlink()
    assert again(cli, *copied, "--resume").json["status"] == "finished"


def test_a_restart_is_of_the_same_print(cli, copied: tuple[Path, Path], tmp_path: Path) -> None:
    assert "holds a print of another" in again(cli, *copied, "--restart", "--seed", "7").refusal
    assert "--restart: " in again(cli, copied[0], tmp_path / "nothing", "--restart").refusal
    assert "not both" in again(cli, *copied, "--restart", "--resume").refusal


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no FIFOs here")
@pytest.mark.parametrize("name", [MANIFEST, CHECKPOINT])
def test_a_fifo_is_not_waited_for(cli, copied: tuple[Path, Path], name: str) -> None:
    (copied[1] / name).unlink()
    os.mkfifo(copied[1] / name)
    assert again(cli, *copied, "--resume").code == 2


def test_a_print_that_another_program_began_meanwhile_stays_as_it_is(
    cli, printed: tuple[Path, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, begin = tmp_path / "run", prints.begin_print

    def late(*given):
        shutil.copytree(printed[1], folder)
        return begin(*given)

    monkeypatch.setattr(prints, "begin_print", late)
    assert "is not empty" in again(cli, printed[0], folder, "--seed", "7").refusal
    for name in (MANIFEST, CHECKPOINT):
        assert (folder / name).read_bytes() == (printed[1] / name).read_bytes()


def test_a_print_that_was_killed_before_it_began_leaves_an_empty_folder(
    cli, printed: tuple[Path, Path], tmp_path: Path
) -> None:
    (tmp_path / "run").mkdir()
    for left in (LOCK, ".0123456789abcdef.part"):
        (tmp_path / "run" / left).touch()
    assert again(cli, printed[0], tmp_path / "run").json["status"] == "finished"
