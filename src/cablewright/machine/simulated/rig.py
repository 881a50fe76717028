"""The true state of the simulated machine: lines, winches, drum, falling powder, deposited material and climate."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.arrays import Array
from cablewright.errors import InputError
from cablewright.kernels.plant import dynamics, machine_step, winding
from cablewright.kernels.rotation import matrix
from cablewright.kernels.statics.equilibrium import evaluate
from cablewright.machine.simulated.settings import ClimateLaw, TwinSettings, require_hanging
from cablewright.machine.simulated.snapshot import Archive
from cablewright.machine.simulated.surroundings import Ground
from cablewright.machine.simulated.winches import Winches
from cablewright.models.packed_views import PlatformNumbers, blank_states
from cablewright.models.statics import Model
from cablewright.robot import Robot
from cablewright.signals import Condition, Notice, Truth, frozen
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse

_DAY = 86400.0  # s
_MAX_FALLING = 0.03  # kg, deposited at once
_FLAG_CONDITIONS = (
    (winding.LIMITED, Condition.LIMITED),
    (winding.STALLED, Condition.STALLED),
    (winding.DRUM_END, Condition.DRUM_END),
)


@dataclass(frozen=True, eq=False)
class RigState:
    """Quantities of a rig that sensors measure, at one time."""

    truth: Truth
    acceleration: Array  # (6,) m/s^2 of B and rad/s^2 of the drum, world
    rotation: Array  # (3, 3) drum to world
    apparent_angles: Array  # (m,) rad, of the lines' tangents, by gravity plus their acceleration
    counts: NDArray[np.int64]  # (m,)
    temperature: float  # degrees Celsius
    humidity: float
    ground: Ground


class Rig:
    """The true robot, winches, drum and surroundings. Plants change its arrays in place."""

    def __init__(self, robot: Robot, settings: TwinSettings, start: ArrayLike, seed: int, along: Array) -> None:
        """Hang the drum of the true *robot* at rest at *start* (3,), m, with a random yaw.

        *settings* are those of the machine as built. *along* (m,): m, by which each accelerometer on a line is farther
        from B than they say.

        Raises `InputError` for a platform that is no point or lines without weight, `AnswerError` if there is no
        equilibrium at *start*.
        """
        owner, simulation = settings.owner, settings.simulation
        self.settings, self.seed, self.powder = settings, seed, owner.drum.powder
        _check(robot)
        self.robot = robot.model_copy(
            update={"platform": robot.platform.model_copy(update={"mass": self._mass, "loads": ()})}
        )
        model = Model(self.robot)
        self.lengths = solve_inverse(model, start).checked().lengths.copy()
        hung = solve_forward(model, self.lengths, guess=start).checked()
        self.winches = Winches(self.robot, owner.winch, simulation.winch, self.lengths, seed)
        shared = model.packed
        self.packed = shared._replace(lines=shared.lines.copy(), platform=shared.platform.copy())
        self.states = hung.states.copy()
        self.tensions = hung.tensions.copy()
        self.motion = np.zeros(dynamics.MOTION)
        self.motion[:3] = hung.pose
        self.acceleration = np.zeros(6)
        self.vibrations = np.zeros((robot.m, 2))
        line = simulation.line
        self.vibration = np.array([line.vibration_damping, line.vibration, robot.scene.gravity])
        self.winch_flags = np.zeros(robot.m, dtype=np.int64)
        self.work, self.swing = dynamics.moving_workspace(robot.m)
        evaluate(self.packed, self.lengths, self.motion[:3].copy(), self.states, self.work)  # for the lines' planes
        self.drum = drum_parameters(settings, self.powder)
        self.ground = Ground(robot, settings)
        self.falling_mass = 0.0  # kg, since `_fall_start`; not deposited yet
        self._fall_start = (0.0, 0.0)
        self._random = np.random.default_rng([seed, 2])
        self._last_position = self.motion[:3].copy()
        self.drum[dynamics.YAW_REST] = self.motion[8] = simulation.drum.yaw_wander * self._random.standard_normal()
        self._expansion = np.array([line.cable.thermal_expansion or 0.0 for line in robot.lines])
        self._scratch = blank_states()
        self._shown = np.zeros((robot.m, machine_step.SHOWS))
        sensor = owner.line_angles
        at = np.maximum(0.0, along + (0.0 if sensor is None else sensor.from_platform)).tolist()
        self._sensor_places = [(slice(i, i + 1), place) for i, place in enumerate(at)]  # m before B, by rows of lines
        if len(set(at)) == 1:
            self._sensor_places = [(slice(None), at[0])]

    @property
    def _mass(self) -> float:
        return self.settings.owner.drum.empty_mass + self.powder

    def advance_slowly(self, time: float, period: float, valve: float) -> list[Notice]:
        """Advance the slow processes by a *period* from *time*, s: powder, twist of the lines, thermal expansion."""
        notices = self._pour(period, valve)
        law, drum = self.settings.simulation.climate, self.settings.simulation.drum
        keep = math.exp(-math.dist(self.motion[:3], self._last_position) / drum.yaw_wander_length)
        self._last_position = self.motion[:3].copy()
        push = drum.yaw_wander * math.sqrt(1.0 - keep * keep)
        self.drum[dynamics.YAW_REST] = keep * self.drum[dynamics.YAW_REST] + push * self._random.standard_normal()
        temperature, _ = air_at(law, time)
        self.winches.set_thermal_strain(self._expansion * (temperature - law.temperature))
        return notices

    def take_notices(self) -> list[Notice]:
        """Return and clear the winches' notices since the last call."""
        if not self.winch_flags.any():
            return []
        notices = [
            Notice(condition, line.name)
            for flags, line in zip(self.winch_flags, self.robot.lines, strict=True)
            for bit, condition in _FLAG_CONDITIONS
            if flags & bit
        ]
        self.winch_flags[:] = 0
        return notices

    def observe(self, time: float) -> RigState:
        """Return the present state, at *time*, s."""
        self._show_lines()
        motion, rotation = self.motion, np.empty((3, 3))
        matrix(motion[6:9], rotation)
        temperature, humidity = air_at(self.settings.simulation.climate, time)
        truth = Truth(
            time,
            frozen(motion[0:3]),
            frozen(motion[3:6]),
            frozen(motion[6:9]),
            frozen(motion[9:12]),
            frozen(self.lengths),
            frozen(self._shown[:, machine_step.TENSION]),
            frozen(self.lengths - self._shown[:, machine_step.TAUT]),
            frozen(self.winches.leaving_radii),
            self.powder,
        )
        shown = self._shown[:, machine_step.SHOWN].copy()
        counts = self.winches.counts
        return RigState(truth, self.acceleration.copy(), rotation, shown, counts, temperature, humidity, self.ground)

    def _show_lines(self) -> None:
        """Compute what the lines show; line by line where their accelerometers are not all at one place."""
        for i, place in self._sensor_places:
            machine_step.show_lines(
                self.packed._replace(lines=self.packed.lines[i]),
                self.states[i],
                self.work.planes[i],
                self.acceleration,
                self.vibrations[i],
                self.vibration,
                place,
                self._scratch,
                self._shown[i],
            )

    def _pour(self, period: float, valve: float) -> list[Notice]:
        """Release powder through the valve; deposit it once the drum has moved by half a cell, or enough has fallen."""
        drum = self.settings.owner.drum
        released = drum.flow * valve * period
        if drum.capacity:
            released = min(self.powder, released)
        matrix(self.motion[6:9], self.work.rotation)
        down = self.work.rotation[:, 2]
        here = (float(self.motion[0] - drum.valve * down[0]), float(self.motion[1] - drum.valve * down[1]))
        moved = math.dist(here, self._fall_start)
        if self.falling_mass and (
            released <= 0.0 or moved > 0.5 * self.ground.field.cell or self.falling_mass > _MAX_FALLING
        ):
            self.ground.deposit(self._fall_start, here, self.falling_mass)
            self.falling_mass = 0.0
        if released <= 0.0:
            return [Notice(Condition.POWDER_OUT)] if valve > 0.0 and drum.flow > 0.0 else []
        if not self.falling_mass:
            self._fall_start = here
        self.falling_mass += released
        if drum.capacity:
            self.fill(self.powder - released)
        return []

    def archive_state(self, archive: Archive) -> None:
        """Save or load the rig's state."""
        self.powder = archive.number("powder", self.powder)
        self.falling_mass = archive.number("falling_mass", self.falling_mass)
        for name in ("lengths", "states", "tensions", "motion", "acceleration", "vibrations", "winch_flags", "drum"):
            archive.array(name, getattr(self, name))
        archive.array("platform", self.packed.platform)
        archive.array("last_position", self._last_position)
        x, y = self._fall_start
        self._fall_start = archive.number("fall_start_x", x), archive.number("fall_start_y", y)
        archive.scratch("work", self.work)
        archive.scratch("swing", self.swing)
        archive.random("random", self._random)
        self.winches.archive_state(archive.section("winches"))
        self.ground.archive_state(archive.section("ground"))

    def fill(self, powder: float) -> None:
        """Set the *powder*, kg, in the drum."""
        self.powder = powder
        yaw_rest = self.drum[dynamics.YAW_REST]
        self.drum = drum_parameters(self.settings, powder)
        self.drum[dynamics.YAW_REST] = yaw_rest
        PlatformNumbers(self.packed.platform).weight = self._mass * self.robot.scene.gravity


