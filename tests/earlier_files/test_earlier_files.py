"""Files that version 0.1.0 wrote in November 2026, in this folder: they are read, or begun anew with a message.

Do not write them anew: they stand for the files of users.
"""

from __future__ import annotations

import json
import logging
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import SensorFrame
from cablewright.live.replay import replay
from cablewright.machine.log.log import read_log
from cablewright.machine.log.messages import decode, encode, encode_frame
from cablewright.machine.log.topics import TOPICS
from cablewright.models.fidelity import Fidelity
from cablewright.models.statics import Model
from cablewright.robot import load
from cablewright.running import signing_key
from cablewright.solvers.equilibria import equilibria
from cablewright.studies.equilibria import search_all
from cablewright.studies.trade import TradeSettings, trade

FILES = Path(__file__).parent
CHANNELS: list[dict[str, Any]] = json.loads((FILES / "topics.json").read_text())
"""Each channel of a log: topic, schema, the attributes of its signal, and a message of lines a to d."""

LENGTHS = [10.1187, 9.3676, 10.9961, 11.3476]
BOX = [-2.0, 2.0, -4.0, 4.0, 0.3, 3.5]


def test_a_log_has_these_channels() -> None:
    """A renamed class or attribute changes none of these names; a new channel is added to the file by hand."""
    found = [(each.topic, each.schema, each.content) for each in TOPICS]
    told = [(each["topic"], each["schema"], each["content"]) for each in CHANNELS]
    assert sorted(found, key=itemgetter(0)) == sorted(told, key=itemgetter(0))


@pytest.mark.parametrize("channel", CHANNELS, ids=lambda each: each["topic"])
def test_a_message_is_read_and_written_as_it_was(channel: dict[str, Any]) -> None:
    signal = decode(channel["topic"], json.dumps(channel["message"]).encode(), "old.mcap")
    assert signal is not None
    if isinstance(signal, SensorFrame):
        assert json.loads(encode_frame(signal)) == channel["message"] | {"readings": 0}
    else:
        topic, again = encode(signal, ("a", "b", "c", "d"), 4096, 10**18)
        assert json.loads(again) == channel["message"]
        assert topic == channel["topic"]


@pytest.mark.parametrize("estimator", ["paper", "filter"])
def test_a_log_is_replayed(estimator: str) -> None:
    found = replay(FILES / "print.mcap", estimator).to_dict()
    told = json.loads((FILES / "print_replayed.json").read_text())[estimator]
    assert {key: found[key] for key in told if key != "consistency"} == {
        key: value for key, value in told.items() if key != "consistency"
    }
    for new, old in zip(found["consistency"], told["consistency"], strict=True):
        assert new["sensor"] == old["sensor"]
        assert new["nis"] == pytest.approx(old["nis"], abs=1e-9)


def test_steps_of_a_log_are_read() -> None:
    told = json.loads((FILES / "print_replayed.json").read_text())
    with read_log(FILES / "print.mcap") as log:
        entries = list(log.entries())
    assert log.notes == []
    assert len(entries) == told["steps"]
    last = entries[-1]
    assert last.truth is not None
    assert last.estimate is not None
    assert last.estimate.position.tolist() == told["last position"]
    assert last.truth.position.tolist() == told["truth"]
    assert last.truth.tensions.tolist() == told["tensions"]


@pytest.fixture
def key(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The key with which the search was signed."""
    folder = tmp_path / "state"
    folder.mkdir()
    file = folder / "signing.key"
    file.write_bytes(bytes(range(32)))
    file.chmod(0o600)
    monkeypatch.setenv(signing_key.DIRECTORY, str(folder))
    return file


@pytest.mark.usefixtures("key")
def test_a_search_begins_anew_and_says_so(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    state = tmp_path / "search.state"
    state.write_bytes((FILES / "search.state").read_bytes())
    found = equilibria(load("merlet2023"), LENGTHS, box=BOX)
    assert not search_all(found, BOX, state, time_limit=1e-9).finished
    assert [each.getMessage() for each in caplog.records if each.levelno == logging.WARNING] == [
        f"{state}: a search of other inputs or by other kernels; it starts again"
    ]
    assert state.read_bytes() != (FILES / "search.state").read_bytes()
    caplog.clear()
    search_all(found, BOX, state, time_limit=1e-9)
    assert not caplog.records


def test_a_search_that_somebody_else_signed_is_refused_where_it_would_be_resumed(
    tmp_path: Path, key: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    state = tmp_path / "search.state"
    found = equilibria(load("merlet2023"), LENGTHS, box=BOX)
    search_all(found, BOX, state, time_limit=1e-9)
    key.write_bytes(bytes(range(1, 33)))
    with pytest.raises(InputError, match="not signed by this user"):
        search_all(found, BOX, state, time_limit=1e-9)


def test_results_of_a_study_are_computed_anew_with_a_message(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    model = Model(load("jung2020"), Fidelity.of("elastic"))
    quick = TradeSettings(criterion="closed-form", tolerance=0.02, boundary_grid=11, inertia="box")
    file = tmp_path / "trade.results.jsonl"
    file.write_bytes((FILES / "trade.results.jsonl").read_bytes())
    old = [json.loads(line)["value"] for line in file.read_text().splitlines()[1:]]
    found = trade(model, {"exit-distance": (0.1, 0.2)}, quick, file=file)
    assert [each.getMessage() for each in caplog.records] == [
        f"{file}: none of its 2 results is of these inputs and this version; the study starts again"
    ]
    for new, each in zip(found.combinations, old, strict=True):
        assert (new.n, new.dominant, new.converged, list(new.exits)) == (
            each["n"], each["dominant"], each["converged"], each["exits"]
        )  # fmt: skip
        for key in ("volume", "fraction", "least", "median", "greatest", "worst_pose"):
            np.testing.assert_allclose(getattr(new, key), each[key], rtol=1e-9)
    caplog.clear()
    trade(model, {"exit-distance": (0.1, 0.2)}, quick, file=file)
    assert not caplog.records
