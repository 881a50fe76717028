"""Machines of the library on virtual CANopen drives, for tests."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from cablewright.control.path_follower import TimedPath
from cablewright.foundation.signals import Command, Order, OrderKind, PrintState, SensorFrame, WinchMode
from cablewright.live.estimators import estimator
from cablewright.live.prints import loop
from cablewright.live.prints.limits import planned
from cablewright.live.prints.loop import Printer, Step
from cablewright.live.prints.simulated_operator import Attendant
from cablewright.machine.drives.canopen_drives import CanopenDrives
from cablewright.machine.drives.cia402 import PowerState
from cablewright.machine.drives.drive_machine import DriveMachine
from cablewright.machine.drives.local_can_bus import Hub
from cablewright.machine.drives.settings import WinchDriveSettings
from cablewright.machine.drives.virtual.rig import Disturb, VirtualPort, VirtualRig, run_rig
from cablewright.machine.files import machine_names
from cablewright.machine.interface import Machine
from cablewright.machine.sensors.encoders import Encoder
from cablewright.machine.sensors.tensions import TensionSensor
from cablewright.machine.simulated.machine_file import built_machine
from cablewright.machine.simulated.settings import TwinSettings, load_twin
from cablewright.machine.simulated.simulated_machine import SimulatedMachine
from cablewright.machine.simulated.unmodelled.effect_sizes import WinchBrakes
from cablewright.printing.job import Job, Motion
from cablewright.printing.numeric_path import Helix
from cablewright.robot import Robot, load

HELD = (0.3, -0.5, 1.0)
RATED = {
    "merlet2023": 0.5,
    "house-printer": 20.0,
    "ipanema": 2.0,
    "cogiro": 4.0,
    "maslow4": 2.0,
    "jung2020": 5.0,
    "grab-four-lines": 1.0,
    "crane": 1.0,
    "hoist": 1.0,
    "pairs": 1.0,
    "two on one": 1.0,
}
"""N m of the motors."""
RING = Job(
    name="ring",
    origin=(0.5, -0.5, 0.0),
    helix=Helix(radius=0.2, layers=1, layer_height=0.001, first_height=1.0),
    motion=Motion(print_speed=0.1, travel_speed=0.1, acceleration=0.1),
)
ON = (Order(OrderKind.RESET), Order(OrderKind.ENABLE))


def virtual_twin(name: str | Robot = "merlet2023", flow: float | None = None, **changes: Any) -> TwinSettings:
    """A machine of the library whose winches are on virtual drives; half of them turn the other way.

    *flow*: kg/s of powder in place of its own.
    """
    robot = load(name) if isinstance(name, str) else name
    twin = load_twin(robot.name) if robot.name in machine_names() else built_machine(robot)[0]
    if flow is not None:
        twin = twin.with_owner(drum=twin.owner.point_drum.model_copy(update={"flow": flow}))
    nodes = {winch: {"id": k + 1, "direction": (1, -1)[k % 2]} for k, winch in enumerate(robot.winch_names)}
    table = {"interface": "loopback", "channel": "43113", "nodes": nodes, "tension": 30.0}
    table["rated_torque"] = RATED[robot.name]
    gone = dict.fromkeys(
        ("retraction", "inertial", "line_angles", "distance", "climate_sensor", "barrier", "load_cells", "swivels")
    )
    regular = twin.simulation.winch.model_copy(update={"radius_walk": 2e-5, "sideways_walk": 2e-4})  # grooved drums
    winch = twin.owner.winch.model_copy(update={"max_speed": min(twin.owner.winch.max_speed, 12.0)})
    return twin.with_simulation(winch=regular).with_owner(
        kind="canopen",
        winch=winch,
        drives=WinchDriveSettings.model_validate(table | changes),
        encoders=Encoder(rate=100.0),
        motor_torques=TensionSensor(rate=100.0, deviation=1.0, most=1e4),
        lidars={},
        **gone,
    )


@dataclass
class Bench:
    """A machine on virtual drives in virtual time, and what is behind it."""

    robot: Robot
    twin: TwinSettings
    rig: VirtualRig
    port: VirtualPort
    machine: DriveMachine
    frames: list[SensorFrame] = field(default_factory=list)

    @property
    def drives(self) -> CanopenDrives:
        found = self.machine.drives
        assert isinstance(found, CanopenDrives)
        return found

    def step(self, mode: WinchMode = WinchMode.OFF, speeds: Any = None, steps: int = 1, **more: Any) -> SensorFrame:
        """Command all winches equally, for some steps."""
        m = len(self.rig.names)
        given = np.zeros(m) if speeds is None else np.array(speeds, dtype=float)
        for _ in range(steps):
            self.frames.append(self.machine.step(Command(self.port.now(), given, modes=(mode,) * m, **more)))
        return self.frames[-1]

    def hang(self, seconds: float) -> None:
        """Let time go by as if this process had been stopped."""
        end = self.port.now() + seconds
        while self.port.now() < end - 1e-6:
            self.port.receive(end)


def bench(
    name: str | Robot = "merlet2023",
    disturb: Disturb | None = None,
    rig: dict[str, Any] | None = None,
    begin: tuple[float, ...] | None = None,
    brakes: WinchBrakes | None = None,
    **changes: Any,
) -> Bench:
    """A machine, not yet open."""
    robot, twin = load(name) if isinstance(name, str) else name, virtual_twin(name, **changes)
    twin = twin.with_simulation(brakes=brakes or twin.simulation.brakes)
    behind = VirtualRig(robot, twin, begin or RING_BEGIN[robot.name], **(rig or {}))
    port = VirtualPort(behind, disturb)
    machine = DriveMachine(CanopenDrives(robot, twin.owner, lambda: port), twin.owner)
    return Bench(robot, twin, behind, port, machine)


RING_BEGIN = {
    "merlet2023": (0.7, -0.5, 1.0),
    "house-printer": (0.7, -0.5, 1.0),
    "cogiro": (0.1, 0.05, 0.8),
    "ipanema": (0.1, 0.05, 0.9),
    "maslow4": (0.1, 0.8 * 0.258819 / 0.965926, 0.8),
    "grab-four-lines": (1.2, 0.1, -0.2),
}
SPEEDS = (0.5, 0.5, -0.5, -0.5)


def moving(**more: Any) -> Bench:
    """A machine whose winches have turned for half a second."""
    found = bench(**more)
    found.machine.open()
    found.step(steps=3)
    found.step(WinchMode.VELOCITY)
    found.step(WinchMode.VELOCITY, SPEEDS, 50)
    assert not found.machine.tripped
    return found


def braked(found: Bench) -> bool:
    """Whether all brakes are closed."""
    return all(drive.brake_closed for drive in found.rig.drives)


EXAMPLE = Path(__file__).parents[1] / "examples" / "virtual-drives.toml"


@dataclass
class Watched:
    """Drives in this process, on a thread, and what their plant showed."""

    rig: VirtualRig
    channel: int
    tensions: list[float] = field(default_factory=list)

    @property
    def braked(self) -> bool:
        """Whether all brakes are closed."""
        return all(drive.brake_closed for drive in self.rig.drives)

    def wait(self, what: str, seconds: float = 10.0) -> None:
        """Wait until all drives are in a state, by its name."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if all(drive.state is PowerState[what] for drive in self.rig.drives):
                return
            time.sleep(0.005)
        raise AssertionError([drive.state for drive in self.rig.drives])


