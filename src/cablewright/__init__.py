"""cablewright models, checks, calibrates and runs cable-driven parallel robots that print large parts.

The names below are the public interface. They are loaded when first used, so that a description alone
(`cablewright.robot`) costs neither Numba nor plotting.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cablewright.analyses.accuracy.nozzle_error import accuracy
    from cablewright.analyses.accuracy.spread import FirstOrder, MonteCarlo, Vertices
    from cablewright.analyses.interference import Interference, InterferenceSettings
    from cablewright.calibration.plan import CalibrationPlan, Sigmas
    from cablewright.calibration.poses import CalibrationPoses, calibration_poses
    from cablewright.calibration.problem import Measured
    from cablewright.calibration.result import Calibration
    from cablewright.calibration.simulation import SensorNoise, SimulatedCalibration, aligned, simulate_calibration
    from cablewright.calibration.solve import calibrate
    from cablewright.calibration.survey.plan import SurveyPlan
    from cablewright.calibration.survey.result import Survey
    from cablewright.calibration.survey.shots import Shot, Shots
    from cablewright.calibration.survey.survey import survey
    from cablewright.calibration.tensile.modulus import modulus
    from cablewright.calibration.tensile.recording import TensileTest
    from cablewright.calibration.tensile.result import TensileResult
    from cablewright.errors import AnswerError, CablewrightError, EnvironmentFault, InputError, Status
    from cablewright.estimation.lidar.room import Laser, RoomMap
    from cablewright.estimation.lidar.scan_file import FileScan, read_scan
    from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
    from cablewright.models.statics import Equilibrium, Model
    from cablewright.printing.curve import Curve, Curves, RankedCurve, curves
    from cablewright.printing.job import Job, load_job
    from cablewright.robot import Robot, library_names, load, load_uncertainty, loads, modulus_ranges
    from cablewright.solvers.certify import Certificate, certify
    from cablewright.solvers.continuation import Tracker, TrackerSettings
    from cablewright.solvers.equilibria import Equilibria, equilibria
    from cablewright.solvers.forward import forward
    from cablewright.solvers.inverse import inverse
    from cablewright.solvers.linearise import Linearisation, linearise
    from cablewright.studies.accuracy import Places, accuracy_over, accuracy_over_job, accuracy_over_workspace
    from cablewright.studies.accuracy_at_pose import accuracy_at
    from cablewright.studies.check import Check, check
    from cablewright.studies.interference import JobInterference, interference
    from cablewright.studies.walls import LidarPlace, Walls, walls

__all__ = [
    "AnswerError",
    "CableLaw",
    "CablewrightError",
    "Calibration",
    "CalibrationPlan",
    "CalibrationPoses",
    "Certificate",
    "Check",
    "Curve",
    "Curves",
    "EnvironmentFault",
    "Equilibria",
    "Equilibrium",
    "Fidelity",
    "FileScan",
    "FirstOrder",
    "InputError",
    "Interference",
    "InterferenceSettings",
    "Job",
    "JobInterference",
    "Laser",
    "LidarPlace",
    "Linearisation",
    "Measured",
    "Model",
    "MonteCarlo",
    "Places",
    "RankedCurve",
    "Robot",
    "RoomMap",
    "SensorNoise",
    "SheaveLaw",
    "Shot",
    "Shots",
    "Sigmas",
    "SimulatedCalibration",
    "Status",
    "Survey",
    "SurveyPlan",
    "TensileResult",
    "TensileTest",
    "Tracker",
    "TrackerSettings",
    "Vertices",
    "Walls",
    "accuracy",
    "accuracy_at",
    "accuracy_over",
    "accuracy_over_job",
    "accuracy_over_workspace",
    "aligned",
    "calibrate",
    "calibration_poses",
    "certify",
    "check",
    "curves",
    "equilibria",
    "forward",
    "interference",
    "inverse",
    "library_names",
    "linearise",
    "load",
    "load_job",
    "load_uncertainty",
    "loads",
    "modulus",
    "modulus_ranges",
    "read_scan",
    "simulate_calibration",
    "survey",
    "walls",
]

_HOMES = {
    "estimation.lidar.scan_file": (
        "FileScan",
        "read_scan",
    ),
    "estimation.lidar.room": (
        "Laser",
        "RoomMap",
    ),
    "studies.walls": (
        "LidarPlace",
        "Walls",
        "walls",
    ),
    "printing.curve": (
        "Curve",
        "Curves",
        "RankedCurve",
        "curves",
    ),
    "calibration.survey.shots": (
        "Shot",
        "Shots",
    ),
    "calibration.survey.plan": ("SurveyPlan",),
    "calibration.survey.result": ("Survey",),
    "calibration.survey.survey": ("survey",),
    "calibration.tensile.result": ("TensileResult",),
    "calibration.tensile.recording": ("TensileTest",),
    "calibration.tensile.modulus": ("modulus",),
    "calibration.solve": ("calibrate",),
    "calibration.result": ("Calibration",),
    "calibration.plan": (
        "CalibrationPlan",
        "Sigmas",
    ),
    "calibration.problem": ("Measured",),
    "calibration.poses": (
        "CalibrationPoses",
        "calibration_poses",
    ),
    "calibration.simulation": (
        "SensorNoise",
        "SimulatedCalibration",
        "aligned",
        "simulate_calibration",
    ),
    "analyses.accuracy.nozzle_error": ("accuracy",),
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
    "solvers.continuation": ("Tracker", "TrackerSettings"),
    "analyses.interference": ("Interference", "InterferenceSettings"),
    "studies.interference": ("JobInterference", "interference"),
    "studies.accuracy": ("Places", "accuracy_over", "accuracy_over_job", "accuracy_over_workspace"),
    "studies.check": ("Check", "check"),
    "studies.accuracy_at_pose": ("accuracy_at",),
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
