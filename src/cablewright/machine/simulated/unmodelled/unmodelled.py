"""All unmodelled effects on one rig, advanced at the end of each step of the machine; see `docs/machine.md`."""

from __future__ import annotations

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.kernels.layout import Packed
from cablewright.machine.simulated.as_built_parts import CREEP, TEETH, WIND, drawn
from cablewright.machine.simulated.settings import SimulationSettings
from cablewright.machine.simulated.unmodelled.cable_creep import CableCreep
from cablewright.machine.simulated.unmodelled.cable_hysteresis import CableHysteresis
from cablewright.machine.simulated.unmodelled.drum_drive import DrumDrive
from cablewright.machine.simulated.unmodelled.exit_mounts import ExitMountState
from cablewright.machine.simulated.unmodelled.gear_backlash import GearBacklash
from cablewright.machine.simulated.unmodelled.gusts import Gusts
from cablewright.machine.simulated.unmodelled.hose import Hose
from cablewright.machine.simulated.unmodelled.load_strain import LoadStrain
from cablewright.machine.simulated.unmodelled.pushes import Pushes
from cablewright.machine.simulated.unmodelled.sheave_slip import SheaveSlip
from cablewright.machine.simulated.winches import Winches
from cablewright.models.climate_and_creep import Air
from cablewright.models.creep import memory_of
from cablewright.models.packed_views import LineNumbers, LineStates, PlatformNumbers
from cablewright.robot import Robot


class Unmodelled:
    """Unmodelled effects on a simulated machine; effects of size 0 are None.

    The reference load of all cables is the mean of the lines' tensions at the start.
    """

    SAVED = (
        "_loads",
        "_time",
        "creeps",
        "hysteresis",
        "load_strain",
        "sheaves",
        "gears",
        "drive",
        "wind",
        "exits",
    )

    def __init__(
        self,
        robot: Robot,
        simulation: SimulationSettings,
        packed: Packed,
        states: Array,
        place: Array,
        winches: Winches,
        seed: int,
    ) -> None:
        """Begin with a machine at rest by *states* (m, 6) at *place* (3,), m, without any of it.

        Raises `UnknownName` for a line.
        """
        names = tuple(line.name for line in robot.lines)
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
        turned = np.array([0.0 if not line.guides else line.dead_span().turned for line in robot.lines])
        friction = simulation.sheaves.friction
        self.sheaves = SheaveSlip(friction, states, turned) if friction else None
        self._cables = np.array([float(line.cables) for line in robot.lines])
        self.exits = ExitMountState(compliance) if compliance.any() else None
        firm = cable.settling or cable.stiffening
        self.load_strain = (
            LoadStrain(cable.settling, cable.stiffening, reference, tensions, elastic.copy()) if firm else None
        )
        self.gears = GearBacklash(gears.backlash, gears.bearing_friction, winches.angles) if gears.backlash else None
        ripple, slide = (gears.ripple, gears.ripple_periods), simulation.winch.slide
        phases = drawn(seed, TEETH).uniform(0.0, 2.0 * np.pi, robot.m)
        moved = gears.torsion or gears.ripple or slide
        self.drive = DrumDrive(gears.torsion, ripple, slide, reference, winches.angles, phases) if moved else None
        self.wind = Gusts(wind.force, wind.correlation, drawn(seed, WIND)) if wind.force else None
        hose, pushes, gravity = simulation.hose, simulation.pushes, robot.scene.gravity
        self.hose = None if hose is None else Hose(hose.start, hose.length, hose.linear_density * gravity)
        self.pushes = Pushes(pushes.force, pushes.pause, pushes.length, seed) if pushes.force else None
        self.ratio = np.ones(robot.m) if self.sheaves is None else self.sheaves.ratio
        """Tension at the winch over that at the platform, (m,)."""
        followers = [each for each in (self.hysteresis, self.load_strain) if each is not None]
        self._strained = (*self.creeps.values(), *followers)
        self._loads = tensions
        parts = (self.sheaves, self.exits, self.gears, self.drive)
        self._feels_loads = bool(self._strained) or any(each is not None for each in parts)
        self._given_force, self._time = PlatformNumbers(packed.platform).wrench[:3].copy(), 0.0
        self._push(packed, place)

    @property
    def strain(self) -> Array | float:
        """Return the inelastic strain (m,) of cables: described and further creep, hysteresis, and by load."""
        return sum(each.strain for each in self._strained) if self._strained else 0.0

    def advance(
        self, packed: Packed, states: Array, planes: Array, winches: Winches, place: Array, period: float, air: Air
    ) -> None:
        """Advance all effects by the *period*, s, since the last call; *packed* and *winches* change in place.

        *place* (3,): m, of the platform's origin.
        """
        if self._feels_loads:
            self._load(packed, states, planes, winches, period, air)
        self._time += period
        if self.wind is not None:
            self.wind.blow(period)
        self._push(packed, place)

    def _load(self, packed: Packed, states: Array, planes: Array, winches: Winches, period: float, air: Air) -> None:
        """Advance what the loads of the lines change by the *period*, s."""
        loads = LineStates(states).tension
        for each in self.creeps.values():
            each.feel(air)
            each.advance(self._loads, loads, period)
        for part in (self.hysteresis, self.load_strain):
            if part is not None:
                part.follow(loads)
        self._loads = loads
        if self.sheaves is not None:
            self.sheaves.slide(packed, states, planes)
        self._turn(packed, states, winches)
        if self.exits is not None:
            self.exits.give(packed, states, planes, self.ratio)

    def _turn(self, packed: Packed, states: Array, winches: Winches) -> None:
        """Turn gears and drums as far as the motors have turned, and set what that does to the lengths that are out."""
        if self.gears is None and self.drive is None and self.sheaves is None:
            return
        pulls, radii, lines = self._loads * self.ratio * self._cables, winches.leaving_radii, winches.lines
        if not lines.plain:  # a gear has the torque of all cables on its drum
            pulls[lines.hosts] = lines.torques(pulls, radii) / radii[lines.hosts]
        if self.gears is not None:
            self.gears.turn(winches.angles, pulls)
        if self.drive is not None:
            self.drive.turn(winches.angles, pulls, radii, softness(packed, states))
        lags = [lines.sense * each.lag[lines.host] for each in (self.gears, self.drive) if each is not None]
        if self.sheaves is not None or lags:
            winches.set_unmodelled(
                self.ratio * self._cables, 0.0 if self.sheaves is None else self.sheaves.stretch, sum(lags)
            )

    def _push(self, packed: Packed, place: Array) -> None:
        """Push the platform, with its origin at *place* (3,), m, by wind, people and a hose."""
        if self.wind is None and self.pushes is None and self.hose is None:
            return
        force = self._given_force.copy()
        if self.wind is not None:
            force[:2] += self.wind.force
        if self.pushes is not None:
            force[:2] += self.pushes.at(self._time)
        if self.hose is not None:
            force += self.hose.pull(place)
        PlatformNumbers(packed.platform).wrench[:3] = force


def softness(packed: Packed, states: Array) -> Array:
    """Return the stretch of straight lines with *states* (m, 6) between fixed ends per pull on drums, (m,) m/N."""
    own, lines = LineStates(states), LineNumbers(packed.lines)
    length = lines.spans * own.free_length + own.dead_length
    return np.asarray((lines.free_compliance * length + lines.spring) / np.maximum(lines.pulls / lines.spans, 1.0))
