"""A body on eight lines prints: tensions by encoders alone, and closed on load cells."""

import tempfile

import cablewright as cw

robot = cw.load("cogiro")
job = cw.Job.model_validate({
    "name": "ring",
    "origin": [0.5, -0.5, 0.0],
    "helix": {"radius": 1.0, "layers": 1, "layer_height": "12 mm", "first_height": "0.5 m"},
    "motion": {"print_speed": "5 cm/s", "travel_speed": "5 cm/s", "acceleration": "50 mm/s^2"},
})  # fmt: skip

for estimator in ("encoders", "filter"):
    options = cw.PrintOptions(estimator, plant="quasi-static", period=0.5, seed=3)
    with tempfile.TemporaryDirectory() as folder:
        found = cw.print_job(robot, job, f"{folder}/run", options=options).record.whole
    print(f"{estimator}: nozzle within {1e3 * found.position_max:.1f} mm of its target")
    print(f"{estimator}: a tension within its limits by at least: {found.min_tension_margin:.0f} N")
