"""All of it on one rig, advanced at the end of each step of the machine for the next one; see `docs/machine.md`."""

from __future__ import annotations

import numpy as np

from cablewright.arrays import Array
from cablewright.errors import UnknownName
from cablewright.kernels.layout import Packed
from cablewright.machine.simulated.as_built_parts import CREEP, WIND, drawn
from cablewright.machine.simulated.settings import SimulationSettings
from cablewright.machine.simulated.snapshot import Archive
from cablewright.machine.simulated.unmodelled.cable_creep import CableCreep
from cablewright.machine.simulated.unmodelled.cable_hysteresis import CableHysteresis
from cablewright.machine.simulated.unmodelled.exit_mounts import ExitMountState
from cablewright.machine.simulated.unmodelled.gear_backlash import GearBacklash
from cablewright.machine.simulated.unmodelled.gusts import Gusts
from cablewright.machine.simulated.unmodelled.sheave_slip import SheaveSlip
from cablewright.machine.simulated.winches import Winches
from cablewright.models.creep import memory_of
from cablewright.models.packed_views import LineNumbers, LineStates, PlatformNumbers
from cablewright.robot import Robot


class Unmodelled:
    """What acts on a rig and is in no model of it; parts that are 0 are None.

    The reference load of all cables is the mean of the lines' tensions at the start.
    """

    def __init__(
        self, robot: Robot, simulation: SimulationSettings, packed: Packed, states: Array, winches: Winches, seed: int
    ) -> None:
        """Begin with a machine at rest by *states* (m, 6), without any of it. Raises `UnknownName` for a line."""
        names = tuple(line.name for line in robot.lines)
        for name in simulation.exits.by_line:
            if name not in names:
                raise UnknownName("line", name, names)
        tensions, cable = LineStates(states).tension, simulation.cable
        reference = float(tensions.mean())
        uneven = 1.0 + cable.creep_spread * drawn(seed, CREEP).uniform(-1.0, 1.0, robot.m)
        elastic = LineNumbers(packed.lines).free_compliance
        compliance, gears, wind = simulation.exits.matrices(names), simulation.gears, simulation.wind
        unknown = CableCreep(cable.creep * uneven / reference) if cable.creep else None
        creeps = {"creep": unknown, "described_creep": memory_of([line.cable.creep for line in robot.lines])}
        self.creeps = {name: each for name, each in creeps.items() if each is not None}
        self.hysteresis = (
            CableHysteresis(cable.hysteresis, reference, tensions, elastic.copy()) if cable.hysteresis else None
        )
        self.sheaves = SheaveSlip(simulation.sheaves.friction, states) if simulation.sheaves.friction else None
        self.exits = ExitMountState(compliance) if compliance.any() else None
        self.gears = GearBacklash(gears.backlash, gears.bearing_friction, winches.angles) if gears.backlash else None
        self.wind = Gusts(wind.force, wind.correlation, drawn(seed, WIND)) if wind.force else None
        self.ratio = np.ones(robot.m) if self.sheaves is None else self.sheaves.ratio
        """Tension at the winch over that at the platform, (m,)."""
        self._loads = tensions
        self._given_wrench = PlatformNumbers(packed.platform).wrench[:2].copy()
        if self.wind is not None:
            self._push(packed, self.wind.force)

    @property
    def strain(self) -> Array | float:
        """Strain (m,) of cables besides elasticity and heat: creep as described and not, and hysteresis."""
        creep = sum(each.strain for each in self.creeps.values())
        return creep if self.hysteresis is None else creep + self.hysteresis.strain

    def advance(self, packed: Packed, states: Array, planes: Array, winches: Winches, period: float) -> None:
        """Advance by the *period*, s, that has passed since the last call; *packed* and *winches* change in place."""
        loads = LineStates(states).tension
        for each in self.creeps.values():
            each.advance(self._loads, loads, period)
        if self.hysteresis is not None:
            self.hysteresis.follow(loads)
        self._loads = loads
        if self.sheaves is not None:
            self.sheaves.slide(packed.lines, states)
        if self.gears is not None:
            self.gears.turn(winches.angles, loads * self.ratio)
        if self.sheaves is not None or self.gears is not None:
            stretch = 0.0 if self.sheaves is None else self.sheaves.stretch
            winches.set_unmodelled(self.ratio, stretch, None if self.gears is None else self.gears.lag)
        if self.exits is not None:
            self.exits.give(packed.lines, states, planes, self.ratio)
        if self.wind is not None:
            self._push(packed, self.wind.blow(period))

    def _push(self, packed: Packed, force: Array) -> None:
        """Push the platform with a horizontal *force* (2,), N."""
        PlatformNumbers(packed.platform).wrench[:2] = self._given_wrench + force

    def archive_state(self, archive: Archive, packed: Packed) -> None:
        """Save or load the state, and of *packed* the lines whose exits give."""
        archive.array("loads", self._loads)
        for name, each in self.creeps.items():
            archive.array(name, each.stretched)
        for part in (self.hysteresis, self.sheaves, self.gears, self.wind):
            if part is not None:
                part.archive_state(archive)
        if self.exits is not None:
            self.exits.archive_state(archive, packed.lines)
