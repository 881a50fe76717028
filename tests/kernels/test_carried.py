"""Compiled kernels in a wheel: used before the user's own where the processor can, never stale, and never missed."""

from __future__ import annotations

import importlib.util
import logging
import os
import pickle
import subprocess
import sys
import venv
import zipfile
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from types import ModuleType
from typing import Any

import llvmlite.binding as llvm
import numpy as np
import pytest
from numba.core import config
from numba.core.serialize import dumps

from cablewright.kernels import cache, is_compiled, jit, shipped_kernels
from cablewright.kernels.statics import platform
from kernel_tree import DOUBLE, edit, ended, entries, planted, start

HOST = ("x86_64-unknown-linux-gnu", "znver4", f"{shipped_kernels.FEATURES},+avx512f,-amx-int8")
LEVEL = {"NUMBA_CPU_NAME": shipped_kernels.CPU, "NUMBA_CPU_FEATURES": shipped_kernels.FEATURES}
pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux")
    or bool(shipped_kernels.missing((llvm.get_process_triple(), "", llvm.get_host_cpu_features().flatten()))),
    reason=f"wheels carry kernels for Linux on {shipped_kernels.CPU}",
)
POSE = np.array([0.0, 0.0, 0.0, 2.0, 3.0, 6.0])
ANGLE = 7.0


def fresh() -> Any:
    """A kernel of the package as a new process has it: not compiled yet."""
    return jit(platform.angle_of.py_func)


def answered() -> tuple[float, int]:
    """What a new process finds, and how many kernels it needs not compile."""
    kernel = fresh()
    return kernel(POSE), sum(kernel.stats.cache_hits.values())


@pytest.fixture
def entry(tmp_path: Path, monkeypatch) -> Path:
    """The file of the one kernel that is carried, for the level of this very processor."""
    monkeypatch.setenv(cache.DIRECTORY, str(tmp_path))
    _, name, features = fresh().targetctx.codegen().magic_tuple()
    assert answered() == (ANGLE, 0)
    (tmp_path / "kernels").rename(tmp_path / "compiled")
    for key, value in (("HOME", tmp_path / "compiled"), ("CPU", name), ("FEATURES", features), ("_has_told", False)):
        monkeypatch.setattr(shipped_kernels, key, value)
    (found,) = entries(tmp_path / "compiled")
    return found


def kept(tmp_path: Path) -> list[Path]:
    """What is in the user's folder."""
    return entries(tmp_path / "kernels")


def test_what_is_carried_is_used_and_nothing_is_kept(entry: Path, tmp_path: Path) -> None:
    assert is_compiled(fresh(), POSE)
    assert answered() == (ANGLE, 1)
    assert not kept(tmp_path)


@pytest.mark.parametrize(
    "damage",
    [
        lambda whole: b"",
        lambda whole: whole[:31],
        lambda whole: whole[:-1],
        lambda whole: whole[:3000] + bytes([whole[3000] ^ 16]) + whole[3001:],
        lambda whole: b"\0" * len(whole),
    ],
)
def test_a_damaged_entry_is_compiled_for_the_user(
    entry: Path, tmp_path: Path, caplog, damage: Callable[[bytes], bytes]
) -> None:
    entry.write_bytes(damage(entry.read_bytes()))
    with caplog.at_level(logging.INFO):
        assert [answered(), answered()] == [(ANGLE, 0), (ANGLE, 1)]
    assert len(kept(tmp_path)) == 1
    assert not caplog.messages


def test_an_entry_that_cannot_be_read_is_compiled_for_the_user(entry: Path) -> None:
    entry.unlink()
    entry.mkdir()
    assert [answered(), answered()] == [(ANGLE, 0), (ANGLE, 1)]


def test_an_entry_of_another_stamp_or_signature_is_not_believed(entry: Path) -> None:
    (_, *key), data = pickle.loads(entry.read_bytes()[32:])
    payload = dumps((("another stamp", *key), data))
    entry.write_bytes(sha256(payload).digest() + payload)
    assert answered() == (ANGLE, 0)


@pytest.mark.parametrize("setting", [("CPU_NAME", "generic"), ("CPU_FEATURES", "+sse2")], ids=lambda pair: pair[0])
def test_whoever_names_a_processor_gets_code_for_it(entry: Path, monkeypatch, caplog, setting: tuple[str, str]) -> None:
    monkeypatch.setattr(config, *setting)
    assert answered()[1] == 0
    assert not caplog.messages


def test_a_processor_below_the_level_compiles_and_says_so_once(
    entry: Path, tmp_path: Path, monkeypatch, caplog
) -> None:
    monkeypatch.setattr(shipped_kernels, "FEATURES", f"{shipped_kernels.FEATURES},+sse9,+avx9")
    assert [answered(), answered()] == [(ANGLE, 0), (ANGLE, 1)]  # then from the user's folder, without a word
    (tmp_path / "kernels").rename(tmp_path / "away")
    assert answered() == (ANGLE, 0)
    (said,) = caplog.messages
    assert said.endswith("are for processors with avx9, sse9: they are compiled for this one")


