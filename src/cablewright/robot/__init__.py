"""Descriptions of a cable robot: frozen models of its parts, read from TOML. Imports no numerics."""

from cablewright.robot.bracket import Bracket, load_bracket
from cablewright.robot.cable import Cable
from cablewright.robot.dynamics import ASSUMED_DAMPING, Damping, Dynamics
from cablewright.robot.file_schema import json_schema
from cablewright.robot.files import file_text, library_names, library_text, load, loads
from cablewright.robot.line import Line
from cablewright.robot.parameter_values import Kind
from cablewright.robot.parameters import KINDS, Parameter, nominal, parameters_of, with_value
from cablewright.robot.plane import Plane
from cablewright.robot.platform import Box, Load, Platform, PointPlatform, Retraction, RigidPlatform
from cablewright.robot.robot import Robot
from cablewright.robot.scene import Beam, Scene
from cablewright.robot.sheave import (
    Eyelet,
    GuideSheave,
    PlatformPulley,
    PlatformSheave,
    Pulley,
    Sheave,
    Swivel,
    UniversalJoint,
)
from cablewright.robot.uncertainty import (
    Range,
    Uncertain,
    Uncertainty,
    assumed_uncertainty,
    load_uncertainty,
    modulus_ranges,
)
from cablewright.robot.winch import SharedWinch, Winch
from cablewright.robot.write_back import update

__all__ = [
    "ASSUMED_DAMPING",
    "KINDS",
    "Beam",
    "Box",
    "Bracket",
    "Cable",
    "Damping",
    "Dynamics",
    "Eyelet",
    "GuideSheave",
    "Kind",
    "Line",
    "Load",
    "Parameter",
    "Plane",
    "Platform",
    "PlatformPulley",
    "PlatformSheave",
    "PointPlatform",
    "Pulley",
    "Range",
    "Retraction",
    "RigidPlatform",
    "Robot",
    "Scene",
    "SharedWinch",
    "Sheave",
    "Swivel",
    "Uncertain",
    "Uncertainty",
    "UniversalJoint",
    "Winch",
    "assumed_uncertainty",
    "file_text",
    "json_schema",
    "library_names",
    "library_text",
    "load",
    "load_bracket",
    "load_uncertainty",
    "loads",
    "modulus_ranges",
    "nominal",
    "parameters_of",
    "update",
    "with_value",
]
