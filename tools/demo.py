"""Check a house on a large printer, print three layers on a simulated machine, and show the results: ``make demo``."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any

COMMAND = Path(sys.executable).with_name("cablewright")
CHECK = ("check", "house-printer", "examples/house.toml")
PRINT = ("print", "merlet2023", "examples/blind-machines.toml", "--layers", "3", "--plant", "quasi-static")


def main() -> int:
    """Run both commands one after the other; return the first exit code that is not 0."""
    code, checked = answer("Can the robot print this house?", CHECK)
    if code:
        return code
    print(textwrap.fill(checked["verdict"], 100))
    error, allowed = (1e3 * checked[key] for key in ("expected_error", "max_expected_error"))
    print(f"  expected error  {error:.3g} mm (allowed: {allowed:.3g} mm)")
    print(f"  duration        {checked['duration'] / 3600:.0f} h")
    print(f"  report          {checked['report']}\n")
    shutil.rmtree("runs/print-merlet2023-blind-machines", ignore_errors=True)
    code, printed = answer("Print three layers of powder on a simulated machine.", PRINT)
    if code:
        return code
    minutes = printed["duration"] / 60
    print(f"The print {printed['status']}: {printed['layers']} layers in {minutes:.0f} min of machine time.")
    print(f"  position error  {1e3 * printed['position_rms']:.2f} mm rms")
    print(f"  report          {printed['report']}\n")
    print("Open the reports in a browser. Next: activate the environment and try a command.\n")
    print("  . .venv/bin/activate\n  cablewright robots\n  cablewright inverse house-printer --at 1,2,1.5")
    return 0


def answer(question: str, arguments: tuple[str, ...]) -> tuple[int, dict[str, Any]]:
    """Run a command; return its exit code and its JSON. Progress goes to the terminal."""
    print(f"{question}\n$ cablewright {' '.join(arguments)}", flush=True)
    run = subprocess.run([COMMAND, *arguments, "--json"], stdout=subprocess.PIPE, text=True, check=False)
    found: dict[str, Any] = json.loads(run.stdout) if run.stdout else {}
    return run.returncode, found


if __name__ == "__main__":
    sys.exit(main())
