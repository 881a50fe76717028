"""Calibration with lines that stretch or sag: each pose is the equilibrium of the paid-out lengths.

The unknowns of a pose are the m lengths paid out, which determine pose and tensions. Rows depend on the pose as for
straight lines (`kernels.fitting.calibration_residuals`); the derivatives of pose and tensions by lengths and unknowns
are those of `solvers.linearise`. Levers of sheaves on universal joints, compliant mounts of exit points and springs are
part of the equilibrium.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from cablewright.calibration.measurements import Measured
from cablewright.calibration.plan import CalibrationPlan
from cablewright.calibration.poses.derivatives import Derivatives
from cablewright.calibration.poses.problem import CalibrationProblem, StraightProblem
from cablewright.foundation.arrays import Array
from cablewright.foundation.errors import AnswerError
from cablewright.kernels.fitting import line_over_sheave
from cablewright.kernels.fitting.pose_schur import FLOOR, MAX_DAMPING, NO_BETTER, StopRule, less_damping
from cablewright.kernels.layout import Code
from cablewright.models.fidelity import CableLaw
from cablewright.models.packed_views import LineNumbers
from cablewright.models.parameters import lines_of, varied
from cablewright.models.rotation import matrices
from cablewright.models.statics import Equilibrium, Model
from cablewright.robot import Robot
from cablewright.solvers.forward import solve_from
from cablewright.solvers.linearise import Linearisation, linearise, tension_changes
from cablewright.solvers.parameter_effects import response, tension_response

_STEP: Final = 1e-10  # m: accuracy of an equilibrium
_MAX_STEPS: Final = 200
_MIN_DAMPING: Final = 1e-10  # keeps what the data leave open at its start


@dataclass(frozen=True, eq=False)
class ElasticProblem(CalibrationProblem):
    """Calibration equations of elastic or catenary lines, each pose at the equilibrium of its lengths.

    The state of a pose has its m lengths, the unknowns, then the pose (n) and the lines' states (6 m) at their
    equilibrium, from which the next equilibrium is solved.
    """

    elastic: ClassVar = True

    def states_of(self, held: Equilibrium) -> Array:
        """Return the states (N, ..) of N equilibria."""
        return np.concatenate([held.lengths, held.pose, held.states.reshape(len(held.pose), -1)], axis=1)

    def is_finite(self, theta: Array, states: Array) -> bool:
        """Return whether there is an equilibrium at every pose."""
        return bool(self.equilibria(theta, states).ok.all())

    def lengths(self, theta: Array, states: Array) -> Array:
        """Return the unstrained lengths (N, m) from winch exit to platform, m."""
        del theta
        return states[:, : self.robot.m]

    def known_tensions(self, theta: Array, states: Array) -> Array:
        """Return the tensions (N, m) of the equilibria, N."""
        return self.equilibria(theta, states).tensions

    def equilibria(self, theta: Array, states: Array, again: bool = True) -> Equilibrium:
        """Return the equilibria for the lengths in *states* (N, ..), solved from there; check their status.

        *again*: whether those that fail are solved again from the pose alone, then without a guess.
        """
        m, n, count = self.robot.m, self.robot.n, len(states)
        lengths, near, line_states = map(np.ascontiguousarray, np.split(states, [m, m + n], axis=1))
        named = zip(self.unknowns, self.whole(theta), strict=True)
        given = [(each, value * each.size) for each, value in named if each.of_equilibrium]
        possible = (lengths > 0.0).all() and all(parameter.entry.allows(value) for parameter, value in given)
        packed = self.model.rows()
        if possible:
            values = np.tile([value for _, value in given], (count, 1))
            heights = LineNumbers(packed.lines).winch_height
            packed, lengths = varied(self.robot, packed, [parameter for parameter, _ in given], values, lengths)
            LineNumbers(packed.lines).winch_height = heights  # a winch exit moves vertically with its exit point
        found = solve_from(self.model, packed, lengths, near, line_states.reshape(count, m, -1), np.full(count, again))
        # A fit may pass through overstretched lines.
        solved = np.where(found.code == int(Code.OVERSTRETCHED), int(Code.OK), found.code)
        return replace(found, code=solved if possible else np.full(count, int(Code.NOT_FINITE)))

    def derivatives(self, theta: Array, states: Array, weights: Array | None = None) -> Derivatives:
        """Return residuals and derivatives at free unknowns *theta* and *states* (N, ..)."""
        return self._rows(theta, states, self.equilibria(theta, states), self.weights if weights is None else weights)

    def _rows(self, theta: Array, states: Array, held: Equilibrium, weights: Array) -> Derivatives:
        """Return the rows at equilibria; NaN at a failed one, except in rows of weight 0."""
        m, ok, k = self.robot.m, held.ok, len(theta)
        poses = np.where(ok[:, None], held.pose, self.poses_of(states))
        found = self.rows_at(theta, poses, weights, np.eye(self.robot.n))
        motion, change = np.zeros((len(states), self.robot.n, m + k)), np.zeros((len(states), m, m + k))
        try:
            if ok.any():
                motion[ok], change[ok] = self._following(theta, held[ok])
        except AnswerError:  # at a fold there are no derivatives: the step is rejected
            ok = np.zeros_like(ok)
        by_all = found.by_pose @ motion
        weight = self.of_poses(weights)
        residual = found.residual
        count, slopes = self.lengths_per_pose, self.in_lengths(np.eye(m))[:, : self.lengths_per_pose].T
        residual[:, :count] += weight[:, :count] * (states[:, :m] @ slopes.T)
        by_all[:, :count, :m] += weight[:, :count, None] * slopes
        if self.measured.tensions is not None:
            loads = slice(count, count + m)
            scale = self.line_numbers(theta)[:, line_over_sheave.TENSION_SCALE]
            read = np.where(ok[:, None], held.tensions, 0.0) / scale  # what load cells without an offset would read
            residual[:, loads] += weight[:, loads] * read
            by_all[:, loads] += weight[:, loads, None] * change / scale[:, None]
            for i in np.flatnonzero(self.rows.target[:, line_over_sheave.TENSION_SCALE] >= 0):
                at = m + self.rows.target[i, line_over_sheave.TENSION_SCALE]
                by_all[:, count + i, at] -= weight[:, count + i] * read[:, i] / scale[i]
        residual[~ok] = np.where(weight[~ok] > 0.0, np.nan, 0.0)
        by_unknown = found.by_unknown + by_all[..., m:]
        return Derivatives(residual, by_all[..., :m], by_unknown, found.others, found.others_by_unknown)

    def _following(self, theta: Array, held: Equilibrium) -> tuple[Array, Array]:
        """Return the derivatives of poses (N, n, m + k) and tensions (N, m, m + k) by lengths and free unknowns."""
        m, k = self.robot.m, len(theta)
        motion, change = np.zeros((len(held.pose), self.robot.n, m + k)), np.zeros((len(held.pose), m, m + k))
        hardware = {m + at: each for at, each in enumerate(self.free_unknowns) if each.of_equilibrium}
        places, parameters = list(hardware), list(hardware.values())
        linear, direct = linearise(held), tension_changes(held)
        motion[..., :m] = linear.per_length
        change[..., :m] = direct.following(linear.per_length)
        change[:, range(m), range(m)] += direct.per_length
        motion[..., self.robot.hung], change[..., self.robot.hung] = 0.0, 0.0  # counterweights decide their lengths
        motion[..., places] = response(held, parameters, linear)
        change[..., places] = tension_response(held, parameters, motion[..., places], direct)
        raised = _raised(held, linear)
        following = direct.following(raised)
        for place, parameter in hardware.items():
            # The linearisation's derivative by a modulus is relative to the present one.
            over = theta[place - m] if parameter.kind == "modulus" else 1.0
            size = parameter.size if parameter.kind == "exit_compliance" else 1.0
            motion[..., place] = motion[..., place] * size / over
            change[..., place] = change[..., place] * size / over
            i = lines_of(self.robot, parameter)[0]
            if parameter.kind == "exit_point.z" and self.robot.lines[i].in_plane:  # else the winch is raised too
                motion[..., place], change[..., place] = raised[..., i], following[..., i]
                change[:, i, place] -= direct.by_pose[:, i, 2]
        return motion, change

    def adjust(
        self, theta: Array, states: Array, weights: Array, settings: StopRule
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
        """Minimise the cost by the steps of the kernel of straight lines: a Schur complement eliminates the lengths."""
        runs = [self._adjust(theta[run], states[run], weights, settings) for run in range(len(theta))]
        codes, steps, costs = zip(*runs, strict=True)
        return np.array(codes, dtype=np.int64), np.array(steps, dtype=np.int64), np.array(costs)

    def _adjust(self, theta: Array, states: Array, weights: Array, settings: StopRule) -> tuple[int, int, float]:
        """Run Levenberg-Marquardt from one start, in place. Returns a code, the accepted steps and the cost."""
        m = self.robot.m
        held = self.equilibria(theta, states)
        found = self._rows(theta, states, held, weights)
        now, damping, growth, steps = _cost(found), settings.damping, 2.0, 0
        if not np.isfinite(now):
            return int(Code.NOT_FINITE), 0, np.inf
        for _ in range(min(settings.max_steps, _MAX_STEPS)):
            change, lengths, promised = _step(found, damping, self.limits[0] - theta, self.limits[1] - theta)
            size = max(np.abs(change).max(initial=0.0), np.abs(lengths).max())
            trial = states.copy()
            trial[:, :m] += lengths
            held = self.equilibria(theta + change, trial, again=False)
            trial[held.ok, m:] = self.states_of(held)[held.ok, m:]
            there = self._rows(theta + change, trial, held, weights)
            then = _cost(there)
            if then <= now:
                fell, found, steps = now - then, there, steps + 1
                theta += change
                states[:] = trial
                done = size < max(settings.step, _STEP) or fell <= settings.fall * now
                now = then
                if done:
                    return int(Code.OK), steps, now
                gain = fell / promised if promised > 0.0 else 1.0
                damping, growth = max(damping * less_damping(gain), _MIN_DAMPING), 2.0
            elif size < NO_BETTER:
                return int(Code.OK), steps, now
            else:
                damping, growth = growth * damping, 2.0 * growth
                if damping > MAX_DAMPING:
                    break
        return int(Code.NOT_CONVERGED), steps, now


def problem_of(
    robot: Robot | Model, measured: Measured, plan: CalibrationPlan | None = None, hold: bool = True
) -> CalibrationProblem:
    """Return the calibration problem of a model, with the equations of its cable law; see `CalibrationProblem.of`."""
    rigid = isinstance(robot, Robot) or robot.fidelity.cable is CableLaw.RIGID
    equations: type[CalibrationProblem] = StraightProblem if rigid else ElasticProblem
    return equations.of(robot, measured, plan, hold)


def _raised(held: Equilibrium, linear: Linearisation) -> Array:
    """Return the motion (N, n, m) of the pose as exit point and winch exit of each line are raised together, m/m.

    It is that of lowering the line's platform point, less the moment of moving the point where its force acts. So
    raising all lines together changes neither lengths nor tensions.
    """
    if held.model.n == 3:
        return -linear.per_platform_point[..., 2]
    lowered = -np.einsum("ncia,na->nci", linear.per_platform_point, matrices(held.pose[:, 3:])[:, 2])
    away = held.platform_points - held.lines.exit_point
    away[..., 2] = 0.0
    cables = np.array([line.advantage * line.cables for line in held.model.robot.lines])
    pull = cables * held.tensions * np.cos(held.line_states.free_angle) / np.linalg.norm(away, axis=2)
    moment = np.cross(np.eye(3)[2], -pull[..., None] * away)
    return np.asarray(lowered + np.einsum("nca,nia->nci", linear.per_wrench[..., 3:], moment))


def _cost(found: Derivatives) -> float:
    """Return half the sum of squares; infinite where a residual has no value."""
    total = 0.5 * float(np.sum(found.residual**2) + np.sum(found.others**2))
    return total if np.isfinite(total) else np.inf


def _step(found: Derivatives, damping: float, down: Array, up: Array) -> tuple[Array, Array, float]:
    """Return the damped step of unknowns (k,) and of lengths (N, m), and the predicted decrease of the cost.

    *down*, *up* (k,): how far unknowns may go; one that is at its bound and that the cost pushes out stays.
    """
    H, G, r = found.by_pose, found.by_unknown, found.residual
    V, W = np.swapaxes(H, 1, 2) @ H, np.swapaxes(H, 1, 2) @ G
    h = -np.einsum("nea,ne->na", H, r)
    flat, others = G.reshape(r.size, G.shape[2]), found.others_by_unknown
    U, g = flat.T @ flat + others.T @ others, -(flat.T @ r.ravel() + others.T @ found.others)
    m, k = V.shape[1], len(g)
    own, shared = damping * np.einsum("naa->na", V) + FLOOR, damping * np.diag(U) + FLOOR
    V[:, range(m), range(m)] += own
    inner = np.linalg.solve(V, np.concatenate([W, h[..., None]], axis=2))
    reduced = U + np.diag(shared) - np.tensordot(W, inner[..., :k], ((0, 1), (0, 1)))
    right = g - np.einsum("nak,na->k", W, inner[..., k])
    stays = ((down >= 0.0) & (g < 0.0)) | ((up <= 0.0) & (g > 0.0))
    reduced[stays], reduced[:, stays], right[stays] = 0.0, 0.0, 0.0
    reduced[stays, stays] = 1.0
    change = np.linalg.solve(reduced, right).clip(down, up)
    lengths = inner[..., k] - inner[..., :k] @ change
    promised = change @ (g + shared * change) + np.sum(lengths * (h + own * lengths))
    return np.asarray(change), np.asarray(lengths), 0.5 * float(promised)
