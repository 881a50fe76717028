"""Campaigns: each print is that of `print`, the same with any executor; intervals, sensitivities and rejections."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from cablewright.foundation.errors import InputError
from cablewright.live.prints.plan import PrintOptions
from cablewright.live.prints.print_job import print_job
from cablewright.machine.simulated.settings import load_twin
from cablewright.printing.job import Job
from cablewright.robot import load
from cablewright.running.executors.processes import Processes
from cablewright.studies.campaigns.campaign import campaign
from cablewright.studies.campaigns.one_print import REMEDIES
from cablewright.studies.campaigns.result import Campaign, MachinePrint

ROBOT = load("merlet2023")
RING = Job.model_validate({
    "name": "ring", "origin": [0.3, -0.5, 0.0],
    "helix": {"radius": 0.1, "layers": 1, "layer_height": "1 mm", "first_height": "1 m"},
    "motion": {"print_speed": "3 cm/s", "travel_speed": "3 cm/s", "acceleration": "20 mm/s^2"},
})  # fmt: skip
OPTIONS = PrintOptions(plant="quasi-static", period=1.0, seed=5)


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> tuple[Campaign, Path]:
    file = tmp_path_factory.mktemp("campaign") / "results.jsonl"
    return campaign(ROBOT, RING, 3, options=OPTIONS, tried=1, file=file), file


def test_each_print_is_that_of_the_machine_of_its_seed(found: tuple[Campaign, Path], tmp_path: Path) -> None:
    record = print_job(ROBOT, RING, tmp_path / "run", options=replace(OPTIONS, seed=6)).record
    own = found[0].prints[1]
    assert own.seed == 6
    assert own.max_error == record.true.error.size
    assert own.rms == record.whole.position_rms
    assert own.distance == record.distance
    assert own.finished


def test_processes_give_the_same_and_a_campaign_resumes(found: tuple[Campaign, Path]) -> None:
    file = found[1]
    lines = file.read_bytes().splitlines(keepends=True)
    assert len(lines) == 1 + 3 + len(found[0].what.tolerances)
    file.write_bytes(b"".join(lines[:3]))
    executor = Processes(2)
    try:
        again = campaign(ROBOT, RING, 3, options=OPTIONS, tried=1, file=file, executor=executor)
    finally:
        executor.close()
    assert (again.prints, again.to_dict()) == (found[0].prints, found[0].to_dict())


def test_a_tolerance_met_exactly_is_the_machine_with_it_at_zero(found: tuple[Campaign, Path]) -> None:
    twin = load_twin("merlet2023")
    exact = twin.simulation.tolerances.model_copy(update={"anchor": 0.0})
    own = campaign(ROBOT, RING, 1, machine=twin.with_simulation(tolerances=exact), options=OPTIONS, tried=0)
    (one,) = [each for each in found[0].sensitivities if each.tolerance == "anchor"]
    assert one.change == own.prints[0].max_error - found[0].prints[0].max_error
    assert {each.tolerance for each in found[0].sensitivities} == {"anchor", "sheave_radius", "modulus"}
    assert math.isnan(one.change_error)
    assert set(REMEDIES) == set(type(twin.simulation.tolerances).model_fields)


@pytest.mark.parametrize(("succeeded", "count"), [(0, 10), (7, 10), (10, 10), (97, 100)])
def test_the_interval_is_that_of_clopper_and_pearson(found: tuple[Campaign, Path], succeeded: int, count: int) -> None:
    """By the quantiles of beta distributions."""
    good, bad = MachinePrint(0, True, "finished", "", 0.001, 0.0, 1.0, 1.0), found[0].prints[0]
    stopped = replace(bad, finished=False, status="fault", max_error=math.nan)
    prints = (good,) * succeeded + (stopped,) * (count - succeeded)
    made = replace(found[0], prints=prints, allowed_error=0.002)
    low = 0.0 if not succeeded else stats.beta.ppf(0.025, succeeded, count - succeeded + 1)
    high = 1.0 if succeeded == count else stats.beta.ppf(0.975, succeeded + 1, count - succeeded)
    assert made.success_interval == pytest.approx((low, high), abs=1e-9)
    assert made.status == {0: "all-failed", count: "ok"}.get(succeeded, "some-failed")
    assert made.quantile(0.5) == (0.001 if succeeded else None)


def test_quantiles_are_errors_of_machines(found: tuple[Campaign, Path]) -> None:
    prints = tuple(replace(found[0].prints[0], max_error=0.001 * (k + 1)) for k in range(100))
    made = replace(found[0], prints=prints, allowed_error=0.0905)
    assert [made.quantile(share) for share in (0.0, 0.5, 0.95, 1.0)] == pytest.approx([0.001, 0.05, 0.095, 0.1])
    assert (made.succeeded, made.success_rate) == (90, 0.9)
    assert np.isfinite(made.errors).all()


@pytest.mark.parametrize(
    ("machines", "more", "says"),
    [
        (0, {}, "machines = 0: must be from 1"),
        (2, {"tried": 3}, "tried = 3: must be from 0 to the number of machines, 2"),
        (2, {"tried": 0, "allowed_error": -1.0}, "allowed_error = -1: must be a finite number over 0"),
        (2, {"tried": 0, "machine": "no-such"}, "no-such"),
    ],
)
def test_what_makes_no_sense_is_rejected(machines: int, more: dict[str, object], says: str) -> None:
    with pytest.raises(InputError, match=says):
        campaign(ROBOT, RING, machines, options=OPTIONS, **more)  # type: ignore[arg-type]


def test_a_picture_shows_machines_and_tolerances(found: tuple[Campaign, Path], tmp_path: Path) -> None:
    found[0].plot(tmp_path / "picture.png")
    assert (tmp_path / "picture.png").stat().st_size > 10_000
