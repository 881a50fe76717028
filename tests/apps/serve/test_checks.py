"""Checks of jobs: an answer stands whatever comes of its report, and a print that begins immediately has its scene."""

from __future__ import annotations

import asyncio
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("starlette")

from cablewright.apps.serve import check_worker, checks
from cablewright.apps.serve.checks import WAITING, Checks
from cablewright.apps.serve.uploads import Uploads
from cablewright.foundation.errors import EnvironmentFault
from cablewright.live.serve.control_process import JOBS
from cablewright.live.serve.jobs import (
    CHECK,
    REPORT,
    SCENE,
    JobCheck,
    forget_check,
    load_served,
    read_check,
    write_check,
)
from cablewright.machine.files import load_machine
from cablewright.robot import load
from served import RING


@pytest.fixture
def job(tmp_path: Path) -> Path:
    """The folder of a job in a served folder."""
    (tmp_path / JOBS).mkdir()
    uploads = Uploads(tmp_path)
    number = uploads.new_job("ring")
    uploads.put_whole(number, "settings", RING.encode())
    check_worker.write_station(tmp_path, load("house-printer"), load_machine("house-printer"))
    return uploads.job(number)


def checked(monkeypatch: pytest.MonkeyPatch, written: Any) -> None:
    """Give each job a "yes" without its computation, and *written* instead of the report."""
    found = SimpleNamespace(
        expected=None,
        feasible=True,
        verdict="it can",
        law=SimpleNamespace(duration=60.0),
        beads=SimpleNamespace(typical=SimpleNamespace(section=1e-3)),
        samples=None,
    )
    monkeypatch.setattr("cablewright.studies.checks.check.check", lambda _robot, _job: found)
    monkeypatch.setattr("cablewright.printing.layers.layer_table", lambda _samples, _law: None)
    monkeypatch.setattr("cablewright.apps.serve.live_scene.live_scene", lambda _head, _job: {"path": [1.0]})
    monkeypatch.setattr("cablewright.apps.report.check.write", written)


def test_a_report_that_fails_leaves_the_answer(job: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_given: object) -> None:
        raise EnvironmentFault("no space left")

    checked(monkeypatch, full)
    with pytest.raises(EnvironmentFault, match="no space left"):
        check_worker.check_job(job.parents[1], job.name)
    found = read_check(job)
    assert found is not None
    assert (found.answer, found.has_report) == ("yes", False)


def test_scene_and_answer_are_there_before_the_report(job: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def write(_found: object, folder: Path, _layers: object) -> None:
        assert (job / SCENE).is_file()
        before = read_check(job)
        assert before is not None
        assert not before.has_report
        (folder / "report.html").write_text("as checked")

    def keep(folder: Path, check: JobCheck) -> None:
        assert (folder / SCENE).is_file()  # whoever reads the answer begins a print
        write_check(folder, check)

    checked(monkeypatch, write)
    monkeypatch.setattr(check_worker, "write_check", keep)
    assert check_worker.check_job(job.parents[1], job.name).has_report
    found = read_check(job)
    assert found is not None
    assert found.has_report
    forget_check(job)
    assert not any((job / name).exists() for name in (CHECK, SCENE, REPORT))
    forget_check(job)  # of none


@pytest.mark.parametrize(("before", "after"), [("yes", "yes"), ("no", "no"), (None, "failed")])
def test_a_worker_that_ends_early_replaces_no_answer(
    job: Path, before: Any, after: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if before is not None:
        write_check(job, JobCheck(subject="1" * 64, answer=before, why="as computed"))
    monkeypatch.setattr(checks.sys, "executable", "/no/such/python")  # type: ignore[attr-defined]
    asyncio.run(Checks(Uploads(job.parents[1]))._do("check", job.name))
    found = read_check(job)
    assert found is not None
    assert found.answer == after


def test_what_cannot_be_queued_changes_nothing(job: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    uploads = Uploads(job.parents[1])
    write_check(job, JobCheck(subject="1" * 64, answer="yes", why="it can"))
    queue = Checks(uploads)
    for k in range(WAITING):
        assert queue.ask("report", f"run {k}") == ""
    assert "try again later" in queue.ask("check", job.name)
    assert read_check(job) is not None

    def locked(_folder: Path) -> None:
        raise EnvironmentFault("cannot be removed")

    queue = Checks(uploads)
    monkeypatch.setattr(checks, "forget_check", locked)
    with pytest.raises(EnvironmentFault, match="cannot be removed"):
        queue.ask("check", job.name)
    assert queue.busy == {}
    assert queue._queue.empty()


def test_stages_that_are_missing_are_sent_later(job: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A stage that was removed, or cut off while it was made, is sent again; without room for all, none is."""
    uploads = Uploads(job.parents[1])
    long = RING.replace('"ring"', f'"{"r" * 300}"').replace(
        "[helix]", 'max_seam = "1 m"\n[[stages]]\nz = "50 mm"\nraised = "0.5 m"\n[helix]'
    )
    (job / "job.toml").write_text(long)

    def stages() -> dict[int, str]:
        check_worker.check_job(uploads.folder, job.name)
        return {each["stage"]: each["id"] for each in uploads.jobs({}) if each["of"] == job.name}

    monkeypatch.setattr(check_worker, "MAX_JOBS", 2)
    assert stages() == {}
    found = read_check(job)
    assert found is not None
    assert "2 stages are jobs of their own, for which there is no room" in found.why
    monkeypatch.setattr(check_worker, "MAX_JOBS", 3)
    first = stages()
    assert sorted(first) == [1, 2]
    assert load_served(uploads.job(first[2]), "stage").name.startswith("stage 2 of 2: rrr")
    assert stages() == first
    uploads.remove(first[1])
    (uploads.job(first[2]) / "job.toml").unlink()
    second = stages()
    assert sorted(second) == [1, 2]
    assert not set(second.values()) & set(first.values())
    assert (uploads.job(second[2]) / check_worker.STAGE).is_file()
