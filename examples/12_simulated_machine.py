"""A simulated machine: lengths by its encoders and true lengths."""

import math

import cablewright as cw

robot, twin = cw.load("merlet2023"), cw.load_twin("merlet2023")
way = cw.random_loop(robot, 28.0, seed=7)  # 28 m, closed
machine = cw.SimulatedMachine(robot, twin, [*way[0], 1.2], seed=7, plant="quasi-static")
pilot, begin = cw.Pilot(machine, way, cw.DriveSettings(), seed=7), machine.truth.lengths
frame = cw.SensorFrame(0.0)
while machine.time < 60.0:
    frame = machine.step(pilot.command())  # a controller would make its commands from frames alone

winch = twin.owner.winch  # the owner's settings
turned = frame.of(cw.Encoders)[-1].counts * 2.0 * math.pi / (winch.counts * winch.ratio)  # rad, drums
paid, radii = machine.truth.lengths - begin, [line.winch.drum_radius or math.nan for line in robot.lines]
said = turned * radii
for line, true, encoded in zip(robot.lines, paid, said, strict=True):
    print(
        f"{line.name} paid out {1e3 * true:7.1f} mm; by its encoder and the file's drum radius {1e3 * encoded:7.1f} mm"
    )
print(f"largest error: {1e3 * max(abs(said - paid)):.1f} mm")
