"""`inverse` and `forward`: one pose to lengths, one set of lengths to a pose."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

import typer

from cablewright.apps.cli.options import AsJson, LawOptions, LengthsOrLog, Pose, Retraction, RobotOptions, SheaveChoice
from cablewright.apps.cli.output import answer, compiling, progress
from cablewright.apps.cli.parsing import lengths_of, numbers, pose_of, slack_excess
from cablewright.errors import InputError
from cablewright.models.fidelity import CableLaw

if TYPE_CHECKING:
    from cablewright.models.statics import Equilibrium, Model
    from cablewright.results import Result
    from cablewright.solvers.pose_box import PoseBox


@dataclass(frozen=True, kw_only=True)
class InverseCommand:
    """Unless --slack or --all-slack-sets is given, all lines are taut where that is possible within their limits.

    The answer is no (exit 1) if the lines cannot hold the pose, or if a limit of the machine is broken there.
    """

    EXAMPLE: ClassVar = "inverse merlet2023 --at 0,0,1"
    ANSWERS: ClassVar = ("studies.one_pose:SolvedPose", "studies.one_pose:SlackSets")

    robot: RobotOptions
    at: Pose
    laws: LawOptions
    retraction: Retraction = None
    slack: Annotated[
        str | None,
        typer.Option(
            "--slack",
            metavar="LINE=EXCESS[,LINE=EXCESS]",
            help="Slack lines and by how much, m, each is longer than taut; a line by name, or by number from 1.",
        ),
    ] = None
    all_slack_sets: Annotated[
        bool, typer.Option("--all-slack-sets", help="List every set of lines that can be slack at this pose.")
    ] = False
    as_json: AsJson = False

    def run(self) -> int:
        """Solve and print."""
        with compiling("inverse", "residuals"):
            return answer(self.found(), self.as_json)

    def found(self) -> Result:
        """The requested solution, judged by all limits of the machine. Raises `InputError`."""
        from cablewright.models.statics import Model
        from cablewright.solvers.inverse import solve_inverse
        from cablewright.solvers.slack import slack_sets, solve_with_slack
        from cablewright.studies.one_pose import SlackSets, SolvedPose

        model = Model.of(self.robot.loaded(), **self.laws.laws())
        pose = pose_of(self.at, model.robot) or []
        if self.slack is not None and self.all_slack_sets:
            raise InputError("--slack and --all-slack-sets: give one of them")
        if self.slack is None and not self.all_slack_sets:
            return SolvedPose.judged(solve_inverse(model, pose, retraction=self.retraction))
        if self.retraction is not None:
            model = replace(model, robot=model.robot.retracted(self.retraction))
        if self.slack is None:
            return SlackSets(model, tuple(pose), slack_sets(model, pose))
        return SolvedPose.judged(solve_with_slack(model, pose, slack_excess(model.robot, self.slack)), slack=True)


@dataclass(frozen=True, kw_only=True)
class ForwardCommand:
    """Lines may be slack. Without --guess the solve needs no start; of several equilibria it finds one.

    --lengths may be a CSV file: a machine's log, or the lengths.csv of a check, solved row by row along the path.

    The answer is no (exit 1) if none is found, a cable would break, or a requested proof fails.
    """

    EXAMPLE: ClassVar = "forward merlet2023 --lengths 10.43,10.43,10.43,10.43 --certify"
    ANSWERS: ClassVar = ("studies.one_pose:SolvedPose", "exchange.length_log:LoggedPoses")

    robot: RobotOptions
    lengths: LengthsOrLog
    guess: Annotated[
        str | None, typer.Option("--guess", metavar="X,Y,Z[,RX,RY,RZ]", help="Pose to start from, m and rad.")
    ] = None
    cable: Annotated[CableLaw, typer.Option("--cable", help="Cable law; rigid cables have no such solution.")] = (
        CableLaw.CATENARY
    )
    sheave: SheaveChoice = None
    modulus_factors: Annotated[
        str | None,
        typer.Option("--modulus-factors", metavar="F1,..,Fm", help="Factor on the Young's modulus of each line."),
    ] = None
    retraction: Retraction = None
    certify: Annotated[
        bool, typer.Option("--certify", help="Prove that exactly one equilibrium is near, and how near.")
    ] = False
    length_error: Annotated[
        str | None,
        typer.Option(
            "--length-error",
            metavar="D[,..,Dm]",
            help="Error of the lengths, m, for a box that is proved to contain the pose.",
        ),
    ] = None
    budget: Annotated[
        int | None, typer.Option("--budget", help="Max number of parts of the lengths for that box; by default 20000.")
    ] = None
    as_json: AsJson = False

    def run(self) -> int:
        """Solve and print."""
        with compiling("forward", "residuals", *(["certify"] if self.certify else [])):
            return answer(self.found(), self.as_json)

    def found(self) -> Result:
        """The solution, with the proofs that are requested. Raises `InputError`."""
        from cablewright.models.statics import Model
        from cablewright.solvers.certify import certify
        from cablewright.solvers.forward import solve_forward
        from cablewright.studies.one_pose import SolvedPose

        model = Model.of(self.robot.loaded(), cable=self.cable, sheave=self.sheave)
        if self.lengths.lower().endswith(".csv"):
            return self._logged(model)
        found = solve_forward(
            model,
            lengths_of(self.lengths, model.robot),
            guess=numbers(self.guess, "--guess"),
            modulus_factors=numbers(self.modulus_factors, "--modulus-factors"),
            retraction=self.retraction,
        )
        proof = certify(found) if self.certify else None
        box = self._pose_box(found) if self.length_error is not None and found.ok else None
        return SolvedPose(found, certificate=proof, pose_box=box)

    def _logged(self, model: Model) -> Result:
        """Solve a file of lengths."""
        from cablewright.exchange.length_log import forward_log, read_lengths

        options = {
            "modulus_factors": self.modulus_factors,
            "retraction": self.retraction,
            "length_error": self.length_error,
        }
        for name, given in options.items():
            if given is not None:
                raise InputError(f"--{name.replace('_', '-')} = {given}: is for one set of lengths, not for a file")
        if self.certify:
            raise InputError("--certify: is for one set of lengths, not for a file")
        model.refuse_rigid()
        log = read_lengths(Path(self.lengths), model.robot)
        return forward_log(model, log, numbers(self.guess, "--guess"))

    def _pose_box(self, found: Equilibrium) -> PoseBox:
        """Where the pose is for all lengths within their error."""
        from cablewright.solvers.pose_hull import BUDGET, enclose_poses

        errors = numbers(self.length_error, "--length-error") or []
        budget = BUDGET if self.budget is None else self.budget
        with progress() as show:
            return enclose_poses(found, errors[0] if len(errors) == 1 else errors, budget=budget, progress=show)