def drum_parameters(settings: TwinSettings, powder: float) -> Array:
    """Return the kernel's parameters (DRUM,) of the drum with *powder*, kg, in it."""
    drum, motion, numbers = settings.owner.drum, settings.simulation.drum, np.zeros(dynamics.DRUM)
    fill = powder / (drum.powder_density * math.pi * drum.radius**2)  # m, height of a cylinder
    depth = drum.powder_bottom - 0.5 * fill
    mass = drum.empty_mass + powder
    numbers[dynamics.MASS] = mass
    numbers[dynamics.CENTRE] = (drum.empty_mass * drum.empty_centre + powder * depth) / mass
    x, y, z = drum.empty_gyration
    about = powder * (drum.radius**2 / 4.0 + fill**2 / 12.0 + depth**2)
    numbers[dynamics.INERTIA] = drum.empty_mass * (x**2 + drum.empty_centre**2) + about
    numbers[dynamics.INERTIA + 1] = drum.empty_mass * (y**2 + drum.empty_centre**2) + about
    numbers[dynamics.INERTIA + 2] = drum.empty_mass * z**2 + 0.5 * powder * drum.radius**2
    numbers[dynamics.DRAG] = motion.drag
    numbers[dynamics.SWING_DAMPING], numbers[dynamics.YAW_DAMPING] = motion.swing_damping, motion.yaw_damping
    numbers[dynamics.YAW_STIFFNESS] = motion.yaw_stiffness
    numbers[dynamics.RELAXATION] = settings.simulation.line.relaxation
    return numbers


def air_at(law: ClimateLaw, time: float) -> tuple[float, float]:
    """Return temperature (degrees Celsius) and relative humidity at *time*, s; both begin at their means."""
    wave = math.sin(2.0 * math.pi * time / _DAY)
    return law.temperature + law.swing * wave, min(1.0, max(0.0, law.humidity - law.humidity_swing * wave))


def _check(robot: Robot) -> None:
    """Raise `InputError` for a robot that no plant can simulate."""
    if robot.n != 3:
        raise InputError(f"robot {robot.name!r}: only a point platform, from which a drum hangs, can be simulated")
    require_hanging(robot)
    for line in robot.lines:
        if any(line.platform_point):
            raise InputError(
                f"robot {robot.name!r}: platform_point of {line.name!r} must be the origin of the platform"
            )
