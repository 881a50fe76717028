"""`inverse` and `forward`: one pose to lengths, one set of lengths to a pose."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

import typer

from cablewright.apps.cli.options import (
    AsJson,
    Cable,
    Limits,
    LoadName,
    Retracted,
    RobotName,
    Sheave,
    Slack,
    Wrench,
    described,
    slack_excess,
)
from cablewright.apps.cli.output import limits, numbers, print_json, progress, tell

if TYPE_CHECKING:
    from cablewright.models.statics import Equilibrium, Model

NO = 1


def inverse(
    robot: RobotName,
    at: Annotated[
        str, typer.Option("--at", metavar="X,Y,Z[,RX,RY,RZ]", help="Pose, m and rad; `free` where gravity decides.")
    ],
    cable: Cable = "catenary",
    sheave: Sheave = None,
    tension_limits: Limits = None,
    retraction: Retracted = None,
    load: LoadName = None,
    wrench: Wrench = None,
    slack: Slack = None,
    all_slack_sets: Annotated[
        bool, typer.Option("--all-slack-sets", help="Every set of lines that can be slack at this pose.")
    ] = False,
    as_json: AsJson = False,
) -> int:
    """The lengths and tensions that hold the platform at a pose."""
    from cablewright.errors import InputError
    from cablewright.models.fidelity import Fidelity
    from cablewright.models.statics import Model
    from cablewright.solvers.inverse import solve_inverse

    model = Model(described(robot, load, wrench), Fidelity.of(cable, sheave), limits(tension_limits))
    pose = numbers(at, "--at", free=True) or []
    if slack is not None and all_slack_sets:
        raise InputError("--slack and --all-slack-sets: only one of them")
    if all_slack_sets:
        return _all_slack_sets(_retracted(model, retraction), pose, as_json)
    if slack is not None:
        return _with_slack(_retracted(model, retraction), pose, slack, as_json)
    return _held(solve_inverse(model, pose, retraction=retraction), {}, as_json)


def _held(found: Equilibrium, more: dict[str, Any], as_json: bool) -> int:
    """Print a solved inverse problem; the limits of the machine have their say too."""
    from cablewright.errors import Status

    status, sentence = found.status, found.sentence()
    if status is Status.OK and (broken := _broken_limit(found)):
        status, sentence = Status.OUT_OF_LIMITS, broken
    return _answer(found, found.to_dict() | {"status": status.word} | more, status is Status.OK, sentence, as_json)


def _retracted(model: Model, retraction: float | None) -> Model:
    return model if retraction is None else replace(model, robot=model.robot.retracted(retraction))


def _with_slack(model: Model, pose: list[float], slack: str, as_json: bool) -> int:
    from cablewright.solvers.slack import excess_lengths, solve_with_slack

    found = solve_with_slack(model, pose, slack_excess(model.robot, slack))
    return _held(found, {"excess": excess_lengths(found)}, as_json)


def _all_slack_sets(model: Model, pose: list[float], as_json: bool) -> int:
    from cablewright.errors import Status
    from cablewright.solvers.slack import slack_sets

    found = slack_sets(model, pose)
    status = Status.OK if found else Status.INFEASIBLE
    if as_json:
        print_json(
            {"status": status.word, "robot": model.robot.name, "pose": pose, "sets": [each.to_dict() for each in found]}
        )
    else:
        typer.echo(f"{model.robot.name}: {status.word}")
        for each in found:
            span = f"{each.excess_low:.3f} to {each.excess_high:.3f} m"
            typer.echo(f"slack {', '.join(each.slack)}: too long by {span}, ended by {each.ended_by}")
            for line, tension in zip(model.robot.lines, each.tensions, strict=True):
                typer.echo(f"  {line.name:<14} {tension:>13.3f} N" + ("  slack" if line.name in each.slack else ""))
    if not found:
        tell(
            f"cablewright: no {model.n} of the {model.m} lines hold this pose within their limits with the others slack"
        )
    return 0 if found else NO


def forward(
    robot: RobotName,
    lengths: Annotated[str, typer.Option("--lengths", metavar="L1,..,Lm", help="Unstrained lengths, m.")],
    guess: Annotated[
        str | None, typer.Option("--guess", metavar="X,Y,Z[,RX,RY,RZ]", help="A pose to start from, m and rad.")
    ] = None,
    cable: Annotated[str, typer.Option("--cable", help="elastic or catenary.")] = "catenary",
    sheave: Sheave = None,
    modulus_factors: Annotated[
        str | None,
        typer.Option("--modulus-factors", metavar="F1,..,Fm", help="Factors on each line's Young's modulus."),
    ] = None,
    retraction: Retracted = None,
    load: LoadName = None,
    wrench: Wrench = None,
    certify: Annotated[
        bool, typer.Option("--certify", help="Prove that exactly one equilibrium is there, and how near.")
    ] = False,
    length_error: Annotated[
        str | None,
        typer.Option(
            "--length-error", metavar="D[,..,Dm]", help="Error of the lengths, m: a box that surely holds the pose."
        ),
    ] = None,
    budget: Annotated[int | None, typer.Option("--budget", help="Leaves that the box may take; 20000.")] = None,
    as_json: AsJson = False,
) -> int:
    """The pose in which the platform hangs when the winches have paid out given lengths."""
    from cablewright.errors import Status
    from cablewright.models.fidelity import Fidelity
    from cablewright.models.statics import Model
    from cablewright.solvers.forward import solve_forward

    model = Model(described(robot, load, wrench), Fidelity.of(cable, sheave))
    found = solve_forward(
        model,
        numbers(lengths, "--lengths") or [],
        guess=numbers(guess, "--guess"),
        modulus_factors=numbers(modulus_factors, "--modulus-factors"),
        retraction=retraction,
    )
    values = found.to_dict()
    yes, sentence = found.status is Status.OK, found.sentence()
    if certify:
        values |= _certified(found)
        if yes and not values["certified"]:
            yes, sentence = False, values["certificate"]["reason"]
    if length_error is not None and found.status is Status.OK:
        values |= {"pose_box": _pose_box(found, length_error, budget)}
    return _answer(found, values, yes, sentence, as_json)


def _certified(found: Equilibrium) -> dict[str, Any]:
    """Whether an equilibrium is certified, and what its certificate says."""
    from cablewright.solvers.certify import certify, is_only_one

    proof = certify(found)
    only = ("globally" if is_only_one(found) else "locally") if proof.certified else None
    levers = {} if found.lines.has_lever.any() else {"levers": None}
    certificate = proof.to_dict() | levers | {"unique": only}
    return {"certified": certificate.pop("certified"), "certificate": certificate}


def _pose_box(found: Equilibrium, length_error: str, budget: int | None) -> dict[str, Any]:
    """Where the pose surely is for all lengths within an error."""
    from cablewright.solvers.pose_hull import BUDGET, enclose_poses

    errors = numbers(length_error, "--length-error") or []
    with progress() as show:
        box = enclose_poses(
            found,
            errors[0] if len(errors) == 1 else errors,
            budget=BUDGET if budget is None else budget,
            progress=show,
        )
    return box.to_dict()


def _box_lines(box: dict[str, Any]) -> str:
    """A box of poses for people."""
    if not box["certified"]:
        return f"box       {box['reason']}"
    unit = "m" if len(box["low"]) == 3 else "m, rad"
    low, high = ("  ".join(f"{x:.6f}" for x in rounded_out) for rounded_out in _outward(box["low"], box["high"]))
    return f"box from  {low}  {unit}\n     to   {high}  {unit}, for all lengths within the error"


def _outward(low: Any, high: Any) -> tuple[list[float], list[float]]:
    """Ends of a box with six decimals, rounded outward."""
    return [math.floor(1e6 * x) / 1e6 for x in low], [math.ceil(1e6 * x) / 1e6 for x in high]


def _proof(values: dict[str, Any]) -> str:
    """The certificate of a single equilibrium in one line."""
    certificate = values["certificate"]
    if not values["certified"]:
        return str(certificate["reason"])
    turned = f", {max(certificate['bound'][3:]):.1e} rad" if len(certificate["bound"]) > 3 else ""
    only = "the only one there is" if certificate["unique"] == "globally" else "the only one near"
    levers = "" if certificate["levers"] is None else f"; levers {certificate['levers']}"
    return f"certified: an equilibrium within {max(certificate['bound'][:3]):.1e} m{turned}, {only}{levers}"


def _broken_limit(found: Equilibrium) -> str | None:
    """The first limit of the machine, other than tension, that a balanced pose breaks, in one line."""
    from cablewright.analyses.feasibility import judge_pose

    for finding in judge_pose(found):
        if finding.violations:
            who = f"line {finding.line}: " if finding.line else ""
            return f"{who}{finding.limit} {finding.value:.6g} {finding.unit}; {finding.bounds()} is allowed"
    return None


def _answer(found: Equilibrium, values: dict[str, Any], yes: bool, sentence: str, as_json: bool) -> int:
    """Print the result; a no goes to stderr and gives exit code 1."""
    if as_json:
        print_json(values)
    else:
        typer.echo(f"{values['robot']}: {values['status']}")
        typer.echo(
            "pose      " + "  ".join(f"{x:.6f}" for x in found.pose) + ("  m" if len(found.pose) == 3 else "  m, rad")
        )
        typer.echo(f"{'line':<14} {'length m':>13} {'tension N':>13} {'at platform':>13} {'at winch':>13}")
        columns = (found.lengths, found.tensions, found.platform_tensions, found.winch_tensions)
        for line, length, tension, platform, winch in zip(found.model.robot.lines, *columns, strict=True):
            typer.echo(f"{line.name:<14} {length:>13.6f} {tension:>13.3f} {platform:>13.3f} {winch:>13.3f}")
        if "excess" in values:
            typer.echo("excess    " + "  ".join(f"{each:.6f}" for each in values["excess"]) + "  m")
        if "certificate" in values:
            typer.echo(_proof(values))
        if "pose_box" in values:
            typer.echo(_box_lines(values["pose_box"]))
        typer.echo(f"residual  {found.residual_norm():.1e} m, {found.unbalanced_force():.1e} N")
    if not yes:
        tell(f"cablewright: {sentence}")
    return 0 if yes else NO
