"""`drives`: scan, show, write, enable, release, jog, tension, home; and virtual drives."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

import typer

import cablewright as cw
from cablewright.apps.cli.command import command, options
from cablewright.apps.cli.drives.machine_file import load_real
from cablewright.apps.cli.drives.terminal import Button, button
from cablewright.apps.cli.options import AsJson
from cablewright.apps.cli.output import answer, tell
from cablewright.apps.cli.parsing import begin_of, numbers
from cablewright.foundation.errors import InputError

if TYPE_CHECKING:
    from cablewright.live.drives.actions import OpenPort

Action = Literal["scan", "show", "write", "enable", "release", "jog", "tension", "home"]


@options()
class ActionOptions:
    """Options of single actions of `drives`."""

    place: Annotated[
        str | None,
        typer.Option(
            "--place",
            metavar="X,Y,Z[,..]",
            help="For the action home: measured position of the platform, m [and rotation vector, rad].",
        ),
    ] = None
    line: Annotated[
        str | None, typer.Option("--line", metavar="NAME", help="For the action jog: line whose winch moves.")
    ] = None
    speed: Annotated[
        float, typer.Option("--speed", metavar="V", help="For jog --line: speed of the cable, m/s; positive pays out.")
    ] = 0.01
    velocity: Annotated[
        str | None,
        typer.Option("--velocity", metavar="VX,VY,VZ", help="For the action jog: velocity of the platform, m/s."),
    ] = None
    seconds: Annotated[
        float | None,
        typer.Option(
            "--seconds",
            metavar="T",
            help="For the action enable: time after which brakes close and torque is removed, s; by default at Ctrl-C.",
        ),
    ] = None

    def done(self, action: Action, robot: cw.Robot, settings: cw.MachineSettings, state: Path, port: OpenPort) -> Any:
        """Carry out the *action* and return its result. Raises `InputError`."""
        import numpy as np

        from cablewright.live.drives import actions

        match action:
            case "scan":
                return actions.scan(robot, settings, port)
            case "show":
                return actions.show(robot, settings, port)
            case "write":
                return actions.write(robot, settings, state, port)
            case "release":
                return actions.release(robot, settings, state, port)
            case "tension":
                return actions.tension(robot, settings, state, port)
            case "home":
                place = begin_of(self.place, "--place", robot)
                return actions.home(robot, settings, state, None if place is None else np.array(place), port)
            case "enable":
                hold = float("inf") if self.seconds is None else self.seconds
                return actions.enable(robot, settings, state, hold, port)
            case "jog":
                with button() as held:
                    return self._jogged(robot, settings, state, held)

    def _jogged(self, robot: cw.Robot, settings: cw.MachineSettings, state: Path, held: Button) -> Any:
        from cablewright.live.drives import actions

        if (self.line is None) == (self.velocity is None):
            raise InputError("drives jog: expected either --line NAME or --velocity VX,VY,VZ")
        if self.line is not None:
            return actions.jog_winch(robot, settings, state, self.line, self.speed, held.held, held.ended)
        velocity = numbers(self.velocity, "--velocity", 3) or []
        return actions.jog_platform(robot, settings, state, velocity, held.held, held.ended)


@command(
    "drives scan merlet2023 --machine examples/virtual-drives.toml --try",
    "live.drives.answers:BusScan",
    "live.drives.answers:DriveValues",
    "live.drives.answers:DriveSession",
)
def drives_command(
    *,
    action: Annotated[
        Action | None,
        typer.Argument(metavar="ACTION", help="One of scan, show, write, enable, release, jog, tension, home."),
    ] = None,
    robot: Annotated[
        str | None,
        typer.Argument(metavar="ROBOT", help="A robot's TOML file, or a name that `cablewright robots` lists."),
    ] = None,
    machine: Annotated[
        str | None, typer.Option("--machine", metavar="FILE", help="Machine file (TOML) that describes the drives.")
    ] = None,
    given: ActionOptions,
    tried: Annotated[
        bool,
        typer.Option(
            "--try",
            help="Try the action on virtual drives in this process, in virtual time; no counts or lengths are saved.",
        ),
    ] = False,
    virtual: Annotated[
        Path | None,
        typer.Option(
            "--virtual",
            metavar="FILE",
            help="Simulate the drives of a machine file on this computer, for another program that commands them.",
        ),
    ] = None,
    at: Annotated[
        str | None,
        typer.Option(
            "--at",
            metavar="X,Y,Z[,..]",
            help="Start position of the platform on virtual drives, m [and rotation vector, rad].",
        ),
    ] = None,
    seed: Annotated[
        int, typer.Option("--seed", help="Seed of the random errors of the simulated machine that virtual drives move.")
    ] = 0,
    as_json: AsJson = False,
) -> int:
    """Moves the winches of the machine. No performance level is claimed: add a hard-wired emergency stop.

    `enable`, `jog`, `tension` and `home` reset the drives and enable all winches. When the command ends, also by
    Ctrl-C, the brakes close. FILE.counts.json and FILE.lengths.json keep counts and lengths.

    `jog` runs while you hold a key: one winch with --line, the platform with --velocity; q quits.
    """
    from tempfile import TemporaryDirectory

    if virtual is not None:
        if action is not None:
            raise InputError("drives: give either --virtual or an action, not both")
        return _be_virtual(virtual, robot, at, seed)
    if action is None or robot is None or machine is None:
        raise InputError(f"drives: expected ACTION ROBOT --machine FILE; actions: {', '.join(get_args(Action))}")
    described = cw.load(robot)
    settings = cw.load_machine(machine) if action in ("scan", "show") else load_real(machine, described)
    if not tried:
        return answer(given.done(action, described, settings, Path(machine).with_suffix(""), None), as_json)
    if action == "jog" or (action == "enable" and given.seconds is None):
        raise InputError(
            f"drives {action}: runs until an operator ends it, whom --try does not simulate; leave --try out"
        )
    port = _virtual_bus(action, described, machine, at, seed)
    with TemporaryDirectory() as folder:
        return answer(given.done(action, described, settings, Path(folder) / "machine", port), as_json)


def _virtual_bus(action: Action, robot: cw.Robot, machine: str, at: str | None, seed: int) -> OpenPort:
    """A bus with virtual drives in this process. Raises `InputError`."""
    from cablewright.machine.drives.virtual.rig import VirtualPort, VirtualRig

    twin = cw.load_twin(machine)
    if twin.owner.kind != "canopen":
        raise InputError(f"drives {action}: --try is for CAN; virtual EtherCAT drives need --virtual")
    port = VirtualPort(VirtualRig(robot, twin, _start(robot, at), seed=seed))
    return lambda: port


def _start(robot: cw.Robot, at: str | None) -> Any:
    """Where the platform of virtual drives begins, m, or a rigid one's pose, m and rad."""
    from cablewright.live.drives.session import session_path

    given = begin_of(at, "--at", robot)
    return session_path(robot, None).start_pose if given is None else given


