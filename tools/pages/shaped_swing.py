"""Draw ``docs/images/shaping.png`` and print the tables of ``docs/dynamics.md``: run it without arguments."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import numpy as np

import cablewright as cw
from cablewright.apps import style
from cablewright.foundation.arrays import Array
from cablewright.printing.job import Job
from cablewright.printing.path import Samples
from cablewright.printing.shaping import Shaper
from cablewright.printing.timing import TimeLaw, time_law

IMAGE: Final = Path(__file__).resolve().parent.parent.parent / "docs" / "images" / "shaping.png"
FREQUENCY: Final = 1.7  # Hz, for which the motion of the tables is shaped
WRONG: Final = (0.75, 0.9, 1.0, 1.1, 1.25, 2.0)
STEP: Final = 2e-3  # s

Motion = tuple[Samples, TimeLaw]
CORNER: Final = "G21\nM83\nG0 X0 Y0 Z0 F18000\nG1 X2000 E1\nG1 Y2000 E1\n"
STOP: Final = "G21\nM83\nG0 X0 Y0 Z0 F18000\nG1 X1000 E1\nG4 P3000\nG1 X2000 E1\n"


def job_of(text: str, folder: str) -> Job:
    """A job of a text of G-code at 0.3 m/s and 0.5 m/s^2."""
    file = Path(folder) / "part.gcode"
    file.write_text(text)
    return Job.model_validate({"name": "part", "gcode": str(file)})


def motions(text: str, folder: str) -> list[Motion]:
    """Samples and law of the path, and those of its shaped motion."""
    job = job_of(text, folder)
    path = job.samples(job.toolpath())
    shaper = Shaper(lambda places: np.full(len(places), 1.0 / FREQUENCY), 0.5, 5e-3)
    return [(path, time_law(path, 0.5, 5e-3)), shaper.shaped(path)]


def commanded(samples: Samples, law: TimeLaw) -> tuple[Array, Array]:
    """Times, s, and places (k, 3), m, along straight lines between the samples."""
    times = np.arange(0.0, law.duration, STEP)
    left = law.time + samples.dwell
    knots = np.stack([law.time, np.maximum(left, law.time + 1e-9)], axis=1).ravel()
    return times, np.stack([np.interp(times, knots, np.repeat(each, 2)) for each in samples.positions.T], axis=1)


def swing(samples: Samples, law: TimeLaw, frequency: float) -> tuple[Array, Array, Array]:
    """Times, places, and the amplitude (k,), m, of an undamped mode about them."""
    times, places = commanded(samples, law)
    jumps = np.diff(np.diff(places, axis=0, prepend=places[:1]), axis=0, append=0.0) / STEP
    rate = 2.0 * np.pi * frequency
    waves = np.cumsum(jumps * np.exp(1j * rate * times[:, None]), axis=0) / rate
    return times, places, np.linalg.norm(np.abs(waves), axis=1)


def table(title: str, text: str, window: Callable[[Samples, TimeLaw], tuple[float, float]], folder: str) -> None:
    """Print the residual swing in a *window* of the samples and the law, for frequencies that are wrong."""
    print(title)
    (plain, law), (shaped, slow) = motions(text, folder)
    print("| true frequency / assumed | not shaped, mm | shaped, mm | left |\n| --- | --- | --- | --- |")
    for factor in WRONG:
        found = []
        for samples, each in ((plain, law), (shaped, slow)):
            times, _, sizes = swing(samples, each, factor * FREQUENCY)
            begin, end = window(samples, each)
            found.append(1e3 * sizes[(times > begin) & (times < end)].max())
        print(f"| {factor:g} | {found[0]:.2f} | {found[1]:.2f} | {found[1] / found[0]:.0%} |")
    print(f"duration: {law.duration:.2f} s, shaped {slow.duration:.2f} s\n")


def after_corner(samples: Samples, law: TimeLaw) -> tuple[float, float]:
    """A second at constant speed after the corner, s."""
    turn = int(np.linalg.norm(samples.positions[:, :2] - (2.0, 0.0), axis=1).argmin())
    return float(law.time[turn]) + 1.5, float(law.time[turn]) + 2.5


def in_stop(samples: Samples, law: TimeLaw) -> tuple[float, float]:
    """The planned stop, s."""
    begin = float(law.time[samples.dwell > 0.0][0])
    return begin + 0.1, begin + 2.9


def draw(folder: str) -> None:
    """Draw the corner and what swings after it."""
    drawn = style.figure(8.0, 3.4)
    path, course = drawn.subplots(1, 2)
    names = (("not shaped", style.GREY), ("shaped", style.INK))
    for (name, colour), (samples, law) in zip(names, motions(CORNER, folder), strict=True):
        times, places, sizes = swing(samples, law, FREQUENCY)
        path.plot(1e3 * places[:, 0], 1e3 * places[:, 1], color=colour, label=name)
        turn = float(law.time[int(np.linalg.norm(samples.positions[:, :2] - (2.0, 0.0), axis=1).argmin())])
        course.plot(times - turn, 1e3 * sizes, color=colour, label=name)
    path.set(xlim=(1960, 2010), ylim=(-10, 40), xlabel="x, mm", ylabel="y, mm", aspect="equal")
    course.set(xlim=(-3, 4), xlabel="time after the corner, s", ylabel="amplitude of the swing, mm")
    path.legend(), course.legend()
    IMAGE.write_bytes(style.png(drawn))


def main() -> None:
    """Print the tables, and draw the picture."""
    with TemporaryDirectory() as folder:
        table("A corner of 90 degrees:", CORNER, after_corner, folder)
        table("A planned stop of 3 s:", STOP, in_stop, folder)
        draw(folder)
    print(cw.__name__, "wrote", IMAGE.name)


if __name__ == "__main__":
    main()
