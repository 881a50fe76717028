"""A tilt meter is added by four files in a copy of the package, as the recipe says, and everything knows it."""

from __future__ import annotations

import filecmp
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import cablewright

HERE, SOURCE = Path(__file__).parent, Path(cablewright.__file__).parent
OF_A_SENSOR = 6  # files at most, with its test and its page
BESIDES = ("the test", "apps/keys.toml")


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the package, with a tilt meter."""
    tree = tmp_path_factory.mktemp("added")
    shutil.copytree(SOURCE, tree / "cablewright", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(
        HERE / "tilt_meter", tree / "cablewright", dirs_exist_ok=True, ignore=shutil.ignore_patterns("__pycache__")
    )
    return tree


@pytest.fixture(scope="module")
def told(tree: Path) -> dict[str, Any]:
    """Results of the copy with it."""
    run = subprocess.run(
        [sys.executable, "-B", HERE / "with_tilt_meter.py", tree],
        env=os.environ | {"PYTHONPATH": str(tree)},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert run.returncode == 0, run.stderr
    found: dict[str, Any] = json.loads(run.stdout)
    return found


def test_a_sensor_touches_six_files_at_most(tree: Path) -> None:
    files = [file.relative_to(tree / "cablewright") for file in (tree / "cablewright").rglob("*") if file.is_file()]
    own = [
        str(file)
        for file in files
        if not (SOURCE / file).is_file() or not filecmp.cmp(SOURCE / file, tree / "cablewright" / file, shallow=False)
    ]
    assert sorted(own) == [
        "estimation/body/updates/tilt_meter.py",
        "foundation/signals/tilt_meter.py",
        "machine/sensors/tilt_meter.py",
        "machine/simulated/sensors/tilt_meter.py",
    ]
    assert len(own) + len(BESIDES) <= OF_A_SENSOR


def test_it_is_simulated_and_logged_and_others_read_as_before(told: dict[str, Any]) -> None:
    """20 readings a second but those that dropped out, until the planned fault; in the log the same."""
    assert 20 <= len(told["times"]) < 30
    assert max(told["times"]) < 1.5
    assert told["logged"] == told["times"]
    assert told["numbers"] == 2 * len(told["times"])
    assert told["same"]


def test_it_is_estimated_by_and_missed(told: dict[str, Any]) -> None:
    with_it, without = told["sigmas"]
    assert all(one < 0.7 * other for one, other in zip(with_it, without, strict=True))
    assert told["faults"] == ["no reading for over 0.5 s"]


def test_its_messages_name_it(told: dict[str, Any]) -> None:
    assert "/tilt_meter" in told["left_out"]
    assert told["unknown"].startswith("simulation.tilt_meter.bias")
    assert "the machine has no such sensor: no [tilt_meter]" in told["none"]
    assert "the machine has no such sensor: no [tilt_meter]" in told["none"]
