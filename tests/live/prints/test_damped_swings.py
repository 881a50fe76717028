"""On the nonlinear plant the swing after a sudden load decays sooner with load cells, with late readings."""

from __future__ import annotations

import numpy as np
import pytest

import cablewright as cw
from cablewright.foundation.signals import Order, OrderKind, PrintState
from cablewright.live.prints.plan import plan_print, twin_of
from cablewright.live.prints.run import begin_print
from cablewright.machine.sensors.tensions import TensionSensor
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix
from cablewright.robot import load

RING = Job(
    name="ring",
    helix=Helix(radius=0.3, layers=1, layer_height=0.001, first_height=1.0),
    motion=Motion(print_speed=0.03),
)
LATE = 0.04  # s, of all readings by wire
WINDOW = 0.6  # s


def left(damping: bool) -> float:
    """The remaining vertical swing of the house printer after 1.8 s, as a share."""
    machine = cw.load_twin("house-printer")
    drum = machine.owner.point_drum.model_copy(
        update={"powder": 26.0, "capacity": 26.0, "radius": 0.3, "powder_density": 1500.0}
    )
    cells = TensionSensor(rate=100.0, deviation=5.0, bias=5.0, gain_deviation=0.005, most=6000.0)
    wire = machine.simulation.wire.model_copy(update={"latency": LATE})
    machine = machine.with_owner(drum=drum, load_cells=cells).with_simulation(wire=wire)
    twin = twin_of(load("house-printer"), RING, machine, cw.PrintOptions(damping=damping, seed=4))
    simulated, printer = begin_print(twin, plan_print(twin))
    simulated.refill(6.0)
    heights: list[float] = []
    simulated.open()
    printer.step(tuple(Order(kind, "test", printer.time) for kind in (OrderKind.RESET, OrderKind.ENABLE)))
    printer.step((Order(OrderKind.START, "test", printer.time),))
    while printer.supervisor.state is not PrintState.PRINTING:
        printer.step()
        assert printer.time < 20.0
    simulated.refill(26.0)
    while len(heights) * simulated.period < 4.0 * WINDOW:
        printer.step()
        heights.append(float(simulated.truth.position[2]))
        assert printer.damps is damping or len(heights) < 5
    simulated.close()
    first, *_, last = (np.ptp(each) for each in np.array_split(heights, 4))
    return float(last / first)


@pytest.mark.slow
def test_a_sudden_load_swings_for_less_than_half_of_the_time() -> None:
    damped, free = left(True), left(False)
    assert free > 0.4
    assert np.log(damped) <= 2.0 * np.log(free)
