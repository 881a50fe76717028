"""The recipes of docs/extending.md, done in a copy of the package: the addition works, its files are counted."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import cablewright

ROOT = Path(__file__).parents[2]
EXTENDING = (ROOT / "docs" / "extending.md").read_text("utf-8")


class Copy:
    """A copy of the package to which something is added. ``touched``: its files that are new or changed."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.touched = folder, set[str]()
        home = Path(cablewright.__file__).parent
        shutil.copytree(home, folder / "cablewright", ignore=shutil.ignore_patterns("__pycache__"))

    def add(self, name: str, text: str) -> None:
        file = self.folder / "cablewright" / name
        assert not file.exists()
        file.write_text(text, encoding="utf-8")
        self.touched.add(name)

    def edit(self, name: str, *pairs: tuple[str, str]) -> None:
        """Replace texts, each of which stands there once."""
        file = self.folder / "cablewright" / name
        text = file.read_text(encoding="utf-8")
        for old, new in pairs:
            assert text.count(old) == 1, (name, old, text.count(old))
            text = text.replace(old, new)
        file.write_text(text, encoding="utf-8")
        self.touched.add(name)

    def run(self, *arguments: str, code: int = 0) -> str:
        """What Python prints, and ends with *code*; kernels run as plain Python: none is compiled for a copy."""
        told = {"PYTHONPATH": str(self.folder), "NUMBA_DISABLE_JIT": "1"}
        done = subprocess.run(
            [sys.executable, *arguments], cwd=self.folder, env=os.environ | told, capture_output=True, text=True
        )  # fmt: skip
        assert done.returncode == code, done.stderr[-2000:]
        return done.stdout

    def command(self, *arguments: str) -> Any:
        return json.loads(self.run("-m", "cablewright", *arguments, "--json"))


@pytest.fixture
def copy(tmp_path: Path) -> Copy:
    return Copy(tmp_path)


def files_of(recipe: str) -> int:
    """The number of files that a recipe says it takes: ``**N files.**``."""
    section = EXTENDING.partition(f"\n## {recipe}\n")[2].partition("\n## ")[0]
    found = re.search(r"\*\*(\d+) files\.\*\*", section)
    assert found is not None, recipe
    return int(found[1])


def test_a_format_that_is_read(copy: Copy) -> None:
    copy.add(
        "exchange/points.py",
        '''"""Exit points as a JSON list of coordinates, m: read."""

from __future__ import annotations

import json
from pathlib import Path

from cablewright.exchange.assumed_values import chosen_cable, frame_of
from cablewright.exchange.translation_result import ImportedRobot, Mapped
from cablewright.robot import Robot
from cablewright.foundation.toml_input import read_bytes
from cablewright.foundation.validation import validated

CARRIED = (Mapped("points", "lines.exit_point", "eyelets"),)


def read_points(path: Path, cable: str | None = None) -> ImportedRobot:
    """Return the robot of a file. Raises `InputError`."""
    points = json.loads(read_bytes(path, 1 << 20, "list of points"))["points"]
    lines = [
        {"name": str(k), "exit_point": point, "sheave": {"kind": "eyelet"}, "tension_limits": [1.0, 100.0],
         "cable": {"linear_density": 0.01, "axial_stiffness": 1e5, "breaking_load": 1000.0}}
        for k, point in enumerate(points)
    ]
    table = {"schema": 1, "name": "points", "platform": {"kind": "point", "mass": 1.0},
             "scene": {"frame_min": [-9.0, -9.0, 0.0], "frame_max": [9.0, 9.0, 9.0]}, "lines": lines}
    return ImportedRobot(validated(Robot, table, str(path)), "points", (), ("platform.mass = 1 kg",))
''',
    )
    copy.edit(
        "foundation/choices.py",
        ('ReadFormatName = Literal[\n    "wirex",', 'ReadFormatName = Literal[\n    "points",\n    "wirex",'),
    )
    copy.edit(
        "exchange/formats.py",
        (
            "import caspr, klipper_config, maslow, rrf_config",
            "import caspr, klipper_config, maslow, points, rrf_config",
        ),
        (
            "READ: Final[Mapping[str, ReadFormat]] = MappingProxyType({\n",
            (
                "READ: Final[Mapping[str, ReadFormat]] = MappingProxyType({\n"
                '    "points": ReadFormat("Points", (".points",), 1, points.CARRIED, r"..points",\n'
                "                         lambda paths, o: points.read_points(paths[0], o.cable)),\n"
            ),
        ),
    )
    (copy.folder / "a.points").write_text('{"points": [[-1, -1, 3], [1, -1, 3], [0, 1, 3]]}')
    found = copy.command("import", "a.points", "--out", "a.toml")
    assert found["format"] == "points"
    assert copy.command("inverse", "a.toml", "--at", "0,0,1", "--cable", "rigid")["status"] == "ok"
    assert len(copy.touched) == files_of("A new format that is read") <= 3


