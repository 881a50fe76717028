"""Two simulations of motion (plants): dynamic, in substeps of milliseconds, or from equilibrium to equilibrium."""

from __future__ import annotations

from typing import Final, Protocol

import numpy as np

from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import InputError
from cablewright.foundation.signals import Condition, Notice
from cablewright.kernels import Direct, continuation
from cablewright.kernels.certificates.system_enclosure import certificate_pool
from cablewright.kernels.layout import COUNTERWEIGHT, HELD, Code, Packed
from cablewright.kernels.plant import counterweights, dynamics, machine_step, retracting_platform, winding
from cablewright.kernels.rotation import matrix
from cablewright.kernels.statics import forward
from cablewright.kernels.statics.equilibrium import evaluate, workspace
from cablewright.kernels.statics.line.counterweight import read_lengths
from cablewright.kernels.statics.platform import between
from cablewright.machine.simulated.plant_parts.coming_to_rest import settle
from cablewright.machine.simulated.true_state import Rig
from cablewright.models.packed_views import LineStates
from cablewright.solvers.continuation import TrackerSettings

MAX_SUBSTEPS: Final = 1000
_TOLERANCE: Final = 1e-6  # m and rad, to which equilibria of bodies are certified


class Plant(Protocol):
    """Interface of a plant, which advances a rig (the true state) in time."""

    @property
    def period(self) -> float:
        """Time of one step, s."""

    def advance(self, speeds: Array) -> list[Notice]:
        """Turn the winches at *speeds* (w,), rad/s of the drums, for one period, and move the platform."""


class DynamicPlant:
    """The platform moves by its dynamics; lines hang as in statics, with a vibration of their first mode."""

    SAVED = ("_lengths_after", "_random")

    def __init__(self, rig: Rig) -> None:
        """Raises `InputError` unless a whole number of substeps fills the period."""
        self.rig = rig
        self.period, substep = rig.settings.owner.period, rig.settings.simulation.substep
        count = self.period / substep
        if not (0.5 < count < MAX_SUBSTEPS + 0.5 and abs(count - round(count)) < 1e-6):
            raise InputError(
                f"simulation.substep = {substep:g} s: the period, {self.period:g} s, must be a whole number of "
                f"substeps, at most {MAX_SUBSTEPS}"
            )
        self._count = round(count)
        self._lengths_after, self._advance = np.zeros(rig.robot.m), Direct(machine_step.advance)
        self._random = np.random.default_rng([rig.seed, 3])
        self._hung = rig.robot.hung
        for i in self._hung:  # a mass in place of a force
            line, row = rig.robot.lines[i], rig.packed.lines[i]
            held, row[COUNTERWEIGHT] = row[COUNTERWEIGHT], 0.0
            own = rig.swing.weights[i]
            own[counterweights.MASS] = (line.counterweight or 0.0) / line.cables
            own[counterweights.HELD] = held

    def advance(self, speeds: Array) -> list[Notice]:
        """Turn the winches at *speeds* (w,), rad/s, for one period, and move the platform; see `Plant.advance`."""
        rig, winches = self.rig, self.rig.winches
        if self._hung:
            rig.swing.weights[:, counterweights.RATIO] = rig.unmodelled.ratio
        code = self._advance.call(
            rig.packed,
            rig.body,
            winches.state,
            winches.motor,
            winches.radii,
            winches.wound,
            winches.sideways,
            winches.by_line(speeds),
            rig.retraction.drive,
            rig.vibration,
            self._random.standard_normal((self._count, rig.robot.m)),
            self.period / self._count,
            rig.motion,
            rig.lengths,
            rig.states,
            rig.vibrations,
            rig.acceleration,
            rig.tensions,
            rig.winch_flags,
            rig.work,
            rig.swing,
            self._lengths_after,
        )
        return [] if code == 0 else [Notice(Condition.NO_EQUILIBRIUM)]


