"""State files that a proof rests on are signed: a stranger's, or a changed one, is not believed."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.foundation.saved_state import Snapshot, read_snapshots, write_snapshots
from cablewright.robot import load
from cablewright.running import signing_key
from cablewright.solvers.equilibria import Equilibria, equilibria
from cablewright.studies.equilibria import search_all

LENGTHS = [10.1187, 9.3676, 10.9961, 11.3476]
BOX = [-2.0, 2.0, -4.0, 4.0, 0.3, 3.5]


@pytest.fixture(autouse=True)
def _fresh_key(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(signing_key.DIRECTORY, str(tmp_path / "state"))


@pytest.fixture(scope="module")
def found() -> Equilibria:
    return equilibria(load("merlet2023"), LENGTHS, box=BOX)


def begun(found: Equilibria, file: Path) -> Snapshot:
    """The state of a search that was stopped immediately, in *file*."""
    assert not search_all(found, BOX, file, time_limit=1e-9).finished
    return read_snapshots(file)["search"]


def test_a_signature_is_of_one_content_and_one_key(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    given = signing_key.signature(b"state")
    assert signing_key.is_signed(b"state", given)
    assert not signing_key.is_signed(b"State", given)
    assert not signing_key.is_signed(b"state", b"")
    monkeypatch.setenv(signing_key.DIRECTORY, str(tmp_path / "another"))
    assert not signing_key.is_signed(b"state", given)


def test_the_key_is_the_users_alone(tmp_path: Path) -> None:
    signing_key.signature(b"")
    file = tmp_path / "state" / "signing.key"
    assert file.stat().st_mode & 0o077 == 0
    file.chmod(0o644)
    with pytest.raises(EnvironmentFault, match="no key of this user alone"):
        signing_key.signature(b"")
    file.chmod(0o600)
    file.write_bytes(b"short")
    with pytest.raises(EnvironmentFault, match="has not the 32 bytes"):
        signing_key.signature(b"")


def test_a_folder_of_the_environment_is_taken_as_it_is_meant(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "xdg"))
    monkeypatch.setenv(signing_key.DIRECTORY, "")
    signing_key.signature(b"")
    assert (tmp_path / "xdg" / "cablewright" / "signing.key").exists()
    monkeypatch.setenv("XDG_STATE_HOME", "relative")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.chdir(tmp_path)
    signing_key.signature(b"")
    assert (tmp_path / "home" / ".local" / "state" / "cablewright" / "signing.key").exists()
    assert not (tmp_path / "relative").exists()


def test_a_full_disk_leaves_no_half_a_key(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "link", full)
        with pytest.raises(EnvironmentFault, match="No space left"):
            signing_key.signature(b"")
    assert list((tmp_path / "state").iterdir()) == []
    assert signing_key.is_signed(b"x", signing_key.signature(b"x"))


def test_a_link_is_no_key(tmp_path: Path) -> None:
    (tmp_path / "state").mkdir()
    target = tmp_path / "target"
    target.write_bytes(bytes(32))
    (tmp_path / "state" / "signing.key").symlink_to(target)
    with pytest.raises(EnvironmentFault):
        signing_key.signature(b"")
    assert target.read_bytes() == bytes(32)


def test_a_forged_proof_is_rejected(found: Equilibria, tmp_path: Path) -> None:
    """Emptied lists would say that nothing is left to judge; they have a right checksum and no signature."""
    file = tmp_path / "search.state"
    state = begun(found, file)
    forged = Snapshot(dict(state.values), state.arrays | {"open": np.empty((0, 6)), "undecided": np.empty((0, 6))})
    write_snapshots(file, {"search": forged})
    before = file.read_bytes()
    with pytest.raises(InputError, match="not signed by this user, so that no proof is taken from it"):
        search_all(found, BOX, file, time_limit=1e-9)
    assert file.read_bytes() == before


@pytest.mark.parametrize("signed", ["", "zz", "00" * 32, 7, None])
def test_another_signature_is_rejected(found: Equilibria, tmp_path: Path, signed: object) -> None:
    file = tmp_path / "search.state"
    state = begun(found, file)
    write_snapshots(file, {"search": Snapshot(state.values | {"signature": signed}, state.arrays)})
    with pytest.raises(InputError, match="not signed by this user"):
        search_all(found, BOX, file, time_limit=1e-9)


def test_the_state_of_another_user_is_rejected(
    found: Equilibria, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "search.state"
    begun(found, file)
    monkeypatch.setenv(signing_key.DIRECTORY, str(tmp_path / "another"))
    with pytest.raises(InputError, match="not signed by this user"):
        search_all(found, BOX, file, time_limit=1e-9)


@pytest.mark.parametrize("missing", ["question", "signature", "level", "open"])
def test_a_state_that_lacks_something_is_none(found: Equilibria, tmp_path: Path, missing: str) -> None:
    file = tmp_path / "search.state"
    state = begun(found, file)
    values = {key: value for key, value in state.values.items() if key != missing}
    arrays = {key: value for key, value in state.arrays.items() if key != missing}
    write_snapshots(file, {"search": Snapshot(values, arrays)})
    with pytest.raises(InputError, match="no saved state of a search"):
        search_all(found, BOX, file, time_limit=1e-9)


def test_a_search_of_an_earlier_version_begins_again(found: Equilibria, tmp_path: Path) -> None:
    """Its proof rests on other kernels, so that nothing is taken from it; the file is read nevertheless."""
    file = tmp_path / "search.state"
    file.write_bytes((Path(__file__).parents[1] / "earlier_files" / "search.state").read_bytes())
    before = read_snapshots(file)["search"]
    assert not search_all(found, BOX, file, time_limit=1e-9).finished
    assert read_snapshots(file)["search"].values["question"] != before.values["question"]


def test_a_search_of_something_else_begins_again(found: Equilibria, tmp_path: Path) -> None:
    file = tmp_path / "search.state"
    begun(found, file)
    other = [*BOX[:5], 1.4]
    assert not search_all(equilibria(load("merlet2023"), LENGTHS, box=other), other, file, time_limit=1e-9).finished


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no FIFOs here")
def test_a_fifo_is_no_state(found: Equilibria, tmp_path: Path) -> None:
    file = tmp_path / "search.state"
    os.mkfifo(file)
    with pytest.raises(InputError, match="not a regular file"):
        search_all(found, BOX, file, time_limit=1e-9)
