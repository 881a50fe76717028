"""What the scripts of the papers' figures share: which figures, where to, quick or not, and the words on each."""

import argparse
import re
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from textwrap import fill

import numpy as np
from matplotlib.figure import Figure

from cablewright.apps import style
from cablewright.apps.pictures.gallery import save
from cablewright.apps.space_axes import add_faces

LETTERS = 124  # of a note in a line of a page of two columns


def words(drawn: Figure, title: str, *notes: str) -> Figure:
    """Write a title over a figure and notes below it: what is reproduced, assumed, tuned or not reproduced."""
    style.headline(drawn, title)
    text = "\n".join(fill(note, LETTERS, subsequent_indent="    ") for note in notes)
    drawn.supxlabel(re.sub(r"-(?=\d)", "\N{MINUS SIGN}", text), x=0.01, ha="left", fontsize=9.0)
    return drawn


def add_map(axes, triangles: np.ndarray, colour: Callable[[np.ndarray], np.ndarray], times: int = 3) -> None:
    """Draw *triangles* (F, 3, 3) in the colours of their places: each is cut in four, *times* over."""
    for _ in range(times):
        a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
        ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        parts = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
        triangles = np.concatenate([np.stack(part, axis=1) for part in parts])
    add_faces(axes, triangles, colour(triangles.mean(axis=1)), zorder=3)


def draw(paper: str, figures: Mapping[int, Callable[[bool], Figure]]) -> None:
    """Draw the figures that the command line names, or all, each to a file with its data beside it."""
    options = argparse.ArgumentParser(description=f"Figures of {paper}, each to a file with its data beside it.")
    options.add_argument("numbers", nargs="*", type=int, metavar="NUMBER", help=f"of {', '.join(map(str, figures))}")
    options.add_argument("--out", type=Path, default=Path(), metavar="FOLDER")
    options.add_argument("--ending", default="pdf", choices=[each[1:] for each in style.FORMATS])
    options.add_argument("--dpi", type=int, default=150, help="dots an inch of a PNG")
    options.add_argument("--quick", action="store_true", help="coarse grids and few runs: to see that it draws")
    given = options.parse_args()
    unknown = [number for number in given.numbers if number not in figures]
    if unknown:
        options.error(f"there is no figure {unknown[0]}; there are {', '.join(map(str, figures))}")
    given.out.mkdir(parents=True, exist_ok=True)
    for number in given.numbers or figures:
        begin, file = time.perf_counter(), given.out / f"{paper}-{number:02}.{given.ending}"
        with style.drawing("two-column"):
            drawn = figures[number](given.quick)
            drawn.set_dpi(given.dpi)
            style.finish(drawn)
            save(drawn, style.picture_file(file))
        print(f"{file}  {time.perf_counter() - begin:.1f} s", flush=True)
