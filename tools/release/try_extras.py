"""The wheel with each extra alone, in an empty environment each: what it brings can be imported, and fits together.

    python tools/release/try_extras.py WHEEL [EXTRA ...]

Without names all extras for users are tried. It ends with 1 where one of them fails; the reason is its last line.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
import venv
from pathlib import Path
from typing import Final

BROUGHT: Final = {
    "camera": "cv2, PIL.Image",
    "cluster": "distributed",
    "design": "cma, pymoo",
    "drives": "can",
    "ethercat": "pysoem",
    "fem": "meshio, skfem",
    "frames": "pandas, xarray",
    "mqtt": "paho.mqtt",
    "notebooks": "jupyterlab, nbclient",
    "ros": "rosbags",
    "ros2": "cyclonedds, rosbags",
    "web": "starlette, uvicorn, websockets",
}
"""What is imported with each extra."""


def main(wheel: Path, extras: list[str]) -> int:
    """Try all, print a line for each, and return 0 if all succeed."""
    failed = 0
    for extra in extras:
        began = time.monotonic()
        reason = tried(wheel, extra)
        failed += bool(reason)
        print(f"{extra:10} {reason or 'ok'} ({time.monotonic() - began:.0f} s)", flush=True)
    return int(failed > 0)


def tried(wheel: Path, extra: str) -> str:
    """Install and import; return the last line of the error, or nothing."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        venv.create(folder / "venv", with_pip=True)
        python = str(folder / "venv" / "bin" / "python")
        pip = [python, "-m", "pip", "--quiet", "--disable-pip-version-check"]
        used = f"import cablewright as cw, {BROUGHT[extra]}; print(cw.load('jung2020'))"
        for command in ([*pip, "install", f"{wheel}[{extra}]"], [*pip, "check"], [python, "-c", used]):
            ended = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
            if ended.returncode:
                return next(
                    line for line in reversed([command[-1], *(ended.stdout + ended.stderr).splitlines()]) if line
                )
    return ""


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    unknown = [each for each in sys.argv[2:] if each not in BROUGHT]
    if unknown:
        sys.exit(f"try: there is no extra {unknown[0]}; there are {', '.join(BROUGHT)}")
    sys.exit(main(Path(sys.argv[1]).absolute(), sys.argv[2:] or list(BROUGHT)))