@pytest.mark.parametrize("program", ["numba", "llvmlite", "np"])
def test_what_another_version_compiled_is_not_looked_for(monkeypatch, program: str) -> None:
    monkeypatch.setattr(getattr(cache, program), "__version__", "9.9.9")
    assert cache.stamp() != cache.STAMP


def test_a_wheels_kernels_are_those_of_its_sources(tmp_path: Path) -> None:
    """Compiled for the level, in a small package: found without a folder, and not after an edit."""
    tree = planted(tmp_path)
    assert ended(start(tree, DOUBLE, **LEVEL)) == "2.0 0"
    (tree / "cache" / "kernels").rename(tree / "cablewright" / "kernels" / "compiled")
    (tree / "file").touch()
    assert ended(start(tree, DOUBLE, folder="file")) == "2.0 1"
    edit(tree, 5.0)
    assert ended(start(tree, DOUBLE)) == "10.0 0"


def test_missing_processor_features_are_named() -> None:
    assert shipped_kernels.missing(HOST) == []
    assert shipped_kernels.missing((*HOST[:2], HOST[2].replace("+movbe", "-movbe"))) == ["movbe"]
    assert "avx2" in shipped_kernels.missing((*HOST[:2], ""))


def test_the_features_add_nothing_to_the_level_and_no_sum_is_fused() -> None:
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    module = llvm.parse_assembly("""
        define void @f(ptr %x, ptr %y) {
        entry:
          br label %loop
        loop:
          %i = phi i64 [ 0, %entry ], [ %next, %loop ]
          %at = getelementptr double, ptr %x, i64 %i
          %to = getelementptr double, ptr %y, i64 %i
          %value = load double, ptr %at
          %twice = fmul double %value, %value
          %sum = fadd double %twice, %value
          store double %sum, ptr %to
          %next = add i64 %i, 1
          %more = icmp ult i64 %next, 4096
          br i1 %more, label %loop, label %end
        end:
          ret void
        }
    """)
    target = llvm.Target.from_triple(HOST[0])
    alone = target.create_target_machine(cpu=shipped_kernels.CPU)
    listed = target.create_target_machine(cpu=shipped_kernels.CPU, features=shipped_kernels.FEATURES)
    assert alone.emit_assembly(module) == listed.emit_assembly(module)
    assert "vfmadd" not in listed.emit_assembly(module)  # product and sum are rounded apart, here as for any processor


# --- The wheel itself


def tool() -> ModuleType:
    path = Path(__file__).parents[2] / "tools" / "wheel.py"
    spec = importlib.util.spec_from_file_location("wheel", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_metadata_asks_for_what_the_kernels_were_compiled_by() -> None:
    metadata = "Name: x\nRequires-Dist: numba<0.69,>=0.68\nRequires-Dist: numpy>=2.0\nRequires-Dist: rich\n\nText\n"
    head, _, text = tool()._bound(metadata).partition("\n\n")
    minor = ".".join(np.__version__.split(".")[:2])
    wanted = [line for line in head.splitlines() if line.startswith("Requires-Dist")]
    assert f"Requires-Dist: numpy=={minor}.*" in wanted
    assert f"Requires-Dist: numba=={cache.numba.__version__}" in wanted
    assert f"Requires-Dist: llvmlite=={cache.llvmlite.__version__}" in wanted
    assert len(wanted) == 4
    assert text == "Text\n"


SOLVE = """
import numpy as np
import cablewright as cw
for name in ("merlet2023", "cogiro"):
    robot = cw.load(name)
    held = cw.inverse(robot, np.zeros(robot.n) + [0.2, -0.1, 1.0, 0.0, 0.0, 0.0][: robot.n])
    back = cw.forward(robot, held.lengths)
    print(*(float(x).hex() for x in [*held.lengths, *held.tensions, *back.pose]), cw.certify(back))
"""


@pytest.mark.slow
def test_a_wheel_answers_without_compilation_and_to_the_bit(tmp_path: Path) -> None:
    tool().main(tmp_path / "dist")
    (wheel,) = (tmp_path / "dist").iterdir()
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "installed")
    shown = {}
    for name, path in (("wheel", tmp_path / "installed"), ("here", Path(shipped_kernels.__file__).parents[2])):
        environment = os.environ | {"PYTHONPATH": str(path), cache.DIRECTORY: str(tmp_path / name)}
        command = [sys.executable, "-c", SOLVE]
        shown[name] = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
    assert shown["wheel"] == shown["here"]
    assert not entries(tmp_path / "wheel")
    assert entries(tmp_path / "here")
    venv.create(tmp_path / "venv", with_pip=True)
    pip = [str(tmp_path / "venv" / "bin" / "python"), "-m", "pip", "install", "--no-deps", "--no-index", str(wheel)]
    assert "Successfully installed" in subprocess.run(pip, capture_output=True, text=True, check=True).stdout
