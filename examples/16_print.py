"""A closed-loop print on a simulated machine, with lidars and with encoders alone."""

import tempfile

import cablewright as cw

robot = cw.load("merlet2023")
job = cw.Job.model_validate({
    "name": "ring",
    "origin": [0.3, -0.5, 0.0],
    "helix": {"radius": 0.6, "layers": 1, "layer_height": "1 mm", "first_height": "1 m"},
    "motion": {"print_speed": "3 cm/s", "travel_speed": "3 cm/s", "acceleration": "20 mm/s^2"},
})  # fmt: skip

for estimator in ("paper", "encoders"):
    options = cw.PrintOptions(estimator, plant="quasi-static", seed=3)
    with tempfile.TemporaryDirectory() as folder:
        found = cw.print_job(robot, job, f"{folder}/run", options=options).record
    believed, true = 1e3 * found.estimated.error.size, 1e3 * found.true.error.size
    print(f"{estimator}: by its own account at most {believed:.1f} mm beside the path, in truth: {true:.1f} mm")
