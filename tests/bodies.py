"""A small plant of a rigid platform for tests: from equilibrium to equilibrium, with errors that no estimator
receives."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from cablewright.estimation.body.settings import BodySettings, Deviations
from cablewright.estimation.body.updates.cells import Cells
from cablewright.estimation.body.updates.tilt import Tilt
from cablewright.foundation.arrays import Array
from cablewright.foundation.signals import Encoders, Inertial, SensorFrame, Tensions
from cablewright.machine.simulated.as_built import as_built
from cablewright.machine.simulated.settings import Tolerances
from cablewright.models.coil import wind
from cablewright.models.rotation import matrices
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.solvers.continuation import Tracker, TrackerSettings
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse

COUNTS = 4096 * 20 / math.tau
COIL = wind(40.0, 0.08, 0.3, 0.004, 0.004)
HELD = 30.0
CELLS = Cells("load_cells", 3.0, 3.0, 5e-3)
TILT = Tilt(0.02, 0.01, 1e-3)


@dataclass(frozen=True)
class Errors:
    """Of the plant: normal sigmas of exit points, m; the others uniform, +-."""

    exit_point: float = 1e-3
    modulus: float = 0.02
    home: float = 3e-3
    radius: float = 5e-3


@dataclass
class BodyPlant:
    """A true robot; ``faults`` changes it: by line, m of cable that its encoder does not show."""

    robot: Robot
    pose: Array
    seed: int
    errors: Errors = field(default_factory=Errors)
    time: float = 0.0

    def __post_init__(self) -> None:
        random = np.random.default_rng(self.seed)
        e, m = self.errors, self.robot.m
        built = as_built(self.robot, Tolerances(anchor=e.exit_point, modulus=e.modulus, sheave_radius=0.0), self.seed)
        self.model = Model(built)
        self.random = random
        self.home = solve_inverse(self.model, self.pose).checked().lengths + random.uniform(-e.home, e.home, m)
        self.scale = 1.0 + random.uniform(-e.radius, e.radius, m)
        self.gain, self.zero = 1.0 + CELLS.gain * random.standard_normal(m), CELLS.zero * random.standard_normal(m)
        self.tilt = math.hypot(TILT.turn, TILT.bias / 9.81) * random.standard_normal(2)
        self.turned = np.zeros(m)  # rad, paid out
        self.counted = np.zeros(m)  # rad that the encoders show too much
        self.slipped = np.zeros(m)  # m of cable beyond what is shown
        nominal = solve_inverse(Model(self.robot), self.pose).checked().lengths
        self.wound = np.array([COIL.angle(HELD - out) for out in nominal])
        near = solve_forward(self.model, self.home, guess=self.pose).checked()
        self.tracker = Tracker(self.model, self.home, TrackerSettings(certify=False), begin=near)
        self.cut: int | None = None
        self.cell_offset = np.zeros(m)

    @property
    def truth(self) -> tuple[Array, Array]:
        """True pose and tensions."""
        tensions = np.exp(self.tracker.states[:, 1])
        return self.tracker.pose, tensions

    def lengths(self) -> Array:
        """True unstrained lengths."""
        paid = [COIL.length(w) - COIL.length(w - a) for w, a in zip(self.wound, self.turned, strict=True)]
        out = self.home + self.scale * np.array(paid) + self.slipped
        if self.cut is not None:
            out[self.cut] += 3.0
        return out

    def step(self, speeds: Array, dt: float) -> SensorFrame:
        """Turn the winches, and return the readings."""
        self.turned = self.turned + speeds * dt
        self.time += dt
        lengths = self.lengths()
        if self.tracker.step(lengths).word != "ok":
            assert self.tracker.restart(lengths)
        pose, tensions = self.truth
        counts = np.round((self.turned + self.counted) * COUNTS).astype(np.int64)
        m = len(counts)
        shown = self.gain * tensions + self.zero + CELLS.deviation * self.random.standard_normal(m) + self.cell_offset
        force = matrices(pose[3:])[2] * 9.81 + TILT.deviation * self.random.standard_normal(3)
        force[:2] += 9.81 * self.tilt
        readings = (
            Encoders(self.time, counts),
            Tensions("load_cells", self.time, shown),
            Inertial(self.time, force, np.zeros(3)),
        )
        return SensorFrame(self.time, readings)


def told(robot: Robot, *, cells: bool = True, tilt: bool = True) -> BodySettings:
    """Settings of its estimator: the description and sigmas, without creep and compliance."""
    return BodySettings(
        Model(robot),
        COUNTS,
        (COIL,) * robot.m,
        HELD,
        30.0,
        Deviations(
            home_length=3e-3 / math.sqrt(3.0),
            drum_radius=5e-3 / math.sqrt(3.0),
            exit_point=1e-3,
            creep=1e-6,
            hysteresis=1e-6,
            exit_compliance=1e-9,
        ),
        (CELLS,) * cells + (TILT,) * tilt,
    )
