"""Merlet and Papegay 2023 beside cablewright: their exhibition's figures and those of prints on the simulated machine.

Each argument is the run folder of a print (none: the powder alone), for one
    cablewright print merlet2023 examples/blind-machines.toml --layers 3 --control paper --out runs/paper
Theirs are what their lidars saw, over 126 h; here both that and what is true are known.
"""

import argparse
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

import cablewright as cw

CM = 100.0
DENSITY, REPOSE = 1500.0, math.radians(22.0)  # kg/m^3, of the powder, and its angle of repose, both theirs
PAPER = {
    "mean_path_error": -0.026e-2,  # m, "mean distance between B and the trajectory"
    "path_error_variance": 0.0774e-4,  # m^2: printed as cm
    "max_path_error": 4.82e-2,  # m
    "mean_speed": 3.0168e-2,  # m/s
    "speed_variance": 0.02667e-4,  # (m/s)^2: printed without a unit
}
ROWS = (
    ("mean error beside the path, cm", "mean_path_error", CM, "8.3f"),
    ("its variance, cm^2", "path_error_variance", CM**2, "8.4f"),
    ("largest, cm", "max_path_error", CM, "8.2f"),
    ("mean speed, cm/s", "mean_speed", CM, "8.4f"),
    ("its variance, (cm/s)^2", "speed_variance", CM**2, "8.5f"),
)


def cell(value: float | None, scale: float, form: str) -> str:
    """A figure, or a dash where it is not known."""
    return f"{'-':>8}" if value is None else format(scale * value, form)


def column(folder: Path) -> dict[str, Any]:
    """The figures of one print. Ends the program where there is none."""
    file = folder / "metrics.json"
    if not file.is_file():
        raise SystemExit(f"{file}: no such file; print first: cablewright print merlet2023 JOB --out {folder}")
    figures: dict[str, Any] = json.loads(file.read_text())
    return figures


def errors(prints: dict[str, dict[str, Any]]) -> None:
    """What the paper's conclusion prints, and the same of each print: true, and as the estimation saw it."""
    print(f"{'':34}{'paper':>8}" + "".join(f"{name[:16]:>18}" for name in prints))
    print(f"{'':34}{'seen':>8}" + f"{'true':>10}{'seen':>8}" * len(prints))
    for title, key, scale, form in ROWS:
        cells = [cell(PAPER[key], scale, form)]
        for each in prints.values():
            cells += ["  " + cell(each[key], scale, form), cell(each[f"estimated_{key}"], scale, form)]
        print(f"{title:34}" + "".join(cells))


def rest(name: str, each: dict[str, Any]) -> None:
    """What was printed in which time, and what the lines and the structure were like."""
    print(f"\n{name}: {each['layers']} layers, {each['distance']:.1f} m of path in {each['duration'] / 60.0:.1f} min")
    shares = ", ".join(f"{line['name']} {100.0 * line['taut']:.0f} %" for line in each["lines"] if line["taut"])
    print(f"  taut: {shares}  (paper: 75, 100, 52 and 30 %)")
    known = [line for line in each["lines"] if line["irregularity"]]
    wear = ", ".join(f"{line['name']} {1e3 * line['irregularity']:.2f} mm" for line in known)
    print(f"  coils irregular by: {wear}  (paper: the least loaded one most)")
    structure = each["structure"]
    if structure and structure["mass"]:
        laid = f"{structure['mass']:.1f} kg, {CM * structure['max_height']:.1f} cm high at most"
        print(f"  powder: {laid}; by the scans {structure['estimated_mass'] or math.nan:.1f} kg")


def ridge(mass: float, length: float) -> None:
    """How high a ridge of *mass* (kg) along *length* (m) is with flanks of 22 degrees, and what theirs holds."""
    section = mass / DENSITY / length  # m^2, of a triangle: height^2 / tan(flank)
    height = math.sqrt(section * math.tan(REPOSE))
    theirs = 0.5 * 0.09 * 0.22 * length * DENSITY
    print(f"\nridge of {mass:.0f} kg along {length:.0f} m at 22 degrees: {CM * height:.1f} cm high, ", end="")
    print(
        f"{CM * 2.0 * height / math.tan(REPOSE):.0f} cm wide; one of 9 cm x 22 cm along all of it holds {theirs:.0f} kg"
    )


def heap(mass: float) -> None:
    """How high *mass* (kg) lies at most, poured along the curve of the exhibition in 14 portions."""
    job = cw.load_job(Path(__file__).parents[1] / "blind-machines.toml")
    samples = job.samples(job.toolpath())
    once = samples.positions[samples.layer == 1]
    length = np.linalg.norm(np.diff(once, axis=0), axis=1)
    powder, field = cw.Powder(), cw.HeightField.flat((-2.2, -4.4), (2.2, 4.4), 0.02)
    for _ in range(14):
        cw.pour(field, once[:-1], once[1:], mass / 14 * length / length.sum(), powder)
    print(f"{mass:.0f} kg along the whole curve: {CM * field.heights.max():.1f} cm high at most  (paper: 18 cm)")


def main() -> None:
    """All of it."""
    options = argparse.ArgumentParser()
    options.add_argument("folders", nargs="*", type=Path, metavar="FOLDER")
    prints = {folder.name: column(folder) for folder in options.parse_args().folders}
    if prints:
        errors(prints)
    for name, each in prints.items():
        rest(name, each)
    ridge(1700.0, 28.0)
    heap(1700.0)


if __name__ == "__main__":
    main()
