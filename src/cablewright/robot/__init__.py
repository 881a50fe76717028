"""What is bolted on: frozen descriptions of a cable robot, read from TOML. Imports no numerics."""

from cablewright.robot.cable import Cable
from cablewright.robot.file_schema import json_schema
from cablewright.robot.files import library_names, library_text, load, loads
from cablewright.robot.line import Line
from cablewright.robot.platform import Load, Platform, PointPlatform, Retraction, RigidPlatform
from cablewright.robot.robot import Robot
from cablewright.robot.scene import Scene
from cablewright.robot.sheave import Eyelet, Sheave, Swivel, UniversalJoint
from cablewright.robot.winch import Winch
from cablewright.robot.write_back import update

__all__ = [
    "Cable",
    "Eyelet",
    "Line",
    "Load",
    "Platform",
    "PointPlatform",
    "Retraction",
    "RigidPlatform",
    "Robot",
    "Scene",
    "Sheave",
    "Swivel",
    "UniversalJoint",
    "Winch",
    "json_schema",
    "library_names",
    "library_text",
    "load",
    "loads",
    "update",
]
