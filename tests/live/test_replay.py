"""A log replayed: the same estimates as during the run, honest counts, cut logs and logs without truth."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.live.error_statistics import CHI2_95, spread
from cablewright.live.prints.plan import PrintOptions
from cablewright.live.prints.print_job import print_job
from cablewright.live.replay import replay
from cablewright.machine.log.log import LogWriter, read_log
from cablewright.printing.job import Job
from cablewright.robot import load
from observer_runs import drive, errors, observe
from twins import head


@pytest.fixture(scope="module")
def recording():
    return drive(8.0, seed=2)


def write(path: Path, recording, truth: bool = True) -> Path:
    with path.open("wb") as file, LogWriter(file, head(seed=2)) as log:
        for frame, true in recording:
            log.write(frame, None, true if truth else None)
    return path


@pytest.fixture(scope="module")
def path(recording, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("replay") / "run.mcap", recording)


def test_a_replay_is_the_estimation_as_it_was(recording, path: Path) -> None:
    found, live = replay(path), observe(recording)
    assert found.steps == len(recording)
    assert found.valid == sum(estimate.valid for estimate in live)
    both = np.concatenate([found.position(moving=False), found.position(moving=True)])
    since = found.begin - 1e-9
    assert np.sort(both) == pytest.approx(np.sort(errors(live, recording, since)), abs=1e-12)
    assert found.radius_errors.shape == (len(both), 4)
    assert not found.faults
    assert not found.notes
    assert len(found.step_times) == found.steps


def test_the_filter_is_replayed_with_its_coverage(recording, path: Path) -> None:
    found, live = replay(path, "filter"), observe(recording, estimator="filter")
    assert found.valid == sum(estimate.valid for estimate in live)
    size = found.column("nees")
    assert len(size) == len(found.column("time"))
    share, mean = found.coverage()
    assert share == pytest.approx(np.mean(size <= CHI2_95))
    assert mean == pytest.approx(size.mean())
    assert np.isnan(replay(path).coverage()[0])
    inside = [row for row in found.trace if row[5] <= row[6]]
    assert len(inside) > 0.8 * len(found.trace)


def test_both_estimators_read_a_cut_log_up_to_there(path: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(path.read_bytes()[: int(0.6 * path.stat().st_size)])
    paper, error_state = replay(cut), replay(cut, "filter")
    assert paper.steps == error_state.steps > 0
    assert paper.notes == error_state.notes
    assert any("cut or damaged" in note for note in error_state.notes)


def test_slack_lines_are_counted_as_defined(recording, path: Path) -> None:
    found, live = replay(path), observe(recording)
    right, due = 0, 0
    for estimate, (frame, truth) in zip(live, recording, strict=True):
        if frame.time < found.begin - 1e-9 or truth.excess.max() <= 5e-3:
            continue
        due += 1
        right += bool(estimate.slack[truth.excess > 5e-3].all() and not estimate.slack[truth.excess <= 0.0].any())
    assert found.slack_errors["steps"] == due
    assert found.slack_errors["named_share"] == pytest.approx(right / due if due else np.nan, nan_ok=True)


def test_a_log_without_truth_is_replayed_without_errors(recording, tmp_path: Path) -> None:
    found = replay(write(tmp_path / "bare.mcap", recording, truth=False))
    assert found.valid > 600
    assert len(found.column("time")) == 0
    assert np.isnan(found.begin)
    assert spread(found.position(moving=True)).count == 0


def test_a_cut_log_is_replayed_up_to_there(path: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(path.read_bytes()[: int(0.7 * path.stat().st_size)])
    found = replay(cut)
    assert 0 < found.steps < 800
    assert any("cut or damaged" in note for note in found.notes)


def test_what_cannot_be_replayed_is_rejected(path: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="filter"):
        replay(path, "magic")
    with pytest.raises(InputError, match="no such file"):
        replay(tmp_path / "none.mcap")


def test_a_spread_is_of_sizes() -> None:
    found = spread(np.array([-3.0, 4.0, np.nan]))
    assert (found.count, found.max) == (2, 4.0)
    assert found.rms == pytest.approx(np.sqrt(12.5))
    assert spread(np.zeros(0)).count == 0


def test_a_replay_is_a_result(path: Path) -> None:
    found = replay(path)
    told = found.to_dict()
    assert json.dumps(told, allow_nan=False)
    assert told["valid_share"] == found.valid / found.steps
    assert told["moving"]["position"]["rms"] == spread(found.position(moving=True)).rms
    assert len(repr(found)) < 160
    assert "\n" not in repr(found)
    assert len(found.plot().axes) == 5


@pytest.mark.parametrize("name", ["hangprinter-v4", pytest.param("ipanema", marks=pytest.mark.slow)])
def test_a_print_by_encoders_alone_is_replayed_as_it_was_estimated(name: str, tmp_path: Path) -> None:
    robot = load(name)
    ring = {"radius": 0.1, "layers": 1, "layer_height": 2e-3, "first_height": 0.3 if robot.n == 3 else 0.8}
    speed = {"print_speed": 0.1, "travel_speed": 0.1, "acceleration": 0.05}
    job = Job.model_validate({"name": "ring", "helix": ring, "motion": speed})
    options = PrintOptions("encoders", plant="quasi-static", period=0.2, seed=3)
    done = print_job(robot, job, tmp_path / "run", options=options)
    assert done.finished
    found = replay(tmp_path / "run", None if robot.n == 3 else "encoders")
    assert found.estimator == "encoders"
    assert found.valid == found.steps == done.run.steps
    with read_log(tmp_path / "run") as log:
        offsets = [e.estimate.position - e.truth.position for e in log.entries() if e.estimate.valid]
    both = np.stack([found.column(axis) for axis in "xyz"], axis=1)
    assert both == pytest.approx(np.array(offsets)[-len(both) :], abs=1e-9)
    assert len(found.trace) > 10
    found.plot(tmp_path / "replay.png")
