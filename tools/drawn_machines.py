"""Share of drawn machines that print a job within the expected error that `check` reports, each built and solved.

``python -m tools.drawn_machines --machines 100 --random 40``. Robots of the library print a ring and a square where
they hold one; random robots print their jobs. Each machine is a robot of its own with drawn numbers; the forward
problem of the lengths that `check` gives for the robot of the file is solved at some samples that lay material.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count, product
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from tools.random_prints import random_print

from cablewright.analyses.accuracy.spread import drawn
from cablewright.foundation.errors import InputError
from cablewright.models.statics import Model
from cablewright.printing.job import Job
from cablewright.robot import Robot, load
from cablewright.robot.parameters import with_value
from cablewright.robot.uncertainty import assumed_uncertainty
from cablewright.solvers.forward import forward
from cablewright.solvers.inverse import inverse
from cablewright.studies.checks.check import check
from cablewright.studies.checks.result import Check

LIBRARY = (
    "building-printer", "caroca", "cogiro", "hangprinter-v4", "house-printer", "ipanema", "jung2020", "maslow4",
    "merlet2023", "nist-robocrane", "wang2021",
)  # fmt: skip
LEVEL, LEAST = 0.95, 0.87
"""Share of all machines, less two standard errors, and of those of each robot, that are to be within."""

SLACK = 0.05  # of a robot's minimum tension: a line that carries less has gone slack


@dataclass(frozen=True)
class Share:
    """How many of a robot's machines are within its expected error."""

    name: str
    expected: float  # m; NaN where it is not stated
    machines: int
    within: int
    slack: int  # machines of which a line goes slack
    level: float  # m: 95 of 100 of the machines are within it

    def __str__(self) -> str:
        """One row of a table."""
        if math.isnan(self.expected):
            return f"{self.name:24s} not stated"
        return (
            f"{self.name:24s} {1e3 * self.expected:9.3f} {1e3 * self.level:9.3f} {self.within:5d} of {self.machines}"
            f" {self.slack:6d}"
        )


def share(name: str, found: Check, machines: int, samples: int, seed: int) -> Share:
    """Return the share of drawn *machines* at so many *samples* that lay material; *found*: of the robot's file."""
    assert found.expected is not None
    rows = np.flatnonzero(found.samples.extruding)
    rows = rows[np.linspace(0, len(rows) - 1, min(samples, len(rows))).astype(int)]
    poses, lengths, wanted = found.poses[rows], found.lengths[rows], found.samples.positions[rows]
    uncertain = found.robot.uncertainty or assumed_uncertainty(found.robot)
    ranges, zero = uncertain.of(found.robot), uncertain.zeroed_at
    if zero is not None:  # a row more, by which coordinates of each machine are shifted
        poses, wanted = np.vstack([poses, zero]), np.vstack([wanted, zero])
        lengths = np.vstack([lengths, inverse(found.robot, zero).lengths])
    least = min(line.tension_limits[0] for line in found.robot.lines)
    errors, slack = np.empty(machines), 0
    for k, values in enumerate(drawn(ranges, machines, seed)):
        robot, paid_out = found.robot, lengths.copy()
        for each, value in zip(ranges, values, strict=True):
            paid_out += np.multiply(value - each.nominal, each.zeroing or 0.0)
            if each.parameter.kind == "length_offset":
                paid_out[:, [each.parameter.of_line(line.name) for line in robot.lines]] += value
            else:
                robot = with_value(robot, each.parameter, value)
        reached = forward(robot, paid_out, guess=poses)
        away = Model(robot).nozzle(reached.pose) - wanted
        off = np.linalg.norm(away if zero is None else away - away[-1], axis=1)
        errors[k] = np.where(reached.ok, off, np.inf).max()
        slack += bool(np.nanmin(reached.extremes()[0]) < SLACK * least)
    value = found.expected.value
    level = float(np.sort(errors)[math.ceil(LEVEL * machines) - 1])
    return Share(name, value, machines, int((errors <= value).sum()), slack, level)


