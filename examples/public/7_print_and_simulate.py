"""Print and simulate.

A machine with real imperfections, and prints in closed loop on it.
"""

import tempfile

import numpy as np

import cablewright as cw

job = cw.Job.model_validate(
    {
        "name": "dot",
        "origin": [0.3, -0.5, 0.0],
        "helix": {"radius": 0.1, "layers": 1, "layer_height": "1 mm", "first_height": "1 m"},
        "motion": {"print_speed": "3 cm/s", "travel_speed": "3 cm/s", "acceleration": "20 mm/s^2"},
    }
)
with tempfile.TemporaryDirectory() as folder:
    options = cw.PrintOptions("encoders", plant="quasi-static")
    printed: cw.PrintedJob = cw.print_job("merlet2023", job, f"{folder}/run", options=options)
    many: cw.Campaign = cw.campaign("merlet2023", job, 2, options=options, tried=0)
assert printed.finished

twin: cw.TwinSettings = cw.load_twin(cw.machine_names()[-1])
settings: cw.MachineSettings = cw.load_machine(cw.machine_names()[-1])  # what its owner knows
assert settings == twin.owner
only_simulated: cw.SimulationSettings = twin.simulation
robot = cw.load("merlet2023")
driven: cw.Simulation = cw.simulate(robot, twin, loop=28.0, duration=3.0, plant="quasi-static")
moves = cw.find_stages  # (robot, job, heights of the exit points): cw.Stages
recorded = (cw.replay, cw.read_log)  # both take a log; the first gives a
found: type[cw.Replay] = cw.Replay

loop = cw.random_loop(robot, 28.0, seed=1)
machine = cw.SimulatedMachine(robot, twin, [*loop[0], 1.2], seed=1, plant="quasi-static")
pilot = cw.Pilot(machine, loop, cw.DriveSettings(), seed=1)
command: cw.Command = pilot.command()
frame: cw.SensorFrame = machine.step(command)
readings = frame.of(cw.Encoders), frame.of(cw.Scan)

way = cw.Trajectory.through([[0.0, 0.0, 1.2], [0.1, 0.0, 1.2]], speed=0.1, acceleration=0.1)
loops: cw.LoopComparison = cw.compare_loops(robot, way, controllers=["model", "paper"], estimators=["truth"])
of_own_loops = (cw.Abilities, cw.Estimate, cw.Truth)  # what own estimators and plants are made of

field = cw.HeightField.flat((-1.0, -1.0), (1.0, 1.0), 0.02)
path = np.column_stack([np.linspace(-0.5, 0.5, 11), np.zeros((11, 2))])
cw.pour(field, path[:-1], path[1:], np.full(10, 0.1), cw.Powder())
