"""`import` and `export`: conversion of robots and jobs from and to files of other programs."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

import cablewright as cw
from cablewright.apps.cli.command import command, options
from cablewright.apps.cli.options import AsJson, BeadSize, Pose, RobotName
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import bead_size, numbers, pose_of, quantity
from cablewright.foundation.choices import (
    CableName,
    ReadFormatName,
    RrfVersionName,
    TargetName,
    WireXVersion,
    WrittenFormatName,
)
from cablewright.foundation.errors import AnswerError, InputError
from cablewright.foundation.units import LENGTH

if TYPE_CHECKING:
    from cablewright.exchange.motion_export.klipper import Stepper
    from cablewright.exchange.result import Exported
    from cablewright.exchange.translation_result import ExportedFile


@command("import examples/robot.wcrfx --out runs/robot.toml", "exchange.result:Imported")
def import_command(
    *,
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE...", help="File to read; for a CASPR model give both files, bodies and cables."),
    ],
    out: Annotated[Path, typer.Option("--out", metavar="FILE.toml", help="Robot file to write; it must not exist.")],
    form: Annotated[
        ReadFormatName | None,
        typer.Option("--format", help="Format of the file; by default recognised by its content."),
    ] = None,
    cable: Annotated[
        CableName | None,
        typer.Option(
            "--cable",
            help="Cable of all lines, by its name in the table of cables in docs/robots.md; by default "
            "the file's, or an assumed one.",
        ),
    ] = None,
    cable_set: Annotated[
        str | None,
        typer.Option(
            "--cable-set",
            metavar="ID",
            help="Set of cables to read from a CASPR model; by default the model's own default set.",
        ),
    ] = None,
    nozzle_below: Annotated[
        str | None,
        typer.Option(
            "--nozzle-below",
            metavar="L",
            help="For a Hangprinter: distance of the nozzle below the point where its lines meet, in m or with a unit.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Reads WireX, CASPR, and settings of Hangprinters (RepRapFirmware, Klipper), Maslows and wall plotters.

    Lists lost and assumed data on stderr and as comments in the new file. See docs/exchange.md.
    """
    from cablewright.exchange.formats import ImportOptions, read_robot
    from cablewright.exchange.result import Imported
    from cablewright.exchange.robot_toml import robot_toml
    from cablewright.foundation.file_output import write_whole

    if out.suffix != ".toml":
        raise cw.InputError(f"--out = {str(out)!r}: must end in .toml")
    if out.exists() or out.is_symlink():
        raise cw.InputError(f"{out}: exists already and is not overwritten; choose another name")
    below = 0.0 if nozzle_below is None else quantity(nozzle_below, "--nozzle-below", LENGTH)
    found = read_robot(files, form, ImportOptions(cable, cable_set, below))
    text = robot_toml(found, "cablewright import")
    cw.loads(text, str(out))
    write_whole(out, text.encode(), parents=True)
    robot = found.robot
    told = Imported(found.format, robot.name, robot.m, robot.freedoms, found.lost, found.assumed)
    return answer(told, as_json, file=out)


FOR: Final = {"gcode": ("rrf", "klipper"), "slicer": ("orca", "prusa", "cura")}
"""Programs for which a format can be written, of formats that need --for."""

AT_A_POSE: Final = ("mjcf", "urdf", "stl", "glb")
"""Formats that describe the robot at a pose."""


