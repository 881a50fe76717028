"""A simulated machine goes along a path for a minute; what its encoders say of the lengths, and what is true."""

import math

import cablewright as cw

robot, settings = cw.load("merlet2023"), cw.load_machine("merlet2023")
way = cw.random_loop(robot, 28.0, seed=7)  # 28 m, closed
machine = cw.SimulatedMachine(robot, settings, [*way[0], 1.2], seed=7, plant="quasi-static")
pilot, begin = cw.Pilot(machine, way, cw.DriveSettings(), seed=7), machine.truth.lengths
frame = cw.SensorFrame(0.0)
while machine.time < 60.0:
    frame = machine.step(pilot.command())  # a controller would make its commands from frames alone

turned = frame.of(cw.Encoders)[-1].counts * 2.0 * math.pi / (settings.winch.counts * settings.winch.ratio)  # rad, drums
for line, turn, paid in zip(robot.lines, turned, machine.truth.lengths - begin, strict=True):
    said = turn * line.winch.drum_radius
    print(f"{line.name} paid out {1e3 * paid:7.1f} mm; by its encoder and the file's drum radius {1e3 * said:7.1f} mm")
worst = max(abs(turned * robot.lines[0].winch.drum_radius - (machine.truth.lengths - begin)))
print(f"off by up to: {1e3 * worst:.1f} mm")
