"""cablewright models, checks, calibrates and runs cable-driven parallel robots that print large parts.

The names below are the public interface. They are loaded when first used, so that a description alone
(`cablewright.robot`) costs neither Numba nor plotting.

Describe a robot and a job: changed, curves, library_names, load, load_job, load_uncertainty, loads, modulus_ranges,
    read_stl, with_box_inertia, CableLaw, Change, Curve, Curves, Fidelity, Job, Model, Parameter, Range,
    RankedCurve, Robot, SheaveLaw, TriangleMesh, Uncertainty.
Statics: capacity, certify, enclose_poses, equilibria, excess_lengths, forward, inverse, let_out, linearise,
    slack_sets, solve_with_slack, tension_distribution, wrench_closure, Capacity, Certificate, Distribution,
    Equilibria, Equilibrium, Linearisation, PoseBox, Quadratic, SlackSet, Tracker, TrackerSettings.
Analyse: accuracy, boundary_modes, bracket, check, count_nodes, design, interference, modes, retraction, trade,
    workspace, workspace_area, Accuracy, AccuracyAtPose, AccuracyStudy, Boundary, BracketStress, Check, Designed,
    FirstOrder, FREEDOMS, Interference, InterferenceSettings, JobInterference, Modes, MonteCarlo, NodeCount, Places,
    RetractionLaw, RetractionStudy, Trade, TradeSettings, Vertices, Workspace, WorkspaceArea.
Calibrate: aligned, calibrate, calibration_poses, check_drift, creep, guide, modulus, read_scan, simulate_calibration,
    survey, walls, Calibration, CalibrationPlan, CalibrationPoses, CalibrationRecord, Drift, FileScan, Guidance,
    Laser, LidarPlace, Measured, RoomMap, SensorNoise,
    Shot, Shots, Sigmas, SimulatedCalibration, Survey, SurveyPlan, TensileResult, TensileTest, Walls.
Print and simulate: campaign, load_machine, load_twin, machine_names, pour, print_job, random_loop, read_log, replay,
    simulate, Campaign, Command, DriveSettings, Encoders, HeightField, MachineSettings, Pilot, Powder, PrintedJob,
    PrintOptions, Replay, Scan, SensorFrame, SimulatedMachine, Simulation, SimulationSettings, TwinSettings.
Results and errors: AnswerError, CablewrightError, EnvironmentFault, Figure, InputError, Result, Status,
    UnknownName.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cablewright.analyses.accuracy.nozzle_error import Accuracy
    from cablewright.analyses.accuracy.spread import FirstOrder, MonteCarlo, Vertices
    from cablewright.analyses.interference import Interference, InterferenceSettings
    from cablewright.analyses.modes import FREEDOMS, Modes, modes
    from cablewright.analyses.workspace.area import WorkspaceArea, workspace_area
    from cablewright.analyses.workspace.boundary_modes import Boundary, boundary_modes
    from cablewright.analyses.workspace.criterion import RetractionLaw
    from cablewright.analyses.workspace.retraction import RetractionStudy, retraction
    from cablewright.analyses.workspace.workspace import NodeCount, Workspace, count_nodes, workspace
    from cablewright.calibration.calibrate import calibrate
    from cablewright.calibration.drift.drift import Drift, check_drift
    from cablewright.calibration.drift.record import CalibrationRecord
    from cablewright.calibration.guidance.guide import Guidance, guide
    from cablewright.calibration.guidance.selection import CalibrationPoses, calibration_poses
    from cablewright.calibration.judgement.result import Calibration
    from cablewright.calibration.measurements import Measured
    from cablewright.calibration.plan import CalibrationPlan, Sigmas
    from cablewright.calibration.poses.simulation import (
        SensorNoise,
        SimulatedCalibration,
        aligned,
        simulate_calibration,
    )
    from cablewright.calibration.survey.plan import SurveyPlan
    from cablewright.calibration.survey.result import Survey
    from cablewright.calibration.survey.shots import Shot, Shots
    from cablewright.calibration.survey.survey import survey
    from cablewright.calibration.tensile.creep import creep
    from cablewright.calibration.tensile.modulus import TensileResult, modulus
    from cablewright.calibration.tensile.recording import TensileTest
    from cablewright.errors import AnswerError, CablewrightError, EnvironmentFault, InputError, Status, UnknownName
    from cablewright.estimation.lidar.room import Laser, RoomMap
    from cablewright.estimation.lidar.scan_file import FileScan, read_scan
    from cablewright.machine.files import load_machine, machine_names
    from cablewright.machine.log.log import read_log
    from cablewright.machine.settings import MachineSettings
    from cablewright.machine.simulated.settings import SimulationSettings, TwinSettings, load_twin
    from cablewright.machine.simulated.simulated_machine import SimulatedMachine
    from cablewright.models.fidelity import CableLaw, Fidelity, SheaveLaw
    from cablewright.models.statics import Equilibrium, Model
    from cablewright.printing.curve import Curve, Curves, RankedCurve, curves
    from cablewright.printing.deposition import Powder, pour
    from cablewright.printing.heightfield import HeightField
    from cablewright.printing.job import Job, load_job
    from cablewright.printing.stl import read_stl
    from cablewright.results import Figure, Result
    from cablewright.robot import Robot, library_names, load, load_uncertainty, loads, modulus_ranges
    from cablewright.robot.design_variables import Change, changed, with_box_inertia
    from cablewright.robot.parameters import Parameter
    from cablewright.robot.uncertainty import Range, Uncertainty
    from cablewright.signals import Command, Encoders, Scan, SensorFrame
    from cablewright.solvers.certify import Certificate, certify
    from cablewright.solvers.continuation import Tracker, TrackerSettings
    from cablewright.solvers.equilibria import Equilibria, equilibria
    from cablewright.solvers.forward import forward
    from cablewright.solvers.inverse import inverse
    from cablewright.solvers.linearise import Linearisation, linearise
    from cablewright.solvers.pose_box import PoseBox
    from cablewright.solvers.pose_hull import enclose_poses
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
    from cablewright.studies.bracket import BracketStress, bracket
    from cablewright.studies.campaigns.campaign import campaign
    from cablewright.studies.campaigns.result import Campaign
    from cablewright.studies.checks.check import check
    from cablewright.studies.checks.result import Check
    from cablewright.studies.design.result import Designed
    from cablewright.studies.design.search import design
    from cablewright.studies.drive import DriveSettings, Pilot, random_loop
    from cablewright.studies.interference import JobInterference, interference
    from cablewright.studies.places import Places
    from cablewright.studies.prints.plan import PrintOptions
    from cablewright.studies.prints.print_job import PrintedJob, print_job
    from cablewright.studies.replay import Replay, replay
    from cablewright.studies.simulate import Simulation, simulate
    from cablewright.studies.trade import Trade, TradeSettings, trade
    from cablewright.studies.walls import LidarPlace, Walls, walls
    from cablewright.triangle_mesh import TriangleMesh

__all__ = [
    "FREEDOMS",
    "Accuracy",
    "AccuracyAtPose",
    "AccuracyStudy",
    "AnswerError",
    "Boundary",
    "BracketStress",
    "CableLaw",
    "CablewrightError",
    "Calibration",
    "CalibrationPlan",
    "CalibrationPoses",
    "CalibrationRecord",
    "Campaign",
    "Capacity",
    "Certificate",
    "Change",
    "Check",
    "Command",
    "Curve",
    "Curves",
    "Designed",
    "Distribution",
    "Drift",
    "DriveSettings",
    "Encoders",
    "EnvironmentFault",
    "Equilibria",
    "Equilibrium",
    "Fidelity",
    "Figure",
    "FileScan",
    "FirstOrder",
    "Guidance",
    "HeightField",
    "InputError",
    "Interference",
    "InterferenceSettings",
    "Job",
    "JobInterference",
    "Laser",
    "LidarPlace",
    "Linearisation",
    "MachineSettings",
    "Measured",
    "Model",
    "Modes",
    "MonteCarlo",
    "NodeCount",
    "Parameter",
    "Pilot",
    "Places",
    "PoseBox",
    "Powder",
    "PrintOptions",
    "PrintedJob",
    "Quadratic",
    "Range",
    "RankedCurve",
    "Replay",
    "Result",
    "RetractionLaw",
    "RetractionStudy",
    "Robot",
    "RoomMap",
    "Scan",
    "SensorFrame",
    "SensorNoise",
    "SheaveLaw",
    "Shot",
    "Shots",
    "Sigmas",
    "SimulatedCalibration",
    "SimulatedMachine",
    "Simulation",
    "SimulationSettings",
    "SlackSet",
    "Status",
    "Survey",
    "SurveyPlan",
    "TensileResult",
    "TensileTest",
    "Tracker",
    "TrackerSettings",
    "Trade",
    "TradeSettings",
    "TriangleMesh",
    "TwinSettings",
    "Uncertainty",
    "UnknownName",
    "Vertices",
    "Walls",
    "Workspace",
    "WorkspaceArea",
    "accuracy",
    "aligned",
    "boundary_modes",
    "bracket",
    "calibrate",
    "calibration_poses",
    "campaign",
    "capacity",
    "certify",
    "changed",
    "check",
    "check_drift",
    "count_nodes",
    "creep",
    "curves",
    "design",
    "enclose_poses",
    "equilibria",
    "excess_lengths",
    "forward",
    "guide",
    "interference",
    "inverse",
    "let_out",
    "library_names",
    "linearise",
    "load",
    "load_job",
    "load_machine",
    "load_twin",
    "load_uncertainty",
    "loads",
    "machine_names",
    "modes",
    "modulus",
    "modulus_ranges",
    "pour",
    "print_job",
    "random_loop",
    "read_log",
    "read_scan",
    "read_stl",
    "replay",
    "retraction",
    "simulate",
    "simulate_calibration",
    "slack_sets",
    "solve_with_slack",
    "survey",
    "tension_distribution",
    "trade",
    "walls",
    "with_box_inertia",
    "workspace",
    "workspace_area",
    "wrench_closure",
]  # fmt: skip

_HOMES = {
    home: names.split()
    for home, names in {
        "analyses.accuracy.nozzle_error": "Accuracy",
        "analyses.accuracy.spread": "FirstOrder MonteCarlo Vertices",
        "analyses.interference": "Interference InterferenceSettings",
        "analyses.modes": "FREEDOMS Modes modes",
        "analyses.workspace.area": "WorkspaceArea workspace_area",
        "analyses.workspace.boundary_modes": "Boundary boundary_modes",
        "analyses.workspace.criterion": "RetractionLaw",
        "analyses.workspace.retraction": "RetractionStudy retraction",
        "analyses.workspace.workspace": "NodeCount Workspace count_nodes workspace",
        "calibration.calibrate": "calibrate",
        "calibration.drift.drift": "Drift check_drift",
        "calibration.drift.record": "CalibrationRecord",
        "calibration.guidance.guide": "Guidance guide",
        "calibration.guidance.selection": "CalibrationPoses calibration_poses",
        "calibration.judgement.result": "Calibration",
        "calibration.measurements": "Measured",
        "calibration.plan": "CalibrationPlan Sigmas",
        "calibration.poses.simulation": "SensorNoise SimulatedCalibration aligned simulate_calibration",
        "calibration.survey.plan": "SurveyPlan",
        "calibration.survey.result": "Survey",
        "calibration.survey.shots": "Shot Shots",
        "calibration.survey.survey": "survey",
        "calibration.tensile.creep": "creep",
        "calibration.tensile.modulus": "TensileResult modulus",
        "calibration.tensile.recording": "TensileTest",
        "errors": "AnswerError CablewrightError EnvironmentFault InputError Status UnknownName",
        "estimation.lidar.room": "Laser RoomMap",
        "estimation.lidar.scan_file": "FileScan read_scan",
        "machine.files": "load_machine machine_names",
        "machine.log.log": "read_log",
        "machine.settings": "MachineSettings",
        "machine.simulated.settings": "SimulationSettings TwinSettings load_twin",
        "machine.simulated.simulated_machine": "SimulatedMachine",
        "models.fidelity": "CableLaw Fidelity SheaveLaw",
        "models.statics": "Equilibrium Model",
        "printing.curve": "Curve Curves RankedCurve curves",
        "printing.deposition": "Powder pour",
        "printing.heightfield": "HeightField",
        "printing.job": "Job load_job",
        "printing.stl": "read_stl",
        "results": "Figure Result",
        "robot": "Robot library_names load load_uncertainty loads modulus_ranges",
        "robot.design_variables": "Change changed with_box_inertia",
        "robot.parameters": "Parameter",
        "robot.uncertainty": "Range Uncertainty",
        "signals": "Command Encoders Scan SensorFrame",
        "solvers.certify": "Certificate certify",
        "solvers.continuation": "Tracker TrackerSettings",
        "solvers.equilibria": "Equilibria equilibria",
        "solvers.forward": "forward",
        "solvers.inverse": "inverse",
        "solvers.linearise": "Linearisation linearise",
        "solvers.pose_box": "PoseBox",
        "solvers.pose_hull": "enclose_poses",
        "solvers.slack": "SlackSet excess_lengths let_out slack_sets solve_with_slack",
        "solvers.tension": "Capacity Distribution Quadratic capacity tension_distribution wrench_closure",
        "studies.accuracy": "AccuracyStudy accuracy",
        "studies.accuracy_at_pose": "AccuracyAtPose",
        "studies.bracket": "BracketStress bracket",
        "studies.campaigns.campaign": "campaign",
        "studies.campaigns.result": "Campaign",
        "studies.checks.check": "check",
        "studies.checks.result": "Check",
        "studies.design.result": "Designed",
        "studies.design.search": "design",
        "studies.drive": "DriveSettings Pilot random_loop",
        "studies.interference": "JobInterference interference",
        "studies.places": "Places",
        "studies.prints.plan": "PrintOptions",
        "studies.prints.print_job": "PrintedJob print_job",
        "studies.replay": "Replay replay",
        "studies.simulate": "Simulation simulate",
        "studies.trade": "Trade TradeSettings trade",
        "studies.walls": "LidarPlace Walls walls",
        "triangle_mesh": "TriangleMesh",
    }.items()
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
