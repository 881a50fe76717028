"""`serve`: a machine that is watched and operated in a browser."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import typer

from cablewright.apps.cli.options import MachineName, RobotName, Seed
from cablewright.apps.cli.output import tell
from cablewright.apps.cli.parsing import numbers
from cablewright.errors import EnvironmentFault, InputError

if TYPE_CHECKING:
    from cablewright.machine.settings import MachineSettings
    from cablewright.robot import Robot
    from cablewright.studies.serve.station import Station


@dataclass(frozen=True, kw_only=True)
class ServeCommand:
    """No performance level is claimed: the hard-wired emergency stop is the builder's, and no browser replaces it.

    The page's address, with a token, is shown once. Whoever has it may stop the machine; one page at a time operates
    it. A machine file that names drives moves a real machine; any other is simulated, at the pace of the clock.

    Needs the extra web (pip install 'cablewright[web]'), and Linux or macOS. Ctrl-C stops the machine and ends.
    """

    EXAMPLE: ClassVar = "serve house-printer"
    ANSWERS: ClassVar = ()

    robot: RobotName
    machine: MachineName = None
    host: Annotated[
        str, typer.Option("--host", metavar="ADDRESS", help="Address to listen at; other than loopback with TLS alone.")
    ] = "127.0.0.1"
    port: Annotated[int, typer.Option("--port", metavar="N", help="Port to listen at; 0: any that is free.")] = 8642
    name: Annotated[
        list[str] | None,
        typer.Option("--name", metavar="HOST", help="A name by which browsers may call this computer; repeatable."),
    ] = None
    certificate: Annotated[
        Path | None, typer.Option("--certificate", metavar="PEM", help="Certificate for TLS, with its chain.")
    ] = None
    key: Annotated[Path | None, typer.Option("--key", metavar="PEM", help="Private key of the certificate.")] = None
    at: Annotated[
        str | None, typer.Option("--at", metavar="X,Y,Z", help="Where the platform of a simulated machine begins, m.")
    ] = None
    seed: Seed = 0
    tried: Annotated[
        bool,
        typer.Option("--try", help="Operate virtual drives in this process; counts and lengths are kept nowhere."),
    ] = False
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Folder of jobs, runs and orders; runs/serve-ROBOT.")
    ] = None

    def run(self) -> int:
        """Serve until interrupted."""
        from tempfile import TemporaryDirectory

        from cablewright.apps.serve.launch import Address, require_libraries, serve
        from cablewright.machine.files import load_machine
        from cablewright.robot import load
        from cablewright.studies.store import folder_name

        address = Address(self.host, self.port, tuple(self.name or ()), self.certificate, self.key)
        require_libraries()
        robot = load(self.robot)
        owner = load_machine(self._machine_of(robot))
        folder = self.out or Path("runs") / folder_name("serve", robot.name)
        if folder.exists() and not folder.is_dir():
            raise InputError(f"--out = {folder}: is no folder")
        with TemporaryDirectory() as aside:
            station = self._station(robot, owner, Path(aside))
            lock = None
            if owner.kind != "simulated" and not self.tried:
                lock = Path(self._machine_of(robot)).with_suffix(".lock")
            try:
                serve(station, owner, folder, address, tell, lock)
            except KeyboardInterrupt:
                tell("cablewright: the machine was stopped, and the page's server has ended")
        return 0

    def _machine_of(self, robot: Robot) -> str:
        """The machine's file or name. Raises `InputError` for a robot without one."""
        from cablewright.machine.files import machine_names

        if self.machine is None and robot.name not in machine_names():
            known = ", ".join(machine_names())
            raise InputError(f"robot {robot.name!r}: has no machine of its own; give --machine FILE, or one of {known}")
        return robot.name if self.machine is None else self.machine

    def _station(self, robot: Robot, owner: MachineSettings, aside: Path) -> Station:
        """The machine that is operated. Raises `InputError`."""
        import numpy as np

        from cablewright.machine.settings import require_robot
        from cablewright.machine.simulated.settings import whole_machine
        from cablewright.models.support import Capability, require
        from cablewright.studies.serve.station import DriveStation, SimulatedStation, resting_place

        require_robot(owner, robot.name)
        require(robot, Capability.SERVE)
        given = numbers(self.at, "--at", 3)
        place = resting_place(robot) if given is None else np.array(given)
        file = self._machine_of(robot)
        if owner.kind == "simulated":
            if self.tried:
                raise InputError("--try: is for a machine file that names drives")
            return SimulatedStation(robot, whole_machine(file), self.seed, place)
        if not self.tried:
            return DriveStation(robot, owner, Path(file).with_suffix(""), begin=place)
        return DriveStation(robot, owner, aside / "machine", self._virtual(robot, file, place), place)

    def _virtual(self, robot: Robot, file: str, place: Any) -> Any:
        """A bus with virtual drives in this process."""
        from cablewright.machine.drives.virtual.rig import VirtualPort, VirtualRig
        from cablewright.machine.simulated.settings import load_twin

        if owner_drives(file) != "loopback":
            raise EnvironmentFault(f'{file}: drives.interface: must be "loopback" for virtual drives')
        rig = VirtualRig(robot, load_twin(file), place, seed=self.seed)
        rig.warm()
        port = VirtualPort(rig)
        return lambda: port


def owner_drives(file: str) -> str | None:
    """The interface of a machine file's drives; None: it has none."""
    from cablewright.machine.files import load_machine

    drives = load_machine(file).drives
    return None if drives is None else drives.interface
