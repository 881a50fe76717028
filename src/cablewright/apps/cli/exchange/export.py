"""`export`: a robot, and a job, as files of another program."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar, Final

import typer

from cablewright.apps.cli.options import AsJson, Pose, RobotName
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import numbers, pose_of
from cablewright.choices import WireXVersion, WrittenFormatName
from cablewright.errors import AnswerError, InputError

if TYPE_CHECKING:
    from cablewright.exchange.klipper_motion import Stepper
    from cablewright.exchange.translation import ExportedFile
    from cablewright.robot import Robot


AT_A_POSE: Final = ("mjcf", "urdf", "stl", "glb")
"""Formats that describe the robot at a pose."""


@dataclass(frozen=True, kw_only=True)
class MotionOptions:
    """For klipper, reprapfirmware and linuxcnc."""

    PANEL: ClassVar = "Firmware"

    machine: Annotated[
        str | None,
        typer.Option("--machine", metavar="NAME", help="Machine file: layers of cable on drums, and the gear."),
    ] = None
    layers: Annotated[
        str | None, typer.Option("--layers", metavar="FIRST,LAST", help="Layers of the part; by default all.")
    ] = None
    tolerance: Annotated[
        float | None,
        typer.Option(
            "--tolerance", help="Largest error of a line's length between two points, m; by default half a microstep."
        ),
    ] = None
    microsteps: Annotated[
        int | None, typer.Option("--microsteps", help="Microsteps of a full step; by default 16.")
    ] = None
    full_steps: Annotated[
        int | None, typer.Option("--full-steps", help="Full steps of a motor's turn; by default 200.")
    ] = None

    @property
    def given(self) -> bool:
        """Whether any is."""
        return self != MotionOptions()


@dataclass(frozen=True, kw_only=True)
class ExportCommand:
    """Klipper, RepRapFirmware and LinuxCNC take a job, ros2 a log; they get a folder. The others describe the robot.

    What the robot has and the format has not is told on stderr and in comments of the files. See docs/exchange.md.
    """

    EXAMPLE: ClassVar = "export mjcf cogiro --out runs/cogiro.xml"
    ANSWERS: ClassVar = ("exchange.result:Exported",)

    format: Annotated[WrittenFormatName, typer.Argument(metavar="FORMAT", help="Format to write.")]
    robot: RobotName
    job: Annotated[
        Path | None,
        typer.Argument(metavar="[JOB]", help="For a firmware a job's TOML or G-code file; for ros2 a machine's log."),
    ] = None
    out: Annotated[
        Path, typer.Option("--out", metavar="OUT", help="File, of a firmware and ros2 folder; it must not exist.")
    ]
    schema_version: Annotated[
        WireXVersion | None, typer.Option("--schema-version", help="Of WireX; by default 0.32.")
    ] = None
    at: Pose = None
    motion: MotionOptions
    as_json: AsJson = False

    def run(self) -> int:
        """Write and print."""
        from cablewright.exchange.firmware import FIRMWARE
        from cablewright.robot import load

        self._require_fitting(self.format in FIRMWARE)
        if self.out.exists() or self.out.is_symlink():
            raise InputError(f"{self.out}: is there already; nothing is overwritten")
        robot = load(self.robot)
        if self.format == "ros2":
            return self._ros_bag(robot)
        return self._firmware(robot) if self.format in FIRMWARE else self._description(robot)

    def _require_fitting(self, is_firmware: bool) -> None:
        """Raise `InputError` for options that this format does not have."""
        if is_firmware and self.job is None:
            raise InputError(f"export {self.format}: expected a JOB after ROBOT, whose motion is written")
        if self.format == "ros2" and self.job is None:
            raise InputError("export ros2: expected a machine's LOG after ROBOT, a file or a run folder")
        if not (is_firmware or self.format == "ros2") and self.job is not None:
            raise InputError(f"{self.job}: {self.format} describes a robot and takes no JOB")
        if not is_firmware and self.motion.given:
            raise InputError(f"export {self.format}: --machine, --layers and their like are for a firmware")
        if self.schema_version is not None and self.format != "wirex":
            raise InputError(f"--schema-version = {self.schema_version}: only wirex has versions")
        if self.at is not None and self.format not in AT_A_POSE:
            raise InputError(f"--at = {self.at!r}: only {', '.join(AT_A_POSE)} are written at a pose")

    def _description(self, robot: Robot) -> int:
        from cablewright.exchange.result import Exported
        from cablewright.file_output import write_whole

        if self.format == "wirex":
            found, content = self._wirex(robot), b""
        else:
            found, content = self._at_pose(robot)
        write_whole(self.out, content or found.text.encode(), parents=True)
        return answer(Exported(self.format, robot.name, found.lost, found.assumed), self.as_json, file=self.out)

    def _ros_bag(self, robot: Robot) -> int:
        from cablewright.exchange.result import Exported
        from cablewright.exchange.ros.bag import ros_bag

        assert self.job is not None
        with progress() as show:
            found = ros_bag(robot, self.job, self.out, show)
        told = Exported(self.format, robot.name, found.lost, (), messages=found.messages)
        return answer(told, self.as_json, out=self.out)

    def _wirex(self, robot: Robot) -> ExportedFile:
        from cablewright.exchange.wirex_output import wirex

        return wirex(robot, self.schema_version or "0.32")

    def _at_pose(self, robot: Robot) -> tuple[ExportedFile, bytes]:
        """The robot at `--at`, or at rest near the middle of its frame; bytes of a file that is no text."""
        from cablewright.exchange.mjcf import mjcf
        from cablewright.exchange.shapes import shapes
        from cablewright.exchange.translation import ExportedFile
        from cablewright.exchange.urdf import urdf
        from cablewright.models.statics import Model
        from cablewright.solvers.inverse import solve_inverse
        from cablewright.studies.rest_pose import rest_pose

        model = Model.of(robot, cable="rigid")
        if self.at is None:
            held = rest_pose(model).equilibrium
        else:
            held = solve_inverse(model, pose_of(self.at, robot) or [])
        if self.format == "mjcf":
            return mjcf(held), b""
        if not all(map(math.isfinite, held.pose)):
            raise AnswerError(f"no pose of the platform: {held.sentence()}", held.status)
        if self.format == "urdf":
            return urdf(robot, held.pose), b""
        mesh, lost = shapes(robot, held.pose), ("all but shapes of frame, exits and platform, for looking",)
        return ExportedFile("", lost), mesh.stl() if self.format == "stl" else mesh.glb()

    def _firmware(self, robot: Robot) -> int:
        from cablewright.exchange.firmware import firmware
        from cablewright.exchange.result import Exported
        from cablewright.file_output import whole_folder, write_whole
        from cablewright.machine.files import load_machine
        from cablewright.printing.job import load_job

        assert self.job is not None
        machine = None if self.motion.machine is None else load_machine(self.motion.machine)
        if self.motion.tolerance is not None and not 0.0 < self.motion.tolerance < 1.0:
            raise InputError(f"--tolerance = {self.motion.tolerance:g}: must be over 0 and under 1 m")
        with progress() as show:
            found = firmware(
                self.format,
                robot,
                load_job(self.job),
                machine=machine,
                stepper=self._stepper(1.0 if machine is None else machine.winch.ratio),
                layers=_layers(self.motion.layers),
                tolerance=self.motion.tolerance,
                progress=show,
            )
        with whole_folder(self.out) as folder:
            for name, text in found.files.items():
                write_whole(folder / name, text.encode())
        computes_itself = self.format == "reprapfirmware"
        points, error = len(found.path.samples), None if computes_itself else found.path.error
        told = Exported(self.format, robot.name, found.lost, found.assumed, points, error)
        return answer(told, self.as_json, out=self.out)

    def _stepper(self, ratio: float) -> Stepper | None:
        from cablewright.exchange.klipper_motion import Stepper

        microsteps, full_steps = self.motion.microsteps, self.motion.full_steps
        for option, value in (("--microsteps", microsteps), ("--full-steps", full_steps)):
            if value is not None and not 1 <= value <= 100_000:
                raise InputError(f"{option} = {value}: must be 1 to 100000")
        if microsteps is None and full_steps is None:
            return None
        return Stepper(full_steps or Stepper.full_steps, microsteps or Stepper.microsteps, ratio)


def _layers(text: str | None) -> tuple[int, int] | None:
    """Return the first and the last layer. Raises `InputError`."""
    if text is None:
        return None
    values = numbers(text, "--layers", 2) or []
    if any(value != int(value) or value < 1 for value in values):
        raise InputError(f"--layers = {text!r}: expected two whole numbers FIRST,LAST, from 1")
    return int(values[0]), int(values[1])
