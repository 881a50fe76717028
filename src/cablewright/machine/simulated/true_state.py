"""The true state of the simulated machine: lines, winches, platform, falling and laid powder, climate.

What sensors measure is computed from it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Condition, Notice, Truth, WinchMode
from cablewright.kernels import Direct
from cablewright.kernels.layout import PLATFORM_WEIGHT
from cablewright.kernels.plant import dynamics, machine_step, retracting_platform, winding
from cablewright.kernels.statics.equilibrium import evaluate
from cablewright.kernels.statics.line.interface import place_lines
from cablewright.machine.drives.settings import FOLLOWING_ERROR
from cablewright.machine.sensors.line_angles import LINE_ANGLES
from cablewright.machine.simulated.as_built_parts import home_errors
from cablewright.machine.simulated.floor import Ground
from cablewright.machine.simulated.plant_parts.line_faults import LineFaults
from cablewright.machine.simulated.plant_parts.load_mass import Masses
from cablewright.machine.simulated.plant_parts.retraction_drive import RetractionAxis
from cablewright.machine.simulated.plant_parts.yaw_axis import YawAxis
from cablewright.machine.simulated.settings import ClimateLaw, TwinSettings
from cablewright.machine.simulated.unmodelled.brakes import Brakes
from cablewright.machine.simulated.unmodelled.stuck_material import StuckMaterial
from cablewright.machine.simulated.unmodelled.unmodelled import Unmodelled, softness
from cablewright.machine.simulated.winches import Winches
from cablewright.models.climate_and_creep import Air
from cablewright.models.free_coordinates import with_free
from cablewright.models.packed_views import LineStates, PlatformNumbers, blank_states
from cablewright.models.statics import Model
from cablewright.models.support_table import Capability, require
from cablewright.robot import RigidPlatform, Robot
from cablewright.solvers.forward import solve_forward
from cablewright.solvers.inverse import solve_inverse

_DAY = 86400.0  # s
_MAX_FALLING = 0.03  # kg, deposited in one step
_FLAG_CONDITIONS = (
    (winding.LIMITED, Condition.LIMITED),
    (winding.STALLED, Condition.STALLED),
    (winding.DRUM_END, Condition.DRUM_END),
)


class RigState(NamedTuple):
    """Quantities of a rig that sensors measure, at one *time*, s."""

    time: float
    truth: Truth
    told: Array  # all numbers of motion and lines, see `machine_step.observe`; do not change
    acceleration: Array  # (6,) m/s^2 of B and rad/s^2 of the drum or body, world
    rotation: Array  # (3, 3) drum or body to world
    counts: NDArray[np.int64]  # (w,)
    temperature: float  # degrees Celsius
    humidity: float
    ground: Ground
    yaw: float  # rad, of the drive that turns a drum

    def of_lines(self, which: int) -> Array:
        """Return the numbers (m,) of all lines that are *which* of those of each, see `machine_step.ANGLES`."""
        m = len(self.truth.lengths)
        return self.told[machine_step.LINES + which * m : machine_step.LINES + (which + 1) * m]


class Rig:
    """The true robot, winches, platform and surroundings. Plants change its arrays in place."""

    SAVED: tuple[str, ...] = (
        "powder",
        "falling_mass",
        "lengths",
        "states",
        "tensions",
        "motion",
        "acceleration",
        "vibrations",
        "winch_flags",
        "body",
        "packed.lines",
        "packed.platform",
        "retraction",
        "yaw",
        "line_faults",
        "unmodelled",
        "_last_position",
        "_fall_start",
        "work.planes",
        "swing.ends",
        "_random",
        "winches",
        "brakes",
        "stuck",
        "ground",
    )

    def __init__(self, robot: Robot, settings: TwinSettings, start: ArrayLike, seed: int, along: Array) -> None:
        """Hang the drum of the true *robot* at rest at *start* (3,), m, with a random yaw; or its body at a pose (6,).

        *settings* are those of the machine as built. *along* (m,): m, by which each accelerometer on a line is farther
        from B than they say.

        Raises `InputError` for lines without weight, or a machine of another kind of platform, `AnswerError` if there
        is no equilibrium at *start*.
        """
        owner, simulation = settings.owner, settings.simulation
        self.settings, self.seed, self.powder = settings, seed, owner.carrier.powder
        require(robot, Capability.SIMULATION)
        self.masses, self.retraction = Masses(robot, settings), RetractionAxis(robot, owner.retraction)
        self.yaw = YawAxis(None if owner.drum is None else owner.drum.yaw_drive)
        law = simulation.sticking
        self.stuck = StuckMaterial(law) if law.share else None
        self.body = self.masses.constant()
        self.masses.put(self.powder, 0.0, self.retraction.length, self.body)
        self.robot = self._filled(robot)
        model, place = Model(self.robot), start_pose(robot, start)
        held = solve_inverse(model, place).checked()
        self.lengths = held.lengths + home_errors(simulation.tolerances, seed, robot.m)
        hung = solve_forward(model, self.lengths, guess=held.pose).checked()
        self.winches = Winches(self.robot, owner.winch, simulation.winch, self.lengths, seed)
        shared = model.packed
        self.packed = shared._replace(lines=shared.lines.copy(), platform=shared.platform.copy())
        self.states, pose = hung.states.copy(), hung.pose.copy()
        self.work, self.swing = dynamics.moving_workspace(self.packed)
        evaluate(self.packed, self.lengths, pose, self.states, self.work)  # for the lines' planes
        self.unmodelled = Unmodelled(robot, simulation, self.packed, self.states, pose[:3], self.winches, seed)
        self.brakes = _brakes_of(robot, settings, seed)
        self._let_exits_give(pose)
        self.swing.place[:] = pose
        self.tensions = hung.tensions.copy() if self.unmodelled.exits is None else LineStates(self.states).tension
        self.motion = np.zeros(dynamics.MOTION)
        self.motion[:3] = pose[:3]
        self.motion[6 : 3 + robot.n] = pose[3:]
        self.acceleration = np.zeros(6)
        self.vibrations = np.zeros((robot.m, 2))
        line = simulation.line
        self.vibration = np.array([line.vibration_damping, line.vibration, robot.scene.gravity])
        self.winch_flags = np.zeros(robot.m, dtype=np.int64)
        self.line_faults = LineFaults(robot, simulation.faults)
        self.ground = Ground(robot, settings)
        self.falling_mass = 0.0  # kg, since `_fall_start`; not deposited yet
        self._fall_start = (0.0, 0.0)
        self._random = np.random.default_rng([seed, 2])
        self._last_position = self.motion[:3].copy()
        twist = simulation.drum if robot.platform.plane is None else None  # no point turns in its plane
        self._twist = np.zeros(0)
        if twist is not None:
            self._twist = np.array([twist.yaw_wander, twist.yaw_wander_length])
            yaw = twist.yaw_wander * self._random.standard_normal()
            self.body[dynamics.YAW_REST] = self.motion[8] = yaw
        self._expansion = np.array([line.cable.thermal_expansion or 0.0 for line in robot.lines])
        self._turned, self._drift = np.empty((3, 3)), Direct(machine_step.drift)
        self._scratch = blank_states()
        if robot.hung:
            self.SAVED = (*Rig.SAVED, "swing.weights")
        self._shown = np.zeros((robot.m, machine_step.SHOWS))
        self._air, self._carrier = (math.nan, (0.0, 0.0)), owner.carrier
        self._drives = self.retraction.has_drive or self.yaw.has_drive
        self._observe = Direct(machine_step.observe)
        self._told = machine_step.LINES + machine_step.OF_EACH * robot.m
        sensor = owner.sensor(LINE_ANGLES)
        self._sensors_at = np.maximum(0.0, along + (0.0 if sensor is None else sensor.from_platform))  # m before B
        self._upright = np.array([line.has_upright_swivel for line in robot.lines])

    def after_load(self) -> None:
        """After a snapshot was loaded, place the lines at the platform again, in the planes of the last step."""
        planes = self.work.planes.copy()
        self.swing.place[:] = self.pose
        place_lines(self.packed, self.swing.place, self.work)
        self.work.planes[:] = planes

    def _let_exits_give(self, pose: Array) -> None:
        """Displace exit points at the start, updating *pose* (n,).

        Raises `InputError` for a platform that nothing holds.
        """
        exits, ratio, whole = self.unmodelled.exits, self.unmodelled.ratio, np.arange(self.robot.m)
        if exits is None:
            return
        if exits.close(self.packed, whole, self.lengths, pose, self.states, ratio, self.work) != 0:
            raise InputError(f"exits.compliance: robot {self.robot.name!r} has no equilibrium with compliant mounts")

    def _filled(self, robot: Robot) -> Robot:
        """*robot* with the mass of the machine's drum or body, and of a body its centre of mass."""
        update: dict[str, object] = {"mass": float(self.body[dynamics.MASS]), "loads": ()}
        if isinstance(robot.platform, RigidPlatform):
            update["centre_of_mass"] = tuple(self.body[dynamics.CENTRE : dynamics.CENTRE + 3].tolist())
        return robot.with_platform(**update)

    @property
    def pose(self) -> Array:
        """The platform's pose (n,), m and rad."""
        return self.motion[[0, 1, 2, 6, 7, 8][: self.robot.n]]

    def advance_slowly(self, time: float, period: float, valve: float) -> list[Notice]:
        """Advance the slow processes by a *period* from *time*, s: material, twist of the lines, thermal expansion.

        Faults of lines that are due begin.
        """
        self.line_faults.begin(time, self.packed.lines, self.states)
        warmer = self._air_at(time)[0] - self.settings.simulation.climate.temperature
        twists = len(self._twist) > 0
        moved = math.dist(self.motion[:3].tolist(), self._last_position.tolist()) if twists else 0.0
        x, y, rest = self._drift.call(
            self.motion, self._last_position, self._twist, moved,
            self._random.standard_normal() if twists else 0.0, self.yaw.angle, self.body,
            self._expansion * warmer + self.unmodelled.strain, self.winches.state, self.masses.nozzle, self._turned,
        )  # fmt: skip
        if self.yaw.has_drive and twists:
            self._turn_yaw(period, rest)
        notices = self._pour(period, valve, (x, y))
        if self.retraction.has_drive and self.retraction.drive.beam[retracting_platform.MOVING_MASS]:
            self._weigh()
        return notices

    def _turn_yaw(self, period: float, rest: float) -> None:
        """Turn a drum by its drive for a *period*, s, from the yaw *rest*, rad, at which its lines are not twisted."""
        x, y = self._turned[:2, 0].tolist()
        self.yaw.turn(period, rest - math.atan2(y, x), self.body[dynamics.YAW_STIFFNESS])
        self.body[dynamics.YAW_REST] = rest + self.yaw.angle

    def advance_unmodelled(self, time: float, period: float) -> None:
        """Advance creep, friction and other unmodelled effects by the *period*, s, since *time*, s."""
        place, air, planes = self.motion[:3], Air(*self._air_at(time)), self.work.planes
        self.unmodelled.advance(self.packed, self.states, planes, self.winches, place, period, air)

    def _air_at(self, time: float) -> tuple[float, float]:
        """Temperature, degrees Celsius, and relative humidity at *time*, s."""
        if self._air[0] != time:
            self._air = time, air_at(self.settings.simulation.climate, time)
        return self._air[1]

    def brake(self, modes: Sequence[WinchMode], reset: bool) -> None:
        """Close the brakes of winches whose *modes* are `OFF`, and open others; *reset*: reported slip is cleared."""
        if self.brakes is None:
            return
        if reset:
            self.brakes.forget(self.winches)
        closed = np.array([mode is WinchMode.OFF for mode in modes] or [False] * self.robot.winches)
        self.brakes.close(self.winches.by_line(closed), self.winches, softness(self.packed, self.states))

    def take_notices(self) -> list[Notice]:
        """Return the notices of winches, brakes, retraction, yaw and plane since the last call."""
        notices = [*self.retraction.take_notices(), *self.yaw.take_notices()] if self._drives else []
        if self.brakes is not None:
            notices += self.brakes.notices(self.winches)
        if self.robot.platform.may_lift and self.swing.on_plane[1] > 0.0:
            notices.append(Notice(Condition.OFF_PLANE))
        self.swing.on_plane[1] = -math.inf
        if not any(self.winch_flags.tolist()):
            return notices
        notices += [
            Notice(condition, line.name)
            for flags, line in zip(self.winch_flags, self.robot.lines, strict=True)
            for bit, condition in _FLAG_CONDITIONS
            if flags & bit
        ]
        self.winch_flags[:] = 0
        return notices

    def observe(self, time: float) -> RigState:
        """Return the present quantities that sensors measure, at *time*, s."""
        told, rotation, winches = np.empty(self._told), np.empty((3, 3)), self.winches
        counts = np.empty(len(winches.lines.hosts), np.int64)
        self._observe.call(
            self.packed, self.states, self.swing.place, self.work, self.swing.ends, self.vibrations, self.vibration,
            self._sensors_at, self._scratch, self._shown, self.motion, self.lengths, winches.state, winches.radii,
            self.unmodelled.ratio, self._upright, winches.lines.hosts, winches.start_angles, winches.counts_per_turn,
            told, rotation, counts,
        )  # fmt: skip
        shown = told[:]  # kernels take the numbers from the other array, which is not read-only
        shown.flags.writeable = False
        place, velocity, turned, rate = shown[: machine_step.LINES].reshape(4, 3)
        lengths, tensions, excess, radii, *_ = shown[machine_step.LINES :].reshape(machine_step.OF_EACH, -1)
        own = lengths, tensions, excess, radii, self.powder, self.retraction.length
        truth, acceleration = Truth(time, place, velocity, turned, rate, *own), self.acceleration.copy()
        return RigState(
            time, truth, told, acceleration, rotation, counts, *self._air_at(time), self.ground, self.yaw.angle
        )

    def _pour(self, period: float, valve: float, here: tuple[float, float]) -> list[Notice]:
        """Release powder through the valve with the nozzle *here* in plan view, m, world.

        It is deposited once the nozzle has moved by half a cell, or enough has fallen.
        """
        carrier = self._carrier
        released = carrier.flow * valve * period
        if carrier.capacity:
            released = min(self.powder, released)
        if self.falling_mass and (
            released <= 0.0
            or math.dist(here, self._fall_start) > 0.5 * self.ground.field.cell
            or self.falling_mass > _MAX_FALLING
        ):
            self.ground.deposit(self._fall_start, here, self.falling_mass)
            self.falling_mass = 0.0
        if released <= 0.0:
            return [Notice(Condition.POWDER_OUT)] if valve > 0.0 and carrier.flow > 0.0 else []
        if not self.falling_mass:
            self._fall_start = here
        self.falling_mass += released if self.stuck is None else self.stuck.passed(released)
        if carrier.capacity:
            self.fill(self.powder - released)
        elif self.stuck is not None:
            self._weigh()
        return []

    def fill(self, powder: float) -> None:
        """Set the *powder*, kg, in the container or hopper."""
        self.powder = powder
        self._weigh()

    def _weigh(self) -> None:
        """Set mass, centre and inertia by the content and the length of the platform."""
        stuck = 0.0 if self.stuck is None else self.stuck.mass
        self.masses.put(self.powder, stuck, self.retraction.length, self.body)
        self.packed.platform[PLATFORM_WEIGHT] = self.body[dynamics.MASS] * self.vibration[machine_step.GRAVITY]
        if self.robot.n == 6:
            PlatformNumbers(self.packed.platform).centre_of_mass = self.body[dynamics.CENTRE : dynamics.CENTRE + 3]


