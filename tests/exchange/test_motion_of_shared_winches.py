"""Motion files of robots with fewer winches than lines: what they turn holds the nozzle where they say, by statics."""

from __future__ import annotations

import numpy as np
import pytest

import shared_winch_robots
from cablewright.exchange.firmware import firmware
from cablewright.exchange.motion_export.klipper import LETTERS as KLIPPER
from cablewright.exchange.motion_export.linuxcnc import LETTERS as LINUXCNC
from cablewright.models.statics import Model
from cablewright.models.winch_lines import WinchLines
from cablewright.printing.job import Job
from cablewright.robot import Robot
from cablewright.solvers.forward import solve_forward
from exchange.test_motion import replay

RING = Job.model_validate({
    "name": "ring",
    "helix": {"radius": 0.1, "layers": 1, "layer_height": 2e-3, "first_height": 0.5},
    "bead": {"width": 0.01, "height": 2e-3},
    "motion": {"print_speed": 0.1, "travel_speed": 0.1, "acceleration": 0.1},
})  # fmt: skip


@pytest.mark.parametrize("robot", [shared_winch_robots.hoist(), shared_winch_robots.pairs()], ids=["hoist", "pairs"])
@pytest.mark.parametrize(
    ("kind", "file", "letters"), [("klipper", "job.gcode", KLIPPER), ("linuxcnc", "job.ngc", LINUXCNC)]
)
def test_the_drums_of_a_file_hold_the_nozzle_on_its_path(kind: str, file: str, letters: str, robot: Robot) -> None:
    made = firmware(kind, robot, RING, tolerance=1e-5)
    found = replay(made.files[file], letters[: robot.winches])
    assert f"\n; {letters[robot.winches]} is line" not in made.files[file]
    winches, model = WinchLines.of(robot), Model.full(robot)
    lengths, host, guess = np.full((1, robot.m), np.nan), list(winches.hosts), None
    begin = made.path.lengths[0]
    for point, turned in list(zip(found.points, found.winches, strict=True))[:: len(found.points) // 6]:
        paid = 0.04 * np.radians(turned)
        lengths[0, host] = begin + paid
        for i, line in enumerate(robot.lines):
            if line.shared_winch is not None:
                lengths[0, i] = line.shared_winch.offset + line.shared_winch.sense * lengths[0, winches.host[i]]
        at = np.zeros(robot.n)
        at[:3] = 1e-3 * np.array(point) if robot.n == 3 else 1e-3 * np.array(point) + (0.0, 0.0, 0.2)
        held = solve_forward(model, lengths[0], guess=at if guess is None else guess).checked()
        assert held.nozzle == pytest.approx(1e-3 * np.array(point), abs=3e-5)
        guess = held.pose