def test_a_format_that_is_written(copy: Copy) -> None:
    copy.add(
        "exchange/exit_list.py",
        '''"""Exit points, a line each: written."""

from __future__ import annotations

from cablewright.exchange.translation_result import ExportedFile
from cablewright.robot import Robot


def exit_list(robot: Robot) -> ExportedFile:
    """Return names and exit points of all lines, m."""
    rows = (f"{line.name} {' '.join(map(str, line.exit_point))}" for line in robot.lines)
    return ExportedFile("\\n".join(rows) + "\\n", ("all but exit points",))
''',
    )
    copy.edit(
        "foundation/choices.py",
        ('WrittenFormatName = Literal[\n    "wirex", ', 'WrittenFormatName = Literal[\n    "exit-list", "wirex", '),
    )
    copy.edit(
        "apps/cli/exchange.py",
        (
            '            found, content = wirex(described, schema_version or "0.32"), b""\n',
            (
                '            found, content = wirex(described, schema_version or "0.32"), b""\n'
                '        elif target == "exit-list":\n'
                "            from cablewright.exchange.exit_list import exit_list\n\n"
                '            found, content = exit_list(described), b""\n'
            ),
        ),
    )
    told = copy.command("export", "exit-list", "merlet2023", "--out", "exits.txt")
    assert told["lost"] == ["all but exit points"]
    assert len((copy.folder / "exits.txt").read_text().splitlines()) == 4
    assert len(copy.touched) == files_of("A new format that is written") <= 3


def test_a_bus(copy: Copy) -> None:
    copy.add(
        "machine/drives/tin_cans.py",
        '''"""Drives on a string between tin cans."""

from __future__ import annotations

from cablewright.foundation.errors import EnvironmentFault
from cablewright.machine.drives.statistics import BusStatistics
from cablewright.machine.settings import MachineSettings
from cablewright.robot import Robot


class TinCanDrives:
    """The drives of all winches; no device is at the other end."""

    def __init__(self, robot: Robot, settings: MachineSettings) -> None:
        self.names, self.axes, self.statistics = [line.name for line in robot.lines], (), BusStatistics()
        self.trouble, self.checking = "no device answers", False

    def open(self) -> None:
        """Raise `EnvironmentFault`."""
        raise EnvironmentFault(f"tin cans: {self.trouble} at {', '.join(self.names)}")
''',
    )
    copy.edit(
        "machine/settings.py",
        ('_Kind = Literal["simulated", ', '_Kind = Literal["tin-cans", "simulated", '),
    )  # fmt: skip
    copy.edit(
        "machine/drives/choice.py",
        (
            "from cablewright.machine.settings",
            "from cablewright.machine.drives.tin_cans import TinCanDrives\nfrom cablewright.machine.settings",
        ),
        (
            "    return EthercatDrives(robot",
            (
                '    if settings.kind == "tin-cans":\n        return TinCanDrives(robot, settings)\n'
                "    return EthercatDrives(robot"
            ),
        ),
    )
    machine = (ROOT / "examples" / "virtual-drives.toml").read_text().replace('"canopen"', '"tin-cans"')
    (copy.folder / "m.toml").write_text(machine)
    told = copy.run(
        "-c",
        "from cablewright.foundation.errors import EnvironmentFault\n"
        "from cablewright.machine.drives.choice import drives_of\n"
        "from cablewright.machine.files import load_machine\n"
        "from cablewright.robot import load\n"
        "try:\n    drives_of(load('merlet2023'), load_machine('m.toml')).open()\n"
        "except EnvironmentFault as fault:\n    print(fault)\n",
    )
    assert told.startswith("tin cans: no device answers at ")
    assert len(copy.touched) == files_of("A new bus of drives") <= 4


