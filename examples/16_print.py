"""A ring of powder printed by a machine that is not quite as described: seen by lidars, and by encoders alone."""

import tempfile
from pathlib import Path

import cablewright as cw
from cablewright.printing.job import Job
from cablewright.studies.prints.finish import finish
from cablewright.studies.prints.plan import Choices, twin_of
from cablewright.studies.prints.run import run_print

robot = cw.load("merlet2023")
job = Job.model_validate({
    "name": "ring",
    "origin": [0.3, -0.5, 0.0],
    "helix": {"radius": 0.6, "layers": 1, "layer_height": "1 mm", "first_height": "1 m"},
    "motion": {"print_speed": "3 cm/s", "travel_speed": "3 cm/s", "acceleration": "20 mm/s^2"},
})  # fmt: skip

for estimator in ("paper", "encoders"):
    twin = twin_of(robot, job, None, Choices(estimator, plant="quasi-static", seed=3))
    with tempfile.TemporaryDirectory() as name:
        run = run_print(twin, Path(name) / "run", {}, {})
        found, _ = finish(run.folder, twin.path.track, twin.path.print_speed, run.machine.rig.ground.field)
    believed, true = 1e3 * found.estimated.error.size, 1e3 * found.true.error.size
    print(f"{estimator}: by its own account at most {believed:.1f} mm beside the path, in truth: {true:.1f} mm")