def library_jobs(name: str, folder: Path) -> Iterator[tuple[str, Robot, Job]]:
    """Yield rings and squares of up to a third of the frame's width, at some heights of a robot of the library."""
    robot = load(name)
    low, high = np.array(robot.scene.frame_min), np.array(robot.scene.frame_max)
    middle, size = 0.5 * (low + high), float(np.sort(high - low)[-2])
    plane = robot.platform.plane
    for height, part in product((0.15, 0.3, 0.45, 0.6, 0.02), (0.17, 0.1, 0.05)):
        z = float(low[2] + height * (high[2] - low[2]))
        origin = (float(middle[0]), float(middle[1]), 0.0)
        helix = {"radius": part * size, "layers": 1, "layer_height": 0.005, "first_height": max(z, 0.01)}
        if plane is None:
            yield f"{name}, ring", robot, Job.model_validate({"name": "ring", "origin": origin, "helix": helix})
        file, half = folder / "square.gcode", 1e3 * part * size
        normal = np.array([0.0, 0.0, 1.0]) if plane is None else np.array(plane.across)
        up = np.cross(normal, [1.0, 0.0, 0.0]) * 1e3
        middle = np.array([middle[0], middle[1], z])
        if plane is not None:
            middle = middle - plane.height(middle) * normal
        corners = [1e3 * middle + half * (a * np.array([1.0, 0, 0]) + b * up / 1e3) for a, b in _SQUARE]
        file.write_text("G21\nG90\nM83\n" + "\n".join(f"G1 X{a:.6f} Y{b:.6f} Z{c:.6f} E5" for a, b, c in corners))
        yield f"{name}, square", robot, Job.model_validate({"name": "square", "gcode": str(file)})


_SQUARE = ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))


def shares(machines: int, samples: int, random: int, seed: int) -> Iterator[Share]:
    """Yield the share of each robot and job whose poses are held; each draws its own machines."""
    seeds = count(seed)
    with TemporaryDirectory() as folder:
        for name in LIBRARY:
            done: set[str] = set()
            for label, robot, job in library_jobs(name, Path(folder)):
                if label not in done and (found := _checked(robot, job)) is not None:
                    done.add(label)
                    yield share(label, found, machines, samples, next(seeds))
        number = 0
        while random:
            robot, job = random_print(seed, number, Path(folder))
            number += 1
            if (found := _checked(robot, job)) is not None:
                random -= 1
                yield share(f"random {number - 1}", found, machines, samples, next(seeds))


def _checked(robot: Robot, job: Job) -> Check | None:
    """Return the check of a job, None where the robot cannot hold it."""
    try:
        found = check(robot, job, skip=("interference",))
    except InputError:
        return None
    held = not found.codes.any() and found.expected is not None and found.expected.sample is not None
    return found if held else None


def main() -> int:
    """Print a row of each robot and the pooled share; 1 where one is too small."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--machines", type=int, default=100, help="drawn of each robot")
    parser.add_argument("--samples", type=int, default=200, help="of the path, at which they are solved")
    parser.add_argument("--random", type=int, default=40, help="random robots")
    parser.add_argument("--seed", type=int, default=7)
    given = parser.parse_args()
    print(f"{'robot':24s} {'expected':>9s} {'95 %, mm':>9s} {'within':>12s} {'slack':>6s}")
    found = []
    for each in shares(given.machines, given.samples, given.random, given.seed):
        print(each, flush=True)
        found.append(each)
    known = [each for each in found if not math.isnan(each.expected)]
    total, within = sum(each.machines for each in known), sum(each.within for each in known)
    least = LEVEL - 2.0 * math.sqrt(LEVEL * (1.0 - LEVEL) / total)
    few = [each.name for each in known if each.within < LEAST * each.machines]
    print(f"{within} of {total} machines are within: {within / total:.4f}, at least {least:.4f} is expected")
    print(f"robots with less than {LEAST:.0%} within: {', '.join(few) or 'none'}")
    return 1 if few or within / total < least else 0


if __name__ == "__main__":
    sys.exit(main())
