"""Accuracy with uncertain numbers, and which of them contribute most."""

from pathlib import Path

import cablewright as cw

robot = cw.load("house-printer")
uncertain = cw.load_uncertainty(Path(__file__).with_name("uncertain.toml")).of(robot)
for compensation in ("none", "full"):
    found = cw.accuracy(robot, [[5.0, 4.0, 1.0]], uncertain, compensation=compensation)
    nominal, largest = found.nominal_error[0], found.spread.max_error[0]
    print(f"compensation {compensation}: nominal error {1e3 * nominal:.1f} mm, largest {1e3 * largest:.1f} mm")
sizes = (found.spread.effects[0] ** 2).sum(axis=0) ** 0.5
for each, size in sorted(zip(uncertain, sizes, strict=True), key=lambda pair: -pair[1])[:3]:
    print(f"  {each.parameter.label} moves it by {1e3 * size:.1f} mm")
best = cw.accuracy(robot, [5.0, 4.0, 1.0], uncertain).best
assert best is not None  # more lines than degrees of freedom leave a choice of tensions
print(f"largest deviation with tensions chosen to hold it best: {1e3 * best.max_deviation:.1f} mm")
