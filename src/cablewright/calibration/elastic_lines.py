"""A calibration of lines that stretch and sag: the same rows, at the equilibrium that lengths paid out lead to.

Unknown of a pose by itself are the m lengths paid out: they decide pose and tensions. What a sensor says of the pose is
as of straight lines (`kernels.sensors`); how pose and tensions follow lengths and unknowns is the one linearisation.
Levers of sheaves on a universal joint are part of the equilibrium, and so exact.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cablewright.arrays import Array
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.problem import CalibrationProblem, Derivatives, Measured, equations
from cablewright.errors import AnswerError
from cablewright.kernels.fitting.calibration_residuals import MeasurementRows
from cablewright.kernels.fitting.pose_schur import FLOOR, MAX_DAMPING, NO_BETTER, StopRule
from cablewright.kernels.layout import Code
from cablewright.models.packed_views import LineNumbers
from cablewright.models.parameters import lines_of, varied
from cablewright.models.rotation import matrices
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot.parameters import Parameter
from cablewright.solvers.forward import solve_from
from cablewright.solvers.linearise import Linearisation, linearise, tension_changes
from cablewright.solvers.parameters import response, tension_response

_STEP: Final = 1e-10  # m: an equilibrium is no more exact than this
_MAX_STEPS: Final = 200
_MIN_DAMPING: Final = 1e-10  # what the data leave open stays where it was
FREED: Final = (0, 1, 2, 5, 4, 3)
"""Freedoms of a pose in the order in which lines hold them: gravity decides the last ones where lines are few."""


@dataclass(frozen=True, eq=False)
class Hanging(CalibrationProblem):
    """The equations of a calibration of lines under the cable law of `model`.

    What is kept of each pose are its m lengths, which are unknown, then the pose (n) and the lines' states (6 m) that
    they led to: from there the next equilibrium is sought.
    """

    model: Model

    @classmethod
    def under(cls, model: Model, measured: Measured, plan: CalibrationPlan, hold: bool = True) -> Hanging:
        """Build the rows; see `CalibrationProblem.of`."""
        return cls(model.robot, measured, plan, *equations(model.robot, measured, plan, hold, hangs=True), model)

    def freed(self) -> Hanging:
        """The same without a datum."""
        return Hanging.under(self.model, self.measured, self.plan, hold=False)

    @property
    def hangs(self) -> bool:
        """They do."""
        return True

    @property
    def cable(self) -> str:
        """The cable law: elastic or catenary."""
        return self.model.fidelity.cable.value

    @property
    def own(self) -> int:
        """How many lengths of a pose are unknown."""
        return self.robot.m

    def poses_of(self, own: Array) -> Array:
        """The poses (N, n)."""
        return own[:, self.robot.m : self.robot.m + self.robot.n]

    def with_poses(self, own: Array, poses: Array) -> Array:
        """The same lengths and states of lines, each in its own plane, at other poses (N, n)."""
        moved = own.copy()
        moved[:, self.robot.m : self.robot.m + self.robot.n] = poses
        return moved

    def kept(self, held: Equilibrium) -> Array:
        """What is kept of each pose (N, ..) of a batch of equilibria."""
        return np.concatenate([held.lengths, held.pose, held.states.reshape(len(held.pose), -1)], axis=1)

    def reaches(self, theta: Array, own: Array) -> bool:
        """Whether the platform hangs at every pose."""
        return bool(self.equilibria(theta, own).ok.all())

    def lengths(self, theta: Array, poses: Array) -> Array:
        """Lengths (N, m) paid out, unstrained, from winch exit to platform, m."""
        del theta
        return poses[:, : self.robot.m]

    def balanced(self, theta: Array, poses: Array) -> CalibrationProblem:
        """Itself: an equilibrium is balanced."""
        del theta, poses
        return self

    @cached_property
    def _hardware(self) -> list[tuple[int, Parameter]]:
        """Which of the unknowns that are not held are numbers of the equilibrium."""
        free = (each for each, held in zip(self.unknowns, self.held, strict=True) if not held)
        return [(at, each) for at, each in enumerate(free) if each.of_equilibrium]

    def equilibria(self, theta: Array, own: Array) -> Equilibrium:
        """Where the platform hangs with these numbers; rows that have no answer say so."""
        m, n, count = self.robot.m, self.robot.n, len(own)
        lengths, near = np.ascontiguousarray(own[:, :m]), np.ascontiguousarray(own[:, m : m + n])
        states = np.ascontiguousarray(own[:, m + n :]).reshape(count, m, -1)
        named = zip(self.unknowns, self.whole(theta), strict=True)
        given = [(each, value) for each, value in named if each.of_equilibrium]
        possible = (lengths > 0.0).all() and all(parameter.entry.allows(value) for parameter, value in given)
        packed = self.model.rows()
        if possible:
            values = np.tile([value for _, value in given], (count, 1))
            heights = LineNumbers(packed.lines).winch_height
            packed, lengths = varied(self.robot, packed, [parameter for parameter, _ in given], values, lengths)
            LineNumbers(packed.lines).winch_height = heights  # winch exits follow in height too
        found = solve_from(self.model, packed, lengths, near, states, np.ones(count, dtype=bool))
        solved = np.where(found.code == int(Code.OVERSTRETCHED), int(Code.OK), found.code)  # a fit passes through those
        return replace(found, code=solved if possible else np.full(count, int(Code.NOT_FINITE)))

    def derivatives(self, theta: Array, poses: Array, weights: Array | None = None) -> Derivatives:
        """Residuals and derivatives at unknowns *theta* that are not held, and what is kept of each pose (N, ..)."""
        return self._rows(theta, poses, self.equilibria(theta, poses), self.weights if weights is None else weights)

    def _rows(self, theta: Array, own: Array, held: Equilibrium, weights: Array) -> Derivatives:
        """The rows at equilibria; NaN where one fails that counts."""
        m, ok, k = self.robot.m, held.ok, len(theta)
        found = super().derivatives(theta, np.where(ok[:, None], held.pose, self.poses_of(own)), weights)
        motion, change = np.zeros((len(own), self.robot.n, m + k)), np.zeros((len(own), m, m + k))
        try:
            if ok.any():
                motion[ok], change[ok] = self._following(theta, held[ok])
        except AnswerError:  # at a fold nothing follows smoothly: whoever steps there goes back
            ok = np.zeros_like(ok)
        by_all = np.einsum("nec,nca->nea", found.by_pose, motion)
        weight = self.of_poses(weights)
        residual = found.residual
        residual[:, :m] += weight[:, :m] * own[:, :m]
        by_all[:, range(m), range(m)] += weight[:, :m]
        if self.measured.tensions is not None:
            loads = slice(m, 2 * m)
            residual[:, loads] += weight[:, loads] * np.where(ok[:, None], held.tensions, 0.0)
            by_all[:, loads] += weight[:, loads, None] * change
        residual[~ok] = np.where(weight[~ok] > 0.0, np.nan, 0.0)
        by_unknown = found.by_unknown + by_all[..., m:]
        return Derivatives(residual, by_all[..., :m], by_unknown, found.others, found.others_by_unknown)

    def _following(self, theta: Array, held: Equilibrium) -> tuple[Array, Array]:
        """How poses (N, n, m + k) and tensions (N, m, m + k) follow lengths and unknowns."""
        m, k = self.robot.m, len(theta)
        motion, change = np.zeros((len(held.pose), self.robot.n, m + k)), np.zeros((len(held.pose), m, m + k))
        places = [m + at for at, _ in self._hardware]
        parameters = [parameter for _, parameter in self._hardware]
        linear, direct = linearise(held), tension_changes(held)
        motion[..., :m] = linear.per_length
        change[..., :m] = direct.following(linear.per_length)
        change[:, range(m), range(m)] += direct.per_length
        motion[..., places] = response(held, parameters, linear)
        change[..., places] = tension_response(held, parameters, motion[..., places], direct)
        raised = _raised(held, linear)
        following = direct.following(raised)
        for place, (at, parameter) in zip(places, self._hardware, strict=True):
            if parameter.kind == "modulus":  # the linearisation's is per share of what there is
                motion[..., place] /= theta[at]
                change[..., place] /= theta[at]
            elif parameter.kind == "exit_point.z":
                i = lines_of(self.robot, parameter)[0]
                motion[..., place], change[..., place] = raised[..., i], following[..., i]
                change[:, i, place] -= direct.by_point[:, i, 2]
        return motion, change

    def followed(self, theta: Array, own: Array, change: Array, by: Array) -> Array:
        """Lengths and poses: these follow both, to the first order."""
        motion, _ = self._following(theta, self.equilibria(theta, own).checked())
        all_changes = np.concatenate([by, np.broadcast_to(change, (len(own), len(change)))], axis=1)
        moved = own.copy()
        moved[:, : self.own] += by
        moved[:, self.own : self.own + self.robot.n] += np.einsum("nca,na->nc", motion, all_changes)
        return moved

    def adjust(
        self, theta: Array, own: Array, weights: Array, settings: StopRule, rows: MeasurementRows | None = None
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
        """As `CalibrationProblem.adjust`, by the same steps as its kernel: a Schur complement takes the lengths out."""
        assert rows is None
        runs = [self._adjust(theta[run], own[run], weights, settings) for run in range(len(theta))]
        codes, steps, costs = zip(*runs, strict=True)
        return np.array(codes, dtype=np.int64), np.array(steps, dtype=np.int64), np.array(costs)

    def _adjust(self, theta: Array, own: Array, weights: Array, settings: StopRule) -> tuple[int, int, float]:
        """One run of Levenberg-Marquardt steps; *theta* and *own* are moved. Returns a code, steps and the cost."""
        m = self.robot.m
        held = self.equilibria(theta, own)
        found = self._rows(theta, own, held, weights)
        now, damping, steps = _cost(found), settings.damping, 0
        if not np.isfinite(now):
            return int(Code.NOT_FINITE), 0, np.inf
        for _ in range(min(settings.max_steps, _MAX_STEPS)):
            change, lengths, promised = _step(found, damping)
            size = max(np.abs(change).max(initial=0.0), np.abs(lengths).max())
            trial = own.copy()
            trial[:, :m] += lengths
            held = self.equilibria(theta + change, trial)
            trial[held.ok, m:] = self.kept(held)[held.ok, m:]
            there = self._rows(theta + change, trial, held, weights)
            then = _cost(there)
            if then <= now:
                fell, found, steps = now - then, there, steps + 1
                theta += change
                own[:] = trial
                done = size < max(settings.step, _STEP) or fell <= settings.fall * now
                now = then
                if done:
                    return int(Code.OK), steps, now
                gain = fell / promised if promised > 0.0 else 1.0
                damping = max(damping * (0.01 if gain > 0.75 else 0.3 if gain > 0.25 else 2.0), _MIN_DAMPING)
            elif size < NO_BETTER:
                return int(Code.OK), steps, now
            else:
                damping = max(8.0 * damping, _MIN_DAMPING)
                if damping > MAX_DAMPING:
                    break
        return int(Code.NOT_CONVERGED), steps, now


def _raised(held: Equilibrium, linear: Linearisation) -> Array:
    """Motion (N, n, m) as exit point and winch exit of each line are raised together, m/m.

    That is what its platform point would do to the span if it were lowered, without the moment that this point's force
    takes along. So raising everything is a motion that no sensor of lengths and tensions sees.
    """
    if held.model.n == 3:
        return -linear.per_platform_point[..., 2]
    turned = matrices(held.pose[:, 3:])
    lowered = -np.einsum("ncia,na->nci", linear.per_platform_point, turned[:, 2])
    away = held.platform_points - held.lines.exit_point
    away[..., 2] = 0.0
    pull = held.tensions * np.cos(held.line_states.free_angle) / np.linalg.norm(away, axis=2)
    moment = np.cross(np.eye(3)[2], -pull[..., None] * away)
    return np.asarray(lowered + np.einsum("nca,nia->nci", linear.per_wrench[..., 3:], moment))


def _cost(found: Derivatives) -> float:
    """Half the sum of squares; infinite where a reading has no value."""
    total = 0.5 * float(np.sum(found.residual**2) + np.sum(found.others**2))
    return total if np.isfinite(total) else np.inf


def _step(found: Derivatives, damping: float) -> tuple[Array, Array, float]:
    """The damped step of unknowns (k,) and of lengths (N, m), and the fall of the cost that it promises."""
    H, G, r = found.by_pose, found.by_unknown, found.residual
    V, W = np.swapaxes(H, 1, 2) @ H, np.swapaxes(H, 1, 2) @ G
    h = -np.einsum("nea,ne->na", H, r)
    flat, others = G.reshape(r.size, G.shape[2]), found.others_by_unknown
    U, g = flat.T @ flat + others.T @ others, -(flat.T @ r.ravel() + others.T @ found.others)
    m, k = V.shape[1], len(g)
    own, shared = damping * np.einsum("naa->na", V) + FLOOR, damping * np.diag(U) + FLOOR
    V[:, range(m), range(m)] += own
    inner = np.linalg.solve(V, np.concatenate([W, h[..., None]], axis=2))
    reduced = U + np.diag(shared) - np.einsum("nak,nal->kl", W, inner[..., :k])
    change = np.linalg.solve(reduced, g - np.einsum("nak,na->k", W, inner[..., k]))
    lengths = inner[..., k] - inner[..., :k] @ change
    promised = change @ (g + shared * change) + np.sum(lengths * (h + own * lengths))
    return np.asarray(change), np.asarray(lengths), 0.5 * float(promised)
