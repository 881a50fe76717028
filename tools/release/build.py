"""What a release consists of, in one folder: packages, notes, citation and checksums.

    python tools/release/build.py [FOLDER]

The version is that of pyproject.toml. CHANGELOG.md must have a section of it with its date, and CITATION.cff the same
version and date. On Linux and processors with AVX2 a wheel with compiled kernels is among the packages.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import sys
import tomllib
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2]
SUMS: Final = "SHA256SUMS"


def main(folder: Path) -> None:
    """Build all in *folder*, which must be empty or not exist, and print the names."""
    if folder.exists() and any(folder.iterdir()):
        sys.exit(f"release: {folder} is not empty: give another folder")
    version = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
    day, notes = section((ROOT / "CHANGELOG.md").read_text("utf-8"), version)
    require_cited((ROOT / "CITATION.cff").read_text("utf-8"), version, day)
    folder.mkdir(parents=True, exist_ok=True)
    build(folder, day)
    (folder / "NOTES.md").write_text(f"# cablewright {version}, {day}\n\n{notes}\n", "utf-8")
    shutil.copy(ROOT / "CITATION.cff", folder)
    names = sorted(path.name for path in folder.iterdir())
    sums = [f"{hashlib.sha256((folder / name).read_bytes()).hexdigest()}  {name}\n" for name in names]
    (folder / SUMS).write_text("".join(sums), "utf-8")
    print(*names, SUMS, sep="\n")


def section(changelog: str, version: str) -> tuple[date, str]:
    """Return the date and the text of a version's section of the changelog. Ends where there is none."""
    found = re.search(rf"^## {re.escape(version)} \((\d{{4}}-\d\d-\d\d)\)\n(.*?)(?=^## |\Z)", changelog, re.M | re.S)
    if found is None:
        sys.exit(
            f"release: CHANGELOG.md has no section '## {version} (YYYY-MM-DD)': name Unreleased so, or set the version"
        )
    return date.fromisoformat(found[1]), found[2].strip()


def require_cited(citation: str, version: str, day: date) -> None:
    """End unless the citation has the version and the day."""
    for key, value in (("version", version), ("date-released", day.isoformat())):
        if re.search(rf"^{key}: {re.escape(value)}$", citation, re.M) is None:
            sys.exit(f"release: CITATION.cff: {key} must be {value}, as in CHANGELOG.md and pyproject.toml")


def build(folder: Path, day: date) -> None:
    """Build the sources' archive, the wheel, and where the platform has them the wheel with kernels."""
    moment = datetime(day.year, day.month, day.day, tzinfo=UTC)
    own = os.environ | {"SOURCE_DATE_EPOCH": str(int(moment.timestamp()))}  # the same sources, the same bytes
    for target in ("sdist", "wheel"):
        command = [sys.executable, "-m", "hatchling", "build", "--target", target, "--directory", str(folder)]
        subprocess.run(command, cwd=ROOT, check=True, env=own, stdout=subprocess.DEVNULL)
    if sys.platform == "linux":
        command = [sys.executable, str(ROOT / "tools" / "wheel.py"), str(folder)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "dist/release").absolute())