class QuasiStaticPlant:
    """Each period ends in the equilibrium followed from the last one.

    A container hangs upright and turns only in yaw.
    """

    SAVED = ("_lengths_after", "_solved", "_pose")

    def __init__(self, rig: Rig) -> None:
        """Start from the state of *rig*."""
        self.rig = rig
        self.period = rig.settings.simulation.quasi_static_period
        self._lengths_after = np.zeros(rig.robot.m)
        self._solved = rig.lengths.copy()
        self._pose = rig.pose
        self._whole = np.arange(rig.robot.m)
        self._fit()
        tolerance = _TOLERANCE if rig.robot.n == 6 else 0.0
        self._bounds = (TrackerSettings().jump, TrackerSettings().fold, tolerance)

    def _fit(self) -> None:
        """Fit the scratch to the lines that have not broken."""
        packed = self.rig.packed
        self._kept = np.delete(self._whole, self.rig.line_faults.broken())
        packed = packed._replace(lines=packed.lines[self._kept])
        self._work, self._pool = workspace(packed), certificate_pool(packed)

    def advance(self, speeds: Array) -> list[Notice]:
        """Turn the winches at *speeds* (w,), rad/s, for one period, and move the platform; see `Plant.advance`."""
        rig, winches, after = self.rig, self.rig.winches, self._lengths_after
        drums = (winches.state, winches.motor, winches.radii, winches.wound, winches.sideways)
        if rig.brakes is not None:
            rig.brakes.yield_by_secants(winches, rig.tensions * winches.state[:, winding.RATIO])
        winding.turn_winches(*drums, winches.by_line(speeds), rig.tensions, self.period, after, rig.winch_flags)
        if rig.robot.m - len(rig.line_faults.broken()) < len(self._kept):
            self._fit()
        self._retract()
        kept = self._kept
        packed = rig.packed if len(kept) == rig.robot.m else rig.packed._replace(lines=rig.packed.lines[kept])
        pose, states = self._pose.copy(), rig.states[kept]
        code, notices = self._follow(packed, self._solved[kept], after[kept], pose, states)
        if code == 0 and rig.unmodelled.exits is not None:
            code, notices = self._close_exits(packed, after[kept], pose, states, notices)
        if code == 0 and rig.robot.hung:
            lengths = after[kept]
            read_lengths(packed, states, lengths)
            after[kept] = lengths
        rig.lengths[:] = after
        if code != 0:
            rig.motion[3:6] = rig.motion[9:12] = 0.0
            return [Notice(Condition.NO_EQUILIBRIUM)]
        self._move(pose)
        rig.states[kept] = states
        rig.work.planes[kept], rig.work.arms[kept] = self._work.planes, self._work.arms
        rig.work.rotation[:], rig.swing.place[:] = self._work.rotation, pose
        self._solved[:] = after
        rig.tensions[:] = LineStates(rig.states).tension
        self._press(packed, pose, states)
        return notices

    def _press(self, packed: Packed, pose: Array, states: Array) -> None:
        """Set the force on the platform's plane, if it has one, of lines and loads at rest."""
        if self.rig.robot.platform.plane is None:
            return
        loose = packed.platform.copy()
        loose[HELD] = 0.0
        evaluate(packed._replace(platform=loose), self._solved[self._kept], pose, states, self._work)
        self.rig.swing.on_plane[:] = dynamics.force_on_plane(packed, self._work.trial)

    def _follow(
        self, packed: Packed, before: Array, after: Array, pose: Array, states: Array
    ) -> tuple[int, list[Notice]]:
        """Follow the equilibrium in *pose* and *states*, updated in place, or find another one. Returns a code."""
        start, shapes = pose.copy(), states.copy()
        certify = self.rig.unmodelled.exits is None  # others are certified when their exit points have given
        code = self._track(packed, before, after, pose, states, certify=certify)
        if code == Code.UNCERTIFIED:
            return 0, [Notice(Condition.UNCERTIFIED)]
        if code == 0:
            return 0, []
        pose[:] = start
        if self.rig.robot.n == 3:
            code, _, _ = forward.solve_near(packed, after, pose, states, self._work)
            return code, []
        states[:] = shapes
        if not settle(packed, self.rig.body, before, after, pose, states):
            return code, []
        code = self._track(packed, after, after, pose, states)
        return (0 if code == Code.UNCERTIFIED else code), [Notice(Condition.BRANCH_END)]

    def _track(
        self, packed: Packed, before: Array, after: Array, pose: Array, states: Array, *, certify: bool = True
    ) -> int:
        """Follow the equilibrium in *pose* and *states*, updated in place, and *certify* it."""
        jump, fold, tolerance = self._bounds
        code, _ = continuation.follow(packed, before, after, pose, states, jump, fold, self._work)
        if code != Code.OK or not (certify and tolerance > 0.0):
            return int(code)
        proved = continuation.is_certified(packed, after, pose, states, tolerance, self._pool)
        return int(Code.OK if proved else Code.UNCERTIFIED)

    def _close_exits(
        self, packed: Packed, lengths: Array, pose: Array, states: Array, notices: list[Notice]
    ) -> tuple[int, list[Notice]]:
        """Let exit points give until they are in equilibrium with *pose* and *states*, updated in place.

        Returns a code, and *notices* with the certificate of where that is.
        """
        rig, kept = self.rig, self._kept
        assert rig.unmodelled.exits is not None  # as asked
        code = rig.unmodelled.exits.close(packed, kept, lengths, pose, states, rig.unmodelled.ratio, self._work)
        rig.packed.lines[kept] = packed.lines
        if code != 0 or rig.robot.n == 3:
            return code, notices
        code = self._track(packed, lengths, lengths, pose, states)
        told = [each for each in notices if each.condition != Condition.UNCERTIFIED]
        return (0, [*told, Notice(Condition.UNCERTIFIED)]) if code == Code.UNCERTIFIED else (code, told)

    def after_load(self) -> None:
        """Adapt to the lines of a rig that was loaded before."""
        self._fit()

    def _retract(self) -> None:
        """Move the retraction, against the pull at the last equilibrium."""
        rig = self.rig
        if rig.retraction.has_drive:
            drive, rotation = rig.retraction.drive, np.empty((3, 3))
            matrix(rig.motion[6:9], rotation)
            given = (rig.packed, rig.body, drive.beam, drive.moved, rig.states, rig.work.planes, rotation)
            rig.retraction.move(rig.packed.lines, retracting_platform.pull_along(*given), self.period)

    def _move(self, pose: Array) -> None:
        """Move the platform to *pose* (n,); a drum turns to the yaw where its lines are untwisted."""
        motion, shift = self.rig.motion, np.zeros(len(pose))
        between(self._pose, pose, shift)
        motion[3:6] = shift[:3] / self.period
        motion[:3], self._pose = pose[:3], pose
        if len(pose) == 6:
            motion[9:12], motion[6:9] = shift[3:] / self.period, pose[3:]
            return
        rest = self.rig.body[dynamics.YAW_REST]
        motion[11] = (rest - motion[8]) / self.period
        motion[8] = rest
