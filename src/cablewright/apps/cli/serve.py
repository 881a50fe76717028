"""`serve`: a page in the browser to watch and operate a machine."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import cablewright as cw
from cablewright.apps.cli.command import command
from cablewright.apps.cli.options import MachineName, RobotName, Seed
from cablewright.apps.cli.output import tell
from cablewright.apps.cli.parsing import begin_of, run_path
from cablewright.foundation.errors import EnvironmentFault, InputError

if TYPE_CHECKING:
    from cablewright.live.serve.operated_machines import Station


@command("serve house-printer")
def serve_command(
    *,
    robot: RobotName,
    machine: MachineName = None,
    host: Annotated[
        str, typer.Option("--host", metavar="ADDRESS", help="Address to listen at; all but loopback require TLS.")
    ] = "127.0.0.1",
    port: Annotated[
        int, typer.Option("--port", metavar="N", help="TCP port at which the server listens; 0 takes any free port.")
    ] = 8642,
    name: Annotated[
        list[str] | None,
        typer.Option("--name", metavar="HOST", help="Host name of this computer for browsers; repeat for more."),
    ] = None,
    certificate: Annotated[
        Path | None, typer.Option("--certificate", metavar="PEM", help="PEM file of the TLS certificate and its chain.")
    ] = None,
    key: Annotated[
        Path | None, typer.Option("--key", metavar="PEM", help="PEM file of the certificate's private key.")
    ] = None,
    camera: Annotated[
        str, typer.Option("--camera", metavar="URL", help="Address of a camera picture, MJPEG or still, for the page.")
    ] = "",
    news: Annotated[
        Path | None,
        typer.Option("--news", metavar="FILE", help="TOML file of webhooks and an MQTT broker that get notices."),
    ] = None,
    ros2: Annotated[
        int | None, typer.Option("--ros2", metavar="N", help="ROS 2 domain in which to publish the state.")
    ] = None,
    at: Annotated[
        str | None, typer.Option("--at", metavar="X,Y,Z[,..]", help="Start pose of a simulated machine, m [and rad].")
    ] = None,
    seed: Seed = 0,
    tried: Annotated[
        bool, typer.Option("--try", help="Try virtual drives in this process; no counts or lengths are saved.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Folder of jobs, runs and orders; by default runs/serve-ROBOT."),
    ] = None,
) -> int:
    """No performance level is claimed: the builder adds a hard-wired emergency stop, which no browser replaces.

    The command prints the address of the page once, with a token. Everyone with the address can stop the machine; one
    page at a time operates it. A machine file with drives moves a real machine; others are simulated in real time.

    Needs the extra web (pip install 'cablewright[web]'), and Linux or macOS. Ctrl-C stops the machine and quits.
    """
    from tempfile import TemporaryDirectory

    from cablewright.apps.serve.launch import Address, require_libraries, serve
    from cablewright.models.support_table import Capability, require

    address = Address(host, port, tuple(name or ()), certificate, key, camera, news, ros2)
    require_libraries()
    described = cw.load(robot)
    require(described, Capability.SERVE)
    folder = run_path(out, "serve", described.name)
    if folder.exists() and not folder.is_dir():
        raise InputError(f"--out = {folder}: is no folder")
    file = machine or (described.name if described.name in cw.machine_names() else _built(described, folder))
    if ros2 is not None:
        tell(f"note: --ros2 = {ros2}: everyone on the network reads the state, without a password; see CYCLONEDDS_URI")
    owner = cw.load_machine(file)
    with TemporaryDirectory() as aside:
        state = Path(aside) / "machine" if tried else Path(file).with_suffix("")
        station = _station(described, owner, file, state, begin_of(at, "--at", described), seed, tried)
        lock = None if owner.kind == "simulated" or tried else Path(file).with_suffix(".lock")
        try:
            serve(station, owner, folder, address, tell, lock)
        except KeyboardInterrupt:
            tell("cablewright: the machine was stopped, and the page's server has ended")
    return 0


def _built(robot: cw.Robot, folder: Path) -> str:
    """The machine file in the *folder*, which is built where there is none, with a note. Raises `EnvironmentFault`."""
    from cablewright.foundation.file_output import write_whole
    from cablewright.live.prints.plan import MACHINE_FILE
    from cablewright.live.prints.run import make_folder
    from cablewright.machine.simulated.machine_file import built_machine

    file = folder / MACHINE_FILE
    if not file.exists():
        make_folder(folder)
        write_whole(file, built_machine(robot)[1].encode())
    tell(f"note: no --machine was given: {file} is used, written for {robot.name} with assumed numbers")
    return str(file)


def _station(
    robot: cw.Robot,
    owner: cw.MachineSettings,
    file: str,
    state: Path,
    given: list[float] | None,
    seed: int,
    tried: bool,
) -> Station:
    """The machine that is operated, from the *given* place (3,), m, or pose on. Raises `InputError`."""
    import numpy as np

    from cablewright.live.serve.operated_machines import DriveStation, SimulatedStation, resting_pose
    from cablewright.machine.settings import require_robot
    from cablewright.machine.simulated.settings import whole_machine

    require_robot(owner, robot.name)
    pose = resting_pose(robot, None if given is None else np.array(given))
    if owner.kind == "simulated":
        if tried:
            raise InputError("--try: is only for a machine file with a table [drives]; leave it out")
        return SimulatedStation(robot, whole_machine(file), seed, pose)
    return DriveStation(robot, owner, state, _virtual(robot, owner, file, pose, seed) if tried else None, pose)


def _virtual(robot: cw.Robot, owner: cw.MachineSettings, file: str, pose: Any, seed: int) -> Any:
    """A bus with virtual drives in this process."""
    from cablewright.machine.drives.virtual.rig import VirtualPort, VirtualRig

    if owner.drives is None or owner.drives.interface != "loopback":
        raise EnvironmentFault(f'{file}: drives.interface: must be "loopback" for virtual drives')
    rig = VirtualRig(robot, cw.load_twin(file), pose, seed=seed)
    rig.warm()
    port = VirtualPort(rig)
    return lambda: port
