"""The control of a rigid platform by kernels beside the same by solvers and numpy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cablewright as cw
from cablewright.control import velocity
from cablewright.control.path_follower import Target
from cablewright.control.stretch_damping import DampingLoop, StretchDamping, listen
from cablewright.control.velocity import VelocitySettings
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Estimate, SensorFrame, Tensions
from cablewright.models.statics import Model
from cablewright.solvers.inverse import solve_inverse

DT = 0.01
START = np.array([0.3, 0.1, 1.0, 0.01, 0.02, -0.01])
MODELS = {name: Model(cw.load(name)) for name in ("cogiro", "ipanema")}


def by_solvers(own: VelocitySettings) -> VelocitySettings:
    """The same settings, of a control that does not call the kernels."""
    other = replace(own)
    other.__dict__["row"] = None
    return other


def moving_to(pose: Array, rate: Array, pushed: Array) -> Target:
    return Target(pose[:3], rate[:3], 0.0, 0, 0.0, False, False, False, pose[3:], rate[3:], accelerations=pushed)


def estimated(model: Model, pose: Array, time: float) -> Estimate:
    m, lengths, nothing = model.m, solve_inverse(model, pose).lengths, np.zeros(3)
    return Estimate(
        time, pose[:3], nothing, pose[3:], lengths, np.zeros(m), np.zeros(m, np.bool_), np.full(m, 0.05), None, ()
    )  # fmt: skip


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("measured", ["all", "one unknown", "none"])
def test_speeds_are_those_by_the_solvers(name: str, measured: str) -> None:
    """Along a path, from the lines of the last step, also after a leap."""
    model, rng = MODELS[name], np.random.default_rng(len(measured))
    own = VelocitySettings(model, 1e3, "model", lag=0.05)
    other = by_solvers(own)
    ours, theirs = velocity.start(own), velocity.start(other)
    rate, pushed = np.array([0.3, 0.1, -0.05, 0.01, 0.0, 0.02]), np.array([[0.05, -0.02, 0.0], [0.04, -0.02, 0.01]])
    for step, shift in enumerate((0.0, 1.0, 2.0, 3.0, 60.0)):
        pose = START + DT * shift * rate
        target = moving_to(pose, rate, pushed)
        seen = estimated(model, pose + 1e-3 * rng.normal(size=6), step * DT)
        tensions = None if measured == "none" else 150.0 + 20.0 * rng.normal(size=model.m)
        if tensions is not None and measured != "all":
            tensions[1] = np.nan
        found = velocity.step(own, ours, seen, target, DT, tensions)
        assert found == pytest.approx(velocity.step(other, theirs, seen, target, DT, tensions), rel=1e-6, abs=1e-8)
        assert ours.chosen == pytest.approx(theirs.chosen, rel=1e-7)
        assert ours.tension_error == pytest.approx(theirs.tension_error, rel=1e-6)
        assert found.any() == (measured != "one unknown")
        assert ours.known == 1
        assert theirs.known == 0


@pytest.mark.parametrize("pushed", [0.0, 0.05])
def test_swings_are_damped_as_by_the_solvers(pushed: float) -> None:
    robot = cw.load("cogiro")
    cables = [line.cable.model_copy(update={"young_modulus": 0.003 * line.cable.young_modulus}) for line in robot.lines]
    soft = [line.model_copy(update={"cable": cable}) for line, cable in zip(robot.lines, cables, strict=True)]
    model = Model(robot.model_copy(update={"lines": tuple(soft)}))
    damped = StretchDamping("load_cells", DampingLoop(late=0.02, lag=0.05, gain=0.5))
    own = VelocitySettings(model, 1e3, "model", lag=0.05, stretch=damped)
    other = by_solvers(own)
    states, found = [velocity.start(each) for each in (own, other)], []
    held = solve_inverse(model, START).tensions
    for step in range(60):
        shown = held * (1.0 + 0.05 * np.sin(2.0 * np.pi * 1.0 * step * DT))
        frame = SensorFrame(step * DT, (Tensions("load_cells", step * DT, shown),), ())
        target = moving_to(START, np.zeros(6), np.full((2, 3), pushed))
        seen = estimated(model, START, step * DT)
        for settings, state in zip((own, other), states, strict=True):
            listen(damped, state.stretch, frame)
            found.append(velocity.step(settings, state, seen, target, DT, shown))
    assert np.array(found[::2]) == pytest.approx(np.array(found[1::2]), rel=1e-6, abs=1e-8)
    undamped = replace(own, stretch=None)
    still = velocity.step(undamped, velocity.start(undamped), seen, target, DT, shown)
    assert np.abs(found[-1] - still).max() > 1e-3


def test_a_pose_that_no_tensions_hold_is_left_to_the_solvers() -> None:
    model = MODELS["cogiro"]
    own = VelocitySettings(model, 1e3, "model")
    other, far = by_solvers(own), START + np.array([60.0, 0.0, 30.0, 0.0, 0.0, 0.0])
    seen, target = estimated(model, START, 0.0), moving_to(far, np.zeros(6), np.zeros((2, 3)))
    ours, theirs = velocity.start(own), velocity.start(other)
    found = velocity.step(own, ours, seen, target, DT, np.full(model.m, 100.0))
    assert ours.known == 0
    assert np.array_equal(found, velocity.step(other, theirs, seen, target, DT, np.full(model.m, 100.0)))
