"""Seams of 100 machines: how far apart two stages print at their seam, beside what the verdict expects.

Each machine is built within the tolerances of a simulated machine; its exit points are set to each stage by hand, and
calibrated by simulated measurements as `cablewright print` does them. The nozzle is then where the true lines hold it
for the lengths that the calibrated robot commands, from the home lengths that the calibration found.

Run it from the repository root: ``python -m benchmarks.campaigns.stage_seams [--machines 100] [--workers 2]``.
"""

from __future__ import annotations

import argparse
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import numpy as np

import cablewright as cw
from cablewright.calibration.drift.record import CalibrationRecord, record_of
from cablewright.calibration.measurements import write_measured
from cablewright.machine.simulated.as_built import as_built
from cablewright.machine.simulated.machine_file import built_machine
from cablewright.models.job_stages import JobStage, stages_of
from cablewright.printing.schedule import Stage
from cablewright.robot.uncertainty import assumed_uncertainty
from cablewright.studies.stages.recalibration import PLAN, POSITION, as_set, fitted, measured
from cablewright.studies.stages.seam import PLACES, seam_of

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
RAISED, FROM = 2.0, 2.02  # m: the stages that `cablewright stages` finds for the wall


def stages() -> tuple[cw.Robot, tuple[JobStage, ...]]:
    """Return the robot and the stages of the wall of the examples."""
    robot, job = cw.load(str(EXAMPLES / "rails.toml")), cw.load_job(EXAMPLES / "wall.toml")
    return robot, stages_of(robot, job.model_copy(update={"stages": (Stage(z=FROM, raised=RAISED),)}))


def printed(
    stage: JobStage, seed: int, places: np.ndarray, position: float, folder: Path
) -> tuple[np.ndarray, JobStage, CalibrationRecord, str]:
    """Return where a machine prints *places* (N, 3), m, in a stage, its calibrated stage, the record and the verdict.

    *position*: standard deviation of the measured positions, m.
    """
    tolerances = built_machine(stage.robot)[0].simulation.tolerances
    true = as_built(as_set(stage, seed), tolerances, seed)
    made = measured(stage, true, seed, position)
    data, plan = folder / f"{seed}-{stage.number}.csv", folder / "plan.toml"
    data.write_text(write_measured(made.measured, true, ()))
    plan.write_text(PLAN)
    found = fitted(stage, data, plan)
    home = found.values[[each.name == "length_offset" for each in found.unknowns]]
    counts = cw.inverse(found.robot, places, cable="catenary").lengths - home
    nozzle = cw.forward(true, made.home_lengths + counts, guess=places, cable="catenary").pose
    return nozzle, replace(stage, robot=found.robot), record_of(found, data, datetime.now(UTC)), found.verdict


def seam(seed: int, position: float) -> tuple[float, float, str]:
    """Return the seam of one machine, m, what its calibrations let expect, m, and the worse verdict of both."""
    robot, (below, above) = stages()
    x = np.linspace(-0.75, 0.75, PLACES)
    places = np.stack([x, np.zeros(PLACES), np.full(PLACES, FROM - 0.02)], axis=1)
    with tempfile.TemporaryDirectory() as folder:
        both = [printed(each, seed, places, position, Path(folder)) for each in (below, above)]
    records = both[0][2], both[1][2]
    expected = seam_of(both[0][1], both[1][1], assumed_uncertainty(robot), records, allowed=1.0)
    apart = float(np.linalg.norm(both[0][0] - both[1][0], axis=1).max())
    return apart, expected.value, max(both[0][3], both[1][3], key=["good", "doubtful", "bad"].index)


def main() -> None:
    """Print the table."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--machines", type=int, default=100)
    asked.add_argument("--workers", type=int, default=2)
    asked.add_argument("--position", type=float, default=POSITION, help="of the measured positions, m")
    given = asked.parse_args()
    with ProcessPoolExecutor(given.workers, mp_context=get_context("spawn")) as pool:
        rows = list(pool.map(partial(seam, position=given.position), range(given.machines)))
    apart, expected = np.array([row[:2] for row in rows]).T
    verdicts = [row[2] for row in rows]
    print(f"machines                        {len(rows)}, positions measured to {1e3 * given.position:g} mm")
    print(f"seam, median                    {1e3 * np.median(apart):.2f} mm")
    print(f"seam, 95 of 100                 {1e3 * np.sort(apart)[int(np.ceil(0.95 * len(apart))) - 1]:.2f} mm")
    print(f"seam, largest                   {1e3 * apart.max():.2f} mm")
    print(f"expected by the calibrations    {1e3 * expected.min():.2f} to {1e3 * expected.max():.2f} mm")
    print(f"machines within the expectation {np.count_nonzero(apart <= expected)}")
    print(f"good verdicts                   {verdicts.count('good')}")


if __name__ == "__main__":
    main()
