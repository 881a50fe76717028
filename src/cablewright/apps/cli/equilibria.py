"""`equilibria`: every pose in which given lengths may hang."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cablewright.apps.cli.options import AsJson, LoadName, Retracted, RobotName, Sheave, Wrench, described
from cablewright.apps.cli.output import numbers, print_json, progress, tell
from cablewright.errors import AnswerError, InputError, Status

if TYPE_CHECKING:
    from cablewright.solvers.equilibria import Equilibria


def equilibria(
    robot: RobotName,
    lengths: Annotated[str, typer.Option("--lengths", metavar="L1,..,Lm", help="Unstrained lengths, m.")],
    box: Annotated[
        str | None,
        typer.Option("--box", metavar="X0,X1,Y0,Y1,Z0,Z1", help="Where to look, m; the frame and a quarter beyond it."),
    ] = None,
    starts: Annotated[
        int | None, typer.Option("--starts", help="Poses to begin from, for each pattern of levers on their head.")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", help="Seed of the poses to begin from.")] = 0,
    exhaustive: Annotated[
        bool, typer.Option("--exhaustive", help="Prove that there are no others in the box, as far as that goes.")
    ] = False,
    time_limit: Annotated[
        float | None, typer.Option("--time-limit", metavar="S", help="Of --exhaustive, s; 600. It can be gone on with.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE.npz", help="Where --exhaustive keeps how far it is; by default in runs/."),
    ] = None,
    sheave: Sheave = None,
    retraction: Retracted = None,
    load: LoadName = None,
    wrench: Wrench = None,
    as_json: AsJson = False,
) -> int:
    """Every equilibrium that many starts find for given lengths: slack or taut, stable or not."""
    from cablewright.models.fidelity import Fidelity
    from cablewright.models.statics import Model
    from cablewright.solvers.equilibria import equilibria as find

    machine = described(robot, load, wrench)
    if retraction is not None:
        machine = machine.retracted(retraction)
    model = Model(machine, Fidelity.of("catenary", sheave))
    given, corners = numbers(lengths, "--lengths") or [], numbers(box, "--box")
    if not exhaustive and (time_limit is not None or out is not None):
        raise InputError("--time-limit and --out: only with --exhaustive")
    try:
        found = find(model, given, box=corners, starts=starts, seed=seed)
    except AnswerError as reason:
        if as_json:
            print_json({"status": "refused", "reason": str(reason)})
        raise
    finished = True
    if exhaustive:
        found, finished = _search(found, corners, 600.0 if time_limit is None else time_limit, out)
    torn = _is_torn(found)
    if as_json:
        print_json({"status": "unfinished" if not finished else "overstretched" if torn else "ok"} | found.to_dict())
    else:
        _print(found)
    if torn:
        tell("cablewright: the lengths cannot meet: in every stable equilibrium a line is over its breaking load")
    return 0 if finished and not torn else 1


def _is_torn(found: Equilibria) -> bool:
    """Whether there are stable equilibria, and cables would break in all of them."""
    return set(found[found.stable].status) == {Status.OVERSTRETCHED}


def _search(found: Equilibria, box: list[float] | None, time_limit: float, out: Path | None) -> tuple[Equilibria, bool]:
    """Search for others; says where it is kept if the time was not enough."""
    from cablewright.studies.equilibria import search_all
    from cablewright.studies.store import folder_name

    name = found.solutions.model.robot.name
    file = out or Path("runs") / f"{folder_name('equilibria', name)}.npz"
    with progress() as shown:
        every, finished = search_all(found, box, file, time_limit=time_limit, progress=shown)
    if not finished:
        tell(f"ended after {time_limit:g} s; {file} has what is done: the same command goes on")
    return every, finished


def _print(found: Equilibria) -> None:
    """The equilibria for people, one a line."""
    names = [line.name for line in found.solutions.model.robot.lines]
    count = len(found)
    typer.echo(f"{count} equilibri{'um' if count == 1 else 'a'}, {int(found.stable.sum())} stable")
    for one, slack, proof in zip(found, found.slack, found.certificates, strict=True):
        pose = " ".join(f"{x:9.4f}" for x in one.pose)
        loose = ", ".join(name for name, hangs in zip(names, slack, strict=True) if hangs) or "none"
        proved = "certified" if proof.certified else "not certified"
        typer.echo(f"{one.status.word:<15} {pose}  {proved}, slack: {loose}")
    if found.outside:
        typer.echo(f"and {found.outside} outside the box: --box widens it")
    for box, why in zip(found.undecided, found.undecided_why, strict=True):
        typer.echo(f"undecided: {' '.join(f'{x:.3f}' for x in box)}: {why}")
    typer.echo(f"{'complete' if found.complete else 'not proved complete'}: {found.why}")
