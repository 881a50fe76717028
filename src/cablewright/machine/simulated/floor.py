"""The floor below the simulated machine, with the deposited material."""

from __future__ import annotations

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.saved_state import Sparse
from cablewright.kernels.plant.lidar_rays import ray_to_floor
from cablewright.machine.simulated.deposition import Powder, extrude, pour
from cablewright.machine.simulated.settings import TwinSettings
from cablewright.printing.heightfield import HeightField
from cablewright.robot import Robot


class Ground:
    """The floor within a robot's frame and the material on it: powder at its angle of repose, or strands.

    Changes in place. Mass that falls outside the frame is counted, so that none is lost.
    """

    SAVED = (Sparse("field.heights"), "outside_mass", "_max_height")

    def __init__(self, robot: Robot, settings: TwinSettings) -> None:
        """Start with an empty floor."""
        low, high = robot.scene.frame_min, robot.scene.frame_max
        self.field = HeightField.flat(low[:2], high[:2], settings.simulation.room.cell)
        self.outside_mass = 0.0  # kg
        self._extrusion = settings.owner.extrusion
        self._powder = Powder(density=settings.owner.carrier.powder_density)
        self._max_height = 0.0

    def take_over(self, other: Ground) -> None:
        """Copy the material on an *other* ground of the same size."""
        self.field.heights[:] = other.field.heights
        self.outside_mass, self._max_height = other.outside_mass, other._max_height

    @property
    def density(self) -> float:
        """Density of the deposited material, kg/m^3."""
        return self._powder.density if self._extrusion is None else self._extrusion.density

    @property
    def mass(self) -> float:
        """Deposited mass, kg, with that outside the frame."""
        return self.field.volume * self.density + self.outside_mass

    @property
    def heights(self) -> Array:
        """Heights (nx, ny) of the ground at the grid's nodes, m."""
        return self.field.heights

    @property
    def grid(self) -> Array:
        """Grid of the ground's heights for a lidar: x and y of the first node, spacing, greatest height; m."""
        (x, y), cell = self.field.low, self.field.cell
        return np.array([x + 0.5 * cell, y + 0.5 * cell, cell, self._max_height])

    def distance(self, place: tuple[float, float, float], way: Array, most: float) -> float:
        """Return the distance from *place*, m, along the unit vector *way* (3,), to the ground; inf beyond *most*."""
        return float(ray_to_floor(*place, *way.tolist(), most, self.grid, self.heights))

    def deposit(self, start: tuple[float, float], end: tuple[float, float], mass: float) -> None:
        """Deposit *mass* (kg) evenly from *start* to *end*, m, world."""
        ends = np.array([start, end])
        if not self.field.holds(ends).all():
            self.outside_mass += mass
            return
        cells = self.field.cells_of(ends)
        if self._extrusion is None:
            pour(self.field, ends[:1], ends[1:], np.array([mass]), self._powder)
        else:
            extrude(self.field, ends[:1], ends[1:], np.array([mass / self.density]), self._extrusion.bead.width)
        near = (slice(max(0, low - 40), high + 41) for low, high in zip(cells.min(0), cells.max(0), strict=True))
        self._max_height = max(self._max_height, float(self.field.heights[tuple(near)].max()))
