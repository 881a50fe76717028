"""cablewright models, checks, calibrates and runs cable-driven parallel robots that print large parts.

The names below are the public interface. They are loaded when first used, so that a description alone
(`cablewright.robot`) costs neither Numba nor plotting.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cablewright.analyses.accuracy.nozzle_error import Accuracy
    from cablewright.analyses.accuracy.spread import FirstOrder, MonteCarlo, Vertices
    from cablewright.analyses.interference import Interference, InterferenceSettings
    from cablewright.errors import AnswerError, CablewrightError, EnvironmentFault, InputError, Status
    from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
    from cablewright.models.statics import Equilibrium, Model
    from cablewright.printing.job import Job, load_job
    from cablewright.robot import Robot, library_names, load, load_uncertainty, loads, modulus_ranges
    from cablewright.robot.parameters import Parameter
    from cablewright.robot.uncertainty import Range, Uncertainty
    from cablewright.solvers.certify import Certificate, certify
    from cablewright.solvers.continuation import Tracker, TrackerSettings
    from cablewright.solvers.equilibria import Equilibria, equilibria
    from cablewright.solvers.forward import forward
    from cablewright.solvers.inverse import inverse
    from cablewright.solvers.linearise import Linearisation, linearise
    from cablewright.solvers.pose_hull import PoseBox, enclose_poses
    from cablewright.solvers.slack import SlackSet, excess_lengths, let_out, slack_sets, solve_with_slack
    from cablewright.solvers.tension import (
        Capacity,
        Distribution,
        Quadratic,
        capacity,
        tension_distribution,
        wrench_closure,
    )
    from cablewright.studies.accuracy import AccuracyStudy, accuracy
    from cablewright.studies.accuracy_at_pose import AccuracyAtPose
    from cablewright.studies.check import Check, check
    from cablewright.studies.interference import JobInterference, interference
    from cablewright.studies.places import Places

__all__ = [
    "Accuracy",
    "AccuracyAtPose",
    "AccuracyStudy",
    "AnswerError",
    "CableLaw",
    "CablewrightError",
    "Capacity",
    "Certificate",
    "Check",
    "Distribution",
    "EnvironmentFault",
    "Equilibria",
    "Equilibrium",
    "Fidelity",
    "FirstOrder",
    "InputError",
    "Interference",
    "InterferenceSettings",
    "Job",
    "JobInterference",
    "Linearisation",
    "Model",
    "MonteCarlo",
    "Parameter",
    "Places",
    "PoseBox",
    "Quadratic",
    "Range",
    "Robot",
    "SheaveLaw",
    "SlackSet",
    "Status",
    "Tracker",
    "TrackerSettings",
    "Uncertainty",
    "Vertices",
    "accuracy",
    "capacity",
    "certify",
    "check",
    "enclose_poses",
    "equilibria",
    "excess_lengths",
    "forward",
    "interference",
    "inverse",
    "let_out",
    "library_names",
    "linearise",
    "load",
    "load_job",
    "load_uncertainty",
    "loads",
    "modulus_ranges",
    "slack_sets",
    "solve_with_slack",
    "tension_distribution",
    "wrench_closure",
]

_HOMES = {
    "analyses.accuracy.nozzle_error": ("Accuracy",),
    "analyses.accuracy.spread": ("FirstOrder", "MonteCarlo", "Vertices"),
    "errors": ("AnswerError", "CablewrightError", "EnvironmentFault", "InputError", "Status"),
    "models.fidelity": ("CableLaw", "Fidelity", "SheaveLaw"),
    "models.statics": ("Equilibrium", "Model"),
    "printing.job": ("Job", "load_job"),
    "robot": ("Robot", "library_names", "load", "load_uncertainty", "loads", "modulus_ranges"),
    "solvers.equilibria": ("Equilibria", "equilibria"),
    "solvers.certify": ("Certificate", "certify"),
    "solvers.forward": ("forward",),
    "solvers.inverse": ("inverse",),
    "solvers.linearise": ("Linearisation", "linearise"),
    "solvers.pose_hull": ("PoseBox", "enclose_poses"),
    "solvers.slack": ("SlackSet", "excess_lengths", "let_out", "slack_sets", "solve_with_slack"),
    "solvers.tension": ("Capacity", "Distribution", "Quadratic", "capacity", "tension_distribution", "wrench_closure"),
    "solvers.continuation": ("Tracker", "TrackerSettings"),
    "analyses.interference": ("Interference", "InterferenceSettings"),
    "studies.interference": ("JobInterference", "interference"),
    "studies.accuracy": ("AccuracyStudy", "accuracy"),
    "studies.places": ("Places",),
    "robot.parameters": ("Parameter",),
    "robot.uncertainty": ("Range", "Uncertainty"),
    "studies.check": ("Check", "check"),
    "studies.accuracy_at_pose": ("AccuracyAtPose",),
}


def __getattr__(name: str) -> object:
    """Load a public name when it is first asked for (PEP 562)."""
    for home, names in _HOMES.items():
        if name in names:
            value = getattr(import_module(f"cablewright.{home}"), name)
            globals()[name] = value
            return value
    raise AttributeError(f"module 'cablewright' has no attribute {name!r}")


def __dir__() -> list[str]:
    """The public names, loaded or not."""
    return sorted(__all__)
