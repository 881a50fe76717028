"""Count the files of ``src`` that three numbers lead a reader through: every file of which a function runs.

Run it from the repository root with ``NUMBA_DISABLE_JIT=1``, so that kernels are seen too:
``python tools/call_traces.py``. ``--files`` lists them. Code that runs on import does not count, nor does the
simulated machine.
"""

from __future__ import annotations

import contextlib
import io
import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from types import FrameType
from typing import Any, Final

import cablewright

SOURCE: Final = Path(cablewright.__file__).parent
NOT_ENTERED: Final = ("machine/simulated/", "kernels/plant/", "__main__.py", "apps/style.py")
PART: Final = "G21\nG90\n;LAYER:0\nG1 X0 Y0 Z500 F3000\nG1 X100 Y0 Z500 E1 F1200\n"
JOB: Final = 'schema = 1\nname = "two moves"\ngcode = "part.gcode"\nscale = 1\norigin = [0.0, 0.0, 0.3]\n'


@contextlib.contextmanager
def entered() -> Iterator[set[str]]:
    """Yield the files of ``src`` in which a function is entered while the block runs."""
    found = set[str]()
    home, importing = str(SOURCE) + os.sep, 0

    def look(frame: FrameType, event: str, _argument: Any) -> None:
        nonlocal importing
        code = frame.f_code
        if code.co_name == "<module>":
            importing += {"call": 1, "return": -1}.get(event, 0)
        elif event == "call" and not importing and code.co_filename.startswith(home):
            name = code.co_filename[len(home) :].replace(os.sep, "/")
            if not name.startswith(NOT_ENTERED):
                found.add(name)

    sys.setprofile(look)
    try:
        yield found
    finally:
        sys.setprofile(None)


def modulus() -> set[str]:
    """From Young's modulus in a robot file to the largest error dp_max: ``accuracy paty2021 --at 0,0,1``."""
    from cablewright.apps.cli.main import main

    with contextlib.redirect_stdout(io.StringIO()), entered() as found, contextlib.suppress(SystemExit):
        sys.argv = ["cablewright", "accuracy", "paty2021", "--at", "0,0,1", "--json"]
        main()
    return found


def lidar() -> set[str]:
    """From a lidar's scan to the speeds of the winches: steps of a print by the filter, the machine left out."""
    from cablewright.live.estimators import estimator
    from cablewright.live.prints.loop import Printer
    from cablewright.live.prints.plan import PrintOptions, plan_print, twin_of
    from cablewright.live.prints.simulated_operator import Attendant
    from cablewright.machine.simulated.simulated_machine import SimulatedMachine
    from cablewright.printing.job import Job, Motion
    from cablewright.printing.numeric_path import Helix
    from cablewright.robot import load

    ring = Job(
        name="ring",
        origin=(0.3, -0.5, 0.0),
        helix=Helix(radius=0.4, layers=1, layer_height=0.001, first_height=1.0),
        motion=Motion(print_speed=0.03, travel_speed=0.03, acceleration=0.02),
    )
    made = twin_of(load("merlet2023"), ring, None, PrintOptions("filter", plant="quasi-static", severity="typical"))
    machine = SimulatedMachine(
        made.robot, made.settings, made.path.track.at(0.0).position, seed=3, plant="quasi-static"
    )  # fmt: skip
    printer = Printer(
        plan_print(made),
        machine,
        lambda place, radii: estimator(made.estimator, made.robot, machine.settings, place, (), radii),
        now=machine.time,
    )
    attendant = Attendant(lambda: machine.refill(printer.plan.powder), refill_time=10.0)
    while not printer.step(attendant.orders(printer, machine.time)).command.winch_speeds.any():
        pass
    with entered() as found:
        for _ in range(3):
            printer.step(attendant.orders(printer, machine.time))
    return found


def gcode() -> set[str]:
    """From a line of G-code to the lengths of the winches: ``check`` of two moves on ``merlet2023``, lengths.csv."""
    from cablewright.apps.cli.main import main

    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "part.gcode").write_text(PART)
        (Path(folder) / "job.toml").write_text(JOB)
        with contextlib.redirect_stdout(io.StringIO()), entered() as found, contextlib.suppress(SystemExit):
            sys.argv = ["cablewright", "check", "merlet2023", f"{folder}/job.toml", "--out", f"{folder}/out", "--json"]
            sys.argv += ["--no-interference", "--no-expected-error"]
            main()
    return found


WALKS: Final = {
    "modulus to dp_max": modulus,
    "lidar scan to winch speeds": lidar,
    "G-code line to winch lengths": gcode,
}


def main(arguments: list[str]) -> None:
    """Print the number of files of each walk that *arguments* name by its first word, by default of all."""
    names = [each for each in arguments if not each.startswith("-")]
    for title, walk in WALKS.items():
        if not names or title.split()[0] in names:
            found = walk()
            print(f"{title}: {len(found)} files", flush=True)
            if "--files" in arguments:
                print("  " + "\n  ".join(sorted(found)))


if __name__ == "__main__":
    main(sys.argv[1:])
