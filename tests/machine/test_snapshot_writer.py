"""Snapshots written in a thread: the newest is on the disk at the end, every file in between is whole."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cablewright.foundation.errors import EnvironmentFault, InputError
from cablewright.foundation.saved_state import Snapshot, read_snapshots, write_snapshots
from cablewright.live.prints import snapshot_writer as keepers
from cablewright.live.prints.snapshot_writer import SnapshotWriter


def number(k: int) -> dict[str, Snapshot]:
    return {"a": Snapshot({"k": k}, {"x": np.full(1000, float(k))})}


def read(path: Path) -> int:
    found = read_snapshots(path)["a"]
    assert (found.arrays["x"] == found.values["k"]).all()
    return int(found.values["k"])


def test_the_newest_is_on_the_disk_at_the_end(tmp_path: Path) -> None:
    path, seen = tmp_path / "state", [0]
    with SnapshotWriter(path) as keeper:
        for k in range(1, 301):
            keeper.put(number(k))
            if path.exists():
                seen.append(read(path))
    assert seen == sorted(seen)
    assert read(path) == 300
    assert [each.name for each in tmp_path.iterdir()] == ["state"]


def test_a_waiting_snapshot_is_replaced_by_a_newer_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written, go, busy = list[int](), threading.Event(), threading.Event()

    def slow(path: Path, snapshots: Any, **_: object) -> None:
        busy.set()
        assert go.wait(10.0)
        written.append(snapshots["a"].values["k"])
        write_snapshots(path, snapshots)

    monkeypatch.setattr(keepers, "write_snapshots", slow)
    with SnapshotWriter(tmp_path / "state") as keeper:
        keeper.put(number(1))
        assert busy.wait(10.0)
        for k in (2, 3, 4):
            keeper.put(number(k))
        go.set()
    assert written == [1, 4]


def put_until_refused(path: Path) -> None:
    with SnapshotWriter(path) as keeper:
        for k in range(100_000):
            keeper.put(number(k))


def test_a_disk_that_rejects_is_reported_at_the_next_one_or_at_the_end(tmp_path: Path) -> None:
    missing = tmp_path / "none" / "state"
    with pytest.raises(EnvironmentFault, match="none/state: cannot be written"):
        put_until_refused(missing)
    with pytest.raises(EnvironmentFault, match="cannot be written"), SnapshotWriter(missing) as keeper:
        keeper.put(number(1))
    with pytest.raises(InputError), SnapshotWriter(missing):  # the first error is reported
        read_snapshots(missing)