def test_an_estimator(copy: Copy) -> None:
    """The estimator of Merlet 2023, always called invalid: a log replayed by it is lost."""
    copy.add(
        "estimation/doubter.py",
        '''"""The estimator of Merlet and Papegay 2023, whose results are never valid."""

from __future__ import annotations

from dataclasses import replace

from cablewright.estimation.merlet2023 import observer
from cablewright.estimation.merlet2023.state import ObserverSettings, ObserverState
from cablewright.foundation.signals import Estimate, SensorFrame


def step(settings: ObserverSettings, state: ObserverState, frame: SensorFrame) -> Estimate:
    """Return the estimate after one frame, never valid."""
    return replace(observer.step(settings, state, frame), valid=False)
''',
    )
    copy.edit(
        "foundation/choices.py",
        ('ObserverName = Literal["paper", ', 'ObserverName = Literal["doubter", "paper", '),
        ('ReplayName = Literal["paper", ', 'ReplayName = Literal["doubter", "paper", '),
        ('EstimatorName = Literal["paper", ', 'EstimatorName = Literal["doubter", "paper", '),
    )
    copy.edit(
        "live/estimator_settings.py",
        ("from cablewright.estimation import ", "from cablewright.estimation import doubter, "),
        (
            '    "paper": Observer(',
            '    "doubter": Observer(observer_settings, observer.start, doubter.step),\n    "paper": Observer(',
        ),
    )
    log = str(ROOT / "tests" / "earlier_files" / "print.mcap")
    told = json.loads(copy.run("-m", "cablewright", "replay", log, "--estimator", "doubter", "--json", code=1))
    assert (told["status"], told["estimator"], told["valid_share"]) == ("lost", "doubter", 0.0)
    assert len(copy.touched) == files_of("A new estimator") <= 6


def test_a_control_law(copy: Copy) -> None:
    """The error and the target's velocity alone: the excess of taut lines stays as it is."""
    plain = "        return np.asarray(rates[settings.hosts])"
    copy.edit("foundation/choices.py", ('LawName = Literal["paper", ', 'LawName = Literal["plain", "paper", '))
    copy.edit(
        "control/velocity.py",
        (
            '    if settings.law == "paper":',
            f'    if settings.law == "plain":\n{plain}\n    if settings.law == "paper":',
        ),
    )
    told = copy.run(
        "-c",
        "import numpy as np\n"
        "from cablewright.control import velocity\n"
        "from cablewright.control.path_follower import Target\n"
        "from cablewright.models.statics import Model\n"
        "from cablewright.robot import load\n"
        "from cablewright.foundation.signals import Estimate\n"
        "from cablewright.solvers.taut import taut_at\n"
        "model, place, zeros = Model(load('merlet2023')), np.array([0.4, -1.2, 1.1]), np.zeros(3)\n"
        "lengths = taut_at(model, place).lengths\n"
        "now = Estimate(0.0, place, zeros, zeros, lengths, 0.0 * lengths, lengths < 0.0, np.full(4, 0.05))\n"
        "target = Target(place, np.array([0.0, 0.0, 0.03]), 0.0, 0, 0.03, True, False, False)\n"
        "settings = velocity.VelocitySettings(model, 3.65, law='plain')\n"
        "speeds = velocity.step(settings, velocity.start(settings), now, target, 0.01)\n"
        "moved = lengths + 0.05 * speeds * 0.01 - taut_at(model, place + [0.0, 0.0, 3e-4]).lengths\n"
        "print(bool(speeds.all()), bool(np.abs(moved).max() < 1e-6))\n",
    )
    assert told == "True True\n"
    assert len(copy.touched) == files_of("A new control law") <= 6


def test_a_cable_law(copy: Copy) -> None:
    """Heavy cables whose dead spans do not stretch."""
    copy.edit(
        "models/fidelity.py",
        ('    CATENARY = "catenary"\n', '    CATENARY = "catenary"\n    STIFF_DEAD = "stiff-dead"\n'),
    )
    copy.edit(
        "models/pack.py",
        ("    if law is CableLaw.CATENARY:", "    if law in (CableLaw.CATENARY, CableLaw.STIFF_DEAD):"),
        ("if line.dead_elastic else 0.0", "if line.dead_elastic and law is not CableLaw.STIFF_DEAD else 0.0"),
    )
    at = ("inverse", "house-printer", "--at", "0,0,1.5", "--cable")
    full, stiff = (copy.command(*at, law) for law in ("catenary", "stiff-dead"))
    assert stiff["status"] == full["status"] == "ok"
    assert stiff["tensions"] == pytest.approx(full["tensions"], rel=1e-3)
    assert stiff["lengths"] != pytest.approx(full["lengths"], abs=1e-9)
    assert stiff["lengths"] == pytest.approx(full["lengths"], abs=0.05)
    assert len(copy.touched) == files_of("A new cable law") <= 6