def start_pose(robot: Robot, start: ArrayLike) -> Array:
    """Return the start pose (n,) of a machine of *robot*; of a body (3,) is a position without rotation.

    With fewer winches than degrees of freedom, NaN marks coordinates that equilibrium decides. Raises `InputError` for
    any other size.
    """
    given = np.array(start, dtype=np.float64)
    if robot.n == 6 and given.shape in {(3,), (6,)}:
        pose = np.zeros(6)
        pose[: len(given)] = given
        return with_free(robot, pose)
    if given.shape != (robot.n,):
        asked = f"{robot.platform.pose_sizes} numbers are expected, a pose of robot {robot.name!r}"
        raise InputError(f"start = {given.tolist()}: {asked}")
    return given


def air_at(law: ClimateLaw, time: float) -> tuple[float, float]:
    """Return temperature (degrees Celsius) and relative humidity of the room at *time*, s.

    Both begin at their means.
    """
    wave = math.sin(2.0 * math.pi * time / _DAY)
    humidity = min(1.0, max(0.0, law.humidity - law.humidity_swing * wave))
    return law.temperature + law.swing * wave, humidity


def _brakes_of(robot: Robot, settings: TwinSettings, seed: int) -> Brakes | None:
    """The brakes of a machine; None where they hold whatever pulls."""
    law, drives = settings.simulation.brakes, settings.owner.drives
    limit = FOLLOWING_ERROR if drives is None else drives.following_error
    return Brakes(law, tuple(line.name for line in robot.lines), seed, limit) if law.give else None