@options("Firmware")
class MotionOptions:
    """Options of the formats klipper, reprapfirmware, linuxcnc and gcode."""

    machine: Annotated[
        str | None,
        typer.Option(
            "--machine",
            metavar="NAME",
            help="Machine file that describes the layers of cable on the drums and the gear.",
        ),
    ] = None
    layers: Annotated[
        str | None,
        typer.Option(
            "--layers", metavar="FIRST,LAST", help="First and last layer to export, from 1; by default all layers."
        ),
    ] = None
    tolerance: Annotated[
        str | None,
        typer.Option(
            "--tolerance",
            metavar="L",
            help="Largest error of a line's length by interpolation between two points, in m or like '20 um'; by "
            "default half a microstep.",
        ),
    ] = None
    microsteps: Annotated[
        int | None,
        typer.Option("--microsteps", help="Number of microsteps in a full step of the motors; by default 16."),
    ] = None
    full_steps: Annotated[
        int | None, typer.Option("--full-steps", help="Number of full steps in a turn of a motor; by default 200.")
    ] = None

    gear: Annotated[
        str | None,
        typer.Option(
            "--gear",
            metavar="MOTOR:SPOOL",
            help="Teeth of the gear wheels of motor and winch drum, like "
            "20:255; by default the machine file's gear, or none.",
        ),
    ] = None
    version: Annotated[
        RrfVersionName | None,
        typer.Option(
            "--firmware-version",
            help="Version of RepRapFirmware for which the files are written; by "
            "default 3.6, or 3.7 for more than 5 lines.",
        ),
    ] = None
    complete: Annotated[
        bool,
        typer.Option(
            "--config",
            help="For linuxcnc: also write a complete configuration with HAL file, homing and simulated joints.",
        ),
    ] = False

    def written(self, target: str, made_for: TargetName | None, robot: cw.Robot, job: Path, out: Path) -> Exported:
        """Write the files of a firmware into the folder *out*. Raises `InputError`."""
        from cablewright.exchange.firmware import firmware, plain_gcode
        from cablewright.exchange.result import Exported
        from cablewright.foundation.file_output import whole_folder, write_whole

        machine = None if self.machine is None else cw.load_machine(self.machine)
        tolerance = None if self.tolerance is None else quantity(self.tolerance, "--tolerance", LENGTH)
        if tolerance is not None and tolerance >= 1.0:
            raise InputError(f"--tolerance = {self.tolerance!r}: must be under 1 m; a number alone is in m")
        if target == "gcode" and tolerance is not None:
            raise InputError(
                "export gcode: --tolerance is only for formats that move each winch by its angle; leave it out"
            )
        if self.complete and target != "linuxcnc":
            raise InputError(f"export {target}: --config is only for the format linuxcnc; leave it out")
        given: dict[str, Any] = {
            "machine": machine, "stepper": self._stepper(), "layers": _layers(self.layers), "version": self.version,
            "gear": _gear(self.gear),
        }  # fmt: skip
        with progress() as show:
            if made_for == "rrf" or made_for == "klipper":
                found, own = plain_gcode(made_for, robot, cw.load_job(job), **given, progress=show)
                error: float | None = own.error
            else:
                found = firmware(
                    target, robot, cw.load_job(job), **given, tolerance=tolerance, complete=self.complete, progress=show
                )
                error = None if target == "reprapfirmware" else found.path.error
        with whole_folder(out) as folder:
            for name, text in found.files.items():
                write_whole(folder / name, text.encode())
        points = len(found.path.samples)
        if target == "gcode":
            return Exported(target, robot.name, found.lost, found.assumed, points, nozzle_error=error)
        return Exported(target, robot.name, found.lost, found.assumed, points, error)

    def _stepper(self) -> Stepper | None:
        from cablewright.exchange.motion_export.klipper import Stepper

        for option, value in (("--microsteps", self.microsteps), ("--full-steps", self.full_steps)):
            if value is not None and not 1 <= value <= 100_000:
                raise InputError(f"{option} = {value}: must be 1 to 100000")
        if self.microsteps is None and self.full_steps is None:
            return None
        return Stepper(self.full_steps or Stepper.full_steps, self.microsteps or Stepper.microsteps)


@command("export mjcf cogiro --out runs/cogiro.xml", "exchange.result:Exported")
def export_command(
    *,
    target: Annotated[WrittenFormatName, typer.Argument(metavar="FORMAT", help="Format to write.")],
    robot: RobotName,
    job: Annotated[
        Path | None,
        typer.Argument(
            metavar="[JOB]", help="For a firmware: the job's TOML or G-code file. For ros2: a machine's log."
        ),
    ] = None,
    out: Annotated[Path, typer.Option("--out", metavar="OUT", help="File or folder to write; it must not exist.")],
    made_for: Annotated[
        TargetName | None,
        typer.Option(
            "--for",
            help="For the format gcode: the firmware, rrf or klipper, that computes the "
            "kinematics. For the format slicer: the name of the slicer.",
        ),
    ] = None,
    bead: BeadSize = None,
    schema_version: Annotated[
        WireXVersion | None,
        typer.Option("--schema-version", help="Version of the WireX file format that is written; by default 0.32."),
    ] = None,
    at: Pose = None,
    motion: MotionOptions,
    as_json: AsJson = False,
) -> int:
    """Klipper, RepRapFirmware, LinuxCNC and gcode need a job, ros2 a log; these and slicer write a folder.

    Other formats describe a robot.

    Lists lost data on stderr and as comments in the files. See docs/exchange.md.
    """
    from cablewright.exchange.firmware import FIRMWARE
    from cablewright.exchange.result import Exported
    from cablewright.exchange.ros.bag import ros_bag
    from cablewright.exchange.walls.settings_output import WALLS
    from cablewright.exchange.wirex_output import wirex
    from cablewright.foundation.file_output import write_whole

    is_firmware = target in (*FIRMWARE, "gcode")
    _require_target(target, made_for, bead, job, is_firmware)
    if not is_firmware and motion != MotionOptions():
        raise InputError(
            f"export {target}: --machine, --layers and similar options are only for firmware; leave them out"
        )
    if schema_version is not None and target != "wirex":
        raise InputError(f"--schema-version = {schema_version}: only the format wirex has versions; leave it out")
    if at is not None and target not in AT_A_POSE:
        raise InputError(f"--at = {at!r}: only {', '.join(AT_A_POSE)} are written for one pose; leave --at out")
    if out.exists() or out.is_symlink():
        raise InputError(f"{out}: exists already and is not overwritten; choose another name")
    described = cw.load(robot)
    if target == "slicer":
        return answer(_profile(made_for, described, bead, out), as_json, out=out)
    if job is None:
        if target == "wirex":
            found, content = wirex(described, schema_version or "0.32"), b""
        elif target in WALLS:
            found, content = WALLS[target](described), b""
        else:
            found, content = _at_pose(target, described, at)
        write_whole(out, content or found.text.encode(), parents=True)
        return answer(Exported(target, described.name, found.lost, found.assumed), as_json, file=out)
    if target == "ros2":
        with progress() as show:
            bag = ros_bag(described, job, out, show)
        told = Exported(target, described.name, bag.lost, (), messages=bag.messages)
    else:
        told = motion.written(target, made_for, described, job, out)
    return answer(told, as_json, out=out)