def test_a_workspace_criterion(copy: Copy) -> None:
    copy.edit(
        "foundation/choices.py",
        ('CriterionName = Literal["closed-form", ', 'CriterionName = Literal["low", "closed-form", '),
    )
    copy.edit(
        "analyses/workspace/criterion.py",
        ("    def _margins(self, poses: Array)", LOW + "    def _margins_of_tensions(self, poses: Array)"),
    )  # fmt: skip
    told = copy.run(
        "-c",
        "import cablewright as cw\n"
        "found = cw.count_nodes(cw.load('jung2020'), criterion='low', grid=3)\n"
        "print(found.criterion.name, found.counted, 'of', found.nodes)\n",
    )
    assert told == "low 18 of 27\n"
    assert len(copy.touched) == files_of("A new workspace criterion") <= 2


LOW = '''    def _margins(self, poses: Array) -> Array:
        """Return how far the origin is below 1.5 m."""
        return 1.5 - poses[:, 2] if self.name == "low" else self._margins_of_tensions(poses)

'''


def test_a_sheave_kind(copy: Copy) -> None:
    """A sheave on a rigid arm about a vertical axis: its lever differs from its radius."""
    copy.edit(
        "robot/sheave.py",
        (
            "class UniversalJoint(_TurningSheave):",
            (
                "class ArmSheave(_TurningSheave):\n"
                '    """A sheave on a rigid arm that turns about the vertical through the exit point."""\n\n'
                '    kind: Literal["arm"] = "arm"\n    arm: Positive[Length]\n    upright: ClassVar[bool] = True\n\n\n'
                "class UniversalJoint(_TurningSheave):"
            ),
        ),
        ("from typing import Annotated, Literal", "from typing import Annotated, ClassVar, Literal"),
        ("Eyelet | Swivel | UniversalJoint | Pulley,", "Eyelet | Swivel | ArmSheave | UniversalJoint | Pulley,"),
    )
    copy.edit("robot/file_schema.py", ('"Swivel", "Universal', '"Swivel", "ArmSheave", "Universal'))
    copy.edit(
        "models/fidelity.py",
        ('    SWIVEL = "swivel"\n', '    SWIVEL = "swivel"\n    ARM = "arm"\n'),
    )
    copy.edit(
        "models/pack.py",
        (
            "    if line.winch_exit is not None:\n        away",
            (
                '    if law is SheaveLaw.ARM and sheave.kind == "arm":\n        own.lever = sheave.arm\n'
                "    if line.winch_exit is not None:\n        away"
            ),
        ),
    )
    copy.edit(
        "robot/line.py",
        ("(self, sheave: Swivel | UniversalJoint)", "(self, sheave: Swivel | ArmSheave | UniversalJoint)"),
        ("    UniversalJoint,\n", "    UniversalJoint,\n    ArmSheave,\n"),
    )
    copy.edit(
        "apps/report/provenance.py",
        (
            '    if sheave.kind == "swivel":\n',
            (
                '    if sheave.kind == "arm":\n'
                "        return f\"{over} on a rigid arm of {quantity(sheave.arm, 'm')}\"\n"
                '    if sheave.kind == "swivel":\n'
            ),
        ),
    )
    swivel = copy.run("-m", "cablewright", "robots", "merlet2023")
    assert swivel.count('kind = "swivel"') == 1
    for name, arm in (
        ("s", 'kind = "swivel"'),
        ("same", 'kind = "arm"\narm = 0.0375'),
        ("long", 'kind = "arm"\narm = 0.06'),
    ):
        (copy.folder / f"{name}.toml").write_text(swivel.replace('kind = "swivel"', arm))
    plain, same, far = (copy.command("inverse", f"{name}.toml", "--at", "0,0,1") for name in ("s", "same", "long"))
    assert same["lengths"] == plain["lengths"]
    assert far["status"] == "ok"
    assert far["lengths"] != pytest.approx(plain["lengths"], abs=1e-4)
    assert len(copy.touched) == files_of("A new sheave kind") <= 12
