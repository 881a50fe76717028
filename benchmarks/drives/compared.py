"""A print on virtual CANopen drives in virtual time beside the same on the plant itself.

`python -m benchmarks.drives.compared house-printer examples/house.toml 2` prints two layers both ways: how far apart
the platform, the lengths paid out and the material left were at the same length of the path.

Refills are poured over half a minute. A suddenly filled drum drops by some millimetres and swings, with tensions
over the torque limit, to which drives yield as they must, and the plant without drives does not.
"""

from __future__ import annotations

import math
import sys
import time
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cablewright.control.path_follower import TimedPath
from cablewright.foundation.signals import Command, Encoders, Order, PrintState, SensorFrame
from cablewright.live.estimators import estimator
from cablewright.live.prints import loop
from cablewright.live.prints.limits import planned
from cablewright.live.prints.loop import Printer, Step
from cablewright.live.prints.simulated_operator import Attendant
from cablewright.machine.drives.canopen_drives import CanopenDrives
from cablewright.machine.drives.drive_machine import DriveMachine
from cablewright.machine.drives.settings import WinchDriveSettings
from cablewright.machine.drives.virtual.rig import VirtualPort, VirtualRig
from cablewright.machine.interface import Machine
from cablewright.machine.sensors.encoders import Encoder
from cablewright.machine.sensors.tensions import TensionSensor
from cablewright.machine.settings import extruding
from cablewright.machine.simulated.settings import Link, TwinSettings, load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.printing.job import load_job
from cablewright.robot import Robot, load

RATED = {"merlet2023": 0.5, "house-printer": 20.0}  # N m of the motors

Array = NDArray[np.float64]


class OpenOrShut(SimulatedMachine):
    """The plant itself, with a valve as an output of a drive opens it: open or shut."""

    def step(self, command: Command) -> SensorFrame:
        """As `Machine`."""
        return super().step(replace(command, valve=float(command.valve >= 0.5)))


POURED = 20.0  # s that a refill takes
STANDS = 2.0  # s until the platform stands


@dataclass
class Pouring(Attendant):
    """An attendant who pours powder slowly into the drum of a *plant* that stands."""

    plant: SimulatedMachine = field(kw_only=True)
    _since_refill: float = field(default=math.nan, repr=False)

    def orders(self, printer: Printer, now: float) -> tuple[Order, ...]:
        """As `Attendant`, with a little more powder each time."""
        if printer.supervisor.state is not PrintState.REFILLING:
            self._since_refill = math.nan
        elif math.isnan(self._since_refill):
            self._since_refill = now
        elif now - self._since_refill >= STANDS:
            left, full = self.plant.truth.powder, self.plant.settings.carrier.powder
            self.plant.refill(min(full, left + full * self.plant.period / POURED))
        return super().orders(printer, now)


@dataclass
class Kept:
    """Path length, true place, counts and material left of each step that printed."""

    plant: SimulatedMachine
    distances: list[float] = field(default_factory=list)
    places: list[Array] = field(default_factory=list)
    counts: list[NDArray[np.int64]] = field(default_factory=list)
    material: list[Array] = field(default_factory=list)  # (1,) kg

    def add(self, _printer: Printer, step: Step, *, last: bool) -> None:  # noqa: ARG002
        """As `StepRecorder`."""
        found = step.frame.of(Encoders)
        if step.progress.state is PrintState.PRINTING and found:
            self.distances.append(step.progress.distance)
            self.places.append(self.plant.truth.position)
            self.counts.append(found[-1].counts)
            self.material.append(np.array([self.plant.truth.powder]))

    def at(self, rows: list[Array] | list[NDArray[np.int64]], distances: Array) -> Array:
        """Rows at path lengths, linearly between steps."""
        return np.column_stack([np.interp(distances, self.distances, axis) for axis in np.array(rows).T])


