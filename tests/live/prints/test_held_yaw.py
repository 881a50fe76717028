"""A print whose drum a drive turns: the yaw is held, the drive stands when the machine stops, and the log has both."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from cablewright.foundation.signals import YAW, Command, PrintState, YawAngle
from cablewright.live.prints.loop import Printer
from cablewright.live.prints.plan import MachineTwin, PrintOptions, plan_print, twin_of
from cablewright.live.prints.print_job import print_job
from cablewright.live.prints.recorder import checkpoint_of
from cablewright.live.prints.run import begin_print
from cablewright.machine.carried_load import YawDrive
from cablewright.machine.log.log import read_log
from cablewright.machine.sensors.yaw_encoder import YawEncoder
from cablewright.machine.simulated.settings import Link, TwinSettings
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.printing.job import Job
from cablewright.robot import load
from twins import TWIN, changed

RING = {
    "name": "ring",
    "origin": [0.3, -0.5, 0.0],
    "helix": {"radius": 0.35, "layers": 1, "layer_height": "1 mm", "first_height": "1 m"},
    "motion": {"print_speed": "3 cm/s", "travel_speed": "3 cm/s", "acceleration": "20 mm/s^2"},
}
JOB = Job.model_validate(RING)
HELD = 0.1  # rad
DRIVEN = changed(TWIN, drum={"yaw_drive": YawDrive(max_speed=0.5, max_torque=5.0, held=HELD)})


def twin(settings: TwinSettings, estimator: str = "filter") -> MachineTwin:
    return twin_of(load("merlet2023"), JOB, settings, PrintOptions(estimator, seed=3))


def test_the_yaw_of_a_ring_is_held(tmp_path: Path) -> None:
    """A step a second, so that lidars alone hold it: slowly. At the end the drive stands."""
    options, off = PrintOptions("paper", plant="quasi-static", period=1.0, seed=3), {}
    for name, settings in (("free", TWIN), ("held", DRIVEN)):
        printed = print_job(load("merlet2023"), JOB, tmp_path / name, machine=settings, options=options)
        assert printed.run.finished
        with read_log(tmp_path / name) as log:
            steps = [each for each in log.entries() if each.progress is not None and each.truth is not None]
        printing = [each for each in steps if each.progress.state is PrintState.PRINTING]
        off[name] = np.array([each.truth.rotation[2] - HELD for each in printing])
        orders = [each.command.outputs for each in printing[1:] if each.command is not None]
        assert orders
        assert all(("yaw" in given) is (name == "held") for given in orders)
    assert np.sqrt(np.mean(off["held"][20:] ** 2)) < 0.7 * np.sqrt(np.mean(off["free"][20:] ** 2))


def test_the_plan_says_that_it_is_held_and_where_nothing_knows_it_the_drive_stands() -> None:
    plan = plan_print(twin(DRIVEN))
    assert plan.yaw is not None
    assert (plan.yaw.held, plan.yaw.turn) == (HELD, 1.0)
    assert any("held at 5.73 deg" in note for note in plan.notes)
    for other in (twin(TWIN), twin(DRIVEN, "encoders")):
        assert plan_print(other).yaw is None


def test_a_stopped_machine_does_not_turn_its_drum() -> None:
    """The printer begins in a fault: its commands close brakes, and no output moves the drive."""
    made = twin(DRIVEN)
    machine, printer = begin_print(made, plan_print(made))
    for _ in range(20):
        assert "yaw" not in printer.step().command.outputs
    assert machine.rig.yaw.angle == 0.0


def test_a_resumed_print_knows_where_its_drive_is() -> None:
    made = twin(DRIVEN)
    plan = plan_print(made)
    machine, printer = begin_print(made, plan)
    printer.yaw.angle = 0.25
    kept = checkpoint_of(printer)
    again = Printer(plan, machine, lambda place, radii: printer.estimator, saved=kept)
    assert again.yaw.angle == 0.25


def test_the_encoder_of_its_drive_shows_how_far_the_drive_has_turned_the_drum() -> None:
    sheet = YawEncoder(rate=50.0)
    settings = DRIVEN.with_owner(yaw_encoder=sheet).with_simulation(wire=Link())
    machine, shown = SimulatedMachine(load("merlet2023"), settings, (0.3, -1.0, 1.2), seed=1), []
    for _ in range(100):
        frame = machine.step(Command(machine.time, np.zeros(4), outputs={YAW: 0.2}))
        shown += [each.angle for each in frame.of(YawAngle)]
    assert 40 < len(shown) <= 51
    assert shown[-1] == pytest.approx(machine.rig.yaw.angle, abs=5e-3)
    assert 0.15 < shown[-1] < 0.21  # 0.2 rad/s for a second
    assert plan_print(twin(settings)).guard.timeouts["yaw_encoder"] == 0.5
    with pytest.raises(ValidationError, match=r"needs drum\.yaw_drive"):
        type(TWIN.owner).model_validate(TWIN.owner.model_dump() | {"yaw_encoder": sheet.model_dump()})
