"""What a corner and a change of speed do to the tensions of a rigid platform, and how slowly its path takes them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cablewright.control.path_follower import TimedPath
from cablewright.foundation.arrays import Array
from cablewright.live.prints import limits
from cablewright.live.prints.body_corner_speeds import calmed, smoothed, swings, told
from cablewright.live.prints.plan import PrintOptions, plan_print, twin_of
from cablewright.live.prints.print_job import PrintedJob, print_job
from cablewright.machine.simulated.settings import whole_machine
from cablewright.models.inertia import mass_matrix
from cablewright.models.statics import Equilibrium, Model
from cablewright.printing.job import Job, load_job
from cablewright.robot import load
from cablewright.solvers.inverse import solve_inverse
from cablewright.solvers.linearise import linearise, tension_changes

ROBOT = load("cogiro")
LAG = 0.02  # s
CORNER = "G21\nG90\nM83\n;LAYER:0\nG0 X3150 Y1500 Z500\nG1 X3400 Y1500 E9\nG1 X3400 Y1750 E9\n"
TURN = [3.4, 1.5, 0.5]


@pytest.fixture(scope="module")
def held() -> Equilibrium:
    return solve_inverse(Model(ROBOT), np.array([[0.5, 0.3, 0.5, 0.0, 0.0, 0.0], [-2.0, 1.5, 1.0, 0.02, -0.03, 0.1]]))


def corner(folder: Path, **motion: object) -> Job:
    (folder / "corner.gcode").write_text(CORNER)
    text = 'schema = 1\nname = "corner"\ngcode = "corner.gcode"\n[bead]\nwidth = "60 mm"\nheight = "20 mm"\n'
    (folder / "corner.toml").write_text(text)
    job = load_job(folder / "corner.toml")
    limits: dict[str, object] = {"print_speed": 0.2, "travel_speed": 0.2, "acceleration": 0.5}
    limits |= {"corner_deviation": 0.02, "shaping": "none"}
    limits |= motion
    return job.model_copy(update={"motion": job.motion.model_copy(update=limits)})


def path_of(job: Job) -> tuple[TimedPath, TimedPath]:
    """Return the path of the job alone, and that of its print."""
    twin = twin_of(ROBOT, job, None, PrintOptions())
    return twin.path, plan_print(twin).path


@pytest.mark.parametrize("delay", [1e-3, 0.1, 0.5, 1.0, 3.0, 10.0])
def test_a_lag_smoothes_a_jump_of_speed_as_the_equation_of_motion_says(delay: float) -> None:
    def motion(t: float, state: Array) -> list[float]:
        return [state[1], -state[0] - np.exp(-t / delay) / delay]

    found = solve_ivp(motion, (0.0, 20.0), [0.0, 0.0], rtol=1e-10, atol=1e-12, max_step=0.01)
    assert smoothed(np.array(delay)) == pytest.approx(np.abs(found.y[0]).max(), rel=1e-3)
    assert smoothed(np.array(0.0)) == pytest.approx(1.0, abs=1e-3)


def test_no_tension_swings_further_after_a_jump_than_is_said_and_nearly_as_far(held: Equilibrium) -> None:
    jumps = np.array([[0.06, -0.06, 0.0, 0.0, 0.0, 0.0], [0.0, 0.05, 0.05, 0.02, 0.0, -0.01]])
    said = swings(held, jumps, LAG)
    stiffness, changes = linearise(held).stiffness, tension_changes(held).by_pose
    for k, mass in enumerate(mass_matrix(ROBOT, held.pose)):
        pull, inverse = 0.5 * (stiffness[k] + stiffness[k].T), np.linalg.inv(mass)

        def motion(t: float, state: Array, k: int = k, pull: Array = pull, inverse: Array = inverse) -> Array:
            follows = jumps[k] * np.exp(-t / LAG) / LAG
            return np.concatenate([state[6:], -inverse @ (pull @ state[:6]) - follows])

        times = np.linspace(0.0, 3.0, 3000)
        swung = solve_ivp(motion, (0.0, 3.0), np.zeros(12), t_eval=times, rtol=1e-8, atol=1e-12).y[:6]
        seen = np.abs(changes[k] @ swung).max(axis=1)
        assert (seen <= said[k] * (1.0 + 1e-6)).all()
        assert (seen >= 0.4 * said[k]).all()


def test_corners_and_acceleration_take_half_of_the_room_each(tmp_path: Path) -> None:
    job, printed = path_of(corner(tmp_path))
    assert printed.acceleration < job.acceleration
    turn = int(np.argmin(np.abs(printed.track.positions - TURN).sum(axis=1)))
    assert printed.speed[turn] < 0.3 * job.speed[turn]
    machine = whole_machine("cogiro").owner
    narrow = Model(ROBOT, tension_limits=(150.0, 4755.0))
    rest = solve_inverse(narrow, np.array([[*TURN, 0.0, 0.0, 0.0]]))
    jump = printed.speed[turn] * np.array([[-1.0, 1.0, 0.0, 0.0, 0.0, 0.0]])
    room = 0.5 * (rest.tensions - 100.0)
    assert (swings(rest, jump, machine.winch.lag) / room).max() == pytest.approx(1.0, rel=0.02)
    (sentence,) = told(job, printed)
    assert f"acceleration {printed.acceleration:.2g} m/s^2, job 0.5" in sentence


def test_a_path_that_is_slow_enough_stays_as_it_is(tmp_path: Path) -> None:
    slow = {"print_speed": 0.002, "travel_speed": 0.002, "acceleration": 0.01}
    job, printed = path_of(corner(tmp_path, **slow))
    np.testing.assert_array_equal(printed.arrival, job.arrival)
    assert told(job, printed) == ()


def test_without_room_the_nozzle_stops_in_corners_and_a_tenth_of_the_acceleration_is_left(tmp_path: Path) -> None:
    job, _ = path_of(corner(tmp_path))
    lines = tuple(line.model_copy(update={"tension_limits": (1e3, 5e3)}) for line in ROBOT.lines)
    path = calmed(Model(ROBOT.model_copy(update={"lines": lines})), Model(ROBOT), job, whole_machine("cogiro").owner)
    turn = int(np.argmin(np.abs(path.track.positions - TURN).sum(axis=1)))
    assert path.speed[turn] == pytest.approx(0.0, abs=1e-3)
    assert path.acceleration == pytest.approx(0.05)


def printed(folder: Path) -> PrintedJob:
    """A print through the corner, without a tour before it."""
    owner = whole_machine("cogiro").owner
    assert owner.body is not None
    machine = whole_machine("cogiro").with_owner(body=owner.body.model_copy(update={"tour": ()}))
    return print_job(ROBOT, corner(folder), folder / "run", machine=machine, options=PrintOptions(seed=5))


def test_tensions_stay_in_their_limits_through_a_corner_that_would_break_them(tmp_path: Path) -> None:
    calm = printed(tmp_path)
    assert calm.finished
    assert calm.record.whole.min_tension_margin > 0.0
    assert "slower for the sake of tensions" in calm.notes[0]


@pytest.mark.slow  # the premise of the test above
def test_the_corner_would_break_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(limits, "calmed", lambda _model, _narrow, path, _settings: replace(path))
    assert printed(tmp_path).record.whole.min_tension_margin < 0.0
