"""Machines in a plane, or on fewer winches than degrees of freedom, on virtual drives: homed, and moved by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cablewright.control.path_follower import TimedPath
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Order, OrderKind, PrintState
from cablewright.live.drives import actions
from cablewright.live.drives.session import RealMachine
from cablewright.live.placeholder_path import still_path
from cablewright.live.prints.loop import Printer
from cablewright.models.statics import Model
from cablewright.printing.job import Motion
from cablewright.solvers.held_tensions import with_margin
from cablewright.solvers.inverse import solve_inverse
from virtual_drives import RING_BEGIN, Bench, bench


def made(name: str) -> Bench:
    return bench(name, tension=10.0)


def place_of(found: Bench) -> np.ndarray:
    """Where the nozzle truly is, (3,) m; it is the origin of both platforms."""
    return np.array(found.rig.plant.truth.position)


def until(printer: Printer, state: PrintState, steps: int = 6000) -> None:
    for _ in range(steps):
        printer.step()
        if printer.supervisor.state is state:
            return
    raise AssertionError(printer.supervisor)


def rest(printer: Printer) -> None:
    """Wait until the winches stand."""
    for _ in range(50):
        printer.step()


def given(printer: Printer, kind: OrderKind, **arguments: tuple[float, ...]) -> str:
    """Give an order; why it was rejected, or an empty text."""
    step = printer.step((Order(kind, "anna", printer.time, arguments),))
    return step.orders[0].refusal


def homed(found: Bench, folder: Path, place: np.ndarray) -> Printer:
    """Reset, enable, and home at a measured *place* (n,)."""
    machine = RealMachine.of(found.robot, found.twin.owner, folder / "machine", lambda: found.port)
    job, samples = still_path(found.robot, place[:3], Motion(print_speed=0.1, travel_speed=0.1, acceleration=0.2))
    path = TimedPath.of(job, nozzle=found.robot.platform.own_nozzle, samples=samples, robot=found.robot)
    homing = machine.homing(path.start_pose, place)
    printer = machine.printer(path, "model", {PrintState.HOMING: homing})
    printer.machine.open()
    for kind, then in ((OrderKind.RESET, PrintState.OFF), (OrderKind.ENABLE, PrintState.IDLE)):
        for _ in range(5):
            printer.step()
        assert given(printer, kind) == ""
        until(printer, then)
    assert given(printer, OrderKind.HOME) == ""
    until(printer, PrintState.IDLE)
    assert printer.supervisor.reason == "", printer.supervisor.reason
    rest(printer)
    return printer


@pytest.mark.slow
def test_a_line_that_was_turned_by_hand_is_named_in_a_plane(tmp_path: Path) -> None:
    found = made("maslow4")
    for turned in (0.0, 0.02):
        found.rig.turn_by_hand("top left", turned)
        place = place_of(found) if turned == 0.0 else None
        answer = actions.home(found.robot, found.twin.owner, tmp_path / "machine", place, lambda: found.port)
        assert (answer.reason == "") == (turned == 0.0), answer.reason
    assert "it is line top left by -20 mm" in answer.reason


@pytest.mark.parametrize(
    ("name", "way", "goal"),
    [
        ("maslow4", (0.0, 0.0258819, 0.0965926), (0.2, 0.9 * 0.258819 / 0.965926, 0.9)),
        pytest.param("grab-four-lines", (0.08, 0.0, 0.0), (1.0, 0.0, -0.3), marks=pytest.mark.slow),
    ],
)
def test_it_is_homed_jogged_and_sent_to_a_place(
    name: str, way: tuple[float, ...], goal: tuple[float, ...], tmp_path: Path
) -> None:
    found = made(name)
    before = place_of(found)
    printer = homed(found, tmp_path, np.pad(before, (0, found.robot.n - 3)))
    assert np.linalg.norm(printer.last_pose[:3] - before) < 2e-3
    for _ in range(100):
        assert given(printer, OrderKind.JOG, velocity=way) == ""
    until(printer, PrintState.IDLE)
    rest(printer)
    gone = place_of(found) - before
    along = np.array(way) / np.linalg.norm(way)
    assert gone @ along > 0.03
    assert np.linalg.norm(gone - (gone @ along) * along) < 2e-3
    assert given(printer, OrderKind.GO_TO, position=goal) == ""
    until(printer, PrintState.IDLE)
    assert printer.supervisor.reason == ""
    assert np.linalg.norm(printer.last_pose[:3] - goal) < 1.1e-4  # of the estimate
    assert np.linalg.norm(place_of(found) - goal) < 3e-3


def test_drives_too_weak_for_the_tensions_that_are_chosen_in_a_plane_are_rejected(tmp_path: Path) -> None:
    found, place = made("maslow4"), np.array(RING_BEGIN["maslow4"])
    model = Model(found.robot)
    chosen, _ = with_margin(model, place[None], None)
    least, held = (solve_inverse(each, place).tensions.max() for each in (model, chosen))
    assert held > 1.2 * least
    job, samples = still_path(found.robot, place, Motion(print_speed=0.1, travel_speed=0.1, acceleration=0.2))
    path = TimedPath.of(job, nozzle=None, samples=samples, robot=found.robot)
    torque = 0.5 * (least + held) * found.machine.drives.axes[0].scale.radii[1]
    owner = found.twin.owner
    weak = owner.model_copy(update={"winch": owner.winch.model_copy(update={"max_torque": torque})})
    machine = RealMachine.of(found.robot, weak, tmp_path / "machine", lambda: found.port)
    with pytest.raises(InputError, match="too heavy for the drives"):
        machine.printer(path, "model", {})
