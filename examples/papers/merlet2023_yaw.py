"""Merlet and Papegay 2023, section IV: the drum's yaw held by a drive, beside the same machine without one.

Prints a ring with the same seeds at 10 ms, with each estimator, with and without the drive: true and estimated errors
and computing time. --no-gyro does so on a machine without its accelerometer and gyro, where lidars alone know the yaw.
The paper expects a more accurate estimation in less computing time, and has no numbers.
"""

import argparse
import json
import tempfile
from pathlib import Path

import numpy as np

import cablewright as cw
from cablewright.machine.carried_load import YawDrive

RING = {
    "name": "ring",
    "origin": [0.3, -0.5, 0.0],
    "helix": {"radius": 0.35, "layers": 1, "layer_height": "1 mm", "first_height": "1 m"},
    "motion": {"print_speed": "3 cm/s", "travel_speed": "3 cm/s", "acceleration": "20 mm/s^2"},
}
DRIVE = YawDrive(max_speed=0.5, max_torque=5.0, lag=0.02)  # assumed: the paper has no drive
SKIPPED = 10.0  # s of printing before errors count: the drum begins with the yaw of its twist


def figures(folder: Path) -> dict[str, float]:
    """Errors of one print's log, and its computing time."""
    rows = []
    with cw.read_log(folder) as log:
        begun = None
        for entry in log.entries():
            if entry.progress is None or entry.progress.state != "printing" or entry.truth is None:
                continue
            begun = entry.frame.time if begun is None else begun
            if entry.estimate is None or entry.frame.time < begun + SKIPPED:
                continue
            off = entry.estimate.position - entry.truth.position
            yaw, true = entry.estimate.yaw, float(entry.truth.rotation[2])
            rows.append((true, yaw - true, np.hypot(*off[:2]), abs(off[2]), entry.truth.rate[2]))
    held, yaw, level, height, rate = np.array(rows).T
    metrics = json.loads((folder / "metrics.json").read_text())
    steps = metrics["step_time"]
    return {
        "yaw of the drum, deg rms": float(np.degrees(np.sqrt(np.mean(held**2)))),
        "its rate, deg/s rms": float(np.degrees(np.sqrt(np.mean(rate**2)))),
        "error of the estimated yaw, deg rms": float(np.degrees(np.sqrt(np.mean(yaw**2)))),
        "error of the estimated place in plan view, mm rms": 1e3 * float(np.sqrt(np.mean(level**2))),
        "most, mm": 1e3 * float(level.max()),
        "error of the estimated height, mm rms": 1e3 * float(np.sqrt(np.mean(height**2))),
        "true error beside the path, mm rms": 1e3
        * float(np.hypot(np.sqrt(metrics["path_error_variance"]), metrics["mean_path_error"])),
        "largest, mm": 1e3 * float(metrics["max_path_error"]),
        "processor time of a step, ms": 1e3 * steps["processor_mean"],
        "its 99 % quantile, ms": 1e3 * steps["processor_p99"],
    }


def main() -> None:
    """All of it."""
    options = argparse.ArgumentParser()
    options.add_argument("--seeds", type=int, default=5)
    options.add_argument("--first", type=int, default=101)
    options.add_argument("--no-gyro", action="store_true")
    given = options.parse_args()
    robot, twin = cw.load("merlet2023"), cw.load_twin("merlet2023")
    if given.no_gyro:
        twin = twin.with_owner(inertial=None)
    drum = twin.owner.point_drum.model_copy(update={"yaw_drive": DRIVE})
    machines = {"free": twin, "held": twin.with_owner(drum=drum)}
    found: dict[tuple[str, str], list[dict[str, float]]] = {}
    with tempfile.TemporaryDirectory() as folder:
        job = cw.Job.model_validate(RING)
        for seed in range(given.first, given.first + given.seeds):
            for estimator in ("paper", "filter"):
                for name, machine in machines.items():
                    out = Path(folder) / f"{name}-{estimator}-{seed}"
                    options_ = cw.PrintOptions(estimator, seed=seed)
                    cw.print_job(robot, job, out, machine=machine, options=options_)
                    found.setdefault((estimator, name), []).append(figures(out))
    columns = [(estimator, name) for estimator in ("paper", "filter") for name in machines]
    print(f"{'mean of ' + str(given.seeds) + ' seeds':52}" + "".join(f"{a + ' ' + b:>14}" for a, b in columns))
    for title in next(iter(found.values()))[0]:
        cells = [np.mean([each[title] for each in found[column]]) for column in columns]
        print(f"{title:52}" + "".join(f"{cell:14.3f}" for cell in cells))


if __name__ == "__main__":
    main()