@contextmanager
def watched_drives(file: Path | None = None) -> Iterator[Watched]:
    """Drives of merlet2023 on a thread, until the end: those of `virtual_twin`, or of the example written to *file*."""
    robot, over, hub = load("merlet2023"), threading.Event(), Hub(0)
    channel = hub._socket.getsockname()[1]
    if file is not None:
        file.write_text(EXAMPLE.read_text("utf-8").replace('"43113"', f'"{channel}"'), encoding="utf-8")
    rig = VirtualRig(robot, virtual_twin() if file is None else load_twin(file), RING_BEGIN["merlet2023"])
    rig.warm()
    found = Watched(rig, channel)

    def ends() -> bool:
        found.tensions.append(float(rig.plant.truth.tensions.max()))
        return over.is_set()

    thread = threading.Thread(target=run_rig, args=(rig, hub, ends), daemon=True)
    thread.start()
    try:
        yield found
    finally:
        over.set()
        thread.join(timeout=10.0)
        hub.close()


def true_poses(job: Job, machine: Machine, plant: SimulatedMachine, found: Bench) -> np.ndarray:
    """Return the true poses (k, 6) of *plant* in the steps in which *machine* prints *job*."""
    robot, settings, poses = found.robot, found.twin.owner, []
    path = TimedPath.of(job, None, 0.0, robot.platform.own_nozzle)
    plan = planned(robot, settings, path, settings.period, "encoders", "model", None)
    printer = Printer(plan, machine, lambda pose, _radii: estimator("encoders", robot, settings, pose))

    class Kept:
        def add(self, _printer: Printer, step: Step, *, last: bool) -> None:
            if step.progress.state is PrintState.PRINTING:
                poses.append(np.concatenate([plant.truth.position, plant.truth.rotation]))

    loop.run(printer, Attendant(lambda: None), Kept())
    assert printer.finished, printer.supervisor.reason
    return np.array(poses)
