"""Swing along a path against the dynamic plant, whose lines sag: a body, and a point on sagging lines."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cablewright.kernels.plant import dynamics
from cablewright.models.inertia import with_inertia
from cablewright.models.packed_views import LineStates
from cablewright.models.rotation import matrices
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.robot import Dynamics, RigidPlatform, load
from cablewright.solvers.inverse import solve_inverse
from cablewright.studies.checks.check import check
from cablewright.studies.checks.result import Check

STEP = 2e-3  # s
RATIO = 0.01


def body_of(found: Check, relaxation: float) -> np.ndarray:
    """The numbers of the body (BODY,) whose lines dissipate with this *relaxation*, s."""
    platform, numbers = with_inertia(found.robot).platform, np.zeros(dynamics.BODY)
    numbers[dynamics.MASS], numbers[dynamics.RELAXATION] = platform.mass, relaxation
    tensor = np.eye(3)  # of a point: it does not turn
    if isinstance(platform, RigidPlatform):
        centre = np.array(platform.centre_of_mass)
        numbers[dynamics.CENTRE : dynamics.CENTRE + 3] = centre
        (xx, yy, zz), (xy, xz, yz) = platform.inertia, platform.inertia_products
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        tensor = tensor + platform.mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    numbers[dynamics.INERTIA : dynamics.INERTIA + 9] = tensor.ravel()
    return numbers


def moved(found: Check, frequency: float) -> tuple[float, float]:
    """Largest error, m, and smallest tension, N, of the plant while the lengths of a check are paid out."""
    held = solve_inverse(Model.full(found.robot), found.poses[:1])
    lines, platform = held.packed.lines, held.packed.platform
    packed = held.packed._replace(
        lines=lines.reshape(-1, *lines.shape[-2:])[0].copy(),
        platform=platform.reshape(-1, platform.shape[-1])[0].copy(),
    )
    states, motion, n = held.states[0].copy(), np.zeros(dynamics.MOTION), found.robot.n
    motion[:3] = found.poses[0, :3]
    if n == 6:
        motion[dynamics.TURN : dynamics.TURN + 3] = found.poses[0, 3:]
    nozzle = np.array(getattr(found.robot.platform, "nozzle", (0.0, 0.0, 0.0)))
    times = np.arange(0.0, found.law.duration, STEP)
    lengths, wanted = (
        np.column_stack([np.interp(times, found.law.time, column) for column in values.T])
        for values in (found.lengths, found.samples.positions)
    )
    body, work = body_of(found, RATIO / (np.pi * frequency)), dynamics.moving_workspace(packed)
    error, least = 0.0, np.inf
    for k in range(1, len(times)):
        given = (packed, body, motion, lengths[k - 1], lengths[k], STEP, states, *work)
        assert dynamics.midpoint_step(*given) == 0
        place = motion[:3] + matrices(motion[dynamics.TURN : dynamics.TURN + 3]) @ nozzle
        error = max(error, float(np.linalg.norm(place - wanted[k])))
        least = min(least, float(LineStates(states).tension.min()))
    return error, least


@pytest.mark.parametrize(("name", "side", "height"), [("cogiro", 400, 500), ("house-printer", 900, 20)])
def test_errors_and_tensions_are_those_of_the_dynamic_plant(name: str, side: int, height: int, tmp_path: Path) -> None:
    corners = ((1, 0), (1, 1), (0, 1), (0, 0))
    lines = [
        "G21 G90 M83",
        ";LAYER:0",
        f"G0 X0 Y0 Z{height} F6000",
        *(f"G1 X{side * x} Y{side * y} E9" for x, y in corners),
    ]
    (tmp_path / "square.gcode").write_text("\n".join(lines) + "\n")
    job = Job.model_validate(
        {"name": "square", "gcode": str(tmp_path / "square.gcode"), "motion": {"acceleration": 0.5, "shaping": "none"}}
    )
    robot = load(name).model_copy(update={"dynamics": Dynamics(damping_ratio=RATIO)})
    found = check(robot, job, skip=("interference", "expected-error"))
    worst = int(np.nanargmax(found.statics.displacement))
    error, least = moved(found, float(found.statics.frequency[worst]))
    assert found.statics.displacement[worst] == pytest.approx(error, rel=0.1)
    assert found.statics.lines.lowest_tension.min() == pytest.approx(least, abs=15.0)