def _at_pose(target: str, robot: cw.Robot, at: str | None) -> tuple[ExportedFile, bytes]:
    """The robot at `--at`, or at rest near the middle of its frame; bytes of a file that is no text."""
    from cablewright.exchange.mjcf import mjcf
    from cablewright.exchange.shapes import shapes
    from cablewright.exchange.translation_result import ExportedFile
    from cablewright.exchange.urdf import urdf
    from cablewright.live.rest_pose import rest_pose
    from cablewright.solvers.inverse import solve_inverse

    model = cw.Model.of(robot, cable="rigid")
    if at is None:
        held = rest_pose(model).equilibrium
    else:
        held = solve_inverse(model, pose_of(at, robot) or [])
    if target == "mjcf":
        return mjcf(held), b""
    if not all(map(math.isfinite, held.pose)):
        raise AnswerError(f"no pose of the platform: {held.sentence()}", held.status)
    if target == "urdf":
        return urdf(robot, held.pose), b""
    mesh, lost = shapes(robot, held.pose), ("all data except shapes of frame, exit points and platform, for viewing",)
    return ExportedFile("", lost), mesh.stl() if target == "stl" else mesh.glb()


def _require_target(
    target: str, made_for: TargetName | None, bead: str | None, job: Path | None, is_firmware: bool
) -> None:
    """Raise `InputError` unless exactly the options that a format needs are given."""
    if made_for not in FOR.get(target, (None,)):
        wanted = " or ".join(FOR.get(target, ())) or "left out"
        raise InputError(f"export {target}: --for = {made_for}: must be {wanted}; only gcode and slicer need --for")
    if (target == "slicer") is (bead is None):
        raise InputError(
            f"export {target}: a slicer needs --bead WIDTH,HEIGHT, the size of its strands; other "
            f"formats take no --bead"
        )
    if is_firmware and job is None:
        raise InputError(f"export {target}: give the JOB whose motion is to be exported, after ROBOT")
    if target == "ros2" and job is None:
        raise InputError("export ros2: expected a machine's LOG after ROBOT, a file or a run folder")
    if not (is_firmware or target == "ros2") and job is not None:
        raise InputError(f"{job}: {target} describes a robot and takes no JOB")


def _profile(slicer: TargetName | None, robot: cw.Robot, bead: str | None, out: Path) -> Exported:
    """Write the profile of a slicer for strands of *bead* into the folder *out*."""
    from cablewright.exchange.result import Exported
    from cablewright.exchange.slicers.formats import slicer_files
    from cablewright.foundation.file_output import whole_folder, write_whole

    strand = bead_size(bead)
    assert strand is not None
    assert slicer == "orca" or slicer == "prusa" or slicer == "cura"
    with progress() as show:
        found = slicer_files(slicer, robot, strand, progress=show)
    with whole_folder(out) as folder:
        for name, text in found.files.items():
            write_whole(folder / name, text.encode())
    return Exported("slicer", robot.name, found.lost, found.assumed)


def _gear(text: str | None) -> tuple[int, int] | None:
    """Return the teeth of motor and spool. Raises `InputError`."""
    if text is None:
        return None
    teeth = text.split(":")
    if len(teeth) != 2 or not all(each.isdecimal() and 1 <= int(each) <= 10_000 for each in teeth):
        raise InputError(f"--gear = {text!r}: expected teeth of motor and spool, each 1 to 10000, like 20:255")
    return int(teeth[0]), int(teeth[1])


def _layers(text: str | None) -> tuple[int, int] | None:
    """Return the first and the last layer. Raises `InputError`."""
    if text is None:
        return None
    values = numbers(text, "--layers", 2) or []
    if any(value != int(value) or value < 1 for value in values):
        raise InputError(f"--layers = {text!r}: expected two whole numbers FIRST,LAST, from 1")
    return int(values[0]), int(values[1])
