"""Reduction of the fastest motion's acceleration, where the platform would swing too far or break tension limits."""

from __future__ import annotations

from typing import Final

import numpy as np

from cablewright.analyses.feasibility import LineQuantities
from cablewright.analyses.motion.path_swing import PathSwing
from cablewright.analyses.steady_acceleration import fed_forward
from cablewright.foundation.arrays import Array
from cablewright.foundation.memory_mapped import MEMORY, Room, blocks, let_go
from cablewright.models.inertia import compensates
from cablewright.models.job_poses import poses_at
from cablewright.models.statics import Model
from cablewright.printing.beads import Beads
from cablewright.printing.job import Job
from cablewright.printing.path import Samples
from cablewright.printing.timing import times_on_way
from cablewright.robot import Robot
from cablewright.solvers.inverse import BLOCK, solve_inverse
from cablewright.solvers.linearise import linearise_solved
from cablewright.solvers.swing_free_motion import JobMotion

LEAST: Final = 0.05
"""Share of a job's acceleration that is always left."""

RESERVE: Final = 1.1
"""Tension kept from the limits at rest, in units of the change by motion."""

_ERROR_SHARE: Final = 0.5  # of the error that a job allows, for motion
_ROUNDS: Final = 14  # of the largest factor they come to the least share
_AIM: Final = 0.95  # of the acceleration that the worst sample would allow, if motion changed in proportion
_STEPS: Final = (0.4, 0.8)  # smallest and largest factor of a round


def slowed(robot: Robot, job: Job, samples: Samples, beads: Beads, room: Room = MEMORY) -> Job:
    """Return the *job* with its acceleration lowered until the motion along *samples* stays within limits.

    At each sample the tensions of the full model, with the swing of the platform, are to stay within the limits of the
    robot file where those at rest do, if need be with a reserve at rest, and the error by motion within half of the
    job's tolerance where material is laid. At least the share `LEAST` of the acceleration is left, and limits that
    motion then breaks are left to the verdict. Motion that is not shaped stays as it is: its corners may swing more if
    it is slower, and a job with the speeds of its G-code is returned unchanged.
    """
    asked = job.motion.acceleration
    if job.motion.speed == "gcode":
        return job
    for _ in range(_ROUNDS):
        motion, now = JobMotion.of(robot, job, samples, room), job.motion.acceleration
        if motion.shaper is None:
            break
        share, drop, rise = _judged(Model.full(robot), job, motion, beads)
        careful = with_reserve(robot, drop, rise) if share < 1.0 else None
        if careful is not None:
            share = max(share, _judged(Model.full(careful), job, motion, beads, robot)[0])
        if share >= 1.0 or now <= LEAST * asked:
            break
        lower = max(now * float(np.clip(_AIM * share, *_STEPS)), LEAST * asked)
        job = job.model_copy(update={"motion": job.motion.model_copy(update={"acceleration": lower})})
    return job


def with_reserve(robot: Robot, drop: Array, rise: Array) -> Robot | None:
    """Return the robot with tension limits that are narrower by the changes of motion; None where no range is left.

    *drop*, *rise* (m,): N, at least 0, the most that motion takes from and adds to the tension of each line.
    """
    lines = []
    for line, less, more in zip(robot.lines, drop, rise, strict=True):
        low, high = line.tension_limits[0] + RESERVE * float(less), line.tension_limits[1] - RESERVE * float(more)
        if not low < high:
            return None
        lines.append(line.model_copy(update={"tension_limits": (low, high)}))
    return robot.model_copy(update={"lines": tuple(lines)})


def slower_note(asked: Job, job: Job) -> tuple[str, ...]:
    """Return a sentence by how much `slowed` has lowered the acceleration of a job; empty if it has not."""
    before, now = asked.motion.acceleration, job.motion.acceleration
    if now == before:
        return ()
    return (
        f"acceleration {now:.3g} m/s^2 in place of {before:.3g}, so that motion keeps tensions and error in limits",
    )


def _judged(
    full: Model, job: Job, motion: JobMotion, beads: Beads, robot: Robot | None = None
) -> tuple[float, Array, Array]:
    """Return the least share of the effects of the *motion* that its limits allow anywhere; inf where it has none.

    And the most that it takes from each tension and adds to it (m,), N. *robot*: robot whose limits count where the
    model's leave a reserve; None: the model's.
    """
    samples, law, swing, worst = motion.samples, motion.law, PathSwing(full), np.inf
    limits = np.array([line.tension_limits for line in (robot or full.robot).lines]).T
    leads, most = law.vector is not None and compensates(full.robot), np.zeros((2, full.m))
    for at in blocks(len(samples), BLOCK):
        poses, retraction = poses_at(full.robot, job, samples.positions[at])
        held = solve_inverse(full, poses, path=True, retraction=retraction)
        regular, linear = linearise_solved(held)
        vector = law.vector[at] if leads and law.vector is not None else None
        found = swing.take(held, regular, linear, *times_on_way(samples, law, at), vector)
        if vector is not None:
            found = found.beside(fed_forward(held, retraction, vector).added)
        needed = np.stack([-found.tension_drop, found.tension_rise])
        most = np.maximum(most, needed.max(axis=1))
        rest = LineQuantities.of(held)
        left = np.stack([rest.lowest_tension - limits[0], limits[1] - rest.highest_tension])
        shares = np.where((left > 0.0) & held.ok[:, None], left / np.maximum(needed, 1e-12), np.inf)
        if robot is not None:  # a reserve that a pose cannot keep is none
            shares[:, ~held.ok] = 0.0
        allowed = 0.5 * beads.sizes(samples.move[at])[0] if job.max_error is None else job.max_error
        far = np.where(samples.extruding[at], found.displacement, np.nan)
        errors = _ERROR_SHARE * allowed / np.maximum(far, 1e-12)
        worst = min(worst, float(shares.min()), float(np.nanmin(errors, initial=np.inf)))
        let_go((samples, law))
    return worst, most[0], most[1]
