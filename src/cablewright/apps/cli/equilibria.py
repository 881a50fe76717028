"""`equilibria`: every pose in which given lengths may hang."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from cablewright.apps.cli.options import AsJson, LoadName, Retracted, RobotName, Sheave, Wrench, described
from cablewright.apps.cli.output import numbers, print_json
from cablewright.errors import AnswerError

if TYPE_CHECKING:
    from cablewright.solvers.branches import Equilibria

__all__ = ["equilibria"]


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
    sheave: Sheave = None,
    retraction: Retracted = None,
    load: LoadName = None,
    wrench: Wrench = None,
    as_json: AsJson = False,
) -> int:
    """Every equilibrium that many starts find for given lengths: slack or taut, stable or not."""
    from cablewright.models.fidelity import Fidelity
    from cablewright.models.statics import Model
    from cablewright.solvers.branches import equilibria as find

    machine = described(robot, load, wrench)
    if retraction is not None:
        machine = machine.retracted(retraction)
    model = Model(machine, Fidelity.of("catenary", sheave))
    given = numbers(lengths, "--lengths") or []
    try:
        found = find(model, given, box=numbers(box, "--box"), starts=starts, seed=seed)
    except AnswerError as reason:
        if as_json:
            print_json({"status": "refused", "reason": str(reason)})
        raise
    if as_json:
        print_json({"status": "ok"} | _values(found))
    else:
        _print(found)
    return 0


def _values(found: Equilibria) -> dict[str, object]:
    """The figures of the JSON, SI."""
    rows = [
        {
            "status": one.status.word,
            "stable": bool(stable),
            "pose": one.pose,
            "tensions": one.tensions,
            "slack": slack,
            "certified": bool(certified),
            "bound": bound,
        }
        for one, stable, slack, certified, bound in zip(
            (found.solutions[row] for row in range(len(found.stable))),
            found.stable,
            found.slack,
            found.certificates.certified,
            found.certificates.bound,
            strict=True,
        )
    ]
    return {
        "robot": found.solutions.model.robot.name,
        "lengths": found.solutions.lengths[0],
        "solutions": rows,
        "complete": found.complete,
        "why": found.why,
        "starts": found.starts,
        "outside": found.outside,
    }


def _print(found: Equilibria) -> None:
    """The equilibria for people, one a line."""
    names = [line.name for line in found.solutions.model.robot.lines]
    count = len(found.stable)
    typer.echo(f"{count} equilibri{'um' if count == 1 else 'a'}, {int(found.stable.sum())} stable")
    for row in range(count):
        one = found.solutions[row]
        pose = " ".join(f"{x:9.4f}" for x in one.pose)
        loose = ", ".join(name for name, slack in zip(names, found.slack[row], strict=True) if slack) or "none"
        proved = "certified" if found.certificates.certified[row] else "not certified"
        typer.echo(f"{one.status.word:<15} {pose}  {proved}, slack: {loose}")
    if found.outside:
        typer.echo(f"and {found.outside} outside the box: --box widens it")
    typer.echo(f"{'complete' if found.complete else 'not proved complete'}: {found.why}")
