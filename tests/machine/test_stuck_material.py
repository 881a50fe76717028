"""Material that sticks to the nozzle: none is lost, its mass is carried, and its owner does not know of it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Command
from cablewright.kernels.plant import dynamics
from cablewright.machine.files import machine_text
from cablewright.machine.simulated.settings import TwinSettings, load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.machine.simulated.unmodelled.effect_sizes import StickingMaterial
from cablewright.machine.simulated.unmodelled.stuck_material import StuckMaterial
from cablewright.models.packed_views import PlatformNumbers
from cablewright.robot import load

STARTS = {"merlet2023": [0.3, -1.0, 1.2], "house-printer": [0.0, 0.0, 0.5], "cogiro": [0.0, 0.0, 1.0]}
Plants = pytest.mark.parametrize("plant", ["dynamic", "quasi-static"])
Names = pytest.mark.parametrize("name", sorted(STARTS))


def twin_with(name: str, law: dict[str, Any]) -> TwinSettings:
    twin = load_twin(name).with_owner(lidars={})
    if name == "cogiro":  # with a hopper
        keys = {"capacity": 60.0, "powder": 40.0, "flow": 0.1, "powder_density": 1200.0, "radius": 0.3}
        twin = twin.with_owner(body=twin.owner.carrier.model_copy(update=keys))
    return twin.with_simulation(sticking=StickingMaterial.model_validate(law))


def made(name: str, law: dict[str, Any], plant: str) -> SimulatedMachine:
    return SimulatedMachine(load(name), twin_with(name, law), STARTS[name], seed=1, plant=plant)  # type: ignore[arg-type]


def poured(machine: SimulatedMachine, steps: int) -> float:
    """Let the valve open for so many steps; return what has left it, kg."""
    for _ in range(steps):
        machine.step(Command(machine.time, np.zeros(machine.robot.m), 1.0))
    return float(machine.settings.carrier.flow * machine.period * steps)


def test_a_crust_grows_by_its_closed_form_however_it_is_stepped() -> None:
    for most, fed in ((2.0, 0.5), (2.0, 500.0), (None, 30.0)):
        ends = []
        for steps in (1, 7, 400):
            stuck = StuckMaterial(StickingMaterial(share=0.05, most=most))
            falls = sum(stuck.passed(fed / steps) for _ in range(steps))
            assert falls + stuck.mass == pytest.approx(fed, rel=1e-12)
            ends.append(stuck.mass)
        whole = 0.05 * fed if most is None else most * (1.0 - math.exp(-0.05 * fed / most))
        assert ends == pytest.approx([whole] * 3, rel=1e-11)


@Plants
@Names
def test_what_leaves_the_valve_is_laid_or_carried(name: str, plant: str) -> None:
    machine, plain = (made(name, law, plant) for law in ({"share": 0.2, "most": 1.0}, {}))
    fed = poured(machine, 150)
    poured(plain, 150)
    rig, stuck = machine.rig, machine.rig.stuck
    assert stuck is not None
    assert stuck.mass == pytest.approx(1.0 - math.exp(-0.2 * fed))
    assert stuck.mass + rig.ground.mass + rig.falling_mass == pytest.approx(fed, rel=1e-9)
    assert machine.truth.powder == plain.truth.powder
    weights = [PlatformNumbers(each.rig.packed.platform).weight for each in (machine, plain)]
    assert weights[0] - weights[1] == pytest.approx(stuck.mass * machine.robot.scene.gravity, rel=1e-9)


@Names
def test_a_crust_is_a_point_mass_at_the_nozzle(name: str) -> None:
    """By the parallel axes: mass, centre of mass, and inertia about the platform's origin."""
    machine, plain = (made(name, law, "quasi-static") for law in ({"share": 0.5}, {}))
    poured(machine, 100), poured(plain, 100)
    stuck, at = machine.rig.stuck, machine.rig.masses.nozzle
    assert stuck is not None
    body, bare = machine.rig.body, plain.rig.body
    centre = slice(dynamics.CENTRE, dynamics.CENTRE + 3)
    inertia = slice(dynamics.INERTIA, dynamics.INERTIA + 9)
    assert body[dynamics.MASS] - bare[dynamics.MASS] == pytest.approx(stuck.mass)
    moment = body[dynamics.MASS] * body[centre] - bare[dynamics.MASS] * bare[centre]
    assert moment == pytest.approx(stuck.mass * at, abs=1e-9)
    spread = stuck.mass * (at @ at * np.eye(3) - np.outer(at, at))
    assert (body[inertia] - bare[inertia]).reshape(3, 3) == pytest.approx(spread, abs=1e-9)


def test_tensions_carry_it() -> None:
    """A point platform that stands: what its lines pull upwards is its weight with the crust."""
    machine, plain = (made("house-printer", law, "quasi-static") for law in ({"share": 0.5}, {}))
    poured(machine, 100), poured(plain, 100)
    stuck = machine.rig.stuck
    assert stuck is not None
    more = stuck.mass * machine.robot.scene.gravity
    low, high = (float(PlatformNumbers(each.rig.packed.platform).weight) for each in (plain, machine))
    assert high - low == pytest.approx(more)
    assert (machine.truth.tensions / plain.truth.tensions) == pytest.approx(np.full(4, high / low), rel=2e-3)


@Plants
@pytest.mark.parametrize("name", ["house-printer", "cogiro"])
def test_a_machine_with_a_crust_is_taken_up_again_to_the_bit(name: str, plant: str) -> None:
    law = {"share": 0.1, "most": 0.5}
    first = made(name, law, plant)
    poured(first, 20)
    robot, twin = load(name), twin_with(name, law)
    again = SimulatedMachine.resumed(robot, twin, first.snapshot(), seed=1, plant=plant)  # type: ignore[arg-type]
    poured(first, 20), poured(again, 20)
    assert first.rig.stuck is not None
    assert again.rig.stuck is not None
    assert first.rig.stuck.mass == again.rig.stuck.mass > 0.0
    assert (first.rig.motion == again.rig.motion).all()
    assert (first.rig.body == again.rig.body).all()


def test_a_refill_leaves_the_crust() -> None:
    machine = made("merlet2023", {"share": 0.1}, "quasi-static")
    fed = poured(machine, 30)
    machine.refill(machine.settings.carrier.powder)
    total = machine.settings.carrier.empty_mass + machine.settings.carrier.powder + 0.1 * fed
    assert machine.rig.body[dynamics.MASS] == pytest.approx(total)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("share = 1.5", r"sticking\.share = 1\.5: must be .*1"),
        ('share = 0.1\nmost = "0 kg"', r"sticking\.most = '0 kg': must be"),
    ],
)
def test_impossible_shares_are_rejected_in_one_line(text: str, says: str, tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text(f"{machine_text('merlet2023')}\n[simulation.sticking]\n{text}\n")
    with pytest.raises(InputError, match=says) as refused:
        load_twin(tmp_path / "own.toml")
    assert "\n" not in str(refused.value)
