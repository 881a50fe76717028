"""A print of the house by a camera alone: lengths that it does not see stay those of the encoders."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest
from benchmarks.campaigns.remedies import EXAMPLES, REMEDIES, machine_of

from cablewright.live.estimator_settings import started_settings
from cablewright.live.prints.loop import Printer, Step, run
from cablewright.live.prints.plan import PrintOptions, plan_print, twin_of
from cablewright.live.prints.run import begin_print
from cablewright.live.prints.simulated_operator import attendant_of
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.printing.job import load_job

STEPS = 320  # s: with radii that count as unknown two lines are slack by then, and the print stops


def test_radii_are_known_as_in_the_machine_file() -> None:
    """Ten times the expected deviation of a grooved drum; random coils of a smooth one are as uncertain as before."""
    for name, sigma in (("house-printer", 2e-3), ("merlet2023", 0.1)):
        robot, settings = machine_of(name, "ideal", REMEDIES[-1])
        assert started_settings(robot, settings.owner).filter.radius_sigma == pytest.approx(sigma)


@dataclass
class Watch:
    """Recorder of the true errors and the slack of a print."""

    machine: SimulatedMachine
    errors: list[float] = field(default_factory=list)
    excess: list[float] = field(default_factory=list)

    def add(self, _printer: Printer, step: Step, *, last: bool) -> None:
        truth, estimate = self.machine.truth, step.estimate
        self.errors.append(float(np.linalg.norm(truth.position - estimate.position)))
        self.excess.append(float(np.abs(truth.lengths - estimate.lengths).max()))


def test_a_print_by_camera_loses_no_line_to_slack(monkeypatch: pytest.MonkeyPatch) -> None:
    robot, settings = machine_of("house-printer", "ideal", REMEDIES[-1])
    options = PrintOptions(estimator="filter", layers=10, plant="quasi-static", seed=50002)
    twin = twin_of(robot, load_job(EXAMPLES / "house.toml"), settings, options)
    machine, printer = begin_print(twin, plan_print(twin))
    watch = Watch(machine)
    attendant = attendant_of(machine, printer, options)
    monkeypatch.setattr(attendant, "is_over", lambda _printer: len(watch.errors) >= STEPS)
    run(printer, attendant, watch)
    assert len(watch.errors) > STEPS
    assert np.nanmax(watch.errors) < 0.025
    assert np.nanmax(watch.excess) < 0.02
