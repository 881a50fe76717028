"""JSON Schemas of all input files, by kind."""

from __future__ import annotations

import re
import tomllib
from functools import cache
from importlib import import_module
from importlib.resources import files
from typing import Any, Final

from cablewright.foundation.choices import FileKind

_MODELS: Final[dict[FileKind, tuple[str, str]]] = {
    "robot": ("robot", "json_schema"),
    "job": ("printing.job", "Job"),
    "machine": ("machine.simulated.settings", "MachineFile"),
    "uncertainty": ("robot.uncertainty", "Uncertainty"),
    "calibration": ("calibration.plan", "CalibrationPlan"),
    "survey": ("calibration.survey.plan", "SurveyPlan"),
}


_LINK = re.compile(r"\[([^\[\]]*)\]\([^)]*\)")


def json_schema(kind: FileKind) -> dict[str, Any]:
    """Return the JSON Schema of the files of a *kind*, with the meaning of each key as its description."""
    module, name = _MODELS[kind]
    model: Any = getattr(import_module(f"cablewright.{module}"), name)
    of_kind: dict[str, Any] = model() if kind == "robot" else model.model_json_schema()
    inner = [*of_kind.get("$defs", {}).values(), of_kind["properties"].get("line", {})]
    for table in (of_kind, *(each for each in inner if "properties" in each)):
        for key, value in table["properties"].items():
            texts = [_LINK.sub(r"\1", meanings(table.get("title", "")).get(key, "")), value.get("description")]
            table["properties"][key] = value | {"description": ". ".join(filter(None, texts))}
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **of_kind}


@cache
def meanings(title: str) -> dict[str, str]:
    """Return the meaning of each key of the table that the class *title* describes, in Markdown; of others nothing."""
    found: dict[str, dict[str, str]] = tomllib.loads(files(__package__).joinpath("keys.toml").read_text("utf-8"))
    return found.get(title, {})
