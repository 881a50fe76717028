"""`bracket`: stress in the brackets of the sheaves, on universal joints and with the second rotation blocked."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cablewright.apps.cli.options import (
    AsJson,
    Cable,
    Limits,
    LoadName,
    Plot,
    Retracted,
    RobotName,
    Wrench,
    check_plot,
    described,
)
from cablewright.apps.cli.output import limits, numbers, print_json, progress, tell
from cablewright.errors import AnswerError, EnvironmentFault, InputError
from cablewright.file_output import write_whole

if TYPE_CHECKING:
    from cablewright.analyses.bracket.stress import Peak
    from cablewright.models.statics import Model
    from cablewright.studies.bracket import BracketStress

NO = 1


def bracket(
    robot: RobotName,
    at: Annotated[
        str | None,
        typer.Option("--at", metavar="X,Y,Z[,RX,RY,RZ]", help="Pose, m and rad; `free` where gravity decides."),
    ] = None,
    job: Annotated[
        Path | None, typer.Option("--job", metavar="JOB", help="The place of a job that stresses brackets most.")
    ] = None,
    workspace: Annotated[
        float | None,
        typer.Option("--workspace", metavar="STEP", help="The same over a grid of the whole workspace, m."),
    ] = None,
    file: Annotated[
        Path | None, typer.Option("--bracket", metavar="FILE.toml", help="Another bracket than the robot file's.")
    ] = None,
    times: Annotated[int, typer.Option("--times", metavar="N", help="How finely: 1, which tells no error, or 2.")] = 2,
    sensitivity: Annotated[
        bool, typer.Option("--sensitivity", help="Stresses with each assumed size a quarter smaller and larger.")
    ] = False,
    cable: Cable = "catenary",
    tension_limits: Limits = None,
    retraction: Retracted = None,
    load: LoadName = None,
    wrench: Wrench = None,
    plot: Plot = None,
    vtu: Annotated[
        Path | None, typer.Option("--vtu", metavar="FILE.vtu", help="Write displacement and stress for ParaView.")
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Stress in the most stressed bracket at a pose, beside one whose sheave only swivels, by finite elements."""
    from cablewright.models.statics import Model
    from cablewright.printing.job import load_job

    check_plot(plot)
    _check_vtu(vtu)
    if sum(given is not None for given in (at, job, workspace)) != 1:
        raise InputError("bracket: one of --at X,Y,Z, --job JOB and --workspace STEP is wanted")
    if at is None and retraction is not None:
        raise InputError("--retraction is for --at; a job's schedule sets it")
    model = Model.of(described(robot, load, wrench), cable=cable, tension_limits=limits(tension_limits))
    _require_fem(vtu is not None)
    from cablewright.studies.bracket import bracket as stress

    pose = numbers(at, "--at", free=True)
    options: dict[str, Any] = {"bracket": file, "times": times, "sensitivities": sensitivity, "retraction": retraction}
    try:
        with progress() as show:
            found = stress(model, pose if job is None else load_job(job), step=workspace, progress=show, **options)
    except AnswerError:
        if as_json:
            print_json(_without_answer(model, pose, retraction))
        raise
    if plot is not None:
        found.plot(plot)
    if vtu is not None:
        from cablewright.apps.report.bracket_vtu import vtu as written

        write_whole(vtu, written(found.designs))
    if as_json:
        files = {"plot": None if plot is None else str(plot), "vtu": None if vtu is None else str(vtu)}
        print_json(found.to_dict() | files)
    else:
        _print(found)
    if found.verdict:
        tell(f"cablewright: {found.verdict}")
    return NO if found.verdict else 0


def _check_vtu(vtu: Path | None) -> None:
    """Raise `InputError` unless --vtu names such a file, or nothing."""
    if vtu is not None and vtu.suffix.lower() != ".vtu":
        raise InputError(f"--vtu = {str(vtu)!r}: a name that ends in .vtu is wanted")


