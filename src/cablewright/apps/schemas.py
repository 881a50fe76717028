"""JSON Schemas of all files that are read, by their kind."""

from importlib import import_module
from typing import Any, Final

from cablewright.foundation.choices import FileKind
from cablewright.foundation.validation import FileDescription

_MODELS: Final[dict[FileKind, tuple[str, str]]] = {
    "job": ("printing.job", "Job"),
    "machine": ("machine.simulated.settings", "MachineFile"),
    "uncertainty": ("robot.uncertainty", "Uncertainty"),
    "calibration": ("calibration.plan", "CalibrationPlan"),
    "survey": ("calibration.survey.plan", "SurveyPlan"),
}


def json_schema(kind: FileKind) -> dict[str, Any]:
    """Return the JSON Schema of the files of a *kind*."""
    if kind == "robot":
        from cablewright.robot import json_schema as of_robots

        return of_robots()
    module, name = _MODELS[kind]
    model: type[FileDescription] = getattr(import_module(f"cablewright.{module}"), name)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **model.model_json_schema()}
