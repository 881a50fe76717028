"""Writing files: whole or not at all, with the usual rights, and never through a link that somebody planted."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

import pytest

from cablewright.foundation import file_output
from cablewright.foundation.errors import EnvironmentFault
from cablewright.foundation.file_output import open_no_link, whole_file, write_whole


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture
def precious(tmp_path: Path) -> Path:
    """Somebody's file, outside of the folder that is written to."""
    file = tmp_path / "elsewhere" / "thesis.txt"
    file.parent.mkdir()
    file.write_text("years of work")
    return file


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    made = tmp_path / "folder"
    made.mkdir()
    return made


def test_a_file_takes_its_place_at_the_end(folder: Path) -> None:
    write_whole(folder / "a", b"old")
    with whole_file(folder / "a") as file:
        file.write(b"new")
        file.flush()
        assert (folder / "a").read_bytes() == b"old"
    assert (folder / "a").read_bytes() == b"new"
    assert names(folder) == ["a"]


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, OSError(errno.ENOSPC, "No space left on device")])
def test_a_file_that_breaks_leaves_what_was(folder: Path, error: type[BaseException] | OSError) -> None:
    write_whole(folder / "a", b"old")

    def broken() -> None:
        with whole_file(folder / "a") as file:
            file.write(b"half")
            raise error

    with pytest.raises(EnvironmentFault if isinstance(error, OSError) else error) as caught:
        broken()
    if isinstance(error, OSError):
        assert str(caught.value) == f"{folder / 'a'}: cannot be written: No space left on device"
    assert (folder / "a").read_bytes() == b"old"
    assert names(folder) == ["a"]


@pytest.mark.parametrize("place", ["none/a", ".", "/"])
def test_a_place_that_cannot_be_written(folder: Path, monkeypatch: pytest.MonkeyPatch, place: str) -> None:
    monkeypatch.chdir(folder)
    with pytest.raises(EnvironmentFault, match=f"^{place}: cannot be written: "):
        write_whole(Path(place), b"text")
    assert names(folder) == []


def test_missing_folders_are_made_where_that_is_requested(folder: Path) -> None:
    write_whole(folder / "b" / "c" / "a", b"text", parents=True)
    assert (folder / "b" / "c" / "a").read_bytes() == b"text"


@pytest.mark.skipif(os.name != "posix", reason="rights are POSIX's")
def test_a_file_has_the_rights_of_any_other(folder: Path) -> None:
    (folder / "any").write_bytes(b"")
    write_whole(folder / "a", b"text")
    assert stat.S_IMODE((folder / "a").stat().st_mode) == stat.S_IMODE((folder / "any").stat().st_mode)


def test_names_in_between_cannot_be_guessed(folder: Path) -> None:
    seen = set()
    for _ in range(5):
        with whole_file(folder / "a"):
            seen.update(set(names(folder)) - {"a"})
    assert len(seen) == 5


def test_a_link_is_not_followed_even_where_the_name_was_guessed(
    folder: Path, precious: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(file_output.secrets, "token_hex", lambda _size: "guessed")
    (folder / ".guessed.part").symlink_to(precious)
    with pytest.raises(EnvironmentFault, match="a: cannot be written: File exists"):
        write_whole(folder / "a", b"text")
    assert precious.read_text() == "years of work"


def test_a_link_in_the_place_itself_is_replaced(folder: Path, precious: Path) -> None:
    (folder / "a").symlink_to(precious)
    write_whole(folder / "a", b"text")
    assert not (folder / "a").is_symlink()
    assert precious.read_text() == "years of work"


@pytest.mark.skipif(not hasattr(os, "O_NOFOLLOW"), reason="this system cannot detect links")
@pytest.mark.parametrize("dangling", [False, True])
def test_a_growing_file_is_not_opened_through_a_link(folder: Path, precious: Path, dangling: bool) -> None:
    target = precious.with_name("none") if dangling else precious
    (folder / "log").symlink_to(target)
    with pytest.raises(EnvironmentFault, match="log: cannot be written: "):
        open_no_link(folder / "log")
    assert names(precious.parent) == ["thesis.txt"]
    assert precious.read_text() == "years of work"


def test_a_growing_file_begins_again(folder: Path) -> None:
    (folder / "log").write_bytes(b"old, and longer")
    with open_no_link(folder / "log") as file:
        file.write(b"new")
    assert (folder / "log").read_bytes() == b"new"
