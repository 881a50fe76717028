"""`workspace`: where a robot can be by a criterion."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import typer

from cablewright.apps.cli.options import (
    CountOptions,
    ExecutorOptions,
    OrientedRegionOptions,
    OutputOptions,
    RobotOptions,
)
from cablewright.apps.cli.output import answer, progress
from cablewright.apps.cli.parsing import check_suffix, numbers
from cablewright.errors import InputError
from cablewright.file_output import write_whole

if TYPE_CHECKING:
    from cablewright.analyses.workspace.area import WorkspaceArea
    from cablewright.analyses.workspace.workspace import Workspace as Volume


@dataclass(frozen=True, kw_only=True)
class WorkspaceCommand:
    """A place is in the workspace if the criterion holds there under every orientation that is requested.

    The volume is refined at the boundary until its error is small enough. A planar robot, or a flat box, has an area.
    With --workers or --cluster a file in runs/ has what is done, until there is an answer: the same command resumes.
    """

    EXAMPLE: ClassVar = "workspace jung2020 --criterion closed-form --count nodes --grid 9"
    ANSWERS: ClassVar = ("analyses.workspace.workspace:Workspace", "analyses.workspace.workspace:NodeCount",
                         "analyses.workspace.area:WorkspaceArea")  # fmt: skip

    robot: RobotOptions
    region: OrientedRegionOptions
    volume: CountOptions
    wrench_box: Annotated[
        str | None,
        typer.Option(
            "--wrench-box",
            metavar="FX0,FX1,FY0,..",
            help="Min and max of each force, N, and moment, N m, that the criterion capacity must balance.",
        ),
    ] = None
    arm: Annotated[
        float,
        typer.Option("--arm", metavar="L", help="Arm, m, on which the criterion capacity counts a moment as a force."),
    ] = 1.0
    mesh: Annotated[
        Path | None,
        typer.Option("--mesh", metavar="FILE.stl|.glb", help="Write the boundary as a closed mesh, in m."),
    ] = None
    executor: ExecutorOptions
    output: OutputOptions

    def run(self) -> int:
        """Find the workspace, write what is requested, and print it."""
        from cablewright.analyses.workspace import workspace as volumes
        from cablewright.analyses.workspace.area import workspace_area
        from cablewright.analyses.workspace.criterion import is_planar

        self._check_files()
        machine, given = self.robot.loaded(), self.region.as_arguments() | {"grid": self.volume.grid, "arm": self.arm}
        given |= {"wrench_box": _wrench_box(self.wrench_box, machine.n)}
        criterion = self.region.criterion_name
        with self._working(machine.name) as who:
            given |= who
            planar = is_planar(machine, given["box"])
            self._check_plane(planar)
            if self.volume.count == "nodes":
                return answer(volumes.count_nodes(machine, criterion, **given), self.output.as_json)
            given |= {"tolerance": self.volume.tolerance, "seed": self.volume.seed}
            find = workspace_area if planar else volumes.workspace
            found: Volume | WorkspaceArea = find(machine, criterion, **given)
            written = self._write(found)
        return answer(found, self.output.as_json, **written)

    @contextmanager
    def _working(self, name: str) -> Iterator[dict[str, Any]]:
        """Who computes, and the progress, until the block ends. Raises `InputError`, `EnvironmentFault`."""
        if not self.executor.asked:
            with progress() as show:
                yield {"progress": show}
            return
        from cablewright.studies.executors.kept import kept_in
        from cablewright.studies.executors.shared_margin import SharedMargin
        from cablewright.studies.store import folder_name

        file = Path("runs") / f"{folder_name('workspace', name)}.results.jsonl"
        with self.executor.working(file) as (executor, show), kept_in(file) as kept:
            yield {"progress": show, "margins": SharedMargin(executor, kept)}
        file.unlink(missing_ok=True)
        with suppress(OSError):  # it holds other runs
            file.parent.rmdir()

    def _check_files(self) -> None:
        """Raise `InputError` unless what is requested can be written."""
        check_suffix(self.mesh, "--mesh", ".stl", ".glb")
        if self.volume.count == "nodes":
            drawn = (("--mesh", self.mesh), ("--plot", self.output.plot), ("--report", self.output.report))
            for option, value in drawn:
                if value is not None:
                    raise InputError(f"{option} needs the surface: it does not go with --count nodes")
            if self.volume.tolerance is not None:
                raise InputError("--tolerance does not go with --count nodes, whose error is that of its grid")

    def _check_plane(self, planar: bool) -> None:
        """Raise `InputError` for what an area does not have."""
        if planar and self.mesh is not None:
            raise InputError("--mesh needs a surface: this workspace is an area; --json has its outlines")
        if planar and self.volume.count == "nodes":
            raise InputError("--count nodes counts in a volume: this workspace is an area, and a --box may give it one")

    def _write(self, found: Volume | WorkspaceArea) -> dict[str, Path | None]:
        """Write what is requested; nothing of an empty workspace."""
        from cablewright.analyses.workspace.workspace import Workspace

        some = found.status != "empty"
        mesh = self.mesh if some else None
        if mesh is not None and isinstance(found, Workspace):
            write_whole(mesh, found.mesh.stl() if mesh.suffix.lower() == ".stl" else found.mesh.glb())
        return {"mesh": mesh, **self.output.write(found, f"Workspace of {self.robot.robot}", when=some)}


def _wrench_box(text: str | None, n: int) -> Any:
    """Min and max wrench; moments are zero where only forces are given. Raises `InputError`."""
    values = numbers(text, "--wrench-box")
    if values is None:
        return None
    if len(values) not in (6, 2 * n):
        raise InputError(f"--wrench-box = {text!r}: expected 6 numbers, N, min and max of each, or {2 * n}")
    values += [0.0] * (2 * n - len(values))
    return values[::2], values[1::2]
