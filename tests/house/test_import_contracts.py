"""Each import contract of pyproject.toml fails on an import that it is to forbid: none has lost its modules."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import cablewright

ROOT = Path(__file__).parents[2]
HOME = Path(cablewright.__file__).parent
TABLE = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]
CONTRACTS = [each["name"] for each in TABLE["contracts"]]
FLAWS = "cablewright.machine.simulated.settings"
PLANTED = (  # a contract, the file that breaks it, and what that imports
    ("A folder is a rank of knowledge", "printing/job.py", "cablewright.solvers.hardware_limits"),
    ("So it is within the foundation", "foundation/units.py", "cablewright.foundation.csv_input"),
    ("Wings of the calibration", "calibration/unknowns.py", "cablewright.calibration.poses.problem"),
    ("Only kernels import numba", "solvers/hardware_limits.py", "numba"),
    ("Descriptions of robots import no numerics", "robot/scene.py", "numpy"),
    ("Estimation, control and limits see nothing", "control/guard.py", FLAWS),
    (
        "The filter and the paper's chain",
        "estimation/merlet2023/drum_radius.py",
        "cablewright.estimation.kalman.filter",
    ),
    ("Readers of logs, and reports", "apps/report/page.py", FLAWS),
)


@pytest.fixture(scope="module")
def broken(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """What import-linter says of each broken contract of a copy with all of the imports."""
    folder = tmp_path_factory.mktemp("planted")
    shutil.copytree(HOME, folder / "cablewright", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", folder)
    for _, file, module in PLANTED:
        with (folder / "cablewright" / file).open("a", encoding="utf-8") as text:
            text.write(f"\n\ndef _planted() -> None:\n    import {module}\n")
    command = Path(sys.executable).with_name("lint-imports")
    told = os.environ | {"PYTHONPATH": str(folder), "COLUMNS": "1000"}
    done = subprocess.run([command, "--no-cache"], cwd=folder, env=told, capture_output=True, text=True)
    assert done.returncode == 1, done.stderr
    text = done.stdout.partition("Broken contracts")[2]
    parts = re.split(rf"^({'|'.join(map(re.escape, CONTRACTS))})$", text, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


@pytest.mark.parametrize(("begins", "file", "module"), PLANTED, ids=lambda value: str(value)[:20])
def test_a_planted_import_breaks_its_contract(begins: str, file: str, module: str, broken: dict[str, str]) -> None:
    name = next(each for each in CONTRACTS if each.startswith(begins))
    importer = "cablewright." + file.removesuffix(".py").replace("/", ".")
    assert f"{importer} -> {module}" in re.sub(r"\s+", " ", broken[name])


def test_each_contract_has_a_planted_import() -> None:
    assert len(PLANTED) == len(CONTRACTS)
    assert all(any(name.startswith(each[0]) for each in PLANTED) for name in CONTRACTS)


@pytest.mark.parametrize("contract", TABLE["contracts"], ids=lambda each: each["name"][:20])
def test_modules_of_a_contract_exist(contract: dict[str, object]) -> None:
    """A module that has moved has left its contract."""
    for key in ("source_modules", "forbidden_modules", "modules", "allowed_importers"):
        for name in contract.get(key, []):  # type: ignore[attr-defined]
            if name.startswith("cablewright."):
                path = HOME.parent / Path(*name.split("."))
                assert path.with_suffix(".py").exists() or (path / "__init__.py").exists(), name
