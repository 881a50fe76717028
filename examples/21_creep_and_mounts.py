"""Creep from a test, compliant masts, and the resulting position error."""

from pathlib import Path

import cablewright as cw

FOLDER = Path(__file__).parent
PLACE = [2.0, -1.5, 3.0]  # m

cable = cw.creep(FOLDER / "creep.csv", initial_length=2.0)
crept, sigma = cable.compliance_at(3600.0)
print(f"after an hour the cable has crept by {1e9 * crept:.0f} +- {1e9 * sigma:.1f} um/m under 1 kN")

robot = cw.load("house-printer")
lines = [line.model_dump() | {"exit_compliance": 2e-6} for line in robot.lines]  # m/N: masts give 2 mm under 1 kN
soft = cw.Robot.model_validate(robot.model_dump() | {"lines": lines})
stiffly, softly = (cw.inverse(each, PLACE).checked() for each in (robot, soft))
print("lengths differ by", (1e3 * (softly.lengths - stiffly.lengths)).round(1), "mm")
off = cw.forward(soft, stiffly.lengths).pose - PLACE
print("with lengths for stiff masts the error of the head is", (1e3 * off).round(1), "mm")

uncertain = cw.Uncertainty(
    parameters=[
        {"name": "creep_compliance", "range": [0.0, crept]},
        {"name": "exit_compliance", "range": [1e-6, 3e-6]},
    ]
)
found = cw.accuracy(soft, PLACE, uncertain.of(soft), compensation="full")
most = found.accuracy.spread.max_deviation[0]
print(f"both uncertain, and the lengths of the full model: {1e3 * most:.2f} mm")