def on_drives(robot: Robot, twin: TwinSettings) -> TwinSettings:
    """The same machine with its winches on drives; encoders come without delay both ways."""
    nodes = {line.name: {"id": k + 1, "direction": (1, -1)[k % 2]} for k, line in enumerate(robot.lines)}
    table = {"interface": "loopback", "channel": "43113", "nodes": nodes, "tension": 30.0}
    table["valve"] = {"line": robot.lines[0].name, "bit": 16, "closes_alone": True}
    gone = dict.fromkeys(("inertial", "line_angles", "distance", "climate_sensor", "barrier"))
    return twin.with_simulation(wire=Link()).with_owner(
        kind="canopen",
        drives=WinchDriveSettings.model_validate(table | {"rated_torque": RATED[robot.name]}),
        encoders=Encoder(rate=100.0),
        motor_torques=TensionSensor(rate=100.0, deviation=1.0, most=1e5),
        lidars={},
        **gone,
    )


def compare(name: str, job_file: Path, layers: int) -> None:
    """Print both ways, and print how far apart they are."""
    robot, job = load(name), load_job(job_file)
    twin = on_drives(robot, load_twin(name))
    owner = extruding(twin.owner, job.bead, job.motion.print_speed)
    twin = twin.model_copy(update={"owner": owner})
    path = TimedPath.of(job, layers, 0.0 if owner.extrusion is None else owner.point_drum.valve)
    begin = path.track.at(0.0).position
    rig = VirtualRig(robot, twin, begin)
    machine = DriveMachine(CanopenDrives(robot, owner, lambda: VirtualPort(rig)), owner)
    bare = twin.with_owner(motor_torques=None)
    there = _printed(robot, twin, path, machine, rig.plant)
    plant = OpenOrShut(robot, bare, begin, seed=0)
    here = _printed(robot, bare, path, plant, plant)
    ends = max(here.distances[0], there.distances[0]), min(here.distances[-1], there.distances[-1])
    at = np.linspace(*ends, 20_000)
    apart = np.linalg.norm(here.at(here.places, at) - there.at(there.places, at), axis=1)
    radius = robot.lines[0].winch.drum_radius or 0.0
    count = 2.0 * np.pi * radius / (owner.winch.counts * owner.winch.ratio)
    lengths = count * np.abs(here.at(here.counts, at) - there.at(there.counts, at))
    print(
        f"{name}, {layers} layers, {path.track.length:.1f} m: platform {1e3 * apart.max():.3f} mm apart at most, ",
        end="",
    )
    print(
        f"{1e3 * float(np.median(apart)):.3f} mm in half of all places; lengths {1e3 * lengths.max():.3f} mm, ", end=""
    )
    print(f"{1e3 * float(np.median(lengths)):.3f} mm; a count of an encoder is {1e3 * count:.4f} mm")
    weights = np.abs(here.at(here.material, at) - there.at(there.material, at))
    print(f"material left {1e3 * weights.max():.1f} g apart at most, {1e3 * float(np.median(weights)):.1f} g in half")
    print(machine.drives.statistics.figures(owner.period, 1_000_000))


def _printed(
    robot: Robot,
    twin: TwinSettings,
    path: TimedPath,
    machine: Machine,
    plant: SimulatedMachine,
) -> Kept:
    began, owner = time.monotonic(), twin.owner
    plan = planned(robot, owner, path, owner.period, "encoders", "model", None)
    printer = Printer(plan, machine, lambda place, radii: estimator("encoders", robot, owner, place, (), radii))
    kept = Kept(plant)
    attendant = Pouring(lambda: None, resume_delay=0.1, refill_time=POURED + 2.0 * STANDS, plant=plant)
    steps = loop.run(printer, attendant, kept)
    assert printer.finished, printer.supervisor.reason
    print(f"{steps} steps in {time.monotonic() - began:.0f} s", flush=True)
    return kept


if __name__ == "__main__":
    compare(sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]))
