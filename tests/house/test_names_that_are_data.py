"""Names of modules and classes that are written as text: a moved module or renamed class cannot leave one behind."""

from __future__ import annotations

import ast
import importlib
import importlib.util
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import cablewright
from cablewright.apps.cli.main import COMMANDS
from cablewright.apps.pictures.gallery import PICTURES
from cablewright.apps.schemas import _MODELS
from cablewright.foundation.results import Pictured
from cablewright.machine.log.topics import TOPICS

HOME = Path(cablewright.__file__).parent
_MODULE = re.compile(r"cablewright(\.[a-z_0-9]+)+")
_MEMBER = re.compile(r"([a-z_0-9]+(\.[a-z_0-9]+)*):([A-Za-z_]\w*)")


@cache
def texts() -> tuple[tuple[str, str], ...]:
    """Each text in the code, and where it stands."""
    return tuple(
        (node.value, f"{path.relative_to(HOME)}:{node.lineno}")
        for path in sorted(HOME.rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    )


def exists(name: str) -> bool:
    try:
        return importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:
        return False


def test_modules_that_texts_name_exist() -> None:
    """Modules that are run (-m), or whose folder holds data, among them."""
    named = [(text, where) for text, where in texts() if _MODULE.fullmatch(text)]
    assert {"cablewright.apps.serve.server", "cablewright.apps.compilation", "cablewright.robot"} <= dict(named).keys()
    assert [f"{where}: {text}" for text, where in named if not exists(text)] == []


def test_classes_that_texts_name_exist() -> None:
    """``module:class`` below `cablewright`."""
    named = [(found, where) for text, where in texts() if (found := _MEMBER.fullmatch(text))]
    assert len(named) > 20
    wrong = []
    for found, where in named:
        module = f"cablewright.{found[1]}"
        if not exists(module) or not hasattr(importlib.import_module(module), found[3]):
            wrong.append(f"{where}: {found[0]}")
    assert wrong == []


def test_names_of_commands_and_file_kinds_resolve() -> None:
    homes = [home.rsplit(".", 1) for commands in COMMANDS.values() for home, _ in commands.values()]
    for module, name in homes:
        assert hasattr(importlib.import_module(f"cablewright.apps.cli.{module}"), name), name
    for module, name in _MODELS.values():
        assert hasattr(importlib.import_module(f"cablewright.{module}"), name), name


def _pictured(kind: type[Pictured]) -> Iterator[str]:
    below = kind.__subclasses__()
    if below:
        for each in below:
            yield from _pictured(each)
    else:
        yield kind.__name__


def test_each_result_with_a_picture_has_one_and_no_other_has() -> None:
    for path in sorted(HOME.rglob("*.py")):
        if re.search(r"^class .*\bPictured\b", path.read_text(encoding="utf-8"), re.MULTILINE):
            parts = path.relative_to(HOME).with_suffix("").parts
            importlib.import_module(".".join(["cablewright", *parts]))
    assert set(_pictured(Pictured)) == set(PICTURES)
    for module, name in PICTURES.values():
        assert hasattr(importlib.import_module(f"cablewright.apps.pictures.{module}"), name), name


def test_schemas_of_a_log_are_this_list() -> None:
    assert {each.schema for each in TOPICS} == {
        "cablewright.Barrier",
        "cablewright.BeamLength",
        "cablewright.CameraPose",
        "cablewright.Climate",
        "cablewright.Command",
        "cablewright.Distance",
        "cablewright.Drives",
        "cablewright.Estimate",
        "cablewright.Frame",
        "cablewright.Inputs",
        "cablewright.LineAngles",
        "cablewright.Order",
        "cablewright.Progress",
        "cablewright.Swivels",
        "cablewright.YawAngle",
        "cablewright.Tensions",
        "cablewright.Truth",
        "foxglove.LaserScan",
        "sensor_msgs/Imu",
        "sensor_msgs/JointState",
    }
