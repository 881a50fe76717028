"""A controller, an estimator and a plant of one's own beside ours, with the same seeds.

The controller goes towards the target by the Jacobian of straight cables, the estimator takes encoders for lengths, and
the plant is a machine without flaws but for the noise of its winches' speeds.
"""

import math

import numpy as np

import cablewright as cw


class TowardsTarget:
    """Feed the velocity forward, and correct a share of the error in each second."""

    def __init__(self, robot: cw.Robot, _settings: cw.MachineSettings) -> None:
        self.robot, self.gain = robot, 1.0  # 1/s

    def __call__(self, estimate, target, _period):
        motion = target.velocity + self.gain * (target.position - estimate.position)
        return cw.jacobian(self.robot, estimate.position) @ motion


class ByEncoders:
    """Count lengths on bare drums from the start, and take the pose at which they hold the platform."""

    def __init__(self, robot: cw.Robot, settings: cw.MachineSettings, start) -> None:
        self.robot, winch = robot, settings.winch
        self.radii = np.array([line.winch.drum_radius for line in robot.lines])
        self.per_count = self.radii * 2.0 * math.pi / (winch.counts * winch.ratio)
        self.start = cw.inverse(robot, start).lengths
        self.lengths, self.at = self.start, start

    def step(self, frame: cw.SensorFrame) -> cw.Estimate:
        for reading in frame.of(cw.Encoders):
            self.lengths = self.start + self.per_count * reading.counts
        found = cw.forward(self.robot, self.lengths, guess=self.at)
        self.at = found.pose if found.ok else self.at
        m, still = self.robot.m, np.zeros(3)
        told = frame.time, self.at, still, still, self.lengths, np.zeros(m), np.zeros(m, dtype=bool)
        return cw.Estimate(*told, radii=self.radii, valid=bool(found.ok))


class NoisyWinches:
    """Pay out at the speeds that are commanded, with 2 % of noise, and hang at rest in each step."""

    period = 0.2  # s

    def __init__(self, robot: cw.Robot, start, seed: int) -> None:
        self.robot, self.random, self.time = robot, np.random.default_rng(seed), 0.0
        self.radii = np.array([line.winch.drum_radius for line in robot.lines])
        self.held = cw.inverse(robot, start)
        self.abilities = cw.Abilities(robot.m, frozenset({"encoders"}), real_time=False, truth=self.truth)

    def truth(self) -> cw.Truth:
        held, still = self.held, np.zeros(3)
        lines = held.lengths, held.tensions, np.zeros(self.robot.m), self.radii
        return cw.Truth(self.time, held.pose, still, still, still, *lines, powder=0.0)

    def step(self, command: cw.Command) -> cw.SensorFrame:
        speeds = command.winch_speeds * self.random.normal(1.0, 0.02, self.robot.m)
        lengths = self.held.lengths + self.period * self.radii * speeds
        self.held = cw.forward(self.robot, lengths, guess=self.held.pose).checked()
        self.time += self.period
        return cw.SensorFrame(self.time)

    def open(self) -> None: ...
    def stop(self) -> None: ...
    def close(self) -> None: ...


robot = cw.load("merlet2023")
way = cw.Trajectory.through([[0.0, 0.0, 1.2], [0.4, 0.3, 1.2]], speed=0.1, acceleration=0.1)
alone = cw.compare_loops(
    robot,
    way,
    controllers=["model", TowardsTarget],
    estimators=["truth"],
    plants=["quasi-static", NoisyWinches],
    seeds=[1],
)
whole = cw.compare_loops(
    robot, way, controllers=["model", TowardsTarget], estimators=["encoders", ByEncoders], seeds=[1, 2]
)
for run in (*alone.runs, *whole.runs):
    print(f"{run.name}, seed {run.seed}: {1e3 * run.errors.max():.1f} mm at most")
worst = 1e3 * max(run.errors.max() for run in whole.runs[-2:])
print(f"own controller and estimator, the worse of two machines: {worst:.1f} mm")