def _require_fem(writing: bool) -> None:
    """Raise `EnvironmentFault` where the extra is not installed."""
    for module in ("skfem", "meshio") if writing else ("skfem",):
        if find_spec(module) is None:
            raise EnvironmentFault("finite elements are an extra that is not installed: pip install cablewright[fem]")


def _without_answer(model: Model, pose: list[float] | None, retraction: float | None) -> dict[str, Any]:
    """The JSON of a pose that one of the designs cannot hold, or of no pose that they could."""
    from cablewright.analyses.bracket.loads import loads_at

    both = () if pose is None else loads_at(model, [pose], retraction=retraction)
    status = next((loads.held[0].status.word for loads in both if not loads.held[0].ok), "infeasible")
    return {
        "status": status,
        "robot": model.robot.name,
        "pose": pose,
        "universal_joint": None,
        "conventional": None,
    }


def _print(stress: BracketStress) -> None:
    """The designs for people, side by side."""
    import numpy as np

    found, highest = stress.designs, stress.highest
    designs, robot = found.designs, found.model.robot
    typer.echo(f"{robot.name}: {stress.status}")
    if highest is not None:
        typer.echo(f"highest stress of {highest.held} poses that can be held, of {len(highest.poses)}")
    typer.echo("pose      " + "  ".join(f"{x:.6f}" for x in found.pose) + ("  m" if robot.n == 3 else "  m, rad"))
    rows: list[tuple[str, list[str]]] = [
        ("", ["universal joint", "conventional"]),
        ("line", [robot.lines[design.line].name for design in designs]),
        ("tension, N", [f"{design.loads.held.tensions[0, design.line]:.1f}" for design in designs]),
        ("lever, degrees", [f"{np.degrees(design.loads.lever_angle[0, design.line]):.1f}" for design in designs]),
        ("moment about the pin, N m", [f"{_zero(design.loads.pin_moment[0, design.line]):.1f}" for design in designs]),
        (
            "moment at the base, N m",
            [f"{np.linalg.norm(design.base_wrench[3:]):.1f}" for design in designs],
        ),
    ]
    for k, name in enumerate(("baseplate", "uprights", "lever")):
        rows.append((f"{name}, MPa (error)", [_stress(design.peaks[k]) for design in designs]))
    rows += [
        ("axle, MPa", [f"{design.axle_stress / 1e6:.1f}" for design in designs]),
        ("safety", [f"{design.safety:.2f}" for design in designs]),
        ("largest displacement, mm", [f"{1e3 * design.max_displacement:.3f}" for design in designs]),
        ("nodes", [str(design.nodes) for design in designs]),
        ("platform moves by, mm", [f"{1e3 * np.linalg.norm(design.platform_motion[:3]):.3f}" for design in designs]),
    ]
    for name, shown in rows:
        typer.echo(f"{name:<27}" + "".join(f"{each:>18}" for each in shown))
    typer.echo(f"conventional over universal joint: {found.ratio:.2f}")
    if np.isfinite(found.cable_motion).all():
        moved = 1e3 * float(np.linalg.norm(found.cable_motion[:3]))
        typer.echo(f"for its cables' elasticity alone the platform moves by {moved:.3f} mm")
    for each in stress.varied:
        stresses = f"{each.universal_joint / 1e6:>10.1f} {each.conventional / 1e6:>10.1f} MPa"
        typer.echo(f"{each.name:<22} x {each.factor:<5.2f}{stresses}  ratio {each.ratio:.2f}")


def _stress(peak: Peak) -> str:
    """A stress with its error, as far as that is known."""
    error = f" ({100 * peak.error:.1f} %)" if peak.error == peak.error else ""
    return f"{peak.stress / 1e6:.1f}{error}"


def _zero(value: float) -> float:
    """A moment that is rounding as 0, without its sign."""
    return 0.0 if abs(value) < 1e-6 else value