def _be_virtual(file: Path, robot: str | None, at: str | None, seed: int) -> int:
    """Simulate the drives, and a person beside them, until interrupted. Raises `InputError`, `EnvironmentFault`."""
    from cablewright.apps.cli.drives.terminal import REFILL, person_beside
    from cablewright.machine.drives.local_can_bus import Hub
    from cablewright.machine.drives.virtual.ethercat_ring import VirtualRing, run_ring
    from cablewright.machine.drives.virtual.rig import VirtualRig, run_rig

    twin = cw.load_twin(file)
    name, drives = robot or twin.owner.robot, twin.owner.drives
    if name is None:
        raise InputError(f"{file}: robot: is missing; name the robot that the virtual drives move")
    if drives is None or (twin.owner.kind == "canopen" and drives.interface != "loopback"):
        raise InputError(f'{file}: drives.interface: must be "loopback" for virtual drives')
    if not drives.channel:
        raise InputError(
            f"{file}: drives.channel: is missing; name the network interface at which virtual drives answer"
        )
    described = cw.load(name)
    rig = VirtualRig(described, twin, _start(described, at), seed=seed)
    rig.warm()
    where = ", ".join(f"{x:.3f}" for x in rig.plant.truth.position)
    bus = "EtherCAT" if twin.owner.kind == "ethercat" else "the bus loopback"

    def ready() -> None:
        tell(f"virtual drives of {twin.owner.name} at {where} m on {bus} {drives.channel}; Ctrl-C ends them")
        tell(f"{REFILL}, typed here, fills the drum")

    if twin.owner.kind == "ethercat":
        run_ring(VirtualRing(rig), drives.channel, person_beside(rig), ready)
        return 0
    with closing(Hub(int(drives.channel))) as hub:
        ready()
        run_rig(rig, hub, person_beside(rig))
    return 0
