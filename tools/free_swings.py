"""Compare the library's `grab-prototype` with recorded swings of the real robot: the tables of docs/modes.md.

``python tools/free_swings.py [MARKERS.json]``. Measured frequencies are those of tests/analyses/free_swings.csv. With a
file of recorded markers, {"swings": {record: [marker][sample][x, y, z]}} at 50 Hz, modes are identified from them too.
"""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

import cablewright as cw
from cablewright.analyses.swing_identification import PERIODS, identify_swing
from cablewright.robot import Parameter, RigidPlatform, Robot, with_value

Array = NDArray[np.float64]
TABLE = Path(__file__).resolve().parents[1] / "tests" / "analyses" / "free_swings.csv"
UP = (0.008698898, -0.005823757, 0.999945205)  # the vertical in the source's axes
TURN = Rotation.align_vectors([(0.0, 0.0, 1.0)], [UP])[0]
STEP = 0.02  # s, of the markers


class Pose:
    """One pose of the table: lines, lengths, and measured frequencies and damping where there are any."""

    def __init__(self, row: dict[str, str]) -> None:
        """Read a row."""
        number = {key: float(text) if text else np.nan for key, text in row.items()}
        self.record, self.lines = row["record"], list(row["lines"])
        turn = TURN * Rotation.from_euler("XYZ", [number[key] for key in "abc"])
        self.pose = np.concatenate([TURN.apply([number[key] for key in "xyz"]), turn.as_rotvec()])
        self.lengths = [number[f"l{name}"] for name in self.lines]
        seen = {number[f"m{k}"]: number[f"d{k}"] for k in range(1, 5)}
        self.measured = {f: d for f, d in seen.items() if f == f}

    def model(self, robot: Robot) -> Array:
        """The frequencies of the motions that keep all lengths, Hz."""
        held = cw.forward(robot.with_lines(self.lines), self.lengths, guess=self.pose, cable="elastic").checked()
        return cw.modes(held).inextensible

    def errors(self, frequencies: Array) -> list[float]:
        """Relative differences of each measured frequency from the nearest of the model."""
        return [each / float(frequencies[abs(np.log(frequencies / each)).argmin()]) - 1.0 for each in self.measured]


def unstretched(robot: Robot) -> Robot:
    """The robot with cables that neither weigh nor stretch."""
    stiff = {"axial_stiffness": 1e9, "linear_density": 0.0}
    changed = (
        line.model_copy(update={"cable": line.cable.model_copy(update=stiff), "tension_limits": (0.0, 1e3)})
        for line in robot.lines
    )
    return robot.model_copy(update={"lines": tuple(changed)})


def with_inertia(robot: Robot, factor: float) -> Robot:
    """The robot with *factor* times its inertia."""
    platform = robot.platform
    assert isinstance(platform, RigidPlatform)
    assert platform.inertia is not None
    scaled = {
        "inertia": tuple(factor * each for each in platform.inertia),
        "inertia_products": tuple(factor * each for each in platform.inertia_products),
    }
    return robot.model_copy(update={"platform": platform.model_copy(update=scaled)})


def fits(poses: list[Pose], robot: Robot) -> None:
    """Print, for one number after the other, its fit to every second pose and what it predicts of the others."""
    height = robot.platform.centre_of_mass[2] if isinstance(robot.platform, RigidPlatform) else 0.0
    plain = {pose.record: pose.model(robot) for pose in poses}
    models: dict[str, Callable[[Pose, float], Array]] = {
        "none": lambda pose, _: plain[pose.record],
        "all frequencies, factor": lambda pose, x: plain[pose.record] * (1.0 + x),
        "inertia, factor": lambda pose, x: pose.model(with_inertia(robot, 1.0 + x)),
        "centre of mass z, m": lambda pose, x: pose.model(
            with_value(robot, Parameter("centre_of_mass.z"), height + 0.1 * x)
        ),
    }
    print("| one number | change | median error, 24 poses | 95 % are within | median difference |")
    print("| --- | --- | --- | --- | --- |")
    for name, model in models.items():

        def off(x: float, chosen: list[Pose], model: Callable[[Pose, float], Array] = model) -> Array:
            return np.array([each for pose in chosen if pose.measured for each in pose.errors(model(pose, x))])

        def cost(x: float, off: Callable[[float, list[Pose]], Array] = off) -> float:
            return float(np.sqrt(1.0 + (off(x, poses[::2]) / 0.01) ** 2).sum())

        fit = minimize_scalar(cost, bounds=(-0.12, 0.12), method="bounded", options={"xatol": 1e-3})
        found = 0.0 if name == "none" else float(fit.x)
        left = 100.0 * off(found, poses[1::2])
        change = f"{0.1 * found:+.4f} m" if name.endswith("m") else f"{100 * found:+.1f} %"
        size = np.abs(left)
        print(
            f"| {name} | {change} | {np.median(size):.1f} % | {np.percentile(size, 95):.1f} % "
            f"| {np.median(left):+.1f} % |"
        )


def markers(path: str, poses: list[Pose]) -> None:
    """Print the modes of recorded markers beside the table's, and how frequencies change while the swing decays."""
    swings = json.loads(Path(path).read_text("utf-8"))["swings"]
    by_record = {pose.record: pose for pose in poses}
    print("| record | table, Hz (damping, %) | here | frequency of the strongest mode, by quarters or halves |")
    print("| --- | --- | --- | --- |")
    for record, swing in swings.items():
        moved = np.array(swing, dtype=np.float64).transpose(1, 0, 2).reshape(len(swing[0]), -1)
        times = STEP * np.arange(len(moved), dtype=np.float64)
        found = identify_swing(times, moved)
        table, here = [], []
        for f, d in by_record[record].measured.items():
            i = int(abs(np.log(found.frequencies / f)).argmin())
            near = abs(found.frequencies[i] / f - 1.0) < 0.05
            table.append(f"{f:.4f} ({100 * d:.2f})")
            here.append(f"{found.frequencies[i]:.4f} ({100 * found.damping[i]:.2f})" if near else "-")
        main = found.frequencies[found.shares.argmax()]
        part = len(moved) // (4 if main * times[-1] > 4 * PERIODS else 2)
        starts = range(0, len(moved) - part + 1, part)
        parts = [identify_swing(times[k : k + part], moved[k : k + part]) for k in starts]
        course = [each.frequencies[abs(np.log(each.frequencies / main)).argmin()] for each in parts]
        print(f"| {record} | {', '.join(table)} | {', '.join(here)} | {', '.join(f'{f:.3f}' for f in course)} |")


def main() -> None:
    """Print the tables."""
    lines = [each for each in TABLE.read_text("utf-8").splitlines() if not each.startswith("#")]
    poses, robot = [Pose(row) for row in csv.DictReader(lines)], unstretched(cw.load("grab-prototype"))
    print("| lines | poses | frequencies | median difference | from 5 % to 95 % |\n| --- | --- | --- | --- | --- |")
    for count in (4, 3, 2):
        chosen = [pose for pose in poses if len(pose.lines) == count]
        off = 100.0 * np.concatenate([pose.errors(pose.model(robot)) for pose in chosen if pose.measured])
        low, middle, high = np.percentile(off, [5, 50, 95])
        print(f"| {count} | {len(chosen)} | {len(off)} | {middle:+.1f} % | {low:+.1f} to {high:+.1f} % |")
    print()
    fits(poses, robot)
    if len(sys.argv) > 1:
        print()
        markers(sys.argv[1], poses)


if __name__ == "__main__":
    main()
