"""The recalibration before a stage: files for a person, a record with a verdict, and the simulated measurement.

Its folder has ``robot.toml`` (the robot with the exit points of the stage, as they are to be set) and ``plan.toml``
(exit points on vertical rails: heights are unknown, the rest nearly known). A person measures ``measured.csv``, and
`cablewright calibrate` writes ``calibrated.toml`` with its record beside it. Each file appears whole, the record last:
where the record is, the recalibration is done, and otherwise it goes on with the files that are there.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

import numpy as np

from cablewright.calibration.calibrate import calibrate
from cablewright.calibration.drift.record import CalibrationRecord, load_record, record_of, record_path, record_text
from cablewright.calibration.judgement.result import Calibration
from cablewright.calibration.measurements import write_measured
from cablewright.calibration.plan import load_plan
from cablewright.calibration.poses.simulation import SensorNoise, SimulatedCalibration, measure, random_poses
from cablewright.foundation.file_output import write_whole
from cablewright.models.fidelity import CableLaw
from cablewright.models.job_stages import JobStage, with_exit_points
from cablewright.robot import Robot, load
from cablewright.robot.write_back import update

POSES: Final = 40
ENCODER: Final = 1e-4  # m, standard deviation of the lengths
POSITION: Final = 5e-4  # m, of each coordinate of the nozzle at the poses
SET: Final = 5e-3  # m: error with which a simulated person sets the height of each exit point, at most
NEED: Final = 5e-3  # m, standard deviation of exit points for a good verdict: the seam judges their effect
_ABOVE: Final = 0.1  # m: lowest nozzle of a measured pose over the last layer
_ROUGH: Final = 0.05  # m

PLAN: Final = f"""schema = 1
# Exit points on vertical rails: each has an unknown height. Change the deviations to those of your rails.
unknowns = ["exit_point", "length_offset"]

[sigma]
encoder = {ENCODER}

[[priors]]
name = "exit_point.x"
deviation = 1e-3

[[priors]]
name = "exit_point.y"
deviation = 1e-3

[[priors]]
name = "exit_point.z"
deviation = 2e-2
"""


@dataclass(frozen=True, eq=False)
class Recalibration:
    """The recalibration before a *stage*, in its *folder*; *text* is that of the robot's file."""

    folder: Path
    stage: JobStage
    text: str

    @property
    def result(self) -> Path:
        """Path of the file of the calibrated robot."""
        return self.folder / "calibrated.toml"

    @property
    def data(self) -> Path:
        """Path of the file of the measurements."""
        return self.folder / "measured.csv"

    @property
    def steps(self) -> str:
        """Instructions for the person, in a sentence."""
        heights = ", ".join(f"{line.name} {line.exit_point[2]:g} m" for line in self.stage.robot.lines)
        robot, plan = self.folder / "robot.toml", self.folder / "plan.toml"
        return (
            f"stage {self.stage.number}: set the exit points to the heights {heights}; measure poses into {self.data} "
            f"(`cablewright calibrate {robot} {self.data} --plan {plan} --guide` names them); then `cablewright "
            f"calibrate {robot} {self.data} --plan {plan} --cable elastic --rough {_ROUGH:g} --need {NEED:g} --out "
            f"{self.result}`, and print again with --resume"
        )

    def prepare(self) -> None:
        """Write the files for the person, unless they exist."""
        for name, text in (("robot.toml", update(self.text, self.stage.robot)), ("plan.toml", PLAN)):
            if not (self.folder / name).exists():
                write_whole(self.folder / name, text.encode(), parents=True)

    def known(self) -> tuple[Robot, CalibrationRecord] | None:
        """Return the calibrated robot and its record; None before the calibration.

        Raises `InputError` where they do not agree.
        """
        path = record_path(self.result)
        if not path.exists():
            return None
        robot, record = load(str(self.result)), load_record(path)
        record.unknowns_in(robot, str(path))
        return robot, record

    def simulate(self, true: Robot, seed: int) -> str:
        """Measure the *true* robot and calibrate, unless that is done; return why there is no record, or ''."""
        if not self.data.exists():
            made, comments = measured(self.stage, true, seed), (f"simulated: stage {self.stage.number} of {true.name}",)
            write_whole(self.data, write_measured(made.measured, true, comments).encode())
        found = fitted(self.stage, self.data, self.folder / "plan.toml")
        if found.verdict == "bad":
            return f"stage {self.stage.number}: the recalibration is bad: {found.reasons[0]}"
        write_whole(self.result, update(self.text, found.robot).encode())
        record = record_text(record_of(found, self.data, datetime.now(UTC)))
        write_whole(record_path(self.result), record.encode())
        return ""


def measured(stage: JobStage, true: Robot, seed: int, position: float = POSITION) -> SimulatedCalibration:
    """Return simulated measurements of the *true* robot at poses above what the stages below have laid.

    *position*: standard deviation of each coordinate of the nozzle, m.
    """
    rng = np.random.default_rng([seed, 41, stage.number])
    (x, y, floor), top = true.scene.frame_min, true.scene.frame_max[2]
    above = (x, y, max(floor, min(stage.begin + _ABOVE, 0.5 * (stage.begin + top))))
    free = true.model_copy(update={"scene": true.scene.model_copy(update={"frame_min": above})})
    poses = random_poses(free, POSES, rng, CableLaw.ELASTIC)
    return measure(true, poses, ENCODER, rng, cable=CableLaw.ELASTIC, sensors=SensorNoise(pose=position))


def fitted(stage: JobStage, data: Path, plan: Path) -> Calibration:
    """Return the calibration of the robot in a stage from the files *data* and *plan*."""
    return calibrate(stage.robot, data, load_plan(plan), cable=CableLaw.ELASTIC, rough=_ROUGH, need=NEED)


def as_set(stage: JobStage, seed: int) -> Robot:
    """Return the robot of a *stage* with exit points as a simulated person sets them, with small errors."""
    off = np.random.default_rng([seed, 40, stage.number]).uniform(-SET, SET, stage.robot.m)
    points = ((x, y, z + dz) for (x, y, z), dz in zip(stage.exit_points.tolist(), off.tolist(), strict=True))
    return with_exit_points(stage.robot, list(points))
