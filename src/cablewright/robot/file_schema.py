"""The JSON Schema of a robot file, for completion and checks in editors."""

from __future__ import annotations

from typing import Any

from cablewright.robot.default_tables import LINE_KEYS, PARTS
from cablewright.robot.robot import Robot

_SHEAVES = ("Eyelet", "Swivel", "UniversalJoint", "Pulley")


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema of the file format.

    It requires less than `loads`: a line may leave a key to a default table, which JSON Schema cannot express.
    """
    schema = Robot.model_json_schema()
    definitions = schema["$defs"]
    for name in ("Cable", "Winch", *_SHEAVES):
        definitions[name].pop("required", None)
    definitions["RigidPlatform"]["required"].append("kind")  # without it a platform is a point
    line = definitions["Line"]
    line["required"] = ["name"]
    line["properties"]["sheave"] = {"anyOf": [{"$ref": f"#/$defs/{name}"} for name in _SHEAVES]}
    shared = {key: line["properties"][key] for key in LINE_KEYS}
    schema["properties"] |= {part: line["properties"][part] for part in PARTS}
    schema["properties"]["line"] = {
        "title": "Line",
        "type": "object",
        "properties": shared,
        "additionalProperties": False,
    }
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
