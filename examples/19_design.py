"""The height of the exit points that serves a column best, checked on the whole path."""

import cablewright as cw

robot = cw.load("house-printer")
job = cw.Job.model_validate({
    "name": "column",
    "helix": {"radius": 2.0, "layers": 3, "layer_height": "20 mm", "first_height": "20 mm"},
})  # fmt: skip

found = cw.design(robot, job, ["exit_point.z=6:15"], ["expected_error"], evaluations=60, population=10, seed=1)
best = found.chosen[0]
print(f"of {len(found.tried)} heights of the exit points the best is {best.values[0]:.1f} m, in place of 15 m")

for name, each in (("as it was", robot), ("designed", found.robot_of(best))):
    checked = cw.check(each, job, skip=["interference"])
    assert checked.feasible
    print(f"expected error on the whole path, {name}: {1e3 * checked.expected.value:.2f} mm")
