"""The head of a log: of machines of each kind, and of logs of the first schema."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import pytest

from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Climate, SensorFrame
from cablewright.live.replay import replay
from cablewright.machine.log.head import LogHead, read_head, written_head
from cablewright.machine.log.log import read_log, write_log
from cablewright.machine.simulated.settings import FaultPlan
from cablewright.robot import load
from observer_runs import drive
from twins import SETTINGS, SIMULATION, TWIN, changed, head

OLD = Path(__file__).with_name("head_schema_1.json")
"""Head of a log of schema 1: with faults, a gap, an intrusion, a cell of 3 cm, and without a distance sensor."""

REAL = LogHead(
    load("merlet2023"),
    SETTINGS,
    0.01,
    kind="real",
    epoch=datetime(2026, 3, 1, 7, 30, 0, 250_000, UTC),
    versions={"cablewright": "0.1", "drive north-west": "4.2.1"},
)


@pytest.mark.parametrize("told", [head(), head(plant="quasi-static", seed=3), REAL, replace(REAL, kind="replayed")])
def test_it_is_read_as_it_was_written(told: LogHead) -> None:
    assert read_head(written_head(told), "a.mcap") == told


def test_a_simulated_machine_has_no_time_of_day() -> None:
    """So that one input and version give the same bytes."""
    assert json.loads(written_head(head())["epoch"]) is None
    assert set(head().versions) == {"cablewright"}
    assert json.loads(written_head(REAL)["epoch"]) == "2026-03-01T07:30:00.250000Z"


def test_a_real_machine_has_nothing_of_a_simulation() -> None:
    assert REAL.simulation is REAL.plant is REAL.seed is None
    assert (REAL.origin, head(seed=4).origin) == ("real machine", "dynamic plant, seed 4")
    for key, value in (("simulation", SIMULATION), ("plant", "dynamic"), ("seed", 0)):
        with pytest.raises(InputError, match=f"the head's {key}: a real machine has none"):
            replace(REAL, **{key: value})
        texts = written_head(REAL) | {key: written_head(head())[key]}
        with pytest.raises(InputError, match=rf"a\.mcap: the head's {key}: a real machine has none"):
            read_head(texts, "a.mcap")


@pytest.mark.parametrize(
    ("key", "value", "says"),
    [
        ("schema", 3, "schema 3 of the log: this cablewright reads 1 to 2"),
        ("schema", None, "schema None"),
        ("kind", "virtual", "the head's kind"),
        ("epoch", "2026-03-01T07:30:00", "the head's epoch"),
        ("epoch", "2026-03-01T07:30:00+01:00", "the head's epoch: Value error, must be UTC"),
        ("versions", {"": "1"}, "the head's versions"),
        ("settings", {}, "the head's settings"),
        ("simulation", {}, "the head's simulation"),
    ],
)
def test_what_is_no_head_is_named(key: str, value: object, says: str) -> None:
    with pytest.raises(InputError, match=says):
        read_head(written_head(head()) | {key: json.dumps(value)}, "a.mcap")


def test_the_first_schema_is_taken_apart() -> None:
    """Into what its owner knew and what only the simulation had, with every number as it was."""
    found = read_head(json.loads(OLD.read_text("utf-8")), "old.mcap")
    faults = (
        FaultPlan(source="north", begin=2.0, end=4.0),
        FaultPlan(source="line_angles", line="south-east", kind="stuck"),
    )
    flaws = {"wifi": {"gaps": ((2.0, 3.0),)}, "barrier": {"intrusions": ((30.0, 50.0),)}, "room": {"cell": 0.03}}
    expected = changed(TWIN, **flaws).with_owner(distance=None).with_simulation(faults=faults)
    assert found.settings == expected.owner
    assert found.settings.winch.radius_deviation == 1e-3  # the earlier filter received the walk itself
    bare = type(found.simulation.distance)()  # the old head has no sensor whose flaws it could have
    assert found.simulation == expected.simulation.model_copy(update={"distance": bare})
    assert (found.kind, found.plant, found.seed, found.period) == ("simulated", "dynamic", 7, 0.01)
    assert (found.epoch, found.versions) == (None, {})


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("winch", None),
        ("lidars", {"north": 3}),
        ("drum", []),
        ("distance", 1),
        ("more", 1),
        ("faults", 7),
        ("line", {}),
    ],
)
def test_a_damaged_head_of_the_first_schema_is_rejected(key: str, value: object) -> None:
    texts = json.loads(OLD.read_text("utf-8"))
    for settings in (json.loads(texts["settings"]) | {key: value}, {key: value}, value):
        with pytest.raises(InputError, match=r"old\.mcap: the head's (settings|simulation)"):
            read_head(texts | {"settings": json.dumps(settings)}, "old.mcap")


def test_an_old_log_is_read(tmp_path: Path) -> None:
    old = Path(__file__).parents[3] / "examples" / "merlet2023-loop.mcap"
    with read_log(old) as log:
        assert log.head.settings == SETTINGS.model_copy(update={"robot": None})  # a key that came later
        assert log.head.simulation == SIMULATION
        assert next(log.entries()).truth is not None


def test_estimation_needs_nothing_of_the_simulation(tmp_path: Path) -> None:
    """A log whose head has only what a real machine's has gives the same estimates, bit for bit."""
    recording, found = drive(6.0, seed=2), []
    for name, told in (("simulated", head(seed=2)), ("real", REAL)):
        path = tmp_path / f"{name}.mcap"
        with write_log(path, told, flush_every=None) as log:
            for frame, truth in recording:
                log.write(frame, None, truth)
        found.append(replay(path, "filter"))
    assert len(found[0].errors) > 100
    assert found[0].errors.tobytes() == found[1].errors.tobytes()
    assert (found[1].to_dict()["plant"], found[1].to_dict()["seed"]) == (None, None)


def test_another_version_goes_on_with_a_log(tmp_path: Path) -> None:
    """A resumed print may run under a newer program; all else of the heads must be the same."""
    for number, told in enumerate((head(), replace(head(), versions={"cablewright": "9.9"}))):
        with write_log(tmp_path / f"log-{number:03}.mcap", told) as log:
            for k in range(5):
                now = 0.01 * (5 * number + k + 1)
                log.write(SensorFrame(now, (Climate(now, 20.0, 0.5),)))
    with read_log(tmp_path) as log:
        assert len(list(log.entries())) == 10
