"""An encoder that does not count stops a print, by name and within centimetres; one that counts never does."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cablewright as cw
from cablewright.machine.simulated.settings import FaultPlan, load_twin

BEGIN = 40.0  # s: it prints by then
RING = {
    "name": "ring",
    "origin": [0.3, -0.5, 0.0],
    "helix": {"radius": 0.3, "layers": 1, "layer_height": "1 mm", "first_height": "1 m"},
    "motion": {"print_speed": "3 cm/s", "travel_speed": "3 cm/s", "acceleration": "20 mm/s^2"},
}


def ring(folder: Path, *faults: FaultPlan, **options: object) -> cw.PrintedJob:
    machine = load_twin("merlet2023").with_simulation(faults=faults)
    job = cw.Job.model_validate(RING)
    return cw.print_job(
        cw.load("merlet2023"), job, folder / "run", machine=machine, options=cw.PrintOptions(seed=3, **options)
    )


@pytest.mark.parametrize(
    ("estimator", "line", "plant"),
    [
        ("encoders", "north-east", "quasi-static"),
        pytest.param("encoders", "north-east", "dynamic", marks=pytest.mark.slow),
        ("filter", None, "quasi-static"),
    ],
)
def test_a_stuck_encoder_stops_the_print_and_is_named(
    tmp_path: Path, estimator: str, line: str | None, plant: str
) -> None:
    fault = FaultPlan(source="encoders", kind="stuck", begin=BEGIN, line=line)
    found = ring(tmp_path, fault, estimator=estimator, plant=plant)
    assert found.status == "fault"
    assert "does not count: its winch was ordered to" in found.refusal
    if line is not None:
        number = [each.name for each in cw.load("merlet2023").lines].index(line) + 1
        assert f"the encoder of line {number} does not count" in found.refusal
    assert found.record.true.error.size < 0.03


@pytest.mark.parametrize(
    ("severity", "plant"), [("rough", "quasi-static"), pytest.param("rough", "dynamic", marks=pytest.mark.slow)]
)
def test_a_sound_machine_prints_to_its_end(tmp_path: Path, severity: str, plant: str) -> None:
    found = ring(tmp_path, estimator="encoders", severity=severity, plant=plant)
    assert found.status == "finished"
    assert np.isfinite(found.record.true.error.size)
