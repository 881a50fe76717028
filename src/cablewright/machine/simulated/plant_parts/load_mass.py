"""Mass, centre and inertia of the load on the lines: a container on a point platform, or a rigid body."""

from __future__ import annotations

import math

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.kernels.plant import dynamics
from cablewright.machine.carried_load import Body, Drum
from cablewright.machine.simulated.settings import TwinSettings
from cablewright.robot import RigidPlatform, Robot


class Masses:
    """Mass, centre of mass and inertia of a simulated platform, which change with the powder in it."""

    def __init__(self, robot: Robot, settings: TwinSettings) -> None:
        """Take the machine as built. Raises `InputError` where robot and machine do not fit, or inertia is unknown."""
        platform, owner = robot.platform, settings.owner
        self._settings, self._platform, self._inertia = settings, platform, np.zeros((3, 3))
        self._at: tuple[float, Array, Array] | None = None  # length, m, and what `_bare` returns there
        if isinstance(platform, RigidPlatform) != (owner.body is not None):
            given, asked = ("[drum]", "[body]") if owner.body is None else ("[body]", "[drum]")
            what = "rigid platform" if owner.body is None else "point platform"
            raise InputError(
                f"machine {owner.name!r}: it has {given}, and robot {robot.name!r}, with a {what}, needs {asked}"
            )
        if owner.body is not None:
            assert isinstance(platform, RigidPlatform)  # as just checked
            self._inertia = _inertia(robot.name, platform, owner.body)
            self.nozzle = np.array(platform.nozzle)
        else:
            self.nozzle = np.array([0.0, 0.0, -owner.point_drum.valve])

    def total(self, powder: float, stuck: float) -> float:
        """Mass of the platform, kg, with its *powder*, kg, and the material *stuck* to the nozzle, kg."""
        return self._settings.owner.carrier.empty_mass + powder + stuck

    def put(self, powder: float, stuck: float, length: float, numbers: Array) -> None:
        """Write mass, centre and inertia for the masses of `total`, at the *length*, m, of a retraction.

        *numbers* (BODY,) of the kernel: others of them stay.
        """
        if self._settings.simulation.drum is not None:
            _put_drum(self._settings.owner.point_drum, powder, stuck, numbers)
        else:
            self._put_body(powder, stuck, length, numbers)

    def constant(self) -> Array:
        """Return the kernel's numbers (BODY,), of which those that `put` does not write do not change."""
        simulation, numbers = self._settings.simulation, np.zeros(dynamics.BODY)
        if simulation.drum is not None:
            numbers[dynamics.DRAG] = simulation.drum.drag
            numbers[dynamics.SWING_DAMPING] = simulation.drum.swing_damping
            numbers[dynamics.YAW_DAMPING] = simulation.drum.yaw_damping
            numbers[dynamics.YAW_STIFFNESS] = simulation.drum.yaw_stiffness
        else:
            assert simulation.body is not None  # as validated
            numbers[dynamics.DRAG] = simulation.body.drag
            numbers[dynamics.SWING_DAMPING] = numbers[dynamics.YAW_DAMPING] = simulation.body.turn_damping
        numbers[dynamics.RELAXATION] = simulation.line.relaxation
        return numbers

    def _put_body(self, powder: float, stuck: float, length: float, numbers: Array) -> None:
        """Write mass, centre and inertia of a rigid platform with its content."""
        body, (moment, about) = self._settings.owner.body, self._bare(length)
        assert body is not None  # as checked
        moment, about = moment.copy(), about.copy()
        if powder:
            fill = body.fill_height(powder)
            centre = np.array(body.hopper) + np.array([0.0, 0.0, 0.5 * fill])
            across = powder * (body.radius**2 / 4.0 + fill**2 / 12.0)
            about += np.diag([across, across, 0.5 * powder * body.radius**2]) + powder * _spread(centre)
            moment += powder * centre
        if stuck:
            about += stuck * _spread(self.nozzle)
            moment += stuck * self.nozzle
        mass = self.total(powder, stuck)
        numbers[dynamics.MASS] = mass
        numbers[dynamics.CENTRE : dynamics.CENTRE + 3] = moment / mass
        numbers[dynamics.INERTIA : dynamics.INERTIA + 9] = about.ravel()

    def _bare(self, length: float) -> tuple[Array, Array]:
        """Return moment (3,), kg m, and inertia (3, 3), kg m^2, of a rigid platform without material."""
        if self._at is not None and (self._at[0] == length or math.isnan(length)):
            return self._at[1:]
        owner, platform = self._settings.owner, self._platform
        assert isinstance(platform, RigidPlatform)
        assert owner.body is not None
        body, drive, own = owner.body, owner.retraction, np.array(platform.centre_of_mass)
        about = self._inertia + body.empty_mass * _spread(own)
        moment = body.empty_mass * own  # kg m
        if drive is not None and drive.moving_mass and platform.retraction is not None:
            assert drive.length is not None  # as validated
            was = np.array(drive.moving_centre)
            now = was + (length - drive.length) * np.array(platform.retraction.along)
            about += drive.moving_mass * (_spread(now) - _spread(was))
            moment += drive.moving_mass * (now - was)
        self._at = length, moment, about
        return moment, about


def _put_drum(drum: Drum, powder: float, stuck: float, numbers: Array) -> None:
    """Write mass, centre and inertia of a drum with *powder*, kg, in it, and *stuck*, kg, to its valve."""
    fill = drum.fill_height(powder)  # m, of a cylinder
    depth = drum.powder_bottom - 0.5 * fill
    mass = drum.empty_mass + powder + stuck
    numbers[dynamics.MASS] = mass
    numbers[dynamics.CENTRE + 2] = -((drum.empty_mass * drum.empty_centre + powder * depth + stuck * drum.valve) / mass)
    x, y, z = drum.empty_gyration
    about = powder * (drum.radius**2 / 4.0 + fill**2 / 12.0 + depth**2) + stuck * drum.valve**2
    numbers[dynamics.INERTIA] = drum.empty_mass * (x**2 + drum.empty_centre**2) + about
    numbers[dynamics.INERTIA + 4] = drum.empty_mass * (y**2 + drum.empty_centre**2) + about
    numbers[dynamics.INERTIA + 8] = drum.empty_mass * z**2 + 0.5 * powder * drum.radius**2


def _inertia(name: str, platform: RigidPlatform, body: Body) -> Array:
    """Inertia tensor (3, 3) of the empty body about its centre of mass, kg m^2."""
    if platform.inertia is None:
        if body.gyration is None:
            raise InputError(f"robot {name!r} has no platform.inertia; give body.gyration in the machine file")
        return np.diag(body.empty_mass * np.square(body.gyration))
    (xx, yy, zz), (xy, xz, yz) = platform.inertia, platform.inertia_products
    return body.empty_mass / platform.mass * np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _spread(place: Array) -> Array:
    """Inertia tensor (3, 3), m^2, of a mass of 1 kg at *place* (3,), m."""
    return np.asarray(place @ place * np.eye(3) - np.outer(place, place))
