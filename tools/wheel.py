"""A wheel that carries compiled kernels, for Linux on processors of the level x86-64-v3.

    python tools/wheel.py [FOLDER]

The package is built as always, its kernels are compiled by `cablewright warm` from the built package, with nothing else
in sight, and both are packed for exactly this minor version of Python and NumPy and this version of Numba and llvmlite.
"""

from __future__ import annotations

import base64
import hashlib
import os
import platform
import re
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from importlib.metadata import version
from pathlib import Path
from typing import Final

from llvmlite import binding

from cablewright.kernels.shipped_kernels import CPU, FEATURES, missing

ROOT: Final = Path(__file__).resolve().parents[1]
KERNELS: Final = "cablewright/kernels/compiled"
EPOCH: Final = (1980, 1, 1, 0, 0, 0)  # the same inputs give the same times
PYTHON: Final = f"cp{sys.version_info.major}{sys.version_info.minor}"
TAGS: Final = f"{PYTHON}-{PYTHON}-{sysconfig.get_platform().replace('-', '_')}"


def main(target: Path) -> None:
    """Build the wheel in the folder *target*, and print its name."""
    _require_platform()
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        plain = _built(place / "plain")
        package = place / "package"
        with zipfile.ZipFile(plain) as archive:
            archive.extractall(package)
        kernels = _compiled(package, place / "cache")
        files = _files(package) | {f"{KERNELS}/{name}": data for name, data in _files(kernels).items()}
        wheel = _packed(files, target, plain.name)
        _try(wheel, place)
    print(wheel)


def _require_platform() -> None:
    """End where such a wheel cannot be made."""
    interface = sysconfig.get_config_var("SOABI") or ""
    if not re.fullmatch(r"cpython-\d+-x86_64-linux-gnu", interface):
        sys.exit(f"wheel: kernels are carried for CPython on Linux and x86-64 only, and this is {interface}")
    features = binding.get_host_cpu_features().flatten()
    lacking = missing((binding.get_process_triple(), binding.get_host_cpu_name(), features))
    if lacking:
        sys.exit(f"wheel: this processor ({platform.processor()}) is below {CPU}: it has no {', '.join(lacking)}")


def _built(folder: Path) -> Path:
    """The wheel without compiled kernels."""
    command = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    (wheel,) = folder.glob("*.whl")
    return wheel


def _compiled(package: Path, cache: Path) -> Path:
    """The folder of kernels that *package* compiles for the level, from an empty *cache*."""
    _warm(package, cache, {"NUMBA_CPU_NAME": CPU, "NUMBA_CPU_FEATURES": FEATURES})
    kernels = cache / "kernels"
    (stamp,) = kernels.iterdir()
    if not any(stamp.iterdir()):
        sys.exit("wheel: nothing was compiled")
    telling = [each for each in stamp.rglob("*") if each.is_file() and str(package).encode() in each.read_bytes()]
    if telling:
        sys.exit(f"wheel: a place on this machine is in {len(telling)} of the kernels, as in {telling[0].parent.name}")
    return kernels


def _warm(package: Path, cache: Path, settings: dict[str, str]) -> None:
    """Let a *package* that is not installed compile missing kernels into *cache*, apart from all that the user set."""
    own = {key: value for key, value in os.environ.items() if not key.startswith(("NUMBA_", "PYTHON"))}
    command = [sys.executable, "-m", "cablewright", "warm"]  # in its folder, which comes before what is installed
    environment = own | settings | {"CABLEWRIGHT_CACHE_DIR": str(cache)}
    subprocess.run(command, cwd=package, env=environment, check=True, stdout=subprocess.DEVNULL)


def _files(folder: Path) -> dict[str, bytes]:
    """All files of *folder*, but for what Python keeps of sources that it has read."""
    found = (each for each in sorted(folder.rglob("*")) if each.is_file() and each.parent.name != "__pycache__")
    return {each.relative_to(folder).as_posix(): each.read_bytes() for each in found}


def _packed(files: dict[str, bytes], folder: Path, plain: str) -> Path:
    """The wheel of *files*, with a name, tags, requirements and a record of its own."""
    name, number = plain.split("-")[:2]
    about = f"{name}-{number}.dist-info"
    files[f"{about}/METADATA"] = _bound(files[f"{about}/METADATA"].decode()).encode()
    described = files[f"{about}/WHEEL"].decode()
    described = re.sub(r"^Tag: .*$", f"Tag: {TAGS}", described, flags=re.MULTILINE)
    files[f"{about}/WHEEL"] = described.replace("Root-Is-Purelib: true", "Root-Is-Purelib: false").encode()
    record = f"{about}/RECORD"
    del files[record]
    lines = [f"{path},sha256={_digest(data)},{len(data)}" for path, data in files.items()]
    files[record] = "\n".join([*lines, f"{record},,", ""]).encode()
    folder.mkdir(parents=True, exist_ok=True)
    wheel = folder / f"{name}-{number}-{TAGS}.whl"
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in files.items():
            entry = zipfile.ZipInfo(path, EPOCH)
            entry.external_attr, entry.compress_type = 0o100644 << 16, zipfile.ZIP_DEFLATED
            archive.writestr(entry, data)
    return wheel


def _bound(metadata: str) -> str:
    """The *metadata* with the versions that compiled the kernels as requirements."""
    head, blank, text = metadata.partition("\n\n")
    numpy = ".".join(version("numpy").split(".")[:2])
    exact = {"numba": version("numba"), "llvmlite": version("llvmlite"), "numpy": f"{numpy}.*"}
    lines = [line for line in head.split("\n") if not re.match(r"Requires-Dist: (numba|llvmlite|numpy)\b", line)]
    lines += [f"Requires-Dist: {name}=={number}" for name, number in exact.items()]
    return "\n".join(lines) + blank + text


def _digest(data: bytes) -> str:
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


def _try(wheel: Path, place: Path) -> None:
    """End unless everything that `warm` compiles is found in the *wheel*."""
    installed, cache = place / "installed", place / "unused"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(installed)
    _warm(installed, cache, {})
    compiled = [each for each in cache.rglob("*") if each.is_file()]
    if compiled:
        wheel.unlink()
        sys.exit(f"wheel: {len(compiled)} kernels were not found in it, among them {compiled[0].parent.name}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "dist").absolute())
